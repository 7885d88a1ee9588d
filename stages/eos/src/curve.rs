//! Curves of any equation of state: the Hugoniot from the reference state, isentropes, release to zero pressure.
use crate::{Eos, Phase};
use hvi_kit::math::bisect;

/// A shocked state, reached from the reference state at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shock {
    /// Specific volume [m3/kg].
    pub volume: f64,
    /// Specific energy [J/kg].
    pub energy: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Particle velocity u_p [m/s].
    pub particle_velocity: f64,
    /// Shock velocity U_s [m/s].
    pub shock_velocity: f64,
    /// Regime.
    pub phase: Phase,
    /// Share of liquid, 0..1.
    pub liquid: f64,
}

/// A state released along its isentrope to zero pressure at a free surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    /// Specific volume [m3/kg].
    pub volume: f64,
    /// Residual energy [J/kg].
    pub energy: f64,
    /// Residual temperature [K].
    pub temperature: f64,
    /// Regime.
    pub phase: Phase,
    /// Share of liquid, 0..1.
    pub liquid: f64,
    /// Velocity of the free surface [m/s]: the particle velocity plus the Riemann integral of the release.
    pub free_surface_velocity: f64,
}

/// A point asked for that isn't on the curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{curve} of the {model} equation of state: {why}")]
pub struct CurveError {
    /// The curve.
    pub curve: &'static str,
    /// The model.
    pub model: &'static str,
    /// What was asked for and what there is, with units.
    pub why: String,
}

/// Steps of the release isentrope.
const RELEASE_STEPS: usize = 4000;

impl Eos {
    /// The state behind a shock that compresses the reference state to `volume` [m3/kg].
    ///
    /// Solves `E - E_ref = (P + P_ref) (V_ref - V) / 2`.
    ///
    /// # Errors
    /// [`CurveError`] where `volume` isn't below the reference volume, or no shock reaches it.
    pub fn hugoniot(&self, volume: f64) -> Result<Shock, CurveError> {
        let start = self.reference_volume();
        let fail = |why| CurveError { curve: "Hugoniot", model: self.name(), why };
        if !(volume > 0.0 && volume <= start) {
            return Err(fail(format!("no shock leads from {start:e} m3/kg to {volume:e} m3/kg")));
        }
        let e0 = self.energy_at(start, self.reference_temperature());
        let p0 = self.point(start, e0).pressure;
        let work = 0.5 * (start - volume);
        let excess = |e: f64| e - e0 - work * (self.point(volume, e).pressure + p0);
        let mut top = e0 + work * (self.point(volume, e0).pressure + p0).abs() + 1.0;
        for _ in 0..60 {
            if excess(top) >= 0.0 {
                break;
            }
            top = e0 + 2.0 * (top - e0);
        }
        let energy = bisect(e0, top, 1e-15 * top.abs(), excess)
            .ok_or_else(|| fail(format!("no shock reaches {volume:e} m3/kg: it is past the limit of compression")))?;
        let at = self.point(volume, energy);
        let rise = (at.pressure - p0).max(0.0);
        let particle_velocity = (rise * (start - volume)).sqrt();
        let shock_velocity =
            if start > volume { start * (rise / (start - volume)).sqrt() } else { self.point(start, e0).sound_speed };
        Ok(Shock {
            volume,
            energy,
            pressure: at.pressure,
            temperature: at.temperature,
            particle_velocity,
            shock_velocity,
            phase: at.phase,
            liquid: at.liquid,
        })
    }

    /// The state behind a shock with `particle_velocity` u_p [m/s] into the reference state at rest.
    ///
    /// # Errors
    /// [`CurveError`] where the velocity is beyond the model's range.
    pub fn hugoniot_at_velocity(&self, particle_velocity: f64) -> Result<Shock, CurveError> {
        self.hugoniot_where("particle velocity", "m/s", particle_velocity, |s| s.particle_velocity)
    }

