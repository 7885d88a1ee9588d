//! GRAY: the known answers of the three published parameter sets.
//!
//! They come from an independent implementation of the same formulas (adaptive quadrature, SciPy), to the digits written here.
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray, Phase};

fn gray(set: Set) -> Gray {
    Gray::new(set.parameters()).unwrap()
}
fn eos(set: Set) -> Eos {
    Eos::Gray(gray(set))
}

#[test]
fn spot_values_to_the_digits_given() {
    let rows: [(Set, f64, f64, f64, f64, Phase); 9] = [
        (Set::CopperRoyce, 0.8, 1000.0, 0.700174, 57.603064, Phase::Solid),
        (Set::CopperRoyce, 0.7, 3000.0, 2.391783, 137.907580, Phase::Solid),
        (Set::CopperRoyce, 0.64, 6000.0, 5.163951, 246.880727, Phase::Melting),
        (Set::CopperRoyce, 0.62, 8000.0, 6.721893, 302.105308, Phase::Liquid),
        (Set::CopperRoyce, 1.4, 9000.0, 3.248834, 3.638424, Phase::HotLiquid),
        (Set::CopperRoyce, 10.0, 6000.0, 5.835551, 0.161765, Phase::Vapour),
        (Set::AluminiumPaper, 0.7, 3000.0, 4.669704, 73.125763, Phase::Solid),
        (Set::AluminiumPaper, 1.3, 5000.0, 4.446086, 2.105671, Phase::HotLiquid),
        (Set::AluminiumPaper, 10.0, 6000.0, 13.804693, 0.099665, Phase::Vapour),
    ];
    for (set, ratio, t, energy, pressure, phase) in rows {
        let gray = gray(set);
        let (at, found) = gray.at(ratio * gray.parameters().volume, t);
        assert!((at.energy / 1e6 - energy).abs() <= 0.6e-6, "{set:?} {ratio} {t}: E {}", at.energy / 1e6);
        assert!((at.pressure / 1e9 - pressure).abs() <= 0.6e-6, "{set:?} {ratio} {t}: P {}", at.pressure / 1e9);
        assert_eq!(found, phase);
        if phase == Phase::Melting {
            assert!((at.liquid - 0.69784).abs() <= 0.6e-5, "{}", at.liquid);
        }
    }
}

#[test]
fn attraction_from_the_cohesive_energy() {
    for (set, attraction) in [(Set::CopperRoyce, 882.6), (Set::CopperPaperMd, 825.2), (Set::AluminiumPaper, 6926.0)] {
        let found = gray(set).attraction();
        let digit = if attraction > 1000.0 { 0.5 } else { 0.05 };
        assert!((found - attraction).abs() <= digit * 1.1, "{set:?}: {found}");
    }
}

/// The Hugoniot's distance from rho0 (C + S up) up: the part of the model that is not exactly the line.
#[test]
fn hugoniot_near_the_line() {
    let rows = [
        (Set::CopperRoyce, [-0.01, -0.05, -0.26, -0.55]),
        (Set::CopperPaperMd, [-0.02, -0.05, -0.23, -0.42]),
        (Set::AluminiumPaper, [-0.04, -0.10, -0.40, -0.76]),
    ];
    for (set, expected) in rows {
        let p = set.parameters();
        let found = [0.9, 0.8, 0.7, 0.66].map(|ratio: f64| {
            let x = 1.0 - ratio;
            let line = p.sound_speed.powi(2) * x / (p.volume * (1.0 - p.slope * x).powi(2));
            100.0 * (eos(set).hugoniot(ratio * p.volume).unwrap().pressure / line - 1.0)
        });
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= 0.0055, "{set:?} {found:?}");
        }
    }
}

/// Pressure at which `measure` of the Hugoniot passes `level`.
fn hugoniot_crossing(eos: &Eos, level: f64, measure: impl Fn(&hvi_eos::curve::Shock) -> f64) -> hvi_eos::curve::Shock {
    let found = hvi_kit::math::bisect(10e9, 400e9, 1e6, |p| measure(&eos.hugoniot_at_pressure(p).unwrap()) - level);
    eos.hugoniot_at_pressure(found.unwrap()).unwrap()
}

