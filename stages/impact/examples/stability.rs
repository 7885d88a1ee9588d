//! The stability battery as one table: `make stability` writes docs/stability.md.
#[path = "../tests/battery/mod.rs"]
mod battery;
#[path = "../tests/common/mod.rs"]
mod common;
use battery::{Bound, Row, contact, gas, grid, material, shock, solid, wall, yardstick};

/// Every subject, at the size the table is made with.
const SUBJECTS: &[fn() -> Vec<Row>] = &[
    || shock::mie_gruneisen(100),
    || shock::mie_gruneisen(200),
    || shock::mie_gruneisen(400),
    || shock::with_gray(100),
    || shock::with_gray(200),
    shock::reference,
    wall::rows,
    wall::unseen_rows,
    wall::melt_rows,
    || gas::noh_rows(200, 24),
    gas::sod_rows,
    gas::expansion_rows,
    contact::rows,
    solid::wave_rows,
    solid::precursor_rows,
    || solid::spall_rows(80),
    || solid::spall_rows(320),
    || solid::taylor_rows(10),
    || solid::taylor_rows(16),
    solid::spin_rows,
    grid::edge_rows,
    grid::leaving_rows,
    || grid::symmetry_rows(3),
    || grid::order_rows([16, 32]),
    grid::even_order_rows,
    material::shear_rows,
    material::limit_rows,
    || material::state_rows(1_000_000),
    yardstick::rows,
    yardstick::long_rows,
    || yardstick::refinement(&[3, 6, 12], "2.5 us"),
    || yardstick::refinement(&[3, 5, 8, 12], "6 us"),
];

fn main() {
    // Subjects share nothing: each worker takes the next, and the table keeps their order.
    let next = std::sync::atomic::AtomicUsize::new(0);
    let done: Vec<std::sync::OnceLock<Vec<Row>>> = SUBJECTS.iter().map(|_| Default::default()).collect();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                while let Some(subject) = SUBJECTS.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    let at = SUBJECTS.iter().position(|s| std::ptr::eq(s, subject)).expect("one of them");
                    let _ = done[at].set(subject());
                }
            });
        }
    });
    let rows: Vec<Row> = done.into_iter().flat_map(|rows| rows.into_inner().unwrap_or_default()).collect();
    print(&rows);
}

/// The table as Markdown.
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
        Bound::Within { known, share: 0.0 } => figure(known, row.unit),
        Bound::Within { known, share } => format!("{} +-{} %", figure(known, row.unit), figure(100.0 * share, "")),
        Bound::Most(most) => format!("<= {}", figure(most, row.unit)),
        Bound::Least(least) => format!(">= {}", figure(least, row.unit)),
        Bound::Reported => "-".into(),
    }
}
