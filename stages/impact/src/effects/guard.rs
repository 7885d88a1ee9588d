//! Watches, at each entry of the ledger, the effects that a plan left off.
use super::{Effect, Plan, estimate};
use crate::material::{Law, Material};
use crate::particle::Particle;
use crate::result::Crossing;
use crate::scene::Layout;
use crate::step::{Setting, State};
use serde::{Deserialize, Serialize};

/// Share of a body's mass that must be beyond an effect's threshold for it to be missed.
const SHARE: f64 = 0.01;
/// Work that strength would have done, over the initial kinetic energy, from which it is missed.
const WORK: f64 = 0.01;
/// Pressure [Pa] below which matter counts as released.
const RELEASED: f64 = 1e9;

/// What is kept between looks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Watch {
    /// Numbers of the particles at the plate's rim at the start.
    rim: Vec<u32>,
    /// Work that strength would have done so far, per the particles' mass unit [J].
    work: f64,
    /// Kinetic energy at the start, per the same [J].
    kinetic: f64,
    /// Time of the last look [s].
    last: f64,
}

impl Watch {
    /// At the start of a run.
    pub fn new<const D: usize>(plan: &Plan, state: &State<D>, setting: &Setting<D>, layout: &Layout) -> Watch {
        let half = 0.5 * layout.width - 2.0 * setting.cell;
        let across = |p: &Particle<D>| p.position[1..].iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let rim = |p: &Particle<D>| plan.off.contains(&Effect::Width) && p.body == 1 && across(p) > half;
        let moment = setting.method.moment(setting.cell);
        let mut rim: Vec<u32> = state.particles().filter(rim).map(|p| p.id).collect();
        rim.sort_unstable();
        Watch { rim, work: 0.0, kinetic: state.particles().map(|p| p.kinetic(moment)).sum(), last: 0.0 }
    }

    /// The first effect left off that is beyond its threshold.
    pub fn look<const D: usize>(
        &mut self,
        plan: &Plan,
        state: &State<D>,
        setting: &Setting<D>,
        materials: &[&Material],
    ) -> Option<Crossing> {
        let since = state.time - self.last;
        self.last = state.time;
        plan.off.iter().find_map(|&effect| {
            let (what, number, threshold) = match effect {
                Effect::Strength => {
                    let power = |p: &Particle<D>| {
                        let volume = p.volume * p.ratio.min(1.0);
                        let flow =
                            materials[p.body as usize].strength.flow_stress(1.0, 0.0, softening(p, setting, materials));
                        if p.failed() || p.alone { 0.0 } else { volume * flow * rate(p, setting) }
                    };
                    self.work += since * state.particles().map(|p| power(&p)).sum::<f64>();
                    ("work that strength would have done over the kinetic energy", self.work / self.kinetic, WORK)
                }
                Effect::Softening => {
                    let lost = |p: &Particle<D>| 1.0 - softening(p, setting, materials);
                    (
                        "share of a body's mass that heat would soften",
                        most(state, |p| lost(p) > effect.threshold()),
                        SHARE,
                    )
                }
                Effect::Rate => {
                    let gain =
                        |p: &Particle<D>| materials[p.body as usize].strength.rate_factor(rate(p, setting)) - 1.0;
                    (
                        "share of a body's mass that rate would harden",
                        most(state, |p| gain(p) > effect.threshold()),
                        SHARE,
                    )
                }
                Effect::Damage => {
                    let done = |p: &Particle<D>| {
                        let damage = materials[p.body as usize].damage.as_ref();
                        damage.map_or(0.0, |d| d.increment(p.plastic_strain, 1.0 / 3.0, 1.0, 0.0))
                    };
                    (
                        "share of a body's mass that would be damaged",
                        most(state, |p| done(p) > effect.threshold()),
                        SHARE,
                    )
                }
                Effect::Spall => {
                    let torn = |p: &Particle<D>| {
                        materials[p.body as usize]
                            .spall
                            .is_some_and(|limit| p.unclamped < -effect.threshold() * limit.si())
                    };
                    ("share of a body's mass in tension beyond half its spall strength", most(state, torn), SHARE)
                }
                Effect::Conduction => {
                    let hot = |p: &Particle<D>| {
                        let melting = estimate::melting(materials[p.body as usize], &setting.laws[p.body as usize].eos);
                        p.pressure() < RELEASED && p.temperature > effect.threshold() * melting
                    };
                    ("share of a body's released mass beyond half its melting temperature", most(state, hot), SHARE)
                }
                // What the rim sends back in the second half is not at the hole by the end.
                Effect::Width if state.time > 0.5 * plan.params.end.map_or(0.0, |t| t.si()) => return None,
                Effect::Width => {
                    let speed = |p: &Particle<D>| p.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
                    let fastest =
                        state.particles().filter(|p| self.rim.binary_search(&p.id).is_ok()).map(|p| speed(&p));
                    (
                        "speed of the rim over the impact's",
                        fastest.fold(0.0, f64::max) / plan.params.velocity.si(),
                        effect.threshold(),
                    )
                }
                // Bodies that stick where they meet show nothing that a look at single particles could tell from sound matter.
                Effect::Contact => return None,
            };
            (number > threshold).then(|| Crossing { effect, time: state.time, what: what.into(), number, threshold })
        })
    }
}

/// Largest share, over the bodies, of a body's mass that `is` so.
fn most<const D: usize>(state: &State<D>, is: impl Fn(&Particle<D>) -> bool) -> f64 {
    let mut sums: Vec<[f64; 2]> = Vec::new();
    for p in state.particles() {
        let body = p.body as usize;
        if sums.len() <= body {
            sums.resize(body + 1, [0.0; 2]);
        }
        sums[body][0] += p.mass;
        sums[body][1] += if is(&p) { p.mass } else { 0.0 };
    }
    sums.iter().map(|[all, part]| if *all > 0.0 { part / all } else { 0.0 }).fold(0.0, f64::max)
}

fn softening<const D: usize>(p: &Particle<D>, setting: &Setting<D>, materials: &[&Material]) -> f64 {
    let (law, jc): (&Law, _) = (&setting.laws[p.body as usize], &materials[p.body as usize].strength);
    let melting = law.eos.melting_temperature(law.eos.reference_volume() * p.ratio);
    jc.softening(jc.homologous(p.temperature, melting.unwrap_or(jc.melting_temperature.si())))
}

/// Equivalent rate of deviatoric strain [1/s], by the particle's affine motion.
fn rate<const D: usize>(p: &Particle<D>, setting: &Setting<D>) -> f64 {
    let mut l = [[0.0; 3]; 3];
    for i in 0..D {
        l[i][..D].copy_from_slice(&p.affine[i]);
    }
    if setting.axisymmetric {
        l[2][2] = p.velocity[D - 1] / p.position[D - 1].max(setting.least_radius());
    }
    let mean = (l[0][0] + l[1][1] + l[2][2]) / 3.0;
    let mut sum = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            let d = 0.5 * (l[i][j] + l[j][i]) - if i == j { mean } else { 0.0 };
            sum += d * d;
        }
    }
    (2.0 / 3.0 * sum).sqrt()
}
