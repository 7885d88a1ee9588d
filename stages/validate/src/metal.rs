//! Whether what is held against each other is of one metal, by its density.

/// Densities this near are one metal's: potentials miss that of their metal by 2 %, aluminium's of Zhou et al. (2004) by 5.2 % at 300 K,
/// alloys by 3 %; copper and aluminium, and most metals, differ by more.
const NEAR: f64 = 0.08;

/// What a reader must know of data that do not say their density.
pub(crate) const UNCHECKED: &str = "The data do not say their density (a line `# rho0: 8.93 g/cm3`): that they are of the same metal is \
                                    taken on trust.";

/// Refuses `other` of density `of_other` beside an equation of state of reference density `of_eos` [kg/m3].
///
/// # Errors
/// What is held against what, with both densities.
pub(crate) fn check(of_eos: f64, other: &str, of_other: f64) -> Result<(), String> {
    if (of_eos / of_other - 1.0).abs() <= NEAR {
        return Ok(());
    }
    Err(format!(
        "the equation of state is of a metal of {:.3} g/cm3, but {other} of one of {:.3} g/cm3: they are not of one metal",
        of_eos / 1e3,
        of_other / 1e3
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Copper (8.93), its potentials (8.70 to 8.86), nickel (8.91, which density can't tell from copper), iron (7.87), aluminium.
    #[test]
    fn metals_differ() {
        assert!([8930.0, 8700.0, 8860.0, 8910.0].iter().all(|d| check(8945.0, "states are", *d).is_ok()));
        assert!([7870.0, 2700.0, 10490.0].iter().all(|d| check(8945.0, "states are", *d).is_err()));
        assert!(check(2785.0, "", 2700.0).is_ok());
    }
}
