//! What the next step must know of all particles: their fastest signal, and where they have gone.
use crate::g2p::counted;
use crate::kernel::{edge, first_node};
use crate::material::Law;
use crate::pack::Pack;
use crate::particle::Matter;
use crate::step::Setting;
use crate::store::{Frame, Site, Store};
use crate::task::{Crew, Desk, Task};
use hvi_kit::lanes::Eight;

/// Speeds [m/s].
#[derive(Clone, Copy, Debug, Default)]
pub struct Signal {
    /// Of the fastest signal in matter that isn't alone.
    pub speed: f64,
    /// Of the fastest particle.
    pub velocity: f64,
}

/// Has every block's particles looked at.
pub fn listen<const D: usize>(store: &mut Store<D>, setting: &Setting<D>, crew: &mut Crew) -> Signal {
    let frame = store.frame();
    crew.each(store, setting, &Listen { frame, quiet: setting.quiet });
    fastest(store)
}

/// The fastest of all blocks.
pub fn fastest<const D: usize>(store: &Store<D>) -> Signal {
    store.sites.iter().flatten().fold(Signal::default(), |a, site| Signal {
        speed: if site.signal.speed <= a.speed { a.speed } else { site.signal.speed },
        velocity: a.velocity.max(site.signal.velocity),
    })
}

struct Listen {
    frame: Frame,
    quiet: f64,
}

impl<const D: usize> Task<D> for Listen {
    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, _: &mut Desk) {
        let mut survey = Survey::<R, D>::new(site, self.frame, self.quiet);
        for group in &mut site.groups {
            for k in 0..group.packs.len() {
                let live = group.live(k);
                survey.see(&mut group.packs[k], live);
            }
        }
        survey.keep(site);
    }
}

/// A look at the particles of a block, pack by pack.
pub struct Survey<R, const D: usize> {
    frame: Frame,
    quiet: f64,
    origin: [f64; D],
    stirred: R,
    speed: R,
    square: R,
    low: [R; D],
    high: [R; D],
    left: R,
}

impl<R: Eight, const D: usize> Survey<R, D> {
    /// Nothing seen yet; `quiet` [m/s] is that of [`Setting`].
    #[inline(always)]
    pub fn new(site: &Site<D>, frame: Frame, quiet: f64) -> Self {
        let zero = R::of(0.0);
        let (low, high) = ([R::of(f64::INFINITY); D], [zero; D]);
        Survey { frame, quiet, origin: site.origin(), stirred: zero, speed: zero, square: zero, low, high, left: zero }
    }

    /// The first `live` of a pack.
    #[inline(always)]
    pub fn see(&mut self, pack: &mut Pack<D>, live: usize) {
        let (zero, one, counted) = (R::of(0.0), R::of(1.0), counted::<R>(live));
        let (c, divergence) = (R::load(&pack.matter.sound_speed), R::load(&pack.matter.divergence));
        let shared = counted * (one - R::load(&pack.alone));
        self.speed = self.speed.max(Law::signal_speed(c, divergence, self.frame.cell) * shared);
        let (mut sum, mut outside) = (zero, zero);
        let mut place = [zero; D];
        for d in 0..D {
            let v = R::load(&pack.velocity[d]);
            sum = v.fused(v, sum);
            let (first, _) = first_node(R::load(&pack.position[d]), 1.0 / self.frame.cell, self.frame.reach);
            let at = first.plus(-self.origin[d]);
            // Neither of these holds for a NaN.
            let above = zero.where_less(R::of(-1.0), at, one);
            outside = outside.max(above).max(zero.where_less(at, R::of(edge::<D>() as f64), one));
            place[d] = at;
        }
        self.square = self.square.max(sum * counted);
        // One that is stirred is enough.
        if !zero.any_less(self.stirred) {
            let stirred = R::of(1.0) - self.rests(&pack.matter.load(), sum);
            self.stirred = self.stirred.max(stirred * counted);
        }
        let outside = outside * counted;
        self.left = self.left.max(outside);
        pack.left = 0;
        if zero.any_less(outside) {
            let mut lanes = [0.0; 8];
            outside.store(&mut lanes);
            for lane in 0..8 {
                pack.left |= ((lanes[lane] > 0.0) as u8) << lane;
            }
        }
        let stays = counted - outside;
        for d in 0..D {
            let low = place[d].where_less(zero, stays, R::of(f64::INFINITY));
            self.low[d] = self.low[d].min(low);
            self.high[d] = self.high[d].max(place[d].where_less(zero, stays, zero));
        }
    }

    /// 1 where neither the speed, given its `square`, nor the pressure and the shear stress over `rho c` are as much as the quiet
    /// velocity, else 0; nothing rests where that is 0.
    #[inline(always)]
    fn rests(&self, m: &Matter<R>, square: R) -> R {
        let (zero, one, most) = (R::of(0.0), R::of(1.0), R::of(self.quiet * self.quiet));
        let impedance = m.stiffness / m.sound_speed;
        let mut shear = zero;
        for s in m.stress {
            shear = s.fused(s, shear);
        }
        let bound = impedance * impedance * most;
        let slow = one.where_less(square, most, zero);
        let free = one.where_less(m.unclamped * m.unclamped, bound, zero);
        slow * free * one.where_less(shear, bound, zero)
    }

    /// Notes what was seen at its block.
    #[inline(always)]
    pub fn keep(&self, site: &mut Site<D>) {
        site.signal = Signal { speed: self.speed.greatest(), velocity: self.square.greatest().sqrt() };
        site.stirred = self.stirred.greatest() > 0.0;
        site.left = self.left.greatest() > 0.0;
        for d in 0..D {
            let low = -(R::of(0.0) - self.low[d]).greatest();
            // Where all have left, what comes first widens it.
            site.cells[d + 3 - D] = [low.min(255.0) as u8, self.high[d].greatest() as u8];
        }
    }
}
