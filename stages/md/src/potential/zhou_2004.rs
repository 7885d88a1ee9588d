//! Sixteen metals by one formula: X. W. Zhou, R. A. Johnson and H. N. G. Wadley 2004.
//!
//! Source: Misfit-energy-increasing dislocations in vapor-deposited CoFe/NiFe multilayers, Phys. Rev. B 69, 144113 (2004),
//! eqs (2)-(7) and table III. Letters are the paper's. Three entries differ from the printed table, as they do in the
//! parameter file that the first author gives (NIST Interatomic Potentials Repository, entry 2004--Zhou-X-W): A of
//! aluminium (printed 0.134873), the sign of eta of tungsten, and the density where platinum's first branch ends, 0.25
//! rho_e; only with them is the embedding function continuous.
//!
//! The functions have no end of their own. They are cut at sqrt(5) r_e, where the authors' tables end, and shifted by a
//! straight line so that values and slopes end at 0: a pair's energy changes by 1e-4 eV at most, mostly far less.
use super::{Jet, Structure};
use hvi_kit::math::{exp, log};
use std::sync::OnceLock;

/// Parameters of one metal.
#[derive(Debug)]
pub struct Metal {
    /// Chemical symbol.
    pub symbol: &'static str,
    /// Its crystal.
    pub structure: Structure,
    /// Molar mass [g/mol].
    pub molar_mass: f64,
    /// Distance of nearest neighbours r_e [angstrom].
    re: f64,
    fe: f64,
    rho_e: f64,
    rho_s: f64,
    alpha: f64,
    beta: f64,
    /// A and B [eV].
    a: f64,
    b: f64,
    kappa: f64,
    lambda: f64,
    /// F_n0 to F_n3 [eV].
    low: [f64; 4],
    /// F_0 to F_3 [eV].
    middle: [f64; 4],
    eta: f64,
    /// F_e [eV].
    high: f64,
    /// Density, in rho_e, where the first branch of the embedding function ends.
    first: f64,
    /// Cubic edge without pressure, once it was asked for.
    pub(super) edge: OnceLock<Option<f64>>,
}

