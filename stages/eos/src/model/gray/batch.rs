//! Many states at once: sorted by regime, then eight side by side through the same formulas as a single state, to the bit.
use super::cold::Row;
use super::dense::{Local, Response};
use super::{Constants, Gray, hot_state, liquid_state, melting_state, solid_state, sound_speed};
use crate::lanes::{Eight, Work};
use crate::{Phase, Points};

/// States sorted at a time: what is known of them stays in the first-level cache.
const BLOCK: usize = 64;

impl Gray {
    /// See [`crate::Eos::evaluate_with`].
    pub(crate) fn evaluate(&self, set: crate::Instructions, volume: &[f64], energy: &[f64], out: &mut Points) {
        set.run(Batch { gray: self, volume, energy, out });
    }
}

pub(super) struct Batch<'a> {
    pub gray: &'a Gray,
    pub volume: &'a [f64],
    pub energy: &'a [f64],
    pub out: &'a mut Points,
}

/// States of one regime that wait for their turn: their places in the block.
struct Queue {
    length: usize,
    place: [u8; BLOCK],
}

impl Queue {
    const EMPTY: Queue = Queue { length: 0, place: [0; BLOCK] };

    #[inline(always)]
    fn push(&mut self, place: usize) {
        self.place[self.length % BLOCK] = place as u8;
        self.length += 1;
    }

    /// Places of a group's states, filled up with its first.
    #[inline(always)]
    fn group(&self, group: usize) -> [usize; 8] {
        let mut places = [0; 8];
        for lane in 0..8 {
            let at = if 8 * group + lane < self.length { 8 * group + lane } else { 8 * group };
            places[lane] = self.place[at % BLOCK] as usize % BLOCK;
        }
        places
    }
}

/// What is known of a block's states: u (or V in the vapour), E and functions of volume.
struct Block {
    u: [f64; BLOCK],
    energy: [f64; BLOCK],
    row: [Row; BLOCK],
}

impl Block {
    /// Numbers of eight states.
    #[inline(always)]
    fn of<R: Eight>(from: &[f64; BLOCK], places: &[usize; 8]) -> R {
        let mut lanes = [0.0; 8];
        for lane in 0..8 {
            lanes[lane] = from[places[lane]];
        }
        R::load(&lanes)
    }

    /// The functions of volume of eight states, the first `kept` of them; 1 for the others.
    #[inline(always)]
    fn local<R: Eight>(&self, k: &Constants, places: &[usize; 8], kept: usize) -> Local<R> {
        let mut lanes = [[1.0; 8]; 8];
        for lane in 0..8 {
            for q in 0..kept {
                lanes[q][lane] = self.row[places[lane]][q];
            }
        }
        // Spelled out: see `drain`.
        let row = [
            R::load(&lanes[0]),
            R::load(&lanes[1]),
            R::load(&lanes[2]),
            R::load(&lanes[3]),
            R::load(&lanes[4]),
            R::load(&lanes[5]),
            R::load(&lanes[6]),
            R::load(&lanes[7]),
        ];
        Local::new(k, Block::of(&self.u, places), row)
    }
}

/// Computes a queue, eight states at a time, and puts the results in their places from `$start` on. A macro, as a closure's or
/// a function pointer's body would not be compiled for the lanes' processor.
macro_rules! drain {
    ($queue:expr, $start:ident, $out:expr, |$places:ident| $compute:expr) => {
        for group in 0..$queue.length.div_ceil(8) {
            let $places = $queue.group(group);
            let (temperature, sound_speed, response) = $compute;
            let mut lanes = [[0.0; 8]; 4];
            temperature.store(&mut lanes[0]);
            sound_speed.store(&mut lanes[1]);
            response.pressure.store(&mut lanes[2]);
            response.liquid.store(&mut lanes[3]);
            for lane in 0..($queue.length - 8 * group).min(8) {
                let place = $start + $places[lane];
                $out.temperature[place] = lanes[0][lane];
                $out.sound_speed[place] = lanes[1][lane];
                $out.pressure[place] += lanes[2][lane];
                $out.liquid[place] = lanes[3][lane];
            }
        }
    };
}

/// One group of a dense regime, of whose functions of volume `$kept` count: temperature, sound speed, response.
macro_rules! dense {
    ($k:ident, $block:ident, $places:ident, $kept:expr, $state:ident) => {{
        let u = Block::of::<R>(&$block.u, &$places);
        let local = $block.local::<R>($k, &$places, $kept);
        let (t, r) = $state($k, &local, Block::of(&$block.energy, &$places));
        (t, sound_speed($k, u.times($k.volume), t, &r), r)
    }};
}

impl Work for Batch<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let k = &self.gray.constants;
        let melting_at_join = Local::at(k, k.join, self.gray.functions.at::<R>(k.join)).tm;
        let mut block = Block { u: [1.0; BLOCK], energy: [0.0; BLOCK], row: [[1.0; 8]; BLOCK] };
        let mut start = 0;
        while start < self.volume.len() {
            let end = (start + BLOCK).min(self.volume.len());
            let mut queues = [const { Queue::EMPTY }; 5];
            for i in 0..end - start {
                let place = start + i;
                let (volume, energy) = (self.volume[place], self.energy[place]);
                let (u, under) = self.gray.ratio(volume);
                // What the extension below the densest state adds: set first, the response is added to it.
                self.out.pressure[place] = under * k.stiffness;
                block.energy[i] = energy;
                if u > k.join {
                    block.u[i] = volume;
                    queues[4].push(i);
                    self.out.phase[place] = Phase::Vapour;
                    self.out.melting[place] = melting_at_join;
                    continue;
                }
                let row = self.gray.functions.at::<R>(u);
                (block.u[i], block.row[i]) = (u, row);
                let local = Local::at(k, u, row);
                let regime = local.regime_of(k, energy);
                self.out.melting[place] = local.tm;
                self.out.phase[place] = regime.phase();
                queues[regime as usize].push(i);
            }
            let [solid, melting, liquid, hot, vapour] = &queues;
            drain!(solid, start, self.out, |places| dense!(k, block, places, 5, solid_state));
            drain!(melting, start, self.out, |places| dense!(k, block, places, 8, melting_state));
            drain!(liquid, start, self.out, |places| dense!(k, block, places, 5, liquid_state));
            drain!(hot, start, self.out, |places| dense!(k, block, places, 5, hot_state));
            drain!(vapour, start, self.out, |places| dilute::<R>(self.gray, &block, &places));
            start = end;
        }
    }
}

/// One group of the vapour.
#[inline(always)]
fn dilute<R: Eight>(gray: &Gray, block: &Block, places: &[usize; 8]) -> (R, R, Response<R>) {
    let k = &gray.constants;
    let volume = Block::of::<R>(&block.u, places);
    let (t, r) = gray.vapour_state(volume, Block::of(&block.energy, places));
    // As in `point`, where V is u V0.
    (t, sound_speed(k, volume.times(k.per_volume).times(k.volume), t, &r), r)
}