#[test]
fn hugoniot_enters_and_leaves_melting() {
    let rows = [
        (Set::CopperRoyce, (224.0, 5775.0), (284.0, 6412.0)),
        (Set::CopperPaperMd, (240.0, 6410.0), (301.0, 7043.0)),
        (Set::AluminiumPaper, (132.0, 5132.0), (171.0, 5918.0)),
    ];
    for (set, enter, leave) in rows {
        for (level, (pressure, temperature)) in [(1e-9, enter), (1.0 - 1e-9, leave)] {
            let at = hugoniot_crossing(&eos(set), level, |s| s.liquid);
            assert!((at.pressure / 1e9 - pressure).abs() <= 0.55, "{set:?} {at:?}");
            assert!((at.temperature - temperature).abs() <= 1.0, "{set:?} {at:?}");
        }
    }
}

/// Melting at P = 0: its band, and the heat it takes along the isobar.
#[test]
fn melting_at_zero_pressure() {
    let rows = [
        (Set::CopperRoyce, 1323.0, 1335.0, 14.9),
        (Set::CopperPaperMd, 1488.0, 1498.0, 16.6),
        (Set::AluminiumPaper, 911.0, 917.0, 10.2),
    ];
    for (set, start, end, heat) in rows {
        let gray = gray(set);
        let v0 = gray.parameters().volume;
        let border = |k: usize| {
            let pressure = |v: f64| gray.at(v, gray.borders(v)[k]).0.pressure;
            let v = hvi_kit::math::bisect(v0, 1.3 * v0, 1e-14 * v0, pressure).unwrap();
            (gray.borders(v)[k], gray.at(v, gray.borders(v)[k]).0.energy)
        };
        let (solid, liquid) = (border(0), border(1));
        let latent = (liquid.1 - solid.1) * gray.parameters().molar_mass / 1e3;
        assert!((solid.0 - start).abs() <= 0.6 && (liquid.0 - end).abs() <= 0.6, "{set:?} {solid:?} {liquid:?}");
        assert!((latent - heat).abs() <= 0.055, "{set:?} {latent}");
    }
}

#[test]
fn release_melts() {
    let rows = [
        (Set::CopperRoyce, (136.0, 4.28), (191.0, 5.38)),
        (Set::CopperPaperMd, (149.0, 4.73), (204.0, 5.87)),
        (Set::AluminiumPaper, (69.0, 5.52), (100.0, 7.10)),
    ];
    for (set, onset, complete) in rows {
        let eos = eos(set);
        for (level, (pressure, impact)) in [(1e-7, onset), (1.0 - 1e-7, complete)] {
            let liquid = |p: f64| eos.release(&eos.hugoniot_at_pressure(p).unwrap()).unwrap().liquid - level;
            let found = hvi_kit::math::bisect(40e9, 260e9, 5e6, liquid).unwrap();
            let shock = eos.hugoniot_at_pressure(found).unwrap();
            let speed = 2.0 * shock.particle_velocity / 1e3;
            assert!((found / 1e9 - pressure).abs() <= 0.55, "{set:?} {found:e}");
            assert!((speed - impact).abs() <= 0.006, "{set:?} {speed}");
        }
    }
}

/// Residual energy after planar release of symmetric impacts, copper of the paper's Table 1 (numerical), kJ/kg; speeds in km/s.
#[test]
fn residual_energy_of_planar_impacts() {
    let eos = eos(Set::CopperPaperMd);
    for (impact, energy) in [(2500.0, 116.7), (4200.0, 403.7), (5900.0, 793.4)] {
        let release = eos.release(&eos.hugoniot_at_velocity(0.5 * impact).unwrap()).unwrap();
        assert!((release.energy / 1e3 - energy).abs() <= 0.06, "{impact} {release:?}");
    }
}
