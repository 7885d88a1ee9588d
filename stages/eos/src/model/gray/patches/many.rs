//! Many states at once: placed in blocks, read in blocks; those outside go to GRAY's own batch.
use super::super::batch::Batch;
use super::Patches;
use super::grid::{PHASES, Strip, column, index, split};
use crate::lanes::{Eight, Quads, Work};
use crate::{Phase, Points};

/// What is asked, and where the answers go.
pub(super) struct Many<'a> {
    pub of: &'a Patches,
    pub volume: &'a [f64],
    pub energy: &'a [f64],
    pub out: &'a mut Points,
}

/// States placed before their patches are read: short loops without long dependencies overlap in the processor.
const BLOCK: usize = 64;
const GROUPS: usize = BLOCK / 8;

/// What is known of a block's states, eight side by side.
struct Block {
    /// Rows as [`index`] reads them, and how far in; then columns and y, in place of them.
    at: [[f64; 8]; GROUPS],
    s: [[f64; 8]; GROUPS],
    y: [[f64; 8]; GROUPS],
    /// See [`Strip`].
    above: [[f64; 8]; GROUPS],
    between: [[f64; 8]; GROUPS],
    columns: [[f64; 8]; GROUPS],
    first: [usize; BLOCK],
    values: [Quads; GROUPS],
}

impl Block {
    const EMPTY: Block = Block {
        at: [[0.0; 8]; GROUPS],
        s: [[0.0; 8]; GROUPS],
        y: [[0.0; 8]; GROUPS],
        above: [[0.0; 8]; GROUPS],
        between: [[1.0; 8]; GROUPS],
        columns: [[1.0; 8]; GROUPS],
        first: [0; BLOCK],
        values: [[[0.0; 4]; 8]; GROUPS],
    };
}

impl Work for Many<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let mut outside = Vec::new();
        let mut block = Block::EMPTY;
        for start in (0..self.volume.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(self.volume.len());
            let (volume, energy) = (&self.volume[start..end], &self.energy[start..end]);
            let mut out = Slices::of(self.out, start, end);
            rows::<R>(self.of, volume, &mut block);
            for (i, &energy) in energy.iter().enumerate() {
                let (group, lane) = (i / 8, i % 8);
                let found = self.of.grid.strip::<R>(block.at[group][lane], block.s[group][lane], energy);
                let strip = found.unwrap_or_else(|| {
                    outside.push(start + i);
                    Strip::NONE
                });
                block.above[group][lane] = strip.above;
                block.between[group][lane] = strip.between;
                block.columns[group][lane] = strip.columns;
                block.first[i] = strip.first;
                out.phase[i] = PHASES[strip.regime];
                out.melting[i] = strip.melting;
            }
            values::<R>(self.of, energy.len(), &mut block);
            answers::<R>(self.of, &block, &mut out);
        }
        if outside.is_empty() {
            return;
        }
        let (volume, energy): (Vec<f64>, Vec<f64>) = outside.iter().map(|&i| (self.volume[i], self.energy[i])).unzip();
        let mut rest = Points::default();
        rest.resize(outside.len());
        Batch { gray: &self.of.gray, volume: &volume, energy: &energy, out: &mut rest }.run::<R>();
        for (k, &i) in outside.iter().enumerate() {
            self.out.set(i, rest.get(k));
            self.out.melting[i] = rest.melting[k];
        }
    }
}

/// Rows, and how far into them.
#[inline(always)]
fn rows<R: Eight>(of: &Patches, volume: &[f64], block: &mut Block) {
    for (group, chunk) in volume.chunks(8).enumerate() {
        let mut eight = [1.0; 8];
        let volume = chunk.first_chunk().unwrap_or_else(|| {
            eight[..chunk.len()].copy_from_slice(chunk);
            &eight
        });
        let (row, s) = split(of.grid.position(R::load(volume).times(of.gray.constants.per_volume)));
        row.store(&mut block.at[group]);
        s.store(&mut block.s[group]);
    }
}

/// What the patches of `count` states say.
#[inline(always)]
fn values<R: Eight>(of: &Patches, count: usize, block: &mut Block) {
    for group in 0..count.div_ceil(8) {
        let above = R::load(&block.above[group]);
        let (at, y) = column(above, R::load(&block.between[group]), R::load(&block.columns[group]));
        at.store(&mut block.at[group]);
        y.store(&mut block.y[group]);
    }
    for i in 0..count {
        let (group, lane) = (i / 8, i % 8);
        let patch = block.first[i] + index(block.at[group][lane]);
        of.grid.value::<R>(patch, block.s[group][lane], block.y[group][lane], &mut block.values[group][lane]);
    }
}

/// Takes the values over.
#[inline(always)]
fn answers<R: Eight>(of: &Patches, block: &Block, out: &mut Slices<'_>) {
    let Slices { temperature, pressure, sound_speed, liquid, .. } = out;
    let arrays = temperature.chunks_mut(8).zip(pressure.chunks_mut(8));
    let arrays = arrays.zip(sound_speed.chunks_mut(8).zip(liquid.chunks_mut(8)));
    for (group, ((t, p), (c, share))) in arrays.enumerate() {
        let [temperature, pressure, sound_speed, liquid] = of.read(R::columns(&block.values[group]));
        put(temperature, t);
        put(pressure, p);
        put(sound_speed, c);
        put(liquid, share);
    }
}

/// Stores as many as there is room for.
#[inline(always)]
fn put<R: Eight>(from: R, to: &mut [f64]) {
    if let Some(eight) = to.first_chunk_mut() {
        from.store(eight);
        return;
    }
    let mut eight = [0.0; 8];
    from.store(&mut eight);
    to.copy_from_slice(&eight[..to.len()]);
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
