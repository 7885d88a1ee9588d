//! The vapour, V > V_J: Young and Alder's van der Waals gas of hard spheres, joined to the hot liquid at V_J.
use super::dense::root;
use super::parameters::Parameters;
use super::{Answer, Constants};

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
        let [e, p_] = [liquid.energy, liquid.pressure];
        // F_E at infinite volume.
        let far = -vj * (p.joining - packing) / (2.0 * p.joining);
        let attraction = (p.cohesive_energy - e[0] - far * p_[0]) / (1.0 / vj + far / (vj * vj));
        Vapour {
            covolume,
            packing,
            attraction,
            c: [p_[0] + attraction / (vj * vj), p_[1] - k.gas * compressibility(packing).0 / vj, p_[2]],
            d: [e[0] + attraction / vj, e[1] - 1.5 * k.gas, e[2]],
        }
    }

    /// F_p and F_E = -Int F_p dV from V_J [m3/kg]; the general form, for any theta.
    pub fn joining(&self, theta: f64, v: f64) -> (f64, f64) {
        let (z, zj) = (self.covolume / v, self.packing);
        let gap = theta - zj;
        let r = z * gap / (zj * (theta - z));
        let scale = self.covolume * (gap / zj) * (gap / zj) * (gap / zj) / 2.0;
        let shape = |z: f64| (2.0 * z - theta) / ((theta - z) * (theta - z));
        (r * r * r, scale * (shape(z) - shape(zj)))
    }

    /// Temperature [K] at `energy`; 0 where there is less than the vapour's cold energy.
    pub fn temperature(&self, p: &Parameters, k: &Constants, v: f64, energy: f64) -> f64 {
        let (_, f_e) = self.joining(p.joining, v);
        let cold = f_e * self.c[0] + self.d[0] - self.attraction / v;
        root(self.d[2] - self.c[2] * f_e, 1.5 * k.gas + self.d[1], energy - cold)
    }

    /// Everything at (V, T).
    pub fn answer(&self, p: &Parameters, k: &Constants, v: f64, t: f64) -> Answer {
        let (f_p, f_e) = self.joining(p.joining, v);
        let z = self.covolume / v;
        let (factor, slope) = compressibility(z);
        let [c1, c2, c3] = self.c;
        let [d1, d2, d3] = self.d;
        let per_v = 1.0 / v;
        let joined = f_p * (c1 + t * (c2 + t * c3));
        let ideal = k.gas * t * per_v;
        Answer {
            energy: (1.5 * k.gas + d2) * t - self.attraction * per_v + f_e * (c1 - c3 * t * t) + d1 + d3 * t * t,
            pressure: ideal * factor - self.attraction * per_v * per_v + joined,
            p_t: k.gas * factor * per_v + f_p * (c2 + 2.0 * c3 * t),
            c_v: 1.5 * k.gas + d2 + 2.0 * (d3 - c3 * f_e) * t,
            p_v: per_v
                * (-ideal * (factor + z * slope) + 2.0 * self.attraction * per_v * per_v
                    - 3.0 * p.joining / (p.joining - z) * joined),
            liquid: 1.0,
        }
    }
}

/// Carnahan and Starling's compressibility factor Z(z) and dZ/dz.
fn compressibility(z: f64) -> (f64, f64) {
    let (top, gap) = (1.0 + z * (1.0 + z * (1.0 - z)), 1.0 / (1.0 - z));
    let value = top * gap * gap * gap;
    (value, value * ((1.0 + z * (2.0 - 3.0 * z)) / top + 3.0 * gap))
}
