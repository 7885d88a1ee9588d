//! Solid, melting band, liquid and hot liquid: V <= V_J, for one state or eight.
//!
//! Free energy F = F_s + excess, where the excess of the liquid over the solid at the same (V, T) is T_m phi(T/T_m), and
//! the melting band joins both by the common tangent to leading order: energy, pressure and entropy are continuous
//! everywhere and dE/dV|_T = T dP/dT|_V - P holds exactly in each regime.
use super::cold::Row;
use super::{Answer, Constants};
use crate::Phase;
use crate::lanes::Real;

/// Everything that depends on volume alone, at one volume (or eight).
#[derive(Clone, Copy)]
pub(super) struct Local<R> {
    per_v: R,
    gamma: R,
    lambda: R,
    e0: R,
    p0: R,
    dp0: R,
    /// Melting temperature [K].
    pub tm: R,
    /// Electronic coefficient [J/kg/K2].
    g: R,
    /// Width of the melting band [J/kg] and its derivatives by V.
    w: R,
    dw: R,
    ddw: R,
}

/// Matter held in one state of aggregation, superheated or undercooled as may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Branch {
    Solid,
    Liquid,
}

/// The excess of the liquid over the solid at the same (V, T): energy [J/kg] and heat capacity [J/kg/K].
#[derive(Clone, Copy)]
struct Excess<R> {
    energy: R,
    heat: R,
}

/// Pressure and what a sound speed takes: see [`Answer`].
#[derive(Clone, Copy)]
pub(super) struct Response<R> {
    pub pressure: R,
    pub p_t: R,
    pub c_v: R,
    pub p_v: R,
    pub liquid: R,
}

impl<R: Real> Local<R> {
    /// From u = V/V0 and the functions of volume there.
    #[inline(always)]
    pub fn new(k: &Constants, u: R, row: [R; 8]) -> Local<R> {
        let gamma = u.plus(-1.0).times(k.gruneisen_slope).plus(k.gruneisen);
        let [e0, p0, dp0, tm, g, w, dw, ddw] = row;
        let lambda = gamma.times(2.0).plus(-2.0 / 3.0);
        Local { per_v: R::of(1.0) / u.times(k.volume), gamma, lambda, e0, p0, dp0, tm, g, w, dw, ddw }
    }

    /// Energy of the solid above E0 [J/kg].
    #[inline(always)]
    fn heat(&self, k: &Constants, t: R) -> R {
        t * (self.g * t.times(0.5)).plus(k.heat)
    }

    /// The liquid's excess at temperature `t`, first kind: up to T_m theta_h.
    #[inline(always)]
    fn excess(&self, k: &Constants, t: R) -> Excess<R> {
        let ratio = t / self.tm;
        let energy = self.tm * (ratio * ratio).times(-0.5 * k.alpha).plus(k.entropy - 0.5 * k.alpha);
        Excess { energy, heat: ratio.times(-k.alpha) }
    }

    /// The hot liquid's excess.
    #[inline(always)]
    fn hot_excess(&self, k: &Constants, t: R) -> Excess<R> {
        Excess { energy: self.tm.times(k.hot_offset) - t.times(k.hot_slope), heat: R::of(-k.hot_slope) }
    }

    /// T/T_m where the melting band begins and where it ends.
    #[inline(always)]
    fn band(&self, k: &Constants) -> [R; 2] {
        let (square, lean) = (k.band_entropy * k.band_entropy, (self.w / self.tm).times(k.alpha));
        let (start, end) = (lean.plus(square).root(), (R::of(square) - lean).root());
        [(R::of(k.entropy) - start).times(1.0 / k.alpha), (R::of(k.entropy) - end).times(1.0 / k.alpha)]
    }

    /// Solid.
    #[inline(always)]
    pub fn solid(&self, k: &Constants, t: R) -> Response<R> {
        let push = (self.gamma * self.per_v).times(k.heat);
        let electrons = (self.g * self.per_v).times(k.electronic_gruneisen) * t;
        let bend = (R::of(k.gruneisen_step) - self.gamma * self.per_v).times(k.heat);
        let inner = bend + electrons.times(0.5 * (k.electronic_gruneisen - 1.0));
        Response {
            pressure: self.p0 + t * (push + electrons.times(0.5)),
            p_t: push + electrons,
            c_v: (self.g * t).plus(k.heat),
            p_v: self.dp0 + t * self.per_v * inner,
            liquid: R::of(0.0),
        }
    }

    /// Liquid of the first kind.
    #[inline(always)]
    pub fn liquid(&self, k: &Constants, t: R) -> Response<R> {
        self.with_liquid(k, t, R::of(1.0), self.excess(k, t))
    }

    /// Hot liquid.
    #[inline(always)]
    pub fn hot(&self, k: &Constants, t: R) -> Response<R> {
        self.with_liquid(k, t, R::of(1.0), self.hot_excess(k, t))
    }

