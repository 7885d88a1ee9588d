//! Melting from crystal and melt in one cell: the temperature, what each phase has there, and what is said where one dies.
use hvi_kit::units::{Pressure, Temperature, Time};
use hvi_kit::{Artifact, Ctx, Stage};
use hvi_md::coexistence::{Coexistence, Params, run};
use hvi_md::lanes::Isa;
use hvi_md::potential::BuiltIn;
use hvi_md::{Named, TwoPhases};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// 1200 atoms, which is few: half a cell of each phase is 20 angstrom long.
fn params(pressure: f64, guess: Option<f64>) -> Params {
    Params {
        potential: Named::BuiltIn(BuiltIn::Mishin2001),
        pressure: Pressure::new(pressure),
        guess: guess.map(Temperature::new),
        across: 5,
        along: 12,
        time_step: Time::new(3e-15),
        settling: Time::new(8e-12),
        target_error: Temperature::new(8.0),
        shortest: Time::new(30e-12),
        longest: Time::new(80e-12),
        alone: Time::new(4e-12),
        seed: 1,
    }
}

fn found(params: &Params) -> Coexistence {
    run(params, &BTreeMap::new(), Isa::best(), &Ctx::quiet()).unwrap()
}

/// At zero pressure, from a start that is a fifth too cold.
static FREE: LazyLock<Coexistence> = LazyLock::new(|| found(&params(0.0, Some(1050.0))));

/// 1327 K is what is published for this potential (Y. Mishin et al. (2001), from coexistence). Copper itself: entropy of
/// melting 9.8 J/mol/K and a slope of 42 to 45 K/GPa at 1358 K (Brand et al. 2006). Potential and copper may differ by a fifth.
#[test]
fn copper_melts_where_its_potential_is_known_to() {
    let found = &*FREE;
    let (slope, error) = found.slope();
    let entropy = found.entropy() * found.molar_mass;
    println!(
        "T_m {:.0} +- {:.0} K, entropy {entropy:.2} J/mol/K, slope {:.1} +- {:.1} K/GPa, solid {:.3}, liquid {:.3} V0",
        found.temperature,
        found.temperature_error,
        slope * 1e9,
        error * 1e9,
        found.solid.volume / found.lattice_volume,
        found.liquid.volume / found.lattice_volume
    );
    assert!((found.temperature - 1327.0).abs() < 30.0, "{} +- {}", found.temperature, found.temperature_error);
    assert!((7.8..11.8).contains(&entropy) && (35e-9..53e-9).contains(&slope), "{entropy} {slope:e}");
    assert!(found.liquid.volume > 1.02 * found.solid.volume && found.solid.volume > 1.05 * found.lattice_volume);
    assert!(found.profile.iter().any(|o| *o > 0.45) && found.profile.iter().any(|o| *o < 0.15), "{:?}", found.profile);
    assert_eq!(Coexistence::decode(&found.encode()).unwrap(), *found);
}

/// A start that is far too cold leaves crystal alone; the stage begins again, warmer, and tells of it.
#[test]
fn a_start_that_one_phase_does_not_survive_is_told() {
    let first = FREE.attempts.first().expect("the first start was too cold");
    assert!(first.start == 1050.0 && first.solid > 0.9 && first.end < FREE.temperature + 30.0, "{first:?}");
}

/// The melting curve by its own slope: from T_m at zero pressure to that at 10 GPa, found from Lindemann's guess, along the
/// mean of both slopes (whose curve lies 5 K below), within three standard errors.
#[test]
fn slope_is_that_of_clausius_and_clapeyron() {
    let high = found(&params(10e9, None));
    let (low, high_slope) = (FREE.slope(), high.slope());
    let (rise, foretold) = (high.temperature - FREE.temperature, 0.5 * (low.0 + high_slope.0) * 10e9);
    let error = FREE.temperature_error.hypot(high.temperature_error);
    let own = 0.5 * low.1.hypot(high_slope.1) * 10e9;
    println!(
        "T_m rises by {rise:.0} +- {error:.0} K over 10 GPa, by {foretold:.0} +- {own:.0} K after Clausius and Clapeyron"
    );
    assert!((rise - foretold).abs() < 3.0 * error.hypot(own), "{rise} {foretold} {error} {own}");
}

#[test]
fn parameters_have_ranges() {
    let why = |p: Params| TwoPhases::check(&p).unwrap_err();
    let fine = params(0.0, Some(1300.0));
    assert!(TwoPhases::check(&fine).is_ok());
    assert!(why(Params { across: 3, ..fine.clone() }).why.contains("4 cells across"));
    assert!(why(Params { along: 8, across: 4, pressure: Pressure::new(1e12), ..fine.clone() }).why.contains("across"));
    assert_eq!(why(Params { guess: Some(Temperature::new(-5.0)), ..fine.clone() }).key, "guess");
    assert_eq!(why(Params { longest: Time::new(1e-12), ..fine }).key, "longest");
}
