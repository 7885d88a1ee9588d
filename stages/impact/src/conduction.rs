//! Artificial heat conduction where matter is being compressed.
//!
//! Artificial viscosity overheats the few cells in which a shock is born, at a contact or a wall: the two halves of the shock's
//! profile are cut off there, and what they heat too much stays behind (W. F. Noh, J. Comput. Phys. 72, 78 (1987), who adds a
//! heat flux beside the viscosity). Here the thermal energy h of particles of one material goes over to a mean over the nodes and back,
//!
//! `dh_p = sum_i w_i alpha_i (h_i - h_p)`, `h_i = sum m w h / sum m w`, `alpha_i = min(1, nodal mass mean of k dt max(0, -div - M c / dx))`,
//!
//! with M a Mach number of .003 below which viscosity fades too, so that waves of sound take no heat along,
//! over matter without an open void (a torn particle's volume counts its void, at which its cold energy means nothing),
//! which conserves energy to rounding, makes no new extreme of h, and is nothing outside shocks. (Were it the whole energy e, matter
//! that is compressed would be robbed of the energy of compression and fall below zero on release.) What a shock of given speed
//! leaves behind where it was born is the difference of the energy in its own profile from that of a sharp front: so a narrow
//! profile with a foot of heat ahead of it leaves less, and the heat conduction pays for a smaller viscosity.
use crate::g2p::NONE;
use crate::grid::Grid;
use crate::material::Law;
use crate::pack::{Pack, ahead};
use crate::step::Setting;
use crate::store::{Group, Site, Store};
use crate::task::{Crew, Desk, Task};
use crate::transfer::{By, spread};
use crate::window::{Shared, clear_window};
use hvi_kit::lanes::{Eight, Quads};

/// Brings to the grid what particles take back as they move on, see [`take`], in a step of `dt` [s].
pub fn conduct<const D: usize>(
    store: &mut Store<D>,
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    dt: f64,
    crew: &mut Crew,
) {
    if !mark(store, grid.blocks()) {
        return;
    }
    grid.clear_heat();
    let mut heat = std::mem::take(&mut grid.heat);
    let fields = heat.iter_mut().map(|field| Shared::new(field)).collect();
    crew.each(store, setting, &Give { setting, fields, dt });
    grid.heat = heat;
    grid.fold_heat();
}

/// Has all blocks take part that share a node block with one in which matter is compressed; whether there are any.
fn mark<const D: usize>(store: &mut Store<D>, blocks: usize) -> bool {
    let mut active = vec![false; blocks];
    for site in store.sites.iter().flatten().filter(|site| site.conducts) {
        site.node_blocks().for_each(|block| active[block] = true);
    }
    for site in store.sites.iter_mut().flatten() {
        let takes_part = site.node_blocks().any(|block| active[block]);
        site.conducts = takes_part;
    }
    active.contains(&true)
}

/// Sums over particles: mass, heat, share.
struct Give<'a, const D: usize> {
    setting: &'a Setting<D>,
    fields: Vec<Shared<'a>>,
    dt: f64,
}

impl<const D: usize> Task<D> for Give<'_, D> {
    const EACH_WIDTH: bool = true;

    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        if !site.conducts {
            return;
        }
        let Desk { lines, windows, quads, .. } = desk;
        let (setting, origin) = (self.setting, site.origin());
        for (material, field) in self.fields.iter().enumerate() {
            let own = |group: &&Group<D>| setting.material(group.body) == material;
            if !site.groups.iter().any(|group| own(&group)) {
                continue;
            }
            clear_window::<R, D>(site, &mut windows[0]);
            for group in site.groups.iter().filter(own) {
                for (k, pack) in group.packs.iter().enumerate() {
                    if let Some(next) = group.packs.get(k + ahead(N)) {
                        next.prefetch_heat();
                    }
                    lines.fill::<R, D, N, false, false>(&pack.position, &origin, setting.method.kernel, setting.cell);
                    let m = pack.matter.load::<R>();
                    let closed = R::of(1.0) - m.open();
                    let mass = m.mass * closed;
                    let share = Law::shocked(&m, setting.cell).times(setting.method.conduction * self.dt);
                    let heat = setting.laws[material].thermal_energy(m.ratio, m.energy);
                    R::transposed([mass, mass * heat, mass * share, R::of(0.0)], &mut quads[0]);
                    for lane in 0..group.live(k) {
                        spread::<R, D, N, false>(&mut windows[0], lines, lane, By::Moment, &quads[0], &NONE);
                    }
                }
            }
            // SAFETY: passes do blocks of one colour at a time, and those share no node.
            unsafe { field.add::<R, D>(site, &mut windows[0]) };
        }
    }
}

/// Adds to a pack's heat what it gains: `at` are the sums over its nodes of the share and of the share times the mean, see
/// [`crate::window::see_heat`].
#[inline(always)]
pub fn take<R: Eight, const D: usize>(pack: &mut Pack<D>, law: &Law, at: &Quads) {
    let [share, gain, ..] = R::columns(at);
    let m = pack.matter.load::<R>();
    let heat = law.thermal_energy(m.ratio, m.energy);
    let gain = m.mass * (R::of(1.0) - m.open()) * (gain - share * heat);
    let gain = gain.where_less(R::of(0.0), share, R::of(0.0));
    (R::load(&pack.heat) + gain).store(&mut pack.heat);
}
