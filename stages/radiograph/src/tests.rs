//! Known answers: chords of spheres, Abel kernels of rings, conservation of mass.
use super::*;
use hvi_impact::result::{Body, Particles};
use hvi_kit::{Artifact, units::Angle};
use std::f64::consts::PI;

const DENSITY: f64 = 8000.0;
const RADIUS: f64 = 5e-3;

fn impact(space: Space, cell: f64, snapshots: Vec<(f64, Particles)>) -> Impact {
    let body = Body { name: "plate".into(), material: "copper".into(), mass: 1.0, density: DENSITY };
    let snapshots = snapshots.into_iter().map(|(time, particles)| Snapshot { time, particles, melt: vec![] }).collect();
    Impact {
        space,
        cell,
        cells_through: 6.0,
        velocity: 6e3,
        diameter: 2.0 * RADIUS,
        thickness: 1e-3,
        bodies: vec![body],
        snapshots,
        ledger: vec![],
        angle: 0.0,
        probes: vec![],
        decisions: vec![],
        crossings: vec![],
        leading: [0.0; 3],
        notes: vec![],
    }
}

fn add(p: &mut Particles, at: [f64; 3], mass: f64) {
    for axis in 0..3 {
        p.position[axis].push(at[axis] as f32);
    }
    p.velocity.iter_mut().for_each(|v| v.push(0.0));
    p.body.push(0);
    p.mass.push(mass as f32);
    p.density.push(DENSITY as f32);
    p.phase.push((p.mass.len() % 5) as u8);
}

/// A solid sphere of rings on a lattice, as an axisymmetric run creates it.
fn ring_sphere(n: i32) -> Impact {
    let h = RADIUS / f64::from(n);
    let mut p = Particles::default();
    for (i, j) in (-n..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let (x, r) = ((f64::from(i) + 0.5) * h, (f64::from(j) + 0.5) * h);
        if x * x + r * r < RADIUS * RADIUS {
            add(&mut p, [x, r, 0.0], DENSITY * 2.0 * PI * r * h * h);
        }
    }
    impact(Space::Axisymmetric, 2.0 * h, vec![(1e-6, p)])
}

/// The same sphere in 3-D, a quarter of it stored.
fn quarter_sphere(n: i32) -> Impact {
    let h = RADIUS / f64::from(n);
    let at = |i: i32| (f64::from(i) + 0.5) * h;
    let mut p = Particles::default();
    for i in -n..n {
        for (j, k) in (0..n).flat_map(|j| (0..n).map(move |k| (j, k))) {
            if at(i) * at(i) + at(j) * at(j) + at(k) * at(k) < RADIUS * RADIUS {
                add(&mut p, [at(i), at(j), at(k)], DENSITY * h * h * h);
            }
        }
    }
    impact(Space::Full { mirror_y: true, mirror_z: true }, 2.0 * h, vec![(1e-6, p)])
}

/// Parameters with a frame of 12 mm square about the origin and the view given.
fn framed(view: View, width: u32) -> Params {
    let corner = |x: f64| [Length::new(x), Length::new(x)];
    let frame = Some(Frame { from: corner(-6e-3), to: corner(6e-3) });
    Params { view, exposures: vec![], width, frame, smooth: true, tone: Tone::Log, black: None, xray: None }
}

