//! The atoms: positions, velocities and forces in a periodic box, and their motion by velocity Verlet.
mod snapshot;
pub use snapshot::Snapshot;

use crate::fault::Fault;
use crate::force::{Forces, Kept, Sums};
use crate::lanes::{Isa, Kernel, Lanes, run};
use crate::neighbor::{Build, Cells, List, NOWHERE};
use crate::random::Random;
use crate::table::Tables;
use crate::thermostat::Chain;
use crate::units::{ATOMIC_MASS, BOLTZMANN};
use hvi_kit::view::Frame;

/// Widest skin [angstrom]: wider lists are rebuilt more rarely but hold more pairs; see `benches/speed.rs`.
const SKIN: f64 = 0.8;
/// Narrowest skin worth having [angstrom].
pub const LEAST_SKIN: f64 = 0.15;

/// Atoms of one kind in a periodic box. Units: angstrom, eV, ps. Atoms are re-sorted as they move; `id` tells which is which.
pub struct System {
    tables: Tables,
    isa: Isa,
    edges: [f64; 3],
    skin: f64,
    /// Edges when the list was built.
    listed_edges: [f64; 3],
    mass: f64,
    /// x, y, z and F', with the atom that stands nowhere: `[atoms + 1]`.
    position: Vec<[f64; 4]>,
    velocity: Vec<[f64; 4]>,
    /// `[atoms + 1]`
    force: Vec<[f64; 4]>,
    /// Where each atom started; moves by whole edges with its atom.
    site: Vec<[f64; 4]>,
    /// Positions when the list was built.
    listed: Vec<[f64; 4]>,
    id: Vec<u32>,
    list: List,
    density: Vec<f64>,
    kept: Kept,
    sums: Sums,
    /// By axis.
    twice_kinetic: [f64; 3],
    /// By axis, in the middle of the last step.
    middle_kinetic: [f64; 3],
    site_virial: f64,
    step: u64,
    time: f64,
    rebuilds: u64,
}

impl System {
    /// Atoms at rest at `sites` [angstrom] in a cube of edge `edge` [angstrom].
    ///
    /// # Errors
    /// [`Fault`] where the box is too small for the potential, or the sites are off the potential's tables.
    pub fn new(tables: Tables, isa: Isa, sites: &[[f64; 3]], edge: f64) -> Result<System, Fault> {
        System::in_box(tables, isa, sites, [edge; 3])
    }

    /// Atoms at rest at `sites` [angstrom] in a box of edges `edges` [angstrom].
    ///
    /// # Errors
    /// As [`System::new`].
    pub fn in_box(tables: Tables, isa: Isa, sites: &[[f64; 3]], edges: [f64; 3]) -> Result<System, Fault> {
        let n = sites.len();
        let mut position: Vec<[f64; 4]> = sites.iter().map(|s| [s[0], s[1], s[2], 0.0]).collect();
        position.push(NOWHERE);
        let mut system = System {
            mass: System::mass_of(&tables),
            tables,
            isa,
            edges,
            listed_edges: edges,
            skin: 0.0,
            site: position[..n].to_vec(),
            listed: Vec::new(),
            position,
            velocity: vec![[0.0; 4]; n],
            force: vec![[0.0; 4]; n + 1],
            id: (0..n as u32).collect(),
            list: List::default(),
            density: vec![0.0; n + 1],
            kept: Kept::default(),
            sums: Sums::default(),
            twice_kinetic: [0.0; 3],
            middle_kinetic: [0.0; 3],
            site_virial: 0.0,
            step: 0,
            time: 0.0,
            rebuilds: 0,
        };
        system.rebuild()?;
        system.act()?;
        Ok(system)
    }

    /// Mass of an atom [eV ps2/angstrom2].
    fn mass_of(tables: &Tables) -> f64 {
        tables.potential.molar_mass() * ATOMIC_MASS
    }

