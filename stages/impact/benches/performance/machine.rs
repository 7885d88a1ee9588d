//! What one core of the machine can do: memory bandwidth and fused products a second.
use super::cpu;
use hvi_kit::lanes::{Eight, Instructions, Work};

/// One core.
pub struct Machine {
    /// Its name.
    pub name: String,
    /// `a = b + s c` over arrays far larger than the caches [GB/s], what is read to be written over included.
    pub memory: f64,
    /// Multiplications and additions in doubles, by instruction set [GFLOP/s].
    pub flops: Vec<(&'static str, f64)>,
}

/// Measures it, in about two seconds.
pub fn measure() -> Machine {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1)).unwrap_or("unknown");
    // Plain arrays would be a measure of the compiler.
    let sets = Instructions::all().into_iter().filter(|set| !set.is_portable());
    Machine { name: name.into(), memory: memory(), flops: sets.map(|set| (set.name(), flops(set))).collect() }
}

fn memory() -> f64 {
    let n = 8 << 20;
    let (mut a, b, c) = (vec![0.0f64; n], vec![1.0f64; n], vec![2.0f64; n]);
    let rounds = (0..9).map(|round| {
        let start = cpu::thread();
        for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
            *a = b + round as f64 * c;
        }
        std::hint::black_box(&mut a);
        32.0 * n as f64 / (cpu::thread() - start)
    });
    1e-9 * cpu::median(rounds.collect())
}

/// Chains of fused products, more than their latency needs.
struct Chains<'a>(&'a mut f64);

const CHAINS: usize = 12;
const LENGTH: usize = 2_000_000;

impl Work for Chains<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let (factor, addend) = (R::of(0.999), R::of(1e-3));
        let mut x = [R::of(0.5); CHAINS];
        for _ in 0..LENGTH {
            for x in &mut x {
                *x = x.fused(factor, addend);
            }
        }
        for x in x {
            *self.0 += x.sum();
        }
    }
}

fn flops(set: Instructions) -> f64 {
    let rounds = (0..5).map(|_| {
        let (start, mut sum) = (cpu::thread(), 0.0);
        set.run(Chains(&mut sum));
        std::hint::black_box(sum);
        (2 * 8 * CHAINS * LENGTH) as f64 / (cpu::thread() - start)
    });
    1e-9 * cpu::median(rounds.collect())
}