/// Light through the middle of a sphere on film: exp(-mu rho 2 R), to what the lattice makes of the chord (see below, 1.5 %);
/// beside it all of it; two flashes of the same add up.
#[test]
fn a_sphere_holds_back_what_its_chord_does() {
    let xray: Xray =
        serde_json::from_str("{\"energy\": \"150 keV\", \"blur\": \"0 mm\", \"pulse\": \"0 ns\"}").unwrap();
    let film = expose(&Params { xray: Some(xray), ..framed(View::default(), 61) }, ring_sphere(40));
    let exposed = film.exposed.as_ref().unwrap();
    let through = libm::exp(-0.02217 * DENSITY * 2.0 * RADIUS);
    assert!((exposed.least - through).abs() < 0.015 * through, "{} {through}", exposed.least);
    let corner = f64::from(exposed.density[0]);
    assert!((corner - 1.5).abs() < 1e-6, "{corner}");
    let mut two = ring_sphere(40);
    two.snapshots.push(Snapshot { time: 2e-6, ..two.snapshots[0].clone() });
    let times = vec![Time::new(1e-6), Time::new(2e-6)];
    let film = expose(&Params { xray: Some(xray), exposures: times, ..framed(View::default(), 61) }, two);
    let both = film.exposed.as_ref().unwrap();
    assert!((f64::from(both.density[0]) - xray.density(2.0)).abs() < 1e-6);
    assert_eq!(
        film.views()
            .iter()
            .filter(|v| matches!(v, hvi_kit::view::View::Picture(p) if p.title.starts_with("X-ray")))
            .count(),
        1
    );
}

/// A ball of matter that flies ahead of a plate with a hole: what a film is measured for.
#[test]
fn the_cloud_is_measured() {
    let mut run = ring_sphere(20);
    let p = &mut run.snapshots[0].particles;
    let n = p.mass.len();
    p.position[0].iter_mut().for_each(|x| *x += 20e-3);
    p.velocity[0] = vec![5000.0; n];
    p.body = vec![1; n];
    for i in 0..40 {
        let r = 8e-3 + f64::from(i) * 0.25e-3;
        add(p, [0.5e-3, r, 0.0], DENSITY * 2.0 * PI * r * 0.25e-3 * 1e-3);
    }
    run.bodies.push(Body { name: "projectile".into(), ..run.bodies[0].clone() });
    let shape = Shape::of(&run, &run.snapshots[0]).unwrap();
    // The sphere ends at 25 mm, the plate's rear is at 1 mm; half a per cent of its mass lies in the last half millimetre.
    assert!((shape.length - 24e-3).abs() < 0.6e-3 && (shape.width - 10e-3).abs() < 0.6e-3, "{shape:?}");
    assert!((shape.front_speed - 5000.0).abs() < 1e-6 && (shape.hole - 16e-3).abs() < 0.6e-3, "{shape:?}");
    assert!((shape.mass / (DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS) - 1.0).abs() < 0.01);
}

fn angles(azimuth: f64, elevation: f64) -> View {
    View::Angles(Angles { azimuth: Angle::new(azimuth), elevation: Angle::new(elevation) })
}

fn expose(p: &Params, run: Impact) -> Film {
    Radiograph::check(p).unwrap();
    Radiograph::run(p, Inputs { run }, &Ctx::quiet()).unwrap()
}

/// Root mean square difference to the chord 2 sqrt(R^2 - d^2) of a sphere, relative to the longest chord.
fn against_sphere(film: &Film) -> f64 {
    let (r, mut sum) = (film.raster, 0.0);
    for (k, &density) in film.density.iter().enumerate() {
        let (column, row) = (k as u32 % r.width, k as u32 / r.width);
        let u = r.left + (f64::from(column) + 0.5) * r.pixel;
        let v = r.top - (f64::from(row) + 0.5) * r.pixel;
        let chord = 2.0 * (RADIUS * RADIUS - u * u - v * v).max(0.0).sqrt();
        sum += (f64::from(density) / (2.0 * RADIUS * DENSITY) - chord / (2.0 * RADIUS)).powi(2);
    }
    (sum / film.density.len() as f64).sqrt()
}

/// The discs that the lattice makes of the sphere have radii off by up to h/2 = R/80 either way, .7 % rms; seen edge-on their
/// chords 2 sqrt(a^2 - v^2) are off by up to three times as much towards the rim. 1.5 % rms bounds that.
#[test]
fn a_sphere_of_rings_has_the_chords_of_a_sphere_from_anywhere() {
    for view in [View::default(), View::Named(Named::Front), angles(0.7, 0.3)] {
        let rms = against_sphere(&expose(&framed(view, 60), ring_sphere(40)));
        assert!(rms < 0.015, "{view:?}: {rms}");
    }
}