    /// Number of atoms.
    pub fn atoms(&self) -> usize {
        self.velocity.len()
    }
    /// Degrees of freedom: the centre of mass is at rest.
    pub fn freedom(&self) -> f64 {
        3.0 * (self.atoms() as f64 - 1.0)
    }
    /// Volume [angstrom3].
    pub fn volume(&self) -> f64 {
        self.edges[0] * self.edges[1] * self.edges[2]
    }
    /// Edges of the box [angstrom].
    pub fn edges(&self) -> [f64; 3] {
        self.edges
    }
    /// Potential energy [eV].
    pub fn energy(&self) -> f64 {
        self.sums.energy
    }
    /// Sum of r.F over pairs [eV]: three volumes times the pressure at rest.
    pub fn virial(&self) -> f64 {
        sum(self.sums.virial)
    }
    /// Sum of r F over pairs, by axis [eV]: the volume times each pressure at rest.
    pub fn virials(&self) -> [f64; 3] {
        self.sums.virial
    }
    /// Twice the kinetic energy [eV], at the end of the step.
    pub fn twice_kinetic(&self) -> f64 {
        sum(self.twice_kinetic)
    }
    /// Twice the kinetic energy by axis [eV], at the end of the step.
    pub fn twice_kinetics(&self) -> [f64; 3] {
        self.twice_kinetic
    }
    /// Twice the kinetic energy in the middle of the step that is under way [eV].
    pub(crate) fn middle_kinetic(&self) -> f64 {
        sum(self.middle_kinetic)
    }
    /// Temperature of the motion in the middle of the last step [K]: its mean is exactly that of the heat bath.
    pub fn temperature(&self) -> f64 {
        self.middle_kinetic() / (self.freedom() * BOLTZMANN)
    }
    /// Sum of F.(x - site) [eV]; its mean is -3(N-1) k_B T in a crystal.
    pub fn site_virial(&self) -> f64 {
        self.site_virial
    }
    /// Time since the start [ps].
    pub fn time(&self) -> f64 {
        self.time
    }
    /// Steps since the start.
    pub fn steps(&self) -> u64 {
        self.step
    }
    /// How often the neighbour list was built.
    pub fn rebuilds(&self) -> u64 {
        self.rebuilds
    }
    /// Forces [eV/angstrom] in the order of the sites: `[atoms][3]`.
    pub fn forces(&self) -> Vec<[f64; 3]> {
        self.in_order(&self.force)
    }
    /// Velocities [angstrom/ps] in the order of the sites: `[atoms][3]`.
    pub fn velocities(&self) -> Vec<[f64; 3]> {
        self.in_order(&self.velocity)
    }
    /// Way of each atom from its site [angstrom], in the order of the sites: `[atoms][3]`.
    pub fn displacements(&self) -> Vec<[f64; 3]> {
        let way: Vec<[f64; 4]> =
            self.site.iter().zip(&self.position).map(|(s, p)| [p[0] - s[0], p[1] - s[1], p[2] - s[2], 0.0]).collect();
        self.in_order(&way)
    }
    /// Where all atoms are, folded into the box, and how they move, in the order of the sites.
    pub fn frame(&self) -> Frame {
        let edges = self.edges;
        let fold = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - (p[k] / edges[k]).floor() * edges[k]);
        let positions = self.in_order(&self.position).into_iter().map(fold).collect();
        Frame { time: self.time, edges, positions, velocities: self.velocities() }
    }
    fn in_order(&self, of: &[[f64; 4]]) -> Vec<[f64; 3]> {
        let mut all = vec![[0.0; 3]; self.atoms()];
        for (a, id) in of.iter().zip(&self.id) {
            all[*id as usize] = [a[0], a[1], a[2]];
        }
        all
    }
    /// Positions, each in any periodic image and in no order [angstrom].
    pub fn positions(&self) -> impl Iterator<Item = [f64; 3]> {
        self.position[..self.atoms()].iter().map(|p| [p[0], p[1], p[2]])
    }

    /// Gives each atom a velocity of the Maxwell distribution, then sets momentum to zero and the temperature exactly [K].
    pub fn heat(&mut self, temperature: f64, seed: u64) {
        let mut random = Random::new(seed);
        for v in &mut self.velocity {
            *v = [random.normal(), random.normal(), random.normal(), 0.0];
        }
        self.stop();
        self.scale(temperature);
    }

    /// Scales all velocities so that the temperature is `temperature` [K] exactly.
    pub fn scale(&mut self, temperature: f64) {
        let axis = |k: usize| self.velocity.iter().map(|v| v[k] * v[k]).sum::<f64>();
        let squares = [axis(0), axis(1), axis(2)];
        let square = self.freedom() * BOLTZMANN * temperature / (self.mass * sum(squares));
        let factor = square.sqrt();
        self.velocity.iter_mut().flatten().for_each(|v| *v *= factor);
        self.twice_kinetic = squares.map(|s| self.mass * s * square);
    }

    /// Scales the velocities of the atoms whose sites are `part` so that their temperature is `temperature` [K], and sets the
    /// momentum of all to zero again.
    pub fn scale_part(&mut self, part: impl Fn(u32) -> bool, temperature: f64) {
        let chosen = || self.velocity.iter().zip(&self.id).filter(|(_, id)| part(**id));
        let squares: f64 = chosen().map(|(v, _)| v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sum();
        let thermal = 3.0 * chosen().count() as f64 * BOLTZMANN * temperature;
        let factor = (thermal / (self.mass * squares)).sqrt();
        for (v, _) in self.velocity.iter_mut().zip(&self.id).filter(|(_, id)| part(**id)) {
            v.iter_mut().for_each(|v| *v *= factor);
        }
        self.stop();
        let axis = |k: usize| self.mass * self.velocity.iter().map(|v| v[k] * v[k]).sum::<f64>();
        self.twice_kinetic = [axis(0), axis(1), axis(2)];
    }

    /// Sets the momentum to zero.
    fn stop(&mut self) {
        for k in 0..3 {
            let mean = self.velocity.iter().map(|v| v[k]).sum::<f64>() / self.atoms() as f64;
            self.velocity.iter_mut().for_each(|v| v[k] -= mean);
        }
    }

    /// Turns all velocities round.
    pub fn reverse(&mut self) {
        self.velocity.iter_mut().flatten().for_each(|v| *v = -*v);
    }

    /// One step over `dt` [ps]: half a kick, half a drift, the whole step of `chain` if there is one, half a drift, half a kick.
    ///
    /// Without a chain it is velocity Verlet. With the heat bath in the middle the positions of a harmonic crystal are
    /// distributed exactly, whatever the time step (Z. Zhang, X. Liu, K. Yan, M. E. Tuckerman and J. Liu, J. Phys. Chem. A
    /// 123, 6056 (2019)); with half of it at either end, as is usual, they are too hot by the square of the time step:
    /// 0.05 GPa at 2 fs in the liquid at 3567 K.
    ///
    /// # Errors
    /// [`Fault`] with step and atom where atoms come too close, too dense, or get lost.
    pub fn advance(&mut self, dt: f64, chain: Option<&mut Chain>) -> Result<(), Fault> {
        self.begin(dt);
        let factor = chain.map_or(1.0, |c| c.step(self.middle_kinetic(), dt));
        self.finish(dt, factor)
    }

    /// The first half of a step over `dt` [ps], up to where the heat bath and the walls act: half a kick, half a drift.
    pub(crate) fn begin(&mut self, dt: f64) {
        let half = 0.5 * dt / self.mass;
        let atoms = Atoms { position: &mut self.position, velocity: &mut self.velocity, force: &self.force };
        let squares = run(self.isa, KickAndDrift { atoms, half, half_step: 0.5 * dt });
        self.middle_kinetic = squares.map(|s| self.mass * s);
    }

    /// Stretches the box and all that is in it by `lengths` along each axis, and velocities by `velocities`.
    pub(crate) fn deform(&mut self, lengths: [f64; 3], velocities: [f64; 3]) {
        let n = self.atoms();
        let scale = |of: &mut [[f64; 4]], by: [f64; 3]| of.iter_mut().for_each(|x| (0..3).for_each(|k| x[k] *= by[k]));
        scale(&mut self.position[..n], lengths);
        scale(&mut self.listed, lengths);
        scale(&mut self.site, lengths);
        scale(&mut self.velocity, velocities);
        for k in 0..3 {
            self.edges[k] *= lengths[k];
            self.middle_kinetic[k] *= velocities[k] * velocities[k];
        }
    }

    /// The second half of a step over `dt` [ps]: velocities times `factor`, half a drift, new forces, half a kick.
    pub(crate) fn finish(&mut self, dt: f64, factor: f64) -> Result<(), Fault> {
        let half = 0.5 * dt / self.mass;
        let atoms = Atoms { position: &mut self.position, velocity: &mut self.velocity, force: &self.force };
        let moved2 = run(self.isa, Drift { atoms, listed: &self.listed, factor, half_step: 0.5 * dt });
        self.step += 1;
        self.time += dt;
        // a lost atom's NaN is not within
        let skin = self.skin_left();
        let within = moved2 <= 0.25 * skin * skin;
        if !within {
            self.rebuild()?;
        }
        self.act()?;
        let atoms = Atoms { position: &mut self.position, velocity: &mut self.velocity, force: &self.force };
        let (squares, site_virial) = run(self.isa, Kick { atoms, site: &self.site, half });
        self.site_virial = site_virial;
        self.twice_kinetic = squares.map(|s| self.mass * s);
        if self.twice_kinetic().is_finite() { Ok(()) } else { Err(Fault::Lost { step: self.step, time: self.time }) }
    }

    /// Forces at the present positions.
    fn act(&mut self) -> Result<(), Fault> {
        self.sums = run(
            self.isa,
            Forces {
                tables: &self.tables,
                list: &self.list,
                edges: self.edges,
                position: &mut self.position,
                force: &mut self.force,
                density: &mut self.density,
                kept: &mut self.kept,
            },
        );
        if self.sums.nearest2 < self.tables.nearest2 {
            return Err(self.too_close());
        }
        match self.sums.too_dense {
            Some(i) => Err(Fault::Dense {
                step: self.step,
                time: self.time,
                atom: self.id[i],
                density: self.density[i],
                densest: self.tables.potential.densest(),
            }),
            None => Ok(()),
        }
    }

    /// Names the first pair that is closer than the table.
    fn too_close(&self) -> Fault {
        let image = |k: usize, d: f64| d - self.edges[k] * (d / self.edges[k]).round();
        let mut found = (0, 0, f64::MAX);
        for i in 0..self.atoms() {
            for j in 0..i {
                let d2: f64 = (0..3).map(|k| image(k, self.position[i][k] - self.position[j][k])).map(|d| d * d).sum();
                if d2 < found.2 {
                    found = (self.id[i].min(self.id[j]), self.id[i].max(self.id[j]), d2);
                }
            }
        }
        Fault::Close {
            step: self.step,
            time: self.time,
            atoms: [found.0, found.1],
            distance: found.2.sqrt(),
            nearest: self.tables.potential.nearest(),
        }
    }

    /// What a shrinking box has left of the skin: pairs beyond the list were at least cut-off and skin apart.
    fn skin_left(&self) -> f64 {
        let shrunk = (0..3).map(|k| self.edges[k] / self.listed_edges[k]).fold(1.0, f64::min);
        let cutoff = self.tables.potential.cutoff();
        (shrunk * (cutoff + self.skin) - cutoff).max(0.0)
    }

    /// Brings all atoms into the box, sorts them by cells and lists neighbours.
    fn rebuild(&mut self) -> Result<(), Fault> {
        let (n, cutoff) = (self.atoms(), self.tables.potential.cutoff());
        let edge = self.edges.into_iter().fold(f64::MAX, f64::min);
        self.skin = SKIN.min(0.5 * edge - cutoff);
        let wide_enough = self.skin >= LEAST_SKIN;
        if !wide_enough {
            return Err(Fault::Small { edge, needed: 2.0 * (cutoff + LEAST_SKIN) });
        }
        self.listed_edges = self.edges;
        let reach = cutoff + self.skin;
        for i in 0..n {
            for k in 0..3 {
                let out = (self.position[i][k] / self.edges[k]).floor() * self.edges[k];
                self.position[i][k] -= out;
                self.site[i][k] -= out;
            }
        }
        let cells = Cells::sort(&self.position[..n], self.edges, reach);
        fn sorted<T: Copy>(order: &[u32], a: &[T]) -> Vec<T> {
            order.iter().map(|&i| a[i as usize]).collect()
        }
        self.position = sorted(&cells.order, &self.position);
        self.listed.clone_from(&self.position);
        self.position.push(NOWHERE);
        self.velocity = sorted(&cells.order, &self.velocity);
        self.site = sorted(&cells.order, &self.site);
        self.id = sorted(&cells.order, &self.id);
        let squares = [self.tables.cutoff2, reach * reach];
        let (list, position) = (&mut self.list, &self.position);
        run(self.isa, Build { list, position, cells: &cells, edges: self.edges, squares });
        self.kept.fit(&self.list);
        self.rebuilds += 1;
        Ok(())
    }
}

