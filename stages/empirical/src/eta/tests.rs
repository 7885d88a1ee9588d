//! The stage on made-up runs that follow a known law.
use super::*;
use crate::law::TABLE_4;
use hvi_impact::result::{Body, Melt, Snapshot, Space};
use hvi_kit::view::Cell;

/// A run whose projectile has melted to `eta`: half of that hot, as much again melting.
fn impact(v: f64, diameter: f64, thickness: f64, eta: f64) -> Impact {
    let by_phase = [1.0 - eta, 0.0, 0.5 * eta, 0.5 * eta, 0.0];
    let own = [0.5 - 0.5 * eta, 0.1, 0.4 + 0.25 * eta, 0.25 * eta, 0.0];
    let melt = Melt { by_phase, by_phase_own_volume: own, liquid: eta };
    let plate = Melt { by_phase: [9.0, 0.2, 0.1, 0.0, 0.0], by_phase_own_volume: [0.0; 5], liquid: 0.2 };
    let body = |name: &str| Body { name: name.into(), material: "copper".into(), mass: 1e-3, density: 8960.0 };
    Impact {
        space: Space::Axisymmetric,
        cell: 1e-4,
        cells_through: 6.0,
        velocity: v * 1e3,
        diameter,
        thickness,
        bodies: vec![body("projectile"), body("plate")],
        snapshots: vec![Snapshot { time: 5e-6, particles: Default::default(), melt: vec![melt, plate] }],
        ledger: vec![],
        leading: [0.0; 3],
        notes: vec![],
    }
}

fn sweep(thickness: f64, eta: impl Fn(f64, f64) -> f64) -> Vec<Impact> {
    let speeds = [1.0, 2.5, 4.2, 5.9, 7.5];
    let sizes = [1.6e-3, 3.2e-3, 6.4e-3, 12.6e-3];
    let pairs = speeds.iter().flat_map(|&v| sizes.iter().map(move |&d| (v, d)));
    pairs.map(|(v, d)| impact(v, d, thickness, eta(v, d / thickness))).collect()
}

fn params() -> Params {
    Params { measure: Measure::Liquid, zeros: Zeros::Keep, full: Full::Limit, bootstrap: 100, seed: 1 }
}

fn run(p: &Params, runs: Vec<Impact>, check: Vec<Impact>) -> Result<EtaLaw, String> {
    Eta::check(p).unwrap();
    Eta::run(p, Inputs { runs, check: hvi_kit::Any(check) }, &Ctx::quiet()).map_err(|e| e.to_string())
}

/// Below 1.16 km/s Table 4's law is negative; without those runs it is recovered, and holds on the runs it was not fitted to.
#[test]
fn runs_that_follow_a_law_give_it_back() {
    let truth = |v: f64, ratio: f64| TABLE_4.at(v, ratio).clamp(0.0, 1.0);
    let p = Params { zeros: Zeros::Drop, ..params() };
    let result = run(&p, sweep(2.5e-3, truth), sweep(5e-3, truth).split_off(4)).unwrap();
    for (a, b) in result.law.values().iter().zip(TABLE_4.values()) {
        assert!((a / b - 1.0).abs() < 1e-7, "{:?}", result.law);
    }
    assert!(result.scores.iter().all(|s| s.rms < 1e-9 && s.worst < 1e-9), "{:?}", result.scores);
    assert_eq!((result.scores[0].runs, result.scores[1].runs), (16, 16));
    assert_eq!(result.points.iter().filter(|p| !p.used).count(), 4);
}

/// The check runs must not enter the fit, and what is wrong with them must be reported.
#[test]
fn check_runs_are_not_fitted() {
    let truth = |v: f64, ratio: f64| TABLE_4.at(v, ratio).clamp(0.0, 1.0);
    let wrong = |v: f64, ratio: f64| truth(v, ratio) + 0.25;
    let alone = run(&params(), sweep(2.5e-3, truth), vec![]).unwrap();
    let both = run(&params(), sweep(2.5e-3, truth), sweep(5e-3, wrong)).unwrap();
    assert_eq!(alone.law, both.law);
    assert_eq!(alone.scores[1].runs, 0);
    assert!((both.scores[1].rms - 0.25).abs() < 0.01, "{:?}", both.scores);
}