    /// The solid and `share` of the liquid's excess, the share held fixed.
    #[inline(always)]
    fn with_liquid(&self, k: &Constants, t: R, share: R, excess: Excess<R>) -> Response<R> {
        let mut r = self.solid(k, t);
        let pull = self.lambda * self.per_v;
        let bend = (R::of(2.0 * k.gruneisen_step) - pull) * self.per_v;
        r.pressure = r.pressure + share * pull * excess.energy;
        r.p_t = r.p_t + share * pull * excess.heat;
        r.c_v = r.c_v + share * excess.heat;
        r.p_v = r.p_v + share * (bend * excess.energy - pull * pull * (excess.energy - t * excess.heat));
        r.liquid = share;
        r
    }

    /// Melting band: the liquid's excess by its share, the mixing term, and the motion of the share with T and V.
    #[inline(always)]
    pub fn melting(&self, k: &Constants, t: R) -> Response<R> {
        let d = t / self.tm - R::of(1.0);
        let share = self.share(k, d).at_least(0.0).at_most(1.0);
        let excess = self.excess(k, t);
        let mut r = self.with_liquid(k, t, share, excess);
        let rest = R::of(0.5) - share;
        let (mixed, per_w) = ((share * (R::of(1.0) - share)).times(0.5), R::of(1.0) / self.w);
        let pull = self.lambda * self.per_v * excess.energy;
        let entropy = (excess.energy - self.w * rest) / t;
        let moved = pull + self.dw * rest;
        r.pressure = r.pressure + self.dw * mixed;
        r.p_t = r.p_t + entropy * per_w * moved;
        r.c_v = r.c_v + t * entropy * entropy * per_w;
        r.p_v = r.p_v + moved * moved * per_w + self.ddw * mixed;
        r
    }

    /// Share of liquid in the band at `d` = T/T_m - 1.
    #[inline(always)]
    fn share(&self, k: &Constants, d: R) -> R {
        let free = self.tm * d * d.times(0.5 * k.alpha).plus(-k.band_entropy);
        R::of(0.5) - free / self.w
    }

    /// Temperature of the solid at `energy`; 0 below the cold curve.
    #[inline(always)]
    pub fn solid_temperature(&self, k: &Constants, energy: R) -> R {
        root(self.g.times(0.5), R::of(k.heat), energy - self.e0)
    }

    /// Temperature of the liquid of the first kind at `energy`.
    #[inline(always)]
    pub fn liquid_temperature(&self, k: &Constants, energy: R) -> R {
        let a = (self.g - R::of(k.alpha) / self.tm).times(0.5);
        root(a, R::of(k.heat), energy - self.e0 - self.tm.times(k.entropy - 0.5 * k.alpha))
    }

    /// Temperature of the hot liquid at `energy`.
    #[inline(always)]
    pub fn hot_temperature(&self, k: &Constants, energy: R) -> R {
        root(self.g.times(0.5), R::of(k.heat - k.hot_slope), energy - self.e0 - self.tm.times(k.hot_offset))
    }

    /// Coefficients of E - E0 over T_m within the band, a quartic in d = T/T_m - 1.
    ///
    /// With s = dS_m, W = w/T_m, phi = -s d + alpha d^2/2, eps = s - alpha d - alpha d^2/2:
    /// `h (1+d) + G T_m (1+d)^2/2 + (1/2 - phi/W) eps - W/8 + phi^2/(2 W)`, multiplied out.
    #[inline(always)]
    fn quartic(&self, k: &Constants) -> [R; 5] {
        let (s, alpha) = (k.band_entropy, k.alpha);
        let (width, electrons) = (self.w / self.tm, self.g * self.tm);
        let per = R::of(1.0) / width;
        [
            electrons.times(0.5) - width.times(0.125) + R::of(k.heat + 0.5 * s),
            electrons.plus(k.heat - 0.5 * alpha) + per.times(s * s),
            electrons.times(0.5).plus(-0.25 * alpha) + per.times(s * (0.5 * s - 1.5 * alpha)),
            per.times(alpha * (0.5 * alpha - s)),
            per.times(0.375 * alpha * alpha),
        ]
    }

    /// Temperature within the band at `energy`: Newton on the quartic, kept in a shrinking bracket by bisection, each lane at
    /// rest once it has converged. E(T) rises everywhere in the band.
    #[inline(always)]
    pub fn melting_temperature(&self, k: &Constants, energy: R) -> R {
        let c = self.quartic(k);
        let target = (energy - self.e0) / self.tm;
        let [start, end] = self.band(k);
        let (mut low, mut high) = (start.plus(-1.0), end.plus(-1.0));
        let (bottom, top) = (value(&c, low), value(&c, high));
        let mut d = low + (high - low) * ((target - bottom) / (top - bottom)).at_least(0.0).at_most(1.0);
        let (zero, mut open) = (R::of(0.0), R::of(1.0));
        for _ in 0..60 {
            let slope = ((c[4].times(4.0) * d + c[3].times(3.0)) * d + c[2].times(2.0)) * d + c[1];
            let step = (value(&c, d) - target) / slope;
            high = d.where_less(zero, step, high);
            low = low.where_less(zero, step, d);
            let newton = d - step;
            let size = step.where_less(zero, step, zero - step);
            // Newton squares an error relative to the band's width (1e-2 or more): 1e-14 is left after such a step.
            let far = R::of(1.0).where_less(R::of(1e-8), size, zero);
            let middle = (low + high).times(0.5);
            let safe = newton.where_less(low, newton, middle).where_less(newton, high, middle);
            let next = safe.where_less(zero, far, newton);
            d = next.where_less(zero, open, d);
            open = open * far;
            if !zero.any_less(open) {
                break;
            }
        }
        d.plus(1.0) * self.tm
    }
}

