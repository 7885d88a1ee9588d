//! Grid to particles: velocity, affine field and position (step 4 of the method), then volume, stress, energy and
//! equation of state (steps 5 to 7).
use crate::conduction;
use crate::grid::Grid;
use crate::material::{Answer, HalfStep, Law};
use crate::method::{Scheme, Transfer, TransferHeat};
use crate::p2g::full_gradient;
use crate::pack::{Pack, ahead};
use crate::particle::Matter;
use crate::signal::Survey;
use crate::step::{Booked, Setting};
use crate::store::{Frame, Group, Site};
use crate::task::{Desk, Task};
use crate::transfer::{Sums, gather};
use crate::window::{see_blend, see_end, see_heat};
use hvi_kit::lanes::{Eight, Instructions, Quads, prefetch};
use std::ops::Range;

/// Updates all particles by the velocities on the grid at the end and the middle of the step.
pub struct Update<'a, const D: usize> {
    /// The run's setting.
    pub setting: &'a Setting<D>,
    /// Velocities at the start of the step and their changes.
    pub grid: &'a Grid<D>,
    /// Time step [s].
    pub dt: f64,
    /// How positions become cells.
    pub frame: Frame,
}

/// No affine field.
pub const NONE: [Quads; 3] = [[[0.0; 4]; 8]; 3];

/// Sums over the particles of a block, in lanes: see [`Booked`].
struct Accounts<R> {
    transfer: R,
    unresolved: R,
    viscous: R,
    floored: R,
    limited: R,
}

impl<const D: usize> Task<D> for Update<'_, D> {
    const EACH_WIDTH: bool = true;
    const ADDS: bool = false;

    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        if !site.moves {
            return;
        }
        let method = &self.setting.method;
        let affine = method.transfer == Transfer::Apic;
        let own = site.reference();
        let blends = method.transfer == Transfer::Aflip;
        if blends {
            see_blend::<R, D>(site, self.grid, self.dt, &own, &mut desk.windows);
        } else {
            let [end, middle, ..] = &mut *desk.windows;
            see_end::<R, D>(site, self.grid, !affine, &own, end, middle);
        }
        let origin = site.origin();
        let zero = R::of(0.0);
        let mut accounts = Accounts { transfer: zero, unresolved: zero, viscous: zero, floored: zero, limited: zero };
        let mut survey = Survey::<R, D>::new(site, self.frame, self.setting.quiet);
        let mut groups = std::mem::take(&mut site.groups);
        for group in &mut groups {
            let law = &self.setting.laws[group.body as usize];
            if method.scheme.deforms_last() {
                group.extra.resize(group.packs.len(), [[0.0; 8]; D]);
            }
            let heat = self.grid.heat.get(self.setting.material(group.body)).filter(|_| site.conducts);
            if let Some(field) = heat {
                see_heat::<R, D>(site, field, &mut desk.heat);
            }
            for batch in batches(group.packs.len()) {
                for k in batch.clone() {
                    let live = group.live(k);
                    if let Some(next) = group.packs.get(k + ahead(N)) {
                        prefetch(next);
                    }
                    let Desk { lines, windows, heat: warm, sums, .. } = &mut *desk;
                    let pack = &mut group.packs[k];
                    let (kernel, cell) = (method.kernel, self.setting.cell);
                    if N > 2 {
                        lines.fill::<R, D, N, true, true>(&pack.position, &origin, kernel, cell);
                    } else {
                        lines.fill::<R, D, N, true, false>(&pack.position, &origin, kernel, cell);
                    }
                    for sums in &mut *sums {
                        sums.clear_after(live);
                    }
                    let [end, middle, damped, still, share] = &mut *sums;
                    for lane in 0..live {
                        if blends {
                            gather::<R, D, N, false, true>(&windows[0], lines, lane, end);
                            gather::<R, D, N, true, true>(&windows[1], lines, lane, middle);
                            gather::<R, D, N, false, true>(&windows[2], lines, lane, damped);
                            gather::<R, D, N, false, false>(&windows[3], lines, lane, still);
                            continue;
                        }
                        // Linear weights know no affine motion.
                        if N > 2 {
                            gather::<R, D, N, false, true>(&windows[0], lines, lane, end);
                        } else {
                            gather::<R, D, N, false, false>(&windows[0], lines, lane, end);
                        }
                        gather::<R, D, N, true, false>(&windows[1], lines, lane, middle);
                    }
                    if heat.is_some() {
                        for lane in 0..live {
                            gather::<R, D, N, false, false>(warm, lines, lane, share);
                        }
                        conduction::take::<R, D>(pack, law, &share.mean);
                    }
                    let extra = group.extra.get_mut(k);
                    self.advance::<R>(pack, extra, live, law, &own, sums, &mut accounts);
                }
                evaluate::<R, D>(group, batch, law, self.setting.instructions, desk, &mut survey, &mut site.booked);
            }
        }
        site.groups = groups;
        survey.keep(site);
        if !method.scheme.deforms_last() {
            site.part();
        }
        site.booked.transfer = accounts.transfer.sum();
        site.booked.unresolved = accounts.unresolved.sum();
        site.booked.viscous = accounts.viscous.sum();
        site.booked.floored = accounts.floored.sum();
        site.booked.limited += accounts.limited.sum() as u64;
    }
}

