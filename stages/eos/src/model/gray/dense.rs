//! Solid, melting band, liquid and hot liquid: V <= V_J.
//!
//! Free energy F = F_s + excess, where the excess of the liquid over the solid at the same (V, T) is T_m phi(T/T_m), and
//! the melting band joins both by the common tangent to leading order: energy, pressure and entropy are continuous
//! everywhere and dE/dV|_T = T dP/dT|_V - P holds exactly in each regime.
use super::parameters::Parameters;
use super::{Answer, Constants};
use crate::Phase;
use crate::model::table::Table;

/// Everything that depends on volume alone, at one volume.
#[derive(Clone, Copy)]
pub(super) struct Local {
    v: f64,
    x: f64,
    /// E0 [J/kg], P0 [Pa], dP0/dV.
    e0: f64,
    p0: f64,
    dp0: f64,
    gamma: f64,
    lambda: f64,
    /// Melting temperature [K].
    pub tm: f64,
    /// Electronic coefficient [J/kg/K2].
    g: f64,
}

/// Matter held in one state of aggregation, superheated or undercooled as may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Branch {
    Solid,
    Liquid,
}

/// A regime at one volume, with what the melting band needs.
pub(super) enum Regime {
    Solid,
    Melting(Band),
    Liquid,
    HotLiquid,
}
impl Regime {
    #[inline]
    pub fn phase(&self) -> Phase {
        match self {
            Regime::Solid => Phase::Solid,
            Regime::Melting(_) => Phase::Melting,
            Regime::Liquid => Phase::Liquid,
            Regime::HotLiquid => Phase::HotLiquid,
        }
    }
}

/// The melting band at one volume: its width w [J/kg], dw/dV, d2w/dV2, and its ends in T/T_m.
pub(super) struct Band {
    w: f64,
    dw: f64,
    ddw: f64,
    start: f64,
    end: f64,
}

/// The excess of the liquid over the solid at the same (V, T).
struct Excess {
    /// Energy [J/kg].
    energy: f64,
    /// Heat capacity [J/kg/K].
    heat: f64,
}

impl Local {
    #[inline]
    pub fn at(p: &Parameters, k: &Constants, table: &Table<3>, u: f64) -> Local {
        let [cold, melting, electronic] = table.at(u);
        let x = 1.0 - u;
        let per_v0 = k.per_volume;
        let gamma = p.gruneisen - p.gruneisen_slope * x;
        Local {
            v: u * p.volume,
            x,
            e0: cold[0],
            p0: -cold[1] * per_v0,
            dp0: -cold[2] * per_v0 * per_v0,
            gamma,
            lambda: 2.0 * gamma - 2.0 / 3.0,
            tm: melting[0],
            g: electronic[0],
        }
    }

    /// Energy of the solid formula [J/kg].
    fn solid_energy(&self, k: &Constants, t: f64) -> f64 {
        self.e0 + t * (k.heat + 0.5 * self.g * t)
    }

    /// The liquid's excess at temperature `t`: first kind up to T_m theta_h, hot beyond.
    #[inline]
    fn excess(&self, k: &Constants, t: f64, hot: bool) -> Excess {
        if hot {
            Excess { energy: self.tm * k.hot_offset - k.hot_slope * t, heat: -k.hot_slope }
        } else {
            let ratio = t / self.tm;
            Excess { energy: self.tm * (k.entropy - 0.5 * k.alpha * (1.0 + ratio * ratio)), heat: -k.alpha * ratio }
        }
    }

