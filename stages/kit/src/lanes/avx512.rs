//! Eight lanes in one 512-bit register.
use super::{Eight, Real, Work};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers. Values are made and used by [`run`]'s work alone, so only where the processor has AVX-512 F.
#[derive(Clone, Copy)]
struct Wide(__m512d);

/// Does `work`; only [`super::Instructions::run`] calls it, with a set that was detected.
pub(super) fn run(work: impl Work) {
    #[target_feature(enable = "avx512f,avx2,fma")]
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
    fn fused(self, factor: Wide, addend: Wide) -> Wide {
        Wide(avx!(_mm512_fmadd_pd(self.0, factor.0, addend.0)))
    }
    #[inline(always)]
    fn floor(self) -> Wide {
        Wide(avx!(_mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0)))
    }
    #[inline(always)]
    fn exponent(self) -> Wide {
        Wide(avx!(_mm512_getexp_pd(self.0)))
    }
    #[inline(always)]
    fn mantissa(self) -> Wide {
        Wide(avx!(_mm512_getmant_pd::<_MM_MANT_NORM_1_2, _MM_MANT_SIGN_SRC>(self.0)))
    }
    #[inline(always)]
    fn scale(self, exponent: Wide) -> Wide {
        Wide(avx!(_mm512_scalef_pd(self.0, exponent.0)))
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
    #[inline(always)]
    fn quads(low: &[f64; 4], high: &[f64; 4]) -> Wide {
        let low = avx!(_mm512_castpd256_pd512(_mm256_loadu_pd(low.as_ptr())));
        Wide(avx!(_mm512_insertf64x4::<1>(low, _mm256_loadu_pd(high.as_ptr()))))
    }
    #[inline(always)]
    fn halves(low: f64, high: f64) -> Wide {
        Wide(avx!(_mm512_mask_broadcastsd_pd(_mm512_set1_pd(low), 0xf0, _mm_set_sd(high))))
    }
    #[inline(always)]
    fn folded(self) -> [f64; 4] {
        let mut quad = [0.0; 4];
        let sum = avx!(_mm256_add_pd(_mm512_castpd512_pd256(self.0), _mm512_extractf64x4_pd::<1>(self.0)));
        avx!(_mm256_storeu_pd(quad.as_mut_ptr(), sum));
        quad
    }
}
