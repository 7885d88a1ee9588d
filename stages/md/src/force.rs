//! Energy, forces and virial of the embedded-atom model, over half neighbour lists in two passes.
//!
//! Pass one sums densities and pair energies and keeps phi'/r and f'/r; then each atom is embedded; pass two makes the
//! forces `-(phi' + (F'_i + F'_j) f') r/|r|` from what was kept. In large boxes the passes go up through layers of cells, pass two
//! as close behind pass one as the list allows, so that what is kept (500 bytes an atom) doesn't leave the cache.
use crate::lanes::{Kernel, Lanes};
use crate::neighbor::List;
use crate::table::{Over, Tables};

/// Energies and forces to be computed. `[atoms + 1]` where the atom past the last is the one that stands nowhere.
pub struct Forces<'a> {
    /// The potential.
    pub tables: &'a Tables,
    /// Which pairs to look at.
    pub list: &'a List,
    /// Edges of the periodic box [angstrom].
    pub edges: [f64; 3],
    /// x, y, z [angstrom] and, on return, F' [eV]: `[atoms + 1]`.
    pub position: &'a mut [[f64; 4]],
    /// Forces [eV/angstrom], last component 0: `[atoms + 1]`.
    pub force: &'a mut [[f64; 4]],
    /// Density sums: `[atoms + 1]`.
    pub density: &'a mut [f64],
    /// Room for phi'/r and f'/r.
    pub kept: &'a mut Kept,
}

/// What pass two needs of pass one, of the layers between them.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// Vectors that a layer may have.
    room: usize,
    /// phi'/r and f'/r of the vectors with any pair within the cut-off, without gaps: `[slots * room]`.
    slopes: Vec<[[f64; 8]; 2]>,
    /// Whether any pair of a vector is within the cut-off: `[slots * room]`.
    active: Vec<bool>,
}

impl Kept {
    /// Makes room for what passes over `list` keep.
    pub fn fit(&mut self, list: &List) {
        self.room = (0..list.layers()).map(|k| list.vectors_of(list.layer(k)).len()).max().unwrap_or(0);
        let slots = list.layers().min(2 * list.lag() + 1);
        self.slopes.resize(slots * self.room, [[0.0; 8]; 2]);
        self.active.resize(slots * self.room, false);
    }

    /// The part for `layer`: layers below `lag` wait for the end, the others follow each other.
    #[inline(always)]
    fn slot(&mut self, layer: usize, lag: usize) -> (&mut [[[f64; 8]; 2]], &mut [bool]) {
        let slot = if layer < lag { layer } else { lag + layer % (lag + 1) };
        let all = slot * self.room..(slot + 1) * self.room;
        (&mut self.slopes[all.clone()], &mut self.active[all])
    }
}

/// What [`Forces`] sums up.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Potential energy [eV].
    pub energy: f64,
    /// Sum of r F over pairs, by axis [eV].
    pub virial: [f64; 3],
    /// Least distance squared of any pair [angstrom2], 1e300 where there is none.
    pub nearest2: f64,
    /// First atom whose density is off the table.
    pub too_dense: Option<usize>,
}

impl Kernel for Forces<'_> {
    type Out = Sums;
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Sums {
        match self.tables.over {
            Over::Square => self.passes::<L, false>(l),
            Over::Distance => self.passes::<L, true>(l),
        }
    }
}

/// Sums over pairs that are under way.
struct Under<L: Lanes> {
    energy: L::F,
    nearest2: L::F,
    virial: [L::F; 3],
}

/// Nearest image of `at - other`, by component; `wraps` is false where that is `at - other` itself, which has the same bits.
#[inline(always)]
fn apart<L: Lanes>(l: L, at: [L::F; 3], other: [L::F; 4], periodic: [[L::F; 2]; 3], wraps: bool) -> [L::F; 3] {
    let (x, y, z) = (l.sub(at[0], other[0]), l.sub(at[1], other[1]), l.sub(at[2], other[2]));
    if !wraps {
        return [x, y, z];
    }
    let [[a, per_a], [b, per_b], [c, per_c]] = periodic;
    let x = l.fnma(l.round(l.mul(x, per_a)), a, x);
    let y = l.fnma(l.round(l.mul(y, per_b)), b, y);
    [x, y, l.fnma(l.round(l.mul(z, per_c)), c, z)]
}