/// The same in 3-D. A chord through the lattice is a whole number of layers, so off by up to h = R/20 either way: h / sqrt(3)
/// rms, 1.4 % of the longest chord, over the 55 % of the frame that the sphere fills: 1.1 %; the rest is the pixels of the rim.
#[test]
fn a_solid_sphere_looks_the_same_from_anywhere() {
    for view in
        [View::default(), View::Named(Named::Top), View::Named(Named::Front), angles(0.5, 0.4), angles(-2.0, 1.0)]
    {
        let film = expose(&framed(view, 60), quarter_sphere(20));
        let rms = against_sphere(&film);
        assert!(rms < 0.015, "{view:?}: {rms}");
    }
}

/// Pixels smaller than particles: the inside of solid matter is smooth. Positions in f32 leave gaps
/// and overlaps of 5 mm * 6e-8 at particles 0.25 mm wide, 1e-6 of a pixel's mass each; a pattern would be of order 1.
#[test]
fn solid_matter_has_no_pattern() {
    let h = RADIUS / 20.0;
    let mut p = Particles::default();
    for i in 0..20 {
        for j in 0..20 {
            let r = (f64::from(j) + 0.5) * h;
            add(&mut p, [(f64::from(i) - 9.5) * h, r, 0.0], DENSITY * 2.0 * PI * r * h * h);
        }
    }
    let film = expose(&framed(View::default(), 337), impact(Space::Axisymmetric, 2.0 * h, vec![(0.0, p)]));
    let row = (film.raster.height / 2 * film.raster.width) as usize;
    let inside = |c: usize| {
        let u = film.raster.left + (c as f64 + 0.5) * film.raster.pixel;
        u.abs() < 10.0 * h - film.raster.pixel
    };
    let values: Vec<f32> =
        (0..film.raster.width as usize).filter(|&c| inside(c)).map(|c| film.density[row + c]).collect();
    let (low, high) = values.iter().fold((f32::MAX, 0f32), |(a, b), &v| (a.min(v), b.max(v)));
    assert!(values.len() > 100 && (high - low) / high < 2e-5, "{low} to {high}");
}

/// Mass between the heights a and b of a thin ring's edge-on projection: (asin(b/r) - asin(a/r)) / pi. The ring here is
/// 1e-3 of its radius thick, so the two agree to the square of that away from the rim.
#[test]
fn a_ring_has_the_abel_kernel() {
    let (r, side) = (4e-3, 4e-6);
    let mut p = Particles::default();
    add(&mut p, [0.0, r, 0.0], DENSITY * 2.0 * PI * r * side * side);
    let sharp = Params { smooth: false, ..framed(View::default(), 96) };
    let film = expose(&sharp, impact(Space::Axisymmetric, 1e-3, vec![(0.0, p)]));
    let f = film.raster;
    for row in 0..f.height {
        let top = f.top - f64::from(row) * f.pixel;
        let found: f64 = (0..f.width).map(|c| f64::from(film.density[(row * f.width + c) as usize])).sum();
        let angle = |y: f64| libm::asin((y / r).clamp(-1.0, 1.0));
        let expected = film.mass * (angle(top) - angle(top - f.pixel)) / PI / (f.pixel * f.pixel);
        if top.abs() < 0.9 * r {
            assert!((found / expected - 1.0).abs() < 1e-5, "row {row}: {found} for {expected}");
        }
    }
}

