//! Passes over all blocks of particles: on the processor's lanes, by one thread or several, with the same bits.
use crate::grid::{CLEAR, WINDOW, Window};
use crate::kernel::Lines;
use crate::step::Setting;
use crate::store::{Site, Store};
use crate::transfer::Sums;
use hvi_eos::Points;
use hvi_kit::lanes::{Eight, Quads, Work, prefetch};
use rayon::prelude::*;

/// What is done to one block. `run` and all it calls must be `#[inline(always)]`, to be compiled for the processor.
pub trait Task<const D: usize>: Sync {
    /// Whether it is compiled for each number of nodes an axis in space, where that is worth it; without it, and elsewhere, always for
    /// four, of which narrower kernels leave some at weight 0. The bits are the same.
    const EACH_WIDTH: bool = false;

    /// Does it, with `N` nodes an axis.
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk);
}

/// Room to work in.
pub struct Desk {
    /// Weights of a pack.
    pub lines: Lines,
    /// Nodes around a block, in up to four fields.
    pub windows: Box<[Window; 4]>,
    /// Masses of the first [kg].
    pub masses: Box<[f64; WINDOW]>,
    /// Sums of a pack, for up to four fields.
    pub sums: [Sums; 4],
    /// What eight particles give or compare, a quad each: constant parts, and columns by level.
    pub quads: [Quads; 4],
    /// Specific volumes [m3/kg] and energies [J/kg] of a group.
    pub volume: Vec<f64>,
    /// See `volume`.
    pub energy: Vec<f64>,
    /// What the equation of state says of them.
    pub points: Points,
}

impl Desk {
    fn new() -> Desk {
        Desk {
            lines: Lines::default(),
            windows: Box::new([CLEAR; 4]),
            masses: Box::new([0.0; WINDOW]),
            sums: [Sums::NONE; 4],
            quads: [[[0.0; 4]; 8]; 4],
            volume: Vec::new(),
            energy: Vec::new(),
            points: Points::default(),
        }
    }
}

/// Who does the passes.
#[derive(Default)]
pub struct Crew {
    pool: Option<rayon::ThreadPool>,
    desk: Option<Desk>,
}

impl Crew {
    /// Does `task` to all blocks, those of one colour in any order or at once.
    pub fn each<const D: usize, T: Task<D>>(&mut self, store: &mut Store<D>, setting: &Setting<D>, task: &T) {
        let threads = setting.threads.max(1);
        if threads == 1 {
            let desk = self.desk.get_or_insert_with(Desk::new);
            for sites in &mut store.sites {
                for k in 0..sites.len() {
                    // The next block's first particles are on their way meanwhile.
                    if let Some(pack) = sites.get(k + 1).and_then(|next| next.groups.first()?.packs.first()) {
                        prefetch(pack);
                    }
                    run(task, setting, &mut sites[k], desk);
                }
            }
            return;
        }
        if self.pool.as_ref().is_none_or(|pool| pool.current_num_threads() != threads) {
            self.pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok();
        }
        let mut pass = || {
            for sites in &mut store.sites {
                sites.par_iter_mut().for_each_init(Desk::new, |desk, site| run(task, setting, site, desk));
            }
        };
        match &self.pool {
            Some(pool) => pool.install(pass),
            // No threads to be had: the calling one does it.
            None => pass(),
        }
    }
}

/// A task at one block, on the lanes there are.
struct Run<'a, const D: usize, const N: usize, T> {
    task: &'a T,
    site: &'a mut Site<D>,
    desk: &'a mut Desk,
}

impl<const D: usize, const N: usize, T: Task<D>> Work for Run<'_, D, N, T> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        if N == 4 || const { fits::<D>() } && !R::IS_PORTABLE {
            self.task.run::<R, N>(self.site, self.desk);
        }
    }
}

/// Whether passes are compiled for narrower kernels.
pub const fn fits<const D: usize>() -> bool {
    D == 3
}

fn run<const D: usize, T: Task<D>>(task: &T, setting: &Setting<D>, site: &mut Site<D>, desk: &mut Desk) {
    let set = setting.instructions;
    let fits = const { fits::<D>() } && T::EACH_WIDTH && !set.is_portable();
    match setting.method.kernel.nodes() {
        2 if fits => set.run(Run::<D, 2, T> { task, site, desk }),
        3 if fits => set.run(Run::<D, 3, T> { task, site, desk }),
        _ => set.run(Run::<D, 4, T> { task, site, desk }),
    }
}
