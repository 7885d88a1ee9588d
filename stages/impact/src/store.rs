//! Where particles are kept: by block of the grid and body, in packs of eight.
//!
//! Only blocks that hold particles exist. Blocks come in colours such that no two of one colour share a node. After each
//! step particles that have left their block move over to their new one, so the order of all particles, and with it the order
//! of every sum, follows from the run's history alone.
use crate::kernel::{self, first_node};
use crate::pack::Pack;
use crate::particle::Particle;
use crate::signal::Signal;
use crate::step::Booked;
use crate::table::Table;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Particles of one body in one block.
pub struct Group<const D: usize> {
    /// Index of the body.
    pub body: u8,
    /// How many.
    pub count: usize,
    /// The particles.
    pub packs: Vec<Pack<D>>,
    /// A vector a particle that some methods keep within a step: see `xpic.rs` and `remap.rs`. Empty otherwise.
    pub extra: Vec<[[f64; 8]; D]>,
}

/// A block of [`kernel::edge`]^D cells that holds particles; a particle's cell is that of its first node.
pub struct Site<const D: usize> {
    /// Its place, in blocks; bodies with a field of their own are [`SECOND`] blocks off along the first axis.
    pub key: [i32; D],
    /// Its particles by body.
    pub groups: Vec<Group<D>>,
    /// The least and the greatest place in its window of its particles' first nodes, by level.
    pub cells: [[u8; 2]; 3],
    /// Some particles have left it, and wait for [`Site::part`].
    pub left: bool,
    /// Those that have left it.
    moved: Vec<Particle<D>>,
    /// The first and the last node (and one) of its window that its particles touch, by level.
    pub touched: [[u8; 2]; 3],
    /// Node blocks that its window lies over, by corner; those not touched are not to be used.
    pub homes: [u32; 8],
    /// What its particles' last step added to the accounts.
    pub booked: Booked,
    /// Its particles' fastest signal.
    pub signal: Signal,
    /// Whether heat is conducted here in this step.
    pub conducts: bool,
    /// Whether some of its particles move or bear stress.
    pub stirred: bool,
    /// Whether its particles move in this step: it is stirred, or shares blocks of nodes with one that is.
    pub moves: bool,
    /// Whether its particles count at the nodes in this step: it shares blocks of nodes with one that moves.
    pub gives: bool,
}

/// All particles.
pub struct Store<const D: usize> {
    /// The blocks by colour.
    pub sites: [Vec<Site<D>>; 8],
    frame: Frame,
    index: Table<D>,
    /// Colour and place in [`Store::sites`] by number in the index.
    seats: Vec<(u8, u32)>,
    /// Particles on their way, kept between steps for its memory.
    moved: Vec<Particle<D>>,
}

/// How positions become cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Grid spacing [m].
    pub cell: f64,
    /// See [`kernel::Kernel::reach`].
    pub reach: f64,
    /// Whether the first body's field is apart from the others'.
    pub apart: bool,
}

/// A particle where the grid can't follow: its number at the start.
#[derive(Debug)]
pub struct Lost(pub u32);

/// Cells from the origin beyond which a coordinate is taken for a runaway: far below where f64 loses the cell's inside.
const REACH: f64 = 5e8;
/// Where the second field's blocks are kept when bodies have fields of their own: so far along the first axis that keys don't meet.
pub const SECOND: i32 = 1 << 30;

impl<const D: usize> Group<D> {
    fn push(&mut self, p: &Particle<D>) {
        let lane = self.count % 8;
        if lane == 0 {
            if self.packs.len() == self.packs.capacity() {
                self.packs.reserve_exact(1 + self.packs.len() / 8);
            }
            self.packs.push(Pack::filled(p));
        } else {
            self.packs[self.count / 8].set(lane, p);
        }
        self.count += 1;
    }

