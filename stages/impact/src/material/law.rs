//! What a particle's matter does in one step: viscosity, half-step stress, volume, strength, energy, equation of state.
use super::{Damage, JohnsonCook, Material};
use crate::particle::Particle;
use crate::tensor::{self, Gradient, Symmetric};
use hvi_eos::{Eos, Phase};

/// Which parts of the material model act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// Shear stress at all; without it matter is a fluid.
    pub strength: bool,
    /// Johnson-Cook damage.
    pub damage: bool,
    /// Tension cut-off with void opening.
    pub spall: bool,
}

/// A material ready to be evaluated: SI numbers, switched parts left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// Equation of state.
    pub eos: Eos,
    shear: Option<f64>,
    johnson_cook: JohnsonCook,
    damage: Option<Damage>,
    spall: Option<f64>,
    /// Volume at which the sound speed is taken at most [m3/kg]: the Mie-Grueneisen c grows with V without end.
    widest: f64,
}

/// Stress that acts through a step, taken at its middle.
#[derive(Clone, Copy, Debug, Default)]
pub struct HalfStep {
    /// Pressure and artificial viscosity [Pa].
    pub pressure: f64,
    /// The artificial viscosity in it [Pa].
    pub viscous: f64,
    /// Deviator [Pa].
    pub deviator: Symmetric,
    /// Whether the volume change to the middle had to be limited.
    pub limited: bool,
}

/// What one update of one particle adds to the run's accounts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Booked {
    /// Energy put in to lift a negative internal energy to zero [J].
    pub floored: f64,
    /// Heat made by artificial viscosity [J].
    pub viscous: f64,
    /// Whether the volume change had to be limited.
    pub limited: bool,
}

/// Linear and quadratic coefficients of artificial viscosity; small, since the narrower a shock's profile, the less heat it
/// leaves where it was born, and heat conduction (`conduction.rs`) damps its overshoot too. Then the Mach number of compression below which the linear
/// part fades: without the fading it takes 22 % of an acoustic wave in ten periods.
const LINEAR: f64 = 0.3;
const QUADRATIC: f64 = 0.7;
const FADE: f64 = 0.003;

/// Volume over initial volume beyond which a particle's volume counts no further: matter so thin exerts no pressure, but
/// the affine fields of a few particles flying side by side would go on to inflate it.
const DUST: f64 = 1e6;

/// Least volume strain to the middle of a step that the pressure there is extrapolated by.
const LEAST_STRAIN: f64 = -0.3;

impl Law {
    /// The law of `material` with `eos`.
    pub fn new(material: &Material, eos: Eos, on: Switches) -> Law {
        let widest = match &eos {
            Eos::MieGruneisen(_) => 1.2 * eos.reference_volume(),
            _ => f64::INFINITY,
        };
        Law {
            eos,
            shear: on.strength.then(|| material.shear()),
            johnson_cook: material.strength.clone(),
            damage: material.damage.clone().filter(|_| on.strength && on.damage),
            spall: material.spall.map(|p| p.si()).filter(|_| on.spall),
            widest,
        }
    }

    /// Fills in the state of matter at its initial volume and the reference temperature.
    pub fn prepare<const D: usize>(&self, p: &mut Particle<D>) {
        let volume = self.eos.reference_volume();
        p.energy = self.eos.energy_at(volume, self.eos.reference_temperature()).max(0.0);
        p.hardened = self.johnson_cook.hardened(p.plastic_strain);
        self.evaluate(p);
    }

    /// Artificial viscosity q [Pa] at velocity divergence `divergence` [1/s]: nothing in expansion or across a void.
    #[inline(always)]
    fn viscosity<const D: usize>(&self, p: &Particle<D>, divergence: f64, cell: f64) -> f64 {
        if divergence >= 0.0 || p.is_open() {
            return 0.0;
        }
        let density = p.mass / (p.volume * p.ratio);
        let jump = -divergence * cell;
        let linear = LINEAR * (jump / (FADE * p.sound_speed)).min(1.0);
        density * jump * (QUADRATIC * jump + linear * p.sound_speed)
    }

    /// Speed that the time step must resolve: `Q + sqrt(Q^2 + c^2)` [m/s] with the viscosity's own speed Q.
    #[inline(always)]
    pub fn signal_speed<const D: usize>(p: &Particle<D>, cell: f64) -> f64 {
        let q = if p.divergence < 0.0 { LINEAR * p.sound_speed - QUADRATIC * cell * p.divergence } else { 0.0 };
        q + (q * q + p.sound_speed * p.sound_speed).sqrt()
    }

