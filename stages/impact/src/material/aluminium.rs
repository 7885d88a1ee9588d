//! Aluminium.
use super::{Damage, JohnsonCook, Material};
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray};
use hvi_kit::units::{Pressure, Rate, Temperature};

pub(super) fn aluminium() -> Material {
    Material {
        name: "aluminium".into(),
        source: "equation of state: GRAY, Liu, Wang & Zhang (2013), Table 3; elastic constants and Johnson-Cook strength: Liu, Wang & Zhang (2013), Table 2; damage: 6061-T6, after \
                 Lesuer, Kay & LeBlanc (2001) as commonly quoted (from memory, not checked); melting temperature 925 K; \
                 spall 1.2 GPa: gas-gun range 1.1-1.4 GPa (from memory, not checked)"
            .into(),
        young: Pressure::new(69e9),
        poisson: 0.35,
        strength: JohnsonCook {
            a: Pressure::new(324e6),
            b: Pressure::new(114e6),
            n: 0.41,
            c: 0.0,
            m: 0.859,
            rate: Rate::new(1.0),
            reference_temperature: Temperature::new(293.0),
            melting_temperature: Temperature::new(925.0),
        },
        damage: Some(Damage { d1: -0.77, d2: 1.45, d3: -0.47, d4: 0.0, d5: 1.6, least: 0.01 }),
        spall: Some(Pressure::new(1.2e9)),
        eos: Eos::Gray(Gray::new(Set::AluminiumPaper.parameters()).expect("published constants")),
    }
}
