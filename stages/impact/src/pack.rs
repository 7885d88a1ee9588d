//! Eight particles side by side.
use crate::particle::{Matter, Particle};
use hvi_kit::lanes::{Eight, Quads, prefetch};

/// How many packs ahead of its work a pass asks for what it will need, with `nodes` an axis: fewer where a pack takes longer.
pub const fn ahead(nodes: usize) -> usize {
    if nodes > 2 { 1 } else { 3 }
}

/// Eight particles of one body: each quantity of all eight lies together. The last pack of a group may hold fewer; its other lanes
/// keep old particles, so that their arithmetic is as tame, and nobody reads them.
#[derive(Clone)]
#[repr(align(64))]
pub struct Pack<const D: usize> {
    /// Positions [m].
    pub position: [[f64; 8]; D],
    /// Velocities [m/s].
    pub velocity: [[f64; 8]; D],
    /// Affine parts of the velocity [1/s], `[component][axis]`.
    pub affine: [[[f64; 8]; D]; D],
    /// Their matter.
    pub matter: Matter<[f64; 8]>,
    /// Within a step: pressure at its middle, without viscosity [Pa].
    pub half_pressure: [f64; 8],
    /// Within a step: deviator at its middle [Pa].
    pub half_deviator: [[f64; 8]; 6],
    /// Within a step: energy that the transfer to the grid took out of motion [J].
    pub heat: [f64; 8],
    /// 1 where no other particle shared a node, else 0.
    pub alone: [f64; 8],
    /// Numbers at the start.
    pub id: [u32; 8],
    /// A bit for each that has left the block in its last step.
    pub left: u8,
}

impl<const D: usize> Pack<D> {
    /// Eight copies of one.
    pub fn filled(p: &Particle<D>) -> Self {
        Pack {
            position: p.position.map(|x| [x; 8]),
            velocity: p.velocity.map(|x| [x; 8]),
            affine: p.affine.map(|row| row.map(|x| [x; 8])),
            matter: Matter::filled(&p.matter),
            half_pressure: [0.0; 8],
            half_deviator: [[0.0; 8]; 6],
            heat: [0.0; 8],
            alone: [p.alone as u8 as f64; 8],
            id: [p.id; 8],
            left: 0,
        }
    }

    /// Particle `lane`, of `body`. (Plain loops here and in `set`: closures over arrays are not inlined.)
    #[inline(always)]
    pub fn get(&self, lane: usize, body: u8) -> Particle<D> {
        // No other lane: so that no index needs a look.
        let lane = lane & 7;
        let (mut position, mut velocity, mut affine) = ([0.0; D], [0.0; D], [[0.0; D]; D]);
        for c in 0..D {
            position[c] = self.position[c][lane];
            velocity[c] = self.velocity[c][lane];
            for d in 0..D {
                affine[c][d] = self.affine[c][d][lane];
            }
        }
        let (matter, alone) = (self.matter.get(lane), self.alone[lane] != 0.0);
        Particle { position, velocity, affine, matter, id: self.id[lane], body, alone }
    }

    /// Makes `p` particle `lane`; what lives within a step is left.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, p: &Particle<D>) {
        let lane = lane & 7;
        for c in 0..D {
            self.position[c][lane] = p.position[c];
            self.velocity[c][lane] = p.velocity[c];
            for d in 0..D {
                self.affine[c][d][lane] = p.affine[c][d];
            }
        }
        self.matter.set(lane, &p.matter);
        self.alone[lane] = p.alone as u8 as f64;
        self.id[lane] = p.id;
    }

    /// Has what heat conduction needs brought to the processor's first cache.
    #[inline(always)]
    pub fn prefetch_heat(&self) {
        let m = &self.matter;
        prefetch(&self.position);
        for row in [&m.mass, &m.ratio, &m.energy, &m.damage, &m.unclamped, &m.divergence, &m.sound_speed] {
            prefetch(row);
        }
    }

    /// Masses and momenta, a quad a particle, as a node has them.
    #[inline(always)]
    pub fn momenta<R: Eight>(&self, to: &mut Quads) {
        let mass = R::load(&self.matter.mass);
        let mut columns = [mass, R::of(0.0), R::of(0.0), R::of(0.0)];
        for c in 0..D {
            columns[c + 1] = R::load(&self.velocity[c]) * mass;
        }
        R::transposed(columns, to);
    }

    /// Columns of the affine parts times the masses, by level.
    #[inline(always)]
    pub fn affine_momenta<R: Eight>(&self, to: &mut [Quads; 3]) {
        let mass = R::load(&self.matter.mass);
        for d in 0..D {
            let mut columns = [R::of(0.0); 4];
            for c in 0..D {
                columns[c + 1] = R::load(&self.affine[c][d]) * mass;
            }
            R::transposed(columns, &mut to[d + 3 - D]);
        }
    }
}