    /// Coefficient of the impact speed in the first steps' time step, when the divergence isn't known yet.
    pub const CONTACT: f64 = 2.0;

    /// Stress at the middle of a step of `dt` [s] under velocity gradient `l` [1/s].
    #[inline(always)]
    pub fn half_step<const D: usize>(&self, p: &Particle<D>, l: &Gradient, dt: f64, cell: f64) -> HalfStep {
        let divergence = tensor::trace(l);
        let viscous = self.viscosity(p, divergence, cell);
        let strain = 0.5 * dt * divergence;
        let limited = strain < LEAST_STRAIN && !p.is_open();
        let pressure = if p.is_open() {
            0.0
        } else {
            (p.unclamped - p.stiffness * strain.max(LEAST_STRAIN)).max(-p.tension_limit)
        };
        HalfStep { pressure: pressure + viscous, viscous, deviator: self.half_deviator(p, l, dt), limited }
    }

    /// Stress as `p` has it, and the viscosity at velocity gradient `l` [1/s].
    #[inline(always)]
    pub fn standing<const D: usize>(&self, p: &Particle<D>, l: &Gradient, cell: f64) -> HalfStep {
        let viscous = self.viscosity(p, tensor::trace(l), cell);
        HalfStep { pressure: p.pressure + viscous, viscous, deviator: p.stress, limited: false }
    }

    #[inline(always)]
    fn half_deviator<const D: usize>(&self, p: &Particle<D>, l: &Gradient, dt: f64) -> Symmetric {
        let Some(shear) = self.shear.filter(|_| p.softening > 0.0) else {
            return [0.0; 6];
        };
        let mut s = tensor::elastic_trial(&p.stress, l, 0.5 * dt, shear);
        let trial = tensor::equivalent(&s);
        if trial > p.yield_stress {
            let most = p.yield_stress.max(tensor::equivalent(&p.stress));
            if trial > most {
                s.iter_mut().for_each(|x| *x *= most / trial);
            }
        }
        s
    }

    /// Carries `p` through a step of `dt` under the mean velocity gradient `l`, doing the work of `stress` over the
    /// volume at its start, and taking up `heat` [J] of the transfer.
    #[inline(always)]
    pub fn advance<const D: usize>(
        &self,
        p: &mut Particle<D>,
        stress: &HalfStep,
        l: &Gradient,
        heat: f64,
        dt: f64,
    ) -> Booked {
        let mut booked = Self::work(p, stress, l, heat, dt);
        booked.limited = self.deform(p, l, dt) || stress.limited;
        self.evaluate(p);
        booked
    }

    /// Books the work of `stress` over the volume `p` has, under the mean velocity gradient `l`, and `heat` [J].
    #[inline(always)]
    pub fn work<const D: usize>(p: &mut Particle<D>, stress: &HalfStep, l: &Gradient, heat: f64, dt: f64) -> Booked {
        let mut booked = Booked::default();
        let divergence = tensor::trace(l);
        let work = dt * p.volume * p.ratio;
        booked.viscous = -work * stress.viscous * divergence;
        let power = tensor::contract(&stress.deviator, l) - stress.pressure * divergence;
        booked.floored = add_heat(p, work * power + heat);
        booked
    }

    /// Volume, deviator and damage under velocity gradient `l` [1/s]; returns whether the volume change was limited.
    #[inline(always)]
    pub fn deform<const D: usize>(&self, p: &mut Particle<D>, l: &Gradient, dt: f64) -> bool {
        p.divergence = tensor::trace(l);
        let stretch = tensor::determinant(l, dt);
        p.ratio = (p.ratio * if stretch < 0.5 { 0.5 } else { stretch }).min(DUST);
        self.strain(p, l, dt);
        stretch < 0.5
    }

    /// Lets `p`, alone in space, keep its state; `heat` [J] of the transfer is no more than rounding.
    pub fn fly<const D: usize>(p: &mut Particle<D>, heat: f64) -> Booked {
        p.divergence = 0.0;
        Booked { floored: add_heat(p, heat), ..Booked::default() }
    }

