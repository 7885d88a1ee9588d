//! Many states at once: placed in blocks, read in blocks; those outside go to GRAY's own batch.
use super::super::batch::Batch;
use super::Patches;
use super::grid::{Place, split};
use crate::lanes::{Eight, Work};
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

impl Work for Many<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let (of, grid) = (self.of, &self.of.grid);
        let mut outside = Vec::new();
        let mut places = [Place::NOWHERE; BLOCK];
        let mut values = [[0.0; 8]; BLOCK];
        let (mut rows, mut shares) = ([[0.0; 8]; BLOCK / 8], [[0.0; 8]; BLOCK / 8]);
        for start in (0..self.volume.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(self.volume.len());
            let (volume, energy) = (&self.volume[start..end], &self.energy[start..end]);
            for (group, chunk) in volume.chunks(8).enumerate() {
                let mut eight = [1.0; 8];
                eight[..chunk.len()].copy_from_slice(chunk);
                let (row, s) = split(grid.position(R::load(&eight).times(of.gray.constants.per_volume)));
                row.store(&mut rows[group]);
                s.store(&mut shares[group]);
            }
            let (row, share) = (rows.as_flattened(), shares.as_flattened());
            for (i, &energy) in energy.iter().enumerate() {
                places[i] = grid.place::<R>(row[i], share[i], energy).unwrap_or_else(|| {
                    outside.push(start + i);
                    Place::NOWHERE
                });
            }
            for (value, place) in values.iter_mut().zip(&places).take(energy.len()) {
                *value = grid.value::<R>(*place);
            }
            let out = Slices::of(self.out, start, end);
            let rest = out.temperature.iter_mut().zip(out.sound_speed).zip(out.phase).zip(out.liquid);
            let all = out.pressure.iter_mut().zip(rest).zip(values.iter().zip(&places));
            for ((pressure, (((temperature, sound_speed), phase), liquid)), (value, place)) in all {
                let at = of.read(*place, value);
                *pressure = at.pressure;
                *temperature = at.temperature;
                *sound_speed = at.sound_speed;
                *phase = at.phase;
                *liquid = at.liquid;
            }
        }
        if outside.is_empty() {
            return;
        }
        let (volume, energy): (Vec<f64>, Vec<f64>) = outside.iter().map(|&i| (self.volume[i], self.energy[i])).unzip();
        let mut rest = Points::default();
        rest.resize(outside.len());
        Batch { gray: &of.gray, volume: &volume, energy: &energy, out: &mut rest }.run::<R>();
        outside.iter().enumerate().for_each(|(k, &i)| self.out.set(i, rest.get(k)));
    }
}

/// One block of the results.
struct Slices<'a> {
    pressure: &'a mut [f64],
    temperature: &'a mut [f64],
    sound_speed: &'a mut [f64],
    phase: &'a mut [Phase],
    liquid: &'a mut [f64],
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
        }
    }
}