    /// The melting band. Its width comes from the lever rule for a small volume change; the fourth root bounds it.
    fn band(&self, p: &Parameters, k: &Constants) -> Band {
        let x = self.x.min(k.cap);
        let (left, right) = (1.0 + p.slope * x, 1.0 / (1.0 - p.slope * x));
        let u = 1.0 - x;
        let per_v = 1.0 / self.v;
        let stiffness = p.sound_speed * p.sound_speed * u * u * left * right * right * right;
        let relative = self.lambda * self.lambda * k.band_entropy * self.tm / stiffness;
        let fourth = 16.0 * (relative * relative) * (relative * relative);
        let q = 1.0 / (1.0 + fourth);
        let w = k.band_entropy * self.tm * relative * q.sqrt().sqrt();
        // Logarithmic derivatives by V: of the stiffness (constant beyond the cap), of `relative`, of w.
        let per_v0 = k.per_volume;
        let (mut stiff1, mut stiff2) = (0.0, 0.0);
        if self.x < k.cap {
            let s = p.slope;
            stiff1 = -per_v0 * (-2.0 / u + s / left + 3.0 * s * right);
            stiff2 = per_v0 * per_v0 * (-2.0 / (u * u) - s * s / (left * left) + 3.0 * s * s * right * right);
        }
        let dlambda = 2.0 * p.gruneisen_slope * per_v0 / self.lambda;
        let log1 = 2.0 * dlambda - self.lambda * per_v - stiff1;
        let slide = self.lambda * per_v * (per_v - dlambda);
        let log2 = -2.0 * dlambda * dlambda + slide - stiff2;
        let first = -self.lambda * per_v + q * log1;
        let second = slide + q * log2 - 4.0 * q * (1.0 - q) * log1 * log1;
        let lean = k.alpha * w / self.tm;
        let discriminant = k.band_entropy * k.band_entropy;
        Band {
            w,
            dw: w * first,
            ddw: w * (second + first * first),
            start: (k.entropy - (discriminant + lean).sqrt()) / k.alpha,
            end: (k.entropy - (discriminant - lean).sqrt()) / k.alpha,
        }
    }

    /// Share of liquid within the band.
    fn share(&self, k: &Constants, band: &Band, t: f64) -> f64 {
        let ratio = t / self.tm;
        0.5 - self.tm * (ratio - 1.0) * (0.5 * k.alpha * (ratio + 1.0) - k.entropy) / band.w
    }

    /// Energy and heat capacity within the band.
    fn band_energy(&self, k: &Constants, band: &Band, t: f64) -> (f64, f64) {
        let share = self.share(k, band, t);
        let excess = self.excess(k, t, false);
        let free = band.w * (0.5 - share);
        let entropy = (excess.energy - free) / t;
        let energy = self.solid_energy(k, t) + share * excess.energy - 0.5 * band.w * share * (1.0 - share);
        (energy, k.heat + self.g * t + share * excess.heat + t * entropy * entropy / band.w)
    }

    /// Temperature [K] and regime at `energy`; T = 0 below the cold curve.
    #[inline]
    pub fn temperature(&self, p: &Parameters, k: &Constants, energy: f64) -> (f64, Regime) {
        let solid = root(0.5 * self.g, k.heat, energy - self.e0);
        if solid < k.surely_solid * self.tm {
            return (solid, Regime::Solid);
        }
        let hot = root(0.5 * self.g, k.heat - k.hot_slope, energy - self.e0 - self.tm * k.hot_offset);
        if hot > k.hot_ratio * self.tm {
            return (hot, Regime::HotLiquid);
        }
        let offset = self.tm * (k.entropy - 0.5 * k.alpha);
        let liquid = root(0.5 * (self.g - k.alpha / self.tm), k.heat, energy - self.e0 - offset);
        if liquid > k.surely_liquid * self.tm {
            return (liquid, Regime::Liquid);
        }
        let band = self.band(p, k);
        if solid <= band.start * self.tm {
            (solid, Regime::Solid)
        } else if liquid >= band.end * self.tm {
            (liquid, Regime::Liquid)
        } else {
            (self.band_temperature(k, &band, energy), Regime::Melting(band))
        }
    }

