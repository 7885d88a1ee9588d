//! The yardstick scene S1: aluminium sphere of 9.53 mm on a plate of 1.906 mm at 6.7 km/s.
use super::Row;
use crate::common::{drift, run, s1};
use hvi_impact::result::Impact;

/// Radius of the hole [mm]: 1 % of the plate's slow matter lies closer to the axis.
fn hole(impact: &Impact) -> f64 {
    let p = &impact.snapshots.last().expect("an end").particles;
    let slow =
        |i: &usize| p.body[*i] == 1 && p.velocity[0][*i].abs() < 200.0 && (p.position[0][*i] - 1e-3).abs() < 6e-3;
    let three = p.position[2].iter().any(|&z| z != 0.0);
    let radius = |i: usize| {
        let (y, z) = (p.position[1][i] as f64, p.position[2][i] as f64);
        (if three { (y * y + z * z).sqrt() } else { y }, p.mass[i] as f64)
    };
    let mut order: Vec<(f64, f64)> = (0..p.mass.len()).filter(slow).map(radius).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted = 0.01 * order.iter().map(|x| x.1).sum::<f64>();
    let mut sum = 0.0;
    for (r, m) in order {
        sum += m;
        if sum >= wanted {
            return 1e3 * r;
        }
    }
    f64::NAN
}

/// What S1 must show at 2.5 us.
fn rows_of(name: &str, impact: &Impact) -> Vec<Row> {
    let (start, end) = (&impact.ledger[0], impact.ledger.last().expect("an end"));
    let p = &impact.snapshots.last().expect("an end").particles;
    let what = |x: &str| format!("S1, {name}, 3 cells, 2.5 us: {x}");
    let least = |x: &[f32]| x.iter().fold(f64::INFINITY, |a, &b| a.min(b as f64));
    let fastest = p.velocity[0].iter().fold(0.0, |a: f64, &b| a.max(b as f64));
    let mut rows = vec![
        Row::most("energy", what("energy drift"), drift(impact), "", 1e-12).peer("1.1e-2"),
        Row::most("energy", what("mass"), (end.mass / start.mass - 1.0).abs(), "", 1e-12).peer("661 particles lost"),
        Row::most("energy", what("momentum"), (end.momentum / start.momentum - 1.0).abs(), "", 1e-12),
        Row::least("negative energy", what("least energy"), least(&p.energy) / 1e3, "J/g", 0.0).peer("-76"),
        Row::most("negative energy", what("floor energy over E0"), end.floored / start.kinetic, "", 1e-4),
        Row::most("over-compression", what("highest rho/rho0"), end.highest_compression, "", 2.07).peer("2.36"),
        Row::most("over-compression", what("highest pressure"), end.highest_pressure / 1e9, "GPa", 390.0).peer("461"),
        Row::least("tension, spall", what("lowest pressure"), least(&p.pressure) / 1e9, "GPa", -1.2)
            .peer("1479 below -1"),
        Row::most("tiny nodal mass", what("fastest particle"), fastest, "m/s", 6700.0).peer("above 7678"),
    ];
    let known = [("0.1", 6160.0, 0.015, "7678"), ("1", 6130.0, 0.01, "7104"), ("5", 6088.0, 0.01, "6578")];
    for (found, (share, known, bound, peer)) in impact.leading.iter().zip(known) {
        let row = Row::within(
            "tiny nodal mass",
            what(&format!("leading {share} % of the projectile")),
            *found,
            "m/s",
            known,
            bound,
        );
        rows.push(row.peer(peer));
    }
    rows
}

