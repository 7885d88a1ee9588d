//! Plane impact with GRAY copper: what heat release leaves behind, and which phases.
mod common;
use common::{drift, mean, planar, run};
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, EosResult, Gray};
use hvi_impact::{ImpactInputs, ImpactStage, Params};
use hvi_kit::view::Cell;
use hvi_kit::{Artifact, Ctx, Places, Stage};
use serde_json::{Value, json};

fn copper() -> (Value, Eos) {
    let eos = Eos::Gray(Gray::new(Set::CopperPaperMd.parameters()).expect("published"));
    let mut copper = serde_json::to_value(hvi_impact::material::Material::named("copper").expect("shipped")).unwrap();
    copper["eos"] = serde_json::to_value(&eos).unwrap();
    (copper, eos)
}

/// Symmetric impact, "Cu MD" parameters: the bulk keeps 116.7 / 403.7 / 793.4 kJ/kg after release from 2.5 / 4.2 / 5.9
/// km/s (Rankine-Hugoniot and isentrope of the same equation of state, which the test computes anew). The bulk is the
/// target's middle, 25 cells or more from the contact, which is overheated, and 15 from the free surface: within 1 %.
#[test]
fn residual_energy_after_release() {
    let (material, eos) = copper();
    for (v, known) in [(2500.0, 116.7e3), (4200.0, 403.7e3), (5900.0, 793.4e3)] {
        let shock = eos.hugoniot_at_velocity(0.5 * v).expect("in range");
        let released = eos.release(&shock).expect("a metal");
        assert!((released.energy / known - 1.0).abs() < 2e-3, "exact {} against {known}", released.energy);
        let length = 10e-3;
        let end = 3.0 * length / shock.shock_velocity;
        let mut params = planar(material.clone(), material.clone(), v, 100, &[], end);
        params["spall"] = json!(true);
        let impact = run(params);
        let p = &impact.snapshots[0].particles;
        let n = p.mass.len();
        let (energy, scatter) = mean(p, |i| p.energy[i] as f64, |i| i >= n / 2 + 50 && i < n - 30);
        assert!(scatter <= 0.02, "{v} m/s: scatter {scatter}");
        if v == 5900.0 {
            // Wall heating of the three cells at the contact, as an independent run of the same method found it [kJ/kg]:
            // known and unremedied, so that a change of it is noticed. Its layout differs by a fraction of a cell: 10 %.
            for (cell, expected) in [3123e3, 627e3, 290e3].iter().enumerate() {
                let first = n / 2 + 2 * cell;
                let excess = 0.5 * (p.energy[first] + p.energy[first + 1]) as f64 - energy;
                assert!((excess / expected - 1.0).abs() <= 0.1, "cell {cell}: excess {excess} J/kg");
            }
        }
        assert!((energy / released.energy - 1.0).abs() <= 0.01, "{v} m/s: residual {energy} J/kg");
        assert!(drift(&impact) <= 1e-12);
    }
}

/// Below 4.73 km/s ("Cu MD") release from a symmetric plane impact melts nothing but the wall-heated contact; above 5.87
/// all melts.
#[test]
fn release_melts_where_it_should() {
    let (material, _) = copper();
    let liquid = |v: f64| {
        let mut params = planar(material.clone(), material.clone(), v, 100, &[], 5e-6);
        params["spall"] = json!(true);
        let impact = run(params);
        let p = &impact.snapshots[0].particles;
        let n = p.mass.len();
        mean(p, |i| p.liquid[i] as f64, |i| i >= n / 2 + 50 && i < n - 30).0
    };
    assert_eq!(liquid(4300.0), 0.0);
    let part = liquid(5300.0);
    assert!(part > 0.2 && part < 0.8, "{part}");
    assert_eq!(liquid(6200.0), 1.0);
}

