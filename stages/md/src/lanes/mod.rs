//! Eight f64 at a time with the same bits on every processor: AVX-512, AVX2 or plain arrays, chosen at run time.
//!
//! Every operation has one defined result: products and sums are fused only where [`Lanes::fma`] says so, and
//! [`Lanes::sum`] adds in one fixed tree. A kernel is written once, generic over [`Lanes`], and [`run`] compiles
//! it for each instruction set.
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;
use crate::table::Line;

/// Eight doubles as a kernel's code sees them. A value of the implementing type is the proof that the processor can do it.
pub trait Lanes: Copy {
    /// Eight doubles.
    type F: Copy;
    /// All lanes `x`.
    fn splat(self, x: f64) -> Self::F;
    /// From memory.
    fn load(self, from: &[f64; 8]) -> Self::F;
    /// To memory.
    fn store(self, a: Self::F, to: &mut [f64; 8]);
    /// a + b
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// a - b
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b + c, rounded once.
    fn fma(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// c - a b, rounded once.
    fn fnma(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// a / b
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// Square root.
    fn sqrt(self, a: Self::F) -> Self::F;
    /// Nearest integer, ties to even.
    fn round(self, a: Self::F) -> Self::F;
    /// Greatest integer not above.
    fn floor(self, a: Self::F) -> Self::F;
    /// `if a < b { a } else { b }`: b where a is NaN.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// `if a > b { a } else { b }`: b where a is NaN.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// `if a < limit { a } else { other }`: other where a is NaN.
    fn below(self, a: Self::F, limit: Self::F, other: Self::F) -> Self::F;
    /// Bit k set where lane k of a is less than that of b.
    fn less(self, a: Self::F, b: Self::F) -> u8;
    /// `((a0 + a4) + (a2 + a6)) + ((a1 + a5) + (a3 + a7))`
    fn sum(self, a: Self::F) -> f64;
    /// The four components of `from[at[k]]`, component c in vector c.
    fn gather(self, from: &[[f64; 4]], at: &[u32; 8]) -> [Self::F; 4];
    /// The eight coefficients of `from[at]`, coefficient c in vector c; `at` holds whole numbers.
    fn gather_lines(self, from: &[Line], at: Self::F) -> [Self::F; 8];
    /// `to[at[k]] += a[k]`, k ascending.
    fn scatter_add(self, to: &mut [f64], at: &[u32; 8], a: Self::F);
    /// `to[at[k]] -= [x[k], y[k], z[k], 0]`, k ascending.
    fn scatter_sub(self, to: &mut [[f64; 4]], at: &[u32; 8], xyz: [Self::F; 3]);
    /// Writes `first + k` for each set bit k of `mask` to the front of `to`, ascending; returns how many.
    fn compress(self, to: &mut [u32; 8], first: u32, mask: u8) -> usize;
}

/// Element `k` of `array`, loaded by itself: compilers would rather shuffle it out of the register that `array` was stored
/// from, which costs more.
#[inline(always)]
fn load_one<T: Copy>(array: &[T; 8], k: usize) -> T {
    // SAFETY: a reference to an element may be read from.
    unsafe { std::ptr::read_volatile(&array[k]) }
}

/// What is said of an index past the end: kernels check eight at a time.
#[cold]
fn past_the_end(at: &[u32; 8], end: usize) -> ! {
    panic!("an index of {at:?} is not below {end}")
}

/// A piece of work that runs on any lanes.
pub trait Kernel {
    /// What it returns.
    type Out;
    /// Does it; to be marked `#[inline(always)]`, with everything it calls, so that it is compiled for the lanes' processor.
    fn run<L: Lanes>(self, lanes: L) -> Self::Out;
}

/// An instruction set that this processor has.
#[derive(Clone, Copy, Debug)]
pub struct Isa(Set);

#[derive(Clone, Copy, Debug)]
enum Set {
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    Portable,
}

impl Isa {
    /// All that this processor has, the fastest first.
    pub fn all() -> Vec<Isa> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        all.extend(avx512::Avx512::detect().map(|a| Isa(Set::Avx512(a))));
        #[cfg(target_arch = "x86_64")]
        all.extend(avx2::Avx2::detect().map(|a| Isa(Set::Avx2(a))));
        all.push(Isa(Set::Portable));
        all
    }

    /// The fastest that this processor has.
    pub fn best() -> Isa {
        Isa::all()[0]
    }

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(_) => "avx512",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(_) => "avx2",
            Set::Portable => "portable",
        }
    }
}

