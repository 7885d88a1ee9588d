//! What is followed through a run: the state at places, what passes planes, and the state of single particles.
use crate::bodies::axes;
use crate::material::Law;
use crate::params::SpaceChoice;
use crate::particle::Particle;
use crate::result::{At, Passed, Probe, Track};
use crate::scene::Layout;
use crate::solid::Place;
use crate::step::{Setting, State};
use hvi_kit::Invalid;
use hvi_kit::units::Length;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Probes of a run, each under its name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probes {
    /// Places that stay where they are: the state of the matter there, the mean over a cell about it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub points: BTreeMap<String, Place>,
    /// Planes across the plate's normal, each by its x: what has passed it along x, less what came back.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub planes: BTreeMap<String, Length>,
    /// Particles, each by the place that it is nearest to at the start.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub particles: BTreeMap<String, Place>,
    /// Times between start and end at which they are read, 1 to 10000.
    #[serde(default = "samples")]
    pub samples: u32,
}

fn samples() -> u32 {
    200
}

/// Most probes of a run.
const MOST: usize = 64;

impl Probes {
    fn count(&self) -> usize {
        self.points.len() + self.planes.len() + self.particles.len()
    }

    /// Checks number, places and samples.
    ///
    /// # Errors
    /// The first that is wrong.
    pub fn check(&self, space: SpaceChoice) -> Result<(), Invalid> {
        if self.count() > MOST {
            return Err(Invalid::new("probes", format!("has {} probes, at most {MOST} are kept", self.count())));
        }
        if !(1..=10_000).contains(&self.samples) {
            return Err(Invalid::new("probes.samples", format!("is {}, must be 1 to 10000", self.samples)));
        }
        let used = axes(space);
        let all = [("points", &self.points), ("particles", &self.particles)];
        for (kind, name, at) in all.iter().flat_map(|(kind, all)| all.iter().map(move |(name, at)| (kind, name, at))) {
            if let Some(d) = (used..3).find(|&d| at[d].si() != 0.0) {
                let why = format!(
                    "lies at {} = {} mm, which space = {:?} does not have: 0 mm",
                    ["x", "y", "z"][d],
                    at[d].si() * 1e3,
                    space
                );
                return Err(Invalid::new(&format!("probes.{kind}.{name}"), why.to_lowercase()));
            }
        }
        Ok(())
    }
}

/// The probes of a run under way, with what they have shown so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Following {
    probes: Vec<Probe>,
    /// Number of the particle that each probe follows, for those that do.
    ids: Vec<Option<u32>>,
    /// By probe and number of the particle, whether it was beyond the plane; empty for other probes.
    beyond: Vec<Vec<bool>>,
    /// Passed so far, per the particles' mass unit.
    passed: Vec<Passed>,
    /// Samples asked for, and the number of the next.
    samples: u32,
    next: u32,
}

impl Following {
    /// The probes `asked` for, read at the start.
    pub fn new<const D: usize>(asked: &Probes, state: &State<D>, setting: &Setting<D>, layout: &Layout) -> Following {
        let mut following = Following {
            probes: Vec::new(),
            ids: Vec::new(),
            beyond: Vec::new(),
            passed: Vec::new(),
            samples: asked.samples,
            next: 0,
        };
        let mut add = |name: &String, place: [f64; 3], track: Track, id: Option<u32>, beyond: Vec<bool>| {
            following.probes.push(Probe { name: name.clone(), place, track });
            following.ids.push(id);
            following.beyond.push(beyond);
            following.passed.push(Passed::default());
        };
        for (name, at) in &asked.points {
            add(name, at.map(Length::si), Track::Point(Vec::new()), None, Vec::new());
        }
        for (name, x) in &asked.planes {
            let mut beyond = vec![false; state.count()];
            state.particles().for_each(|p| beyond[p.id as usize] = p.position[0] >= x.si());
            add(name, [x.si(), 0.0, 0.0], Track::Plane(Vec::new()), None, beyond);
        }
        for (name, at) in &asked.particles {
            let at = at.map(Length::si);
            let apart =
                |p: &Particle<D>| (0..D).map(|d| (p.position[d] - at[d]) * (p.position[d] - at[d])).sum::<f64>();
            let order = |a: &Particle<D>, b: &Particle<D>| apart(a).total_cmp(&apart(b)).then(a.id.cmp(&b.id));
            let id = state.particles().min_by(order).map(|p| p.id);
            add(name, at, Track::Particle(Vec::new()), id, Vec::new());
        }
        following.step(state, setting, layout);
        following
    }

