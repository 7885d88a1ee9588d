//! Which metal it is, for files that name elements.

/// Symbols and standard atomic weights of metals and of what potentials are made for beside them [g/mol] (IUPAC 2021, to three
/// decimals).
const WEIGHTS: [(&str, f64); 31] = [
    ("Li", 6.94),
    ("Na", 22.990),
    ("Mg", 24.305),
    ("Al", 26.982),
    ("Si", 28.085),
    ("Ar", 39.95),
    ("K", 39.098),
    ("Ca", 40.078),
    ("Ti", 47.867),
    ("V", 50.942),
    ("Cr", 51.996),
    ("Mn", 54.938),
    ("Fe", 55.845),
    ("Co", 58.933),
    ("Ni", 58.693),
    ("Cu", 63.546),
    ("Zn", 65.38),
    ("Zr", 91.224),
    ("Nb", 92.906),
    ("Mo", 95.95),
    ("Rh", 102.906),
    ("Pd", 106.42),
    ("Ag", 107.868),
    ("Ta", 180.948),
    ("W", 183.84),
    ("Ir", 192.217),
    ("Pt", 195.084),
    ("Au", 196.967),
    ("Pb", 207.2),
    ("Th", 232.038),
    ("U", 238.029),
];

/// The symbol of the metal of `molar_mass` [g/mol]; `X` where none is within 0.1 g/mol, as potentials' files round.
pub fn symbol(molar_mass: f64) -> &'static str {
    let off = |weight: f64| (weight - molar_mass).abs();
    let nearest = WEIGHTS.iter().min_by(|a, b| off(a.1).total_cmp(&off(b.1))).expect("the list is not empty");
    if off(nearest.1) < 0.1 { nearest.0 } else { "X" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_have_their_symbols() {
        let masses = [(63.55, "Cu"), (26.98, "Al"), (58.69, "Ni"), (58.93, "Co"), (195.08, "Pt"), (12.0, "X")];
        for (mass, expected) in masses {
            assert_eq!(symbol(mass), expected);
        }
    }
}
