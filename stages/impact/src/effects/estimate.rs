//! States that a scene can reach, by closed form: impedance match at the contact, release, strain, heat.
use crate::bodies::{Piece, pieces};
use crate::material::Material;
use crate::params::Params;
use crate::scene::Layout;
use hvi_eos::Eos;
use hvi_eos::curve::Shock;
use hvi_kit::math;

/// The numbers that decide; infinite where no estimate can be made, so that the effect is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Highest pressure of the impedance matches [Pa].
    pub pressure: f64,
    /// Least spall strength [Pa]; infinite where no material has one.
    pub spall: f64,
    /// Work of strength over kinetic energy.
    pub strength: f64,
    /// Share of strength lost to heat.
    pub softening: f64,
    /// Share of strength due to the rate of strain.
    pub rate: f64,
    /// Damage by the strain expected; infinite where no material has constants of damage.
    pub damage: f64,
    /// Residual temperature after release over the melting temperature.
    pub melting: f64,
}

impl Estimate {
    /// Over all bodies that can meet: each moving one against each other one, at their relative speed.
    pub fn of(params: &Params, eos: &[Eos]) -> Estimate {
        let layout = Layout::of(params);
        let all = pieces(params, &layout);
        let speed = |i: usize, j: usize| {
            let squares = (0..3).map(|d| all[i].velocity[d] - all[j].velocity[d]).map(|v| v * v);
            squares.sum::<f64>().sqrt()
        };
        let mut found = Estimate {
            pressure: 0.0,
            spall: f64::INFINITY,
            strength: 0.0,
            softening: 0.0,
            rate: 0.0,
            damage: f64::INFINITY,
            melting: 0.0,
        };
        for piece in &all {
            found.spall = found.spall.min(piece.material.spall.map_or(f64::INFINITY, |p| p.si()));
        }
        let has_damage = all.iter().any(|piece| piece.material.damage.is_some());
        found.damage = if has_damage { 0.0 } else { f64::INFINITY };
        for i in 0..all.len() {
            for j in 0..i {
                if speed(i, j) > 0.0 {
                    found.pair([&all[i], &all[j]], [&eos[i], &eos[j]], speed(i, j), &layout);
                }
            }
        }
        found
    }

    /// Raises the numbers to those of two bodies that meet at `v` [m/s].
    fn pair(&mut self, bodies: [&Piece<'_>; 2], eos: [&Eos; 2], v: f64, layout: &Layout) {
        let shocks = impedance_match(eos, v);
        for k in 0..2 {
            let (material, eos) = (bodies[k].material, eos[k]);
            let density = 1.0 / eos.reference_volume();
            let jc = &material.strength;
            let (flow, kinetic) = (jc.hardened(1.0), 0.5 * density * v * v);
            self.strength = self.strength.max(flow / kinetic);
            self.rate = self.rate.max(jc.rate_factor(v / layout.cell) - 1.0);
            let (pressure, temperature, shrunk) =
                shocks.as_ref().map_or((f64::INFINITY, f64::INFINITY, 0.5), |shocks| {
                    let released = eos.release(&shocks[k]).map_or(f64::INFINITY, |r| r.temperature);
                    (shocks[k].pressure, released, shocks[k].volume * density)
                });
            self.pressure = self.pressure.max(pressure);
            let melting = melting(material, eos);
            self.melting = self.melting.max(temperature / melting);
            let hot = temperature.max(heated(eos, flow / density));
            self.softening = self.softening.max(1.0 - jc.softening(jc.homologous(hot, melting)));
            if let Some(damage) = &material.damage {
                let strain = (-2.0 / 3.0 * math::log(shrunk)).max((v * layout.end / smallest(bodies)).min(1.0));
                self.damage = self.damage.max(damage.increment(strain, 1.0 / 3.0, 1.0, 0.0));
            }
        }
    }
}

/// Least thickness of the two [m].
fn smallest(bodies: [&Piece<'_>; 2]) -> f64 {
    bodies.iter().map(|b| b.solid.thinnest(1)).fold(f64::INFINITY, f64::min)
}

/// Melting temperature without pressure [K]: the equation of state's, or the strength model's.
pub fn melting(material: &Material, eos: &Eos) -> f64 {
    eos.melting_temperature(eos.reference_volume()).unwrap_or(material.strength.melting_temperature.si())
}

/// Temperature [K] of matter at its reference volume with `heat` [J/kg] more than at its reference temperature.
fn heated(eos: &Eos, heat: f64) -> f64 {
    let (volume, start) = (eos.reference_volume(), eos.reference_temperature());
    eos.point(volume, eos.energy_at(volume, start) + heat).temperature
}

/// The shocked states of two bodies that meet at relative speed `v` [m/s]: equal pressure, particle velocities that add up to v.
/// None where an equation of state knows no such shock.
pub fn impedance_match(eos: [&Eos; 2], v: f64) -> Option<[Shock; 2]> {
    let shock = |k: usize, u: f64| eos[k].hugoniot_at_velocity(u).ok();
    if eos[0] == eos[1] {
        let half = shock(0, 0.5 * v)?;
        return Some([half, half]);
    }
    let (mut low, mut high) = (1e-6 * v, (1.0 - 1e-6) * v);
    // 1e-4 of the speed is far below what any threshold turns on.
    while high - low > 1e-4 * v {
        let u = 0.5 * (low + high);
        let (first, second) = (shock(0, v - u)?, shock(1, u)?);
        if first.pressure > second.pressure { low = u } else { high = u }
    }
    let u = 0.5 * (low + high);
    Some([shock(0, v - u)?, shock(1, u)?])
}
