//! Eight lanes in one 512-bit register.
use super::{Kernel, Lanes, load_one};
use crate::table::Line;
use std::arch::x86_64::*;

/// Instructions that need nothing but the processor's features, which `self` proves.
macro_rules! avx {
    ($e:expr) => {{
        // SAFETY: an `Avx512` exists only where `detect` found the features that the intrinsics need.
        unsafe { $e }
    }};
}

/// Proof that the processor has AVX-512 F, VL and DQ, AVX2, FMA, POPCNT and BMI: made by [`Avx512::detect`] alone.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

impl Avx512 {
    /// The proof, if the processor has it.
    pub fn detect() -> Option<Avx512> {
        let has = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("popcnt")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        has.then_some(Avx512(()))
    }

    /// Stops the program unless all of `at` are below `end`.
    #[inline(always)]
    fn check(self, at: &[u32; 8], end: usize) {
        let past = avx!({
            let (at, end) =
                (_mm256_loadu_si256(at.as_ptr().cast()), _mm256_set1_epi32(end.min(u32::MAX as usize) as i32));
            _mm256_cmpge_epu32_mask(at, end) != 0
        });
        if past {
            super::past_the_end(at, end);
        }
    }
}

/// Runs `kernel`, compiled for AVX-512.
pub fn run<K: Kernel>(lanes: Avx512, kernel: K) -> K::Out {
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma,popcnt,bmi1,bmi2")]
    fn compiled<K: Kernel>(lanes: Avx512, kernel: K) -> K::Out {
        kernel.run(lanes)
    }
    // SAFETY: `lanes` proves that the processor has the features.
    unsafe { compiled(lanes, kernel) }
}

impl Lanes for Avx512 {
    type F = __m512d;
    #[inline(always)]
    fn splat(self, x: f64) -> __m512d {
        avx!(_mm512_set1_pd(x))
    }
    #[inline(always)]
    fn load(self, from: &[f64; 8]) -> __m512d {
        avx!(_mm512_loadu_pd(from.as_ptr()))
    }
    #[inline(always)]
    fn store(self, a: __m512d, to: &mut [f64; 8]) {
        avx!(_mm512_storeu_pd(to.as_mut_ptr(), a))
    }
    #[inline(always)]
    fn add(self, a: __m512d, b: __m512d) -> __m512d {
        avx!(_mm512_add_pd(a, b))
    }
    #[inline(always)]
    fn sub(self, a: __m512d, b: __m512d) -> __m512d {
        avx!(_mm512_sub_pd(a, b))
    }
    #[inline(always)]
    fn mul(self, a: __m512d, b: __m512d) -> __m512d {
        avx!(_mm512_mul_pd(a, b))
    }
    #[inline(always)]
    fn fma(self, a: __m512d, b: __m512d, c: __m512d) -> __m512d {
        avx!(_mm512_fmadd_pd(a, b, c))
    }
    #[inline(always)]
    fn fnma(self, a: __m512d, b: __m512d, c: __m512d) -> __m512d {
        avx!(_mm512_fnmadd_pd(a, b, c))
    }
    #[inline(always)]
    fn div(self, a: __m512d, b: __m512d) -> __m512d {
        avx!(_mm512_div_pd(a, b))
    }
    #[inline(always)]
    fn sqrt(self, a: __m512d) -> __m512d {
        avx!(_mm512_sqrt_pd(a))
    }
    #[inline(always)]
    fn below(self, a: __m512d, limit: __m512d, other: __m512d) -> __m512d {
        avx!(_mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, limit), other, a))
    }
    #[inline(always)]
    fn round(self, a: __m512d) -> __m512d {
        avx!(_mm512_roundscale_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(a))
    }
    #[inline(always)]
    fn floor(self, a: __m512d) -> __m512d {
        avx!(_mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(a))
    }
    #[inline(always)]
    fn min(self, a: __m512d, b: __m512d) -> __m512d {
        avx!(_mm512_min_pd(a, b))
    }
    #[inline(always)]
    fn max(self, a: __m512d, b: __m512d) -> __m512d {
        avx!(_mm512_max_pd(a, b))
    }
    #[inline(always)]
    fn less(self, a: __m512d, b: __m512d) -> u8 {
        avx!(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn sum(self, a: __m512d) -> f64 {
        avx!({
            let four = _mm256_add_pd(_mm512_castpd512_pd256(a), _mm512_extractf64x4_pd::<1>(a));
            let two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd::<1>(four));
            _mm_cvtsd_f64(two) + _mm_cvtsd_f64(_mm_unpackhi_pd(two, two))
        })
    }
    #[inline(always)]
    fn gather(self, from: &[[f64; 4]], at: &[u32; 8]) -> [__m512d; 4] {
        self.check(at, from.len());
        // SAFETY: `check` found all of them within.
        let row = |k: usize| unsafe { from.get_unchecked(at[k] as usize) }.as_ptr();
        avx!({
            let z0 = pair(row(0), row(4));
            let z1 = pair(row(1), row(5));
            let z2 = pair(row(2), row(6));
            let z3 = pair(row(3), row(7));
            transpose4([z0, z1, z2, z3])
        })
    }
    #[inline(always)]
    fn gather_lines(self, from: &[Line], at: __m512d) -> [__m512d; 8] {
        let mut index = [0u32; 8];
        avx!(_mm256_storeu_si256(index.as_mut_ptr().cast(), _mm512_cvttpd_epi32(at)));
        self.check(&index, from.len());
        // SAFETY: `check` found all of them within.
        let row = |k: usize| unsafe { from.get_unchecked(load_one(&index, k) as usize) }.0.as_ptr();
        avx!({
            let r = [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)];
            transpose8([
                _mm512_loadu_pd(r[0]),
                _mm512_loadu_pd(r[1]),
                _mm512_loadu_pd(r[2]),
                _mm512_loadu_pd(r[3]),
                _mm512_loadu_pd(r[4]),
                _mm512_loadu_pd(r[5]),
                _mm512_loadu_pd(r[6]),
                _mm512_loadu_pd(r[7]),
            ])
        })
    }
    #[inline(always)]
    fn scatter_add(self, to: &mut [f64], at: &[u32; 8], a: __m512d) {
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
    fn scatter_sub(self, to: &mut [[f64; 4]], at: &[u32; 8], [x, y, z]: [__m512d; 3]) {
        let rows = avx!(transpose4([x, y, z, _mm512_setzero_pd()]));
        self.check(at, to.len());
        for k in 0..8 {
            let row = rows[k & 3];
            let row = avx!(if k < 4 { _mm512_castpd512_pd256(row) } else { _mm512_extractf64x4_pd::<1>(row) });
            // SAFETY: `check` found all of them within.
            subtract(unsafe { to.get_unchecked_mut(at[k] as usize) }, row);
        }
    }
    #[inline(always)]
    fn compress(self, to: &mut [u32; 8], first: u32, mask: u8) -> usize {
        avx!({
            let ramp = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let all = _mm256_add_epi32(_mm256_set1_epi32(first as i32), ramp);
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(mask, all));
        });
        mask.count_ones() as usize
    }
}

