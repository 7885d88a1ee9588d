//! Many states at once: the bits of one at a time, on every instruction set, in every regime and on every border.
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray, Instructions, Phase, Point, Points};

fn same(a: Point, b: Point) -> bool {
    let bits = |p: Point| [p.pressure, p.temperature, p.sound_speed, p.liquid].map(f64::to_bits);
    a.phase == b.phase && bits(a) == bits(b)
}

/// States from 0.3 V0 to 1e4 V0, from below the cold curve to 30 MJ/kg, and on every border, in no order.
fn states(gray: &Gray, n: usize) -> (Vec<f64>, Vec<f64>) {
    let v0 = gray.parameters().volume;
    let mut seed = 7u64;
    let mut uniform = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n)
        .map(|i| {
            let v = v0 * if i % 5 == 0 { 1e4f64.powf(uniform()) } else { 0.3 + 1.2 * uniform() };
            let borders = gray.borders(v);
            let t = match i % 7 {
                0..3 => borders[i % 3],
                3 => 1.5 * uniform() * borders[0],
                _ => borders[0] + (borders[1] - borders[0]) * uniform(),
            };
            let energy = gray.at(v, t).0.energy;
            (v, if i % 11 == 0 { 30e6 * uniform() - 1e6 } else { energy })
        })
        .unzip()
}

#[test]
fn the_batch_has_the_scalars_bits() {
    for set in Set::ALL {
        let gray = Gray::new(set.parameters()).unwrap();
        let (v, e) = states(&gray, 20_011);
        let eos = Eos::Gray(gray);
        let mut seen = [0; 5];
        for instructions in Instructions::all() {
            let mut out = Points::default();
            eos.evaluate_with(instructions, &v, &e, &mut out);
            for i in 0..v.len() {
                let one = eos.point(v[i], e[i]);
                assert!(
                    same(out.get(i), one),
                    "{set:?} {} {} {}: {:?} {one:?}",
                    instructions.name(),
                    v[i],
                    e[i],
                    out.get(i)
                );
                seen[one.phase as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
    }
}

/// Any length, also below eight; and models without vectors.
#[test]
fn short_batches_and_other_models() {
    let gray = Gray::new(Set::CopperRoyce.parameters()).unwrap();
    let (v, e) = states(&gray, 100);
    let gas = Eos::IdealGas(hvi_eos::IdealGas::new(1.0, 1.4, 700.0, 300.0).unwrap());
    for eos in [Eos::Gray(gray), gas] {
        let mut out = Points::default();
        for n in [0, 1, 7, 8, 9, 63, 64, 65, 100] {
            eos.evaluate(&v[..n], &e[..n], &mut out);
            assert_eq!(out.phase.len(), n);
            assert!((0..n).all(|i| same(out.get(i), eos.point(v[i], e[i]))));
        }
    }
    assert_eq!(Phase::Vapour as u8, 4);
}