    /// Takes out those marked as having left, from the last to the first, so that the last one, which takes an empty place, always
    /// stays.
    fn part(&mut self, moved: &mut Vec<Particle<D>>) {
        for k in (0..self.packs.len()).rev() {
            while self.packs[k].left != 0 {
                let lane = self.packs[k].left.ilog2() as usize;
                self.packs[k].left &= !(1 << lane);
                moved.push(self.packs[k].get(lane, self.body));
                self.count -= 1;
                if 8 * k + lane != self.count {
                    let last = self.get(self.count);
                    self.packs[k].set(lane, &last);
                }
            }
        }
        self.packs.truncate(self.count.div_ceil(8));
    }

    /// Particle `i`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Particle<D> {
        self.packs[i / 8].get(i % 8, self.body)
    }

    /// How many of the lanes of pack `k` hold particles.
    #[inline(always)]
    pub fn live(&self, k: usize) -> usize {
        (self.count - 8 * k).min(8)
    }
}

impl<const D: usize> Site<D> {
    /// Its first cell along each axis.
    #[inline(always)]
    pub fn origin(&self) -> [f64; D] {
        let mut origin = [0.0; D];
        for d in 0..D {
            let key = if d == 0 && self.key[0] > SECOND >> 1 { self.key[0] - SECOND } else { self.key[d] };
            origin[d] = key as f64 * kernel::edge::<D>() as f64;
        }
        origin
    }

    /// Velocity of its first particle: what others are told apart from, so that rounding is relative to differences.
    #[inline(always)]
    pub fn reference(&self) -> [f64; 3] {
        let mut velocity = [0.0; 3];
        (0..D).for_each(|c| velocity[c] = self.groups[0].packs[0].velocity[c][0]);
        velocity
    }

    /// Takes out what has left it, to be settled elsewhere.
    pub fn part(&mut self) {
        if self.left {
            self.left = false;
            self.groups.iter_mut().for_each(|group| group.part(&mut self.moved));
        }
    }

    /// Node blocks that its particles touch.
    pub fn node_blocks(&self) -> impl Iterator<Item = usize> {
        let needed = |corner: &usize| {
            (0..D).all(|d| corner >> d & 1 == 0 || self.touched[d + 3 - D][1] as usize > kernel::edge::<D>())
        };
        (0..1usize << D).filter(needed).map(|corner| self.homes[corner] as usize)
    }

    /// One more particle has its first node there, in cells from the start of the block.
    fn widen(&mut self, first: &[f64; D]) {
        self.stirred = true;
        for d in 0..D {
            let [low, high] = &mut self.cells[d + 3 - D];
            (*low, *high) = ((*low).min(first[d] as u8), (*high).max(first[d] as u8));
        }
    }
}

/// Before any particle has come.
const NO_CELLS: [[u8; 2]; 3] = [[u8::MAX, 0]; 3];

impl<const D: usize> Store<D> {
    /// Keeps `particles` but for those whose position isn't finite or lies more than 5e8 cells away: the first of them is told.
    pub fn new(particles: &[Particle<D>], frame: Frame) -> (Self, Option<Lost>) {
        let sites = std::array::from_fn(|_| Vec::new());
        let mut store = Store { sites, frame, index: Table::default(), seats: Vec::new(), moved: Vec::new() };
        let lost = particles.iter().filter_map(|p| store.insert(p).err()).reduce(|first, _| first);
        (store, lost)
    }

    /// All particles in order.
    pub fn iter(&self) -> impl Iterator<Item = Particle<D>> {
        let groups = self.sites.iter().flatten().flat_map(|site| &site.groups);
        groups.flat_map(|group| (0..group.count).map(|i| group.get(i)))
    }

    /// Shows every particle to `look`, in order.
    #[inline(always)]
    pub fn visit(&self, mut look: impl FnMut(Particle<D>)) {
        for group in self.sites.iter().flatten().flat_map(|site| &site.groups) {
            for i in 0..group.count {
                look(group.get(i));
            }
        }
    }

    /// How many particles.
    pub fn len(&self) -> usize {
        self.sites.iter().flatten().flat_map(|site| &site.groups).map(|group| group.count).sum()
    }

