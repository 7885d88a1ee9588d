//! One particle of matter: Johnson-Cook against its own equation, its limits, and the equations of state far from home.
use super::Row;
use crate::common;
use hvi_eos::Eos;
use hvi_impact::material::{Law, Material};
use hvi_impact::particle::Particle;
use hvi_kit::math::pow;
use hvi_kit::units::Pressure;

/// Adiabatic simple shear at 1e4 a second to a strain of 1 against `rho de/dt = Y(ep, rate, T(e)) rate`, the same matter rigid
/// (1e4 times stiffer than copper, so that the elastic strain is 3e-7), in steps of 1e-10 s.
pub fn shear_rows() -> Vec<Row> {
    let mut copper = Material::named("copper").expect("shipped");
    copper.young = Pressure::new(1e4 * copper.young.si());
    let law = Law::new(&copper, copper.eos.clone(), super::solid::ON);
    let (rate, steps) = (1e4, 1_000_000);
    let mut p = Particle::<3>::new([0.0; 3], [0.0; 3], 1e-9 / law.eos.reference_volume(), 1e-9, 0, 0);
    law.prepare(&mut p);
    let dt = 1.0 / rate / steps as f64;
    let l = [[0.0, rate * 3f64.sqrt(), 0.0], [0.0; 3], [0.0; 3]];
    for _ in 0..steps {
        let stress = law.half_step(&p, &l, dt, 1e-3);
        law.advance(&mut p, &stress, &l, 0.0, dt);
    }
    let (energy, flow) = equation(&law, &copper, rate, p.plastic_strain);
    let s = p.stress;
    let equivalent =
        (1.5 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt();
    let case = "Johnson-Cook";
    vec![
        Row::most(
            case,
            "adiabatic shear at 1e4 1/s, steps of 1e-10 s: error of e",
            (p.energy / energy - 1.0).abs(),
            "",
            1e-6,
        ),
        Row::most(case, "the same: error of Y", (equivalent / flow - 1.0).abs(), "", 1e-6),
    ]
}

/// Energy [J/kg] and flow stress [Pa] after plastic strain `to`, by the fourth-order Runge-Kutta rule over z = strain^n, in which
/// the right-hand side is smooth at 0.
fn equation(law: &Law, material: &Material, rate: f64, to: f64) -> (f64, f64) {
    let jc = &material.strength;
    let volume = law.eos.reference_volume();
    let melting = law.eos.melting_temperature(volume).expect("GRAY melts");
    let flow = |strain: f64, e: f64| {
        let t = law.eos.point(volume, e).temperature;
        jc.flow_stress(strain, rate, jc.softening(jc.homologous(t, melting)))
    };
    let strain = |z: f64| pow(z, 1.0 / jc.n);
    let slope = |z: f64, e: f64| if z == 0.0 { 0.0 } else { flow(strain(z), e) * volume * strain(z) / (jc.n * z) };
    let steps = 4000;
    let h = pow(to, jc.n) / steps as f64;
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

/// Rates of 1e-30 to 1e8 a second at T_m-, T_m and 2 T_m: the flow stress is finite, and nothing from T_m on.
pub fn limit_rows() -> Vec<Row> {
    let jc = Material::named("copper").expect("shipped").strength;
    let melting = jc.melting_temperature.si();
    let (mut wrong, mut total) = (0, 0);
    for rate in [1e-30, 1e-10, 1.0, 1e4, 1e8] {
        for t in [melting * (1.0 - 1e-15), melting, 2.0 * melting] {
            for strain in [0.0, 1e-12, 0.1, 5.0] {
                let y = jc.flow_stress(strain, rate, jc.softening(jc.homologous(t, melting)));
                total += 1;
                wrong += (!(y.is_finite() && y >= 0.0 && (t < melting || y == 0.0))) as u32;
            }
        }
    }
    let what = format!("rates 1e-30..1e8 1/s, T_m-, T_m, 2 T_m: wrong flow stresses of {total}");
    vec![Row::most("Johnson-Cook", what, wrong as f64, "", 0.0)]
}

/// `count` random states of each equation of state (rho .001..3 rho0, e -.1..50 MJ/kg), and compression to x = .9.
pub fn state_rows(count: usize) -> Vec<Row> {
    let own = |value: serde_json::Value| -> Eos {
        serde_json::from_value(value["eos"].clone()).expect("an equation of state")
    };
    let gray = |name: &str| Material::named(name).expect("shipped").eos;
    let models = [
        ("GRAY copper", gray("copper")),
        ("GRAY aluminium", gray("aluminium")),
        ("Mie-Grueneisen copper", own(common::copper())),
        ("Mie-Grueneisen aluminium", own(common::aluminium())),
    ];
    let mut rows = Vec::new();
    for (name, eos) in &models {
        let mut seed = 88172645463325252u64;
        let mut uniform = move || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut wrong, mut worst) = (0, 0.0f64);
        for _ in 0..count {
            let volume = eos.reference_volume() / (1e-3 + (3.0 - 1e-3) * uniform());
            let energy = -0.1e6 + 50.1e6 * uniform();
            let p = eos.point(volume, energy);
            let finite = p.pressure.is_finite() && p.temperature.is_finite() && p.sound_speed > 0.0;
            wrong += !finite as u32;
            if p.temperature > 0.0 {
                let back = eos.energy_at(volume, p.temperature);
                // In the mixed phase temperature says nothing of the energy in copies whose melting band is flat: the way back
                // goes by temperature.
                let again = eos.point(volume, back).temperature;
                worst = worst.max((again / p.temperature - 1.0).abs());
            }
        }
        let case = "EOS root in the mixed phase";
        rows.push(Row::most(case, format!("{name}: not finite or c^2 <= 0, of {count}"), wrong as f64, "", 0.0));
        rows.push(Row::most(case, format!("{name}: worst round trip through T"), worst, "", 1e-10));
        let mut falls = 0;
        let mut last = f64::NEG_INFINITY;
        for i in 0..900 {
            let volume = eos.reference_volume() * (1.0 - 1e-3 * i as f64);
            let pressure = eos.point(volume, eos.energy_at(volume, eos.reference_temperature())).pressure;
            falls += !(pressure > last) as u32;
            last = pressure;
        }
        rows.push(Row::most(
            "over-compression",
            format!("{name}: places to x = .9 where P does not rise"),
            falls as f64,
            "",
            0.0,
        ));
    }
    rows
}