/// Runs `kernel` on the lanes of `isa`.
pub fn run<K: Kernel>(isa: Isa, kernel: K) -> K::Out {
    match isa.0 {
        #[cfg(target_arch = "x86_64")]
        Set::Avx512(lanes) => avx512::run(lanes, kernel),
        #[cfg(target_arch = "x86_64")]
        Set::Avx2(lanes) => avx2::run(lanes, kernel),
        Set::Portable => kernel.run(portable::Portable),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation once, on numbers that round, tie, cancel, overflow and aren't.
    struct All<'a> {
        a: [f64; 8],
        b: [f64; 8],
        quads: &'a [[f64; 4]],
        lines: &'a [Line],
    }
    impl Kernel for All<'_> {
        type Out = Vec<u64>;
        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Vec<u64> {
            let (a, b) = (l.load(&self.a), l.load(&self.b));
            let at = [3, 1, 4, 1, 5, 9, 2, 6];
            let mut results = vec![l.add(a, b), l.sub(a, b), l.mul(a, b), l.fma(a, b, a), l.fnma(a, b, a)];
            results.extend([l.div(a, b), l.sqrt(l.mul(b, b)), l.below(a, b, l.splat(0.3)), l.below(b, a, a)]);
            results.extend([l.round(a), l.floor(a), l.min(a, b), l.max(a, b), l.splat(self.a[1])]);
            results.extend(l.gather(self.quads, &at));
            let whole = l.load(&[0.0, 2.0, 1.0, 2.0, 3.0, 0.0, 1.0, 3.0]);
            results.extend(l.gather_lines(self.lines, whole));
            let mut all = Vec::new();
            for r in results {
                let mut out = [0.0; 8];
                l.store(r, &mut out);
                all.extend(out);
            }
            let finite = l.load(&self.quads.as_flattened()[..8].try_into().unwrap());
            let (mut sums, mut quads) = (vec![0.1; 10], self.quads.to_vec());
            l.scatter_add(&mut sums, &at, finite);
            l.scatter_sub(&mut quads, &at, [finite, b, finite]);
            all.extend(sums);
            all.extend(quads.into_iter().flatten());
            all.push(l.sum(finite));
            // NaN has many bit patterns; that it is NaN is all that counts
            let mut bits: Vec<u64> = all.iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect();
            for mask in [l.less(a, b), l.less(b, a), 0, 255, 0b1010_0110] {
                let mut out = [0; 8];
                let n = l.compress(&mut out, 7, mask);
                bits.push(u64::from(mask));
                bits.extend(out[..n].iter().map(|&x| u64::from(x)));
            }
            bits
        }
    }

    #[test]
    fn all_instruction_sets_give_the_same_bits() {
        let quads: Vec<[f64; 4]> = (0..10).map(|k| [0.1, 1.3, -2.7, 1e-3].map(|x| x * (k as f64 + 0.77))).collect();
        let lines: Vec<Line> =
            (0..4).map(|k| Line([1, 2, 3, 4, 5, 6, 7, 8].map(|c| f64::from(c * (k + 3)).sqrt()))).collect();
        let a = [0.5, -1.5, 2.5, 1e300, f64::NAN, -0.0, 1.0 / 3.0, -7.9];
        let b = [0.1, 1e-17, -2.5, 1e300, 1.0, 0.0, 3.0, f64::NAN];
        let of = |isa| run(isa, All { a, b, quads: &quads, lines: &lines });
        let expected = of(Isa(Set::Portable));
        for isa in Isa::all() {
            assert_eq!(of(isa), expected, "{}", isa.name());
        }
    }
}
