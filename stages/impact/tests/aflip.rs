//! The transfer AFLIP: it keeps momentum and energy, and heats far less than APIC what spreads on the scale of a few cells.
mod common;
use common::{copper, drift, run};
use hvi_impact::result::Impact;
use serde_json::json;

/// A copper sphere through a copper plate at 6 cells.
fn ball(space: &str, transfer: &str, cells: u32) -> Impact {
    run(json!({
        "projectile": { "shape": "sphere", "diameter": "5 mm", "material": copper() },
        "plate": { "thickness": "2.5 mm", "width": "12 mm", "material": copper() },
        "velocity": "6.7 km/s", "cells": cells, "space": space, "transfer": transfer, "end": "1.5 us",
    }))
}

/// Share of the impact's energy that became heat in the transfer.
fn heat(impact: &Impact) -> f64 {
    impact.ledger.last().unwrap().transfer / impact.ledger[0].kinetic
}

#[test]
fn momentum_and_energy_are_kept() {
    for (space, cells) in [("axisymmetric", 6), ("quarter", 3)] {
        let impact = ball(space, "aflip", cells);
        let (first, last) = (&impact.ledger[0], impact.ledger.last().unwrap());
        assert!(drift(&impact) <= 1e-12, "{space}: {:e}", drift(&impact));
        assert!(
            (last.momentum / first.momentum - 1.0).abs() <= 1e-12,
            "{space}: {:e}",
            last.momentum / first.momentum - 1.0
        );
        // The heat of a particle may be negative where its affine motion grows: what the floor then puts in is told, and next to nothing.
        assert!(last.floored <= 1e-4 * first.kinetic, "{space}: {:e}", last.floored / first.kinetic);
    }
}

/// What APIC takes out of motion in each step does not go away as cells shrink; outside shocks AFLIP leaves the particle's own velocity
/// in motion. What both take alike is the affine part, and all of it in shocks: at these cells that is more than half of what APIC
/// takes (measured: 0.6), so less than three quarters is asked for.
#[test]
fn less_becomes_heat_than_by_apic() {
    let [apic, aflip] = ["apic", "aflip"].map(|transfer| ball("axisymmetric", transfer, 6));
    assert!(heat(&aflip) > 0.0 && heat(&aflip) < 0.75 * heat(&apic), "{} against {}", heat(&aflip), heat(&apic));
    let fastest = |impact: &Impact| impact.leading[0];
    assert!(
        (fastest(&aflip) / fastest(&apic) - 1.0).abs() < 0.1,
        "no noise runs ahead: {} {}",
        fastest(&aflip),
        fastest(&apic)
    );
}