impl<const D: usize> Update<'_, D> {
    /// Motion, then work and deformation of a pack; its equation of state is left to be asked.
    #[inline(always)]
    fn advance<R: Eight>(
        &self,
        pack: &mut Pack<D>,
        extra: Option<&mut [[f64; 8]; D]>,
        live: usize,
        law: &Law,
        own: &[f64; 3],
        at: &[Sums; 5],
        accounts: &mut Accounts<R>,
    ) {
        let (setting, zero, one) = (self.setting, R::of(0.0), R::of(1.0));
        let scheme = setting.method.scheme;
        let across = D.min(2) - 1;
        let radius = R::load(&pack.position[across]);
        let mut velocity = [zero; D];
        let mean = R::columns(&at[1].mean);
        for c in 0..D {
            velocity[c] = mean[c + 1].plus(own[c]);
        }
        let l = full_gradient::<R, D>(&at[1], velocity[across], radius, setting);
        let mut m = pack.matter.load::<R>();
        let alone = R::load(&pack.alone);
        let shared = one - alone;
        let mut stress = HalfStep {
            pressure: R::load(&pack.half_pressure),
            viscous: law.viscosity(&m, m.divergence, setting.cell) * shared,
            deviator: [zero; 6],
            limited: zero,
        };
        for k in 0..6 {
            stress.deviator[k] = R::load(&pack.half_deviator[k]);
        }
        if scheme == Scheme::Midpoint {
            stress.limited = law.limited(&m, m.divergence, self.dt);
        }
        let lost = match setting.method.transfer {
            Transfer::Apic => self.adopt::<R>(pack, &m, own, &at[0]),
            Transfer::Aflip => self.blend::<R>(pack, &m, own, at),
            Transfer::Flip | Transfer::Xpic { .. } => self.accelerate::<R>(pack, &m, extra.as_deref(), &at[0]),
        };
        match extra {
            Some(way) if scheme.deforms_last() => {
                for d in 0..D {
                    velocity[d].times(self.dt).store(&mut way[d]);
                }
            }
            _ => {
                for d in 0..D {
                    (R::load(&pack.position[d]) + velocity[d].times(self.dt)).store(&mut pack.position[d]);
                }
            }
        }
        let unresolved = match setting.method.transfer_heat {
            TransferHeat::All => zero,
            TransferHeat::Shocks => lost * (one - law.compression(&m, m.divergence, setting.cell)),
        };
        let heat = R::load(&pack.heat) + lost - unresolved;
        let mut gain = Law::work(&mut m, &stress, &l, heat, self.dt);
        let mut limited = stress.limited;
        if scheme == Scheme::Midpoint {
            limited = limited.max(law.deform(&mut m, &l, self.dt));
        }
        if zero.any_less(alone) {
            // Alone it keeps its state; the heat of its transfer is no more than rounding.
            let old = pack.matter.load::<R>();
            let mut kept = Matter { divergence: zero, ..old };
            kept.energy = old.energy + heat / old.mass;
            let floored = (zero - kept.energy * kept.mass).at_least(0.0);
            kept.energy = kept.energy.at_least(0.0).where_less(kept.energy, R::of(f64::INFINITY), kept.energy);
            keep_where_alone(&mut m, &kept, zero, shared);
            gain.floored = gain.floored.where_less(zero, shared, floored);
            gain.viscous = gain.viscous * shared;
            limited = limited * shared;
        }
        pack.matter.store(&m);
        if !scheme.deforms_last() {
            reflect::<R, D>(pack, &setting.mirrors);
        }
        let counted = counted::<R>(live);
        accounts.transfer = heat.fused(counted, accounts.transfer);
        accounts.unresolved = unresolved.fused(counted, accounts.unresolved);
        accounts.viscous = gain.viscous.fused(counted, accounts.viscous);
        accounts.floored = gain.floored.fused(counted, accounts.floored);
        accounts.limited = limited.fused(counted, accounts.limited);
    }

    /// Takes over velocity and affine field `C = B / D`; what motion on the grid the particle can't hold,
    /// `m/2 [sum w |u|^2 - |mean u|^2 - D |C|^2]`, is heat from now on [J]. Velocities u on the grid are less `own`.
    #[inline(always)]
    fn adopt<R: Eight>(&self, pack: &mut Pack<D>, m: &Matter<R>, own: &[f64; 3], at: &Sums) -> R {
        let per_moment = 1.0 / self.setting.method.moment(self.setting.cell);
        let mut held = R::of(0.0);
        let mean = R::columns(&at.mean);
        for c in 0..D {
            held = mean[c + 1].fused(mean[c + 1], held);
            mean[c + 1].plus(own[c]).store(&mut pack.velocity[c]);
        }
        for d in 0..D {
            let moment = R::columns(&at.moment[d + 3 - D]);
            for c in 0..D {
                let affine = moment[c + 1].times(per_moment);
                held = moment[c + 1].fused(affine, held);
                affine.store(&mut pack.affine[c][d]);
            }
        }
        (m.mass * (mean[0] - held)).times(0.5)
    }

    /// Adds to the velocity the grid's change a of it less the damped share s of `r = u - v`, u the particle's own affine motion and v the
    /// grid's, and takes over the affine field of the grid's end e = v + a. With the sums of [`see_blend`], returns the heat [J]: what the
    /// kinetic energy (affine included) and the work of the forces have lost, up to `sum w s e.r`, which is nothing over all
    /// particles of a node,
    /// `m (sum w [a^2 / 2 + s (u_0 - e).r + u_1.r] - |change of velocity|^2 / 2 - D |change of C|^2 / 2)`, with `u = u_0 + u_1 = v_p + C (x_i - x)`.
    #[inline(always)]
    fn blend<R: Eight>(&self, pack: &mut Pack<D>, m: &Matter<R>, own: &[f64; 3], at: &[Sums; 5]) -> R {
        let moment = self.setting.method.moment(self.setting.cell);
        // Spelled out: a closure would not be compiled for the lanes' processor.
        let (end, middle) = (R::columns(&at[0].mean), R::columns(&at[1].mean));
        let (damped, still) = (R::columns(&at[2].mean), R::columns(&at[3].mean));
        let mut heat = middle[0] + end[0];
        let mut apart = [R::of(0.0); D];
        for c in 0..D {
            apart[c] = (R::load(&pack.velocity[c]).plus(-own[c])) * damped[0] - still[c + 1];
        }
        for d in 0..D {
            let level = d + 3 - D;
            let (end, middle) = (R::columns(&at[0].moment[level]), R::columns(&at[1].moment[level]));
            let damped = R::columns(&at[2].moment[level]);
            for c in 0..D {
                let old = R::load(&pack.affine[c][d]);
                apart[c] = old.fused(damped[0], apart[c]);
                let start = middle[c + 1].times(2.0) - end[c + 1];
                heat = old.fused(old.times(moment) - start - damped[c + 1], heat);
                let new = end[c + 1].times(1.0 / moment);
                let change = new - old;
                heat = heat - (change * change).times(0.5 * moment);
                new.store(&mut pack.affine[c][d]);
            }
        }
        for c in 0..D {
            let v = R::load(&pack.velocity[c]);
            let change = (end[c + 1] - middle[c + 1]).times(2.0) - apart[c];
            heat = v.plus(-own[c]).fused(apart[c] - damped[c + 1], heat);
            heat = heat - (change * change).times(0.5);
            (v + change).store(&mut pack.velocity[c]);
        }
        m.mass * heat
    }

    /// Adds the grid's change of velocity less what is damped; returns the heat [J]: what was damped, and the grid's motion that the
    /// particle can't hold, `m/2 (sum w |dt a_i|^2 - |dt a_p|^2)`.
    #[inline(always)]
    fn accelerate<R: Eight>(&self, pack: &mut Pack<D>, m: &Matter<R>, damped: Option<&[[f64; 8]; D]>, at: &Sums) -> R {
        let damped = damped.filter(|_| self.setting.method.transfer != Transfer::Flip);
        let mean = R::columns(&at.mean);
        let mut heat = mean[0].times(0.5);
        for c in 0..D {
            let gained = mean[c + 1];
            heat = heat - (gained * gained).times(0.5);
            let mut velocity = R::load(&pack.velocity[c]) + gained;
            if let Some(damped) = damped {
                let damped = R::load(&damped[c]);
                heat = gained.fused(damped, heat);
                velocity = velocity - damped;
            }
            velocity.store(&mut pack.velocity[c]);
        }
        m.mass * heat
    }
}

