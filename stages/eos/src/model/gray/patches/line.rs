//! The nodes along one row and the polynomials between two.
use super::super::dense::{Local, Regime};
use super::super::{Gray, hot_state, liquid_state, melting_state, solid_state};
use super::grid::{Part, REGIMES};

/// Hottest hot liquid in a patch, over its coldest.
const HOTTEST: f64 = 3.0;
/// A value at one row, and its slope along it times the step.
pub(super) type Knot = [f64; 2];
/// T, P, c^2, liquid at the nodes of one column at one row.
pub(super) type Column = Vec<[Knot; 4]>;

/// One volume: borders and T_m, and every column's nodes.
pub(super) struct Line {
    pub borders: [Knot; 6],
    pub columns: Vec<Column>,
}

impl Line {
    /// At V0/V = `density`; slopes by differences of second order, from within `range`.
    pub fn new(
        gray: &Gray,
        density: f64,
        range: (f64, f64),
        step: f64,
        counts: [usize; REGIMES],
        nodes: &[f64],
    ) -> Line {
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
        let mut columns = Vec::new();
        for (k, &count) in counts.iter().enumerate() {
            for column in 0..count {
                let at_node = |node: &f64| {
                    let y = (column as f64 + node) / count as f64;
                    let at: [[f64; 4]; 3] = std::array::from_fn(|i| {
                        let energy = edges[i][k] + y * (edges[i][k + 1] - edges[i][k]);
                        state(gray, &locals[i], k, energy)
                    });
                    std::array::from_fn(|q| knot([at[0][q], at[1][q], at[2][q]]))
                };
                columns.push(nodes.iter().map(at_node).collect());
            }
        }
        Line { borders: std::array::from_fn(|k| knot([edges[0][k], edges[1][k], edges[2][k]])), columns }
    }
}

/// E [J/kg] where the solid, melting, the liquid, the hot liquid begin, and where patches end; and T_m [K].
pub(super) fn borders(gray: &Gray, local: &Local<f64>) -> [f64; 6] {
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
        local.tm,
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

/// Chebyshev-Lobatto nodes of 0..1, `(1 - cos(pi m/n))/2` for m = 0..n: of n = 3, and of n = 5, whose cosines are of the
/// golden ratio.
pub(super) fn nodes() -> [Vec<f64>; 2] {
    let root = 5f64.sqrt();
    let (a, b) = ((3.0 - root) / 8.0, (5.0 - root) / 8.0);
    [vec![0.0, 0.25, 0.75, 1.0], vec![0.0, a, b, 1.0 - b, 1.0 - a, 1.0]]
}

/// `[power][node]`: coefficients of 1, y, y^2 .. in the polynomial that is 1 at one node and 0 at the others.
pub(super) fn monomials(nodes: &[f64]) -> Vec<Vec<f64>> {
    let mut all = vec![vec![0.0; nodes.len()]; nodes.len()];
    for m in 0..nodes.len() {
        let mut product = vec![0.0; nodes.len()];
        product[0] = 1.0;
        for other in (0..nodes.len()).filter(|&other| other != m) {
            let per = 1.0 / (nodes[m] - nodes[other]);
            for power in (0..nodes.len()).rev() {
                let lower = if power > 0 { product[power - 1] } else { 0.0 };
                product[power] = (lower - nodes[other] * product[power]) * per;
            }
        }
        (0..nodes.len()).for_each(|power| all[power][m] = product[power]);
    }
    all
}

/// Coefficients of the cubic on 0..1 between two knots.
pub(super) fn cubic([f0, d0]: Knot, [f1, d1]: Knot) -> [f64; 4] {
    [f0, d0, 3.0 * (f1 - f0) - 2.0 * d0 - d1, 2.0 * (f0 - f1) + d0 + d1]
}

/// The patch between two rows' columns, part by part.
pub(super) fn patch(basis: &[Vec<f64>], a: &Column, b: &Column) -> Vec<Part> {
    let knots = a.iter().zip(b);
    let along: Vec<[[f64; 4]; 4]> = knots.map(|(a, b)| std::array::from_fn(|q| cubic(a[q], b[q]))).collect();
    let coefficient = |power: usize, q: usize, s: usize| {
        // Against the first node: what does not change with y, as the share of liquid in the solid, is then exact.
        let over = |(m, at): (usize, &[[f64; 4]; 4])| basis[power][m] * (at[q][s] - along[0][q][s]);
        if power == 0 { along[0][q][s] } else { along.iter().enumerate().map(over).sum() }
    };
    let part = |pair: usize| -> Part {
        let lane = |s: usize, lane: usize| coefficient(2 * pair + lane / 4, lane % 4, s) as f32;
        Part(std::array::from_fn(|s| std::array::from_fn(|k| lane(s, k))))
    };
    (0..basis.len() / 2).map(part).collect()
}
