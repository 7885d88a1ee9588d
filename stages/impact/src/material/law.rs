//! What a particle's matter does in one step: viscosity, half-step stress, volume, strength, energy, equation of state; for one
//! particle or eight of the same law.
use super::isotherm::Isotherm;
use super::released::Released;
use super::terms::{Gain, HalfStep};
use super::{Damage, JohnsonCook, Material};
use crate::particle::{Matter, Particle};
use crate::tensor::{self, Gradient, Symmetric};
use hvi_eos::Eos;
use hvi_kit::lanes::Real;

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
    pub(super) isotherm: Isotherm,
    /// Phases of matter that has parted.
    pub released: Released,
    pub(super) shear: Option<f64>,
    pub(super) johnson_cook: JohnsonCook,
    damage: Option<Damage>,
    pub(super) spall: Option<f64>,
    /// Volume at which the sound speed is taken at most [m3/kg]: the Mie-Grueneisen c grows with V without end.
    pub(super) widest: f64,
}

/// Linear and quadratic coefficients of artificial viscosity; small, since the narrower a shock's profile, the less heat it
/// leaves where it was born, and heat conduction (`conduction.rs`) damps its overshoot too. Then the Mach number of compression below which the linear
/// part fades: without the fading it takes 22 % of an acoustic wave in ten periods.
const LINEAR: f64 = 0.3;
const QUADRATIC: f64 = 0.7;
const FADE: f64 = 0.003;
/// Share of the velocity that the grid doesn't see that fades while sound crosses a cell, by the transfer AFLIP: with none a weak
/// shock leaves noise behind, with all of it in each step, which is APIC, what shears or spreads over few cells heats up.
const BACKGROUND: f64 = 0.3;
/// The same over the compression of a step.
const SHOCK: f64 = 20.0;

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
            isotherm: Isotherm::new(&eos),
            released: Released::new(&eos),
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
    pub fn viscosity<R: Real>(&self, m: &Matter<R>, divergence: R, cell: f64) -> R {
        let density = m.mass / (m.volume * m.ratio);
        let jump = Self::jump(m, divergence, cell);
        let linear = (jump / m.sound_speed.times(FADE)).at_most(1.0).times(LINEAR);
        density * jump * (jump.times(QUADRATIC) + linear * m.sound_speed)
    }

    /// Velocity over a cell [m/s] by which matter is compressed; nothing in expansion or across a void.
    #[inline(always)]
    fn jump<R: Real>(m: &Matter<R>, divergence: R, cell: f64) -> R {
        divergence.times(-cell).at_least(0.0) * (R::of(1.0) - m.open())
    }

    /// Whether matter is being compressed, as in a shock: from 0, rising over [`FADE`] as the linear viscosity does, to 1.
    #[inline(always)]
    pub fn compression<R: Real>(&self, m: &Matter<R>, divergence: R, cell: f64) -> R {
        (Self::jump(m, divergence, cell) / m.sound_speed.times(FADE)).at_most(1.0)
    }

    /// Rate at which matter is compressed beyond that of a sound wave, in which the linear viscosity fades too [1/s], or 0; counted
    /// by the divergence of its last step.
    #[inline(always)]
    pub fn shocked<R: Real>(m: &Matter<R>, cell: f64) -> R {
        (R::of(0.0) - m.divergence - m.sound_speed.times(FADE / cell)).at_least(0.0)
    }

    /// Share of its velocity apart from the grid's that a particle loses in a step of `dt` [s] by the transfer AFLIP: the more the faster
    /// matter is compressed, and everywhere so that what the grid doesn't see fades while sound crosses some cells.
    #[inline(always)]
    pub fn damping<R: Real>(&self, m: &Matter<R>, divergence: R, dt: f64, cell: f64) -> R {
        let crossing = m.sound_speed.times(dt / cell);
        let compression = (divergence.times(-dt) - crossing.times(FADE)).at_least(0.0) * (R::of(1.0) - m.open());
        (crossing.times(BACKGROUND) + compression.times(SHOCK)).at_most(1.0)
    }

    /// Speed that the time step must resolve: `Q + sqrt(Q^2 + c^2)` [m/s] with the viscosity's own speed Q.
    #[inline(always)]
    pub fn signal_speed<R: Real>(sound_speed: R, divergence: R, cell: f64) -> R {
        let q = sound_speed.times(LINEAR) - divergence.times(QUADRATIC * cell);
        let q = q.where_less(divergence, R::of(0.0), R::of(0.0));
        q + (q * q + sound_speed * sound_speed).root()
    }

    /// Coefficient of the impact speed in the first steps' time step, when the divergence isn't known yet.
    pub const CONTACT: f64 = 2.0;

    /// Stress at the middle of a step of `dt` [s] under velocity gradient `l` [1/s].
    #[inline(always)]
    pub fn half_step<R: Real>(&self, m: &Matter<R>, l: &Gradient<R>, dt: f64, cell: f64) -> HalfStep<R> {
        let divergence = tensor::trace(l);
        let strain = divergence.times(0.5 * dt);
        let (zero, closed) = (R::of(0.0), R::of(1.0) - m.open());
        let predicted = m.unclamped - m.stiffness * strain.at_least(LEAST_STRAIN);
        HalfStep {
            pressure: predicted.max(zero - self.tension_limit(m)) * closed,
            viscous: self.viscosity(m, divergence, cell),
            deviator: self.half_deviator(m, l, dt),
            limited: self.limited(m, divergence, dt),
        }
    }

    /// 1 where the volume strain to the middle of a step of `dt` [s] is more than may be, else 0.
    #[inline(always)]
    pub fn limited<R: Real>(&self, m: &Matter<R>, divergence: R, dt: f64) -> R {
        (R::of(1.0) - m.open()).where_less(divergence.times(0.5 * dt), R::of(LEAST_STRAIN), R::of(0.0))
    }

    /// Stress as `m` has it, and the viscosity at velocity gradient `l` [1/s].
    #[inline(always)]
    pub fn standing<R: Real>(&self, m: &Matter<R>, l: &Gradient<R>, cell: f64) -> HalfStep<R> {
        let viscous = self.viscosity(m, tensor::trace(l), cell);
        HalfStep { pressure: m.pressure(), viscous, deviator: m.stress, limited: R::of(0.0) }
    }

    /// Largest tension carried [Pa].
    #[inline(always)]
    pub fn tension_limit<R: Real>(&self, m: &Matter<R>) -> R {
        let limit = match self.spall {
            Some(limit) => (R::of(1.0) - m.homologous.at_least(0.0).at_most(1.0)).times(limit),
            None => R::of(f64::INFINITY),
        };
        limit.where_less(m.damage, R::of(1.0), R::of(0.0))
    }

    #[inline(always)]
    fn half_deviator<R: Real>(&self, m: &Matter<R>, l: &Gradient<R>, dt: f64) -> Symmetric<R> {
        let zero = R::of(0.0);
        let mut s = [zero; 6];
        if let Some(shear) = self.shear {
            s = tensor::elastic_trial(&m.stress, l, 0.5 * dt, shear);
            let trial = tensor::equivalent(&s);
            let most = m.yield_stress().max(tensor::equivalent(&m.stress));
            let kept = (most / trial).where_less(most, trial, R::of(1.0)).where_less(zero, m.softening, zero);
            for x in &mut s {
                *x = *x * kept;
            }
        }
        s
    }

    /// Carries `p` through a step of `dt` under the mean velocity gradient `l`, doing the work of `stress` over the
    /// volume at its start, and taking up `heat` [J] of the transfer.
    pub fn advance<const D: usize>(
        &self,
        p: &mut Particle<D>,
        stress: &HalfStep<f64>,
        l: &Gradient<f64>,
        heat: f64,
        dt: f64,
    ) -> Gain<f64> {
        let gain = Self::work(p, stress, l, heat, dt);
        self.deform(p, l, dt);
        self.evaluate(p);
        gain
    }

    /// Books the work of `stress` over the volume `m` has, under the mean velocity gradient `l`, and `heat` [J].
    #[inline(always)]
    pub fn work<R: Real>(m: &mut Matter<R>, stress: &HalfStep<R>, l: &Gradient<R>, heat: R, dt: f64) -> Gain<R> {
        let divergence = tensor::trace(l);
        let work = (m.volume * m.ratio).times(dt);
        let viscous = work * stress.viscous * (R::of(0.0) - divergence);
        let power = tensor::contract(&stress.deviator, l) - (stress.pressure + stress.viscous) * divergence;
        m.energy = m.energy + (work * power + heat) / m.mass;
        let floored = (R::of(0.0) - m.energy * m.mass).at_least(0.0);
        m.energy = m.energy.at_least(0.0).where_less(m.energy, R::of(f64::INFINITY), m.energy);
        Gain { floored, viscous }
    }

    /// Volume, deviator and damage under velocity gradient `l` [1/s]; returns 1 where the volume change was limited, else 0.
    #[inline(always)]
    pub fn deform<R: Real>(&self, m: &mut Matter<R>, l: &Gradient<R>, dt: f64) -> R {
        m.divergence = tensor::trace(l);
        let stretch = tensor::determinant(l, dt);
        let half = R::of(0.5);
        m.ratio = (m.ratio * half.where_less(stretch, half, stretch)).min(R::of(DUST));
        self.strain(m, l, dt);
        R::of(1.0).where_less(stretch, half, R::of(0.0))
    }

    /// Elastic trial, radial return, damage.
    #[inline(always)]
    fn strain<R: Real>(&self, m: &mut Matter<R>, l: &Gradient<R>, dt: f64) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let Some(shear) = self.shear.filter(|_| zero.any_less(m.softening)) else {
            m.stress = [zero; 6];
            return;
        };
        let solid = one.where_less(zero, m.softening, zero);
        let mut s = tensor::elastic_trial(&m.stress, l, dt, shear);
        let trial = tensor::equivalent(&s);
        let first = m.yield_stress();
        // Never plastic where there is nothing to carry shear.
        let bar = first.where_less(zero, m.softening, R::of(f64::INFINITY));
        let mut left = solid;
        if bar.any_less(trial) {
            let jc = &self.johnson_cook;
            let (increment, hardened) =
                jc.plastic_increment(trial, m.plastic_strain, bar, dt, m.softening, shear, m.hardened);
            let increment = increment.where_less(bar, trial, zero);
            left = (one - increment.times(3.0 * shear) / trial.at_least(f64::MIN_POSITIVE)) * solid;
            m.plastic_strain = m.plastic_strain + increment;
            m.hardened = hardened;
            if let Some(damage) = &self.damage {
                let equivalent = (left * trial).max(trial.times(1e-6)).at_least(f64::MIN_POSITIVE);
                let rate = increment.times(1.0 / (dt * jc.rate.si()));
                let triaxiality = (zero - m.pressure()) / equivalent;
                m.damage = m.damage + damage.increment(increment, triaxiality, rate, m.homologous);
            }
        }
        for x in &mut s {
            *x = *x * left.at_least(0.0);
        }
        m.stress = s;
    }
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
            let l: Gradient<f64> =
                std::array::from_fn(|i| std::array::from_fn(|j| if i == j { -rate / 3.0 } else { 0.0 }));
            let (start, mut booked, mut expected, mut work) = (p.energy, 0.0, 0.0, 0.0);
            for _ in 0..500 {
                let c1 = 0.3 * (jump / (0.003 * p.sound_speed)).min(1.0);
                expected += dt * p.mass * jump * rate * (0.7 * jump + c1 * p.sound_speed);
                let stress = law.half_step(&p, &l, dt, cell);
                work += dt * p.volume * p.ratio * stress.pressure * rate;
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
                !held.failed()
                    && held.pressure() < 0.0
                    && (law.tension_limit(&held) / (limit * strength) - 1.0).abs() < 1e-6
            );
            assert!(failed.failed() && failed.pressure() == 0.0 && law.tension_limit(&failed) == 0.0);
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
            assert_eq!(stress.limited != 0.0, even, "{strain}");
            let whole = law.deform(&mut p.matter, &l, 1.0);
            assert_eq!(stress.limited.max(whole) != 0.0, counted, "{strain}");
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
            let deviator = law.half_deviator(&p, &l, dt);
            let stress = HalfStep { pressure: 0.0, viscous: 0.0, deviator, limited: 0.0 };
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
