//! Eight lanes in two 256-bit registers.
use super::{Eight, Real, Work};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers. Values are made and used by [`run`]'s work alone, so only where the processor has AVX2.
#[derive(Clone, Copy)]
struct Pair(__m256d, __m256d);

/// Does `work`; only [`super::Instructions::run`] calls it, with a set that was detected.
pub(super) fn run(work: impl Work) {
    #[target_feature(enable = "avx2")]
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
    fn store(self, to: &mut [f64; 8]) {
        // SAFETY: as in `load`.
        unsafe {
            _mm256_storeu_pd(to.as_mut_ptr(), self.0);
            _mm256_storeu_pd(to.as_mut_ptr().add(4), self.1);
        }
    }
}
