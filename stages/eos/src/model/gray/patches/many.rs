//! Many states at once: placed eight side by side, read one by one; those outside go to GRAY's own batch.
use super::super::batch::Batch;
use super::Patches;
use super::grid::{PHASES, index};
use crate::lanes::{Eight, Quads, Work};
use crate::{Phase, Points};

/// What is asked, and where the answers go.
pub(super) struct Many<'a> {
    pub of: &'a Patches,
    pub volume: &'a [f64],
    pub energy: &'a [f64],
    pub out: &'a mut Points,
}

/// States taken through each of the loops before the next: short loops without long dependencies overlap in the processor.
const BLOCK: usize = 64;
const GROUPS: usize = BLOCK / 8;

/// A number of each of a block's states, eight side by side.
type Numbers = [[f64; 8]; GROUPS];

/// What is known of a block's states.
#[repr(align(64))]
struct Block {
    volume: Numbers,
    energy: Numbers,
    row: Numbers,
    s: Numbers,
    /// E_0 .. E_3 of each state; then E_4, T_m and two zeros.
    low: [Quads; GROUPS],
    high: [Quads; GROUPS],
    patch: Numbers,
    regime: Numbers,
    y: Numbers,
    outside: Numbers,
    values: [Quads; GROUPS],
}

impl Block {
    const EMPTY: Block = Block {
        volume: [[1.0; 8]; GROUPS],
        energy: [[0.0; 8]; GROUPS],
        row: [[0.0; 8]; GROUPS],
        s: [[0.0; 8]; GROUPS],
        low: [[[0.0; 4]; 8]; GROUPS],
        high: [[[0.0; 4]; 8]; GROUPS],
        patch: [[0.0; 8]; GROUPS],
        regime: [[0.0; 8]; GROUPS],
        y: [[0.0; 8]; GROUPS],
        outside: [[0.0; 8]; GROUPS],
        values: [[[0.0; 4]; 8]; GROUPS],
    };
}

impl Work for Many<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let mut block = Block::EMPTY;
        let mut rest = Rest::default();
        for start in (0..self.volume.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(self.volume.len());
            let (volume, energy) = (&self.volume[start..end], &self.energy[start..end]);
            block.volume.as_flattened_mut()[..end - start].copy_from_slice(volume);
            block.energy.as_flattened_mut()[..end - start].copy_from_slice(energy);
            let mut out = Slices::of(self.out, start, end);
            rows::<R>(self.of, &mut block);
            borders::<R>(self.of, &mut block);
            strips::<R>(self.of, &mut block, &mut out);
            match self.of.grid.parts() {
                2 => values::<R, 2>(self.of, &mut block),
                _ => values::<R, 3>(self.of, &mut block),
            }
            answers::<R>(self.of, &block, &mut out);
            rest.find(&block, volume, energy, start);
        }
        if !rest.place.is_empty() {
            rest.answer::<R>(self.of, self.out);
        }
    }
}

/// Rows, and how far into them.
#[inline(always)]
fn rows<R: Eight>(of: &Patches, block: &mut Block) {
    for group in 0..GROUPS {
        let (row, s) = of.grid.row(R::load(&block.volume[group]).times(of.gray.constants.per_volume));
        row.store(&mut block.row[group]);
        s.store(&mut block.s[group]);
    }
}

/// Borders of all places of the block, of which those beyond the last state hold what is of no use and does no harm.
#[inline(always)]
fn borders<R: Eight>(of: &Patches, block: &mut Block) {
    for group in 0..GROUPS {
        for lane in 0..8 {
            let borders: R = of.grid.borders(index(block.row[group][lane]), block.s[group][lane]);
            borders.split(&mut block.low[group][lane], &mut block.high[group][lane]);
        }
    }
}

