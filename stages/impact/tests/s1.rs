//! The yardstick scene S1: aluminium sphere on a thin aluminium plate at 6.7 km/s.
mod common;
use common::{drift, run, s1};
use hvi_impact::result::Impact;

/// What every run of S1 must show at 2.5 us: energy to 1e-9 (rounding), momentum of 8.318 kg m/s (in (r, z) of its own
/// discretised mass) kept, no energy below zero, no compression beyond what the contact jets reach (2.07), no tension
/// beyond the spall strength, and a leading edge that is matter, not noise: 6130 m/s +-1.5 % for the leading 1 %,
/// 6160 for .1 %, 6088 for 5 %, nothing faster than the impact.
fn check(impact: &Impact) {
    let (start, end) = (&impact.ledger[0], impact.ledger.last().expect("an end"));
    println!("{:?}: drift {:.1e}, leading .1/1/5 % {:.0?} m/s", impact.space, drift(impact), impact.leading);
    assert!(drift(impact) <= 1e-9, "drift {:e}", drift(impact));
    assert!((end.mass / start.mass - 1.0).abs() <= 1e-12);
    assert!((end.momentum / start.momentum - 1.0).abs() <= 1e-12, "momentum {:e}", end.momentum / start.momentum - 1.0);
    assert!(end.floored <= 1e-4 * start.kinetic);
    assert!(end.highest_compression <= 2.07, "compression {}", end.highest_compression);
    assert!(end.highest_pressure <= 390e9);
    for (found, (expected, bound)) in impact.leading.iter().zip([(6160.0, 0.015), (6130.0, 0.01), (6088.0, 0.01)]) {
        assert!((found / expected - 1.0).abs() <= bound, "leading {found} m/s, expected {expected}");
    }
    let p = &impact.snapshots.last().expect("an end").particles;
    for i in 0..p.mass.len() {
        assert!(p.energy[i] >= 0.0 && p.velocity[0][i] <= 6700.0);
        assert!(p.pressure[i] >= -1.2e9, "tension {}", p.pressure[i]);
    }
}

#[test]
fn axisymmetric() {
    check(&run(s1("axisymmetric", 3, "2.5 us")));
}

/// The lattice of S1: 14,328 particles in the sphere (a quarter: 3,582), 86,400 in the plate; 1.24150 g, 27,865.46 J,
/// 8318.05 g m/s.
#[test]
fn quarter() {
    let impact = run(s1("quarter", 3, "2.5 us"));
    let p = &impact.snapshots[0].particles;
    assert_eq!(p.body.iter().filter(|&&b| b == 0).count(), 3582);
    assert_eq!(p.body.iter().filter(|&&b| b == 1).count(), 21600);
    assert!((impact.bodies[0].mass / 1.24150e-3 - 1.0).abs() < 1e-5);
    assert!((impact.ledger[0].kinetic / 27865.46 - 1.0).abs() < 1e-5);
    assert!((impact.ledger[0].momentum / 8.31805 - 1.0).abs() < 1e-5);
    check(&impact);
}
