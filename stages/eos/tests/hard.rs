//! Hard cases of every model: far out of range, on borders, wild parameters: finite and monotone, or a typed error.
use hvi_eos::handbook::Set;
use hvi_eos::model::{mie_gruneisen, sesame, tabulated, tillotson};
use hvi_eos::{Eos, Gray, IdealGas, MieGruneisen, Phase, StiffenedGas, Tabulated, Tillotson};
use proptest::prelude::*;

/// Aluminium of H. J. Melosh, Impact Cratering (1989), table AII.3, as quoted in the material data of the SPH code miluphcuda
/// (`aluminum.till.cfg`: E_iv 3.0, E_cv 13.9 MJ/kg; LLNL's Spheral has 2.7 and 14.1), after J. H. Tillotson, General Atomic
/// GA-3216 (1962; DTIC AD0486711); heat capacity of the metal.
fn aluminium() -> tillotson::Parameters {
    tillotson::Parameters {
        density: 2700.0,
        a: 0.5,
        b: 1.63,
        bulk: 75.2e9,
        bulk_slope: 65e9,
        energy: 5e6,
        incipient: 3e6,
        complete: 13.9e6,
        alpha: 5.0,
        beta: 5.0,
        heat_capacity: 900.0,
        reference_temperature: 300.0,
    }
}

fn linear() -> mie_gruneisen::Parameters {
    mie_gruneisen::Parameters {
        density: 8930.0,
        sound_speed: 3940.0,
        slope: 1.489,
        gruneisen: 2.0,
        heat_capacity: 385.0,
        reference_temperature: 293.0,
    }
}

/// Copper's states on a grid, as a table with phases.
fn table() -> Eos {
    let gray = Gray::new(Set::CopperRoyce.parameters()).unwrap();
    let v0 = gray.parameters().volume;
    let sheet = |phase: Phase| -> Vec<tabulated::Isochore> {
        let isochore = |i: i32| {
            let volume = v0 * (0.64 + 0.03 * f64::from(i));
            let node = |t: f64| {
                let at = gray.at(volume, t).0;
                tabulated::Node { temperature: t, energy: at.energy, pressure: at.pressure, errors: [0.0; 2] }
            };
            let nodes = (0..10).map(|j| 300.0 + 1000.0 * f64::from(j)).filter(|&t| gray.at(volume, t).1 == phase);
            tabulated::Isochore { volume, nodes: nodes.map(node).collect() }
        };
        (0..15).map(isochore).filter(|i| i.nodes.len() >= 2).collect()
    };
    let (solid, liquid) = (sheet(Phase::Solid), sheet(Phase::Liquid));
    Eos::Table(
        Tabulated::new(tabulated::Parameters { reference_volume: v0, reference_temperature: 300.0, solid, liquid })
            .unwrap(),
    )
}

fn models() -> Vec<Eos> {
    let mut all: Vec<Eos> = Set::ALL.iter().map(|s| Eos::Gray(Gray::new(s.parameters()).unwrap())).collect();
    all.push(Eos::MieGruneisen(MieGruneisen::new(linear()).unwrap()));
    all.push(Eos::Tillotson(Tillotson::new(aluminium()).unwrap()));
    let water =
        StiffenedGas { density: 1e3, gamma: 2.35, stiffness: 1e9, heat_capacity: 1816.0, reference_temperature: 300.0 };
    all.push(Eos::StiffenedGas(water.new().unwrap()));
    all.push(Eos::IdealGas(IdealGas::new(1.2, 1.4, 718.0, 300.0).unwrap()));
    all.push(table());
    all
}

