//! Answers for many states, one array a quantity.
use crate::{Phase, Point};

/// What [`crate::Eos::evaluate`] fills: arrays of one length, entry i for state i. The units are those of [`Point`];
/// `melting` is the melting temperature [K] at the state's volume, infinite where the model knows no melting.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "they are the fields of `Point`")]
pub struct Points {
    pub pressure: Vec<f64>,
    pub temperature: Vec<f64>,
    pub sound_speed: Vec<f64>,
    pub phase: Vec<Phase>,
    pub liquid: Vec<f64>,
    pub melting: Vec<f64>,
}

impl Points {
    /// Makes room for `n` states; what was there is left as it is.
    pub fn resize(&mut self, n: usize) {
        let Points { pressure, temperature, sound_speed, liquid, melting, .. } = self;
        for array in [pressure, temperature, sound_speed, liquid, melting] {
            array.resize(n, 0.0);
        }
        self.phase.resize(n, Phase::Solid);
    }
    /// State `i`.
    pub fn get(&self, i: usize) -> Point {
        Point {
            pressure: self.pressure[i],
            temperature: self.temperature[i],
            sound_speed: self.sound_speed[i],
            phase: self.phase[i],
            liquid: self.liquid[i],
        }
    }
    /// Sets state `i`.
    pub fn set(&mut self, i: usize, at: Point) {
        self.pressure[i] = at.pressure;
        self.temperature[i] = at.temperature;
        self.sound_speed[i] = at.sound_speed;
        self.phase[i] = at.phase;
        self.liquid[i] = at.liquid;
    }
}