/// Patches, phases and T_m.
#[inline(always)]
fn strips<R: Eight>(of: &Patches, block: &mut Block, out: &mut Slices<'_>) {
    for group in 0..GROUPS {
        let [e0, e1, e2, e3] = R::columns(&block.low[group]);
        let [e4, tm, _, _] = R::columns(&block.high[group]);
        let at = (R::load(&block.row[group]), R::load(&block.s[group]));
        let strip = of.grid.strip(at, [e0, e1, e2, e3, e4], R::load(&block.energy[group]));
        strip.patch.store(&mut block.patch[group]);
        strip.regime.store(&mut block.regime[group]);
        strip.y.store(&mut block.y[group]);
        strip.outside.store(&mut block.outside[group]);
        put(tm, out.melting, group);
    }
    let regime = block.regime.as_flattened();
    for i in 0..out.phase.len() {
        out.phase[i] = PHASES[index(regime[i])];
    }
}

/// What the patches say.
#[inline(always)]
fn values<R: Eight, const PARTS: usize>(of: &Patches, block: &mut Block) {
    for group in 0..GROUPS {
        for lane in 0..8 {
            let (patch, s, y) = (index(block.patch[group][lane]), block.s[group][lane], block.y[group][lane]);
            of.grid.value::<R, PARTS>(patch, s, y, &mut block.values[group][lane]);
        }
    }
}

/// Takes the values over.
#[inline(always)]
fn answers<R: Eight>(of: &Patches, block: &Block, out: &mut Slices<'_>) {
    for group in 0..out.pressure.len().div_ceil(8) {
        let [temperature, pressure, sound_speed, liquid] = of.read(R::columns(&block.values[group]));
        put(temperature, out.temperature, group);
        put(pressure, out.pressure, group);
        put(sound_speed, out.sound_speed, group);
        put(liquid, out.liquid, group);
    }
}

/// Stores group number `group`, as much of it as there is room for.
#[inline(always)]
fn put<R: Eight>(from: R, to: &mut [f64], group: usize) {
    let Some(to) = to.get_mut(8 * group..) else { return };
    if let Some(eight) = to.first_chunk_mut() {
        from.store(eight);
        return;
    }
    let mut eight = [0.0; 8];
    from.store(&mut eight);
    to.copy_from_slice(&eight[..to.len()]);
}

/// States outside all patches.
#[derive(Default)]
struct Rest {
    place: Vec<usize>,
    volume: Vec<f64>,
    energy: Vec<f64>,
}
impl Rest {
    /// Takes up those of a block.
    #[inline(always)]
    fn find(&mut self, block: &Block, volume: &[f64], energy: &[f64], start: usize) {
        let outside = block.outside.as_flattened();
        for i in 0..volume.len() {
            if outside[i] > 0.0 {
                self.place.push(start + i);
                self.volume.push(volume[i]);
                self.energy.push(energy[i]);
            }
        }
    }

    /// Answers by GRAY itself.
    #[inline(always)]
    fn answer<R: Eight>(&self, of: &Patches, out: &mut Points) {
        let mut rest = Points::default();
        rest.resize(self.place.len());
        Batch { gray: &of.gray, volume: &self.volume, energy: &self.energy, out: &mut rest }.run::<R>();
        for (k, &i) in self.place.iter().enumerate() {
            out.set(i, rest.get(k));
            out.melting[i] = rest.melting[k];
        }
    }
}

/// One block of the results.
struct Slices<'a> {
    pressure: &'a mut [f64],
    temperature: &'a mut [f64],
    sound_speed: &'a mut [f64],
    phase: &'a mut [Phase],
    liquid: &'a mut [f64],
    melting: &'a mut [f64],
}
impl<'a> Slices<'a> {
    #[inline(always)]
    fn of(out: &'a mut Points, start: usize, end: usize) -> Slices<'a> {
        Slices {
            pressure: &mut out.pressure[start..end],
            temperature: &mut out.temperature[start..end],
            sound_speed: &mut out.sound_speed[start..end],
            phase: &mut out.phase[start..end],
            liquid: &mut out.liquid[start..end],
            melting: &mut out.melting[start..end],
        }
    }
}
