//! A sparse grid without a box: blocks of nodes that exist only where particles touch them.
//!
//! Each step it is laid out anew in the order of the blocks of particles, so its numbers depend on the particles alone. The grid
//! keeps sums over particles; `window.rs` has what a block's particles need of it. Blocks of one colour share no node: they may
//! add to the grid at the same time, and each node is added to in the order of the colours.
use crate::kernel::edge;
use crate::store::{SECOND, Store};
use crate::table::Table;
use crate::task::Crew;

/// Numbers at a node: mass [kg] and momentum [kg m/s], or force [N] after a place left free, or others in passes of their own.
pub type Node = [f64; 4];

/// The nodes that particles touch.
#[derive(Default)]
pub struct Grid<const D: usize> {
    /// Mass and momentum; once these are whole, mass and velocity.
    pub start: Vec<Node>,
    /// Force, then its change of velocity; and other sums that live shorter.
    pub force: Vec<Node>,
    /// Sums for heat conduction, by material: mass, mass times heat, mass times share.
    pub heat: Vec<Vec<Node>>,
    /// Nodes on a mirror plane, by axis.
    on_plane: [Vec<u32>; 3],
    /// Nodes next to a mirror plane and their images behind it, by axis.
    pub images: [Vec<(u32, u32)>; 3],
    blocks: Vec<[i32; D]>,
    homes: Table<D>,
}

/// Nodes of a block.
pub const fn block<const D: usize>() -> usize {
    edge::<D>().pow(D as u32)
}

impl<const D: usize> Grid<D> {
    /// Lays out zero nodes under all windows of `store`: `materials` fields of heat beside the others.
    pub fn lay_out(&mut self, store: &mut Store<D>, mirrors: &[bool; D], materials: usize) {
        self.homes.clear();
        self.blocks.clear();
        for site in store.sites.iter_mut().flatten() {
            for corner in 0..1usize << D {
                let needed = (0..D).all(|d| corner >> d & 1 == 0 || site.touched[d + 3 - D][1] as usize > edge::<D>());
                if needed {
                    let mut key = site.key;
                    (0..D).for_each(|d| key[d] += (corner >> d & 1) as i32);
                    let (home, new) = self.homes.slot(key);
                    if new {
                        self.blocks.push(key);
                    }
                    site.homes[corner] = home;
                }
            }
        }
        let count = self.blocks.len() * const { block::<D>() };
        self.heat.resize(materials, Vec::new());
        clear(&mut self.start, count);
        clear(&mut self.force, count);
        self.find_mirrors(mirrors);
    }

    /// Makes the sums of heat conduction zero.
    pub fn clear_heat(&mut self) {
        let count = self.blocks.len() * const { block::<D>() };
        self.heat.iter_mut().for_each(|field| clear(field, count));
    }

    /// Nodes next to a mirror reach behind it to one layer, whose partners in front are on the same windows.
    fn find_mirrors(&mut self, mirrors: &[bool; D]) {
        let (n, edge) = const { (block::<D>() as u32, edge::<D>() as u32) };
        for d in 0..D {
            self.on_plane[d].clear();
            self.images[d].clear();
            if !mirrors[d] {
                continue;
            }
            let stride = edge.pow((D - 1 - d) as u32);
            let along = |node: u32| node / stride % edge;
            for (b, key) in self.blocks.iter().enumerate() {
                let start = b as u32 * n;
                if key[d] == 0 {
                    self.on_plane[d].extend((0..n).filter(|&k| along(k) == 0).map(|k| start + k));
                } else if key[d] == -1 {
                    let mut front = *key;
                    front[d] = 0;
                    let Some(front) = self.homes.find(front) else { continue };
                    let last = (0..n).filter(|&k| along(k) == edge - 1);
                    self.images[d].extend(last.map(|k| (front * n + k - (edge - 2) * stride, start + k)));
                }
            }
        }
    }

