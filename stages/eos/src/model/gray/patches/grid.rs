//! Where a state lies among the patches, what is read there, and how far it is from GRAY.
use super::super::Gray;
use super::PatchErrors;
use super::line::{Line, borders, cubic, monomials, patch};
use crate::Phase;
use crate::lanes::{Eight, Plain, Real};

/// Regimes with patches; code k is that of [`Phase`].
pub(super) const REGIMES: usize = 4;
pub(super) const PHASES: [Phase; REGIMES] = [Phase::Solid, Phase::Melting, Phase::Liquid, Phase::HotLiquid];

/// T, P, c^2, liquid: a fit in y and s.
pub(super) type Quad = [f64; 4];
/// A part of a patch: `[power of s][lane]`, lanes T, P, c^2, liquid of an even power of y, then of the odd one after it. Of single
/// width, whose rounding is 6e-8: half as much to fetch. Two lines of the cache.
#[derive(Clone, Debug, PartialEq)]
#[repr(align(64))]
pub(super) struct Part(pub [[f32; 8]; 4]);

/// Borders and T_m of a row: `[power of s][E_0 .. E_4, T_m, two zeros]`.
#[derive(Clone, Debug, PartialEq)]
#[repr(align(64))]
struct Borders([[f64; 8]; 4]);

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// V0/V of the first row and rows a unit of it: in density, features of the cold curve are about as wide everywhere.
    start: f64,
    per_step: f64,
    columns: [f64; REGIMES],
    /// How many columns come before each regime's, and of all.
    before: [f64; REGIMES],
    width: f64,
    /// Parts a patch has: half as many as nodes in y, 2 or 3.
    parts: usize,
    /// By row.
    borders: Vec<Borders>,
    /// By row, regime, column, powers of y rising.
    patches: Vec<Part>,
}

/// The strip between two borders that a state lies in, or several states' strips side by side.
#[derive(Clone, Copy)]
pub(super) struct Strip<R> {
    /// Its patch.
    pub patch: R,
    /// Its code, see [`PHASES`].
    pub regime: R,
    /// From the patch's lower edge to its upper one, 0..1.
    pub y: R,
    /// 0 where there is a patch, 1 outside all of them; the others are then of some patch that exists.
    pub outside: R,
}

/// Added to a number below 2^51, leaves its nearest integer in the last bits.
const SHIFT_OUT: f64 = (1u64 << 52) as f64;

/// The interval of 0, 1, .. `last` that `position` lies in, and how far in: 0..1, unless it lies in none.
#[inline(always)]
fn interval<R: Real>(position: R, last: R) -> (R, R) {
    let below = position.plus(-0.5).at_least(0.0).min(last).plus(SHIFT_OUT).plus(-SHIFT_OUT);
    (below, position - below)
}

/// Of four, the one that belongs to the last of three rising `borders` that `energy` is above; the first above none.
#[inline(always)]
fn last_below<R: Real>(energy: R, of: [R; 4], borders: [R; 3]) -> R {
    let of_two = of[1].where_less(borders[0], energy, of[0]);
    of[3].where_less(borders[2], energy, of[2].where_less(borders[1], energy, of_two))
}

/// The same in all lanes.
#[inline(always)]
fn numbers<R: Real>(of: &[f64; 4]) -> [R; 4] {
    [R::of(of[0]), R::of(of[1]), R::of(of[2]), R::of(of[3])]
}

/// A whole number as an index.
#[inline(always)]
pub(super) fn index(whole: f64) -> usize {
    (whole + SHIFT_OUT).to_bits() as u32 as usize
}

