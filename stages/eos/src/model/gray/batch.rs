//! Many states at once: sorted by regime, then eight side by side through the same formulas as a single state, to the bit.
use super::dense::{Local, Regime, Response};
use super::{Constants, Gray, hot_state, liquid_state, melting_state, solid_state, sound_speed};
use crate::lanes::{Eight, Work};
use crate::{Phase, Points};

/// States sorted at a time: what a block's queues hold stays in the first-level cache.
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

/// States of one regime that wait for their turn: for each its place, u (or V in the vapour), E and functions of volume.
struct Queue {
    length: usize,
    place: [usize; BLOCK],
    u: [[f64; 8]; BLOCK / 8],
    energy: [[f64; 8]; BLOCK / 8],
    row: [[[f64; 8]; 8]; BLOCK / 8],
}

impl Queue {
    const EMPTY: Queue = Queue {
        length: 0,
        place: [0; BLOCK],
        u: [[1.0; 8]; BLOCK / 8],
        energy: [[0.0; 8]; BLOCK / 8],
        row: [[[1.0; 8]; 8]; BLOCK / 8],
    };

    #[inline(always)]
    fn push(&mut self, place: usize, u: f64, energy: f64, row: &[f64]) {
        let (group, lane) = (self.length / 8 % (BLOCK / 8), self.length % 8);
        self.place[8 * group + lane] = place;
        self.u[group][lane] = u;
        self.energy[group][lane] = energy;
        for (to, from) in self.row[group].iter_mut().zip(row) {
            to[lane] = *from;
        }
        self.length += 1;
    }

    /// Fills the last group up with copies of its first state.
    #[inline(always)]
    fn fill(&mut self) {
        let (group, used) = (self.length / 8, self.length % 8);
        if used > 0 {
            let first = |lanes: &mut [f64; 8]| {
                let x = lanes[0];
                lanes[used..].fill(x);
            };
            first(&mut self.u[group]);
            first(&mut self.energy[group]);
            self.row[group].iter_mut().for_each(first);
        }
    }
}

/// Computes a queue, eight states at a time, and puts the results in their places. A macro, as a closure's or
/// a function pointer's body would not be compiled for the lanes' processor.
macro_rules! drain {
    ($queue:ident, $out:expr, |$group:ident| $compute:expr) => {
        $queue.fill();
        for $group in 0..$queue.length.div_ceil(8) {
            let (temperature, sound_speed, response) = $compute;
            let mut lanes = [[0.0; 8]; 4];
            temperature.store(&mut lanes[0]);
            sound_speed.store(&mut lanes[1]);
            response.pressure.store(&mut lanes[2]);
            response.liquid.store(&mut lanes[3]);
            for lane in 0..($queue.length - 8 * $group).min(8) {
                let place = $queue.place[8 * $group + lane];
                $out.temperature[place] = lanes[0][lane];
                $out.sound_speed[place] = lanes[1][lane];
                $out.pressure[place] += lanes[2][lane];
                $out.liquid[place] = lanes[3][lane];
            }
        }
    };
}

/// One group of a dense regime: temperature, sound speed, response.
macro_rules! dense {
    ($k:ident, $queue:ident, $group:ident, $state:ident) => {{
        let (t, r) = $state($k, &local::<R>($k, $queue, $group), R::load(&$queue.energy[$group]));
        (t, sound_speed($k, R::load(&$queue.u[$group]).times($k.volume), t, &r), r)
    }};
}

impl Work for Batch<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let k = &self.gray.constants;
        let melting_at_join = self.gray.local(k.join).tm;
        let mut queues = [const { Queue::EMPTY }; 5];
        let mut start = 0;
        while start < self.volume.len() {
            let end = (start + BLOCK).min(self.volume.len());
            queues.iter_mut().for_each(|q| q.length = 0);
            for place in start..end {
                let (volume, energy) = (self.volume[place], self.energy[place]);
                let (u, under) = self.gray.ratio(volume);
                // What the extension below the densest state adds: set first, the response is added to it.
                self.out.pressure[place] = under * k.stiffness;
                if u > k.join {
                    queues[4].push(place, volume, energy, &[]);
                    self.out.phase[place] = Phase::Vapour;
                    self.out.melting[place] = melting_at_join;
                    continue;
                }
                let row = self.gray.functions.at::<R>(u);
                let local = Local::at(k, u, row);
                let regime = local.regime_of(k, energy);
                self.out.melting[place] = local.tm;
                self.out.phase[place] = regime.phase();
                let kept = if regime == Regime::Melting { 8 } else { 5 };
                queues[regime as usize].push(place, u, energy, &row[..kept]);
            }
            let [solid, melting, liquid, hot, vapour] = &mut queues;
            drain!(solid, self.out, |group| dense!(k, solid, group, solid_state));
            drain!(melting, self.out, |group| dense!(k, melting, group, melting_state));
            drain!(liquid, self.out, |group| dense!(k, liquid, group, liquid_state));
            drain!(hot, self.out, |group| dense!(k, hot, group, hot_state));
            drain!(vapour, self.out, |group| dilute::<R>(self.gray, vapour, group));
            start = end;
        }
    }
}

/// The functions of volume of one group.
#[inline(always)]
fn local<R: Eight>(k: &Constants, queue: &Queue, group: usize) -> Local<R> {
    let row = &queue.row[group];
    // Spelled out: see `drain`.
    let row = [
        R::load(&row[0]),
        R::load(&row[1]),
        R::load(&row[2]),
        R::load(&row[3]),
        R::load(&row[4]),
        R::load(&row[5]),
        R::load(&row[6]),
        R::load(&row[7]),
    ];
    Local::new(k, R::load(&queue.u[group]), row)
}

/// One group of the vapour.
#[inline(always)]
fn dilute<R: Eight>(gray: &Gray, queue: &Queue, group: usize) -> (R, R, Response<R>) {
    let k = &gray.constants;
    let volume = R::load(&queue.u[group]);
    let (t, r) = gray.vapour_state(volume, R::load(&queue.energy[group]));
    // As in `point`, where V is u V0.
    (t, sound_speed(k, volume.times(k.per_volume).times(k.volume), t, &r), r)
}
