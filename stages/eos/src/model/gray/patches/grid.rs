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
/// A part of a patch: `[power of s][lane]`, lanes T, P, c^2, liquid of an even power of y, then of the odd one after it.
pub(super) type Part = [[f64; 8]; 4];

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// V0/V of the first row and rows a unit of it: in density, features of the cold curve are about as wide everywhere.
    start: f64,
    per_step: f64,
    columns: [usize; REGIMES],
    /// `columns` as numbers, and how many come before each regime's.
    counts: [f64; REGIMES],
    before: [usize; REGIMES],
    width: usize,
    /// Parts a patch has: half as many as nodes in y.
    parts: usize,
    /// By row, `[power of s][E_0 .. E_4, T_m, two zeros]`.
    borders: Vec<[[f64; 8]; 4]>,
    /// By row, regime, column, powers of y rising.
    patches: Vec<Part>,
}

/// The strip between two borders that a state lies in.
#[derive(Clone, Copy)]
pub(super) struct Strip {
    /// Its first patch in this row.
    pub first: usize,
    pub regime: usize,
    /// Energy above its lower border, and between its borders [J/kg].
    pub above: f64,
    pub between: f64,
    /// Its columns.
    pub columns: f64,
    /// T_m [K].
    pub melting: f64,
}
impl Strip {
    pub const NONE: Strip = Strip { first: 0, regime: 0, above: 0.0, between: 1.0, columns: 1.0, melting: 0.0 };
}

/// Added to a number below 2^51, leaves its nearest integer in the last bits.
const SHIFT_OUT: f64 = (1u64 << 52) as f64;

/// The interval of 0, 1, .. that `position` lies in, as what [`index`] reads, and how far in, 0..1.
#[inline(always)]
pub(super) fn split<R: Real>(position: R) -> (R, R) {
    let shifted = position.plus(-0.5).at_least(0.0).plus(SHIFT_OUT);
    (shifted, position - shifted.plus(-SHIFT_OUT))
}

/// The column of a strip, as what [`index`] reads, and y in it: of a state `above` its lower border.
#[inline(always)]
pub(super) fn column<R: Real>(above: R, between: R, columns: R) -> (R, R) {
    let position = (above / between * columns).at_least(0.0);
    // On the upper border itself the nearest integer may be that of the next strip.
    let shifted = position.plus(-0.5).at_least(0.0).min(columns.plus(-1.0)).plus(SHIFT_OUT);
    (shifted, position - shifted.plus(-SHIFT_OUT))
}

#[inline(always)]
pub(super) fn index(shifted: f64) -> usize {
    shifted.to_bits() as u32 as usize
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
            columns,
            counts: columns.map(|n| n as f64),
            before: std::array::from_fn(|k| columns[..k].iter().sum()),
            width: columns.iter().sum(),
            parts: nodes.len() / 2,
            borders: Vec::new(),
            patches: Vec::new(),
        };
        for ends in lines.windows(2) {
            let along: [[f64; 4]; 6] = std::array::from_fn(|k| cubic(ends[0].borders[k], ends[1].borders[k]));
            let lane = |power: usize, lane: usize| along.get(lane).map_or(0.0, |c| c[power]);
            grid.borders.push(std::array::from_fn(|power| std::array::from_fn(|k| lane(power, k))));
            for (a, b) in ends[0].columns.iter().zip(&ends[1].columns) {
                grid.patches.extend(patch(&basis, a, b));
            }
        }
        grid
    }

    /// Number of patches, and bytes of all.
    pub fn size(&self) -> (usize, usize) {
        (self.borders.len() * self.width, size_of_val(&self.patches[..]) + size_of_val(&self.borders[..]))
    }

    /// The row, and how far into it, of V/V0 = `u`.
    #[inline(always)]
    pub fn position<R: Real>(&self, u: R) -> R {
        (R::of(1.0) / u).plus(-self.start).times(self.per_step)
    }

    /// The strip of a row, as [`split`] gives it, that E lies in; `None` outside all patches.
    #[inline(always)]
    pub fn strip<R: Eight>(&self, row: f64, s: f64, energy: f64) -> Option<Strip> {
        let row = index(row);
        // Outside on the left or the right s is not in 0..1, nor is it for a NaN; to the right of all the row is too large.
        if !((0.0..=1.0).contains(&s) && row < self.borders.len()) {
            return None;
        }
        let mut borders = [0.0; 8];
        cubic_at::<R>(&self.borders[row], R::of(s)).store(&mut borders);
        if !(energy <= borders[4]) {
            return None;
        }
        let above = |k: usize| usize::from(energy > borders[k]);
        let regime = above(1) + above(2) + above(3);
        Some(Strip {
            first: row * self.width + self.before[regime],
            regime,
            above: energy - borders[regime],
            between: borders[regime + 1] - borders[regime],
            columns: self.counts[regime],
            melting: borders[5],
        })
    }

    /// What the patch says.
    #[inline(always)]
    pub fn value<R: Eight>(&self, patch: usize, s: f64, y: f64, to: &mut Quad) {
        let (s, square) = (R::of(s), R::of(y * y));
        let parts = &self.patches[patch * self.parts..][..self.parts];
        let mut value = cubic_at::<R>(&parts[self.parts - 1], s);
        for part in parts[..self.parts - 1].iter().rev() {
            value = value.fused(square, cubic_at::<R>(part, s));
        }
        (value * R::halves(1.0, y)).fold(to);
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
                    for i in 0..self.columns[k] * nodes.len() {
                        let (column, m) = (i / nodes.len(), i % nodes.len());
                        // The first is the coldest solid, whose T suffers most from an error of the cold curve.
                        let at = if m == 0 { 0.01 } else { 0.5 * (nodes[m - 1] + nodes[m]) };
                        let y = (column as f64 + at) / self.columns[k] as f64;
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
        let (row, s) = split(self.position(volume * gray.constants.per_volume));
        let Some(strip) = self.strip::<Plain>(row, s, energy) else { return lost };
        let exact = gray.point(volume, energy);
        if exact.phase != PHASES[strip.regime] {
            return lost;
        }
        let (at, y) = column(strip.above, strip.between, strip.columns);
        let mut value = Quad::default();
        self.value::<Plain>(strip.first + index(at), s, y, &mut value);
        let [t, p, c2, liquid] = value;
        let parameters = &gray.parameters;
        let scale = 0.01 * parameters.sound_speed * parameters.sound_speed / parameters.volume;
        let mut own = [0.0; 8];
        cubic_at::<Plain>(&self.borders[index(row)], Plain::of(s)).store(&mut own);
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

#[inline(always)]
fn cubic_at<R: Eight>(c: &Part, s: R) -> R {
    R::load(&c[3]).fused(s, R::load(&c[2])).fused(s, R::load(&c[1])).fused(s, R::load(&c[0]))
}
