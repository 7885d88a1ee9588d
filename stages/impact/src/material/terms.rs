//! What passes between a law and the step: stress, gains, and what the equation of state says; for one particle or eight.
use crate::tensor::Symmetric;

/// Stress that acts through a step, taken at its middle.
#[derive(Clone, Copy, Debug)]
pub struct HalfStep<R> {
    /// Pressure without artificial viscosity [Pa].
    pub pressure: R,
    /// Artificial viscosity [Pa].
    pub viscous: R,
    /// Deviator [Pa].
    pub deviator: Symmetric<R>,
    /// 1 where the volume change to the middle had to be limited, else 0.
    pub limited: R,
}

/// What one update adds to the run's accounts.
#[derive(Clone, Copy, Debug)]
pub struct Gain<R> {
    /// Energy put in to lift a negative internal energy to zero [J].
    pub floored: R,
    /// Heat made by artificial viscosity [J].
    pub viscous: R,
}

/// What an equation of state says of a particle.
#[derive(Clone, Copy, Debug)]
pub struct Answer<R> {
    /// Pressure, unclamped [Pa].
    pub pressure: R,
    /// Temperature [K].
    pub temperature: R,
    /// Bulk sound speed [m/s].
    pub sound_speed: R,
    /// Share of liquid.
    pub liquid: R,
    /// Melting temperature [K], infinite where there is none.
    pub melting: R,
}
