//! Johnson-Cook flow stress with implicit radial return.
use hvi_kit::lanes::{Real, log, pow};
use hvi_kit::units::{Pressure, Rate, Temperature};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `Y = (A + B ep^n) (1 + C ln(rate / rate0)) (1 - T*^m)`, `T* = (T - T_r) / (T_m - T_r)`.
///
/// The rate factor is 1 below rate0 and the thermal one 1 below T_r, 0 above T_m. Source: G. R. Johnson and W. H. Cook,
/// 7th Int. Symp. Ballistics (1983); Liu, Wang & Zhang (2013) eqs 17-18, where eq 17 lacks the exponent n.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JohnsonCook {
    /// A.
    pub a: Pressure,
    /// B.
    pub b: Pressure,
    /// n.
    pub n: f64,
    /// C.
    pub c: f64,
    /// m.
    pub m: f64,
    /// Reference rate.
    #[serde(default = "reference_rate")]
    pub rate: Rate,
    /// T_r.
    #[serde(default = "reference_temperature")]
    pub reference_temperature: Temperature,
    /// T_m where the equation of state knows no melting.
    pub melting_temperature: Temperature,
}

fn reference_rate() -> Rate {
    Rate::new(1.0)
}
fn reference_temperature() -> Temperature {
    Temperature::new(293.0)
}

impl JohnsonCook {
    /// `T*`: 0 or less when cold, 1 or more when melted; `melting` T_m [K].
    #[inline(always)]
    pub fn homologous<R: Real>(&self, temperature: R, melting: R) -> R {
        let room = self.reference_temperature.si();
        let range = melting.plus(-room);
        (temperature.plus(-room) / range).where_less(R::of(0.0), range, R::of(1.0))
    }

    /// `1 - T*^m`, in 0..1.
    #[inline(always)]
    pub fn softening<R: Real>(&self, homologous: R) -> R {
        let hot = R::of(1.0) - pow(homologous.at_least(LEAST).at_most(1.0), self.m);
        hot.where_less(homologous, R::of(1.0), R::of(0.0))
    }

    /// `A + B ep^n` [Pa].
    #[inline(always)]
    pub fn hardened<R: Real>(&self, strain: R) -> R {
        pow(strain.at_least(LEAST), self.n).times(self.b.si()).plus(self.a.si())
    }

    /// `1 + C ln(rate / rate0)`, 1 below rate0.
    #[inline(always)]
    pub fn rate_factor<R: Real>(&self, rate: R) -> R {
        if self.c == 0.0 {
            return R::of(1.0);
        }
        log(rate.times(1.0 / self.rate.si()).at_least(1.0)).times(self.c).plus(1.0)
    }

    /// Y [Pa].
    pub fn flow_stress(&self, strain: f64, rate: f64, softening: f64) -> f64 {
        if softening == 0.0 { 0.0 } else { self.hardened(strain) * self.rate_factor(rate) * softening }
    }

