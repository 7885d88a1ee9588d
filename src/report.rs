//! The report page (types first: the integrator's `outputs.rs` fills them; note the extra field `swept`).
use hvi_kit::view::{Scalar, View};
/// A study.
pub struct Study { /// Name
    pub name: String, /// Question
    pub question: String, /// Steps
    pub steps: Vec<Step>, /// Seconds
    pub seconds: f64, /// Command
    pub command: String }
/// A step.
pub struct Step { /// Name
    pub name: String, /// Stage
    pub stage: String, /// Summary
    pub summary: String, /// Needs
    pub needs: Vec<String>, /// Points
    pub points: Vec<Point> }
/// A point.
pub struct Point { /// Label
    pub label: String, /// State
    pub state: State, /// Seconds
    pub seconds: f64, /// Key
    pub key: String, /// Params
    pub params: Vec<(String, String)>, /// Swept keys and values as written
    pub swept: Vec<(String, String)>, /// Scalars
    pub scalars: Vec<Scalar>, /// Views
    pub views: Vec<View> }
/// State.
#[expect(missing_docs)]
pub enum State { Hit, Ran, Failed(String), Skipped(String), Cancelled }
/// Renders.
pub fn render(_study: &Study) -> String { String::new() }