/// Edges of the box and what is 1 over them, for [`apart`].
#[inline(always)]
fn periodic<L: Lanes>(l: L, edges: [f64; 3]) -> [[L::F; 2]; 3] {
    let [a, b, c] = edges;
    [[l.splat(a), l.splat(1.0 / a)], [l.splat(b), l.splat(1.0 / b)], [l.splat(c), l.splat(1.0 / c)]]
}

/// phi, phi'/r, f, f'/r of eight distances squared, none of which is past the table's end.
#[inline(always)]
fn look_up<L: Lanes, const ROOT: bool>(l: L, tables: &Tables, r2: L::F) -> [L::F; 4] {
    let (zero, scale) = (l.splat(0.0), l.splat(tables.scale));
    let (r, per_r) = if ROOT {
        let r = l.sqrt(r2);
        (r, l.div(l.splat(1.0), r))
    } else {
        (zero, zero)
    };
    let u = if ROOT { l.mul(r, scale) } else { l.max(l.mul(l.sub(r2, l.splat(tables.start)), scale), zero) };
    let line = l.floor(u);
    let t = l.sub(u, line);
    let c = l.gather_lines(&tables.pair, line);
    let (t2, t3) = (l.add(t, t), l.mul(t, l.splat(3.0)));
    let p = l.fma(l.fma(l.fma(c[3], t, c[2]), t, c[1]), t, c[0]);
    let f = l.fma(l.fma(l.fma(c[7], t, c[6]), t, c[5]), t, c[4]);
    let p_slope = l.fma(l.mul(c[3], t3), t, l.fma(c[2], t2, c[1]));
    let f_slope = l.fma(l.mul(c[7], t3), t, l.fma(c[6], t2, c[5]));
    if ROOT {
        // p is r phi
        let (phi, k) = (l.mul(p, per_r), l.mul(per_r, scale));
        let phi_slope = l.mul(l.mul(l.fma(p_slope, scale, l.sub(zero, phi)), per_r), per_r);
        return [phi, phi_slope, f, l.mul(f_slope, k)];
    }
    // d/dr2 is half of (1/r) d/dr
    let double = l.add(scale, scale);
    [p, l.mul(p_slope, double), f, l.mul(f_slope, double)]
}