/// Sum over the axes.
fn sum([x, y, z]: [f64; 3]) -> f64 {
    (x + y) + z
}

/// What the integrator moves.
struct Atoms<'a> {
    position: &'a mut [[f64; 4]],
    velocity: &'a mut [[f64; 4]],
    force: &'a [[f64; 4]],
}

/// `v += half F; x += half_step v`; returns the sum of v^2 by axis.
struct KickAndDrift<'a> {
    atoms: Atoms<'a>,
    half: f64,
    half_step: f64,
}
impl Kernel for KickAndDrift<'_> {
    type Out = [f64; 3];
    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> [f64; 3] {
        let Atoms { position, velocity, force } = self.atoms;
        let mut squares = [0.0; 4];
        for ((x, v), f) in position.iter_mut().zip(velocity).zip(force) {
            for k in 0..4 {
                v[k] += self.half * f[k];
                x[k] += self.half_step * v[k];
                squares[k] += v[k] * v[k];
            }
        }
        [squares[0], squares[1], squares[2]]
    }
}

/// `v *= factor; x += half_step v`; returns the greatest square of the way since the list was built.
struct Drift<'a> {
    atoms: Atoms<'a>,
    listed: &'a [[f64; 4]],
    factor: f64,
    half_step: f64,
}
impl Kernel for Drift<'_> {
    type Out = f64;
    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> f64 {
        let Atoms { position, velocity, .. } = self.atoms;
        let mut most: f64 = 0.0;
        for ((x, v), x0) in position.iter_mut().zip(velocity).zip(self.listed) {
            let mut way = [0.0; 4];
            for k in 0..4 {
                v[k] *= self.factor;
                x[k] += self.half_step * v[k];
                way[k] = x[k] - x0[k];
                way[k] *= way[k];
            }
            let square = (way[0] + way[1]) + way[2];
            // not f64::max: a lost atom must not go unseen
            most = if square <= most { most } else { square };
        }
        most
    }
}

/// `v += half F`; returns the sum of v^2 by axis and that of F.(x - site).
struct Kick<'a> {
    atoms: Atoms<'a>,
    site: &'a [[f64; 4]],
    half: f64,
}
impl Kernel for Kick<'_> {
    type Out = ([f64; 3], f64);
    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> ([f64; 3], f64) {
        let Atoms { position, velocity, force } = self.atoms;
        let (mut squares, mut pull) = ([0.0; 4], [0.0; 4]);
        for (((x, v), f), s) in position.iter().zip(velocity).zip(force).zip(self.site) {
            for k in 0..4 {
                v[k] += self.half * f[k];
                squares[k] += v[k] * v[k];
                pull[k] += f[k] * (x[k] - s[k]);
            }
        }
        ([squares[0], squares[1], squares[2]], (pull[0] + pull[1]) + pull[2])
    }
}