/// Uniform numbers in 0..1 from a 64-bit xorshift generator (Marsaglia 2003).
struct Random(u64);
impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A million states a model, V from 0.4 V0 to 1e4 V0, E from far below the cold
/// curve: all finite, c^2 > 0 and T >= 0; and T(V, E(V, T)) = T.
#[test]
fn a_million_states_a_model_are_finite_and_go_round() {
    for eos in models() {
        let v0 = eos.reference_volume();
        let mut random = Random(17);
        let (n, limit) = (1_000_000, if matches!(eos, Eos::Table(_)) { 1e-10 } else { 1e-12 });
        let (mut worst, mut cold) = (0.0f64, 0);
        for i in 0..n {
            let v = v0 * if i % 2 == 0 { 0.4 + 1.1 * random.uniform() } else { 0.4 * 25_000f64.powf(random.uniform()) };
            // P_inf V would drown c_v T: 1e10 against 1e5 J/kg at 1e4 V0.
            let v = if matches!(eos, Eos::StiffenedGas(_)) { v.min(10.0 * v0) } else { v };
            let t = 50.0 * 400f64.powf(random.uniform());
            let e = eos.energy_at(v, t);
            let (at, wild) = (eos.point(v, e), eos.point(v, -5e6 + 50e6 * random.uniform()));
            for p in [at, wild] {
                assert!(
                    p.pressure.is_finite() && p.temperature.is_finite() && p.sound_speed.is_finite(),
                    "{eos:?} {v} {e} {p:?}"
                );
                assert!(
                    p.temperature >= 0.0 && p.sound_speed >= 0.0 && (0.0..=1.0).contains(&p.liquid),
                    "{v} {e} {p:?}"
                );
                cold += usize::from(p.temperature == 0.0);
            }
            // In the belt of a table E says more than T: there T is T_m.
            if at.phase != Phase::Melting || !matches!(eos, Eos::Table(_)) {
                worst = worst.max((at.temperature / t - 1.0).abs());
            }
        }
        println!("{}: {n} states, round trip {worst:.1e}, {cold} below the cold curve", eos.name());
        assert!(worst <= limit, "{}: {worst:e}", eos.name());
    }
}

/// T never falls with E on any isochore, nor P on those of models whose matter pushes when heated.
#[test]
fn temperature_rises_with_energy_in_every_model() {
    for eos in models() {
        let v0 = eos.reference_volume();
        for i in 0..40 {
            let v = v0 * 0.4 * 1.25f64.powi(i);
            let mut last = eos.point(v, -3e6);
            for j in 1..500 {
                let at = eos.point(v, -3e6 + 4e4 * f64::from(j));
                assert!(at.temperature >= last.temperature, "{} {} {j}: {last:?} {at:?}", eos.name(), v / v0);
                last = at;
            }
        }
    }
}

/// Where c^2 has to be floored: cold solid beyond 1.43 V0 and the loops of the vapour, nowhere else.
#[test]
fn sound_speeds_are_floored_in_the_stated_places_only() {
    for set in Set::ALL {
        let gray = Gray::new(set.parameters()).unwrap();
        let (v0, floor) = (gray.parameters().volume, 0.1 * gray.parameters().sound_speed);
        let mut random = Random(23);
        for _ in 0..200_000 {
            let v = v0 * (0.42 + 1.0 * random.uniform());
            let t = 100.0 * 200f64.powf(random.uniform());
            let at = gray.point(v, gray.at(v, t).0.energy);
            assert!(at.sound_speed > floor * (1.0 + 1e-9), "{set:?} {} {t} {at:?}", v / v0);
        }
    }
}

fn finite(eos: &Eos, states: &[(f64, f64)]) -> Result<(), TestCaseError> {
    let v0 = eos.reference_volume();
    for &(ratio, e) in states {
        let (low, high) = (eos.point(ratio * v0, e), eos.point(ratio * v0, e + 1e5));
        for at in [low, high] {
            prop_assert!(
                at.pressure.is_finite() && at.temperature >= 0.0 && at.sound_speed >= 0.0,
                "{eos:?} {ratio} {e} {at:?}"
            );
        }
        prop_assert!(high.temperature >= low.temperature, "{eos:?} {ratio} {e} {low:?} {high:?}");
    }
    Ok(())
}

