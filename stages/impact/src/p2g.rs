//! Particles to grid: mass and momentum (step 1 of the method), then the stress that acts through the step and its forces
//! (steps 2 and 3).
use crate::grid::Grid;
use crate::material::{HalfStep, Law};
use crate::method::{Scheme, Transfer};
use crate::pack::{Pack, ahead};
use crate::step::Setting;
use crate::store::Site;
use crate::task::{Desk, Task};
use crate::tensor::{self, Gradient};
use crate::transfer::{By, Sums, gather, sharing, spread};
use crate::window::{Shared, clear_window, see_velocity};
use hvi_kit::lanes::{Eight, Quads, prefetch};

/// Step 1: `m_i = sum m w`, `m_i v_i = sum m w (v + C (x_i - x))`.
pub struct Momentum<'a, const D: usize> {
    /// The run's setting.
    pub setting: &'a Setting<D>,
    /// Where to.
    pub field: Shared<'a>,
}

impl<const D: usize> Task<D> for Momentum<'_, D> {
    const EACH_WIDTH: bool = true;

    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        if !site.gives {
            return;
        }
        let Desk { lines, windows, quads, .. } = desk;
        let method = &self.setting.method;
        let window = &mut windows[0];
        let [constant, columns @ ..] = quads;
        clear_window::<R, D>(site, window);
        let origin = site.origin();
        for group in &site.groups {
            for (k, pack) in group.packs.iter().enumerate() {
                if let Some(next) = group.packs.get(k + ahead(N)) {
                    prefetch(&next.position);
                    prefetch(&next.velocity);
                    prefetch(&next.matter.mass);
                    if N > 2 {
                        prefetch(&next.affine);
                    }
                }
                pack.momenta::<R>(constant);
                // Linear weights know no affine motion; with the others it is zero where the transfer has none.
                let (kernel, cell) = (method.kernel, self.setting.cell);
                if N > 2 {
                    lines.fill::<R, D, N, false, true>(&pack.position, &origin, kernel, cell);
                    pack.affine_momenta::<R>(columns);
                } else {
                    lines.fill::<R, D, N, false, false>(&pack.position, &origin, kernel, cell);
                }
                for lane in 0..group.live(k) {
                    if N > 2 {
                        spread::<R, D, N, true>(window, lines, lane, By::Moment, constant, columns);
                    } else {
                        spread::<R, D, N, false>(window, lines, lane, By::Moment, constant, columns);
                    }
                }
            }
        }
        // SAFETY: passes do blocks of one colour at a time, and those share no node.
        unsafe { self.field.add::<R, D>(site, window) };
    }
}

/// Steps 2 and 3: the heat of the transfer and the velocity gradient, the stress that acts through the step, and its force
/// `f_i = -V sum (S - P I) g`; in axisymmetry the hoop stress acts on the radial component too.
///
/// A particle is alone where `sum w m_i` is no more than its own `m sum w^2`. Alone, its affine field meets nothing, so its
/// gradient would stay as it is for ever and its volume grow as an exponential of time: it flies on as a whole instead, its state
/// untouched.
pub struct Force<'a, const D: usize> {
    /// The run's setting.
    pub setting: &'a Setting<D>,
    /// Masses and velocities.
    pub grid: &'a Grid<D>,
    /// Where to.
    pub field: Shared<'a>,
    /// Time step [s].
    pub dt: f64,
}

impl<const D: usize> Task<D> for Force<'_, D> {
    const EACH_WIDTH: bool = true;

    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        site.conducts = false;
        if !site.moves {
            return;
        }
        let own = site.reference();
        see_velocity::<R, D>(site, self.grid, &own, &mut desk.windows[0], &mut desk.masses);
        clear_window::<R, D>(site, &mut desk.windows[1]);
        let origin = site.origin();
        let mut conducts = false;
        for group in &mut site.groups {
            let law = &self.setting.laws[group.body as usize];
            let Desk { lines, windows, masses, sums, quads, .. } = &mut *desk;
            for k in 0..group.packs.len() {
                let live = group.live(k);
                if let Some(next) = group.packs.get(k + ahead(N)) {
                    prefetch(next);
                }
                let (pack, at) = (&mut group.packs[k], &mut sums[0]);
                let (kernel, cell) = (self.setting.method.kernel, self.setting.cell);
                if N > 2 {
                    lines.fill::<R, D, N, true, true>(&pack.position, &origin, kernel, cell);
                } else {
                    lines.fill::<R, D, N, true, false>(&pack.position, &origin, kernel, cell);
                }
                at.clear_after(live);
                for lane in 0..live {
                    // Linear weights know no affine motion.
                    if N > 2 {
                        gather::<R, D, N, true, true>(&windows[0], lines, lane, at);
                    } else {
                        gather::<R, D, N, true, false>(&windows[0], lines, lane, at);
                    }
                }
                let shared = R::load(&sharing::<D, N>(masses, lines, &pack.matter.mass, live));
                self.stress::<R>(pack, law, shared, &own, at, quads);
                conducts |= R::of(0.0).any_less(Law::shocked(&pack.matter.load::<R>(), cell));
                let [hoop, columns @ ..] = &*quads;
                for lane in 0..live {
                    spread::<R, D, N, true>(&mut windows[1], lines, lane, By::Slope, hoop, columns);
                }
            }
        }
        site.conducts = conducts;
        // SAFETY: passes do blocks of one colour at a time, and those share no node.
        unsafe { self.field.add::<R, D>(site, &mut desk.windows[1]) };
    }
}

