//! Where a state lies among the patches, what is read there, and how far it is from GRAY.
use super::super::Gray;
use super::PatchErrors;
use super::line::{Line, borders, cubic, monomials, nodes, patch};
use crate::Phase;
use crate::lanes::{Eight, Plain, Real};

/// Nodes in y of a patch, and the 1, y .. y^5 of the polynomial through them.
pub(super) const NODES: usize = 6;
/// Regimes with patches; code k is that of [`Phase`].
pub(super) const REGIMES: usize = 4;
/// The share of liquid in each regime, at least and at most.
pub(super) const LEAST_LIQUID: [f64; REGIMES] = [0.0, 0.0, 1.0, 1.0];
pub(super) const MOST_LIQUID: [f64; REGIMES] = [0.0, 1.0, 1.0, 1.0];
pub(super) const PHASES: [Phase; REGIMES] = [Phase::Solid, Phase::Melting, Phase::Liquid, Phase::HotLiquid];

/// One patch: `[power of y^2][power of s][lane]`, lanes T, P, c^2, liquid of the even powers of y, then of the odd ones.
pub(super) type Patch = [[[f64; 8]; 4]; NODES / 2];

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// V0/V of the first row and rows a unit of it: in density, features of the cold curve are about as wide everywhere.
    start: f64,
    per_step: f64,
    columns: [usize; REGIMES],
    /// `columns` as numbers, how many come before each regime's, and all of them.
    counts: [f64; REGIMES],
    before: [usize; REGIMES],
    width: usize,
    /// By row, `[power of s][E_0 .. E_4, three zeros]`.
    pub borders: Vec<[[f64; 8]; 4]>,
    /// By row, regime, column.
    pub patches: Vec<Patch>,
}

/// Where a state lies: patch, local coordinates, regime.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub patch: usize,
    pub s: f64,
    pub y: f64,
    pub regime: usize,
}
impl Place {
    pub const NOWHERE: Place = Place { patch: 0, s: 0.0, y: 0.0, regime: 0 };
}

/// Added to a number below 2^51, leaves its nearest integer in the last bits.
const SHIFT_OUT: f64 = (1u64 << 52) as f64;

/// The interval of 0, 1, .. that `position` lies in, as what [`index`] reads, and how far in, 0..1.
#[inline(always)]
pub(super) fn split<R: Real>(position: R) -> (R, R) {
    let shifted = position.plus(-0.5).at_least(0.0).plus(SHIFT_OUT);
    (shifted, position - shifted.plus(-SHIFT_OUT))
}
#[inline(always)]
fn index(shifted: f64) -> usize {
    shifted.to_bits() as u32 as usize
}

impl Grid {
    /// `rows` rows and, by regime, `columns` columns of patches.
    pub fn new(gray: &Gray, rows: usize, columns: [usize; REGIMES]) -> Grid {
        let range = (1.0 / gray.constants.join, 1.0 / (1.0 - gray.parameters.cap()));
        let step = (range.1 - range.0) / rows as f64;
        let line = |i: usize| Line::new(gray, (range.0 + i as f64 * step).min(range.1), range, step, columns);
        let lines: Vec<Line> = (0..=rows).map(line).collect();
        let basis = monomials();
        let mut grid = Grid {
            start: range.0,
            per_step: 1.0 / step,
            columns,
            counts: columns.map(|n| n as f64),
            before: std::array::from_fn(|k| columns[..k].iter().sum()),
            width: columns.iter().sum(),
            borders: Vec::new(),
            patches: Vec::new(),
        };
        for ends in lines.windows(2) {
            let border = |k: usize| cubic(ends[0].borders[k], ends[1].borders[k]);
            let borders: [[f64; 4]; 5] = std::array::from_fn(border);
            grid.borders.push(std::array::from_fn(|power| {
                std::array::from_fn(|lane| if lane < 5 { borders[lane][power] } else { 0.0 })
            }));
            for (a, b) in ends[0].nodes.iter().zip(&ends[1].nodes) {
                grid.patches.push(patch(&basis, a, b));
            }
        }
        grid
    }

