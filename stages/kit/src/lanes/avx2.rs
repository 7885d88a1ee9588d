//! Eight lanes in two 256-bit registers.
use super::{Eight, Quads, Real, Work};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers. Values are made and used by [`run`]'s work alone, so only where the processor has AVX2.
#[derive(Clone, Copy)]
struct Pair(__m256d, __m256d);

/// Does `work`; only [`super::Instructions::run`] calls it, with a set that was detected.
pub(super) fn run(work: impl Work) {
    #[target_feature(enable = "avx2,fma")]
    fn compiled(work: impl Work) {
        work.run::<Pair>();
    }
    // SAFETY: `Instructions` of this set are made only where the processor has the features.
    unsafe { compiled(work) }
}

macro_rules! avx {
    ($e:expr) => {{
        // SAFETY: the features were detected before `run`, which alone makes and uses these values.
        unsafe { $e }
    }};
}

macro_rules! each {
    ($($trait:ident $method:ident $intrinsic:ident),*) => { $(
        impl $trait for Pair {
            type Output = Pair;
            #[inline(always)]
            fn $method(self, other: Pair) -> Pair {
                Pair(avx!($intrinsic(self.0, other.0)), avx!($intrinsic(self.1, other.1)))
            }
        }
    )* }
}
each!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

/// 2^52: a whole number below it lies in the low bits of its sum with this.
const WHOLE: f64 = 4503599627370496.0;

/// Exponents of normal positive numbers, as numbers.
#[inline(always)]
fn exponent(x: __m256d) -> __m256d {
    let biased = avx!(_mm256_srli_epi64::<52>(_mm256_castpd_si256(x)));
    let whole = avx!(_mm256_or_pd(_mm256_castsi256_pd(biased), _mm256_set1_pd(WHOLE)));
    avx!(_mm256_sub_pd(whole, _mm256_set1_pd(WHOLE + 1023.0)))
}

/// The same numbers with exponent 0.
#[inline(always)]
fn mantissa(x: __m256d) -> __m256d {
    let kept = avx!(_mm256_and_pd(x, _mm256_castsi256_pd(_mm256_set1_epi64x(0x000f_ffff_ffff_ffff))));
    avx!(_mm256_or_pd(kept, _mm256_set1_pd(1.0)))
}

/// 2^k for whole k from -1022 to 1023.
#[inline(always)]
fn power(k: __m256d) -> __m256d {
    let whole = avx!(_mm256_castpd_si256(_mm256_add_pd(k, _mm256_set1_pd(WHOLE + 1023.0))));
    avx!(_mm256_castsi256_pd(_mm256_slli_epi64::<52>(whole)))
}

impl Real for Pair {
    #[inline(always)]
    fn of(x: f64) -> Pair {
        let all = avx!(_mm256_set1_pd(x));
        Pair(all, all)
    }
    #[inline(always)]
    fn root(self) -> Pair {
        Pair(avx!(_mm256_sqrt_pd(self.0)), avx!(_mm256_sqrt_pd(self.1)))
    }
    #[inline(always)]
    fn fused(self, factor: Pair, addend: Pair) -> Pair {
        let low = avx!(_mm256_fmadd_pd(self.0, factor.0, addend.0));
        Pair(low, avx!(_mm256_fmadd_pd(self.1, factor.1, addend.1)))
    }
    #[inline(always)]
    fn floor(self) -> Pair {
        Pair(avx!(_mm256_floor_pd(self.0)), avx!(_mm256_floor_pd(self.1)))
    }
    #[inline(always)]
    fn exponent(self) -> Pair {
        Pair(exponent(self.0), exponent(self.1))
    }
    #[inline(always)]
    fn mantissa(self) -> Pair {
        Pair(mantissa(self.0), mantissa(self.1))
    }
    #[inline(always)]
    fn scale(self, exponent: Pair) -> Pair {
        Pair(avx!(_mm256_mul_pd(self.0, power(exponent.0))), avx!(_mm256_mul_pd(self.1, power(exponent.1))))
    }
    #[inline(always)]
    fn where_less(self, a: Pair, b: Pair, other: Pair) -> Pair {
        let low = avx!(_mm256_cmp_pd::<_CMP_LT_OQ>(a.0, b.0));
        let high = avx!(_mm256_cmp_pd::<_CMP_LT_OQ>(a.1, b.1));
        Pair(avx!(_mm256_blendv_pd(other.0, self.0, low)), avx!(_mm256_blendv_pd(other.1, self.1, high)))
    }
    #[inline(always)]
    fn any_less(self, other: Pair) -> bool {
        let low = avx!(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0));
        let high = avx!(_mm256_cmp_pd::<_CMP_LT_OQ>(self.1, other.1));
        avx!(_mm256_movemask_pd(_mm256_or_pd(low, high))) != 0
    }
}