/// An equation of state plugged into a body's port takes the place of its material's own.
#[test]
fn plugged_equation_of_state() {
    let (material, eos) = copper();
    let shipped = serde_json::to_value(hvi_impact::material::Material::named("copper").unwrap()).unwrap();
    let own: Params = serde_json::from_value(planar(material.clone(), material, 3000.0, 50, &[], 1e-6)).unwrap();
    let other: Params = serde_json::from_value(planar(shipped.clone(), shipped, 3000.0, 50, &[], 1e-6)).unwrap();
    let result = |key: &str| (key.to_string(), EosResult { eos: eos.clone(), source: "test".into(), fit: None });
    let inputs = ImpactInputs { eos: Places([result("projectile.eos"), result("plate.eos")].into()) };
    let plugged = ImpactStage::run(&other, inputs, &Ctx::quiet()).unwrap();
    let expected = ImpactStage::run(&own, ImpactInputs { eos: Places(Default::default()) }, &Ctx::quiet()).unwrap();
    assert_eq!(plugged.snapshots, expected.snapshots);
}

/// A copper sphere on a copper plate with the shipped material: shares add up, and more melts at higher speed.
#[test]
fn phases_of_a_sphere_on_a_plate() {
    let at = |v: &str| {
        run(json!({
            "projectile": { "shape": "sphere", "diameter": "6.4 mm", "material": "copper" },
            "plate": { "thickness": "2.5 mm", "material": "copper" },
            "velocity": v, "cells": 4,
        }))
    };
    let runs = [at("2.5 km/s"), at("5.9 km/s"), at("8 km/s")];
    let mut last = -1.0;
    for impact in &runs {
        let melt = &impact.snapshots[0].melt;
        assert!((melt[0].by_phase.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((melt[0].by_phase_own_volume.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let plate: f64 = melt[1].by_phase.iter().sum();
        assert!((plate / (impact.bodies[1].mass / impact.bodies[0].mass) - 1.0).abs() < 1e-12);
        assert!(melt[0].liquid > last);
        last = melt[0].liquid;
        assert!(drift(impact) <= 1e-12);
    }
}

/// What the notes say of the melted share holds: most of a small sphere's energy becomes heat in the transfer (.54 of it at
/// 6 cells across, .04 in viscosity: figures of this code), more where cfl is smaller, less where cells are; the row of
/// numbers and the notes tell it from the run's own ledger.
#[test]
fn heat_of_the_transfer_is_told() {
    let at = |cells: u32, cfl: f64| {
        let impact = run(json!({
            "projectile": { "shape": "sphere", "diameter": "1.6 mm", "material": "copper" },
            "plate": { "thickness": "2.5 mm", "width": "8 mm", "material": "copper" },
            "velocity": "2.5 km/s", "cells": cells, "cfl": cfl,
        }));
        let kinetic = impact.ledger[0].kinetic;
        let end = impact.ledger.last().expect("an end");
        (end.transfer / kinetic, end.viscous / kinetic, impact.snapshots[0].melt[0].liquid, impact)
    };
    let (transfer, viscous, liquid, impact) = at(6, 0.5);
    assert!((transfer - 0.54).abs() < 0.03 && (viscous - 0.042).abs() < 0.01, "{transfer} {viscous}");
    let number = |name: &str| {
        let scalar = impact.scalars().into_iter().find(|s| s.name == name).unwrap_or_else(|| panic!("no {name}"));
        scalar.value.clone()
    };
    let is = |name: &str, value: f64| assert_eq!(format!("{:?}", number(name)), format!("{:?}", Cell::Number(value)));
    is("cells across the projectile", impact.diameter / impact.cell);
    is("transfer heat share", transfer);
    is("viscous heat share", viscous);
    let said = format!(
        "{:.1} % became heat in the transfer between particles and grid, {:.1} % in artificial viscosity",
        100.0 * transfer,
        100.0 * viscous
    );
    assert!(impact.notes[0].contains(&said) && impact.notes[0].contains("6.0 across"), "{:?}", impact.notes);
    let (often, coarse) = (at(6, 0.25), at(3, 0.5));
    assert!(often.0 > 1.1 * transfer && often.2 > 1.1 * liquid, "{} {} {liquid}", often.0, often.2);
    assert!(coarse.0 > 1.1 * transfer && coarse.2 > 1.1 * liquid, "{} {} {liquid}", coarse.0, coarse.2);
}
