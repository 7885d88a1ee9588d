//! GRAY in patches: within the stated error of GRAY everywhere, continuous, the same bits in every way of asking.
use hvi_eos::definition::Definition;
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray, Instructions, Patches, Phase, Point, Points};

/// Uniform numbers in 0..1 from a 64-bit xorshift generator (Marsaglia 2003).
fn numbers() -> impl FnMut() -> f64 {
    let mut seed = 11u64;
    move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// States of all regimes and beyond them.
fn states(gray: &Gray, n: usize) -> (Vec<f64>, Vec<f64>) {
    let v0 = gray.parameters().volume;
    let mut uniform = numbers();
    (0..n)
        .map(|i| {
            let v = v0 * if i % 9 == 0 { 1e3f64.powf(uniform()) } else { 0.38 + 1.12 * uniform() };
            let [start, end, hot] = gray.borders(v);
            let range = [(0.0, start), (start, end), (end, hot), (hot, 3.5 * hot)][i % 4];
            let energy = gray.at(v, range.0 + (range.1 - range.0) * uniform()).0.energy;
            (v, if i % 13 == 0 { energy - 1e6 * uniform() } else { energy })
        })
        .unzip()
}

#[test]
fn the_error_is_within_the_one_stated() {
    for set in Set::ALL {
        let gray = Gray::new(set.parameters()).unwrap();
        let p = gray.parameters().clone();
        let (all_v, all_e) = states(&gray, 1_000_000);
        let scale = 0.01 * p.sound_speed * p.sound_speed / p.volume;
        for accuracy in [1e-2, 1e-4, 1e-5] {
            // A million at the accuracy that runs take, fewer beside it.
            let n = if accuracy == 1e-4 { all_v.len() } else { 60_000 };
            let (v, e) = (&all_v[..n], &all_e[..n]);
            let patches = Patches::new(gray.clone(), accuracy).unwrap();
            assert!(patches.errors().largest() <= accuracy);
            let (mut seen, mut strayed) = ([0; 5], 0);
            for (&v, &e) in v.iter().zip(e) {
                let (a, b) = (patches.point(v, e), gray.point(v, e));
                let errors = [
                    (a.pressure - b.pressure).abs() / b.pressure.abs().max(scale),
                    (a.temperature - b.temperature).abs() / b.temperature.max(p.reference_temperature),
                    (a.liquid - b.liquid).abs(),
                    (a.sound_speed - b.sound_speed).abs() / b.sound_speed.max(0.25 * p.sound_speed),
                ];
                // On the wrong side of a border, which is displaced by the error stated, only the sound speed jumps.
                let jumps = a.phase != b.phase;
                strayed += usize::from(jumps);
                let counted = if jumps { 3 } else { 4 };
                assert!(
                    errors[..counted].iter().all(|&x| x <= accuracy),
                    "{set:?} {accuracy}: V/V0 {} E {e}: {errors:?} {a:?} {b:?}",
                    v / p.volume
                );
                seen[b.phase as usize] += 1;
            }
            let (mut many, mut exact) = (Points::default(), Points::default());
            Eos::Patches(patches).evaluate(v, e, &mut many);
            Eos::Gray(gray.clone()).evaluate(v, e, &mut exact);
            let off = |(a, b): (&f64, &f64)| (a / b - 1.0).abs();
            let worst = many.melting.iter().zip(&exact.melting).map(off).fold(0.0, f64::max);
            assert!(worst <= accuracy, "{set:?} {accuracy}: T_m off by {worst}");
            assert!(seen.iter().all(|&n| n > 1000), "{seen:?}");
            // The displaced borders sweep over about that share of the states.
            assert!(strayed as f64 <= 3.0 * accuracy * v.len() as f64, "{set:?} {accuracy}: {strayed}");
        }
    }
}

/// On every border itself, of phases, columns, rows and of the patches' range, as beside it.
#[test]
fn borders_belong_to_one_of_their_sides() {
    let gray = Gray::new(Set::CopperRoyce.parameters()).unwrap();
    let patches = Patches::new(gray.clone(), 1e-5).unwrap();
    let v0 = gray.parameters().volume;
    let mut uniform = numbers();
    for i in 0..4000 {
        let v = match i % 4 {
            0 => v0 * 1.5,
            1 => v0 * (1.0 - gray.parameters().cap()),
            _ => v0 * (0.4 + 1.1 * uniform()),
        };
        let [start, end, hot] = gray.borders(v);
        // Columns are halves, quarters .. of a strip: its middle is the border of two of them.
        let energy = |t: f64| gray.at(v, t).0.energy;
        let ends = [energy(0.0), energy(start), energy(end), energy(hot), energy(3.0 * hot)];
        for e in ends.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1]), w[1]]) {
            let (a, b) = (patches.point(v, e), gray.point(v, e));
            let scale = b.pressure.abs().max(1e9);
            assert!((a.pressure - b.pressure).abs() < 2e-5 * scale, "V/V0 {} E {e}: {a:?} {b:?}", v / v0);
            assert!((a.temperature - b.temperature).abs() < 2e-5 * b.temperature.max(300.0), "{a:?} {b:?}");
        }
    }
}

