//! Passes over all blocks of particles: on the processor's lanes, by one thread or several, with the same bits.
use crate::grid::Node;
use crate::kernel::Lines;
use crate::step::Setting;
use crate::store::{Site, Store};
use crate::transfer::Sums;
use crate::window::{CLEAR, WINDOW, Window};
use hvi_eos::Points;
use hvi_kit::lanes::{Eight, Quads, Work, prefetch};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// What is done to one block. `run` and all it calls must be `#[inline(always)]`, to be compiled for the processor.
pub trait Task<const D: usize>: Sync {
    /// Whether it is compiled for each number of nodes an axis in space, where that is worth it; without it, and elsewhere, always for
    /// four, of which narrower kernels leave some at weight 0. The bits are the same.
    const EACH_WIDTH: bool = false;
    /// Whether it adds to nodes, so that only blocks of one colour may be done at once. Without it neighbours are done one after another,
    /// which have nodes in common.
    const ADDS: bool = true;

    /// Does it, with `N` nodes an axis.
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk);
}

/// Room to work in.
pub struct Desk {
    /// Weights of a pack.
    pub lines: Lines,
    /// Nodes around a block, in up to four fields.
    pub windows: Box<[Window; 4]>,
    /// The same for heat.
    pub heat: Box<Window>,
    /// Masses of the first window [kg].
    pub masses: Box<[f64; WINDOW]>,
    /// Sums of a pack, for up to four fields and heat.
    pub sums: [Sums; 5],
    /// What eight particles give or compare, a quad each: constant parts, and columns by level.
    pub quads: [Quads; 4],
    /// Specific volumes [m3/kg] and energies [J/kg] of a group.
    pub volume: Vec<f64>,
    /// See `volume`.
    pub energy: Vec<f64>,
    /// What the equation of state says of them.
    pub points: Points,
    /// Room for it to say more.
    pub capped: Points,
}

impl Desk {
    fn new() -> Desk {
        Desk {
            lines: Lines::default(),
            windows: Box::new([CLEAR; 4]),
            heat: Box::new(CLEAR),
            masses: Box::new([0.0; WINDOW]),
            sums: [Sums::NONE; 5],
            quads: [[[0.0; 4]; 8]; 4],
            volume: Vec::new(),
            energy: Vec::new(),
            points: Points::default(),
            capped: Points::default(),
        }
    }
}

/// Who does the passes.
#[derive(Default)]
pub struct Crew {
    pool: Option<rayon::ThreadPool>,
    /// Whether the pool is wanted.
    several: bool,
    desks: Mutex<Vec<Desk>>,
}

/// A desk in use; given back when done with.
struct Lent<'a> {
    desk: Option<Desk>,
    from: &'a Mutex<Vec<Desk>>,
}

impl Lent<'_> {
    fn new(from: &Mutex<Vec<Desk>>) -> Lent<'_> {
        let free = from.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Lent { desk: Some(free.unwrap_or_else(Desk::new)), from }
    }
    fn desk(&mut self) -> &mut Desk {
        self.desk.get_or_insert_with(Desk::new)
    }
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        self.from.lock().unwrap_or_else(PoisonError::into_inner).extend(self.desk.take());
    }
}

impl Crew {
    /// Does `task` to all blocks, in any order or at once: where it adds to nodes those of one colour, else all of them.
    pub fn each<const D: usize, T: Task<D>>(&mut self, store: &mut Store<D>, setting: &Setting<D>, task: &T) {
        self.hire(setting.threads);
        if T::ADDS {
            for sites in &mut store.sites {
                self.all(&mut sites.iter_mut().collect::<Vec<_>>(), setting, task);
            }
        } else {
            let mut sites: Vec<&mut Site<D>> = store.sites.iter_mut().flatten().collect();
            sites.sort_unstable_by_key(|site| site.key);
            self.all(&mut sites, setting, task);
        }
    }

    fn all<const D: usize, T: Task<D>>(&self, sites: &mut [&mut Site<D>], setting: &Setting<D>, task: &T) {
        if let Some(pool) = self.pool.as_ref().filter(|_| self.several) {
            let lend = || Lent::new(&self.desks);
            let pass = || sites.par_iter_mut().for_each_init(lend, |lent, site| run(task, setting, site, lent.desk()));
            return pool.install(pass);
        }
        let mut lent = Lent::new(&self.desks);
        for k in 0..sites.len() {
            // The next block's first particles are on their way meanwhile.
            if let Some(group) = sites.get(k + 2).and_then(|later| later.groups.first()) {
                prefetch(group);
            }
            if let Some(pack) = sites.get(k + 1).and_then(|next| next.groups.first()?.packs.first()) {
                prefetch(pack);
            }
            run(task, setting, sites[k], lent.desk());
        }
    }

    /// Does `work` to pieces of `nodes`, at once where there are threads; it is told where a piece starts.
    pub fn nodes(&mut self, threads: usize, nodes: &mut [Node], work: impl Fn(usize, &mut [Node]) + Sync) {
        self.hire(threads);
        match self.pool.as_ref().filter(|_| self.several) {
            Some(pool) => pool.install(|| {
                let pieces = nodes.par_chunks_mut(PIECE).enumerate();
                pieces.for_each(|(k, piece)| work(k * PIECE, piece));
            }),
            None => work(0, nodes),
        }
    }

    /// Sees to it that there are `threads` of them; where none are to be had the calling one does all.
    fn hire(&mut self, threads: usize) {
        self.several = threads > 1;
        if self.several && self.pool.as_ref().is_none_or(|pool| pool.current_num_threads() != threads) {
            self.pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok();
        }
    }
}

/// Nodes that a thread does at a time.
const PIECE: usize = 1 << 13;

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