    /// Plastic strain increment x that brings an elastic `trial` equivalent stress [Pa] back to the yield surface at the
    /// end of the step: `trial - 3 G x = Y(strain + x, x / dt)`, with shear modulus `shear` G [Pa]. 0 where the trial lies on or
    /// below `first`, Y at the start and the reference rate [Pa].
    ///
    /// With it comes `A + B ep^n` at the end [Pa], `hardened` where nothing happens.
    ///
    /// Halley's rule inside a bracket; the left side falls and the right one rises with x, so the root is single. The last step is
    /// taken without looking at where it leads: what its third order leaves is bounded by that of the powers of x and of the
    /// strain.
    #[inline(always)]
    pub fn plastic_increment<R: Real>(
        &self,
        trial: R,
        strain: R,
        first: R,
        dt: f64,
        softening: R,
        shear: f64,
        mut hardened: R,
    ) -> (R, R) {
        let (stiffness, zero, one) = (3.0 * shear, R::of(0.0), R::of(1.0));
        let (mut low, mut high) = (zero, trial.times(1.0 / stiffness));
        let mut x = (trial - first).times(1.0 / stiffness).at_least(0.0);
        // 1 where still sought.
        let mut open = one.where_less(first, trial, zero);
        for _ in 0..60 {
            if !zero.any_less(open) {
                break;
            }
            let total = strain + x;
            let (per_strain, per_x) = (one / total.at_least(LEAST), one / x.at_least(LEAST));
            let bar = self.hardened(total);
            let factor = self.rate_factor(x.times(1.0 / dt));
            let excess = trial - x.times(stiffness) - bar * factor * softening;
            low = x.where_less(zero, excess, low);
            high = high.where_less(zero, excess, x);
            // Slopes by x of the bar (over 1), and of the factor where it acts; then what both bend.
            let hardening = bar.plus(-self.a.si()).times(self.n) * per_strain;
            let rate = per_x.times(self.c);
            let acting = rate.where_less(one, factor, zero);
            let curving = hardening.times(self.n - 1.0) * per_strain;
            let slope = ((hardening * factor + bar * acting) * softening).plus(stiffness);
            let bend = (curving * factor + (hardening.times(2.0) - bar * per_x) * acting) * softening;
            let plain = excess / slope;
            let step = plain / ((bend * plain).times(0.5) / slope).plus(1.0).at_least(0.5);
            let (next, middle) = (x + step, (low + high).times(0.5));
            let within = one.where_less(low, next, zero).where_less(next, high, zero);
            let next = next.where_less(zero, within, middle);
            let close = trial.times(1e-10);
            let remainder =
                (curving.size() * factor + (hardening.times(2.0) + bar * per_x) * rate) * step * step * step * per_x;
            let sure = one.where_less(remainder.size(), close.min(bar.times(1e-10)), zero) * within;
            // What is there stays; else it takes the step, for the last time where that is sure.
            let there = zero.where_less(close, excess.size(), one);
            let moves = open * (one - there);
            let change = next - x;
            let after = bar + change * (hardening + (curving * change).times(0.5));
            hardened = bar.where_less(zero, open * there, hardened);
            hardened = after.where_less(zero, moves, hardened);
            x = next.where_less(zero, moves, x);
            open = (moves * (one - sure)).where_less(high.times(1e-15), high - low, zero);
        }
        (x, hardened)
    }
}

/// Stands for 0 where a power of a positive number is wanted: to a power of .1 it is 1e-30.
const LEAST: f64 = 1e-300;

#[cfg(test)]
mod tests {
    use super::super::Material;

    /// At T* >= 1 nothing is left; at any rate from 1e-30 to 1e8 per second and any strain the stress is finite.
    #[test]
    fn limits() {
        let jc = Material::named("copper").unwrap().strength;
        let room = jc.reference_temperature.si();
        for (t, melting) in [(1356.0, 1356.0), (1356.0 - 1e-10, 1356.0), (2712.0, 1356.0), (0.0, 1356.0), (400.0, room)]
        {
            let softening = jc.softening(jc.homologous(t, melting));
            assert!((0.0..=1.0).contains(&softening));
            assert_eq!(softening == 0.0, t >= melting || melting <= room, "{t}");
            for rate in [1e-30, 1e-10, 1.0, 1e4, 1e8] {
                for strain in [0.0, 1e-12, 0.1, 5.0] {
                    let y = jc.flow_stress(strain, rate, softening);
                    assert!(y.is_finite() && y >= 0.0 && (softening > 0.0 || y == 0.0));
                }
            }
        }
        assert_eq!(jc.rate_factor(1.0), 1.0);
        assert_eq!(jc.rate_factor(1e-30), 1.0);
    }

    /// The return lands on the yield surface it was asked for, from any trial stress, strain and step.
    #[test]
    fn return_lands_on_the_surface() {
        for name in ["copper", "aluminium"] {
            let jc = Material::named(name).unwrap().strength;
            let shear = 40e9;
            for trial in [1e6, 1e8, 3.3e8, 1e9, 5e10] {
                for strain in [0.0, 1e-9, 1e-3, 2.0] {
                    for dt in [1e-12, 1e-9, 1e3] {
                        for softening in [0.0, 1e-6, 0.7, 1.0] {
                            let first = jc.flow_stress(strain, 0.0, softening);
                            if trial <= first {
                                continue;
                            }
                            let (x, hardened) = jc.plastic_increment(trial, strain, first, dt, softening, shear, 0.0);
                            let y = jc.flow_stress(strain + x, x / dt, softening);
                            let left = trial - 3.0 * shear * x;
                            assert!(x > 0.0 && (left - y).abs() <= 1e-9 * trial, "{trial} {strain} {dt}: {left} {y}");
                            assert!((hardened / jc.hardened(strain + x) - 1.0).abs() < 1e-9);
                        }
                    }
                }
            }
        }
    }
}
