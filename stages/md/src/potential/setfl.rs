//! A potential as a setfl file, for other programs.
use super::{Potential, Tabulated};
use std::fmt::Write;

/// Knots of a formula's tables.
const KNOTS: usize = 10_001;

/// `potential` in setfl format, its element named `name`: a file's own knots, or a formula on 10001 of them. Read back, it is
/// the same curve as a file's, to the last bit, and a formula's to about 1e-9 eV.
pub fn setfl(potential: &Potential, name: &str) -> String {
    let (columns, steps) = match potential {
        Potential::Tabulated(file) => of_file(file),
        Potential::Mishin2001 | Potential::Zhou2004(_) => of_formula(potential),
    };
    let [embedding, density, pair] = columns;
    let mut text = format!("made by hvi-flow\n\n\n1 {name}\n");
    let (counts, cutoff) = ([embedding.len(), density.len()], potential.cutoff());
    let _ = writeln!(text, "{} {:e} {} {:e} {cutoff:e}", counts[0], steps[0], counts[1], steps[1]);
    let _ = writeln!(text, "1 {:e} {:e} fcc", potential.molar_mass(), potential.lattice_constant());
    for value in [embedding, density, pair].iter().flatten() {
        let _ = writeln!(text, "{value:e}");
    }
    text
}

/// F, f and r phi on their knots, with the steps of density and distance.
type Columns = ([Vec<f64>; 3], [f64; 2]);

fn of_file(file: &Tabulated) -> Columns {
    ([&file.embedding, &file.density, &file.pair].map(|s| s.values()), [file.embedding.step, file.density.step])
}

fn of_formula(potential: &Potential) -> Columns {
    let last = (KNOTS - 1) as f64;
    let (by_density, by_distance) = (potential.densest() / last, potential.cutoff() / last);
    let at = |step: f64, f: &dyn Fn(f64) -> f64| (0..KNOTS).map(|k| f(step * k as f64)).collect::<Vec<f64>>();
    // formulas say nothing of nearer pairs
    let away = |r: f64| r.max(potential.nearest());
    let columns = [
        at(by_density, &|rho| potential.embedding(rho).value),
        at(by_distance, &|r| potential.density(away(r)).value),
        at(by_distance, &|r| away(r) * potential.pair(away(r)).value),
    ];
    (columns, [by_density, by_distance])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::Format;
    use std::sync::Arc;

    /// Written and read, a formula is what it was: 1e-8 eV is h^4/24 with h = 5e-4 angstrom and derivatives below 1e6; the
    /// second time it is a file's, and not a bit changes.
    #[test]
    fn what_is_written_is_read() {
        let formula = Potential::Mishin2001;
        let first = setfl(&formula, "Cu");
        let file = Tabulated::read(&first, Format::Setfl, None).unwrap();
        for k in 0..1000 {
            let r = 1.8 + 3.7 * f64::from(k) / 999.0;
            assert!((file.pair(r).value - formula.pair(r).value).abs() < 1e-8, "{r}");
            assert!((file.density(r).value - formula.density(r).value).abs() < 1e-8, "{r}");
        }
        let second = setfl(&Potential::Tabulated(Arc::new(file)), "Cu");
        assert!(first == second);
    }
}
