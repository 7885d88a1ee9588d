//! Functions of volume alone: the cold curve, the melting temperature and the electronic heat, tabulated.
use super::parameters::Parameters;
use crate::model::table::{Jet, Table};
use hvi_kit::math::{exp, log};

/// Intervals of the table a unit of V/V0. The cold curve steepens towards the pole at x = 1/S; at 0.92/S this many keep
/// its interpolation error near 1e-9 of the value, at x = 0.5 below 1e-12; more would not fit the first-level cache.
const PER_UNIT: f64 = 320.0;

/// E0 [J/kg], T_m [K] and G [J/kg/K2] over u = V/V0, from the densest state to V_J.
///
/// E0 solves `dE0/dx = Q + gamma/(1-x) E0`, x = 1 - u (the cold curve whose Hugoniot is Us = C + S up): between nodes
/// by Gauss-Legendre quadrature, at nodes with exact derivatives. Pressure is the derivative of the interpolant.
pub(super) fn table(p: &Parameters) -> Table<3> {
    let (cap, open) = (1.0 - p.cap(), p.join_ratio);
    let above = ((open - cap) * PER_UNIT).ceil() as usize;
    let step = (open - cap) / above as f64;
    let below = ((p.densest() - p.cap()) / step).ceil() as usize;
    let curve = ColdCurve::new(p);
    let at = |i: isize| cap + i as f64 * step;

    // From the reference state at u = 1 outwards in both directions, so that rounding grows away from it.
    let first = ((1.0 - cap) / step).floor() as isize;
    let mut cold = vec![[0.0; 3]; above + 1];
    let mut inward = (1.0, curve.reference);
    for i in (0..=first).rev() {
        inward = (at(i), curve.advance(inward.0, inward.1, at(i)));
        cold[i as usize] = curve.jet(inward.0, inward.1);
    }
    let mut outward = (1.0, curve.reference);
    for i in first + 1..=above as isize {
        outward = (at(i), curve.advance(outward.0, outward.1, at(i)));
        cold[i as usize] = curve.jet(outward.0, outward.1);
    }
    let end = cold[0];
    let nodes: Vec<[Jet; 3]> = (-(below as isize)..=above as isize)
        .map(|i| {
            let e0 = usize::try_from(i).map_or_else(|_| tangent(end, i as f64 * step), |i| cold[i]);
            [e0, melting(p, at(i)), electronic(p, at(i))]
        })
        .collect();
    Table::new(at(-(below as isize)), step, &nodes)
}

/// The cold curve's ingredients.
struct ColdCurve<'a> {
    p: &'a Parameters,
    /// E00: cold energy at V0, minus the thermal energy of the reference state [J/kg].
    reference: f64,
    /// V0 P_cc: what the electrons' gamma_e differs from gamma0 by at the reference state [J/kg].
    offset: f64,
}

impl<'a> ColdCurve<'a> {
    fn new(p: &'a Parameters) -> Self {
        let t0 = p.reference_temperature;
        let electrons = 0.5 * p.electronic * t0 * t0;
        ColdCurve {
            p,
            reference: -(3.0 * p.specific_gas_constant() * t0 + electrons),
            offset: electrons * (p.gruneisen - p.electronic_gruneisen),
        }
    }

    /// Q(x) [J/kg] and dQ/dx of `dE0/dx = Q + gamma/(1-x) E0`.
    fn source(&self, x: f64) -> (f64, f64) {
        let p = self.p;
        let (u, gap, c2) = (1.0 - x, 1.0 / (1.0 - p.slope * x), p.sound_speed * p.sound_speed);
        let gamma = p.gruneisen - p.gruneisen_slope * x;
        let (h, dh) = (c2 * x * gap * gap, c2 * (1.0 + p.slope * x) * gap * gap * gap);
        let share = 1.0 - 0.5 * gamma * x / u;
        let dshare = -0.5 * ((gamma - p.gruneisen_slope * x) * u + gamma * x) / (u * u);
        (h * share + self.offset, dh * share + h * dshare)
    }

    /// ln psi: the integrating factor, dln(psi)/dx = gamma/(1-x).
    fn log_factor(&self, u: f64) -> f64 {
        let p = self.p;
        p.gruneisen_slope * (1.0 - u) + (p.gruneisen_slope - p.gruneisen) * log(u)
    }

    /// E0 at `to`, from `energy` at `from`: 4-point Gauss-Legendre.
    fn advance(&self, from: f64, energy: f64, to: f64) -> f64 {
        const NODES: [(f64, f64); 2] =
            [(0.339_981_043_584_856_26, 0.652_145_154_862_546_1), (0.861_136_311_594_052_6, 0.347_854_845_137_453_9)];
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let end = self.log_factor(to);
        let term = |u: f64| self.source(1.0 - u).0 * exp(end - self.log_factor(u));
        let sum: f64 = NODES.iter().map(|(s, w)| w * (term(middle - half * s) + term(middle + half * s))).sum();
        exp(end - self.log_factor(from)) * energy - half * sum
    }

    /// E0 and its derivatives by u, given its value.
    fn jet(&self, u: f64, energy: f64) -> Jet {
        let p = self.p;
        let gamma = p.gruneisen - p.gruneisen_slope * (1.0 - u);
        let (q, dq) = self.source(1.0 - u);
        let (b, db) = (gamma / u, (gamma - p.gruneisen_slope * u) / (u * u));
        let slope = q + b * energy;
        [energy, -slope, dq + db * energy + b * slope]
    }
}

/// The quadratic through a jet, at distance `d`: pressure on its tangent, beyond the cap.
fn tangent([e, de, dde]: Jet, d: f64) -> Jet {
    [e + d * (de + 0.5 * d * dde), de + d * dde, dde]
}

/// T_m by the Lindemann law dln(T_m)/dln(V) = -lambda = 2/3 - 2 gamma, exact for every volume.
fn melting(p: &Parameters, u: f64) -> Jet {
    let power = 2.0 * (p.gruneisen_slope + 1.0 / 3.0 - p.gruneisen);
    let tm = p.melting_temperature * exp(2.0 * p.gruneisen_slope * (1.0 - u) + power * log(u));
    let slope = power / u - 2.0 * p.gruneisen_slope;
    [tm, tm * slope, tm * (slope * slope - power / (u * u))]
}

/// G = G0 u^gamma_e: the electronic heat coefficient that a pressure of gamma_e G T^2 / (2 V) demands.
fn electronic(p: &Parameters, u: f64) -> Jet {
    let power = p.electronic_gruneisen;
    let g = p.electronic * exp(power * log(u));
    [g, power * g / u, power * (power - 1.0) * g / (u * u)]
}
