//! Eight lanes as a plain array: what the other instruction sets must agree with, bit for bit.
use super::Lanes;
use crate::table::Line;

/// Any processor can do it.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

type F = [f64; 8];

#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> F {
    std::array::from_fn(f)
}

impl Lanes for Portable {
    type F = F;
    #[inline(always)]
    fn splat(self, x: f64) -> F {
        [x; 8]
    }
    #[inline(always)]
    fn load(self, from: &[f64; 8]) -> F {
        *from
    }
    #[inline(always)]
    fn store(self, a: F, to: &mut [f64; 8]) {
        *to = a;
    }
    #[inline(always)]
    fn add(self, a: F, b: F) -> F {
        each(|k| a[k] + b[k])
    }
    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        each(|k| a[k] - b[k])
    }
    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        each(|k| a[k] * b[k])
    }
    #[inline(always)]
    fn fma(self, a: F, b: F, c: F) -> F {
        each(|k| a[k].mul_add(b[k], c[k]))
    }
    #[inline(always)]
    fn fnma(self, a: F, b: F, c: F) -> F {
        each(|k| (-a[k]).mul_add(b[k], c[k]))
    }
    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        each(|k| a[k] / b[k])
    }
    #[inline(always)]
    fn sqrt(self, a: F) -> F {
        a.map(f64::sqrt)
    }
    #[inline(always)]
    fn below(self, a: F, limit: F, other: F) -> F {
        each(|k| if a[k] < limit[k] { a[k] } else { other[k] })
    }
    #[inline(always)]
    fn round(self, a: F) -> F {
        a.map(f64::round_ties_even)
    }
    #[inline(always)]
    fn floor(self, a: F) -> F {
        a.map(f64::floor)
    }
    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        each(|k| if a[k] < b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        each(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn less(self, a: F, b: F) -> u8 {
        (0..8).fold(0, |mask, k| mask | u8::from(a[k] < b[k]) << k)
    }
    #[inline(always)]
    fn sum(self, a: F) -> f64 {
        ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]))
    }
    #[inline(always)]
    fn gather(self, from: &[[f64; 4]], at: &[u32; 8]) -> [F; 4] {
        let rows = at.map(|j| from[j as usize]);
        [0, 1, 2, 3].map(|c| each(|k| rows[k][c]))
    }
    #[inline(always)]
    fn gather_lines(self, from: &[Line], at: F) -> [F; 8] {
        let rows = at.map(|m| from[m as usize].0);
        [0, 1, 2, 3, 4, 5, 6, 7].map(|c| each(|k| rows[k][c]))
    }
    #[inline(always)]
    fn scatter_add(self, to: &mut [f64], at: &[u32; 8], a: F) {
        for k in 0..8 {
            to[at[k] as usize] += a[k];
        }
    }
    #[inline(always)]
    fn scatter_sub(self, to: &mut [[f64; 4]], at: &[u32; 8], [x, y, z]: [F; 3]) {
        for k in 0..8 {
            let row = &mut to[at[k] as usize];
            row[0] -= x[k];
            row[1] -= y[k];
            row[2] -= z[k];
        }
    }
    #[inline(always)]
    fn compress(self, to: &mut [u32; 8], first: u32, mask: u8) -> usize {
        let mut n = 0;
        for k in 0..8 {
            if mask >> k & 1 == 1 {
                to[n] = first + k;
                n += 1;
            }
        }
        n
    }
}
