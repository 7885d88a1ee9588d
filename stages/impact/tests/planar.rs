//! Plane impact of unlike and like slabs against the shock relations of the same equation of state.
mod common;
use common::{aluminium, copper, drift, mean, planar, run};
use serde_json::Value;

/// Mie-Grueneisen matter for the reference: rho0, c0, s, G0.
#[derive(Clone, Copy)]
struct Solid(f64, f64, f64, f64);
const CU: Solid = Solid(8930.0, 3940.0, 1.489, 2.02);
const AL: Solid = Solid(2703.0, 5240.0, 1.40, 1.97);

impl Solid {
    fn shock(self, u: f64) -> (f64, f64) {
        let us = self.1 + self.2 * u;
        (self.0 * us * u, us)
    }
    fn pressure(self, ratio: f64, e: f64) -> f64 {
        let Solid(rho, c, s, g) = self;
        let x = 1.0 - ratio;
        if x < 0.0 {
            return rho * c * c * x + g * rho * e;
        }
        let h = rho * c * c * x / ((1.0 - s * x) * (1.0 - s * x));
        h * (1.0 - 0.5 * g * x) + g * rho * e
    }
    /// Velocity of the free surface when matter shocked to particle velocity `u` has released to zero pressure.
    fn free_surface(self, u: f64) -> f64 {
        let (p, us) = self.shock(u);
        let (mut ratio, mut now, mut gained) = (1.0 - u / us, p, 0.0);
        let mut e = 0.5 * p * (1.0 - ratio) / self.0;
        let step = 1e-5;
        loop {
            let mut next = now;
            for _ in 0..4 {
                next = self.pressure(ratio + step, e - 0.5 * (now + next) * step / self.0);
            }
            if next <= 0.0 {
                return u + gained + (now * now / (now - next) * step / self.0).sqrt();
            }
            e -= 0.5 * (now + next) * step / self.0;
            gained += ((now - next) * step / self.0).sqrt();
            (now, ratio) = (next, ratio + step);
        }
    }
}

/// Particle velocity in the target at equal pressure on both sides.
fn match_impedance(flyer: Solid, target: Solid, v: f64) -> f64 {
    let (mut a, mut b) = (0.0, v);
    for _ in 0..100 {
        let u = 0.5 * (a + b);
        if flyer.shock(v - u).0 > target.shock(u).0 { a = u } else { b = u }
    }
    a
}

/// Errors relative to the reference: pressure, scatter of pressure, velocity, density, free surface; and the drift.
struct Errors([f64; 5], f64);

fn measure(flyer: (Value, Solid), target: (Value, Solid), v: f64, cells: u32) -> Errors {
    let u = match_impedance(flyer.1, target.1, v);
    let (p, us) = target.1.shock(u);
    let length = 10e-3;
    let (early, late) = (0.7 * length / us, 1.4 * length / us);
    let impact = run(planar(flyer.0, target.0, v, cells, &[early], late));
    let dx = impact.cell;
    let plateau = &impact.snapshots[0].particles;
    let x = |i: usize| plateau.position[0][i] as f64;
    // Six cells from the contact and twelve from the front: the plateau between the smeared ends.
    let inside = |i: usize| plateau.body[i] == 1 && x(i) > u * early + 6.0 * dx && x(i) < us * early - 12.0 * dx;
    let (pressure, scatter) = mean(plateau, |i| plateau.pressure[i] as f64, inside);
    let (velocity, _) = mean(plateau, |i| plateau.velocity[0][i] as f64, inside);
    let (density, _) = mean(plateau, |i| plateau.density[i] as f64, inside);
    let end = &impact.snapshots[1].particles;
    let n = end.mass.len();
    let (surface, _) = mean(end, |i| end.velocity[0][i] as f64, |i| i >= n - 20);
    let compressed = target.1.0 * us / (us - u);
    let errors = [
        pressure / p - 1.0,
        scatter,
        velocity / u - 1.0,
        density / compressed - 1.0,
        surface / target.1.free_surface(u) - 1.0,
    ];
    assert!(impact.ledger.iter().all(|l| l.floored <= 1e-12 * impact.ledger[0].kinetic));
    Errors(errors, drift(&impact))
}

fn check(name: &str, errors: &Errors, bounds: [f64; 5]) {
    println!("{name}: errors of P, scatter, u, density, free surface: {:?}; drift {:.1e}", errors.0, errors.1);
    let Errors(found, drift) = errors;
    for (k, what) in ["pressure", "scatter", "velocity", "density", "free surface"].iter().enumerate() {
        assert!(found[k].abs() <= bounds[k], "{name}: {what} {:.5}, allowed {}", found[k], bounds[k]);
    }
    assert!(*drift <= 1e-12, "{name}: energy drift {drift:e}");
}

/// Bounds of the method's specification: P .2 %, scatter 1 %, u and free surface .1 %, density .2 %.
const TIGHT: [f64; 5] = [2e-3, 1e-2, 1e-3, 2e-3, 1e-3];

#[test]
fn copper_on_copper_at_1000() {
    for cells in [100, 200, 400] {
        check("Cu-Cu 1000", &measure((copper(), CU), (copper(), CU), 1000.0, cells), TIGHT);
    }
}

#[test]
fn aluminium_on_aluminium_at_6700() {
    for cells in [100, 200] {
        check("Al-Al 6700", &measure((aluminium(), AL), (aluminium(), AL), 6700.0, cells), TIGHT);
    }
}

#[test]
fn weak_and_very_strong() {
    check("Cu-Cu 300", &measure((copper(), CU), (copper(), CU), 300.0, 100), TIGHT);
    check("Al-Al 12000", &measure((aluminium(), AL), (aluminium(), AL), 12000.0, 100), TIGHT);
    // At 100 cells the free surface is .20 % too fast, at 200 .013 %, at 400 .001 %: the rest of the row holds at 100 too.
    check("Al-Al 20000", &measure((aluminium(), AL), (aluminium(), AL), 20000.0, 200), TIGHT);
}

#[test]
fn unlike_slabs() {
    check("Al-Cu 6000", &measure((aluminium(), AL), (copper(), CU), 6000.0, 100), TIGHT);
}

/// Figures quoted for the planar reference at 6.7 km/s: 89.917 GPa, Us 9930 m/s, rho/rho0 1.5091, free surface 6893.4 m/s.
#[test]
fn the_reference_itself() {
    let (p, us) = AL.shock(3350.0);
    assert!((p / 89.917e9 - 1.0).abs() < 1e-4 && (us - 9930.0).abs() < 1e-9);
    assert!((us / (us - 3350.0) - 1.5091).abs() < 1e-4);
    assert!((AL.free_surface(3350.0) - 6893.4).abs() < 0.5);
    assert!((CU.free_surface(500.0) - 1001.4).abs() < 0.2);
}