impl Forces<'_> {
    /// Both passes, layer by layer.
    ///
    /// Rows of a layer name atoms of it and of `lag` layers below, round the box: a density is complete `lag` layers later,
    /// and pass two needs complete densities. The lowest layers' neighbours are at the top: they come last.
    #[inline(always)]
    fn passes<L: Lanes, const ROOT: bool>(mut self, l: L) -> Sums {
        self.density.fill(0.0);
        let (layers, lag) = (self.list.layers(), self.list.lag());
        let zero = l.splat(0.0);
        let mut under = Under { energy: zero, nearest2: l.splat(1e300), virial: [zero; 3] };
        let mut sums = Sums::default();
        let (mut embedded, mut finished) = (0, lag);
        for layer in 0..layers {
            self.densities::<L, ROOT>(l, layer, &mut under);
            let last = layer + 1 == layers;
            let complete = if last { layers } else { (layer + 1).saturating_sub(lag) };
            while embedded < complete {
                self.embed(embedded, &mut sums);
                embedded += 1;
            }
            // pass two of a layer needs what is `lag` below to be complete, and that is all that it needs
            while finished < if last { layers + lag } else { complete } {
                self.forces(l, finished % layers, &mut under);
                finished += 1;
            }
        }
        let mut least = [0.0; 8];
        l.store(under.nearest2, &mut least);
        sums.nearest2 = least.into_iter().fold(1e300, |a, b| if b < a { b } else { a });
        sums.energy += l.sum(under.energy);
        sums.virial = under.virial.map(|v| l.sum(v));
        sums
    }

    /// Pass one over a layer: density sums, pair energy and the least distance squared.
    #[inline(always)]
    fn densities<L: Lanes, const ROOT: bool>(&mut self, l: L, layer: usize, under: &mut Under<L>) {
        let periodic = periodic(l, self.edges);
        let (cutoff2, beyond) = (l.splat(self.tables.cutoff2), l.splat(self.tables.beyond));
        let (mut energy, mut nearest2) = (under.energy, under.nearest2);
        let rows = self.list.layer(layer);
        let (slopes, active) = self.kept.slot(layer, self.list.lag());
        let (mut slopes, mut active) = (slopes.iter_mut(), active.iter_mut());
        for i in rows {
            self.force[i] = [0.0; 4];
            let [x, y, z, _] = self.position[i];
            let at = [l.splat(x), l.splat(y), l.splat(z)];
            let mut sum = l.splat(0.0);
            let (row, wraps) = (self.list.row(i), self.list.wraps[i]);
            // the row ends first, and asks for no more than it has
            for (neighbours, active) in self.list.vectors[row].iter().zip(&mut active) {
                let [x, y, z] = apart(l, at, l.gather(self.position, neighbours), periodic, wraps);
                let r2 = l.fma(z, z, l.fma(y, y, l.mul(x, x)));
                *active = l.less(r2, cutoff2) != 0;
                if !*active {
                    continue;
                }
                nearest2 = l.min(r2, nearest2);
                let [phi, phi_slope, f, f_slope] = look_up::<L, ROOT>(l, self.tables, l.below(r2, cutoff2, beyond));
                if let Some(kept) = slopes.next() {
                    l.store(phi_slope, &mut kept[0]);
                    l.store(f_slope, &mut kept[1]);
                }
                energy = l.add(energy, phi);
                sum = l.add(sum, f);
                l.scatter_add(self.density, neighbours, f);
            }
            self.density[i] += l.sum(sum);
        }
        (under.energy, under.nearest2) = (energy, nearest2);
    }

    /// Puts F' of each atom of a layer beside its position; adds up the embedding energy and finds the first atom off the table.
    #[inline(always)]
    fn embed(&mut self, layer: usize, sums: &mut Sums) {
        for i in self.list.layer(layer) {
            match self.tables.embedding(self.density[i]) {
                Some(jet) => {
                    sums.energy += jet.value;
                    self.position[i][3] = jet.slope;
                }
                None => sums.too_dense = sums.too_dense.or(Some(i)),
            }
        }
    }

    /// Pass two over a layer: forces, and the virial by axis.
    #[inline(always)]
    fn forces<L: Lanes>(&mut self, l: L, layer: usize, under: &mut Under<L>) {
        let periodic = periodic(l, self.edges);
        let (zero, mut virial) = (l.splat(0.0), under.virial);
        let (slopes, active) = self.kept.slot(layer, self.list.lag());
        let (mut slopes, mut active) = (slopes.iter(), active.iter());
        for i in self.list.layer(layer) {
            let [x, y, z, slope] = self.position[i];
            let at = [l.splat(x), l.splat(y), l.splat(z)];
            let slope = l.splat(slope);
            let mut sum = [zero; 3];
            let (row, wraps) = (self.list.row(i), self.list.wraps[i]);
            for (neighbours, active) in self.list.vectors[row].iter().zip(&mut active) {
                if !active {
                    continue;
                }
                let Some(kept) = slopes.next() else { break };
                let other = l.gather(self.position, neighbours);
                let d = apart(l, at, other, periodic, wraps);
                let (phi_slope, f_slope) = (l.load(&kept[0]), l.load(&kept[1]));
                // what was looked up past the cut-off is exactly 0, and so are these
                let pull = l.sub(zero, l.fma(l.add(slope, other[3]), f_slope, phi_slope));
                let f = [l.mul(pull, d[0]), l.mul(pull, d[1]), l.mul(pull, d[2])];
                virial = [l.fma(f[0], d[0], virial[0]), l.fma(f[1], d[1], virial[1]), l.fma(f[2], d[2], virial[2])];
                sum = [l.add(sum[0], f[0]), l.add(sum[1], f[1]), l.add(sum[2], f[2])];
                l.scatter_sub(self.force, neighbours, f);
            }
            for k in 0..3 {
                self.force[i][k] += l.sum(sum[k]);
            }
        }
        under.virial = virial;
    }
}
