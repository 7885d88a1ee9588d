//! What the equation of state says of particles, and how their matter takes it over.
use super::law::Law;
use super::terms::Answer;
use crate::particle::{Matter, Particle};
use hvi_eos::Points;
use hvi_kit::lanes::{Eight, Instructions, Real};

impl Law {
    /// Energy above that of the reference temperature at the same volume [J/kg]: heat that may flow, without the energy of
    /// compression.
    #[inline(always)]
    pub fn thermal_energy<R: Eight>(&self, ratio: R, energy: R) -> R {
        energy - self.isotherm.energy(ratio)
    }

    /// Answers of the equation of state for many particles' `volume` [m3/kg], which is lost, and `energy` [J/kg]; `capped` is room to work.
    pub fn answers(
        &self,
        set: Instructions,
        volume: &mut [f64],
        energy: &[f64],
        out: &mut Points,
        capped: &mut Points,
    ) {
        self.eos.evaluate_with(set, volume, energy, out);
        if volume.iter().any(|&v| v > self.widest) {
            for v in volume.iter_mut() {
                *v = v.min(self.widest);
            }
            self.eos.evaluate_with(set, volume, energy, capped);
            std::mem::swap(&mut out.sound_speed, &mut capped.sound_speed);
        }
    }

    /// Pressure, temperature, sound speed, spall, and what strength needs of them, of one particle.
    pub fn evaluate<const D: usize>(&self, p: &mut Particle<D>) {
        let (mut at, mut capped) = (Points::default(), Points::default());
        let volume = &mut [self.specific_volume(p.ratio)];
        self.answers(Instructions::best(), volume, &[p.energy], &mut at, &mut capped);
        let answer = Answer {
            pressure: at.pressure[0],
            temperature: at.temperature[0],
            sound_speed: at.sound_speed[0],
            liquid: at.liquid[0],
            melting: at.melting[0],
        };
        self.settle(p, &answer);
    }

    /// Specific volume [m3/kg].
    #[inline(always)]
    pub fn specific_volume<R: Real>(&self, ratio: R) -> R {
        ratio.times(self.eos.reference_volume())
    }

    /// Takes over what the equation of state says.
    #[inline(always)]
    pub fn settle<R: Real>(&self, m: &mut Matter<R>, at: &Answer<R>) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let volume = self.specific_volume(m.ratio);
        m.unclamped = at.pressure;
        m.temperature = at.temperature;
        let own = R::of(self.johnson_cook.melting_temperature.si());
        let melting = at.melting.where_less(at.melting, R::of(f64::INFINITY), own);
        let homologous = self.johnson_cook.homologous(at.temperature, melting);
        m.homologous = one.where_less(R::of(0.5), at.liquid, homologous);
        if self.spall.is_some() {
            let failed = m.damage.at_least(1.0);
            m.damage = failed.where_less(at.pressure, zero - self.tension_limit(m), m.damage);
        }
        m.stiffness = at.sound_speed * at.sound_speed / volume * (one - m.open());
        let mut shear = zero;
        m.softening = zero;
        if let Some(modulus) = self.shear {
            // Only what can carry shear: a vapour's V would make any shear term swallow the time step.
            let whole = one - m.failed();
            if (zero - whole).any_less(zero) {
                m.softening = self.johnson_cook.softening(m.homologous) * whole;
            }
            shear = R::of(4.0 / 3.0 * modulus).where_less(zero, m.softening, zero);
        }
        m.sound_speed = (at.sound_speed * at.sound_speed + shear * volume.at_most(self.widest)).root();
    }
}
