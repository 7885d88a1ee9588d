//! Eight lanes in two 256-bit registers.
use super::{Kernel, Lanes, load_one};
use crate::table::Line;
use std::arch::x86_64::*;

/// Instructions that need nothing but the processor's features, which `self` proves.
macro_rules! avx {
    ($e:expr) => {{
        // SAFETY: an `Avx2` exists only where `detect` found the features that the intrinsics need.
        unsafe { $e }
    }};
}

/// Proof that the processor has AVX2, FMA, POPCNT and BMI: made by [`Avx2::detect`] alone.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// The proof, if the processor has it.
    pub fn detect() -> Option<Avx2> {
        let has = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("popcnt")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        has.then_some(Avx2(()))
    }

    /// Stops the program unless all of `at` are below `end`.
    #[inline(always)]
    fn check(self, at: &[u32; 8], end: usize) {
        let past = avx!({
            let (at, end) =
                (_mm256_loadu_si256(at.as_ptr().cast()), _mm256_set1_epi32(end.min(u32::MAX as usize) as i32));
            _mm256_movemask_epi8(_mm256_cmpeq_epi32(_mm256_max_epu32(at, end), at)) != 0
        });
        if past {
            super::past_the_end(at, end);
        }
    }
}

/// Runs `kernel`, compiled for AVX2.
pub fn run<K: Kernel>(lanes: Avx2, kernel: K) -> K::Out {
    #[target_feature(enable = "avx2,fma,popcnt,bmi1,bmi2")]
    fn compiled<K: Kernel>(lanes: Avx2, kernel: K) -> K::Out {
        kernel.run(lanes)
    }
    // SAFETY: `lanes` proves that the processor has the features.
    unsafe { compiled(lanes, kernel) }
}

/// Lanes 0 to 3, and 4 to 7.
type F = [__m256d; 2];

/// Applies a 256-bit instruction to both halves.
macro_rules! both {
    ($op:ident, $($a:expr),+) => { avx!([$op($($a[0]),+), $op($($a[1]),+)]) };
}