impl Grid {
    /// `rows` rows and, by regime, `columns` columns of patches with `nodes` nodes in y.
    pub fn new(gray: &Gray, rows: usize, columns: [usize; REGIMES], nodes: &[f64]) -> Grid {
        let range = (1.0 / gray.constants.join, 1.0 / (1.0 - gray.parameters.cap()));
        let step = (range.1 - range.0) / rows as f64;
        let line = |i: usize| Line::new(gray, (range.0 + i as f64 * step).min(range.1), range, step, columns, nodes);
        let lines: Vec<Line> = (0..=rows).map(line).collect();
        let basis = monomials(nodes);
        let mut grid = Grid {
            start: range.0,
            per_step: 1.0 / step,
            columns: columns.map(|n| n as f64),
            before: std::array::from_fn(|k| columns[..k].iter().sum::<usize>() as f64),
            width: columns.iter().sum::<usize>() as f64,
            parts: nodes.len() / 2,
            borders: Vec::new(),
            patches: Vec::new(),
        };
        for ends in lines.windows(2) {
            let along: [[f64; 4]; 6] = std::array::from_fn(|k| cubic(ends[0].borders[k], ends[1].borders[k]));
            let lane = |power: usize, lane: usize| along.get(lane).map_or(0.0, |c| c[power]);
            grid.borders.push(Borders(std::array::from_fn(|power| std::array::from_fn(|k| lane(power, k)))));
            for (a, b) in ends[0].columns.iter().zip(&ends[1].columns) {
                grid.patches.extend(patch(&basis, a, b));
            }
        }
        grid
    }

    /// Number of patches, and bytes of all.
    pub fn size(&self) -> (usize, usize) {
        (self.patches.len() / self.parts, size_of_val(&self.patches[..]) + size_of_val(&self.borders[..]))
    }

    /// Parts a patch has: 2 or 3.
    pub fn parts(&self) -> usize {
        self.parts
    }

    /// The row of V/V0 = `u`, and how far into it: 0..1, unless it lies in none.
    #[inline(always)]
    pub fn row<R: Real>(&self, u: R) -> (R, R) {
        let position = (R::of(1.0) / u).plus(-self.start).times(self.per_step);
        interval(position, R::of((self.borders.len() - 1) as f64))
    }

    /// E_0 .. E_4 and T_m, `s` into a row.
    #[inline(always)]
    pub fn borders<R: Eight>(&self, row: usize, s: f64) -> R {
        let (c, s) = (&self.borders[row].0, R::of(s));
        R::load(&c[3]).fused(s, R::load(&c[2])).fused(s, R::load(&c[1])).fused(s, R::load(&c[0]))
    }

    /// Where a state of `energy` lies that is `s` into `row`, between borders E_0 .. E_4.
    #[inline(always)]
    pub fn strip<R: Real>(&self, (row, s): (R, R), [e0, e1, e2, e3, e4]: [R; 5], energy: R) -> Strip<R> {
        let lower = last_below(energy, [e0, e1, e2, e3], [e1, e2, e3]);
        let upper = last_below(energy, [e1, e2, e3, e4], [e1, e2, e3]);
        let columns = last_below(energy, numbers(&self.columns), [e1, e2, e3]);
        let before = last_below(energy, numbers(&self.before), [e1, e2, e3]);
        let (column, y) = interval(((energy - lower) / (upper - lower) * columns).at_least(0.0), columns.plus(-1.0));
        let (zero, one) = (R::of(0.0), R::of(1.0));
        // What is NaN is less than nothing: outside.
        let outside = one.where_less(s, zero, zero.where_less(s, R::of(1.0 + 1e-9), one));
        Strip {
            patch: row.times(self.width) + before + column,
            regime: last_below(energy, numbers(&[0.0, 1.0, 2.0, 3.0]), [e1, e2, e3]),
            y,
            outside: outside.where_less(energy, e4, one),
        }
    }