/// `old` where `shared` is not above `least`.
#[inline(always)]
pub fn keep_where_alone<R: Eight>(m: &mut Matter<R>, old: &Matter<R>, least: R, shared: R) {
    m.ratio = m.ratio.where_less(least, shared, old.ratio);
    m.energy = m.energy.where_less(least, shared, old.energy);
    m.plastic_strain = m.plastic_strain.where_less(least, shared, old.plastic_strain);
    m.damage = m.damage.where_less(least, shared, old.damage);
    m.hardened = m.hardened.where_less(least, shared, old.hardened);
    m.divergence = m.divergence.where_less(least, shared, old.divergence);
    for k in 0..6 {
        m.stress[k] = m.stress[k].where_less(least, shared, old.stress[k]);
    }
}

/// 1 for the first `live` lanes, else 0.
#[inline(always)]
pub fn counted<R: Eight>(live: usize) -> R {
    const COUNTED: [f64; 16] = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    R::load(COUNTED[8 - live..].first_chunk().expect("eight more"))
}

/// Packs done together: what goes to the equation of state and comes back stays in the first cache.
#[inline(always)]
pub fn batches(packs: usize) -> impl Iterator<Item = Range<usize>> {
    (0..packs).step_by(8).map(move |start| start..packs.min(start + 8))
}

