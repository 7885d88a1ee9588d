//! Solid or liquid: translational order against the lattice, and how far atoms are from their sites.
use crate::{lattice, void};
use hvi_kit::math::{cos, sin};
use serde::{Deserialize, Serialize};

/// Below this order there is no crystal. Copper's overheated crystal keeps 0.5 until it melts; a liquid has 0.01.
pub const LEAST_ORDER: f64 = 0.2;
/// An atom this far from its site, over the distance of nearest sites, has left it. (In the overheated crystal the root
/// mean square is 0.2.)
pub const FARTHEST: f64 = 0.75;

/// The structure at one moment.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Order {
    /// Mean over the four {111} reciprocal lattice vectors G of |sum exp(i G.x)/N|^2, the Bragg intensity of the starting
    /// lattice: 1 at rest, exp(-G^2 <u^2>/3) in a crystal whose atoms are off by u, about 1/N in a liquid. It sees the
    /// long-range order itself: a hot or overheated crystal, whose local surroundings look like a liquid's, keeps it.
    pub translational: f64,
    /// Mean square way of atoms from their sites, over the square of the distance of nearest sites.
    pub displacement2: f64,
    /// The farthest atom's way from its site, over the distance of nearest sites.
    pub farthest: f64,
    /// The share of the box that is void, see [`void`].
    pub void: f64,
}

impl Order {
    /// The structure of atoms at `positions` in any order, `ways` off their sites, which are a lattice of cubic edge
    /// `lattice`, in a cube of edge `edge` (all in angstrom).
    pub fn of(positions: &[[f64; 3]], ways: &[[f64; 3]], lattice: f64, edge: f64) -> Order {
        let atoms = positions.len() as f64;
        let translational = bragg(positions.iter().copied(), lattice) / (atoms * atoms);
        let nearest2 = lattice::NEAREST * lattice::NEAREST * lattice * lattice;
        let (mut sum, mut most) = (0.0, 0.0f64);
        for d in ways {
            let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            sum += square;
            most = most.max(square);
        }
        let void = void::share(positions, [edge; 3]);
        Order { translational, displacement2: sum / atoms / nearest2, farthest: (most / nearest2).sqrt(), void }
    }

    /// Whether it is a crystal.
    pub fn is_solid(&self) -> bool {
        self.translational > LEAST_ORDER
    }
}

/// Mean of |sum exp(i G.x)|^2 over G = (2 pi/a)(+-1, +-1, 1).
fn bragg(positions: impl Iterator<Item = [f64; 3]>, lattice: f64) -> f64 {
    let mut sums = [(0.0, 0.0); 4];
    for x in positions {
        let phase = x.map(|x| std::f64::consts::TAU * x / lattice);
        let (c, s) = (phase.map(cos), phase.map(sin));
        for (k, sum) in sums.iter_mut().enumerate() {
            // exp(i(+-p +-q + r)) as a product
            let (s0, s1) = (if k & 1 == 0 { s[0] } else { -s[0] }, if k & 2 == 0 { s[1] } else { -s[1] });
            let (re, im) = (c[0] * c[1] - s0 * s1, c[0] * s1 + s0 * c[1]);
            sum.0 += re * c[2] - im * s[2];
            sum.1 += re * s[2] + im * c[2];
        }
    }
    0.25 * sums.iter().map(|(re, im)| re * re + im * im).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Sites shaken by a normal u of variance s^2 an axis: exp(-G^2 s^2) with G^2 = 3 (2 pi/a)^2, and the part of one
    /// atom, (1 - that)/N. With 4000 atoms the scatter is about 2 |rho| sqrt((1 - exp)/N), 0.01.
    #[test]
    fn bragg_intensity_follows_debye_and_waller() {
        let (a, mut random) = (3.6, Random::new(5));
        for spread in [0.0, 0.1, 0.25] {
            let shaken = lattice::sites(10, a).into_iter().map(|s| s.map(|x| x + spread * random.normal()));
            let found = bragg(shaken.collect::<Vec<_>>().into_iter(), a) / 16e6;
            let wave = std::f64::consts::TAU / a * spread;
            let expected = hvi_kit::math::exp(-3.0 * wave * wave);
            assert!((found - expected).abs() < 0.02, "{spread}: {found} {expected}");
        }
        let scattered = (0..4000).map(|_| [(); 3].map(|()| 36.0 * random.uniform())).collect::<Vec<_>>();
        assert!(bragg(scattered.into_iter(), a) / 16e6 < 0.003);
    }
}
