//! Two bodies that meet, slide and part.
use super::Row;
use super::gas::{energy, go};
use super::solid::{ON, material};
use crate::common::copper;
use hvi_impact::material::{Law, Switches};
use hvi_impact::particle::Particle;
use hvi_impact::step::{Setting, State};

/// Two equal bars of copper, one at 100 m/s: after the waves' round trip they part, the first at rest, the second with all the
/// momentum, and no force is left between or in them.
fn bars(friction: Option<f64>, cells: usize) -> [f64; 5] {
    let copper = material(copper());
    let law = Law::new(&copper, copper.eos.clone(), Switches { strength: false, ..ON });
    let (length, v) = (10e-3, 100.0);
    let cell = length / cells as f64;
    let mut setting = Setting::<1>::new(cell, vec![law.clone(), law]);
    setting.method.friction = friction;
    let h = 0.5 * cell;
    let n = 2 * cells as i64;
    let all = (-n..n).map(|i| {
        let (body, speed) = if i < 0 { (0, v) } else { (1, 0.0) };
        Particle::new([(i as f64 + 0.5) * h], [speed], 8930.0 * h, h, (i + n) as u32, body)
    });
    let mut state = State::new(all.collect(), &setting);
    let start = energy(&state, &setting);
    let mean = |state: &State<1>, body: u8| {
        let own = state.particles().filter(|p| p.body == body);
        own.map(|p| p.velocity[0]).sum::<f64>() / (2 * cells) as f64
    };
    // Twice and thrice the round trip, when the gap is wider than two kernels.
    go(&mut state, &setting, 4.0 * length / 3940.0);
    let before = mean(&state, 0);
    go(&mut state, &setting, 6.0 * length / 3940.0);
    let after = mean(&state, 0);
    // Pressure of impact: rho c v / 2.
    let left = state.particles().map(|p| p.pressure().abs()).fold(0.0, f64::max) / (0.5 * 8930.0 * 3940.0 * v);
    [after / v, mean(&state, 1) / v, left, (energy(&state, &setting) / start - 1.0).abs(), (after - before).abs() / v]
}

/// Bars part with no force left; stuck together they ring on. The fields meet where their kernels do, a cell or two before the
/// bodies, so what they keep of each other's motion falls with the cell.
pub fn rows() -> Vec<Row> {
    let case = "two materials";
    let mut rows = Vec::new();
    for (cells, most) in [(100, 0.03), (400, 0.01)] {
        let [first, second, left, drift, force] = bars(Some(0.0), cells);
        let what = |x: &str| format!("bars of copper at 100 m/s, two fields, {cells} cells: {x}");
        rows.extend([
            Row::most(case, what("change of velocity after they have parted, over the impact's"), force, "", 1e-12),
            Row::most(case, what("velocity left in the first, over the impact's"), first.abs(), "", most),
            Row::within(case, what("velocity of the second, over the impact's"), second, "", 1.0, most),
            Row::most(case, what("energy drift"), drift, "", 1e-12),
            Row::reported(case, what("largest pressure that rings on, over the impact's"), left, ""),
        ]);
    }
    let [.., stuck, _, _] = bars(None, 100);
    rows.push(Row::reported(case, "the same with no slip, 100 cells: largest pressure, over the impact's", stuck, ""));
    rows
}