impl<const D: usize> Force<'_, D> {
    /// Keeps a pack's heat, loneliness, divergence and stress at the middle of the step; `pull` is what goes with the weights in its
    /// forces, and what goes with their slopes, by level. Velocities on the grid are less `own`.
    #[inline(always)]
    fn stress<R: Eight>(
        &self,
        pack: &mut Pack<D>,
        law: &Law,
        shared: R,
        own: &[f64; 3],
        at: &Sums,
        pull: &mut [Quads; 4],
    ) {
        let (setting, zero, one) = (self.setting, R::of(0.0), R::of(1.0));
        let mut m = pack.matter.load::<R>();
        (one - shared).store(&mut pack.alone);
        match setting.method.transfer {
            Transfer::Apic => self.left_behind::<R>(pack, own, at).store(&mut pack.heat),
            Transfer::Flip | Transfer::Aflip => pack.heat = [0.0; 8],
            Transfer::Xpic { .. } => {}
        }
        let across = D.min(2) - 1;
        let radial = R::columns(&at.mean)[across + 1].plus(own[across]);
        let l = full_gradient::<R, D>(at, radial, R::load(&pack.position[across]), setting);
        let half: HalfStep<R> = match setting.method.scheme {
            Scheme::Midpoint => law.half_step(&m, &l, self.dt, setting.cell),
            Scheme::Usf | Scheme::Usl | Scheme::Musl => law.standing(&m, &l, setting.cell),
        };
        m.divergence = tensor::trace(&l) * shared;
        m.divergence.store(&mut pack.matter.divergence);
        (half.pressure * shared).store(&mut pack.half_pressure);
        let volume = (m.volume * m.ratio) * (zero - shared);
        let pressure = half.pressure + half.viscous;
        let mut full = [zero; 6];
        for k in 0..6 {
            (half.deviator[k] * shared).store(&mut pack.half_deviator[k]);
            let stress = if k < 3 { half.deviator[k] - pressure } else { half.deviator[k] };
            full[k] = stress * volume;
        }
        let mut constant = [zero; 4];
        if setting.axisymmetric {
            let radius = R::load(&pack.position[D - 1]).at_least(setting.least_radius());
            constant[D.min(2)] = full[2] / radius;
        }
        if setting.method.transfer == Transfer::Aflip {
            constant[0] = m.mass * law.damping(&m, m.divergence, self.dt, setting.cell);
        }
        R::transposed(constant, &mut pull[0]);
        const PLACE: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
        for d in 0..D {
            let mut columns = [zero; 4];
            for c in 0..D {
                columns[c + 1] = full[PLACE[c][d]];
            }
            R::transposed(columns, &mut pull[1 + d + 3 - D]);
        }
    }

    /// Energy of affine motion that its nodes don't take up: `m/2 sum w |v + C (x_i - x) - v_i|^2` [J], multiplied out with the weights'
    /// moments.
    #[inline(always)]
    fn left_behind<R: Eight>(&self, pack: &Pack<D>, own: &[f64; 3], at: &Sums) -> R {
        let moment = self.setting.method.moment(self.setting.cell);
        let mean = R::columns(&at.mean);
        let mut twice = mean[0];
        for c in 0..D {
            let v = R::load(&pack.velocity[c]).plus(-own[c]);
            twice = v.fused(v - mean[c + 1].times(2.0), twice);
        }
        for d in 0..D {
            let moments = R::columns(&at.moment[d + 3 - D]);
            for c in 0..D {
                let affine = R::load(&pack.affine[c][d]);
                twice = affine.fused(affine.times(moment) - moments[c + 1].times(2.0), twice);
            }
        }
        (R::load(&pack.matter.mass) * twice).times(0.5)
    }
}

/// Velocity gradient of the full space; the hoop rate is `radial / radius` in axisymmetry.
#[inline(always)]
pub fn full_gradient<R: Eight, const D: usize>(at: &Sums, radial: R, radius: R, setting: &Setting<D>) -> Gradient<R> {
    let mut full = [[R::of(0.0); 3]; 3];
    for j in 0..D {
        let column = R::columns(&at.slope[j + 3 - D]);
        for i in 0..D {
            full[i][j] = column[i + 1];
        }
    }
    if setting.axisymmetric {
        full[2][2] = radial / radius.at_least(setting.least_radius());
    }
    full
}