/// Runs with nothing melted pull a law that ignores them; each treatment enters as its name says.
#[test]
fn the_treatment_of_zeros_matters_and_is_recorded() {
    let onset = |v: f64, ratio: f64| if v < 4.0 { 0.0 } else { TABLE_4.at(v, ratio) };
    let keep = run(&params(), sweep(2.5e-3, onset), vec![]).unwrap();
    let drop = run(&Params { zeros: Zeros::Drop, ..params() }, sweep(2.5e-3, onset), vec![]).unwrap();
    assert_eq!((keep.scores[0].runs, drop.scores[0].runs), (20, 12));
    assert!(drop.scores[0].rms < 1e-9 && keep.scores[0].rms > 1e-3);
    assert!(keep.law.at(2.5, 1.0) < drop.law.at(2.5, 1.0));
}

#[test]
fn each_measure_reads_its_own_masses() {
    let melt =
        Melt { by_phase: [0.4, 0.3, 0.2, 0.07, 0.03], by_phase_own_volume: [0.1, 0.2, 0.3, 0.3, 0.1], liquid: 0.42 };
    let close = |measure: Measure, expected: f64| assert!((measure.of(&melt) - expected).abs() < 1e-15, "{measure:?}");
    close(Measure::Liquid, 0.42);
    close(Measure::Complete, 0.3);
    close(Measure::MeltingOrMore, 0.6);
    close(Measure::CompleteOwnVolume, 0.7);
    close(Measure::MeltingOrMoreOwnVolume, 0.9);
}

#[test]
fn studies_that_cannot_be_fitted_say_what_to_add() {
    let truth = |v: f64, ratio: f64| TABLE_4.at(v, ratio).clamp(0.0, 1.0);
    let all = sweep(2.5e-3, truth);
    let only = |keep: fn(&Impact) -> bool| {
        run(&params(), all.iter().filter(|r| keep(r)).cloned().collect(), vec![]).unwrap_err()
    };
    assert!(only(|r| r.velocity == 5900.0).contains("Sweep the velocity"));
    assert!(only(|r| r.diameter == 1.6e-3).contains("Sweep the diameter"));
    assert!(only(|_| false).contains("need 4 or more"));
    assert!(
        run(&params(), sweep(2.5e-3, |_, _| 0.0), vec![])
            .unwrap_err()
            .contains("0 runs with a melted fraction above 0")
    );
    let broken = run(&params(), sweep(2.5e-3, |_, _| f64::NAN), vec![]).unwrap_err();
    assert!(broken.contains("melted fraction NaN"), "{broken}");
    assert_eq!(Eta::check(&Params { bootstrap: 3, ..params() }).unwrap_err().key, "bootstrap");
}

#[test]
fn the_result_reads_back_and_shows_what_the_paper_shows() {
    let truth = |v: f64, ratio: f64| TABLE_4.at(v, ratio).clamp(0.0, 1.0);
    let result = run(&params(), sweep(2.5e-3, truth), sweep(5e-3, truth)).unwrap();
    assert_eq!(EtaLaw::decode(&result.encode()).unwrap(), result);
    let views = result.views();
    let titles: Vec<&str> = views
        .iter()
        .map(|v| match v {
            View::Table(t) => t.title.as_str(),
            View::Figure(f) => f.title.as_str(),
            View::Picture(p) => p.title.as_str(),
        })
        .collect();
    assert_eq!(titles.len(), 7, "{titles:?}");
    for view in &views {
        if let View::Table(t) = view {
            assert!(t.rows.iter().all(|row| row.len() == t.columns.len()), "{}", t.title);
        }
    }
    let View::Table(t) = &views[0] else { panic!("the parameters come first") };
    assert!(t.note.contains("N = 6.0 cells"), "{}", t.note);
    assert_eq!(t.rows[2][5], Cell::Number(-0.6963));
}