fn same(a: Point, b: Point) -> bool {
    let bits = |p: Point| [p.pressure, p.temperature, p.sound_speed, p.liquid].map(f64::to_bits);
    a.phase == b.phase && bits(a) == bits(b)
}

#[test]
fn many_states_have_the_bits_of_one_and_those_outside_are_grays() {
    let gray = Gray::new(Set::CopperRoyce.parameters()).unwrap();
    let eos = Eos::Patches(Patches::new(gray.clone(), 1e-4).unwrap());
    let (v, e) = states(&gray, 20_003);
    for instructions in Instructions::all() {
        let mut out = Points::default();
        eos.evaluate_with(instructions, &v, &e, &mut out);
        for i in 0..v.len() {
            assert!(same(out.get(i), eos.point(v[i], e[i])), "{} {} {}", instructions.name(), v[i], e[i]);
        }
    }
    let v0 = gray.parameters().volume;
    for (v, e) in [(0.39 * v0, 1e7), (1.6 * v0, 3e6), (1e4 * v0, 8e6), (v0, 1e9), (0.2 * v0, -1.0)] {
        assert!(same(eos.point(v, e), gray.point(v, e)));
    }
}

/// Pressure and temperature across every edge: an isochore's E steps by 1e-9 of its range, P may not jump by more than a
/// thousandth of the accuracy; and along V at fixed E as much.
#[test]
fn pressure_has_no_jumps() {
    let gray = Gray::new(Set::CopperRoyce.parameters()).unwrap();
    let eos = Eos::Patches(Patches::new(gray.clone(), 1e-3).unwrap());
    let v0 = gray.parameters().volume;
    let mut uniform = numbers();
    for _ in 0..200 {
        let v = v0 * (0.41 + 1.08 * uniform());
        let top = gray.at(v, 1.5 * gray.borders(v)[2]).0.energy;
        let bottom = gray.at(v, 0.0).0.energy;
        let at = |e: f64| eos.point(v, e).pressure;
        // Bisection onto the largest jump that halving leaves.
        let (mut low, mut high) = (bottom, top);
        while high - low > 1e-9 * (top - bottom) {
            let middle = 0.5 * (low + high);
            let upper = (at(high) - at(middle)).abs() > (at(middle) - at(low)).abs();
            *(if upper { &mut low } else { &mut high }) = middle;
        }
        assert!((at(high) - at(low)).abs() < 1e-6 * at(high).abs().max(1e9), "{} {low} {high}", v / v0);
        let (e, step) = (low, 1e-10 * v0);
        let (a, b) = (eos.point(v, e).pressure, eos.point(v + step, e).pressure);
        assert!((a - b).abs() < 1e-6 * a.abs().max(1e9), "{}", v / v0);
    }
}

#[test]
fn what_cannot_be_reached_is_refused_and_a_description_reads_back() {
    let gray = || Gray::new(Set::CopperRoyce.parameters()).unwrap();
    for accuracy in [0.0, 1e-12, 0.5, f64::NAN] {
        assert_eq!(Patches::new(gray(), accuracy).unwrap_err().parameter, "accuracy");
    }
    let given = Definition { accuracy: Some(1e-4), ..Definition::of(Set::AluminiumPaper) };
    let made = given.make().unwrap();
    assert!(matches!(&made.eos, Eos::Patches(p) if p.accuracy() == 1e-4));
    assert_eq!(Definition::describe(&made).unwrap().make().unwrap().eos, made.eos);
    let text = serde_json::to_string(&made).unwrap();
    assert_eq!(serde_json::from_str::<hvi_eos::EosResult>(&text).unwrap(), made);
    let gas =
        r#"{"accuracy": 1e-3, "ideal_gas": {"density": "1.2 kg/m3", "gamma": 1.4, "heat_capacity": "718 J/kg/K"}}"#;
    let refused = serde_json::from_str::<Definition>(gas).unwrap().make().unwrap_err();
    assert!(refused.key == "accuracy" && refused.why.contains("only GRAY"), "{refused:?}");
    let vapour = made.eos.point(10.0 * made.eos.reference_volume(), 1.4e7);
    assert_eq!(vapour.phase, Phase::Vapour);
}
