//! States come to by pressure: they are where the grid has them, and their volume does not know their temperature.
use hvi_kit::{Ctx, Invalid, Stage};
use hvi_md::lanes::Isa;
use hvi_md::{Md, Params, State, run};
use serde_json::json;
use std::collections::BTreeMap;

fn params(more: serde_json::Value) -> Params {
    let mut all = json!({ "potential": "mishin-2001", "atoms": 256, "volume_ratio": 1.0, "temperature": "300 K" });
    all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    serde_json::from_value(all).unwrap()
}

fn state(params: &Params) -> State {
    Md::check(params).unwrap();
    run::state(params, &BTreeMap::new(), Isa::best(), &Ctx::quiet()).unwrap()
}

/// Room temperature by the way of pressure, from P_0 of the lattice that it begins at up by 20 GPa: the volume has that
/// pressure. 256 atoms over 2 ps know V_1 to 0.1 GPa or so, P_0 to 0.05 GPa, the states themselves to 0.02 GPa: 0.4 GPa is
/// three times all together. And hot at the same volume: what the grid's state of this volume and temperature has.
#[test]
fn pressed_states_are_where_the_grid_has_them() {
    let way = |temperature: &str| {
        let pressed = json!({ "rise": "20 GPa", "relaxation": "3 ps", "pressing": "4 ps" });
        state(&params(json!({ "temperature": temperature, "pressed": pressed })))
    };
    let (start, cold, hot) = (state(&params(json!({}))), way("300 K"), way("2000 K"));
    let rise = (cold.pressure - start.pressure) * 1e-9;
    println!(
        "P_0 {:.3} GPa, rise {rise:.3} GPa, V_1/V_0 {:.5}",
        start.pressure * 1e-9,
        cold.volume / cold.lattice_volume
    );
    assert!((rise - 20.0).abs() < 0.4, "{rise}");
    assert!(cold.volume.to_bits() == hot.volume.to_bits(), "{:e} {:e}", cold.volume, hot.volume);
    let ratio = hot.volume / hot.lattice_volume;
    let grid = state(&params(json!({ "volume_ratio": ratio, "temperature": "2000 K" })));
    let apart = |a: f64, b: f64, ea: f64, eb: f64| (a - b).abs() / (ea * ea + eb * eb).sqrt();
    let pressures = apart(hot.pressure, grid.pressure, hot.pressure_error, grid.pressure_error);
    let energies = apart(hot.energy, grid.energy, hot.energy_error, grid.energy_error);
    println!("2000 K: {pressures:.1} errors of P apart, {energies:.1} of E");
    assert!(pressures < 4.0 && energies < 4.0, "{hot:?} {grid:?}");
}

#[test]
fn what_is_off_its_range_is_refused() {
    let why = |more| -> Invalid { Md::check(&params(more)).unwrap_err() };
    assert_eq!(why(json!({ "pressed": { "rise": "600 GPa" } })).key, "pressed.rise");
    assert_eq!(why(json!({ "pressed": { "rise": "2 GPa", "pressing": "0 ps" } })).key, "pressed.pressing");
    assert_eq!(why(json!({ "pressed": { "rise": "2 GPa" }, "engine": "lammps" })).key, "pressed");
}
