//! Melting from crystal and melt in one cell: the temperature, what each phase has there, and what is said where one dies.
use hvi_kit::units::{Pressure, Temperature, Time};
use hvi_kit::{Artifact, Cancel, Ctx, Host, Stage, StageError};
use hvi_md::coexistence::{Coexistence, Params, run};
use hvi_md::lanes::Isa;
use hvi_md::potential::BuiltIn;
use hvi_md::{Named, TwoPhases};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{LazyLock, Mutex};

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

/// Other first velocities: the same temperature, within three of its standard errors.
#[test]
fn another_seed_finds_the_same() {
    let other = found(&Params { seed: 2, ..params(0.0, Some(1300.0)) });
    let error = FREE.temperature_error.hypot(other.temperature_error);
    let off = other.temperature - FREE.temperature;
    println!("T_m {:.0} +- {:.0} K from another seed", other.temperature, other.temperature_error);
    assert!(off.abs() < 3.0 * error, "{off} K, {error} K");
}

/// Stopped twice with both phases together, and while the melt is alone; gone on with: the bits of a straight run.
#[test]
fn resumed_runs_have_the_bits_of_straight_ones() {
    let brief = Params {
        settling: Time::new(1e-12),
        shortest: Time::new(5e-12),
        longest: Time::new(5e-12),
        alone: Time::new(1e-12),
        ..params(0.0, Some(1300.0))
    };
    let straight = found(&brief);
    let (mut kept, mut stops) = (None, 0);
    let resumed = loop {
        let host = Stopper { kept: Mutex::new(kept), ..Stopper::default() };
        match run(&brief, &BTreeMap::new(), Isa::best(), &Ctx { host: &host, cancel: &host.cancel, threads: 1 }) {
            Ok(found) => break found,
            Err(StageError::Cancelled(_)) => stops += 1,
            Err(e) => panic!("{e}"),
        }
        kept = host.kept.into_inner().unwrap();
    };
    // 25 looks at both together, each stop after the ninth; 27 ticks of the crystal alone, so the last with the melt alone
    assert_eq!(stops, 3);
    assert!(resumed.encode() == straight.encode());
}

/// A host that keeps all, and asks for a stop at the eighth look at both phases, or at the 40th tick of a phase alone.
#[derive(Default)]
struct Stopper {
    together: AtomicUsize,
    alone: AtomicUsize,
    cancel: Cancel,
    kept: Mutex<Option<Vec<u8>>>,
}
impl Host for Stopper {
    fn advance(&self, _: f64, _: f64, doing: &str) {
        let (count, at) = match doing {
            "crystal and melt together" => (&self.together, 8),
            "each phase alone" => (&self.alone, 40),
            _ => return,
        };
        if count.fetch_add(1, Ordering::Relaxed) + 1 == at {
            self.cancel.set();
        }
    }
    fn due(&self) -> bool {
        true
    }
    fn keep(&self, bytes: &[u8]) {
        *self.kept.lock().unwrap() = Some(bytes.to_vec());
    }
    fn kept(&self) -> Option<Vec<u8>> {
        self.kept.lock().unwrap().clone()
    }
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
