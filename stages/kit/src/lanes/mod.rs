//! Formulas written once, for one number or for eight: on AVX-512, AVX2 or plain arrays, chosen at run time, the same bits.
//!
//! Every operation is one IEEE operation on each lane, and products and sums are fused only where [`Real::fused`] says so: a lane's
//! result is the scalar's. `functions.rs` has exponential, logarithm and power.
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod functions;
mod portable;
pub use functions::{exp, log, pow};
pub use portable::Plain;
use std::ops::{Add, Div, Mul, Sub};

/// A number, or several side by side.
pub trait Real: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// `x`, in every lane.
    fn of(x: f64) -> Self;
    /// Square root.
    fn root(self) -> Self;
    /// `self factor + addend`, rounded once.
    fn fused(self, factor: Self, addend: Self) -> Self;
    /// Greatest whole number not above.
    fn floor(self) -> Self;
    /// Exponent k of `m 2^k`, m from 1 to 2, of a normal positive number.
    fn exponent(self) -> Self;
    /// m of the same.
    fn mantissa(self) -> Self;
    /// `self` times 2 to a whole power from -1022 to 1023; the result a normal number.
    fn scale(self, exponent: Self) -> Self;
    /// `self` where `a < b`, else `other`.
    fn where_less(self, a: Self, b: Self, other: Self) -> Self;
    /// Whether `self < other` in any lane.
    fn any_less(self, other: Self) -> bool;

    /// `self` where it is above `bound`, else `bound` (which a NaN gives too).
    #[inline(always)]
    fn at_least(self, bound: f64) -> Self {
        self.where_less(Self::of(bound), self, Self::of(bound))
    }
    /// `self` where it is below `bound`, else `bound` (which a NaN gives too).
    #[inline(always)]
    fn at_most(self, bound: f64) -> Self {
        self.where_less(self, Self::of(bound), Self::of(bound))
    }
    /// The greater of both; `other` where `self` is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.where_less(other, self, other)
    }
    /// The lesser of both; `other` where `self` is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.where_less(self, other, other)
    }
    /// Absolute value.
    #[inline(always)]
    fn size(self) -> Self {
        self.max(Self::of(0.0) - self)
    }
    /// `self + x`.
    #[inline(always)]
    fn plus(self, x: f64) -> Self {
        self + Self::of(x)
    }
    /// `self` times `x`.
    #[inline(always)]
    fn times(self, x: f64) -> Self {
        self * Self::of(x)
    }
}

/// Four numbers for each of eight lanes.
pub type Quads = [[f64; 4]; 8];

/// Eight numbers side by side.
pub trait Eight: Real {
    /// Whether these are plain arrays.
    const IS_PORTABLE: bool = false;
    /// From memory.
    fn load(from: &[f64; 8]) -> Self;
    /// From memory, of half the width.
    fn widened(from: &[f32; 8]) -> Self;
    /// To memory.
    fn store(self, to: &mut [f64; 8]);
    /// Four numbers and four others.
    fn quads(low: &[f64; 4], high: &[f64; 4]) -> Self;
    /// Four times `low`, then four times `high`.
    fn halves(low: f64, high: f64) -> Self;
    /// Puts the first four and the last four there.
    fn split(self, low: &mut [f64; 4], high: &mut [f64; 4]);
    /// Puts the first four plus the last four there.
    fn fold(self, to: &mut [f64; 4]);
    /// Puts lane k of the four there as quad k.
    fn transposed(columns: [Self; 4], to: &mut Quads);
    /// Makes number c of quad k lane k of the cth.
    fn columns(from: &Quads) -> [Self; 4];