/// The quartic `c`, constant first, at `d`.
#[inline(always)]
fn value<R: Real>(c: &[R; 5], d: R) -> R {
    (((c[4] * d + c[3]) * d + c[2]) * d + c[1]) * d + c[0]
}

/// Which formulas hold at one state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Regime {
    Solid,
    Melting,
    Liquid,
    HotLiquid,
}
impl Regime {
    #[inline(always)]
    pub fn phase(self) -> Phase {
        match self {
            Regime::Solid => Phase::Solid,
            Regime::Melting => Phase::Melting,
            Regime::Liquid => Phase::Liquid,
            Regime::HotLiquid => Phase::HotLiquid,
        }
    }
}

impl Local<f64> {
    /// From u = V/V0 and the row of functions there.
    #[inline(always)]
    pub fn at(k: &Constants, u: f64, row: Row) -> Local<f64> {
        Local::new(k, u, row)
    }

    /// Where the melting band begins and ends [K].
    pub fn melting_range(&self, k: &Constants) -> [f64; 2] {
        self.band(k).map(|ratio| ratio * self.tm)
    }

    /// Regime at temperature `t`.
    pub fn regime(&self, k: &Constants, t: f64) -> Regime {
        let [start, end] = self.melting_range(k);
        if t <= start {
            Regime::Solid
        } else if t > k.hot_ratio * self.tm {
            Regime::HotLiquid
        } else if t >= end {
            Regime::Liquid
        } else {
            Regime::Melting
        }
    }

    /// Regime at `energy`. Only near the band are its ends needed: it is never wider than the bounds compared first.
    #[inline(always)]
    pub fn regime_of(&self, k: &Constants, energy: f64) -> Regime {
        let above = energy - self.e0;
        let liquid = |ratio: f64| {
            let t = ratio * self.tm;
            self.heat(k, t) + self.tm * (k.entropy - 0.5 * k.alpha * (1.0 + ratio * ratio))
        };
        if above < self.heat(k, k.surely_solid * self.tm) {
            return Regime::Solid;
        }
        if above > self.heat(k, k.hot_ratio * self.tm) + self.tm * (k.hot_offset - k.hot_slope * k.hot_ratio) {
            return Regime::HotLiquid;
        }
        if above > liquid(k.surely_liquid) {
            return Regime::Liquid;
        }
        let [start, end] = self.band(k);
        if above <= self.heat(k, start * self.tm) {
            Regime::Solid
        } else if above >= liquid(end) {
            Regime::Liquid
        } else {
            Regime::Melting
        }
    }

    /// Temperature at `energy` if all were solid, or all liquid (hot or not), stable or not.
    pub fn branch_temperature(&self, k: &Constants, energy: f64, branch: Branch) -> f64 {
        if branch == Branch::Solid {
            return self.solid_temperature(k, energy);
        }
        let hot = self.hot_temperature(k, energy);
        if hot > k.hot_ratio * self.tm { hot } else { self.liquid_temperature(k, energy) }
    }

    /// Everything at temperature `t` in `regime`.
    pub fn answer(&self, k: &Constants, t: f64, regime: Regime) -> Answer {
        let heat = self.e0 + self.heat(k, t);
        let (energy, r) = match regime {
            Regime::Solid => (heat, self.solid(k, t)),
            Regime::Liquid => (heat + self.excess(k, t).energy, self.liquid(k, t)),
            Regime::HotLiquid => (heat + self.hot_excess(k, t).energy, self.hot(k, t)),
            Regime::Melting => {
                let r = self.melting(k, t);
                let mixed = 0.5 * self.w * r.liquid * (1.0 - r.liquid);
                (heat + r.liquid * self.excess(k, t).energy - mixed, r)
            }
        };
        Answer { energy, pressure: r.pressure, p_t: r.p_t, c_v: r.c_v, p_v: r.p_v, liquid: r.liquid }
    }
}

/// The non-negative root T of `a T^2 + b T = c` with b > 0, in the form that does not cancel; 0 where c <= 0.
///
/// Where a < 0 and no root is real (c beyond the parabola's top), the top: the caller sees it is beyond its regime.
#[inline(always)]
pub(super) fn root<R: Real>(a: R, b: R, c: R) -> R {
    let c = c.at_least(0.0);
    c.times(2.0) / (b + (b * b + (a * c).times(4.0)).at_least(0.0).root())
}
