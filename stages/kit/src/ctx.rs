//! What a running stage may know of the world outside.
use std::sync::atomic::{AtomicBool, Ordering};

/// Set once, by Ctrl-C; polled by stages.
#[derive(Default)]
pub struct Cancel(AtomicBool);
impl Cancel {
    /// Asks every running stage to stop at its next tick.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
    /// Whether a stop was asked for.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The stage was asked to stop.
#[derive(Debug, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Listens to how far a stage has come.
pub trait Progress: Sync {
    /// `done` of `of` parts of the work are done (any unit, `of > 0`); `doing` says what comes now.
    fn advance(&self, done: f64, of: f64, doing: &str);
}
impl Progress for () {
    fn advance(&self, _: f64, _: f64, _: &str) {}
}

/// No clock, no file system, no environment, no global random numbers: seeds are parameters.
pub struct Ctx<'a> {
    /// Where progress goes.
    pub progress: &'a dyn Progress,
    /// Whether to stop.
    pub cancel: &'a Cancel,
}

static NEVER: Cancel = Cancel(AtomicBool::new(false));

impl Ctx<'static> {
    /// No listener, never cancelled: for tests and one-off calls.
    pub fn quiet() -> Ctx<'static> {
        Ctx { progress: &(), cancel: &NEVER }
    }
}

impl Ctx<'_> {
    /// Call once per step: reports progress, and stops the stage when asked to.
    ///
    /// # Errors
    /// [`Cancelled`], to be passed on.
    pub fn tick(&self, done: f64, of: f64, doing: &str) -> Result<(), Cancelled> {
        if self.cancel.is_set() {
            return Err(Cancelled);
        }
        self.progress.advance(done, of, doing);
        Ok(())
    }
}