macro_rules! metals {
    ($($name:ident $symbol:literal $structure:ident $mass:literal: $re:literal $fe:literal $rho_e:literal $rho_s:literal,
       $alpha:literal $beta:literal $a:literal $b:literal $kappa:literal $lambda:literal,
       $low:expr, $middle:expr, $eta:literal $high:literal $first:literal;)*) => {
        $(#[doc = concat!("Parameters of ", $symbol, ".")]
        pub static $name: Metal = Metal {
            symbol: $symbol, structure: Structure::$structure, molar_mass: $mass, re: $re, fe: $fe, rho_e: $rho_e,
            rho_s: $rho_s, alpha: $alpha, beta: $beta, a: $a, b: $b, kappa: $kappa, lambda: $lambda, low: $low,
            middle: $middle, eta: $eta, high: $high, first: $first, edge: OnceLock::new(),
        };)*
        #[cfg(test)]
        static ALL: &[&Metal] = &[$(&$name),*];
    };
}
metals! {
    CU "Cu" Fcc 63.546: 2.556162 1.554485 21.175871 21.175395, 8.127620 4.334731 0.396620 0.548085 0.308782 0.756515,
        [-2.170269, -0.263788, 1.088878, -0.817603], [-2.19, 0.0, 0.561830, -2.100595], 0.310490 -2.186568 0.85;
    AG "Ag" Fcc 107.8682: 2.891814 1.106232 14.604100 14.604144, 9.132010 4.870405 0.277758 0.419611 0.339710 0.750758,
        [-1.729364, -0.255882, 0.912050, -0.561432], [-1.75, 0.0, 0.744561, -1.150650], 0.783924 -1.748423 0.85;
    AU "Au" Fcc 196.96657: 2.885034 1.529021 19.991632 19.991509, 9.516052 5.075228 0.229762 0.356666 0.356570 0.748798,
        [-2.937772, -0.500288, 1.601954, -0.835530], [-2.98, 0.0, 1.706587, -1.134778], 1.021095 -2.978815 0.85;
    NI "Ni" Fcc 58.6934: 2.488746 2.007018 27.562015 27.930410, 8.383453 4.471175 0.429046 0.633531 0.443599 0.820658,
        [-2.693513, -0.076445, 0.241442, -2.375626], [-2.70, 0.0, 0.265390, -0.152856], 0.469000 -2.699486 0.85;
    PD "Pd" Fcc 106.42: 2.750897 1.595417 21.335246 21.940073, 8.697397 4.638612 0.406763 0.598880 0.397263 0.754799,
        [-2.321006, -0.473983, 1.615343, -0.231681], [-2.36, 0.0, 1.481742, -1.675615], 1.130000 -2.352753 0.85;
    PT "Pt" Fcc 195.084: 2.771916 2.336509 33.367564 35.205357, 7.105782 3.789750 0.556398 0.696037 0.385255 0.770510,
        [-1.455568, -2.149952, 0.528491, 1.222875], [-4.17, 0.0, 3.010561, -2.420128], 1.450000 -4.145597 0.25;
    AL "Al" Fcc 26.981538: 2.863924 1.403115 20.418205 23.195740, 6.613165 3.527021 0.314873 0.365551 0.379846 0.759692,
        [-2.807602, -0.301435, 1.258562, -1.247604], [-2.83, 0.0, 0.622245, -2.488244], 0.785902 -2.824528 0.85;
    PB "Pb" Fcc 207.2: 3.499723 0.647872 8.450154 8.450063, 9.121799 5.212457 0.161219 0.236884 0.250805 0.764955,
        [-1.422370, -0.210107, 0.682886, -0.529378], [-1.44, 0.0, 0.702726, -0.538766], 0.935380 -1.439436 0.85;
    FE "Fe" Bcc 55.845: 2.481987 1.885957 20.041463 20.041463, 9.818270 5.236411 0.392811 0.646243 0.170306 0.340613,
        [-2.534992, -0.059605, 0.193065, -2.282322], [-2.54, 0.0, 0.200269, -0.148770], 0.391750 -2.539945 0.85;
    MO "Mo" Bcc 95.95: 2.728100 2.723710 29.354065 29.354065, 8.393531 4.476550 0.708787 1.120373 0.137640 0.275280,
        [-3.692913, -0.178812, 0.380450, -3.133650], [-3.71, 0.0, 0.875874, 0.776222], 0.790879 -3.712093 0.85;
    TA "Ta" Bcc 180.94788: 2.860082 3.086341 33.787168 33.787168, 8.489528 4.527748 0.611679 1.032101 0.176977 0.353954,
        [-5.103845, -0.405524, 1.112997, -3.585325], [-5.14, 0.0, 1.640098, 0.221375], 0.848843 -5.141526 0.85;
    W "W" Bcc 183.84: 2.740840 3.487340 37.234847 37.234847, 8.900114 4.746728 0.882435 1.394592 0.139209 0.278417,
        [-4.946281, -0.148818, 0.365057, -4.432406], [-4.96, 0.0, 0.661935, 0.348147], 0.582714 -4.961306 0.85;
    MG "Mg" Hcp 24.305: 3.196291 0.544323 7.132600 7.132600, 10.228708 5.455311 0.137518 0.225930 0.5 1.0,
        [-0.896473, -0.044291, 0.162232, -0.689950], [-0.90, 0.0, 0.122838, -0.226010], 0.431425 -0.899702 0.85;
    CO "Co" Hcp 58.933194: 2.505979 1.975299 27.206789 27.206789, 8.679625 4.629134 0.421378 0.640107 0.5 1.0,
        [-2.541799, -0.219415, 0.733381, -1.589003], [-2.56, 0.0, 0.705845, -0.687140], 0.694608 -2.559307 0.85;
    TI "Ti" Hcp 47.867: 2.933872 1.863200 25.565138 25.565138, 8.775431 4.680230 0.373601 0.570968 0.5 1.0,
        [-3.203773, -0.198262, 0.683779, -2.321732], [-3.22, 0.0, 0.608587, -0.750710], 0.558572 -3.219176 0.85;
    ZR "Zr" Hcp 91.224: 3.199978 2.230909 30.879991 30.879991, 8.559190 4.564902 0.424667 0.640054 0.5 1.0,
        [-4.485793, -0.293129, 0.990148, -3.202516], [-4.51, 0.0, 0.928602, -0.981870], 0.597133 -4.509025 0.85;
}