    /// Root of the energy within the band: Newton, kept in a shrinking bracket by bisection. E(T) rises everywhere in it.
    fn band_temperature(&self, k: &Constants, band: &Band, energy: f64) -> f64 {
        let (mut low, mut high) = (band.start * self.tm, band.end * self.tm);
        let (bottom, top) = (self.band_energy(k, band, low).0, self.band_energy(k, band, high).0);
        let mut t = low + (high - low) * ((energy - bottom) / (top - bottom)).clamp(0.0, 1.0);
        for _ in 0..60 {
            let (e, heat) = self.band_energy(k, band, t);
            let off = e - energy;
            if off > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - off / heat;
            // Newton squares the error relative to the band's width (1e-2 T or more): 1e-14 T is left after such a step.
            if (newton - t).abs() <= 1e-8 * t {
                return newton;
            }
            t = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        t
    }

    /// Temperature at `energy` if all were solid, or all liquid (hot or not), stable or not.
    pub fn branch_temperature(&self, k: &Constants, energy: f64, branch: Branch) -> f64 {
        if branch == Branch::Solid {
            return root(0.5 * self.g, k.heat, energy - self.e0);
        }
        let hot = root(0.5 * self.g, k.heat - k.hot_slope, energy - self.e0 - self.tm * k.hot_offset);
        if hot > k.hot_ratio * self.tm {
            return hot;
        }
        let offset = self.tm * (k.entropy - 0.5 * k.alpha);
        root(0.5 * (self.g - k.alpha / self.tm), k.heat, energy - self.e0 - offset)
    }

    /// Regime at temperature `t`.
    pub fn regime(&self, p: &Parameters, k: &Constants, t: f64) -> Regime {
        if t < k.surely_solid * self.tm {
            return Regime::Solid;
        }
        if t > k.hot_ratio * self.tm {
            return Regime::HotLiquid;
        }
        let band = self.band(p, k);
        if t <= band.start * self.tm {
            Regime::Solid
        } else if t >= band.end * self.tm {
            Regime::Liquid
        } else {
            Regime::Melting(band)
        }
    }

    /// Where the melting band begins and ends [K].
    pub fn melting_range(&self, p: &Parameters, k: &Constants) -> (f64, f64) {
        let band = self.band(p, k);
        (band.start * self.tm, band.end * self.tm)
    }

    /// Everything at temperature `t` in `regime`.
    #[inline]
    pub fn answer(&self, p: &Parameters, k: &Constants, t: f64, regime: &Regime) -> Answer {
        let per_v = 1.0 / self.v;
        let gamma_v = self.gamma * per_v;
        let dgamma = p.gruneisen_slope * k.per_volume;
        let electrons = p.electronic_gruneisen * self.g * per_v;
        let mut answer = Answer {
            energy: self.solid_energy(k, t),
            pressure: self.p0 + t * (k.heat * gamma_v + 0.5 * electrons * t),
            p_t: k.heat * gamma_v + electrons * t,
            c_v: k.heat + self.g * t,
            p_v: self.dp0
                + k.heat * t * (dgamma - gamma_v) * per_v
                + 0.5 * (p.electronic_gruneisen - 1.0) * electrons * per_v * t * t,
            liquid: 0.0,
        };
        match regime {
            Regime::Solid => {}
            Regime::Melting(band) => self.add_band(p, k, band, t, &mut answer),
            Regime::Liquid | Regime::HotLiquid => {
                let excess = self.excess(k, t, matches!(regime, Regime::HotLiquid));
                self.add_liquid(p, k, t, 1.0, &excess, &mut answer);
                answer.liquid = 1.0;
            }
        }
        answer
    }

    /// Adds `share` of the liquid's excess, the share held fixed.
    #[inline]
    fn add_liquid(&self, p: &Parameters, k: &Constants, t: f64, share: f64, excess: &Excess, answer: &mut Answer) {
        let per_v = 1.0 / self.v;
        let pull = self.lambda * per_v;
        let dpull = (2.0 * p.gruneisen_slope * k.per_volume - pull) * per_v;
        answer.energy += share * excess.energy;
        answer.pressure += share * pull * excess.energy;
        answer.p_t += share * pull * excess.heat;
        answer.c_v += share * excess.heat;
        answer.p_v += share * (dpull * excess.energy - pull * pull * (excess.energy - t * excess.heat));
    }

    /// Adds the band: the liquid's excess by its share, the mixing term, and the motion of the share with T and V.
    fn add_band(&self, p: &Parameters, k: &Constants, band: &Band, t: f64, answer: &mut Answer) {
        let share = self.share(k, band, t).clamp(0.0, 1.0);
        let excess = self.excess(k, t, false);
        self.add_liquid(p, k, t, share, &excess, answer);
        let (mixed, lean) = (share * (1.0 - share), 0.5 * (1.0 - 2.0 * share));
        let pull = self.lambda / self.v * excess.energy;
        let entropy = (excess.energy - band.w * (0.5 - share)) / t;
        let share_t = entropy / band.w;
        let share_v = (pull + (0.5 - share) * band.dw) / band.w;
        answer.energy -= 0.5 * band.w * mixed;
        answer.pressure += 0.5 * band.dw * mixed;
        answer.p_t += share_t * (pull + band.dw * lean);
        answer.c_v += t * entropy * share_t;
        answer.p_v += share_v * (pull + band.dw * lean) + 0.5 * band.ddw * mixed;
        answer.liquid = share;
    }
}

/// The non-negative root T of `a T^2 + b T = c` with b > 0, in the form that does not cancel; 0 where c <= 0.
///
/// Where a < 0 and no root is real (c beyond the parabola's top), the top: the caller sees it is beyond its regime.
#[inline]
pub(super) fn root(a: f64, b: f64, c: f64) -> f64 {
    let c = c.max(0.0);
    2.0 * c / (b + (b * b + 4.0 * a * c).max(0.0).sqrt())
}
