//! The fastest signal: what the time step must resolve.
use crate::g2p::counted;
use crate::material::Law;
use crate::step::Setting;
use crate::store::{Site, Store};
use crate::task::{Crew, Desk, Task};
use hvi_kit::lanes::Eight;

/// Speeds [m/s].
#[derive(Clone, Copy, Debug, Default)]
pub struct Signal {
    /// Of the fastest signal in matter that isn't alone.
    pub speed: f64,
    /// Of the fastest particle, where it was asked for.
    pub velocity: f64,
}

/// The fastest of all.
pub fn fastest<const D: usize>(
    store: &mut Store<D>,
    setting: &Setting<D>,
    with_velocity: bool,
    crew: &mut Crew,
) -> Signal {
    crew.each(store, setting, &Listen { cell: setting.cell, with_velocity });
    store.sites.iter().flatten().fold(Signal::default(), |a, site| Signal {
        speed: if site.signal.speed <= a.speed { a.speed } else { site.signal.speed },
        velocity: a.velocity.max(site.signal.velocity),
    })
}

struct Listen {
    cell: f64,
    with_velocity: bool,
}

impl<const D: usize> Task<D> for Listen {
    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, _: &mut Desk) {
        let (mut speed, mut square) = (R::of(0.0), R::of(0.0));
        for group in &site.groups {
            for (k, pack) in group.packs.iter().enumerate() {
                let counted = counted::<R>(group.live(k));
                let (c, divergence) = (R::load(&pack.matter.sound_speed), R::load(&pack.matter.divergence));
                let shared = counted * (R::of(1.0) - R::load(&pack.alone));
                speed = speed.max(Law::signal_speed(c, divergence, self.cell) * shared);
                if self.with_velocity {
                    let mut sum = R::of(0.0);
                    for v in &pack.velocity {
                        let v = R::load(v);
                        sum = v.fused(v, sum);
                    }
                    square = square.max(sum * counted);
                }
            }
        }
        site.signal = Signal { speed: speed.greatest(), velocity: square.greatest().sqrt() };
    }
}