    /// All lanes added up: `((0 + 4) + (2 + 6)) + ((1 + 5) + (3 + 7))`.
    #[inline(always)]
    fn sum(self) -> f64 {
        let mut quad = [0.0; 4];
        self.fold(&mut quad);
        (quad[0] + quad[2]) + (quad[1] + quad[3])
    }
    /// The greatest of all lanes; NaNs are passed over.
    #[inline(always)]
    fn greatest(self) -> f64 {
        let mut all = [0.0; 8];
        self.store(&mut all);
        let mut greatest = f64::NEG_INFINITY;
        for x in all {
            if x > greatest {
                greatest = x;
            }
        }
        greatest
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn root(self) -> f64 {
        self.sqrt()
    }
    #[inline(always)]
    fn fused(self, factor: f64, addend: f64) -> f64 {
        self.mul_add(factor, addend)
    }
    #[inline(always)]
    fn floor(self) -> f64 {
        f64::floor(self)
    }
    #[inline(always)]
    fn exponent(self) -> f64 {
        (self.to_bits() >> 52 & 0x7ff) as f64 - 1023.0
    }
    #[inline(always)]
    fn mantissa(self) -> f64 {
        f64::from_bits(self.to_bits() & 0x000f_ffff_ffff_ffff | 0x3ff0_0000_0000_0000)
    }
    #[inline(always)]
    fn scale(self, exponent: f64) -> f64 {
        self * f64::from_bits(((exponent as i64 + 1023) as u64) << 52)
    }
    #[inline(always)]
    fn where_less(self, a: f64, b: f64, other: f64) -> f64 {
        if a < b { self } else { other }
    }
    #[inline(always)]
    fn any_less(self, other: f64) -> bool {
        self < other
    }
}

/// Has `x` brought to the processor's first cache, soon.
#[inline(always)]
pub fn prefetch<T>(x: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(x).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(64) {
            // SAFETY: a hint, which reads nothing; the address lies within `x`.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(64 * line)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = x;
}

/// A piece of work on eight lanes. `run` and everything it calls must be `#[inline(always)]`, to be compiled for the processor.
pub trait Work {
    /// Does it.
    fn run<R: Eight>(self);
}

/// An instruction set that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instructions(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Plain,
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

impl Instructions {
    /// All that this processor has, the fastest first.
    pub fn all() -> Vec<Instructions> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") && has_avx2() {
                all.push(Instructions(Set::Avx512));
            }
            if has_avx2() {
                all.push(Instructions(Set::Avx2));
            }
        }
        all.push(Instructions(Set::Plain));
        all
    }
    /// The fastest that this processor has.
    pub fn best() -> Instructions {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") && has_avx2() {
                return Instructions(Set::Avx512);
            }
            if has_avx2() {
                return Instructions(Set::Avx2);
            }
        }
        Instructions(Set::Plain)
    }
    /// Whether it is plain arrays.
    pub fn is_portable(self) -> bool {
        self.0 == Set::Plain
    }
    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "AVX-512",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "AVX2",
            Set::Plain => "portable",
        }
    }
    /// Does `work` with it.
    pub fn run(self, work: impl Work) {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => avx512::run(work),
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => avx2::run(work),
            Set::Plain => work.run::<Plain>(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct All<'a>(&'a [f64; 8], &'a [f64; 8], &'a mut Vec<u64>);
    impl Work for All<'_> {
        #[inline(always)]
        fn run<R: Eight>(self) {
            let (a, b) = (R::load(self.0), R::load(self.1));
            let all = [
                a + b,
                a - b,
                a * b,
                a / b,
                a.root(),
                a.where_less(a, b, R::of(3.0)),
                a.at_least(0.5),
                a.at_most(0.5),
                a.times(0.1).plus(7.0),
                a.fused(b, R::of(0.3)),
                a.floor(),
                a.max(b),
                a.min(b),
                a.size(),
                b.size().at_least(1e-300).at_most(1e300).exponent(),
                b.size().at_least(1e-300).at_most(1e300).mantissa(),
                R::of(1.7).scale(a.at_least(-900.0).at_most(900.0).floor()),
                R::quads(&[1.0, 2.0, 3.0, 4.0], &[5.0, 6.0, 7.0, 8.0]) * R::halves(0.1, 0.2),
                R::widened(&[0.1, -7.0, 1e30, 1e-40, 3.0, -0.0, 1.0, 0.3]),
                R::of(a.at_most(3.0).sum()),
                R::of(a.greatest()),
                exp(a.at_most(3.0)),
                log(b.size().at_least(1e-300).at_most(1e300)),
                pow(b.size().at_least(1e-300).at_most(1e10), 0.3),
            ];
            let mut quads = [[0.0; 4]; 8];
            R::transposed([a, b, a + b, a * b], &mut quads);
            for r in all.into_iter().chain(R::columns(&quads)) {
                let mut out = [0.0; 8];
                r.store(&mut out);
                self.2.extend(out.iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }));
            }
            let mut parts = [[0.0; 4]; 2];
            let [low, high] = &mut parts;
            a.split(low, high);
            self.2.extend(parts.as_flattened().iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }));
            self.2.extend(quads.as_flattened().iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }));
            self.2.extend([u64::from(a.any_less(b)), u64::from(b.any_less(b))]);
        }
    }

    /// Numbers that round, overflow and aren't; each lane against the scalar's own operation.
    #[test]
    fn all_instruction_sets_give_the_scalars_bits() {
        let a = [0.5, -1.5, 2.5, 1e300, f64::NAN, -0.0, 1.0 / 3.0, -7.9];
        let b = [0.1, 1e-17, -2.5, 1e300, 1.0, 0.0, 3.0, f64::NAN];
        let of = |set: Instructions| {
            let mut out = Vec::new();
            set.run(All(&a, &b, &mut out));
            out
        };
        let expected = of(Instructions(Set::Plain));
        for k in 0..8 {
            let scalar = [a[k] + b[k], a[k] - b[k], a[k] * b[k], a[k] / b[k], a[k].sqrt()];
            for (i, x) in scalar.iter().enumerate() {
                assert!(x.is_nan() || expected[8 * i + k] == x.to_bits(), "{i} {k}");
            }
        }
        for set in Instructions::all() {
            assert_eq!(of(set), expected, "{}", set.name());
        }
        assert_eq!(Instructions::best(), Instructions::all()[0]);
    }
}