#[inline(always)]
fn subtract(row: &mut [f64; 4], a: __m256d) {
    avx!(_mm256_storeu_pd(row.as_mut_ptr(), _mm256_sub_pd(_mm256_loadu_pd(row.as_ptr()), a)))
}

/// Four doubles from `low` and four from `high`.
///
/// # Safety
/// Both point to four doubles, and the processor has AVX-512 F.
#[inline(always)]
unsafe fn pair(low: *const f64, high: *const f64) -> __m512d {
    // SAFETY: by the function's own contract.
    unsafe { _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(_mm256_loadu_pd(low)), _mm256_loadu_pd(high)) }
}

/// Lane k of result c is element c of row k, where row k is the low half of `z[k]` and row k + 4 its high half;
/// its own inverse.
///
/// # Safety
/// The processor has AVX-512 F.
#[inline(always)]
unsafe fn transpose4(z: [__m512d; 4]) -> [__m512d; 4] {
    // SAFETY: by the function's own contract.
    unsafe {
        let (l0, l2) = (_mm512_unpacklo_pd(z[0], z[1]), _mm512_unpacklo_pd(z[2], z[3]));
        let (h0, h2) = (_mm512_unpackhi_pd(z[0], z[1]), _mm512_unpackhi_pd(z[2], z[3]));
        let even = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let odd = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        [
            _mm512_permutex2var_pd(l0, even, l2),
            _mm512_permutex2var_pd(h0, even, h2),
            _mm512_permutex2var_pd(l0, odd, l2),
            _mm512_permutex2var_pd(h0, odd, h2),
        ]
    }
}

/// Lane k of result c is lane c of row k.
///
/// # Safety
/// The processor has AVX-512 F.
#[inline(always)]
unsafe fn transpose8(r: [__m512d; 8]) -> [__m512d; 8] {
    // SAFETY: by the function's own contract.
    unsafe {
        let (t0, t1) = (_mm512_unpacklo_pd(r[0], r[1]), _mm512_unpackhi_pd(r[0], r[1]));
        let (t2, t3) = (_mm512_unpacklo_pd(r[2], r[3]), _mm512_unpackhi_pd(r[2], r[3]));
        let (t4, t5) = (_mm512_unpacklo_pd(r[4], r[5]), _mm512_unpackhi_pd(r[4], r[5]));
        let (t6, t7) = (_mm512_unpacklo_pd(r[6], r[7]), _mm512_unpackhi_pd(r[6], r[7]));
        let (u0, u1) = (_mm512_shuffle_f64x2::<0x88>(t0, t2), _mm512_shuffle_f64x2::<0xdd>(t0, t2));
        let (u2, u3) = (_mm512_shuffle_f64x2::<0x88>(t4, t6), _mm512_shuffle_f64x2::<0xdd>(t4, t6));
        let (v0, v1) = (_mm512_shuffle_f64x2::<0x88>(t1, t3), _mm512_shuffle_f64x2::<0xdd>(t1, t3));
        let (v2, v3) = (_mm512_shuffle_f64x2::<0x88>(t5, t7), _mm512_shuffle_f64x2::<0xdd>(t5, t7));
        [
            _mm512_shuffle_f64x2::<0x88>(u0, u2),
            _mm512_shuffle_f64x2::<0x88>(v0, v2),
            _mm512_shuffle_f64x2::<0x88>(u1, u3),
            _mm512_shuffle_f64x2::<0x88>(v1, v3),
            _mm512_shuffle_f64x2::<0xdd>(u0, u2),
            _mm512_shuffle_f64x2::<0xdd>(v0, v2),
            _mm512_shuffle_f64x2::<0xdd>(u1, u3),
            _mm512_shuffle_f64x2::<0xdd>(v1, v3),
        ]
    }
}