    /// Changes every particle; none may leave its cell.
    pub fn alter(&mut self, mut change: impl FnMut(&mut Particle<D>)) {
        for group in self.sites.iter_mut().flatten().flat_map(|site| &mut site.groups) {
            for i in 0..group.count {
                let mut p = group.get(i);
                change(&mut p);
                group.packs[i / 8].set(i % 8, &p);
            }
        }
    }

    /// Particles that have left their blocks and are not settled.
    pub fn leaving(&self) -> impl Iterator<Item = &Particle<D>> {
        self.sites.iter().flatten().flat_map(|site| &site.moved)
    }

    /// Moves particles that have left their blocks over to those they are in now.
    ///
    /// # Errors
    /// [`Lost`] for one that has gone beyond the range of the grid.
    pub fn settle(&mut self) -> Result<(), Lost> {
        let mut moved = std::mem::take(&mut self.moved);
        moved.clear();
        for site in self.sites.iter_mut().flatten().filter(|site| !site.moved.is_empty()) {
            moved.append(&mut std::mem::take(&mut site.moved));
        }
        if !moved.is_empty() {
            moved.iter().try_for_each(|p| self.insert(p))?;
            self.drop_empty();
        }
        self.moved = moved;
        Ok(())
    }

    /// Forgets blocks that hold nothing; the others keep their order.
    fn drop_empty(&mut self) {
        let mut any = false;
        for sites in &mut self.sites {
            for site in sites.iter_mut() {
                site.groups.retain(|group| group.count > 0);
                any |= site.groups.is_empty();
            }
            sites.retain(|site| !site.groups.is_empty());
        }
        if any {
            self.index.clear();
            self.seats.clear();
            for (colour, sites) in self.sites.iter().enumerate() {
                for (place, site) in sites.iter().enumerate() {
                    self.index.slot(site.key);
                    self.seats.push((colour as u8, place as u32));
                }
            }
        }
    }

    fn insert(&mut self, p: &Particle<D>) -> Result<(), Lost> {
        let (mut key, mut place) = ([0i32; D], [0.0; D]);
        let mut colour = 0;
        for d in 0..D {
            let (first, _) = first_node(p.position[d], 1.0 / self.frame.cell, self.frame.reach);
            if first.is_nan() || first.abs() >= REACH {
                return Err(Lost(p.id));
            }
            key[d] = (first as i32).div_euclid(kernel::edge::<D>() as i32);
            place[d] = first - key[d] as f64 * kernel::edge::<D>() as f64;
            colour |= (key[d] as u8 & 1) << d;
        }
        if self.frame.apart {
            key[0] += p.body.min(1) as i32 * SECOND;
        }
        let (number, new) = self.index.slot(key);
        if new {
            self.seats.push((colour, self.sites[colour as usize].len() as u32));
            self.sites[colour as usize].push(Site {
                key,
                groups: Vec::new(),
                cells: NO_CELLS,
                left: false,
                moved: Vec::new(),
                touched: [[0, 1]; 3],
                homes: [0; 8],
                booked: Booked::default(),
                signal: Signal::default(),
                conducts: false,
                stirred: true,
                moves: true,
                gives: true,
            });
        }
        let (colour, seat) = self.seats[number as usize];
        let site = &mut self.sites[colour as usize][seat as usize];
        site.widen(&place);
        let groups = &mut site.groups;
        let at = groups.iter().position(|group| group.body == p.body).unwrap_or_else(|| {
            groups.push(Group { body: p.body, count: 0, packs: Vec::new(), extra: Vec::new() });
            groups.len() - 1
        });
        groups[at].push(p);
        Ok(())
    }

    /// Notes which nodes each block touches, `nodes` an axis and particle.
    pub fn touch(&mut self, nodes: usize) {
        for site in self.sites.iter_mut().flatten() {
            for level in 3 - D..3 {
                let [low, high] = site.cells[level];
                site.touched[level] = [low, high + nodes as u8];
            }
        }
    }