/// Density, in rho_e, where the third branch of the embedding function begins.
const LAST: f64 = 1.15;

/// `size exp(-steep (r/re - 1)) / (1 + (r/re - shift)^20)`, and its derivative by r.
fn decay(r: f64, re: f64, size: f64, steep: f64, shift: f64) -> Jet {
    let x = r / re - shift;
    let (x2, x3) = (x * x, x * x * x);
    let x5 = x2 * x3;
    let x19 = x5 * x5 * x5 * x2 * x2;
    let below = 1.0 / (1.0 + x19 * x);
    let value = size * exp(-steep * (r / re - 1.0)) * below;
    Jet { value, slope: -value * (steep + 20.0 * x19 * below) / re }
}

impl Metal {
    /// Cut-off sqrt(5) r_e [angstrom].
    pub fn cutoff(&self) -> f64 {
        5f64.sqrt() * self.re
    }

    /// Edge of the cubic cell in which nearest neighbours are r_e apart [angstrom].
    pub fn lattice_constant(&self) -> f64 {
        self.structure.edge(self.re)
    }

    /// Highest density that is allowed: ten times that of the crystal.
    pub fn densest(&self) -> f64 {
        10.0 * self.rho_e
    }

    /// `f` less its tangent at the cut-off.
    fn ended(&self, r: f64, f: impl Fn(f64) -> Jet) -> Jet {
        let cutoff = self.cutoff();
        if r >= cutoff {
            return Jet::default();
        }
        let (here, end) = (f(r), f(cutoff));
        Jet { value: here.value - end.value - (r - cutoff) * end.slope, slope: here.slope - end.slope }
    }

    /// Pair function phi(r) [eV] of eq (2), `r` in angstrom.
    pub fn pair(&self, r: f64) -> Jet {
        self.ended(r, |r| {
            let up = decay(r, self.re, self.a, self.alpha, self.kappa);
            let down = decay(r, self.re, self.b, self.beta, self.lambda);
            Jet { value: up.value - down.value, slope: up.slope - down.slope }
        })
    }

    /// Density function f(r) of eq (4), `r` in angstrom.
    pub fn density(&self, r: f64) -> Jet {
        self.ended(r, |r| decay(r, self.re, self.fe, self.beta, self.lambda))
    }

    /// Embedding function F(rho) [eV], eqs (5)-(7).
    pub fn embedding(&self, density: f64) -> Jet {
        let cubic = |c: &[f64; 4], at: f64| {
            let x = density / at - 1.0;
            let slope = ((3.0 * c[3] * x + 2.0 * c[2]) * x + c[1]) / at;
            Jet { value: ((c[3] * x + c[2]) * x + c[1]) * x + c[0], slope }
        };
        let first = self.first * self.rho_e;
        if density < first {
            cubic(&self.low, first)
        } else if density < LAST * self.rho_e {
            cubic(&self.middle, self.rho_e)
        } else {
            let power = self.eta * log(density / self.rho_s);
            let size = self.high * exp(power);
            Jet { value: size * (1.0 - power), slope: -size * power * self.eta / density }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parameters are given to six decimals; a wrong digit in any of the embedding's breaks the joints.
    #[test]
    fn embedding_functions_are_continuous() {
        for metal in ALL {
            for at in [metal.first * metal.rho_e, LAST * metal.rho_e] {
                let d = 1e-9 * at;
                let (below, above) = (metal.embedding(at - d), metal.embedding(at + d));
                let (value, slope) = (below.value - above.value, (below.slope - above.slope) * metal.rho_e);
                println!("{} at {at:.3}: {value:.1e} {slope:.1e} eV", metal.symbol);
                assert!(value.abs() < 3e-5 && slope.abs() < 1e-3, "{} at {at}: {value} {slope}", metal.symbol);
            }
        }
    }
}
