//! Eight lanes in one 512-bit register.
use super::{Eight, Real, Work};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers. Values are made and used by [`run`]'s work alone, so only where the processor has AVX-512 F.
#[derive(Clone, Copy)]
struct Wide(__m512d);

/// Does `work`; only [`super::Instructions::run`] calls it, with a set that was detected.
pub(super) fn run(work: impl Work) {
    #[target_feature(enable = "avx512f,avx2")]
    fn compiled(work: impl Work) {
        work.run::<Wide>();
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
        impl $trait for Wide {
            type Output = Wide;
            #[inline(always)]
            fn $method(self, other: Wide) -> Wide {
                Wide(avx!($intrinsic(self.0, other.0)))
            }
        }
    )* }
}
each!(Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

impl Real for Wide {
    #[inline(always)]
    fn of(x: f64) -> Wide {
        Wide(avx!(_mm512_set1_pd(x)))
    }
    #[inline(always)]
    fn root(self) -> Wide {
        Wide(avx!(_mm512_sqrt_pd(self.0)))
    }
    #[inline(always)]
    fn where_less(self, a: Wide, b: Wide, other: Wide) -> Wide {
        Wide(avx!(_mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a.0, b.0), other.0, self.0)))
    }
    #[inline(always)]
    fn any_less(self, other: Wide) -> bool {
        avx!(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0)) != 0
    }
}

impl Eight for Wide {
    #[inline(always)]
    fn load(from: &[f64; 8]) -> Wide {
        Wide(avx!(_mm512_loadu_pd(from.as_ptr())))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; 8]) {
        avx!(_mm512_storeu_pd(to.as_mut_ptr(), self.0))
    }
}
