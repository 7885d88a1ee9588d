//! Functions of volume alone: the cold curve, the melting temperature and the electronic heat, tabulated.
use super::parameters::Parameters;
use crate::lanes::Eight;
use crate::model::table::{Jet, quintic};
use hvi_kit::math::{exp, log};

/// Intervals of the table a unit of V/V0. The cold curve steepens towards the pole at x = 1/S; at 0.92/S this many keep
/// its interpolation error near 1e-9 of the value, at x = 0.5 below 1e-12; more would crowd the second-level cache.
const PER_UNIT: f64 = 320.0;

/// What a row of [`Functions`] holds, by lane: E0 [J/kg], P0 [Pa], dP0/dV, T_m [K], G [J/kg/K2], the melting band's width w [J/kg],
/// dw/dV and d2w/dV2.
pub(super) type Row = [f64; 8];

/// The functions of volume alone over u = V/V0, from the densest state to V_J: quintic Hermite pieces of E0, T_m, G and w.
///
/// P0 and dw/dV are derivatives of the interpolants, so that pressure and energy stay exactly consistent.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Functions {
    start: f64,
    per_step: f64,
    /// `[interval][power of the local coordinate 0..1][lane]`
    pieces: Vec<[Row; 6]>,
}

impl Functions {
    /// E0 solves `dE0/dx = Q + gamma/(1-x) E0`, x = 1 - u (the cold curve whose Hugoniot is Us = C + S up): between nodes
    /// by Gauss-Legendre quadrature, at nodes with exact derivatives.
    pub fn new(p: &Parameters, melting_entropy: f64) -> Functions {
        let (cap, open) = (1.0 - p.cap(), p.join_ratio);
        let above = ((open - cap) * PER_UNIT).ceil() as usize;
        let step = (open - cap) / above as f64;
        let below = ((p.densest() - p.cap()) / step).ceil() as usize;
        let at = |i: usize| cap + (i as f64 - below as f64) * step;
        let cold = cold_nodes(p, cap, step, above);
        let node = |i: usize| -> [Jet; 4] {
            let e0 = match i.checked_sub(below) {
                Some(i) => cold[i],
                None => tangent(cold[0], (i as f64 - below as f64) * step),
            };
            let tm = melting(p, at(i));
            [e0, tm, electronic(p, at(i)), width(p, at(i), tm[0], melting_entropy)]
        };
        let nodes: Vec<[Jet; 4]> = (0..=below + above).map(node).collect();
        let per_volume = 1.0 / (step * p.volume);
        let pieces = nodes
            .windows(2)
            .map(|ends| {
                let [e0, tm, g, w]: [[f64; 6]; 4] = std::array::from_fn(|k| quintic(ends[0][k], ends[1][k], step));
                let (p0, dw) = (slope(&e0, -per_volume), slope(&w, per_volume));
                let lanes = [e0, p0, slope(&p0, per_volume), tm, g, w, dw, slope(&dw, per_volume)];
                std::array::from_fn(|power| std::array::from_fn(|lane| lanes[lane][power]))
            })
            .collect();
        Functions { start: at(0), per_step: 1.0 / step, pieces }
    }

    /// The row at `u`, clamped to the range.
    #[inline(always)]
    pub fn at<R: Eight>(&self, u: f64) -> Row {
        // `as` truncates and saturates: positions below 0 land in the first interval, NaN too.
        let position = (u - self.start) * self.per_step;
        let interval = (position as usize).min(self.pieces.len() - 1);
        let s = R::of((position - interval as f64).clamp(0.0, 1.0));
        let [c0, c1, c2, c3, c4, c5] = &self.pieces[interval];
        let high = (R::load(c5) * s + R::load(c4)) * s + R::load(c3);
        let mut row = [0.0; 8];
        (((high * s + R::load(c2)) * s + R::load(c1)) * s + R::load(c0)).store(&mut row);
        row
    }

    /// The smallest u of the range.
    pub fn densest(&self) -> f64 {
        self.start
    }
}

/// Coefficients of `scale` times the derivative of the polynomial `c`.
fn slope(c: &[f64; 6], scale: f64) -> [f64; 6] {
    std::array::from_fn(|k| if k < 5 { scale * (k + 1) as f64 * c[k + 1] } else { 0.0 })
}

/// E0 at `cap + i step`, 0 <= i <= `above`: from the reference state at u = 1 outwards in both directions, so that rounding
/// grows away from it.
fn cold_nodes(p: &Parameters, cap: f64, step: f64, above: usize) -> Vec<Jet> {
    let curve = ColdCurve::new(p);
    let at = |i: usize| cap + i as f64 * step;
    let first = ((1.0 - cap) / step).floor() as usize;
    let mut cold = vec![[0.0; 3]; above + 1];
    let mut inward = (1.0, curve.reference);
    for i in (0..=first).rev() {
        inward = (at(i), curve.advance(inward.0, inward.1, at(i)));
        cold[i] = curve.jet(inward.0, inward.1);
    }
    let mut outward = (1.0, curve.reference);
    for i in first + 1..=above {
        outward = (at(i), curve.advance(outward.0, outward.1, at(i)));
        cold[i] = curve.jet(outward.0, outward.1);
    }
    cold
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

/// Width w of the melting band [J/kg] as a free energy, and its derivatives by u.
///
/// `w = dS_m T_m kk`, `k = lambda^2 dS_m T_m / c_r^2`, `kk = k / (1 + (k/0.5)^4)^(1/4)`: the lever rule for a small volume change,
/// bounded by the fourth root; c_r is the sound speed along the Hugoniot's own formula, held constant beyond the cap and where
/// 1 + S x would fall below 0.2. Any positive w(V) is consistent, for the band derives from it as a potential.
fn width(p: &Parameters, u: f64, tm: f64, melting_entropy: f64) -> Jet {
    let (s, x) = (p.slope, 1.0 - u);
    let held = x.clamp(-0.8 / s, p.cap());
    let (open, left, right) = (1.0 - held, 1.0 + s * held, 1.0 / (1.0 - s * held));
    let stiffness = p.sound_speed * p.sound_speed * open * open * left * right * right * right;
    let lambda = 2.0 * (p.gruneisen - p.gruneisen_slope * x) - 2.0 / 3.0;
    let relative = lambda * lambda * melting_entropy * tm / stiffness;
    let fourth = 16.0 * (relative * relative) * (relative * relative);
    let q = 1.0 / (1.0 + fourth);
    let w = melting_entropy * tm * relative * q.sqrt().sqrt();
    // Logarithmic derivatives by u: of the stiffness, of `relative`, of w.
    let (mut stiff1, mut stiff2) = (0.0, 0.0);
    if held == x {
        stiff1 = 2.0 / open - s / left - 3.0 * s * right;
        stiff2 = -2.0 / (open * open) - s * s / (left * left) + 3.0 * s * s * right * right;
    }
    let dlambda = 2.0 * p.gruneisen_slope / lambda;
    let log1 = 2.0 * dlambda - lambda / u - stiff1;
    let slide = lambda / u * (1.0 / u - dlambda);
    let log2 = -2.0 * dlambda * dlambda + slide - stiff2;
    let first = -lambda / u + q * log1;
    let second = slide + q * log2 - 4.0 * q * (1.0 - q) * log1 * log1;
    [w, w * first, w * (second + first * first)]
}
