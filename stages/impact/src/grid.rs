//! A sparse grid without a box: blocks of 4^D nodes that exist only where particles are.
//!
//! Each step it is laid out anew, in the order of the particles, so its node numbers and with them every sum's order
//! depend on the particles alone.
use crate::kernel;
use crate::particle::Particle;

/// One node.
#[derive(Clone, Copy, Debug)]
pub struct Node<const D: usize> {
    /// Mass [kg].
    pub mass: f64,
    /// Momentum [kg m/s] while particles give theirs, then the velocity at the start of the step [m/s].
    pub velocity: [f64; D],
    /// Force [N] while particles give theirs, then the velocity at the end of the step [m/s].
    pub next: [f64; D],
}

/// The nodes around occupied cells.
#[derive(Default)]
pub struct Grid<const D: usize> {
    /// All nodes of all blocks; the last axis runs fastest inside a block.
    pub nodes: Vec<Node<D>>,
    /// Nodes on a mirror plane, by axis.
    pub on_plane: [Vec<u32>; 3],
    /// Nodes next to a mirror plane and their images behind it, by axis.
    pub images: [Vec<(u32, u32)>; 3],
    stencils: Vec<u32>,
    blocks: Vec<[i32; D]>,
    cells: Table<D>,
    homes: Table<D>,
}

/// A particle where the grid can't follow: its index.
#[derive(Debug)]
pub struct Lost(pub usize);

/// Cells from the origin beyond which a coordinate is taken for a runaway: far below where f64 loses the cell's inside.
const REACH: f64 = 5e8;

/// Where the second body's nodes are kept when bodies have fields of their own: so far along the first axis that keys don't meet.
const SECOND: i32 = 1 << 30;

impl<const D: usize> Grid<D> {
    /// Nodes at the same place of the first and the second body's fields.
    pub fn shared(&self) -> Vec<(u32, u32)> {
        let n = const { kernel::nodes::<D>() as u32 };
        let mut pairs = Vec::new();
        for (b, key) in self.blocks.iter().enumerate().filter(|(_, key)| key[0] > SECOND >> 3) {
            let mut first = *key;
            first[0] -= SECOND >> 2;
            if let Some(a) = self.homes.find(first) {
                pairs.extend((0..n).map(|k| (a * n + k, b as u32 * n + k)));
            }
        }
        pairs
    }

    /// Nodes of the cell in `slot`, rows of the last axis in order: 4^D numbers.
    #[inline(always)]
    pub fn stencil(&self, slot: u32) -> &[u32] {
        let n = const { kernel::nodes::<D>() };
        &self.stencils[slot as usize * n..][..n]
    }

    /// Node `number` of the cell in `slot`.
    #[inline(always)]
    pub fn at(&mut self, slot: u32, number: usize) -> &mut Node<D> {
        let index = self.stencil(slot)[number];
        &mut self.nodes[index as usize]
    }

    /// Lays out the nodes around `particles` and puts each particle's cell slot into `slots`; all nodes are zero then. With `apart`
    /// the first body and all others get nodes of their own (and no mirror along the first axis).
    ///
    /// # Errors
    /// [`Lost`] for a particle whose position isn't finite or lies more than 5e8 cells away.
    pub fn lay_out(
        &mut self,
        particles: &[Particle<D>],
        cell: f64,
        mirrors: &[bool; D],
        apart: bool,
        slots: &mut Vec<u32>,
    ) -> Result<(), Lost> {
        self.cells.clear();
        self.homes.clear();
        self.stencils.clear();
        self.blocks.clear();
        slots.clear();
        let mut last: Option<([i32; D], u32)> = None;
        for (i, p) in particles.iter().enumerate() {
            let mut key = [0; D];
            for d in 0..D {
                let c = kernel::cell_of(p.position[d], cell);
                if c.is_nan() || c.abs() >= REACH {
                    return Err(Lost(i));
                }
                key[d] = c as i32;
            }
            if apart {
                key[0] += p.body.min(1) as i32 * SECOND;
            }
            let slot = match last {
                Some((k, slot)) if k == key => slot,
                _ => self.cell(key),
            };
            last = Some((key, slot));
            slots.push(slot);
        }
        let zero = Node { mass: 0.0, velocity: [0.0; D], next: [0.0; D] };
        self.nodes.clear();
        self.nodes.resize(self.blocks.len() * const { kernel::nodes::<D>() }, zero);
        self.find_mirrors(mirrors);
        Ok(())
    }

    /// Slot of the cell `key`, made with its list of nodes where it is new.
    fn cell(&mut self, key: [i32; D]) -> u32 {
        let (slot, new) = self.cells.slot(key);
        if new {
            let first: [i32; D] = std::array::from_fn(|d| key[d] - 1);
            let mut homes = [0u32; 8];
            for (corner, home) in homes.iter_mut().enumerate().take(1 << D) {
                let block = std::array::from_fn(|d| (first[d] >> 2) + (corner as i32 >> d & 1));
                let needed = (0..D).all(|d| corner >> d & 1 == 0 || first[d] & 3 != 0);
                if needed {
                    *home = self.block(block);
                }
            }
            for node in 0..const { kernel::nodes::<D>() } {
                let (mut corner, mut inside) = (0, 0);
                for d in 0..D {
                    let at = (first[d] & 3) + (node >> (2 * (D - 1 - d)) & 3) as i32;
                    corner |= ((at >> 2) as usize) << d;
                    inside = inside * 4 + (at & 3) as u32;
                }
                self.stencils.push(homes[corner] * const { kernel::nodes::<D>() as u32 } + inside);
            }
        }
        slot
    }

