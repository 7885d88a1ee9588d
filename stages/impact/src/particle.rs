//! A material point.
use serde::{Deserialize, Serialize};

/// A material point in `D` dimensions; tensors are always 3 x 3 (in (r, z) the third axis is the hoop).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Particle<const D: usize> {
    /// Position [m]; `[axis, radius]` in axisymmetry.
    #[serde(with = "padded")]
    pub position: [f64; D],
    /// Velocity [m/s].
    #[serde(with = "padded")]
    pub velocity: [f64; D],
    /// Affine part of the velocity field around the particle [1/s], `[component][axis]`.
    #[serde(with = "padded::square")]
    pub affine: [[f64; D]; D],
    /// Mass [kg]: per square metre in one dimension, per radian in axisymmetry.
    pub mass: f64,
    /// Volume at the start [m3], per the same.
    pub volume: f64,
    /// Volume over volume at the start; goes on counting the void when the particle has failed.
    pub ratio: f64,
    /// Specific internal energy [J/kg].
    pub energy: f64,
    /// Deviatoric stress xx, yy, zz, xy, yz, xz [Pa].
    pub stress: [f64; 6],
    /// Equivalent plastic strain.
    pub plastic_strain: f64,
    /// Johnson-Cook damage; 1 is failure.
    pub damage: f64,
    /// Pressure that acts [Pa].
    pub pressure: f64,
    /// Pressure of the equation of state, before any tension cut-off [Pa].
    pub unclamped: f64,
    /// Largest tension carried [Pa], infinite where spall is off.
    pub tension_limit: f64,
    /// Bulk modulus rho c_b^2 [Pa].
    pub stiffness: f64,
    /// Longitudinal sound speed [m/s].
    pub sound_speed: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Johnson-Cook's `1 - T*^m`, 0 where melted or failed.
    pub softening: f64,
    /// Johnson-Cook's `A + B ep^n` [Pa].
    pub hardened: f64,
    /// Yield stress at the reference rate [Pa].
    pub yield_stress: f64,
    /// Velocity divergence in the last step [1/s].
    pub divergence: f64,
    /// Number at the start, kept through all sorting.
    pub id: u32,
    /// Index of the body.
    pub body: u8,
    /// Failed: carries no tension and no shear.
    pub failed: bool,
    /// No other particle shared a node with it in the last step: it flies on as it is.
    pub alone: bool,
}

impl<const D: usize> Particle<D> {
    /// Matter at rest in itself; the state of its material is filled in by [`crate::material::Law::prepare`].
    pub fn new(position: [f64; D], velocity: [f64; D], mass: f64, volume: f64, id: u32, body: u8) -> Self {
        Self {
            position,
            velocity,
            affine: [[0.0; D]; D],
            mass,
            volume,
            ratio: 1.0,
            energy: 0.0,
            stress: [0.0; 6],
            plastic_strain: 0.0,
            damage: 0.0,
            pressure: 0.0,
            unclamped: 0.0,
            tension_limit: f64::INFINITY,
            stiffness: 0.0,
            sound_speed: 0.0,
            temperature: 0.0,
            softening: 0.0,
            hardened: 0.0,
            yield_stress: 0.0,
            divergence: 0.0,
            id,
            body,
            failed: false,
            alone: false,
        }
    }

    /// Failed and pulled apart: a void is open, so it neither carries pressure nor resists.
    #[inline(always)]
    pub fn is_open(&self) -> bool {
        self.failed && self.unclamped < 0.0
    }

    /// Kinetic energy, the affine motion's included [J] (per the mass's unit); `moment` [m2] is the kernel's, see
    /// [`crate::method::Method::moment`].
    pub fn kinetic(&self, moment: f64) -> f64 {
        let speed2: f64 = self.velocity.iter().map(|v| v * v).sum();
        let affine2: f64 = self.affine.iter().flatten().map(|c| c * c).sum();
        0.5 * self.mass * (speed2 + moment * affine2)
    }
}

/// Arrays of `D` numbers in a checkpoint: filled up with zeros to 3, since serde knows no arrays of a length to be chosen.
mod padded {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    fn fill<T: Copy, const D: usize>(short: &[T; D], zero: T) -> [T; 3] {
        std::array::from_fn(|i| if i < D { short[i] } else { zero })
    }
    pub fn serialize<S: Serializer, const D: usize>(x: &[f64; D], to: S) -> Result<S::Ok, S::Error> {
        fill(x, 0.0).serialize(to)
    }
    pub fn deserialize<'a, S: Deserializer<'a>, const D: usize>(from: S) -> Result<[f64; D], S::Error> {
        <[f64; 3]>::deserialize(from).map(|x| std::array::from_fn(|i| x[i]))
    }
    /// The same for `D` by `D` numbers.
    pub mod square {
        use super::*;
        pub fn serialize<S: Serializer, const D: usize>(x: &[[f64; D]; D], to: S) -> Result<S::Ok, S::Error> {
            fill(&x.map(|row| fill(&row, 0.0)), [0.0; 3]).serialize(to)
        }
        pub fn deserialize<'a, S: Deserializer<'a>, const D: usize>(from: S) -> Result<[[f64; D]; D], S::Error> {
            <[[f64; 3]; 3]>::deserialize(from).map(|x| std::array::from_fn(|i| std::array::from_fn(|j| x[i][j])))
        }
    }
}
