//! The nodes along one row and the polynomials between two.
use super::super::dense::{Local, Regime};
use super::super::{Gray, hot_state, liquid_state, melting_state, solid_state};
use super::grid::{NODES, Patch, REGIMES};

/// Hottest hot liquid in a patch, over its coldest.
const HOTTEST: f64 = 3.0;
/// A value at one row, and its slope along it times the step.
pub(super) type Knot = [f64; 2];
/// T, P, c^2, liquid at the nodes of one column at one row.
pub(super) type Column = [[Knot; 4]; NODES];

/// One volume: borders, and every column's nodes.
pub(super) struct Line {
    pub borders: [Knot; 5],
    pub nodes: Vec<Column>,
}

impl Line {
    /// At V0/V = `density`; slopes by differences of second order, from within `range`.
    pub fn new(gray: &Gray, density: f64, range: (f64, f64), step: f64, columns: [usize; REGIMES]) -> Line {
        const SHIFT: f64 = 1e-5;
        // Weights of density + i SHIFT in the slope times SHIFT.
        let stencil: [(f64, f64); 3] = if density - SHIFT < range.0 {
            [(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)]
        } else if density + SHIFT > range.1 {
            [(0.0, 1.5), (-1.0, -2.0), (-2.0, 0.5)]
        } else {
            [(0.0, 0.0), (1.0, 0.5), (-1.0, -0.5)]
        };
        let locals = stencil.map(|(i, _)| {
            let u = 1.0 / (density + i * SHIFT);
            (u, gray.local(u))
        });
        let edges = locals.map(|(_, local)| borders(gray, &local));
        let knot = |at: [f64; 3]| -> Knot { [at[0], (0..3).map(|i| stencil[i].1 * at[i]).sum::<f64>() * step / SHIFT] };
        let mut nodes = Vec::new();
        for (k, &count) in columns.iter().enumerate() {
            for column in 0..count {
                nodes.push(self::nodes().map(|node| {
                    let y = (column as f64 + node) / count as f64;
                    let at: [[f64; 4]; 3] = std::array::from_fn(|i| {
                        let energy = edges[i][k] + y * (edges[i][k + 1] - edges[i][k]);
                        state(gray, &locals[i], k, energy)
                    });
                    std::array::from_fn(|q| knot([at[0][q], at[1][q], at[2][q]]))
                }));
            }
        }
        Line { borders: std::array::from_fn(|k| knot([edges[0][k], edges[1][k], edges[2][k]])), nodes }
    }
}

/// E [J/kg] where the solid, melting, the liquid, the hot liquid begin, and where patches end.
pub(super) fn borders(gray: &Gray, local: &Local<f64>) -> [f64; 5] {
    use Regime::{HotLiquid, Liquid, Solid};
    let k = &gray.constants;
    let [start, end] = local.melting_range(k);
    let hot = k.hot_ratio * local.tm;
    let energy = |t, regime| local.answer(k, t, regime).energy;
    [
        energy(0.0, Solid),
        energy(start, Solid),
        energy(end, Liquid),
        energy(hot, Liquid),
        energy(HOTTEST * hot, HotLiquid),
    ]
}

/// T, P, c^2, liquid of `regime`'s formulas at one volume and `energy`.
fn state(gray: &Gray, (u, local): &(f64, Local<f64>), regime: usize, energy: f64) -> [f64; 4] {
    let k = &gray.constants;
    let (t, r) = match regime {
        0 => solid_state(k, local, energy),
        1 => melting_state(k, local, energy),
        2 => liquid_state(k, local, energy),
        _ => hot_state(k, local, energy),
    };
    let volume = u * k.volume;
    [t, r.pressure, volume * volume * (t * r.p_t * r.p_t / r.c_v - r.p_v), r.liquid]
}

/// Chebyshev-Lobatto nodes of 0..1: `(1 - cos(pi m/5))/2`, whose cosines are of the golden ratio.
pub(super) fn nodes() -> [f64; NODES] {
    let root = 5f64.sqrt();
    let (a, b) = ((3.0 - root) / 8.0, (5.0 - root) / 8.0);
    [0.0, a, b, 1.0 - b, 1.0 - a, 1.0]
}

/// `[power][node]`: coefficients of 1, y .. y^5 in the polynomial that is 1 at one node and 0 at the others.
pub(super) fn monomials() -> [[f64; NODES]; NODES] {
    let nodes = nodes();
    let mut all = [[0.0; NODES]; NODES];
    for m in 0..NODES {
        let mut product = [0.0; NODES];
        product[0] = 1.0;
        for other in (0..NODES).filter(|&other| other != m) {
            let per = 1.0 / (nodes[m] - nodes[other]);
            product = std::array::from_fn(|power| {
                let lower = if power > 0 { product[power - 1] } else { 0.0 };
                (lower - nodes[other] * product[power]) * per
            });
        }
        (0..NODES).for_each(|power| all[power][m] = product[power]);
    }
    // At the node 0 all others vanish exactly, rounded or not: a cold curve of T = 0 stays so.
    all[0] = std::array::from_fn(|m| f64::from(u8::from(m == 0)));
    all
}

/// Coefficients of the cubic on 0..1 between two knots.
pub(super) fn cubic([f0, d0]: Knot, [f1, d1]: Knot) -> [f64; 4] {
    [f0, d0, 3.0 * (f1 - f0) - 2.0 * d0 - d1, 2.0 * (f0 - f1) + d0 + d1]
}

pub(super) fn patch(basis: &[[f64; NODES]; NODES], a: &Column, b: &Column) -> Patch {
    let along: [[[f64; 4]; 4]; NODES] = std::array::from_fn(|m| std::array::from_fn(|q| cubic(a[m][q], b[m][q])));
    let coefficient = |power: usize, q: usize, s: usize| (0..NODES).map(|m| basis[power][m] * along[m][q][s]).sum();
    std::array::from_fn(|pair| {
        std::array::from_fn(|s| std::array::from_fn(|lane| coefficient(2 * pair + lane / 4, lane % 4, s)))
    })
}
