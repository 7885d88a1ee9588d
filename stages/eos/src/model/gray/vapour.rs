//! The vapour, V > V_J: Young and Alder's van der Waals gas of hard spheres, joined to the hot liquid at V_J.
use super::Constants;
use super::dense::Response;
use super::dense::root;
use super::parameters::Parameters;
use crate::lanes::Real;

/// Constants of the vapour: attraction a_y and the joining coefficients.
///
/// With `z = V_b/V`: `P = R'T Z(z)/V - a_y/V^2 + F_p (C1 + C2 T + C3 T^2)`, and E the energy that goes with it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Vapour {
    covolume: f64,
    /// z at V_J.
    packing: f64,
    /// a_y [J m3/kg2].
    pub attraction: f64,
    /// F_E = scale (shape(z) - start).
    scale: f64,
    start: f64,
    c: [f64; 3],
    d: [f64; 3],
}

/// What the hot liquid is at V_J, as polynomials in T: E = e0 + e1 T + e2 T^2, P = p0 + p1 T + p2 T^2.
pub(super) struct Join {
    pub volume: f64,
    pub energy: [f64; 3],
    pub pressure: [f64; 3],
}

impl Vapour {
    /// Joins `liquid`; `cohesive_energy` of the parameters fixes the attraction.
    pub fn new(p: &Parameters, k: &Constants, liquid: &Join) -> Vapour {
        let vj = liquid.volume;
        let covolume = p.covolume_ratio * p.volume;
        let packing = covolume / vj;
        let gap = p.joining - packing;
        let [e, p_] = [liquid.energy, liquid.pressure];
        // F_E at infinite volume.
        let far = -vj * (p.joining - packing) / (2.0 * p.joining);
        let attraction = (p.cohesive_energy - e[0] - far * p_[0]) / (1.0 / vj + far / (vj * vj));
        Vapour {
            covolume,
            packing,
            attraction,
            scale: covolume * (gap / packing) * (gap / packing) * (gap / packing) / 2.0,
            start: (2.0 * packing - p.joining) / (gap * gap),
            c: [p_[0] + attraction / (vj * vj), p_[1] - k.gas * compressibility(packing).0 / vj, p_[2]],
            d: [e[0] + attraction / vj, e[1] - 1.5 * k.gas, e[2]],
        }
    }

    /// Temperature [K] at `energy` and F_p, F_E at `v`; 0 K where there is less than the vapour's cold energy.
    #[inline(always)]
    pub fn temperature<R: Real>(&self, k: &Constants, v: R, energy: R) -> R {
        let (_, f_e) = self.joins(k.joining, v);
        let cold = f_e.times(self.c[0]).plus(self.d[0]) - R::of(self.attraction) / v;
        root(f_e.times(-self.c[2]).plus(self.d[2]), R::of(1.5 * k.gas + self.d[1]), energy - cold)
    }

    /// Energy [J/kg] at (V, T).
    pub fn energy(&self, k: &Constants, v: f64, t: f64) -> f64 {
        let (_, f_e) = self.joins(k.joining, v);
        let ([c1, _, c3], [d1, d2, d3]) = (self.c, self.d);
        (1.5 * k.gas + d2) * t - self.attraction / v + f_e * (c1 - c3 * t * t) + d1 + d3 * t * t
    }

    /// Critical temperature of the gas without what joins it to the liquid [K]: the hottest at which `R'T Z(z)/V - a_y/V^2` is flat
    /// somewhere, `T = 2 a_y z/(V_b R' (Z + z Z'))`.
    pub fn critical_temperature(&self, k: &Constants) -> f64 {
        let flat = |i: i32| {
            let z = self.packing * f64::from(i) / 200.0;
            let (factor, slope) = compressibility(z);
            2.0 * self.attraction * z / (self.covolume * k.gas * (factor + z * slope))
        };
        (1..=200).map(flat).fold(0.0, f64::max)
    }

    /// Pressure and its derivatives at (V, T).
    #[inline(always)]
    pub fn response<R: Real>(&self, k: &Constants, v: R, t: R) -> Response<R> {
        let (f_p, f_e) = self.joins(k.joining, v);
        let z = R::of(self.covolume) / v;
        let (factor, slope) = compressibility(z);
        let per_v = R::of(1.0) / v;
        let joined = f_p * (t * t.times(self.c[2]).plus(self.c[1])).plus(self.c[0]);
        let ideal = t.times(k.gas) * per_v;
        let pull = (per_v * per_v).times(self.attraction);
        let fall = joined.times(3.0 * k.joining) / (R::of(k.joining) - z);
        Response {
            pressure: ideal * factor - pull + joined,
            p_t: (factor * per_v).times(k.gas) + f_p * t.times(2.0 * self.c[2]).plus(self.c[1]),
            c_v: (f_e.times(-self.c[2]).plus(self.d[2]) * t).times(2.0).plus(1.5 * k.gas + self.d[1]),
            p_v: per_v * (pull.times(2.0) - ideal * (factor + z * slope) - fall),
            liquid: R::of(1.0),
        }
    }

    /// F_p and F_E = -Int F_p dV from V_J [m3/kg]; the general form, for any theta.
    #[inline(always)]
    pub fn joins<R: Real>(&self, theta: f64, v: R) -> (R, R) {
        let (z, gap) = (R::of(self.covolume) / v, theta - self.packing);
        let open = R::of(theta) - z;
        let r = z.times(gap / self.packing) / open;
        let shape = z.times(2.0).plus(-theta) / (open * open);
        (r * r * r, shape.plus(-self.start).times(self.scale))
    }
}

/// Carnahan and Starling's compressibility factor Z(z) and dZ/dz.
#[inline(always)]
fn compressibility<R: Real>(z: R) -> (R, R) {
    let one = R::of(1.0);
    let (top, gap) = (one + z * (one + z * (one - z)), one / (one - z));
    let value = top * gap * gap * gap;
    (value, value * ((one + z * (R::of(2.0) - z.times(3.0))) / top + gap.times(3.0)))
}