    fn block(&mut self, key: [i32; D]) -> u32 {
        let (home, new) = self.homes.slot(key);
        if new {
            self.blocks.push(key);
        }
        home
    }

    /// Only cell 0 beside a mirror reaches behind it, to one layer of nodes; its stencil holds the partners in front.
    fn find_mirrors(&mut self, mirrors: &[bool; D]) {
        let n = const { kernel::nodes::<D>() as u32 };
        for d in 0..D {
            self.on_plane[d].clear();
            self.images[d].clear();
            if !mirrors[d] {
                continue;
            }
            let stride = 4u32.pow((D - 1 - d) as u32);
            let along = |node: u32| node / stride % 4;
            for (b, key) in self.blocks.iter().enumerate() {
                let start = b as u32 * n;
                if key[d] == 0 {
                    self.on_plane[d].extend((0..n).filter(|&k| along(k) == 0).map(|k| start + k));
                } else if key[d] == -1 {
                    let mut front = *key;
                    front[d] = 0;
                    let front = self.homes.find(front).expect("a cell beside the mirror has nodes on both sides") * n;
                    let pairs = (0..n).filter(|&k| along(k) == 3).map(|k| (front + k - 2 * stride, start + k));
                    self.images[d].extend(pairs);
                }
            }
        }
    }
}

/// Open-addressing map from whole-number coordinates to slots numbered in order of arrival.
struct Table<const D: usize> {
    entries: Vec<Entry<D>>,
    count: u32,
    round: u32,
}

#[derive(Clone, Copy)]
struct Entry<const D: usize> {
    key: [i32; D],
    slot: u32,
    round: u32,
}

impl<const D: usize> Default for Table<D> {
    fn default() -> Self {
        Self { entries: vec![Entry { key: [0; D], slot: 0, round: 0 }; 64], count: 0, round: 1 }
    }
}

impl<const D: usize> Table<D> {
    fn clear(&mut self) {
        self.count = 0;
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.entries.iter_mut().for_each(|e| e.round = 0);
            self.round = 1;
        }
    }

    /// Where `key` is or would go.
    fn place(&self, key: [i32; D]) -> usize {
        let mask = self.entries.len() - 1;
        let mut hash = 0u64;
        for k in key {
            hash = (hash ^ k as u32 as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            hash ^= hash >> 29;
        }
        let mut at = hash as usize & mask;
        while self.entries[at].round == self.round && self.entries[at].key != key {
            at = (at + 1) & mask;
        }
        at
    }

    fn find(&self, key: [i32; D]) -> Option<u32> {
        let e = &self.entries[self.place(key)];
        (e.round == self.round).then_some(e.slot)
    }

    /// Slot of `key`, and whether it is new.
    fn slot(&mut self, key: [i32; D]) -> (u32, bool) {
        let at = self.place(key);
        if self.entries[at].round == self.round {
            return (self.entries[at].slot, false);
        }
        let slot = self.count;
        self.entries[at] = Entry { key, slot, round: self.round };
        self.count += 1;
        if 2 * self.count as usize > self.entries.len() {
            self.grow();
        }
        (slot, true)
    }

    fn grow(&mut self) {
        let empty = Entry { key: [0; D], slot: 0, round: 0 };
        let old = std::mem::take(&mut self.entries);
        self.entries = vec![empty; 2 * old.len()];
        for e in old.into_iter().filter(|e| e.round == self.round) {
            let at = self.place(e.key);
            self.entries[at] = e;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at<const D: usize>(position: [f64; D]) -> Particle<D> {
        Particle::new(position, [0.0; D], 1.0, 1.0, 0, 0)
    }

    /// Neighbouring cells share exactly the nodes that their stencils have in common.
    #[test]
    fn stencils_of_neighbours_overlap() {
        let mut grid = Grid::<2>::default();
        let particles: Vec<_> =
            (-9..9).flat_map(|i| (-9..9).map(move |j| at([i as f64 + 0.5, j as f64 + 0.5]))).collect();
        let mut slots = Vec::new();
        grid.lay_out(&particles, 1.0, &[false; 2], false, &mut slots).unwrap();
        for i in 0..17 {
            for j in 0..17 {
                let (a, right) = (grid.stencil(slots[i * 18 + j]), grid.stencil(slots[i * 18 + j + 1]));
                let below = grid.stencil(slots[(i + 1) * 18 + j]);
                for k in 0..4 {
                    for l in 0..3 {
                        assert_eq!(a[k * 4 + l + 1], right[k * 4 + l]);
                        assert_eq!(a[(l + 1) * 4 + k], below[l * 4 + k]);
                    }
                }
            }
        }
    }

    #[test]
    fn images_lie_behind_the_mirror() {
        let mut grid = Grid::<3>::default();
        let mut slots = Vec::new();
        grid.lay_out(&[at([0.5, 0.5, 0.5])], 1.0, &[false, true, true], false, &mut slots).unwrap();
        let nodes = grid.stencil(slots[0]);
        let number = |i: usize, j: usize, k: usize| nodes[i * 16 + j * 4 + k];
        for i in 0..4 {
            for k in 0..4 {
                assert!(grid.images[1].contains(&(number(i, 2, k), number(i, 0, k))));
                assert!(grid.images[2].contains(&(number(i, k, 2), number(i, k, 0))));
                assert!(grid.on_plane[1].contains(&number(i, 1, k)));
            }
        }
        assert!(grid.images[0].is_empty());
    }

    #[test]
    fn a_runaway_is_named() {
        let mut grid = Grid::<1>::default();
        let lost = grid.lay_out(&[at([0.0]), at([f64::NAN])], 1.0, &[false], false, &mut Vec::new()).unwrap_err();
        assert_eq!(lost.0, 1);
    }
}
