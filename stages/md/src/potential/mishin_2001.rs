//! Copper of Mishin et al. 2001, EAM1, in its analytic form.
//!
//! Source: Y. Mishin, M. J. Mehl, D. A. Papaconstantopoulos, A. F. Voter and J. D. Kress, Structural stability and
//! lattice defects in copper: ab initio, tight-binding, and embedded-atom calculations, Phys. Rev. B 63, 224106 (2001),
//! the functions of section III and the column EAM1 of the parameter table. Letters are the paper's.
use super::Jet;
use hvi_kit::math::exp;

/// Molar mass of copper [g/mol].
pub const MOLAR_MASS: f64 = 63.546;
/// Edge of its lattice [angstrom].
pub const LATTICE_CONSTANT: f64 = 3.615;
/// Highest density that is allowed; the crystal has about 1, at 0.45 of its volume 7.
pub const DENSEST: f64 = 10.0;
/// Cut-off distance r_c [angstrom].
pub const CUTOFF: f64 = 5.50679;
/// Width h of the cut-off function [angstrom].
const H: f64 = 0.50037;
/// (E [eV], alpha [1/angstrom], r0 [angstrom]) of the two Morse functions.
const MORSE: [(f64, f64, f64); 2] = [(2.01458e2, 2.97758, 0.83591), (6.59288e-3, 1.54927, 4.46867)];
/// Constant delta of the pair function [eV].
const DELTA: f64 = 0.86225e-2;
/// (r_s [angstrom], S [eV/angstrom^4]) of the three short-range terms.
const SHORT: [(f64, f64); 3] = [(2.24, 4.0), (1.8, 40.0), (1.2, 1.15e3)];
const A: f64 = 3.80362;
/// (beta1 [1/angstrom^2], r0(3) [angstrom]) of the Gaussian of the density.
const GAUSSIAN: (f64, f64) = (0.17394, -2.19885);
/// (beta2 [1/angstrom], r0(4) [angstrom]) of the exponential of the density, which underflows to 0 at any distance.
const EXPONENTIAL: (f64, f64) = (5.35661e2, -2.61984e2);
const F0: f64 = -2.28235;
const F2: f64 = 1.35535;
const Q: [f64; 4] = [-1.27775, -0.86074, 1.78804, 2.97571];
const Q1: f64 = 0.4;
const Q2: f64 = 0.3;

/// Cut-off function psi(x) = x^4/(1 + x^4) below 0, else 0, with x = (r - r_c)/h; derivative by r.
fn cut(r: f64) -> Jet {
    let x = (r - CUTOFF) / H;
    if x >= 0.0 {
        return Jet::default();
    }
    let x3 = x * x * x;
    let below = 1.0 / (1.0 + x3 * x);
    Jet { value: x3 * x * below, slope: 4.0 * x3 * below * below / H }
}

fn product(a: Jet, b: Jet) -> Jet {
    Jet { value: a.value * b.value, slope: a.slope * b.value + a.value * b.slope }
}

/// Pair function V(r) [eV], `r` in angstrom.
pub fn pair(r: f64) -> Jet {
    let mut sum = Jet { value: DELTA, slope: 0.0 };
    for (energy, alpha, r0) in MORSE {
        let m = exp(-alpha * (r - r0));
        sum.value += energy * (m * m - 2.0 * m);
        sum.slope -= 2.0 * alpha * energy * (m * m - m);
    }
    let mut v = product(sum, cut(r));
    for (reach, strength) in SHORT {
        let t = (reach - r).max(0.0);
        v.value -= strength * (t * t) * (t * t);
        v.slope += 4.0 * strength * t * t * t;
    }
    v
}

/// Density function rho(r), `r` in angstrom.
pub fn density(r: f64) -> Jet {
    let x = r - GAUSSIAN.1;
    let gaussian = A * exp(-GAUSSIAN.0 * x * x);
    let exponential = exp(-EXPONENTIAL.0 * (r - EXPONENTIAL.1));
    let sum =
        Jet { value: gaussian + exponential, slope: -2.0 * GAUSSIAN.0 * x * gaussian - EXPONENTIAL.0 * exponential };
    product(sum, cut(r))
}

/// Embedding function F(rho) [eV].
pub fn embedding(density: f64) -> Jet {
    let x = density - 1.0;
    let (x2, x3) = (x * x, x * x * x);
    if x < 0.0 {
        let power_sum = x3 * (Q[0] + x * (Q[1] + x * (Q[2] + x * Q[3])));
        let slope = F2 * x + x2 * (3.0 * Q[0] + x * (4.0 * Q[1] + x * (5.0 * Q[2] + x * 6.0 * Q[3])));
        return Jet { value: F0 + 0.5 * F2 * x2 + power_sum, slope };
    }
    let above = F0 + 0.5 * F2 * x2 + Q[0] * x3 + Q1 * x3 * x;
    let above_slope = F2 * x + 3.0 * Q[0] * x2 + 4.0 * Q1 * x3;
    let below = 1.0 + Q2 * x3;
    let value = above / below;
    Jet { value, slope: (above_slope - value * 3.0 * Q2 * x2) / below }
}