fn some_states() -> impl Strategy<Value = Vec<(f64, f64)>> {
    proptest::collection::vec((-0.4f64..4.0, -6e6f64..60e6).prop_map(|(x, e)| (10f64.powf(x), e)), 20)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// GRAY of any numbers at all: a typed error, or finite and monotone, with E and P continuous on every border.
    #[test]
    fn wild_gray(
        scale in proptest::collection::vec(-1.2f64..1.2, 9),
        shape in (0.2f64..3.0, 0.05f64..0.5, 1.05f64..2.5, 0.1f64..0.9, 0.5f64..2.0),
        states in some_states(),
    ) {
        let mut p = Set::CopperRoyce.parameters();
        let fields: [&mut f64; 9] = [&mut p.volume, &mut p.sound_speed, &mut p.slope, &mut p.gruneisen, &mut p.gruneisen_slope,
            &mut p.electronic, &mut p.melting_temperature, &mut p.molar_mass, &mut p.cohesive_energy];
        for (field, s) in fields.into_iter().zip(&scale) {
            *field *= s.exp();
        }
        (p.melting_entropy, p.liquid_softening, p.join_ratio, p.covolume_ratio, p.joining) = shape;
        if let Ok(gray) = Gray::new(p.clone()) {
            for ratio in [0.4, 0.7, 1.0, 1.3] {
                let v = (ratio * p.volume).min(p.join_ratio * p.volume);
                let [start, end, hot] = gray.borders(v);
                // Where melting takes less than the step below, all of its heat lies in the step.
                let seen = if end - start < 1e-6 * start { &[hot][..] } else { &[start, end, hot] };
                for &border in seen {
                    let (a, b) = (gray.at(v, border * (1.0 - 1e-9)).0, gray.at(v, border * (1.0 + 1e-9)).0);
                    let heat = 1e-8 * border * (a.c_v + b.c_v) + 1e-9 * a.energy.abs();
                    prop_assert!((b.energy - a.energy).abs() < heat, "{p:?} {ratio} {border} {a:?} {b:?}");
                    let on = gray.point(v, gray.at(v, border).0.energy);
                    prop_assert!((on.temperature / border - 1.0).abs() < 1e-9, "{p:?} {border} {on:?}");
                }
            }
            finite(&Eos::Gray(gray), &states)?;
        }
    }

    #[test]
    fn wild_tillotson(scale in proptest::collection::vec(-2.0f64..2.0, 11), states in some_states()) {
        let mut p = aluminium();
        let fields: [&mut f64; 11] = [&mut p.density, &mut p.a, &mut p.b, &mut p.bulk, &mut p.bulk_slope, &mut p.energy, &mut p.incipient,
            &mut p.complete, &mut p.alpha, &mut p.beta, &mut p.heat_capacity];
        for (field, s) in fields.into_iter().zip(&scale) {
            *field *= s.exp();
        }
        if let Ok(eos) = Tillotson::new(p) {
            finite(&Eos::Tillotson(eos), &states)?;
        }
    }

    #[test]
    fn wild_mie_gruneisen(scale in proptest::collection::vec(-2.0f64..2.0, 5), states in some_states()) {
        let mut p = linear();
        let fields: [&mut f64; 5] = [&mut p.density, &mut p.sound_speed, &mut p.slope, &mut p.gruneisen, &mut p.heat_capacity];
        for (field, s) in fields.into_iter().zip(&scale) {
            *field *= s.exp();
        }
        if let Ok(eos) = MieGruneisen::new(p) {
            finite(&Eos::MieGruneisen(eos), &states)?;
        }
    }

    /// Tables of noise: refused, or finite and rising.
    #[test]
    fn wild_tables(
        noise in proptest::collection::vec((-1.0f64..1.0, -1.0f64..1.0), 30),
        rough in 0.0f64..0.5,
        states in some_states(),
    ) {
        let node = |i: usize, j: usize| {
            let (a, b) = noise[5 * i + j];
            let t = 300.0 + 500.0 * j as f64;
            tabulated::Node { temperature: t, energy: 390.0 * t * (1.0 + rough * a), pressure: 1e9 * (30.0 - 8.0 * i as f64 + 20.0 * rough * b), errors: [0.0; 2] }
        };
        let isochore = |i: usize| tabulated::Isochore { volume: 1e-4 * (0.8 + 0.06 * i as f64), nodes: (0..5).map(|j| node(i, j)).collect() };
        let p = tabulated::Parameters { reference_volume: 1e-4, reference_temperature: 300.0, solid: (0..6).map(isochore).collect(), liquid: Vec::new() };
        if let Ok(table) = Tabulated::new(p) {
            finite(&Eos::Table(table), &states)?;
        }
    }

    /// Any text is a table or an error that says what was wrong.
    #[test]
    fn wild_text(text in "[0-9eE.+ \n#a-z-]{0,200}") {
        if let Err(e) = sesame::read(&text, 300.0) {
            prop_assert!(e.to_string().starts_with("SESAME table, "));
        }
    }
}