impl Lanes for Avx2 {
    type F = F;
    #[inline(always)]
    fn splat(self, x: f64) -> F {
        avx!([_mm256_set1_pd(x), _mm256_set1_pd(x)])
    }
    #[inline(always)]
    fn load(self, from: &[f64; 8]) -> F {
        avx!([_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from[4..].as_ptr())])
    }
    #[inline(always)]
    fn store(self, a: F, to: &mut [f64; 8]) {
        avx!({
            _mm256_storeu_pd(to.as_mut_ptr(), a[0]);
            _mm256_storeu_pd(to[4..].as_mut_ptr(), a[1]);
        })
    }
    #[inline(always)]
    fn add(self, a: F, b: F) -> F {
        both!(_mm256_add_pd, a, b)
    }
    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        both!(_mm256_sub_pd, a, b)
    }
    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        both!(_mm256_mul_pd, a, b)
    }
    #[inline(always)]
    fn fma(self, a: F, b: F, c: F) -> F {
        both!(_mm256_fmadd_pd, a, b, c)
    }
    #[inline(always)]
    fn fnma(self, a: F, b: F, c: F) -> F {
        both!(_mm256_fnmadd_pd, a, b, c)
    }
    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        both!(_mm256_div_pd, a, b)
    }
    #[inline(always)]
    fn sqrt(self, a: F) -> F {
        both!(_mm256_sqrt_pd, a)
    }
    #[inline(always)]
    fn below(self, a: F, limit: F, other: F) -> F {
        avx!({
            let low = _mm256_cmp_pd::<_CMP_LT_OQ>(a[0], limit[0]);
            let high = _mm256_cmp_pd::<_CMP_LT_OQ>(a[1], limit[1]);
            [_mm256_blendv_pd(other[0], a[0], low), _mm256_blendv_pd(other[1], a[1], high)]
        })
    }
    #[inline(always)]
    fn round(self, a: F) -> F {
        const NEAREST: i32 = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;
        avx!([_mm256_round_pd::<NEAREST>(a[0]), _mm256_round_pd::<NEAREST>(a[1])])
    }
    #[inline(always)]
    fn floor(self, a: F) -> F {
        const DOWN: i32 = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC;
        avx!([_mm256_round_pd::<DOWN>(a[0]), _mm256_round_pd::<DOWN>(a[1])])
    }
    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        both!(_mm256_min_pd, a, b)
    }
    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        both!(_mm256_max_pd, a, b)
    }
    #[inline(always)]
    fn less(self, a: F, b: F) -> u8 {
        avx!({
            let low = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a[0], b[0]));
            let high = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a[1], b[1]));
            (low | high << 4) as u8
        })
    }
    #[inline(always)]
    fn sum(self, a: F) -> f64 {
        avx!({
            let four = _mm256_add_pd(a[0], a[1]);
            let two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd::<1>(four));
            _mm_cvtsd_f64(two) + _mm_cvtsd_f64(_mm_unpackhi_pd(two, two))
        })
    }
    #[inline(always)]
    fn gather(self, from: &[[f64; 4]], at: &[u32; 8]) -> [F; 4] {
        self.check(at, from.len());
        // SAFETY: `check` found all of them within.
        let row = |k: usize| unsafe { from.get_unchecked(at[k] as usize) }.as_ptr();
        let r = [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)];
        // SAFETY: each of the pointers is to a row of four doubles, and `self` proves AVX2.
        let (low, high) =
            unsafe { (load_transpose4([r[0], r[1], r[2], r[3]]), load_transpose4([r[4], r[5], r[6], r[7]])) };
        [[low[0], high[0]], [low[1], high[1]], [low[2], high[2]], [low[3], high[3]]]
    }
    #[inline(always)]
    fn gather_lines(self, from: &[Line], at: F) -> [F; 8] {
        let mut index = [0u32; 8];
        avx!({
            _mm_storeu_si128(index.as_mut_ptr().cast(), _mm256_cvttpd_epi32(at[0]));
            _mm_storeu_si128(index[4..].as_mut_ptr().cast(), _mm256_cvttpd_epi32(at[1]));
        });
        self.check(&index, from.len());
        // SAFETY: `check` found all of them within.
        let row = |k: usize| unsafe { from.get_unchecked(load_one(&index, k) as usize) }.0.as_ptr();
        let r = [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)];
        // SAFETY: each of the pointers is to a line of eight doubles, and `self` proves AVX2.
        unsafe {
            let a = load_transpose4([r[0], r[1], r[2], r[3]]);
            let b = load_transpose4([r[4], r[5], r[6], r[7]]);
            let c = load_transpose4([r[0].add(4), r[1].add(4), r[2].add(4), r[3].add(4)]);
            let d = load_transpose4([r[4].add(4), r[5].add(4), r[6].add(4), r[7].add(4)]);
            [
                [a[0], b[0]],
                [a[1], b[1]],
                [a[2], b[2]],
                [a[3], b[3]],
                [c[0], d[0]],
                [c[1], d[1]],
                [c[2], d[2]],
                [c[3], d[3]],
            ]
        }
    }
    #[inline(always)]
    fn scatter_add(self, to: &mut [f64], at: &[u32; 8], a: F) {
        let mut lanes = [0.0; 8];
        self.store(a, &mut lanes);
        self.check(at, to.len());
        for k in 0..8 {
            // SAFETY: `check` found all of them within.
            let sum = unsafe { to.get_unchecked_mut(at[k] as usize) };
            *sum += load_one(&lanes, k);
        }
    }
    #[inline(always)]
    fn scatter_sub(self, to: &mut [[f64; 4]], at: &[u32; 8], [x, y, z]: [F; 3]) {
        self.check(at, to.len());
        for half in 0..2 {
            let rows = avx!(transpose4([x[half], y[half], z[half], _mm256_setzero_pd()]));
            for k in 0..4 {
                // SAFETY: `check` found all of them within.
                let row = unsafe { to.get_unchecked_mut(at[4 * half + k] as usize) };
                avx!(_mm256_storeu_pd(row.as_mut_ptr(), _mm256_sub_pd(_mm256_loadu_pd(row.as_ptr()), rows[k])));
            }
        }
    }
    #[inline(always)]
    fn compress(self, to: &mut [u32; 8], first: u32, mask: u8) -> usize {
        let (mut left, mut n) = (mask, 0);
        while left != 0 {
            to[n & 7] = first + left.trailing_zeros();
            left &= left - 1;
            n += 1;
        }
        n
    }
}

/// # Safety
/// The processor has AVX2.
#[inline(always)]
unsafe fn transpose4(r: [__m256d; 4]) -> [__m256d; 4] {
    // SAFETY: by the function's own contract.
    unsafe {
        let (a, b) = (_mm256_unpacklo_pd(r[0], r[1]), _mm256_unpackhi_pd(r[0], r[1]));
        let (c, d) = (_mm256_unpacklo_pd(r[2], r[3]), _mm256_unpackhi_pd(r[2], r[3]));
        [
            _mm256_permute2f128_pd::<0x20>(a, c),
            _mm256_permute2f128_pd::<0x20>(b, d),
            _mm256_permute2f128_pd::<0x31>(a, c),
            _mm256_permute2f128_pd::<0x31>(b, d),
        ]
    }
}

/// # Safety
/// Each pointer is to four doubles, and the processor has AVX2.
#[inline(always)]
unsafe fn load_transpose4(r: [*const f64; 4]) -> [__m256d; 4] {
    // SAFETY: by the function's own contract.
    unsafe { transpose4([_mm256_loadu_pd(r[0]), _mm256_loadu_pd(r[1]), _mm256_loadu_pd(r[2]), _mm256_loadu_pd(r[3])]) }
}