    /// The row, and how far into it, of V/V0 = `u`.
    #[inline(always)]
    pub fn position<R: Real>(&self, u: R) -> R {
        (R::of(1.0) / u).plus(-self.start).times(self.per_step)
    }

    /// Where a row, as [`split`] gives it, and E lie; `None` outside all patches.
    #[inline(always)]
    pub fn place<R: Eight>(&self, row: f64, s: f64, energy: f64) -> Option<Place> {
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
        let across = (energy - borders[regime]) / (borders[regime + 1] - borders[regime]);
        let (column, y) = split((across * self.counts[regime]).at_least(0.0));
        Some(Place { patch: row * self.width + self.before[regime] + index(column), s, y, regime })
    }

    /// Even and odd parts in y of T, P, c^2 and liquid.
    #[inline(always)]
    pub fn value<R: Eight>(&self, place: Place) -> [f64; 8] {
        let (s, square) = (R::of(place.s), R::of(place.y * place.y));
        let [even, middle, high] = &self.patches[place.patch];
        let mut value = [0.0; 8];
        ((cubic_at::<R>(high, s) * square + cubic_at::<R>(middle, s)) * square + cubic_at::<R>(even, s))
            .store(&mut value);
        value
    }

    /// Largest errors by regime, between the nodes in y, at the given shares of each row.
    pub fn errors(&self, gray: &Gray, shares: &[f64]) -> [PatchErrors; REGIMES] {
        let mut all = [PatchErrors::default(); REGIMES];
        let nodes = nodes();
        for row in 0..self.borders.len() {
            for share in shares {
                let u = 1.0 / (self.start + (row as f64 + share) / self.per_step);
                let volume = u * gray.constants.volume;
                let exact = borders(gray, &gray.local(u));
                for k in 0..REGIMES {
                    for i in 0..self.columns[k] * NODES {
                        let (column, m) = (i / NODES, i % NODES);
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

    fn error(&self, gray: &Gray, volume: f64, energy: f64, borders: &[f64; 5]) -> PatchErrors {
        let lost = PatchErrors { border: f64::INFINITY, ..PatchErrors::default() };
        let (row, s) = split(self.position(volume * gray.constants.per_volume));
        let Some(place) = self.place::<Plain>(row, s, energy) else { return lost };
        let exact = gray.point(volume, energy);
        if exact.phase != PHASES[place.regime] {
            return lost;
        }
        let value = self.value::<Plain>(place);
        let [t, p, c2, liquid]: [f64; 4] = std::array::from_fn(|q| value[q] + place.y * value[q + 4]);
        let (parameters, row) = (&gray.parameters, &self.borders[place.patch / self.width]);
        let scale = 0.01 * parameters.sound_speed * parameters.sound_speed / parameters.volume;
        let border = |k: usize| {
            let at = ((row[3][k] * place.s + row[2][k]) * place.s + row[1][k]) * place.s + row[0][k];
            (at - borders[k]).abs() / (borders[1] - borders[0])
        };
        PatchErrors {
            pressure: (p - exact.pressure).abs() / exact.pressure.abs().max(scale),
            temperature: (t - exact.temperature).abs() / exact.temperature.max(parameters.reference_temperature),
            sound_speed: (c2.max(gray.constants.floor).sqrt() - exact.sound_speed).abs()
                / exact.sound_speed.max(0.25 * parameters.sound_speed),
            liquid: (liquid - exact.liquid).abs(),
            border: (0..4).map(border).fold(0.0, f64::max),
        }
    }
}

#[inline(always)]
fn cubic_at<R: Eight>(c: &[[f64; 8]; 4], s: R) -> R {
    ((R::load(&c[3]) * s + R::load(&c[2])) * s + R::load(&c[1])) * s + R::load(&c[0])
}
