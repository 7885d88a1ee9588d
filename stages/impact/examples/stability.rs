//! The stability battery as one table: `make stability` writes docs/stability.md.
#[path = "../tests/battery/mod.rs"]
mod battery;
#[path = "../tests/common/mod.rs"]
mod common;
use battery::{Bound, Row, gas, grid, material, shock, solid, wall, yardstick};

fn main() {
    let mut rows = Vec::new();
    for cells in [100, 200, 400] {
        rows.extend(shock::mie_gruneisen(cells));
    }
    for cells in [100, 200, 400] {
        rows.extend(shock::with_gray(cells));
    }
    let rest = [
        shock::reference(),
        wall::rows(),
        wall::melt_rows(),
        gas::noh_rows(200, 24),
        gas::sod_rows(),
        gas::expansion_rows(),
        solid::wave_rows(),
        solid::precursor_rows(),
        solid::spall_rows(80),
        solid::spall_rows(320),
        solid::taylor_rows(10),
        solid::taylor_rows(20),
        solid::spin_rows(),
        grid::edge_rows(),
        grid::leaving_rows(),
        grid::symmetry_rows(3),
        grid::order_rows([16, 32]),
        material::shear_rows(),
        material::limit_rows(),
        material::state_rows(1_000_000),
        yardstick::rows(),
        yardstick::long_rows(),
        yardstick::refinement(&[3, 6, 12], "2.5 us"),
        yardstick::refinement(&[3, 5, 8, 12], "10 us"),
    ];
    rows.extend(rest.into_iter().flatten());
    print(&rows);
}

/// The planar scenes are many: a line each, its worst figure over its bound.
fn print(rows: &[Row]) {
    let judged = rows.iter().filter(|r| !matches!(r.bound, Bound::Reported)).count();
    let missed = rows.iter().filter(|r| !r.met()).count();
    println!("# Stability\n");
    println!(
        "Hard cases of the material point method with a known answer. Made by `make stability`; the same rows, at sizes"
    );
    println!(
        "that fit, are tests (`stages/impact/tests/battery_*.rs`). The peer is MPM3D-F90, the best of its schemes.\n"
    );
    println!("{judged} figures are judged, {missed} of them missed; the others are told.\n");
    println!("| case | what | peer | ours | bound | |\n|---|---|---|---|---|---|");
    for row in rows {
        let verdict = match (row.bound, row.met()) {
            (Bound::Reported, _) => "told",
            (_, true) => "met",
            (_, false) => "**missed**",
        };
        println!(
            "| {} | {} | {} | {} | {} | {verdict} |",
            row.case,
            row.what,
            row.peer,
            figure(row.ours, row.unit),
            bound(row)
        );
    }
}

fn figure(x: f64, unit: &str) -> String {
    let text = match x.abs() {
        0.0 => "0".into(),
        s if !(1e-3..1e5).contains(&s) => format!("{x:.1e}"),
        s if s < 1.0 => format!("{x:.4}"),
        s if s < 100.0 => format!("{x:.3}"),
        _ => format!("{x:.1}"),
    };
    format!("{text} {unit}").trim_end().to_string()
}

fn bound(row: &Row) -> String {
    match row.bound {
        Bound::Within { known, share } if share == 0.0 => figure(known, row.unit),
        Bound::Within { known, share } => format!("{} +-{} %", figure(known, row.unit), figure(100.0 * share, "")),
        Bound::Most(most) => format!("<= {}", figure(most, row.unit)),
        Bound::Least(least) => format!(">= {}", figure(least, row.unit)),
        Bound::Reported => "-".into(),
    }
}