/// 1e-6 leaves room for the rounding of pixels to f32 in the stored film; the sum before that is exact to 1e-12.
#[test]
fn the_film_holds_the_mass_in_the_frame() {
    for (name, run) in [("rings", ring_sphere(15)), ("quarter", quarter_sphere(12))] {
        let whole: f64 = run.snapshots[0].particles.mass.iter().map(|&m| f64::from(m)).sum::<f64>()
            * if name == "quarter" { 4.0 } else { 1.0 };
        for view in [View::default(), angles(0.6, -0.2)] {
            let film = expose(&framed(view, 70), run.clone());
            let on_film =
                film.density.iter().map(|&d| f64::from(d)).sum::<f64>() * film.raster.pixel * film.raster.pixel;
            assert!((on_film / whole - 1.0).abs() < 1e-6, "{name} {view:?}: {on_film} of {whole}");
            assert!((film.caught / film.mass - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn what_lies_outside_the_frame_is_counted() {
    let corner = |x: f64, y: f64| [Length::new(x), Length::new(y)];
    let half = Some(Frame { from: corner(0.0, -6e-3), to: corner(6e-3, 6e-3) });
    let film = expose(&Params { frame: half, ..framed(View::default(), 60) }, ring_sphere(20));
    assert!((film.caught / film.mass - 0.5).abs() < 1e-12, "{}", film.caught / film.mass);
}

/// The frame is symmetric, so the two halves of a revolved run must be equal to rounding of the pixel edges.
#[test]
fn a_revolved_run_is_symmetric() {
    let film = expose(&Params { frame: None, ..framed(View::default(), 101) }, ring_sphere(15));
    let r = film.raster;
    let at = |row: u32, column: u32| film.density[(row * r.width + column) as usize];
    let peak = film.density.iter().copied().fold(0.0, f32::max);
    for (row, column) in (0..r.height).flat_map(|row| (0..r.width).map(move |column| (row, column))) {
        assert!((at(row, column) - at(r.height - 1 - row, column)).abs() < 1e-5 * peak, "row {row}, column {column}");
    }
    assert!(film.caught / film.mass > 0.998);
}

#[test]
fn exposures_add_up() {
    let (early, mut late) = (ring_sphere(10), ring_sphere(10));
    late.snapshots[0].particles.position[0].iter_mut().for_each(|x| *x += 2e-3);
    let mut both = early.clone();
    both.snapshots.push(Snapshot { time: 2e-6, ..late.snapshots[0].clone() });
    let p = framed(View::default(), 80);
    let times = vec![Time::new(1e-6), Time::new(2.01e-6)];
    let (a, b) = (expose(&p, early), expose(&p, late));
    let sum = expose(&Params { exposures: times, ..p }, both);
    assert_eq!(sum.exposures, [1e-6, 2e-6]);
    assert_eq!(sum.phases.len(), 2);
    for k in 0..sum.density.len() {
        let expected = a.density[k] + b.density[k];
        assert!((sum.density[k] - expected).abs() <= 1e-6 * expected.abs(), "pixel {k}");
    }
}

#[test]
fn a_time_that_was_not_kept_is_refused_with_those_that_were() {
    let p = Params { exposures: vec![Time::new(20e-6)], ..framed(View::default(), 80) };
    let why = Radiograph::run(&p, Inputs { run: ring_sphere(5) }, &Ctx::quiet()).unwrap_err().to_string();
    assert!(why.contains("within 1 % of 20 µs") && why.contains("kept 1 µs"), "{why}");
}

#[test]
fn runs_that_cannot_be_shown_say_why() {
    let refuse = |run| {
        Radiograph::run(&framed(View::default(), 80), Inputs { run }, &Ctx::quiet())
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    let mut broken = ring_sphere(5);
    broken.snapshots[0].particles.position[1][3] = f32::NAN;
    assert!(refuse(broken).contains("particle 3 at 1 µs"));
    assert!(refuse(Impact { space: Space::Line, ..ring_sphere(5) }).contains("one-dimensional"));
    assert!(refuse(Impact { snapshots: vec![], ..ring_sphere(5) }).contains("no snapshot"));
}

#[test]
fn parameters_out_of_range_are_named() {
    let p = framed(View::default(), 80);
    let key = |p: Params| Radiograph::check(&p).unwrap_err().key;
    assert_eq!(key(Params { width: 5, ..p.clone() }), "width");
    assert_eq!(key(Params { exposures: vec![Time::new(-1e-6)], ..p.clone() }), "exposures");
    assert_eq!(key(Params { black: Some(Length::new(0.0)), ..p.clone() }), "black");
    let flat = Frame { from: [Length::new(0.0); 2], to: [Length::new(1.0), Length::new(0.0)] };
    assert_eq!(key(Params { frame: Some(flat), ..p }), "frame");
}

/// Both halves of an axisymmetric cut are drawn, pixels of solid matter are all filled, and the shares are of the mass.
#[test]
fn the_phase_map_shows_both_halves() {
    let mut run = ring_sphere(20);
    let p = &mut run.snapshots[0].particles;
    p.phase = p.position[0].iter().map(|&x| if x < 0.0 { 0 } else { 2 }).collect();
    let film = expose(&framed(View::default(), 60), run);
    let map = &film.phases[0];
    let at = |u: f64, v: f64| {
        let r = map.raster;
        let (column, row) = ((u - r.left) / r.pixel, (r.top - v) / r.pixel);
        map.code[row as usize * r.width as usize + column as usize]
    };
    for y in [-4e-3, -1e-3, 1e-3, 4e-3] {
        assert_eq!((at(-1e-3, y), at(1e-3, y)), (0, 2), "height {y}");
    }
    assert_eq!(at(5.5e-3, 5.5e-3), 255);
    assert!((map.shares[0] - 0.5).abs() < 1e-6 && (map.shares[2] - 0.5).abs() < 1e-6);
}

/// Darker is more; full black is black; two decades below it still shows on the logarithmic scale.
#[test]
fn the_grey_scale_runs_from_white_to_black() {
    let log = expose(&framed(View::default(), 60), ring_sphere(10));
    let linear = Film { tone: Tone::Linear, ..log.clone() };
    for film in [&log, &linear] {
        assert_eq!(
            (film.blackness(0.0), film.blackness(film.black), film.blackness(9.0 * film.black)),
            (0.0, 1.0, 1.0)
        );
        assert!(film.blackness(0.2 * film.black) < film.blackness(0.3 * film.black));
    }
    assert!((linear.blackness(0.25 * linear.black) - 0.25).abs() < 1e-15);
    assert!(log.blackness(0.01 * log.black) > 0.1);
    let asked = expose(&Params { black: Some(Length::new(1e-3)), ..framed(View::default(), 60) }, ring_sphere(10));
    assert_eq!(asked.black, DENSITY * 1e-3);
}

#[test]
fn the_artifact_reads_back_and_shows_its_pictures() {
    let film = expose(&framed(angles(0.3, 0.1), 64), ring_sphere(8));
    assert_eq!(Film::decode(&film.encode()).unwrap(), film);
    let views = film.views();
    assert_eq!(views.len(), 2);
    for view in views {
        let hvi_kit::view::View::Picture(p) = view else { panic!("a picture is expected") };
        assert_eq!(p.rgb.len(), (3 * p.width * p.height) as usize);
    }
}

/// A lattice with a ninth of its matter leaves gaps of two thirds of its spacing, 3.3 pixels, of which 2 in 5 or more stay quite
/// empty, unless it is smoothed; the mass is the same either way.
#[test]
fn smoothing_fills_the_gaps_of_a_thin_cloud() {
    let h = RADIUS / 10.0;
    let mut p = Particles::default();
    for (i, j) in (0..10).flat_map(|i| (0..10).map(move |j| (i, j))) {
        let r = (f64::from(j) + 0.5) * h;
        add(&mut p, [(f64::from(i) - 4.5) * h, r, 0.0], DENSITY * 2.0 * PI * r * h * h / 9.0);
    }
    let run = impact(Space::Axisymmetric, 2.0 * h, vec![(0.0, p)]);
    let gaps = |smooth: bool| {
        let film = expose(&Params { smooth, ..framed(View::default(), 120) }, run.clone());
        let row = (film.raster.height / 2 * film.raster.width) as usize;
        let inside = &film.density[row + 40..row + 80];
        (film.caught, inside.iter().filter(|&&d| d == 0.0).count())
    };
    let ((mass_with, with), (mass_without, without)) = (gaps(true), gaps(false));
    assert!(with == 0 && without >= 16, "{with} and {without} of 40 pixels are empty");
    assert!((mass_with / mass_without - 1.0).abs() < 1e-12);
}
