//! Particles to grid: mass and momentum (step 1 of the method), then the stress that acts through the step and its forces
//! (steps 2 and 3).
use crate::grid::Grid;
use crate::kernel::Stencil;
use crate::material::HalfStep;
use crate::method::Scheme;
use crate::particle::Particle;
use crate::step::Setting;
use crate::tensor::Gradient;

/// What a particle needs between the passes of one step.
#[derive(Clone, Copy, Debug)]
pub struct Work<const D: usize> {
    /// Slot of its cell in the grid.
    pub slot: u32,
    /// Its weights.
    pub stencil: Stencil<D>,
    /// Grid velocity at the particle minus the particle's [m/s].
    pub drift: [f64; D],
    /// Gradient of the grid velocity [1/s], `[component][axis]`.
    pub gradient: [[f64; D]; D],
    /// Energy that the transfer to the grid took out of motion [J].
    pub heat: f64,
    /// Velocity that the transfer damps away [m/s]; see `xpic.rs`.
    pub damped: [f64; D],
    /// Energy gained by artificial heat conduction [J].
    pub conducted: f64,
    /// Stress at the middle of the step; none where the particle is alone.
    pub stress: HalfStep,
    /// No other particle shares a node with it.
    pub alone: bool,
    /// Radius at the start of the step [m].
    pub radius: f64,
}

impl<const D: usize> Work<D> {
    /// Work space of a particle at `radius` [m] in cell `slot` with weights `stencil`.
    pub fn new(slot: u32, stencil: Stencil<D>, radius: f64) -> Self {
        Work {
            radius,
            slot,
            stencil,
            drift: [0.0; D],
            gradient: [[0.0; D]; D],
            heat: 0.0,
            damped: [0.0; D],
            conducted: 0.0,
            stress: HalfStep::default(),
            alone: false,
        }
    }

    /// Gradient of the grid velocity at the start of the step, of the full space [1/s].
    #[inline(always)]
    pub fn gradient_at_start(&self, p: &Particle<D>, setting: &Setting<D>) -> Gradient {
        let radial = p.velocity[D.min(2) - 1] + self.drift[D.min(2) - 1];
        full_gradient(&self.gradient, radial, self.radius, setting)
    }
}

/// Sums over a stencil of a vector field: `sum w u`, `sum u g^T`, `sum w u r^T` and `sum w |u|^2`.
#[derive(Clone, Copy)]
pub struct Sums<const D: usize> {
    pub mean: [f64; D],
    pub gradient: [[f64; D]; D],
    pub moment: [[f64; D]; D],
    pub square: f64,
}

impl<const D: usize> Sums<D> {
    /// Nothing summed yet.
    #[inline(always)]
    pub fn zero() -> Self {
        Sums { mean: [0.0; D], gradient: [[0.0; D]; D], moment: [[0.0; D]; D], square: 0.0 }
    }
}

/// Velocity gradient of the full space; the hoop rate is `radial / radius` in axisymmetry.
#[inline(always)]
pub fn full_gradient<const D: usize>(l: &[[f64; D]; D], radial: f64, radius: f64, setting: &Setting<D>) -> Gradient {
    let mut full = [[0.0; 3]; 3];
    for i in 0..D {
        full[i][..D].copy_from_slice(&l[i]);
    }
    if setting.axisymmetric {
        full[2][2] = radial / setting.radius(radius);
    }
    full
}

/// Step 1: weights; `m_i = sum m w`, `m_i v_i = sum m w (v + C (x_i - x))`.
pub fn momentum<const D: usize>(
    particles: &[Particle<D>],
    slots: &[u32],
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    work: &mut Vec<Work<D>>,
) {
    let cell = setting.cell;
    work.clear();
    for (p, &slot) in particles.iter().zip(slots) {
        let stencil = Stencil::at(&p.position, cell, setting.method.kernel);
        work.push(Work::new(slot, stencil, p.position[D.min(2) - 1]));
        let last = D - 1;
        let along: [f64; D] = std::array::from_fn(|c| p.affine[c][last] * cell);
        for row in 0..Stencil::<D>::ROWS {
            let r = stencil.row(row, cell);
            let mut u = p.velocity;
            for c in 0..D {
                for d in 0..last {
                    u[c] += p.affine[c][d] * r.offset[d];
                }
                u[c] += p.affine[c][last] * stencil.corner[last];
            }
            for k in 0..4 {
                let m = p.mass * r.weight * stencil.weight[last][k];
                let node = grid.at(slot, 4 * row + k);
                node.mass += m;
                for c in 0..D {
                    node.velocity[c] += m * u[c];
                    u[c] += along[c];
                }
            }
        }
    }
}

/// The first half of step 2: the heat of the transfer, and the velocity gradient.
pub fn gradients<const D: usize>(particles: &[Particle<D>], work: &mut [Work<D>], grid: &Grid<D>, cell: f64) {
    for (p, w) in particles.iter().zip(work) {
        w.alone = gather_start(p, w, grid, cell);
    }
}