    /// Adds what the mirrored half of the scene gives the nodes of `field` near each mirror plane, and copies the sum behind
    /// it. A vector's component along the mirror's normal is turned round.
    fn fold(&self, field: &mut [Node], is_vector: bool) {
        let turned = |node: Node, d: usize| if is_vector { turned(node, d) } else { node };
        for d in 0..D {
            for &n in &self.on_plane[d] {
                let node = field[n as usize];
                let image = turned(node, d);
                field[n as usize] = std::array::from_fn(|c| node[c] + image[c]);
            }
            for &(front, behind) in &self.images[d] {
                let image = turned(field[behind as usize], d);
                let node = &mut field[front as usize];
                (0..4).for_each(|c| node[c] += image[c]);
            }
        }
        for d in 0..D {
            for &(front, behind) in &self.images[d] {
                field[behind as usize] = turned(field[front as usize], d);
            }
        }
    }

    /// Copies mass and velocity behind each mirror plane.
    pub fn reflect_start(&mut self) {
        reflect(&self.images, &mut self.start);
    }

    /// Copies forces behind each mirror plane.
    pub fn reflect_force(&mut self) {
        reflect(&self.images, &mut self.force);
    }

    /// Mirrors mass and momentum.
    pub fn fold_start(&mut self) {
        let mut field = std::mem::take(&mut self.start);
        self.fold(&mut field, true);
        self.start = field;
    }

    /// Makes momenta velocities; nodes of no more than `cut` [kg] stand still.
    pub fn find_velocities(&mut self, cut: f64, crew: &mut Crew, threads: usize) {
        let count = self.blocks.len() * const { block::<D>() };
        crew.nodes(threads, &mut self.start[..count], |_, piece| {
            for node in piece {
                let [mass, x, y, z] = *node;
                let per_mass = if mass > cut { 1.0 / mass } else { 0.0 };
                *node = [mass, x * per_mass, y * per_mass, z * per_mass];
            }
        });
    }

    /// Makes forces changes of velocity in a step of `dt` [s]; nodes of no more than `cut` [kg] stand still.
    pub fn find_changes(&mut self, cut: f64, dt: f64, crew: &mut Crew, threads: usize) {
        let count = self.blocks.len() * const { block::<D>() };
        let Grid { start, force, .. } = self;
        crew.nodes(threads, &mut force[..count], |first, piece| {
            for (force, start) in piece.iter_mut().zip(&start[first..]) {
                let kick = if start[0] > cut { dt / start[0] } else { 0.0 };
                let [a, x, y, z] = *force;
                *force = [a * kick, x * kick, y * kick, z * kick];
            }
        });
    }

    /// Mirrors forces, or what else is there.
    pub fn fold_force(&mut self) {
        let mut field = std::mem::take(&mut self.force);
        self.fold(&mut field, true);
        self.force = field;
    }

    /// Mirrors the sums of heat conduction.
    pub fn fold_heat(&mut self) {
        let mut fields = std::mem::take(&mut self.heat);
        fields.iter_mut().for_each(|field| self.fold(field, false));
        self.heat = fields;
    }

    /// Nodes at the same place of the two fields, where bodies have fields of their own.
    pub fn shared(&self) -> Vec<(u32, u32)> {
        let n = const { block::<D>() as u32 };
        let mut pairs = Vec::new();
        for (b, key) in self.blocks.iter().enumerate().filter(|(_, key)| key[0] > SECOND >> 1) {
            let mut first = *key;
            first[0] -= SECOND;
            if let Some(a) = self.homes.find(first) {
                pairs.extend((0..n).map(|k| (a * n + k, b as u32 * n + k)));
            }
        }
        pairs
    }

    /// Number of node blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }
}

/// Makes the first `count` nodes of a field zero; it never shrinks.
fn clear(field: &mut Vec<Node>, count: usize) {
    field.resize(count.max(field.len()), [0.0; 4]);
    field[..count].as_flattened_mut().fill(0.0);
}

/// The image of a vector in a mirror across axis `d`.
fn turned(mut node: Node, d: usize) -> Node {
    node[d + 1] = -node[d + 1];
    node
}

fn reflect(images: &[Vec<(u32, u32)>; 3], field: &mut [Node]) {
    for (d, pairs) in images.iter().enumerate() {
        for &(front, behind) in pairs {
            field[behind as usize] = turned(field[front as usize], d);
        }
    }
}
