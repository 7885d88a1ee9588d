//! Eight lanes in a plain array, on any processor.
use super::{Eight, Quads, Real};
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers.
#[derive(Clone, Copy)]
pub struct Plain([f64; 8]);

macro_rules! each {
    ($($trait:ident $method:ident $op:tt),*) => { $(
        impl $trait for Plain {
            type Output = Plain;
            #[inline(always)]
            fn $method(self, other: Plain) -> Plain {
                Plain(std::array::from_fn(|k| self.0[k] $op other.0[k]))
            }
        }
    )* }
}
each!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Real for Plain {
    #[inline(always)]
    fn of(x: f64) -> Plain {
        Plain([x; 8])
    }
    #[inline(always)]
    fn root(self) -> Plain {
        Plain(self.0.map(f64::sqrt))
    }
    // Not copied into each place of use: without the instruction it is eight calls.
    #[inline(never)]
    fn fused(self, factor: Plain, addend: Plain) -> Plain {
        Plain(std::array::from_fn(|k| self.0[k].mul_add(factor.0[k], addend.0[k])))
    }
    #[inline(always)]
    fn floor(self) -> Plain {
        Plain(self.0.map(f64::floor))
    }
    #[inline(always)]
    fn exponent(self) -> Plain {
        Plain(self.0.map(Real::exponent))
    }
    #[inline(always)]
    fn mantissa(self) -> Plain {
        Plain(self.0.map(Real::mantissa))
    }
    #[inline(always)]
    fn scale(self, exponent: Plain) -> Plain {
        Plain(std::array::from_fn(|k| self.0[k].scale(exponent.0[k])))
    }
    #[inline(always)]
    fn where_less(self, a: Plain, b: Plain, other: Plain) -> Plain {
        Plain(std::array::from_fn(|k| if a.0[k] < b.0[k] { self.0[k] } else { other.0[k] }))
    }
    #[inline(always)]
    fn any_less(self, other: Plain) -> bool {
        (0..8).any(|k| self.0[k] < other.0[k])
    }
}

impl Eight for Plain {
    const IS_PORTABLE: bool = true;
    #[inline(always)]
    fn load(from: &[f64; 8]) -> Plain {
        Plain(*from)
    }
    #[inline(always)]
    fn widened(from: &[f32; 8]) -> Plain {
        Plain(from.map(f64::from))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; 8]) {
        *to = self.0;
    }
    #[inline(always)]
    fn quads(low: &[f64; 4], high: &[f64; 4]) -> Plain {
        Plain([low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]])
    }
    #[inline(always)]
    fn halves(low: f64, high: f64) -> Plain {
        Plain([low, low, low, low, high, high, high, high])
    }
    #[inline(always)]
    fn split(self, low: &mut [f64; 4], high: &mut [f64; 4]) {
        low.copy_from_slice(&self.0[..4]);
        high.copy_from_slice(&self.0[4..]);
    }
    #[inline(always)]
    fn fold(self, to: &mut [f64; 4]) {
        for k in 0..4 {
            to[k] = self.0[k] + self.0[k + 4];
        }
    }
    #[inline(always)]
    fn transposed(columns: [Plain; 4], to: &mut Quads) {
        for k in 0..8 {
            for c in 0..4 {
                to[k][c] = columns[c].0[k];
            }
        }
    }
    #[inline(always)]
    fn columns(from: &Quads) -> [Plain; 4] {
        let mut columns = [Plain([0.0; 8]); 4];
        for k in 0..8 {
            for c in 0..4 {
                columns[c].0[k] = from[k][c];
            }
        }
        columns
    }
}
