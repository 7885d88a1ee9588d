//! Heat at the contact of a symmetric plane impact, and what is left in the bulk after release: GRAY copper ("Cu MD").
use super::{Bound, Row};
use crate::common::{drift, mean, planar, run};
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray};
use hvi_impact::result::Particles;
use serde_json::{Value, json};

/// Copper with the paper's molecular-dynamics parameters.
pub fn copper() -> (Value, Eos) {
    let eos = Eos::Gray(Gray::new(Set::CopperPaperMd.parameters()).expect("published"));
    let mut copper = super::shock::gray("copper");
    copper["eos"] = serde_json::to_value(&eos).expect("plain data");
    (copper, eos)
}

/// The target's middle: 25 cells or more from the contact, which is overheated, and 15 from the free surface.
fn bulk(p: &Particles, value: impl Fn(usize) -> f64) -> f64 {
    let n = p.mass.len();
    mean(p, value, |i| i >= n / 2 + 50 && i < n - 30).0
}

/// Residual energy after release, and the excess of the three cells at the contact.
pub fn rows() -> Vec<Row> {
    let case = "wall heating at the contact";
    let (material, eos) = copper();
    let mut rows = Vec::new();
    for (v, known) in [(2500.0, 116.7), (4200.0, 403.7), (5900.0, 793.4)] {
        let shock = eos.hugoniot_at_velocity(0.5 * v).expect("in range");
        let length = 10e-3;
        let mut params = planar(material.clone(), material.clone(), v, 100, &[], 3.0 * length / shock.shock_velocity);
        params["spall"] = json!(true);
        let impact = run(params);
        let p = &impact.snapshots[0].particles;
        let energy = bulk(p, |i| p.energy[i] as f64);
        // The row names 4.2 and 5.9 km/s; at 2.5 km/s noise behind the weak shock heats by 1.0 %.
        let share = if v < 3000.0 { 0.015 } else { 0.01 };
        let what = format!("GRAY Cu-Cu {v} m/s, 100 cells: residual energy of the bulk");
        rows.push(Row::within(case, what, energy / 1e3, "kJ/kg", known, share));
        rows.push(Row::most(case, format!("GRAY Cu-Cu {v} m/s: energy drift"), drift(&impact), "", 1e-12));
        let cell = |c: usize| {
            let first = p.mass.len() / 2 + 2 * c;
            (0.5 * (p.energy[first] + p.energy[first + 1]) as f64 - energy) / 1e3
        };
        if v == 5900.0 {
            let what = "GRAY Cu-Cu 5900 m/s: excess of the three cells at the contact, sum";
            let all =
                Row::most(case, what, cell(0) + cell(1) + cell(2), "kJ/kg", 0.25 * 4040.0).peer("4040 (unremedied)");
            rows.push(all);
            let each = [("first", 3123.0, "3123", 1.0), ("second", 627.0, "627", 0.7), ("third", 290.0, "290", 1.1)];
            for (c, (name, before, text, worst)) in each.into_iter().enumerate() {
                let what = format!("GRAY Cu-Cu 5900 m/s: excess of the {name} cell");
                let row = Row::most(case, what, cell(c), "kJ/kg", 0.25 * before).peer(text);
                rows.push(if c == 0 { row } else { row.missed(Bound::Most(worst * before)) });
            }
        }
    }
    rows
}

/// Excess of the three cells at the contact over the bulk's residual energy, as a share of that, without and with the heat
/// conduction, on impacts whose profiles its coefficient was not chosen by; and how far the bulk is off the isentrope's end.
pub fn unseen_rows() -> Vec<Row> {
    let case = "wall heating at the contact";
    let aluminium = super::shock::gray("aluminium");
    let eos: Eos = serde_json::from_value(aluminium["eos"].clone()).expect("an equation of state");
    let (copper, copper_eos) = copper();
    let scenes = [
        ("Al-Al", &aluminium, &eos, 4500.0, 100),
        ("Al-Al", &aluminium, &eos, 7500.0, 100),
        ("Cu-Cu", &copper, &copper_eos, 7000.0, 100),
        ("Cu-Cu", &copper, &copper_eos, 5000.0, 150),
    ];
    let mut rows = Vec::new();
    for (metals, material, eos, v, cells) in scenes {
        let shock = eos.hugoniot_at_velocity(0.5 * v).expect("in range");
        let known = eos.release(&shock).expect("a metal").energy;
        let [without, with] = [0.0, hvi_impact::method::CONDUCTION].map(|conduction| {
            let mut params = planar(material.clone(), material.clone(), v, cells, &[], 30e-3 / shock.shock_velocity);
            (params["spall"], params["conduction"]) = (json!(true), json!(conduction));
            let impact = run(params);
            let p = &impact.snapshots[0].particles;
            let energy = bulk(p, |i| p.energy[i] as f64);
            let first = p.mass.len() / 2;
            let excess: f64 = (first..first + 6).map(|i| 0.5 * (p.energy[i] as f64 - energy)).sum();
            (excess / energy, energy / known - 1.0)
        });
        let what = |x: &str| format!("GRAY {metals} {v} m/s, {cells} cells, not used for the choice: {x}");
        rows.push(Row::reported(case, what("excess of three cells over the bulk, no conduction"), without.0, ""));
        rows.push(Row::reported(case, what("the same with it"), with.0, ""));
        rows.push(Row::reported(case, what("residual energy of the bulk, off the isentrope's"), 100.0 * with.1, "%"));
    }
    rows
}

/// The liquid share after release is the isentrope's; below the threshold of release melting nothing melts, above it all does.
pub fn melt_rows() -> Vec<Row> {
    let case = "temperature, release";
    let (copper, copper_eos) = copper();
    let aluminium = super::shock::gray("aluminium");
    let aluminium_eos: Eos = serde_json::from_value(aluminium["eos"].clone()).expect("an equation of state");
    let scenes = [
        ("Cu", 4300.0),
        ("Cu", 5300.0),
        ("Cu", 6200.0),
        ("Al", 5000.0),
        ("Al", 5600.0),
        ("Al", 6200.0),
        ("Al", 6700.0),
    ];
    scenes
        .map(|(metal, v)| {
            let (material, eos) = if metal == "Cu" { (&copper, &copper_eos) } else { (&aluminium, &aluminium_eos) };
            let shock = eos.hugoniot_at_velocity(0.5 * v).expect("in range");
            let known = eos.release(&shock).expect("a metal").liquid;
            let mut params = planar(material.clone(), material.clone(), v, 100, &[], 30e-3 / shock.shock_velocity);
            params["spall"] = json!(true);
            let impact = run(params);
            let p = &impact.snapshots[0].particles;
            let liquid = bulk(p, |i| p.liquid[i] as f64);
            let what = format!(
                "GRAY {metal}-{metal} {v} m/s, 100 cells: liquid share after release, off the isentrope's {known:.3}"
            );
            Row::most(case, what, (liquid - known).abs(), "", 0.01)
        })
        .into()
}
