//! Eight lanes in one 512-bit register.
use super::avx2::transposed;
use super::{Eight, Quads, Real, Work};
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
    fn widened(from: &[f32; 8]) -> Wide {
        Wide(avx!(_mm512_cvtps_pd(_mm256_loadu_ps(from.as_ptr()))))
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
    fn split(self, low: &mut [f64; 4], high: &mut [f64; 4]) {
        let halves = self.halved();
        avx!(_mm256_storeu_pd(low.as_mut_ptr(), halves.0));
        avx!(_mm256_storeu_pd(high.as_mut_ptr(), halves.1));
    }
    #[inline(always)]
    fn fold(self, to: &mut [f64; 4]) {
        let (low, high) = self.halved();
        avx!(_mm256_storeu_pd(to.as_mut_ptr(), _mm256_add_pd(low, high)));
    }
    #[inline(always)]
    fn transposed(columns: [Wide; 4], to: &mut Quads) {
        let [a, b, c, d] = [columns[0].halved(), columns[1].halved(), columns[2].halved(), columns[3].halved()];
        let (low, high) = (transposed([a.0, b.0, c.0, d.0]), transposed([a.1, b.1, c.1, d.1]));
        for k in 0..4 {
            avx!(_mm256_storeu_pd(to[k].as_mut_ptr(), low[k]));
            avx!(_mm256_storeu_pd(to[k + 4].as_mut_ptr(), high[k]));
        }
    }
    #[inline(always)]
    fn columns(from: &Quads) -> [Wide; 4] {
        let zero = avx!(_mm256_setzero_pd());
        let (mut low, mut high) = ([zero; 4], [zero; 4]);
        for k in 0..4 {
            low[k] = avx!(_mm256_loadu_pd(from[k].as_ptr()));
            high[k] = avx!(_mm256_loadu_pd(from[k + 4].as_ptr()));
        }
        let (low, high) = (transposed(low), transposed(high));
        [joined(low[0], high[0]), joined(low[1], high[1]), joined(low[2], high[2]), joined(low[3], high[3])]
    }
}

impl Wide {
    /// The first four and the last four.
    #[inline(always)]
    fn halved(self) -> (__m256d, __m256d) {
        (avx!(_mm512_castpd512_pd256(self.0)), avx!(_mm512_extractf64x4_pd::<1>(self.0)))
    }
}

#[inline(always)]
fn joined(low: __m256d, high: __m256d) -> Wide {
    Wide(avx!(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)))
}