/// Steps 2 and 3: the stress that acts through the step, and its force on the nodes.
pub fn force<const D: usize>(
    particles: &mut [Particle<D>],
    work: &mut [Work<D>],
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    dt: f64,
) {
    for (p, w) in particles.iter_mut().zip(work) {
        if w.alone {
            continue;
        }
        let l = w.gradient_at_start(p, setting);
        let law = &setting.laws[p.body as usize];
        w.stress = match setting.method.scheme {
            Scheme::Midpoint => law.half_step(p, &l, dt, setting.cell),
            Scheme::Usl | Scheme::Musl => law.standing(p, &l, setting.cell),
            Scheme::Usf => {
                let limited = law.deform(p, &l, dt);
                law.evaluate(p);
                HalfStep { limited, ..law.standing(p, &l, setting.cell) }
            }
        };
        scatter_force(p, w, grid, setting);
    }
}

/// Gathers the grid velocity at the start of the step, and `h = m/2 sum w |v + C (x_i - x) - v_i|^2`.
///
/// Returns whether the particle is alone: `sum w m_i` is no more than its own `m sum w^2`. Alone, its affine field meets
/// nothing, so its gradient would stay as it is for ever and its volume grow as an exponential of time: it flies on as a
/// whole instead, its state untouched.
#[inline(always)]
fn gather_start<const D: usize>(p: &Particle<D>, w: &mut Work<D>, grid: &Grid<D>, cell: f64) -> bool {
    let (s, last) = (&w.stencil, D - 1);
    let nodes = grid.stencil(w.slot);
    let mut sums = Sums::<D>::zero();
    let mut shared = 0.0;
    for row in 0..Stencil::<D>::ROWS {
        let r = s.row(row, cell);
        let mut affine = [0.0; D];
        for c in 0..D {
            for d in 0..last {
                affine[c] += p.affine[c][d] * r.offset[d];
            }
            affine[c] += p.affine[c][last] * s.corner[last];
        }
        let (mut mean, mut slope, mut square, mut mass) = ([0.0; D], [0.0; D], 0.0, 0.0);
        for k in 0..4 {
            let node = &grid.nodes[nodes[4 * row + k] as usize];
            let (weight, gradient) = (s.weight[last][k], s.slope[last][k]);
            mass += weight * node.mass;
            let mut apart = 0.0;
            for c in 0..D {
                let u = node.velocity[c] - p.velocity[c];
                mean[c] += weight * u;
                slope[c] += gradient * u;
                let x = affine[c] - u;
                apart += x * x;
                affine[c] += p.affine[c][last] * cell;
            }
            square += weight * apart;
        }
        for c in 0..D {
            sums.mean[c] += r.weight * mean[c];
            for d in 0..last {
                sums.gradient[c][d] += r.slope[d] * mean[c];
            }
            sums.gradient[c][last] += r.weight * slope[c];
        }
        sums.square += r.weight * square;
        shared += r.weight * mass;
    }
    w.drift = sums.mean;
    w.gradient = sums.gradient;
    w.heat = 0.5 * p.mass * sums.square;
    let own: f64 = s.weight.iter().map(|w| w.iter().map(|x| x * x).sum::<f64>()).product();
    shared <= p.mass * own * (1.0 + 1e-9)
}

/// `f_i = -V sum (S - P I) g`, and in axisymmetry the hoop stress on the radial component.
#[inline(always)]
fn scatter_force<const D: usize>(p: &Particle<D>, w: &Work<D>, grid: &mut Grid<D>, setting: &Setting<D>) {
    let (s, last) = (&w.stencil, D - 1);
    let volume = -p.volume * p.ratio;
    let full = |i: usize, j: usize| match (i, j) {
        (0, 0) | (1, 1) | (2, 2) => volume * (w.stress.deviator[i] - w.stress.pressure),
        (0, 1) | (1, 0) => volume * w.stress.deviator[3],
        (1, 2) | (2, 1) => volume * w.stress.deviator[4],
        _ => volume * w.stress.deviator[5],
    };
    let stress: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|j| full(i, j)));
    let hoop = if setting.axisymmetric { full(2, 2) / setting.radius(p.position[last]) } else { 0.0 };
    for row in 0..Stencil::<D>::ROWS {
        let r = s.row(row, setting.cell);
        let (mut by_weight, mut by_slope) = ([0.0; D], [0.0; D]);
        for c in 0..D {
            for d in 0..last {
                by_weight[c] += stress[c][d] * r.slope[d];
            }
            by_slope[c] = stress[c][last] * r.weight;
        }
        by_weight[last] += hoop * r.weight;
        for k in 0..4 {
            let node = grid.at(w.slot, 4 * row + k);
            for c in 0..D {
                node.next[c] += by_weight[c] * s.weight[last][k] + by_slope[c] * s.slope[last][k];
            }
        }
    }
}
