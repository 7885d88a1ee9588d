//! XPIC's damping of velocity: what is taken away, and the motion that becomes heat.
//!
//! With S the pass from grid to particles and S+ its mass-weighted transpose, XPIC of order k takes `d = (1 - S S+)^k v` from
//! each particle's velocity (C. C. Hammerquist and J. A. Nairn, Comput. Methods Appl. Mech. Eng. 318, 724 (2017)). The loss of
//! kinetic energy is booked where it happens: with `e_j = (1 - S S+)^j v`, and S S+ its own transpose in the mass-weighted
//! product, `sum m v.d` is `sum m |e_j|^2` for k = 2 j and `sum m sum_i w |e_j - (S+ e_j)_i|^2` for k = 2 j + 1.
use crate::g2p::NONE;
use crate::grid::Grid;
use crate::step::Setting;
use crate::store::{Site, Store};
use crate::task::{Crew, Desk, Task};
use crate::transfer::{By, gather, spread};
use crate::window::{Shared, clear_window, see_mean};
use hvi_kit::lanes::Eight;

/// Fills in what each particle's velocity loses (`extra` of its group) and the heat of it but for the part with the acceleration, for
/// `order` passes. The field of forces is used and left at zero.
pub fn damp<const D: usize>(
    store: &mut Store<D>,
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    order: u32,
    cut: f64,
    crew: &mut Crew,
) {
    for group in store.sites.iter_mut().flatten().flat_map(|site| &mut site.groups) {
        group.extra.clear();
        group.extra.extend(group.packs.iter().map(|pack| pack.velocity));
        group.packs.iter_mut().for_each(|pack| pack.heat = [0.0; 8]);
    }
    for pass in 0..order {
        average(store, grid, setting, true, crew);
        // The middle of the chain of passes holds the loss, see above.
        let books = match order % 2 {
            1 if pass == order / 2 => Books::Apart,
            0 if pass + 1 == order / 2 => Books::Left,
            _ => Books::Nothing,
        };
        crew.each(store, setting, &Remainder { setting, grid, cut, books, is_last: pass + 1 == order });
    }
    grid.force.fill([0.0; 4]);
}

/// Sums over particles of mass times `extra`, or times velocity, mirrored, in the field of forces.
pub fn average<const D: usize>(
    store: &mut Store<D>,
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    of_extra: bool,
    crew: &mut Crew,
) {
    grid.force.fill([0.0; 4]);
    crew.each(store, setting, &Give { setting, field: Shared::new(&mut grid.force), of_extra });
    grid.fold_force();
}

/// See [`average`].
struct Give<'a, const D: usize> {
    setting: &'a Setting<D>,
    field: Shared<'a>,
    of_extra: bool,
}

impl<const D: usize> Task<D> for Give<'_, D> {
    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        let Desk { lines, windows, quads, .. } = desk;
        clear_window::<R, D>(site, &mut windows[0]);
        let origin = site.origin();
        for group in &site.groups {
            for (k, pack) in group.packs.iter().enumerate() {
                lines.fill::<R, D, N, false, false>(
                    &pack.position,
                    &origin,
                    self.setting.method.kernel,
                    self.setting.cell,
                );
                let given = if self.of_extra { &group.extra[k] } else { &pack.velocity };
                let mut columns = [R::of(0.0); 4];
                for c in 0..D {
                    columns[c + 1] = R::load(&pack.matter.mass) * R::load(&given[c]);
                }
                R::transposed(columns, &mut quads[0]);
                for lane in 0..group.live(k) {
                    spread::<R, D, N, false>(&mut windows[0], lines, lane, By::Moment, &quads[0], &NONE);
                }
            }
        }
        // SAFETY: passes do blocks of one colour at a time, and those share no node.
        unsafe { self.field.add::<R, D>(site, &mut windows[0]) };
    }
}

/// What a pass books as heat.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Books {
    Nothing,
    /// `m sum w |e - mean|^2`
    Apart,
    /// `m |e|^2` after the pass.
    Left,
}

/// Takes the mean over the nodes off each particle's `extra`.
struct Remainder<'a, const D: usize> {
    setting: &'a Setting<D>,
    grid: &'a Grid<D>,
    cut: f64,
    books: Books,
    is_last: bool,
}

impl<const D: usize> Task<D> for Remainder<'_, D> {
    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        let Desk { lines, windows, sums, .. } = desk;
        let sums = &mut sums[0];
        see_mean::<R, D>(site, self.grid, self.cut, &mut windows[0]);
        let origin = site.origin();
        for group in &mut site.groups {
            for k in 0..group.packs.len() {
                let live = group.live(k);
                let (pack, extra) = (&mut group.packs[k], &mut group.extra[k]);
                lines.fill::<R, D, N, false, false>(
                    &pack.position,
                    &origin,
                    self.setting.method.kernel,
                    self.setting.cell,
                );
                for lane in 0..live {
                    gather::<R, D, N, false, false>(&windows[0], lines, lane, sums);
                    let (mut left, mut apart) = (0.0, sums.mean[lane][0]);
                    for c in 0..D {
                        let (before, mean) = (extra[c][lane], sums.mean[lane][c + 1]);
                        extra[c][lane] = before - mean;
                        left += extra[c][lane] * extra[c][lane];
                        apart += before * (before - 2.0 * mean);
                    }
                    let mass = pack.matter.mass[lane];
                    match self.books {
                        Books::Nothing => {}
                        Books::Apart => pack.heat[lane] = mass * apart,
                        Books::Left => pack.heat[lane] = mass * left,
                    }
                    if self.is_last {
                        pack.heat[lane] -= 0.5 * mass * left;
                    }
                }
            }
        }
    }
}
