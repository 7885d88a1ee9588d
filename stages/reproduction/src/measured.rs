//! The paper's quantities, taken out of results.
use crate::verdict::Found;
use hvi_empirical::{EtaLaw, Measure, Point};
use hvi_eos::{Eos, EosResult};
use hvi_impact::result::{Impact, Snapshot};
use hvi_radiograph::Shape;
use hvi_validate::{Compared, Validation};

/// One column: the results by one set of choices; each may be missing.
#[derive(Default)]
pub struct Column<'a> {
    /// The equation of state of copper.
    pub copper: Option<&'a EosResult>,
    /// That of the impacts, where it is another one.
    pub impacted: Option<&'a EosResult>,
    /// Against shock experiments.
    pub hugoniot: Option<&'a Validation>,
    /// Against diamond-anvil experiments.
    pub isotherm: Option<&'a Validation>,
    /// Aluminium sphere on copper plate.
    pub sphere: Option<&'a Impact>,
    /// Copper cylinder on aluminium plate.
    pub cylinder: Option<&'a Impact>,
    /// The law of the melted fraction.
    pub eta: Option<&'a EtaLaw>,
}

/// How a quantity is taken out of a column; nothing where the result is missing or has no such number.
type Take = fn(&Column<'_>) -> Option<Found>;

/// Every quantity that can be compared.
pub const QUANTITIES: &[(&str, Take)] = &[
    ("V0", |c| parameter(c, "V0")),
    ("C", |c| parameter(c, "C")),
    ("S", |c| parameter(c, "S")),
    ("gamma0", |c| parameter(c, "gamma0")),
    ("a", |c| parameter(c, "a")),
    ("g_e", |c| parameter(c, "g_e")),
    ("T_m", |c| parameter(c, "T_m")),
    ("states", |c| Some(Found::of(c.copper?.fit.as_ref()?.residuals.len() as f64))),
    ("surface_pressure_misfit", |c| Some(Found::of(c.copper?.fit.as_ref()?.pressure_misfit().0 / 1e9))),
    ("melting_jump", |c| melting_jump(c.copper?)),
    ("hugoniot_mean", |c| mean(c.hugoniot?, |p| p.measured >= LEAST && p.measured <= 200e9)),
    ("hugoniot_dense", |c| mean(c.hugoniot?, |p| volume(c, p).is_some_and(|v| v < 0.085e-3) && p.measured <= 200e9)),
    ("isotherm_dense", |c| largest(c.isotherm?, |p| volume(c, p).is_some_and(|v| v < 0.090e-3))),
    ("isotherm_mean", |c| mean(c.isotherm?, |p| p.measured >= LEAST)),
    ("sphere_length", |c| Some(Found::of(1e3 * shape(c.sphere?)?.length))),
    ("sphere_width", |c| Some(Found::of(1e3 * shape(c.sphere?)?.width))),
    ("sphere_front", |c| Some(Found::of(shape(c.sphere?)?.front_speed / c.sphere?.velocity))),
    ("sphere_molten", |c| molten(c.sphere?, 5e-6, "plate")),
    ("sphere_border", |c| border(c.sphere?, 5e-6)),
    ("cylinder_axis", |c| concentration(c.cylinder?)),
    ("cylinder_length", |c| Some(Found::of(1e3 * shape(c.cylinder?)?.length))),
    ("cylinder_width", |c| Some(Found::of(1e3 * shape(c.cylinder?)?.width))),
    ("cylinder_molten", |c| molten(c.cylinder?, 5e-6, "projectile")),
    ("slow_change", |c| greatest(c.eta?, |p| p.velocity <= 2.001e3, |p| changed(&p.projectile))),
    ("hot_onset", |c| onset(c.eta?, |p| hot(&p.projectile))),
    ("plate_onset", |c| onset(c.eta?, |p| changed(&p.plate))),
    ("plate_share", |c| plate_share(c.eta?)),
    ("release_onset", |c| landmark(c.impacted.or(c.copper)?, "symmetric impact that begins to melt on release")),
    ("alpha", |c| law(c.eta?, 0)),
    ("beta", |c| law(c.eta?, 1)),
    ("gamma", |c| law(c.eta?, 2)),
    ("alpha_limit", |c| limit(c.eta?, 0)),
    ("beta_limit", |c| limit(c.eta?, 1)),
    ("gamma_limit", |c| limit(c.eta?, 2)),
    ("eta_rms", |c| Some(Found::of(c.eta?.own.fitted.rms))),
    ("eta_check_rms", |c| (c.eta?.own.new.runs > 0).then(|| Found::of(c.eta.map_or(0.0, |e| e.own.new.rms)))),
    ("eta_contact", |c| at_contact(c.eta?, 0.0)),
    ("eta_contact_slow", |c| {
        let onset = take("release_onset", c)?.value * 1e3;
        at_contact(c.eta?, onset)
    }),
    ("eta_table4_rms", |c| Some(Found::of(c.eta?.paper.fitted.rms))),
];

/// Deviations count from this pressure up [Pa], as in `validate`.
const LEAST: f64 = 5e9;
/// Shares of the projectile's mass from here on are a phase change that a figure shows.
const SEEN: f64 = 0.02;

fn parameter(c: &Column<'_>, symbol: &str) -> Option<Found> {
    let copper = c.copper?;
    if let Some(fit) = &copper.fit {
        let p = fit.parameters.iter().find(|p| p.symbol == symbol)?;
        return Some(Found { value: p.value, error: p.quoted_error() });
    }
    let Eos::Gray(gray) = &copper.eos else { return None };
    let p = gray.parameters();
    let value = match symbol {
        "V0" => p.volume * 1e3,
        "C" => p.sound_speed * 1e-4,
        "S" => p.slope,
        "gamma0" => p.gruneisen,
        "a" => p.gruneisen_slope,
        "g_e" => p.electronic * p.molar_mass * 1e-3,
        _ => p.melting_temperature,
    };
    Some(Found::of(value))
}

/// Share of the liquid in all runs of the law, below `onset` [m/s] where that is above 0, that began within three cells of the contact:
/// what artificial viscosity overheats.
fn at_contact(eta: &EtaLaw, onset: f64) -> Option<Found> {
    // Of another measure's mass the liquid is no share.
    if eta.measure != Measure::Liquid {
        return None;
    }
    let runs = || eta.points.iter().filter(|p| onset == 0.0 || p.velocity < onset);
    let all: f64 = runs().map(|p| p.eta).sum();
    (all > 0.0).then(|| Found::of(runs().map(|p| p.contact).sum::<f64>() / all))
}

/// Rise of pressure across melting at V0 [GPa]: the belt of Fig 4.
fn melting_jump(copper: &EosResult) -> Option<Found> {
    let Eos::Gray(gray) = &copper.eos else { return None };
    let volume = gray.parameters().volume;
    let [begins, ends, _] = gray.borders(volume);
    let at = |t: f64| gray.at(volume, t).0.pressure;
    Some(Found::of((at(ends) - at(begins)) / 1e9))
}

/// Specific volume of an experiment [m3/kg], by the model's own V0.
fn volume(c: &Column<'_>, p: &Compared) -> Option<f64> {
    Some(p.ratio * c.copper?.eos.reference_volume())
}

fn deviations(v: &Validation, keep: impl Fn(&Compared) -> bool) -> Vec<f64> {
    v.points.iter().filter(|p| keep(p)).filter_map(|p| Some(100.0 * (p.model? / p.measured - 1.0))).collect()
}

/// Mean deviation of the equation of state from experiments [%].
fn mean(v: &Validation, keep: impl Fn(&Compared) -> bool) -> Option<Found> {
    let all = deviations(v, keep);
    (!all.is_empty()).then(|| Found::of(all.iter().sum::<f64>() / all.len() as f64))
}

/// Size of the largest deviation [%].
fn largest(v: &Validation, keep: impl Fn(&Compared) -> bool) -> Option<Found> {
    let all = deviations(v, keep);
    (!all.is_empty()).then(|| Found::of(all.iter().fold(0.0, |a: f64, d| a.max(d.abs()))))
}

fn shape(run: &Impact) -> Option<Shape> {
    Shape::of(run, run.snapshots.last()?)
}

fn at(run: &Impact, time: f64) -> Option<&Snapshot> {
    run.snapshots.iter().find(|s| (s.time / time - 1.0).abs() < 0.01)
}

/// Share of a body's own mass that has begun to melt or more, at the time [s].
fn molten(run: &Impact, time: f64, body: &str) -> Option<Found> {
    let (k, _) = run.bodies.iter().enumerate().find(|(_, b)| b.name == body)?;
    let p = &at(run, time)?.particles;
    let (mut all, mut hot) = (0.0, 0.0);
    // Of a plate only what moves with the cloud counts: the rest of it has no end.
    for i in (0..p.mass.len()).filter(|&i| usize::from(p.body[i]) == k) {
        if body == "plate" && f64::from(p.velocity[0][i]) < 0.05 * run.velocity {
            continue;
        }
        all += f64::from(p.mass[i]);
        hot += if p.phase[i] >= 1 { f64::from(p.mass[i]) } else { 0.0 };
    }
    (all > 0.0).then(|| Found::of(hot / all))
}

/// Molten share of the cloud's outer fifth by radius over that of its inner fifth; below 1 the middle melts more.
fn border(run: &Impact, time: f64) -> Option<Found> {
    let p = &at(run, time)?.particles;
    let radius = |i: usize| {
        let [_, y, z] = std::array::from_fn(|d| p.position[d].get(i).map_or(0.0, |&x| f64::from(x)));
        (y * y + z * z).sqrt()
    };
    let moving = |i: &usize| f64::from(p.velocity[0][*i]) > 0.05 * run.velocity;
    let mut cloud: Vec<usize> = (0..p.mass.len()).filter(moving).collect();
    cloud.sort_by(|&a, &b| radius(a).total_cmp(&radius(b)));
    let whole: f64 = cloud.iter().map(|&i| f64::from(p.mass[i])).sum();
    let share = |from: f64, to: f64| {
        let (mut before, mut all, mut hot) = (0.0, 0.0, 0.0);
        for &i in &cloud {
            let m = f64::from(p.mass[i]);
            if before >= from * whole && before < to * whole {
                all += m;
                hot += if p.phase[i] >= 1 { m } else { 0.0 };
            }
            before += m;
        }
        hot / all
    };
    let (inner, outer) = (share(0.0, 0.2), share(0.8, 1.0));
    (inner > 0.0).then(|| Found::of(outer / inner))
}

/// Mass of the cloud within a tenth of its width about the axis, over what an even spread over its section would have there.
fn concentration(run: &Impact) -> Option<Found> {
    let last = run.snapshots.last()?;
    let shape = Shape::of(run, last)?;
    let p = &last.particles;
    let radius = 0.05 * shape.width;
    let (mut near, mut all) = (0.0, 0.0);
    for i in (0..p.mass.len()).filter(|&i| shape.holds(run, &last.particles, i)) {
        let [_, y, z] = std::array::from_fn(|d| p.position[d].get(i).map_or(0.0, |&x| f64::from(x)));
        let m = f64::from(p.mass[i]);
        all += m;
        near += if y * y + z * z < radius * radius { m } else { 0.0 };
    }
    (all > 0.0).then(|| Found::of(near / all / 0.01))
}

fn changed(phases: &[f64; 5]) -> f64 {
    phases[2..].iter().sum()
}

fn hot(phases: &[f64; 5]) -> f64 {
    phases[3..].iter().sum()
}

/// The lowest speed at which `of` is seen in a sphere at least as wide as the plate is thick [km/s].
fn onset(eta: &EtaLaw, of: fn(&Point) -> f64) -> Option<Found> {
    let seen = eta.points.iter().filter(|p| p.ratio() > 1.0 && of(p) > SEEN).map(|p| p.velocity / 1e3);
    seen.reduce(f64::min).map(Found::of)
}

fn greatest(eta: &EtaLaw, keep: fn(&&Point) -> bool, of: fn(&Point) -> f64) -> Option<Found> {
    eta.points.iter().filter(keep).map(of).reduce(f64::max).map(Found::of)
}

/// Molten mass of the plates over that of the projectiles, all runs together.
fn plate_share(eta: &EtaLaw) -> Option<Found> {
    let sum = |of: fn(&Point) -> f64| eta.points.iter().map(of).sum::<f64>();
    let projectiles = sum(|p| changed(&p.projectile));
    (projectiles > 0.0).then(|| Found::of(sum(|p| changed(&p.plate)) / projectiles))
}

fn law(eta: &EtaLaw, i: usize) -> Option<Found> {
    Some(Found { value: eta.fit.law.values()[i], error: eta.error().values()[i] })
}

/// The law fitted to fractions extrapolated to a vanishing cell.
fn limit(eta: &EtaLaw, i: usize) -> Option<Found> {
    let limit = eta.refined.as_ref()?.limit.as_ref().ok()?;
    let error = limit.spread.map_or(limit.fit.error, |s| s.error);
    Some(Found { value: limit.fit.law.values()[i], error: error.values()[i] })
}

fn landmark(copper: &EosResult, name: &str) -> Option<Found> {
    let Eos::Gray(gray) = &copper.eos else { return None };
    let marks = hvi_eos::landmarks::landmarks(gray);
    marks.iter().find(|m| m.name == name)?.value.map(Found::of)
}

/// The quantity `id` of a column.
pub fn take(id: &str, column: &Column<'_>) -> Option<Found> {
    QUANTITIES.iter().find(|q| q.0 == id).and_then(|q| q.1(column)).filter(|f| f.value.is_finite())
}
