//! Copper (oxygen-free).
use super::{Damage, JohnsonCook, Material};
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray};
use hvi_kit::units::{Pressure, Rate, Temperature};

pub(super) fn copper() -> Material {
    Material {
        name: "copper".into(),
        source: "equation of state: GRAY, Royce (1971); elastic constants and Johnson-Cook strength: Liu, Wang & Zhang (2013), Table 2; damage: Johnson & Cook \
                 (1985), OFHC copper; melting temperature of the strength model: Johnson & Cook (1983); spall 1.35 GPa: \
                 gas-gun range 1.0-1.6 GPa (secondary source)"
            .into(),
        young: Pressure::new(117e9),
        poisson: 0.3,
        strength: JohnsonCook {
            a: Pressure::new(90e6),
            b: Pressure::new(292e6),
            n: 0.31,
            c: 0.025,
            m: 1.09,
            rate: Rate::new(1.0),
            reference_temperature: Temperature::new(293.0),
            melting_temperature: Temperature::new(1356.0),
        },
        damage: Some(Damage { d1: 0.54, d2: 4.89, d3: -3.03, d4: 0.014, d5: 1.12, least: 0.01 }),
        spall: Some(Pressure::new(1.35e9)),
        eos: Eos::Gray(Gray::new(Set::CopperRoyce.parameters()).expect("published constants")),
    }
}