    /// Has all blocks move that are stirred or share one of `blocks` node blocks with one that is: what a wave has not reached
    /// sleeps. Without `sleeps` all do.
    pub fn wake(&mut self, blocks: usize, sleeps: bool) {
        let (mut stirred, mut moved) = (vec![!sleeps; blocks], vec![!sleeps; blocks]);
        for site in self.sites.iter().flatten().filter(|site| site.stirred) {
            site.node_blocks().for_each(|block| stirred[block] = true);
        }
        for site in self.sites.iter_mut().flatten() {
            let moves = site.node_blocks().any(|block| stirred[block]);
            site.moves = moves;
            if site.moves {
                site.node_blocks().for_each(|block| moved[block] = true);
            }
        }
        for site in self.sites.iter_mut().flatten() {
            let gives = site.node_blocks().any(|block| moved[block]);
            site.gives = gives;
        }
    }

    /// How positions become cells.
    pub fn frame(&self) -> Frame {
        self.frame
    }
}

impl<const D: usize> Serialize for Store<D> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        (self.frame, self.iter().collect::<Vec<_>>()).serialize(to)
    }
}
impl<'a, const D: usize> Deserialize<'a> for Store<D> {
    fn deserialize<S: Deserializer<'a>>(from: S) -> Result<Self, S::Error> {
        let (frame, particles) = <(Frame, Vec<Particle<D>>)>::deserialize(from)?;
        match Store::new(&particles, frame) {
            (store, None) => Ok(store),
            (_, Some(Lost(id))) => Err(serde::de::Error::custom(format_args!("particle {id} is beyond the grid"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at<const D: usize>(position: [f64; D], id: u32) -> Particle<D> {
        Particle::new(position, [0.0; D], 1.0, 1.0, id, 0)
    }

    const FRAME: Frame = Frame { cell: 1.0, reach: 1.0, apart: false };

    /// Whether a particle's first node lies in the block; no for a NaN.
    fn inside<const D: usize>(position: &[f64; D], origin: &[f64; D], edge: f64, frame: &Frame) -> bool {
        (0..D).all(|d| {
            let at = first_node(position[d], 1.0 / frame.cell, frame.reach).0 - origin[d];
            0.0 <= at && at < edge
        })
    }

    /// Marks what has left its block, as a step does.
    fn mark(store: &mut Store<2>) {
        for site in store.sites.iter_mut().flatten() {
            site.left = true;
            let origin = site.origin();
            for group in &mut site.groups {
                for i in 0..group.count {
                    let out = !inside(&group.get(i).position, &origin, kernel::edge::<2>() as f64, &FRAME);
                    group.packs[i / 8].left |= (out as u8) << (i % 8);
                }
            }
            site.part();
        }
    }

    /// After particles have moved at random, each is kept once, in the block it is in, and a store made anew of all of them in order is
    /// the same.
    #[test]
    fn particles_settle_where_they_are() {
        let mut seed = 88172645463325252u64;
        let mut uniform = move || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let particles: Vec<_> = (0..700).map(|id| at([30.0 * uniform(), 30.0 * uniform()], id)).collect();
        let (mut store, lost) = Store::new(&particles, FRAME);
        assert!(lost.is_none());
        for _ in 0..20 {
            store.alter(|p| p.position = p.position.map(|x| x + 3.0 * uniform()));
            mark(&mut store);
            store.settle().expect("in reach");
            let mut ids: Vec<u32> = store.iter().map(|p| p.id).collect();
            ids.sort_unstable();
            assert!(ids.iter().copied().eq(0..700));
            for site in store.sites.iter().flatten() {
                let origin = site.origin();
                let all = site.groups.iter().flat_map(|group| (0..group.count).map(|i| group.get(i)));
                all.for_each(|p| assert!(inside(&p.position, &origin, kernel::edge::<2>() as f64, &FRAME)));
            }
            let again = Store::new(&store.iter().collect::<Vec<_>>(), FRAME).0;
            assert!(again.iter().eq(store.iter()));
        }
    }

    #[test]
    fn a_runaway_is_named() {
        let (store, lost) = Store::new(&[at([0.0], 4), at([f64::NAN], 7)], FRAME);
        assert_eq!((lost.expect("one is lost").0, store.len()), (7, 1));
    }
}
