//! Published and computed side by side, and what comes of it.
use crate::measured::{Column, QUANTITIES, take};
use crate::published::{Published, Stated};
use crate::why;
use serde::{Deserialize, Serialize};

/// A computed quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Its value.
    pub value: f64,
    /// Its standard error; 0 where none is known.
    pub error: f64,
}
impl Found {
    /// A value without an error.
    pub fn of(value: f64) -> Found {
        Found { value, error: 0.0 }
    }
}

/// What comes of one comparison.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reproduced {
    /// Within what counts as equal, or within two standard errors; or on the side that was claimed.
    Yes,
    /// Within three times that.
    Nearly,
    /// Neither.
    No,
    /// Nothing published as a number.
    Unsaid,
    /// Nothing computed.
    Missing,
}
impl Reproduced {
    /// In a word or two.
    pub fn describe(self) -> &'static str {
        match self {
            Reproduced::Yes => "reproduced",
            Reproduced::Nearly => "near",
            Reproduced::No => "differs",
            Reproduced::Unsaid => "no number published",
            Reproduced::Missing => "not computed",
        }
    }
}

/// One quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Where in the paper.
    pub result: String,
    /// What it is.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// As published: `"0.398"`, `"< 10"`, or empty.
    pub published: String,
    /// Where it was published, and how far that can be trusted.
    pub source: String,
    /// By the paper's choices.
    pub paper: Option<Found>,
    /// By the best known.
    pub best: Option<Found>,
    /// By the paper's choices, and by the best known.
    pub verdicts: [Reproduced; 2],
    /// What makes the difference; may be empty.
    pub why: String,
}

/// Every published quantity beside the computed ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// In the order published.
    pub rows: Vec<Row>,
}

/// Compares `published` with two columns of results.
///
/// # Errors
/// The first quantity that nothing is known of, with those that are.
pub fn judge(published: &[Published], columns: &[Column<'_>; 2]) -> Result<Verdict, String> {
    let row = |p: &Published| {
        if !QUANTITIES.iter().any(|(id, _)| *id == p.id) {
            let known: Vec<&str> = QUANTITIES.iter().map(|q| q.0).collect();
            return Err(format!("`published` names the quantity `{}`, which is none of {}", p.id, known.join(", ")));
        }
        let found = [0, 1].map(|k| take(&p.id, &columns[k]));
        Ok(Row {
            result: p.result.clone(),
            quantity: p.quantity.clone(),
            unit: p.unit.clone(),
            published: match p.stated {
                Stated::Near(x, _) => format!("{x}"),
                Stated::Below(x) => format!("< {x}"),
                Stated::Above(x) => format!("> {x}"),
                Stated::Nothing => String::new(),
            },
            source: p.source.clone(),
            paper: found[0],
            best: found[1],
            verdicts: found.map(|f| compare(p.stated, f)),
            why: why::why(&p.id, columns),
        })
    };
    Ok(Verdict { rows: published.iter().map(row).collect::<Result<_, String>>()? })
}

fn compare(stated: Stated, found: Option<Found>) -> Reproduced {
    let Some(Found { value, error }) = found else { return Reproduced::Missing };
    let side = |holds: bool| if holds { Reproduced::Yes } else { Reproduced::No };
    match stated {
        Stated::Nothing => Reproduced::Unsaid,
        Stated::Below(x) => side(value < x),
        Stated::Above(x) => side(value > x),
        Stated::Near(x, within) => {
            let (off, allowed) = ((value - x).abs(), (within * x.abs()).max(2.0 * error));
            match off {
                off if off <= allowed => Reproduced::Yes,
                off if off <= 3.0 * within * x.abs() => Reproduced::Nearly,
                _ => Reproduced::No,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_by_tolerance_error_and_side() {
        let near = |value, error| compare(Stated::Near(2.0, 0.05), Some(Found { value, error }));
        assert_eq!(
            [near(2.09, 0.0), near(2.2, 0.0), near(2.4, 0.0)],
            [Reproduced::Yes, Reproduced::Nearly, Reproduced::No]
        );
        assert_eq!(near(2.4, 0.21), Reproduced::Yes, "two standard errors");
        assert_eq!(compare(Stated::Below(10.0), Some(Found::of(9.0))), Reproduced::Yes);
        assert_eq!(compare(Stated::Above(6.0), Some(Found::of(5.0))), Reproduced::No);
        assert_eq!(compare(Stated::Nothing, Some(Found::of(5.0))), Reproduced::Unsaid);
        assert_eq!(compare(Stated::Near(1.0, 0.1), None), Reproduced::Missing);
    }

    /// The shipped file names known quantities only.
    #[test]
    fn the_shipped_results_are_known() {
        let text = include_str!("../../../pipelines/data/paper_liu2013_results.csv");
        let published = crate::published::read(text).unwrap();
        let verdict = judge(&published, &Default::default()).unwrap();
        assert!(verdict.rows.len() > 25);
        assert!(verdict.rows.iter().all(|r| r.verdicts == [Reproduced::Missing; 2]));
        let wrong = text.replace(",gamma_limit,", ",gama,");
        let why = judge(&crate::published::read(&wrong).unwrap(), &Default::default()).unwrap_err();
        assert!(why.contains("`gama`") && why.contains("gamma_limit"), "{why}");
    }
}
