//! GRAY copper: plugged equations of state, phases, and the heat that the notes tell of.
mod common;
use common::{drift, planar, run};
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

/// An equation of state plugged into a body's port takes the place of its material's own.
#[test]
fn plugged_equation_of_state() {
    let (material, eos) = copper();
    let shipped = serde_json::to_value(hvi_impact::material::Material::named("copper").unwrap()).unwrap();
    let own: Params = serde_json::from_value(planar(material.clone(), material, 3000.0, 50, &[], 1e-6)).unwrap();
    let other: Params = serde_json::from_value(planar(shipped.clone(), shipped, 3000.0, 50, &[], 1e-6)).unwrap();
    let result = |key: &str| (key.to_string(), EosResult { eos: eos.clone(), source: "test".into(), fit: None });
    let inputs = ImpactInputs {
        eos: Places([result("projectile.eos"), result("plate.eos")].into()),
        file: Places(Default::default()),
    };
    let plugged = ImpactStage::run(&other, inputs, &Ctx::quiet()).unwrap();
    let expected = ImpactStage::run(
        &own,
        ImpactInputs { eos: Places(Default::default()), file: Places(Default::default()) },
        &Ctx::quiet(),
    )
    .unwrap();
    assert_eq!(plugged.snapshots, expected.snapshots);
}

/// Copper with aluminium's equation of state is neither.
#[test]
fn a_material_and_an_equation_of_state_of_two_metals_are_refused() {
    let shipped = serde_json::to_value(hvi_impact::material::Material::named("copper").unwrap()).unwrap();
    let params: Params = serde_json::from_value(planar(shipped.clone(), shipped, 3000.0, 50, &[], 1e-6)).unwrap();
    let aluminium = Eos::Gray(Gray::new(Set::AluminiumPaper.parameters()).unwrap());
    let plugged = EosResult { eos: aluminium, source: "test".into(), fit: None };
    let inputs = ImpactInputs { eos: Places([("plate.eos".into(), plugged)].into()), file: Places(Default::default()) };
    let said = ImpactStage::run(&params, inputs, &Ctx::quiet()).unwrap_err().to_string();
    assert!(
        said.contains("plate: its equation of state is of matter of 2.79 g/cm3, its material copper has 8.9"),
        "{said}"
    );
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

/// What the notes say of the melted share holds: most of a small sphere's energy becomes heat in the transfer (.51 of it at
/// 6 cells across, .03 in viscosity: figures of this code), more where cfl is smaller, less where cells are; the row of
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
    assert!((transfer - 0.51).abs() < 0.03 && (viscous - 0.032).abs() < 0.01, "{transfer} {viscous}");
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
    assert!(often.0 > 1.1 * transfer && often.2 > 1.02 * liquid, "{} {} {liquid}", often.0, often.2);
    assert!(coarse.0 > 1.1 * transfer && coarse.2 > 1.1 * liquid, "{} {} {liquid}", coarse.0, coarse.2);
}