    /// The state behind a shock to `pressure` [Pa].
    ///
    /// # Errors
    /// [`CurveError`] where the pressure is beyond the model's range.
    pub fn hugoniot_at_pressure(&self, pressure: f64) -> Result<Shock, CurveError> {
        self.hugoniot_where("pressure", "Pa", pressure, |s| s.pressure)
    }

    fn hugoniot_where(
        &self,
        what: &str,
        unit: &str,
        wanted: f64,
        measure: fn(&Shock) -> f64,
    ) -> Result<Shock, CurveError> {
        let start = self.reference_volume();
        // Past the limit of compression no shock arrives: anything wanted lies below it in compression.
        let above = |v: f64| self.hugoniot(v).map_or(1.0, |s| measure(&s) - wanted);
        // metals first; gases of a gamma near 1 compress to less than a fifth
        let search = |from: f64, to: f64| bisect(from * start, to * start, 1e-15 * start, above);
        let volume = search(0.2, 1.0).or_else(|| search(1e-3, 0.2)).ok_or_else(|| CurveError {
            curve: "Hugoniot",
            model: self.name(),
            why: format!("{what} {wanted:e} {unit} is not between the reference state and the limit of compression"),
        })?;
        self.hugoniot(volume)
    }

    /// Energy [J/kg] on the isentrope through (`volume`, `energy`) at volume `to` [m3/kg]: dE/dV = -P, in `steps` steps of
    /// the classical fourth-order Runge-Kutta rule.
    pub fn isentrope(&self, volume: f64, energy: f64, to: f64, steps: usize) -> f64 {
        let h = (to - volume) / steps as f64;
        (0..steps).fold(energy, |e, i| self.isentropic_step(volume + i as f64 * h, e, h))
    }

    fn isentropic_step(&self, v: f64, e: f64, h: f64) -> f64 {
        let slope = |v: f64, e: f64| -self.point(v, e).pressure;
        let k1 = slope(v, e);
        let k2 = slope(v + 0.5 * h, e + 0.5 * h * k1);
        let k3 = slope(v + 0.5 * h, e + 0.5 * h * k2);
        let k4 = slope(v + h, e + h * k3);
        e + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    }

    /// Release of a shocked state along its isentrope to zero pressure.
    ///
    /// # Errors
    /// [`CurveError`] where the pressure stays positive up to 100 reference volumes (a gas).
    pub fn release(&self, from: &Shock) -> Result<Release, CurveError> {
        let mut h = (1.1 * self.reference_volume() - from.volume) / RELEASE_STEPS as f64;
        let (mut v, mut e, mut u) = (from.volume, from.energy, from.particle_velocity);
        let mut p = from.pressure;
        while p > 0.0 {
            if v > 100.0 * self.reference_volume() {
                let why = format!("release from {:e} Pa does not reach zero pressure", from.pressure);
                return Err(CurveError { curve: "isentrope", model: self.name(), why });
            }
            let next = self.isentropic_step(v, e, h);
            let mut reached = (v + h, next, self.point(v + h, next).pressure);
            if reached.2 < 0.0 {
                let end = |f: f64| self.point(v + f * h, self.isentropic_step(v, e, f * h)).pressure;
                let f = bisect(0.0, 1.0, 1e-12, end).unwrap_or(0.0);
                reached = (v + f * h, self.isentropic_step(v, e, f * h), 0.0);
            }
            u += ((p - reached.2).max(0.0) * (reached.0 - v)).sqrt();
            (v, e, p) = reached;
            // The far tail of a hot release needs no fine steps.
            if v > 1.6 * self.reference_volume() {
                h *= 1.001;
            }
        }
        let at = self.point(v, e);
        Ok(Release {
            volume: v,
            energy: e,
            temperature: at.temperature,
            phase: at.phase,
            liquid: at.liquid,
            free_surface_velocity: u,
        })
    }
}