    /// What the patch says, of `PARTS` parts.
    #[inline(always)]
    pub fn value<R: Eight, const PARTS: usize>(&self, patch: usize, s: f64, y: f64, to: &mut Quad) {
        let (s, square) = (R::of(s), R::of(y * y));
        let parts = &self.patches[patch * PARTS..][..PARTS];
        let at = |part: &Part| {
            let c = &part.0;
            let high = R::widened(&c[3]).fused(s, R::widened(&c[2]));
            high.fused(s, R::widened(&c[1])).fused(s, R::widened(&c[0]))
        };
        let mut value = at(&parts[PARTS - 1]);
        for part in parts[..PARTS - 1].iter().rev() {
            value = value.fused(square, at(part));
        }
        (value * R::halves(1.0, y)).fold(to);
    }

    /// The phase at V/V0 = `u` and `energy`, T_m, and what the patch says; `None` outside all patches.
    #[inline(always)]
    pub fn point<R: Eight>(&self, u: f64, energy: f64) -> Option<(Phase, Quad, [f64; 8])> {
        let (row, s) = self.row(u);
        let (mut borders, mut value) = ([0.0; 8], Quad::default());
        self.borders::<R>(index(row), s).store(&mut borders);
        let [e0, e1, e2, e3, e4, ..] = borders;
        let strip = self.strip((row, s), [e0, e1, e2, e3, e4], energy);
        if strip.outside > 0.0 {
            return None;
        }
        match self.parts {
            2 => self.value::<R, 2>(index(strip.patch), s, strip.y, &mut value),
            _ => self.value::<R, 3>(index(strip.patch), s, strip.y, &mut value),
        }
        Some((PHASES[index(strip.regime)], value, borders))
    }

    /// Largest errors by regime, between the nodes in y, at the given shares of each row.
    pub fn errors(&self, gray: &Gray, nodes: &[f64], shares: &[f64]) -> [PatchErrors; REGIMES] {
        let mut all = [PatchErrors::default(); REGIMES];
        for row in 0..self.borders.len() {
            for share in shares {
                let u = 1.0 / (self.start + (row as f64 + share) / self.per_step);
                let volume = u * gray.constants.volume;
                let exact = borders(gray, &gray.local(u));
                for k in 0..REGIMES {
                    for i in 0..self.columns[k] as usize * nodes.len() {
                        let (column, m) = (i / nodes.len(), i % nodes.len());
                        // The first is the coldest solid, whose T suffers most from an error of the cold curve.
                        let at = if m == 0 { 0.01 } else { 0.5 * (nodes[m - 1] + nodes[m]) };
                        let y = (column as f64 + at) / self.columns[k];
                        let energy = exact[k] + y * (exact[k + 1] - exact[k]);
                        all[k] = all[k].or(self.error(gray, volume, energy, &exact));
                    }
                }
            }
        }
        all
    }

    fn error(&self, gray: &Gray, volume: f64, energy: f64, borders: &[f64; 6]) -> PatchErrors {
        let lost = PatchErrors { border: f64::INFINITY, ..PatchErrors::default() };
        let Some((phase, value, own)) = self.point::<Plain>(volume * gray.constants.per_volume, energy) else {
            return lost;
        };
        let exact = gray.point(volume, energy);
        if exact.phase != phase {
            return lost;
        }
        let [t, p, c2, liquid] = value;
        let parameters = &gray.parameters;
        let scale = 0.01 * parameters.sound_speed * parameters.sound_speed / parameters.volume;
        let border = |k: usize| (own[k] - borders[k]).abs() / (borders[1] - borders[0]);
        PatchErrors {
            pressure: (p - exact.pressure).abs() / exact.pressure.abs().max(scale),
            temperature: (t - exact.temperature).abs() / exact.temperature.max(parameters.reference_temperature),
            sound_speed: (c2.max(gray.constants.floor).sqrt() - exact.sound_speed).abs()
                / exact.sound_speed.max(0.25 * parameters.sound_speed),
            liquid: (liquid - exact.liquid).abs(),
            border: (0..4).map(border).fold(0.0, f64::max),
            melting: (own[5] / borders[5] - 1.0).abs(),
        }
    }
}