    /// Elastic trial, radial return, damage.
    #[inline(always)]
    fn strain<const D: usize>(&self, p: &mut Particle<D>, l: &Gradient, dt: f64) {
        let Some(shear) = self.shear.filter(|_| p.softening > 0.0) else {
            p.stress = [0.0; 6];
            return;
        };
        p.stress = tensor::elastic_trial(&p.stress, l, dt, shear);
        let trial = tensor::equivalent(&p.stress);
        if trial <= p.yield_stress {
            return;
        }
        let jc = &self.johnson_cook;
        let increment = jc.plastic_increment(trial, p.plastic_strain, p.yield_stress, dt, p.softening, shear);
        let left = 1.0 - 3.0 * shear * increment / trial;
        p.stress.iter_mut().for_each(|x| *x *= left.max(0.0));
        p.plastic_strain += increment;
        p.hardened = jc.hardened(p.plastic_strain);
        if let Some(damage) = &self.damage {
            let equivalent = (left * trial).max(1e-6 * trial);
            let homologous = jc.homologous(p.temperature, self.melting_temperature(p));
            let rate = increment / (dt * jc.rate.si());
            p.damage += damage.increment(increment, -p.pressure / equivalent, rate, homologous);
            p.failed |= p.damage >= 1.0;
        }
    }

    /// Energy above that of the reference temperature at the same volume [J/kg]: heat that may flow, without the energy of
    /// compression.
    pub fn thermal_energy<const D: usize>(&self, p: &Particle<D>) -> f64 {
        p.energy - self.eos.energy_at(self.specific_volume(p), self.eos.reference_temperature())
    }

    /// Specific volume [m3/kg].
    #[inline(always)]
    fn specific_volume<const D: usize>(&self, p: &Particle<D>) -> f64 {
        self.eos.reference_volume() * p.ratio
    }

    #[inline(always)]
    fn melting_temperature<const D: usize>(&self, p: &Particle<D>) -> f64 {
        let own = self.eos.melting_temperature(self.specific_volume(p));
        own.unwrap_or(self.johnson_cook.melting_temperature.si())
    }

    /// Pressure, temperature, sound speed, spall, and what strength needs of them.
    #[inline(always)]
    pub fn evaluate<const D: usize>(&self, p: &mut Particle<D>) {
        let volume = self.specific_volume(p);
        let point = self.eos.point(volume, p.energy);
        let bulk =
            if volume > self.widest { self.eos.point(self.widest, p.energy).sound_speed } else { point.sound_speed };
        p.temperature = point.temperature;
        p.unclamped = point.pressure;
        p.pressure = point.pressure;
        let molten = matches!(point.phase, Phase::Liquid | Phase::HotLiquid | Phase::Vapour) || point.liquid > 0.5;
        let heeds_melting = self.spall.is_some() || (self.shear.is_some() && !p.failed);
        let homologous = if molten {
            1.0
        } else if heeds_melting {
            self.johnson_cook.homologous(p.temperature, self.melting_temperature(p))
        } else {
            0.0
        };
        if let Some(limit) = self.spall {
            p.tension_limit = if p.failed { 0.0 } else { limit * (1.0 - homologous.clamp(0.0, 1.0)) };
            if p.pressure < -p.tension_limit {
                p.failed = true;
                p.tension_limit = 0.0;
            }
        }
        if p.failed {
            p.pressure = p.pressure.max(0.0);
            p.tension_limit = 0.0;
        }
        p.stiffness = if p.is_open() { 0.0 } else { bulk * bulk / volume };
        p.softening = if p.failed || self.shear.is_none() { 0.0 } else { self.johnson_cook.softening(homologous) };
        p.yield_stress = p.hardened * p.softening;
        // Only what can carry shear: a vapour's V would make any shear term swallow the time step.
        let shear = self.shear.filter(|_| p.softening > 0.0).unwrap_or(0.0);
        p.sound_speed = (bulk * bulk + 4.0 / 3.0 * shear * volume.min(self.widest)).sqrt();
    }
}

