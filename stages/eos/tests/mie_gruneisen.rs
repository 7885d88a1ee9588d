//! Mie-Grueneisen: planar shocks and releases with known answers, laws, and states far out of range.
use hvi_eos::model::mie_gruneisen::Parameters;
use hvi_eos::{Eos, MieGruneisen};

fn aluminium() -> Eos {
    Eos::MieGruneisen(
        MieGruneisen::new(Parameters {
            density: 2703.0,
            sound_speed: 5240.0,
            slope: 1.40,
            gruneisen: 1.97,
            heat_capacity: 875.0,
            reference_temperature: 293.0,
        })
        .unwrap(),
    )
}

fn copper() -> Eos {
    Eos::MieGruneisen(
        MieGruneisen::new(Parameters {
            density: 8930.0,
            sound_speed: 3940.0,
            slope: 1.489,
            gruneisen: 2.02,
            heat_capacity: 385.0,
            reference_temperature: 293.0,
        })
        .unwrap(),
    )
}

/// Rankine-Hugoniot on Us = c0 + s up, in closed form: rho0 Us up and rho/rho0 = Us / (Us - up).
#[test]
fn hugoniot_is_the_line_it_was_made_of() {
    let (eos, rho, c0, s) = (aluminium(), 2703.0, 5240.0, 1.40);
    for up in [100.0, 1000.0, 3350.0, 6000.0] {
        let shock = eos.hugoniot_at_velocity(up).unwrap();
        let us = c0 + s * up;
        assert!((shock.shock_velocity / us - 1.0).abs() < 1e-9, "{shock:?}");
        assert!((shock.pressure / (rho * us * up) - 1.0).abs() < 1e-9, "{shock:?}");
        assert!((shock.volume * rho / (1.0 - up / us) - 1.0).abs() < 1e-9, "{shock:?}");
    }
}

/// Planar symmetric impact of 6061-T6 aluminium at 6700 m/s: 89.917 GPa, free surface 6893.4 m/s, residual 1.096 MJ/kg,
/// and further free-surface velocities, from an independent integration of the same model (digits as given).
#[test]
fn releases_with_known_answers() {
    let shock = aluminium().hugoniot_at_velocity(3350.0).unwrap();
    assert!((shock.pressure / 89.917e9 - 1.0).abs() < 1e-5, "{shock:?}");
    let release = aluminium().release(&shock).unwrap();
    assert!((release.free_surface_velocity - 6893.4).abs() < 0.1, "{release:?}");
    assert!((release.energy - 1.096e6).abs() < 0.5e3, "{release:?}");
    for (eos, impact, surface, digits) in [
        (aluminium(), 1000.0, 1000.7, 0.05),
        (aluminium(), 4000.0, 4047.7, 0.05),
        (copper(), 1000.0, 1001.4, 0.05),
        (copper(), 6000.0, 6240.0, 0.5),
    ] {
        let release = eos.release(&eos.hugoniot_at_velocity(0.5 * impact).unwrap()).unwrap();
        assert!((release.free_surface_velocity - surface).abs() < digits + 0.02, "{impact}: {release:?}");
    }
}

/// On the isentrope through the reference state T = Tr exp(G0 x), the temperature's own definition.
#[test]
fn temperature_follows_the_isentrope() {
    let eos = copper();
    let v0 = eos.reference_volume();
    for x in [-0.1f64, 0.1, 0.3, 0.5] {
        let v = v0 * (1.0 - x);
        let t = eos.point(v, eos.isentrope(v0, 0.0, v, 400)).temperature;
        assert!((t / (293.0 * (2.02 * x).exp()) - 1.0).abs() < 1e-7, "{x} {t}");
        assert!((eos.point(v, eos.energy_at(v, 1234.0)).temperature - 1234.0).abs() < 1e-9);
    }
}

/// c^2 = -V^2 dP/dV along the isentrope, by central differences (error of order h^2 = 1e-8).
#[test]
fn sound_speed_is_the_slope_of_the_isentrope() {
    let eos = copper();
    for (ratio, energy) in [(1.05, 1e5), (0.9, 3e5), (0.7, 2e6), (0.5, 8e6)] {
        let v = ratio * eos.reference_volume();
        let h = 1e-4 * v;
        let p = |to: f64| eos.point(to, eos.isentrope(v, energy, to, 4)).pressure;
        let c2 = -v * v * (p(v + h) - p(v - h)) / (2.0 * h);
        assert!((eos.point(v, energy).sound_speed / c2.sqrt() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn finite_and_monotone_far_out_of_range() {
    for eos in [aluminium(), copper()] {
        // On the isentrope through the reference state, where matter can be: at fixed E it cannot.
        let v0 = eos.reference_volume();
        let (mut last, mut energy) = (0.0, 0.0);
        for i in 1..950 {
            let at = |i: usize| v0 * (1.0 - 1e-3 * i as f64);
            energy = eos.isentrope(at(i - 1), energy, at(i), 1);
            let p = eos.point(at(i), energy).pressure;
            assert!(p > last, "P must rise with compression at {i}");
            last = p;
        }
        for ratio in [1e-3, 0.1, 0.3, 0.6, 1.0, 1.5, 20.0, 1e4] {
            for energy in [-1e9, -1e3, 0.0, 1e6, 1e9, 1e15] {
                let at = eos.point(ratio * eos.reference_volume(), energy);
                assert!(at.pressure.is_finite() && at.temperature.is_finite() && at.sound_speed > 0.0, "{at:?}");
            }
        }
    }
}

#[test]
fn separated_matter_is_judged_at_its_own_volume() {
    let eos = aluminium();
    let v0 = eos.reference_volume();
    let own = eos.relaxed_volume(7.0 * v0, 1.0e6);
    assert!((own / v0 - (1.0 + 1.97e6 / 5240f64.powi(2))).abs() < 1e-12);
    assert!(eos.point(own, 1.0e6).pressure.abs() < 1.0);
    assert_eq!(eos.relaxed_volume(0.9 * v0, 1.0e6), 0.9 * v0);
}

/// Tensile and pole-near parameters are refused with a reason.
#[test]
fn bad_parameters_are_named() {
    let Eos::MieGruneisen(good) = copper() else { unreachable!() };
    let bad = Parameters { gruneisen: 0.0, ..good.parameters().clone() };
    assert_eq!(MieGruneisen::new(bad).unwrap_err().to_string(), "Mie-Grueneisen: gruneisen is 0, must be positive");
}