/// Asks the equation of state for some packs of a group, has them take it over, and looks at what they are now.
#[inline(always)]
pub fn evaluate<R: Eight, const D: usize>(
    group: &mut Group<D>,
    batch: Range<usize>,
    law: &Law,
    set: Instructions,
    desk: &mut Desk,
    survey: &mut Survey<R, D>,
    booked: &mut Booked,
) {
    let Desk { volume, energy, points, capped, .. } = desk;
    volume.resize(8 * batch.len(), 0.0);
    energy.resize(8 * batch.len(), 0.0);
    let slots = volume.as_chunks_mut::<8>().0.iter_mut().zip(energy.as_chunks_mut::<8>().0);
    for (pack, (v, e)) in group.packs[batch.clone()].iter().zip(slots) {
        law.specific_volume(R::load(&pack.matter.ratio)).store(v);
        *e = pack.matter.energy;
    }
    // Dead lanes of the last pack have what its last particle has.
    let filled = 8 * (batch.len() - 1) + group.live(batch.end - 1);
    law.answers(set, &mut volume[..filled], &energy[..filled], points, capped);
    for array in [
        &mut points.pressure,
        &mut points.temperature,
        &mut points.sound_speed,
        &mut points.liquid,
        &mut points.melting,
    ] {
        let last = array[filled - 1];
        array.resize(8 * batch.len(), last);
    }
    for (i, k) in batch.enumerate() {
        let live = group.live(k);
        let pack = &mut group.packs[k];
        let mut m = pack.matter.load::<R>();
        let answer = Answer {
            pressure: eight(&points.pressure, i),
            temperature: eight(&points.temperature, i),
            sound_speed: eight(&points.sound_speed, i),
            liquid: eight(&points.liquid, i),
            melting: eight(&points.melting, i),
        };
        law.settle(&mut m, &answer);
        pack.matter.store(&m);
        book_extremes::<R>(&m, live, booked);
        survey.see(pack, live);
    }
}