    /// Looks at what has passed in the last step, and reads the probes where a sample is due.
    pub fn step<const D: usize>(&mut self, state: &State<D>, setting: &Setting<D>, layout: &Layout) {
        if self.probes.is_empty() {
            return;
        }
        for ((probe, beyond), passed) in self.probes.iter().zip(&mut self.beyond).zip(&mut self.passed) {
            if !beyond.is_empty() {
                pass(state.particles(), probe.place[0], beyond, passed);
            }
        }
        let samples = f64::from(self.samples);
        if state.time < layout.end * f64::from(self.next) / samples {
            return;
        }
        self.next = 1 + (samples * state.time / layout.end) as u32;
        for k in 0..self.probes.len() {
            let (place, time) = (self.probes[k].place, state.time);
            match &mut self.probes[k].track {
                Track::Point(all) => all.push(at_place(state, setting, place)),
                Track::Particle(all) => {
                    let own = state.particles().find(|p| Some(p.id) == self.ids[k]);
                    all.extend(own.map(|p| of_particle(&p, &setting.laws[p.body as usize], time)));
                }
                Track::Plane(all) => {
                    let (p, m) = (&self.passed[k], layout.multiple);
                    all.push(Passed {
                        time,
                        mass: m * p.mass,
                        momentum: m * p.momentum,
                        kinetic: m * p.kinetic,
                        internal: m * p.internal,
                    });
                }
            }
        }
    }

    /// What they have shown.
    pub fn done(self) -> Vec<Probe> {
        self.probes
    }
}

/// Books what has gone through the plane at `x` [m] since the last look.
fn pass<const D: usize>(
    particles: impl Iterator<Item = Particle<D>>,
    x: f64,
    beyond: &mut [bool],
    passed: &mut Passed,
) {
    for p in particles {
        let (is, was) = (p.position[0] >= x, &mut beyond[p.id as usize]);
        if is != *was {
            *was = is;
            let mass = if is { p.mass } else { -p.mass };
            passed.mass += mass;
            passed.momentum += mass * p.velocity[0];
            passed.kinetic += 0.5 * mass * p.velocity.iter().map(|v| v * v).sum::<f64>();
            passed.internal += mass * p.energy;
        }
    }
}

fn padded<const D: usize>(x: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|d| if d < D { x[d] } else { 0.0 })
}

/// The temperature is that of the matter itself: of a torn particle at its volume without the void.
fn of_particle<const D: usize>(p: &Particle<D>, law: &Law, time: f64) -> At {
    let volume = law.eos.reference_volume() * p.ratio;
    let own = || law.eos.point(law.eos.relaxed_volume(volume, p.energy), p.energy).temperature;
    At {
        time,
        position: padded(&p.position),
        velocity: padded(&p.velocity),
        density: 1.0 / volume,
        pressure: p.pressure(),
        temperature: if p.failed() { own() } else { p.temperature },
        energy: p.energy,
        plastic_strain: p.plastic_strain,
        failed: if p.failed() { 1.0 } else { 0.0 },
    }
}

/// Mean over the matter within a cell of `place`, weighted by mass and `(1 - |dx| / cell)` along each axis, mirror images
/// included; NaN where there is none.
fn at_place<const D: usize>(state: &State<D>, setting: &Setting<D>, place: [f64; 3]) -> At {
    let mut sum = At { time: state.time, position: place, ..At::default() };
    let mut total = 0.0;
    for p in state.particles() {
        for image in 0..1usize << D {
            let turned = |d: usize| image >> d & 1 == 1;
            if (0..D).any(|d| turned(d) && !setting.mirrors[d]) {
                continue;
            }
            let sign = |d: usize| if turned(d) { -1.0 } else { 1.0 };
            let near = |d: usize| (1.0 - (sign(d) * p.position[d] - place[d]).abs() / setting.cell).max(0.0);
            let weight = p.mass * (0..D).map(near).product::<f64>();
            if weight > 0.0 {
                let mut own = of_particle(&p, &setting.laws[p.body as usize], state.time);
                (0..D).for_each(|d| own.velocity[d] *= sign(d));
                total += weight;
                sum.add(&own, weight);
            }
        }
    }
    sum.over(total)
}
