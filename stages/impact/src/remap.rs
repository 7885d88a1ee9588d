//! Matter's deformation where it is a pass of its own: before the forces (USF), by the velocities at the end of the step (USL), or by the
//! particles' new velocities, which go to the grid once more (MUSL).
use crate::g2p;
use crate::grid::Grid;
use crate::method::Scheme;
use crate::p2g::full_gradient;
use crate::signal::Survey;
use crate::step::Setting;
use crate::store::{Frame, Site, Store};
use crate::task::{Crew, Desk, Task};
use crate::transfer::{gather, sharing};
use crate::window::{see_end, see_mean, see_velocity};
use crate::xpic;
use hvi_kit::lanes::Eight;

/// Deforms all particles by the gradient on the grid that the method's scheme wants, at the weights of the start of the step; at its end
/// they move by their `extra`.
pub fn deform<const D: usize>(
    store: &mut Store<D>,
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    cut: f64,
    dt: f64,
    crew: &mut Crew,
) {
    if setting.method.scheme == Scheme::Musl {
        xpic::average(store, grid, setting, false, crew);
    }
    let frame = store.frame();
    crew.each(store, setting, &Deform { setting, grid, cut, dt, frame });
}

struct Deform<'a, const D: usize> {
    setting: &'a Setting<D>,
    grid: &'a Grid<D>,
    cut: f64,
    dt: f64,
    frame: Frame,
}

impl<const D: usize> Task<D> for Deform<'_, D> {
    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        let setting = self.setting;
        let scheme = setting.method.scheme;
        let mut own = site.reference();
        let window = &mut desk.windows[0];
        match scheme {
            Scheme::Midpoint | Scheme::Usf => {
                see_velocity::<R, D>(site, self.grid, &own, window, &mut desk.masses);
            }
            Scheme::Usl => {
                let [end, middle, ..] = &mut *desk.windows;
                see_end::<R, D>(site, self.grid, false, &own, end, middle);
            }
            Scheme::Musl => {
                own = [0.0; 3];
                see_mean::<R, D>(site, self.grid, self.cut, window);
            }
        }
        let mut survey = Survey::<R, D>::new(site, self.frame, self.setting.quiet);
        let origin = site.origin();
        for group in &mut site.groups {
            let law = &setting.laws[group.body as usize];
            for k in 0..group.packs.len() {
                let live = group.live(k);
                let Desk { lines, windows, masses, sums, .. } = &mut *desk;
                let (pack, at) = (&mut group.packs[k], &mut sums[0]);
                lines.fill::<R, D, N, true, false>(&pack.position, &origin, setting.method.kernel, setting.cell);
                at.clear_after(live);
                for lane in 0..live {
                    gather::<R, D, N, true, false>(&windows[0], lines, lane, at);
                }
                let across = D.min(2) - 1;
                let radial = R::columns(&at.mean)[across + 1].plus(own[across]);
                let l = full_gradient::<R, D>(at, radial, R::load(&pack.position[across]), setting);
                let mut m = pack.matter.load::<R>();
                let old = m;
                let shared = match scheme {
                    // `alone` is not known yet.
                    Scheme::Midpoint | Scheme::Usf => R::load(&sharing::<D, N>(masses, lines, &pack.matter.mass, live)),
                    Scheme::Usl | Scheme::Musl => R::of(1.0) - R::load(&pack.alone),
                };
                let limited = law.deform(&mut m, &l, self.dt) * shared;
                g2p::keep_where_alone(&mut m, &old, R::of(0.0), shared);
                pack.matter.store(&m);
                site.booked.limited += (limited * g2p::counted::<R>(live)).sum() as u64;
                if scheme.deforms_last() {
                    for d in 0..D {
                        (R::load(&pack.position[d]) + R::load(&group.extra[k][d])).store(&mut pack.position[d]);
                    }
                    g2p::reflect::<R, D>(pack, &setting.mirrors);
                }
            }
            for batch in g2p::batches(group.packs.len()) {
                let (set, booked) = (setting.instructions, &mut site.booked);
                g2p::evaluate::<R, D>(group, batch, law, set, desk, &mut survey, booked);
            }
        }
        survey.keep(site);
        if scheme.deforms_last() {
            site.part();
        }
    }
}