impl Eight for Pair {
    #[inline(always)]
    fn load(from: &[f64; 8]) -> Pair {
        // SAFETY: both halves lie within the array; the features were detected before `run`.
        unsafe { Pair(_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))) }
    }
    #[inline(always)]
    fn widened(from: &[f32; 8]) -> Pair {
        // SAFETY: both halves lie within the array; the features were detected before `run`.
        unsafe {
            Pair(_mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr())), _mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr().add(4))))
        }
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; 8]) {
        // SAFETY: as in `load`.
        unsafe {
            _mm256_storeu_pd(to.as_mut_ptr(), self.0);
            _mm256_storeu_pd(to.as_mut_ptr().add(4), self.1);
        }
    }
    #[inline(always)]
    fn quads(low: &[f64; 4], high: &[f64; 4]) -> Pair {
        Pair(avx!(_mm256_loadu_pd(low.as_ptr())), avx!(_mm256_loadu_pd(high.as_ptr())))
    }
    #[inline(always)]
    fn halves(low: f64, high: f64) -> Pair {
        Pair(avx!(_mm256_set1_pd(low)), avx!(_mm256_set1_pd(high)))
    }
    #[inline(always)]
    fn split(self, low: &mut [f64; 4], high: &mut [f64; 4]) {
        avx!(_mm256_storeu_pd(low.as_mut_ptr(), self.0));
        avx!(_mm256_storeu_pd(high.as_mut_ptr(), self.1));
    }
    #[inline(always)]
    fn fold(self, to: &mut [f64; 4]) {
        avx!(_mm256_storeu_pd(to.as_mut_ptr(), _mm256_add_pd(self.0, self.1)));
    }
    #[inline(always)]
    fn transposed(columns: [Pair; 4], to: &mut Quads) {
        let [a, b, c, d] = columns;
        let (low, high) = (transposed([a.0, b.0, c.0, d.0]), transposed([a.1, b.1, c.1, d.1]));
        for k in 0..4 {
            avx!(_mm256_storeu_pd(to[k].as_mut_ptr(), low[k]));
            avx!(_mm256_storeu_pd(to[k + 4].as_mut_ptr(), high[k]));
        }
    }
    #[inline(always)]
    fn columns(from: &Quads) -> [Pair; 4] {
        let zero = avx!(_mm256_setzero_pd());
        let (mut low, mut high) = ([zero; 4], [zero; 4]);
        for k in 0..4 {
            low[k] = avx!(_mm256_loadu_pd(from[k].as_ptr()));
            high[k] = avx!(_mm256_loadu_pd(from[k + 4].as_ptr()));
        }
        let (low, high) = (transposed(low), transposed(high));
        [Pair(low[0], high[0]), Pair(low[1], high[1]), Pair(low[2], high[2]), Pair(low[3], high[3])]
    }
}

/// Four by four, turned over.
#[inline(always)]
pub(super) fn transposed(rows: [__m256d; 4]) -> [__m256d; 4] {
    let [a, b, c, d] = rows;
    let (ab_even, ab_odd) = (avx!(_mm256_unpacklo_pd(a, b)), avx!(_mm256_unpackhi_pd(a, b)));
    let (cd_even, cd_odd) = (avx!(_mm256_unpacklo_pd(c, d)), avx!(_mm256_unpackhi_pd(c, d)));
    [
        avx!(_mm256_permute2f128_pd::<0x20>(ab_even, cd_even)),
        avx!(_mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd)),
        avx!(_mm256_permute2f128_pd::<0x31>(ab_even, cd_even)),
        avx!(_mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd)),
    ]
}