/// S1 in a quarter of three dimensions and in (r, z), at 3 cells through the plate; and the two against each other.
pub fn rows() -> Vec<Row> {
    let (quarter, flat) = (run(s1("quarter", 3, "2.5 us")), run(s1("axisymmetric", 3, "2.5 us")));
    let mut rows = rows_of("quarter", &quarter);
    rows.extend(rows_of("(r, z)", &flat));
    let p = &quarter.snapshots[0].particles;
    let count = |body: u8| p.body.iter().filter(|&&b| b == body).count() as f64;
    let layout = "S1, quarter: layout of the yardstick";
    rows.push(Row::within("energy", format!("{layout}, particles of the sphere"), 4.0 * count(0), "", 14328.0, 0.0));
    rows.push(Row::within("energy", format!("{layout}, particles of the plate"), 4.0 * count(1), "", 86400.0, 0.0));
    rows.push(Row::within(
        "energy",
        format!("{layout}, kinetic energy"),
        quarter.ledger[0].kinetic,
        "J",
        27865.46,
        1e-5,
    ));
    rows.push(Row::within(
        "energy",
        format!("{layout}, momentum"),
        quarter.ledger[0].momentum,
        "kg m/s",
        8.31805,
        1e-5,
    ));
    let ratio = |a: f64, b: f64| 100.0 * (a / b - 1.0).abs();
    let case = "axisymmetry";
    let what = "S1, 3 cells, 2.5 us: (r, z) against the quarter";
    rows.push(Row::most(case, format!("{what}, leading 1 %"), ratio(flat.leading[1], quarter.leading[1]), "%", 3.0));
    rows.push(Row::most(case, format!("{what}, hole"), ratio(hole(&flat), hole(&quarter)), "%", 3.0));
    rows
}

/// S1 to 10 us: no collapse of the time step, and the same leading edge as the specification's own run.
pub fn long_rows() -> Vec<Row> {
    let impact = run(s1("axisymmetric", 3, "10 us"));
    let end = impact.ledger.last().expect("an end");
    let first = impact.ledger[1].time_step;
    let least = impact.ledger[1..].iter().map(|l| l.time_step / first).fold(f64::INFINITY, f64::min);
    let case = "time-step collapse";
    vec![
        Row::most(case, "S1, (r, z), 3 cells, 10 us: steps", end.step as f64, "", 600.0).peer("448"),
        Row::least(case, "S1, (r, z), 3 cells, 10 us: least time step over the first", least, "", 0.3),
        Row::most("energy", "S1, (r, z), 3 cells, 10 us: energy drift", drift(&impact), "", 1e-12).peer("1.1e-2"),
        Row::reported(
            "tiny nodal mass",
            "S1, (r, z), 3 cells, 10 us: leading 1 % (6087 in the specification's run)",
            impact.leading[1],
            "m/s",
        )
        .peer("7104"),
    ]
}

/// Refinement of S1 in (r, z) at `cells` through the plate: the last two within 5 %.
pub fn refinement(cells: &[u32], end: &str) -> Vec<Row> {
    let case = "thin plate";
    let runs: Vec<(u32, f64, f64)> = cells
        .iter()
        .map(|&n| {
            let impact = run(s1("axisymmetric", n, end));
            (n, impact.leading[1], hole(&impact))
        })
        .collect();
    let mut rows = Vec::new();
    for &(n, leading, hole) in &runs {
        rows.push(Row::reported(
            case,
            format!("S1, (r, z), {end}, {n} cells: leading 1 % over the impact speed"),
            leading / 6700.0,
            "",
        ));
        rows.push(Row::reported(case, format!("S1, (r, z), {end}, {n} cells: radius of the hole"), hole, "mm"));
    }
    let [.., a, b] = runs.as_slice() else { return rows };
    let pair = format!("S1, (r, z), {end}, {} against {} cells", a.0, b.0);
    rows.push(Row::most(case, format!("{pair}: leading 1 %"), 100.0 * (a.1 / b.1 - 1.0).abs(), "%", 5.0));
    rows.push(Row::most(case, format!("{pair}: hole"), 100.0 * (a.2 / b.2 - 1.0).abs(), "%", 5.0));
    rows
}