/// The `k`th eight of an array.
#[inline(always)]
fn eight<R: Eight>(from: &[f64], k: usize) -> R {
    R::load(from[8 * k..].first_chunk().expect("eight more"))
}

/// Highest pressure, least volume, and whether all numbers are finite.
#[inline(always)]
fn book_extremes<R: Eight>(m: &Matter<R>, live: usize, booked: &mut Booked) {
    let (zero, infinity, counted) = (R::of(0.0), R::of(f64::INFINITY), counted::<R>(live));
    let pressure = m.pressure().where_less(zero, counted, zero - infinity);
    let thinness = zero - m.ratio.where_less(zero, counted, infinity);
    let sum = (m.energy + m.ratio + m.unclamped).size();
    booked.wrong |= zero.any_less(counted - counted.where_less(sum, infinity, zero));
    booked.highest_pressure = booked.highest_pressure.max(pressure.greatest());
    booked.least_ratio = booked.least_ratio.min(-thinness.greatest());
}

/// Shear stresses that a reflection of an axis turns round, as places in xx, yy, zz, xy, yz, xz.
const SHEARS: [[usize; 2]; 3] = [[3, 5], [3, 4], [4, 5]];

/// Puts particles that went through a mirror in their images' places; after the stress has taken its step, since the
/// velocity gradient of the step is that of the side it came from.
#[inline(always)]
pub fn reflect<R: Eight, const D: usize>(pack: &mut Pack<D>, mirrors: &[bool; D]) {
    let zero = R::of(0.0);
    for d in 0..D {
        let place = R::load(&pack.position[d]);
        if mirrors[d] && place.any_less(zero) {
            let turn = R::of(-1.0).where_less(place, zero, R::of(1.0));
            (place * turn).store(&mut pack.position[d]);
            turned(&mut pack.velocity[d], turn);
            for c in 0..D {
                turned(&mut pack.affine[c][d], turn);
                turned(&mut pack.affine[d][c], turn);
            }
            for k in SHEARS[d] {
                turned(&mut pack.matter.stress[k], turn);
            }
        }
    }
}

#[inline(always)]
fn turned<R: Eight>(x: &mut [f64; 8], turn: R) {
    (R::load(x) * turn).store(x);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::Particle;
    use hvi_kit::lanes::Plain;

    /// `R m R` with `R` the reflection of axis `d`.
    fn image(m: [[f64; 3]; 3], d: usize) -> [[f64; 3]; 3] {
        let sign = |i: usize| if i == d { -1.0 } else { 1.0 };
        std::array::from_fn(|i| std::array::from_fn(|j| sign(i) * m[i][j] * sign(j)))
    }

    fn full(s: &[f64; 6]) -> [[f64; 3]; 3] {
        [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]]
    }

    /// Behind a mirror a particle is its own image: `R x`, `R v`, `R C R` and `R S R`; in front it stays as it is.
    #[test]
    fn reflection_is_the_image() {
        let mut start = Particle::<3>::new([-0.1, -0.2, -0.3], [-4.0, -5.0, -6.0], 1.0, 1.0, 0, 0);
        start.affine = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]];
        start.stress = [1.0, 2.0, -3.0, 4.0, 5.0, 6.0];
        let mut front = start;
        front.position = start.position.map(f64::abs);
        for d in 0..3 {
            let mut pack = Pack::filled(&start);
            pack.set(5, &front);
            reflect::<Plain, 3>(&mut pack, &std::array::from_fn(|k| k == d));
            let p = pack.get(3, 0);
            for k in 0..3 {
                let sign = if k == d { -1.0 } else { 1.0 };
                assert_eq!((p.position[k], p.velocity[k]), (sign * start.position[k], sign * start.velocity[k]));
            }
            assert_eq!(p.affine, image(start.affine, d));
            assert_eq!(full(&p.stress), image(full(&start.stress), d));
            assert_eq!(pack.get(5, 0), front);
        }
    }
}
