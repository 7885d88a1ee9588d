//! A material point, and the matter in it: one, or eight side by side.
use hvi_kit::lanes::{Eight, Real};
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// Declares [`Matter`] and what goes through all of its fields.
macro_rules! matter {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        /// State of the matter of a particle: `T` is f64, eight lanes of it, or their memory.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct Matter<T> {
            $($(#[$doc])* pub $name: T,)*
            /// Deviatoric stress xx, yy, zz, xy, yz, xz [Pa].
            pub stress: [T; 6],
        }

        impl Matter<[f64; 8]> {
            /// Eight copies.
            pub fn filled(m: &Matter<f64>) -> Self {
                Matter { $($name: [m.$name; 8],)* stress: m.stress.map(|s| [s; 8]) }
            }
            /// Particle `lane`.
            #[inline(always)]
            pub fn get(&self, lane: usize) -> Matter<f64> {
                let mut stress = [0.0; 6];
                for k in 0..6 {
                    stress[k] = self.stress[k][lane];
                }
                Matter { $($name: self.$name[lane],)* stress }
            }
            /// Makes `m` particle `lane`.
            #[inline(always)]
            pub fn set(&mut self, lane: usize, m: &Matter<f64>) {
                $(self.$name[lane] = m.$name;)*
                for k in 0..6 {
                    self.stress[k][lane] = m.stress[k];
                }
            }
            /// All eight.
            #[inline(always)]
            pub fn load<R: Eight>(&self) -> Matter<R> {
                let s = &self.stress;
                let stress =
                    [R::load(&s[0]), R::load(&s[1]), R::load(&s[2]), R::load(&s[3]), R::load(&s[4]), R::load(&s[5])];
                Matter { $($name: R::load(&self.$name),)* stress }
            }
            /// Keeps all eight.
            #[inline(always)]
            pub fn store<R: Eight>(&mut self, m: &Matter<R>) {
                $(m.$name.store(&mut self.$name);)*
                for k in 0..6 {
                    m.stress[k].store(&mut self.stress[k]);
                }
            }
        }
    };
}

matter! {
    /// Mass [kg]: per square metre in one dimension, per radian in axisymmetry.
    mass,
    /// Volume at the start [m3], per the same.
    volume,
    /// Volume over volume at the start; goes on counting the void when the particle has failed.
    ratio,
    /// Specific internal energy [J/kg].
    energy,
    /// Equivalent plastic strain.
    plastic_strain,
    /// Johnson-Cook damage; 1 or more: failed, by damage or spall, so that it carries no tension and no shear.
    damage,
    /// Pressure of the equation of state, before any tension cut-off [Pa].
    unclamped,
    /// Bulk modulus rho c_b^2 [Pa].
    stiffness,
    /// Longitudinal sound speed [m/s].
    sound_speed,
    /// Temperature [K].
    temperature,
    /// T* = (T - T_r) / (T_m - T_r) of Johnson-Cook, 1 where molten.
    homologous,
    /// Johnson-Cook's `1 - T*^m`, 0 where melted or failed.
    softening,
    /// Johnson-Cook's `A + B ep^n` [Pa].
    hardened,
    /// Velocity divergence in the last step [1/s].
    divergence,
}

impl<R: Real> Matter<R> {
    /// 1 where failed, else 0.
    #[inline(always)]
    pub fn failed(&self) -> R {
        R::of(0.0).where_less(self.damage, R::of(1.0), R::of(1.0))
    }
    /// 1 where failed and pulled apart: a void is open, so it neither carries pressure nor resists. Else 0.
    #[inline(always)]
    pub fn open(&self) -> R {
        self.failed().where_less(self.unclamped, R::of(0.0), R::of(0.0))
    }
    /// Pressure that acts [Pa].
    #[inline(always)]
    pub fn pressure(&self) -> R {
        self.unclamped.where_less(self.damage, R::of(1.0), self.unclamped.at_least(0.0))
    }
    /// Yield stress at the reference rate [Pa].
    #[inline(always)]
    pub fn yield_stress(&self) -> R {
        self.hardened * self.softening
    }
}

/// A material point in `D` dimensions; tensors of its matter are always 3 x 3 (in (r, z) the third axis is the hoop).
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
    /// Its matter; its fields are the particle's.
    pub matter: Matter<f64>,
    /// Number at the start, kept through all sorting.
    pub id: u32,
    /// Index of the body.
    pub body: u8,
    /// No other particle shared a node with it in the last step: it flies on as it is.
    pub alone: bool,
}

impl<const D: usize> Deref for Particle<D> {
    type Target = Matter<f64>;
    fn deref(&self) -> &Matter<f64> {
        &self.matter
    }
}
impl<const D: usize> DerefMut for Particle<D> {
    fn deref_mut(&mut self) -> &mut Matter<f64> {
        &mut self.matter
    }
}

impl<const D: usize> Particle<D> {
    /// Matter at rest in itself; the state of its material is filled in by [`crate::material::Law::prepare`].
    pub fn new(position: [f64; D], velocity: [f64; D], mass: f64, volume: f64, id: u32, body: u8) -> Self {
        let matter = Matter { mass, volume, ratio: 1.0, ..Matter::default() };
        Self { position, velocity, affine: [[0.0; D]; D], matter, id, body, alone: false }
    }

    /// Failed: carries no tension and no shear.
    pub fn failed(&self) -> bool {
        self.damage >= 1.0
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