/// Adds `heat` [J]; returns what had to be put in [J] for the energy not to be negative.
#[inline(always)]
fn add_heat<const D: usize>(p: &mut Particle<D>, heat: f64) -> f64 {
    p.energy += heat / p.mass;
    let lacking = (-p.energy * p.mass).max(0.0);
    p.energy = p.energy.max(0.0);
    lacking
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adiabatic simple shear at 1e4 per second to a strain of 1, one particle, against its own equation
    /// `rho de/dt = Y(ep, rate, T(e)) rate` of a rigid-plastic body. The shear modulus is 1e4 times copper's here, so that
    /// the elastic strain, Y / (3 G), is 3e-7. The step is of first order: what is left after extrapolating two step
    /// sizes must be within 1e-6.
    #[test]
    fn adiabatic_shear_follows_its_equation() {
        let mut material = Material::named("copper").unwrap();
        material.young = hvi_kit::units::Pressure::new(1e4 * material.young.si());
        let law = Law::new(&material, material.eos.clone(), Switches { strength: true, damage: false, spall: false });
        let errors = [20_000, 40_000].map(|steps| {
            let p = shear(&law, 1e4, steps);
            let (e, y) = ode(&law, &material, 1e4, p.plastic_strain);
            [p.energy / e - 1.0, tensor::equivalent(&p.stress) / y - 1.0]
        });
        for k in 0..2 {
            let (coarse, fine) = (errors[0][k], errors[1][k]);
            assert!(fine.abs() < 2e-5 && (2.0 * fine - coarse).abs() < 1e-6, "{k}: {coarse:e}, {fine:e}");
        }
    }

    /// Uniform compression at a constant rate: the heat of viscosity is `integral q V |div| dt`, in which `rho V` is the mass,
    /// so `m dx |div| (c2 dx |div| + c1' c)`; energy rises by it and by the half-step pressure's work, to rounding.
    /// Expansion makes none.
    #[test]
    fn viscous_heat_is_its_integral() {
        let material = Material::named("aluminium").unwrap();
        let law = Law::new(&material, material.eos.clone(), Switches { strength: true, damage: false, spall: true });
        // A jump of 10 m/s a cell is in the part of the linear term that fades, 300 m/s beyond it.
        let cell = 1e-3;
        for jump in [10.0, 300.0] {
            let mut p = prepared(&law);
            let (rate, dt) = (jump / cell, 1e-9);
            let l: Gradient = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { -rate / 3.0 } else { 0.0 }));
            let (start, mut booked, mut expected, mut work) = (p.energy, 0.0, 0.0, 0.0);
            for _ in 0..500 {
                let c1 = 0.3 * (jump / (0.003 * p.sound_speed)).min(1.0);
                expected += dt * p.mass * jump * rate * (0.7 * jump + c1 * p.sound_speed);
                let stress = law.half_step(&p, &l, dt, cell);
                work += dt * p.volume * p.ratio * (stress.pressure - stress.viscous) * rate;
                booked += law.advance(&mut p, &stress, &l, 0.0, dt).viscous;
            }
            assert!((booked / expected - 1.0).abs() < 1e-12, "{jump}: {booked} J, expected {expected} J");
            assert!((p.mass * (p.energy - start) / (work + expected) - 1.0).abs() < 1e-9, "{jump}");
            let outward = l.map(|row| row.map(|x| -x));
            let stress = law.half_step(&p, &outward, dt, cell);
            assert_eq!((stress.viscous, law.advance(&mut p, &stress, &outward, 0.0, dt).viscous), (0.0, 0.0));
        }
    }

    /// Plastic shear under tension beyond s* = 1.5 damages as `1 / ((D1 + D2 exp(1.5 D3)) (1 + D4 ln rate))` a strain (T* is
    /// within .01 of 0: 1.2 % of D5's factor); under compression beyond s* = -3 less than a thousandth of it.
    #[test]
    fn tension_damages() {
        let material = Material::named("copper").unwrap();
        let law = Law::new(&material, material.eos.clone(), Switches { strength: true, damage: true, spall: false });
        let d = material.damage.clone().unwrap();
        let rate = 1e4;
        let damage = |ratio: f64| {
            let mut p = prepared(&law);
            p.ratio = ratio;
            law.evaluate(&mut p);
            let l = [[0.0, rate * 3f64.sqrt(), 0.0], [0.0; 3], [0.0; 3]];
            for _ in 0..100 {
                let stress = law.half_step(&p, &l, 1e-8, 1e-3);
                law.advance(&mut p, &stress, &l, 0.0, 1e-8);
            }
            assert!(p.plastic_strain > 5e-3);
            p.damage / p.plastic_strain
        };
        let (tension, compression) = (damage(1.01), damage(0.98));
        let known = 1.0 / ((d.d1 + d.d2 * hvi_kit::math::exp(1.5 * d.d3)) * (1.0 + d.d4 * hvi_kit::math::log(rate)));
        assert!((tension / known - 1.0).abs() < 0.012, "{tension} {known}");
        assert!(compression < 1e-3 * tension, "{compression} {tension}");
    }

    /// Halfway to melting (T* = .5) half the tension is carried: at .45 of the room's spall strength matter holds, at .55 it
    /// fails; at room temperature it holds .95 and fails at 1.05.
    #[test]
    fn warm_matter_spalls_earlier() {
        let material = Material::named("copper").unwrap();
        let law = Law::new(&material, material.eos.clone(), Switches { strength: true, damage: true, spall: true });
        let (strength, room) = (material.spall.unwrap().si(), material.strength.reference_temperature.si());
        let volume = law.eos.reference_volume();
        let pulled = |homologous: f64, share: f64| {
            let mut p = prepared(&law);
            let (mut low, mut high) = (1.0, 1.1);
            for _ in 0..60 {
                let ratio = 0.5 * (low + high);
                let melting = law.eos.melting_temperature(ratio * volume).expect("GRAY melts");
                let energy = law.eos.energy_at(ratio * volume, room + homologous * (melting - room));
                (p.ratio, p.energy) = (ratio, energy);
                if law.eos.point(ratio * volume, energy).pressure > -share * strength {
                    low = ratio
                } else {
                    high = ratio
                }
            }
            law.evaluate(&mut p);
            assert!((p.unclamped / (share * strength) + 1.0).abs() < 1e-9, "{} Pa", p.unclamped);
            p
        };
        for (homologous, limit) in [(0.0, 1.0), (0.5, 0.5)] {
            let (held, failed) = (pulled(homologous, limit - 0.05), pulled(homologous, limit + 0.05));
            assert!(
                !held.failed && held.pressure < 0.0 && (held.tension_limit / (limit * strength) - 1.0).abs() < 1e-6
            );
            assert!(failed.failed && failed.pressure == 0.0 && failed.tension_limit == 0.0);
        }
    }

    /// A volume limited in half a step (strain below -.3) or in the whole (below a half) is counted.
    #[test]
    fn limits_are_counted() {
        let material = Material::named("copper").unwrap();
        let law = Law::new(&material, material.eos.clone(), Switches { strength: false, damage: false, spall: false });
        // .45 and .55 along one axis; .61 spread evenly leaves (1 - .61/3)^3 = .506, above a half.
        for (strain, even, counted) in [(0.45, false, false), (0.61, true, true), (0.55, false, true)] {
            let mut p = prepared(&law);
            let mut l = [[0.0; 3]; 3];
            l[0][0] = -strain / if even { 3.0 } else { 1.0 };
            if even {
                (l[1][1], l[2][2]) = (l[0][0], l[0][0]);
            }
            let stress = law.half_step(&p, &l, 1.0, 1e-3);
            assert_eq!(stress.limited, even, "{strain}");
            assert_eq!(law.advance(&mut p, &stress, &l, 0.0, 1.0).limited, counted, "{strain}");
        }
    }

    /// A cubic millimetre at rest.
    fn prepared(law: &Law) -> Particle<3> {
        let mut p = Particle::new([0.0; 3], [0.0; 3], 1e-9 / law.eos.reference_volume(), 1e-9, 0, 0);
        law.prepare(&mut p);
        p
    }

    /// A particle after simple shear to an equivalent strain of 1 at `rate` [1/s].
    fn shear(law: &Law, rate: f64, steps: usize) -> Particle<3> {
        let mut p = prepared(law);
        let dt = 1.0 / rate / steps as f64;
        let l = [[0.0, rate * 3f64.sqrt(), 0.0], [0.0; 3], [0.0; 3]];
        for _ in 0..steps {
            let stress = HalfStep { deviator: law.half_deviator(&p, &l, dt), ..HalfStep::default() };
            law.advance(&mut p, &stress, &l, 0.0, dt);
        }
        p
    }

    /// Energy [J/kg] and flow stress [Pa] after plastic strain `to`, by the fourth-order Runge-Kutta rule over strain^n.
    fn ode(law: &Law, material: &Material, rate: f64, to: f64) -> (f64, f64) {
        let jc = &material.strength;
        let volume = law.eos.reference_volume();
        let melting = law.eos.melting_temperature(volume).expect("GRAY melts");
        let flow = |strain: f64, e: f64| {
            let t = law.eos.point(volume, e).temperature;
            jc.flow_stress(strain, rate, jc.softening(jc.homologous(t, melting)))
        };
        // With z = strain^n the right-hand side is smooth at 0: d strain = (strain / (n z)) dz.
        let strain = |z: f64| hvi_kit::math::pow(z, 1.0 / jc.n);
        let slope = |z: f64, e: f64| if z == 0.0 { 0.0 } else { flow(strain(z), e) * volume * strain(z) / (jc.n * z) };
        let steps = 4000;
        let h = hvi_kit::math::pow(to, jc.n) / steps as f64;
        let mut e = 0.0;
        for i in 0..steps {
            let z = i as f64 * h;
            let k1 = slope(z, e);
            let k2 = slope(z + 0.5 * h, e + 0.5 * h * k1);
            let k3 = slope(z + 0.5 * h, e + 0.5 * h * k2);
            let k4 = slope(z + h, e + h * k3);
            e += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        }
        (e, flow(to, e))
    }
}
