//! A potential as cubic pieces for the kernels: one cache line a piece, pair functions over r^2 or r, embedding over density.
use crate::potential::{Jet, Potential, Tabulated};

/// Pieces of a formula's pair functions, and of its embedding function.
const PIECES: usize = 4000;

/// Coefficients of both pair functions on one piece, ascending powers: phi or r phi, then f. One cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Line(pub [f64; 8]);

/// What the pieces of the pair functions are equally spaced over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// r^2, for formulas: phi(r^2) and f(r^2) need neither root nor division. They are Hermite cubics of values and slopes.
    Square,
    /// r, for files: r phi(r) and f(r) as [`crate::potential::spline::Spline`] means them.
    Distance,
}

/// A potential in tables.
///
/// Pair line m covers `x = start + (m + t)/scale`, `0 <= t < 1`, x being r^2 or r; the last lines are zero, so anything
/// that is taken to [`Tables::beyond`] acts as nothing at all.
#[derive(Clone, Debug)]
pub struct Tables {
    /// What was tabled.
    pub potential: Potential,
    /// Cut-off distance squared [angstrom2].
    pub cutoff2: f64,
    /// Square of the nearest distance [angstrom2].
    pub nearest2: f64,
    /// What lines are spaced over.
    pub over: Over,
    /// First r^2 or r of the table [angstrom2 or angstrom].
    pub start: f64,
    /// Lines per angstrom2 or angstrom.
    pub scale: f64,
    /// An r^2 that is on a line of zeros [angstrom2].
    pub beyond: f64,
    pub(crate) pair: Vec<Line>,
    /// Embedding lines per unit of density.
    embedding_scale: f64,
    /// Ascending powers of the distance from the line's start, in lines.
    embedding: Vec<[f64; 4]>,
}

/// Cubic on [0, 1] with the values and slopes (in intervals) of `a` and `b` at its ends.
fn hermite(a: Jet, b: Jet, interval: f64) -> [f64; 4] {
    let (from, to, d, e) = (a.value, b.value, a.slope * interval, b.slope * interval);
    [from, d, 3.0 * (to - from) - 2.0 * d - e, d + e - 2.0 * (to - from)]
}

/// A function of r as one of r^2.
fn by_square(jet: Jet, r: f64) -> Jet {
    Jet { value: jet.value, slope: jet.slope / (2.0 * r) }
}

fn line(p: [f64; 4], f: [f64; 4]) -> Line {
    Line([p[0], p[1], p[2], p[3], f[0], f[1], f[2], f[3]])
}

impl Tables {
    /// Tables of `potential`.
    pub fn new(potential: Potential) -> Tables {
        match &potential {
            Potential::Tabulated(file) => Tables::of_file(potential.clone(), file),
            Potential::Mishin2001 | Potential::Zhou2004(_) => Tables::of_formula(potential),
        }
    }

    fn of_formula(potential: Potential) -> Tables {
        let (nearest2, cutoff2) = (potential.nearest() * potential.nearest(), potential.cutoff() * potential.cutoff());
        let interval = (cutoff2 - nearest2) / PIECES as f64;
        let knots: Vec<(Jet, Jet)> = (0..PIECES)
            .map(|k| {
                let r = (nearest2 + interval * k as f64).sqrt();
                (by_square(potential.pair(r), r), by_square(potential.density(r), r))
            })
            .chain([(Jet::default(), Jet::default())])
            .collect();
        let mut pair: Vec<Line> = knots
            .windows(2)
            .map(|k| line(hermite(k[0].0, k[1].0, interval), hermite(k[0].1, k[1].1, interval)))
            .collect();
        pair.extend([Line::default(); 3]);
        let width = potential.densest() / PIECES as f64;
        let embedding = (0..PIECES)
            .map(|k| {
                let at = |k: usize| potential.embedding(width * k as f64);
                hermite(at(k), at(k + 1), width)
            })
            .collect();
        Tables {
            potential,
            cutoff2,
            nearest2,
            over: Over::Square,
            start: nearest2,
            scale: 1.0 / interval,
            beyond: cutoff2 + 1.5 * interval,
            pair,
            embedding_scale: 1.0 / width,
            embedding,
        }
    }

    fn of_file(potential: Potential, file: &Tabulated) -> Tables {
        let step = file.pair.step;
        let used = (file.cutoff / step).ceil() as usize;
        let pieces = file.pair.pieces.iter().zip(&file.density.pieces).take(used);
        let mut pair: Vec<Line> = pieces.map(|(p, f)| line(*p, *f)).collect();
        pair.extend([Line::default(); 3]);
        let beyond = (used as f64 + 1.5) * step;
        Tables {
            cutoff2: file.cutoff * file.cutoff,
            nearest2: file.nearest * file.nearest,
            over: Over::Distance,
            start: 0.0,
            scale: 1.0 / step,
            beyond: beyond * beyond,
            pair,
            embedding_scale: 1.0 / file.embedding.step,
            embedding: file.embedding.pieces.clone(),
            potential,
        }
    }

    /// Embedding energy [eV] and its derivative by density; `None` off the table, or where `density` is NaN.
    #[inline(always)]
    pub fn embedding(&self, density: f64) -> Option<Jet> {
        let u = density * self.embedding_scale;
        if u.is_nan() || u < 0.0 {
            return None;
        }
        let line = u as usize;
        let c = self.embedding.get(line)?;
        let t = u - line as f64;
        let slope = ((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]) * self.embedding_scale;
        Some(Jet { value: ((c[3] * t + c[2]) * t + c[1]) * t + c[0], slope })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hermite's error is h^4/384 times the fourth derivative by r^2: with h = 7e-3 angstrom2 and derivatives of order
    /// 10 eV/angstrom^8 where atoms meet (r > 1.8 angstrom), below 1e-9 eV; slopes are worse by about 1/h.
    #[test]
    fn tables_follow_the_formulas() {
        let potential = Potential::Mishin2001;
        let tables = Tables::new(potential.clone());
        for k in 0..2000 {
            let r = 1.8 + 3.7 * k as f64 / 1999.0;
            let u = (r * r - tables.start) * tables.scale;
            let (c, t) = (tables.pair[u as usize].0, u.fract());
            for (c, exact) in [(&c[..4], potential.pair(r)), (&c[4..], potential.density(r))] {
                let value = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
                let slope = ((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]) * tables.scale * 2.0 * r;
                assert!((value - exact.value).abs() < 1e-9, "value at {r}: {value} {exact:?}");
                assert!((slope - exact.slope).abs() < 3e-7, "slope at {r}: {slope} {exact:?}");
            }
        }
        for k in 0..2000 {
            let density = 9.99 * k as f64 / 1999.0;
            let (table, exact) = (tables.embedding(density).unwrap(), potential.embedding(density));
            assert!((table.value - exact.value).abs() < 1e-9 && (table.slope - exact.slope).abs() < 1e-6, "{density}");
        }
    }

    #[test]
    fn there_is_nothing_off_the_table() {
        let tables = Tables::new(Potential::Mishin2001);
        assert!(tables.embedding(tables.potential.densest()).is_none() && tables.embedding(f64::NAN).is_none());
        assert!(tables.embedding(-1e-9).is_none());
        assert_eq!(tables.pair[((tables.beyond - tables.start) * tables.scale) as usize].0, [0.0; 8]);
    }
}
