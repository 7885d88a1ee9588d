//! Phase of matter that has parted, by its energy alone: at the volume that it has itself it bears no pressure.
use hvi_eos::{Eos, Phase};

/// Energies at which the phase at no pressure changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Released {
    /// Of the coldest.
    first: Phase,
    /// Energies [J/kg], rising, and the phase from there on.
    borders: Vec<(f64, Phase)>,
}

/// Volume over the reference one that has room for all matter at no pressure.
const WIDE: f64 = 20.0;
/// Energies looked at up to the square of the sound speed, at which metals are beyond their critical points.
const LOOKS: usize = 256;
/// To what share of the energy between two looks a border is found.
const SHARE: f64 = 1e-9;

impl Released {
    /// Of `eos`.
    pub fn new(eos: &Eos) -> Released {
        let volume = eos.reference_volume();
        let phase = |energy: f64| eos.point(eos.relaxed_volume(WIDE * volume, energy), energy).phase;
        let cold = eos.energy_at(volume, eos.reference_temperature()).max(0.0);
        let speed = eos.point(volume, cold).sound_speed;
        let step = speed * speed / LOOKS as f64;
        let (first, mut last) = (phase(0.0), phase(0.0));
        let mut borders = Vec::new();
        for look in 0..LOOKS {
            let (mut from, end) = (step * look as f64, step * (look + 1) as f64);
            let beyond = phase(end);
            while last != beyond {
                let mut to = end;
                while to - from > SHARE * step {
                    let middle = 0.5 * (from + to);
                    if phase(middle) == last { from = middle } else { to = middle }
                }
                (from, last) = (to, phase(to));
                borders.push((to, last));
            }
        }
        Released { first, borders }
    }

    /// At `energy` [J/kg].
    pub fn phase(&self, energy: f64) -> Phase {
        self.borders.iter().rev().find(|border| border.0 <= energy).map_or(self.first, |border| border.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;

    /// Matter in tension has the phase of its relaxed volume, from cold to far beyond boiling; within 1e-6 of a border it may be either's.
    #[test]
    fn the_phase_is_that_of_the_relaxed_volume() {
        for name in Material::NAMES {
            let eos = Material::named(name).expect("shipped").eos;
            let released = Released::new(&eos);
            assert!(released.borders.len() >= 2, "{released:?}");
            let mut torn = 0;
            for i in 0..2000 {
                let (energy, volume) =
                    (4e3 * f64::from(i) + 0.1, (1.0 + 0.01 * f64::from(i % 400)) * eos.reference_volume());
                if eos.point(volume, energy).pressure >= 0.0 {
                    continue;
                }
                let intact = eos.point(eos.relaxed_volume(volume, energy), energy).phase;
                let near = released.borders.iter().any(|border| (border.0 / energy - 1.0).abs() < 1e-6);
                assert!(near || released.phase(energy) == intact, "{name}: {energy} J/kg at {volume} m3/kg");
                torn += 1;
            }
            assert!(torn > 100, "{torn}");
        }
    }
}
