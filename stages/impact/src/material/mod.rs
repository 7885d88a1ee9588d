//! Materials: constants of strength, damage, spall and equation of state, one file a shipped material.
//!
//! `johnson_cook.rs` flow stress and its return map; `damage.rs` fracture strain; `isotherm.rs` energy that is not heat; `released.rs` phases of matter that has parted; `law.rs` what one particle does in a step, with `answer.rs` of its equation of state, in `terms.rs`.
mod aluminium;
mod answer;
mod copper;
mod damage;
mod isotherm;
mod johnson_cook;
mod law;
mod released;
mod terms;
pub use damage::Damage;
use hvi_eos::Eos;
use hvi_kit::units::Pressure;
pub use johnson_cook::JohnsonCook;
pub use law::{Law, Switches};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
pub use terms::{Answer, Gain, HalfStep};

/// Constants of a material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Its name in results.
    pub name: String,
    /// Where the constants come from.
    #[serde(default)]
    pub source: String,
    /// Young's modulus E.
    pub young: Pressure,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Johnson-Cook strength.
    pub strength: JohnsonCook,
    /// Johnson-Cook damage; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damage: Option<Damage>,
    /// Largest tension at room temperature; falls as 1 - T*. Absent: no spall.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spall: Option<Pressure>,
    /// Equation of state where no fitted one is plugged in.
    pub eos: Eos,
}

impl Material {
    /// Names of the shipped materials.
    pub const NAMES: [&str; 2] = ["copper", "aluminium"];

    /// A shipped material.
    pub fn named(name: &str) -> Option<Material> {
        match name {
            "copper" => Some(copper::copper()),
            "aluminium" => Some(aluminium::aluminium()),
            _ => None,
        }
    }

    /// Shear modulus `E / (2 (1 + nu))` [Pa].
    pub fn shear(&self) -> f64 {
        0.5 * self.young.si() / (1.0 + self.poisson)
    }

    /// Longitudinal sound speed of the reference state with `eos` [m/s].
    pub fn sound_speed(&self, eos: &Eos) -> f64 {
        let volume = eos.reference_volume();
        let bulk = eos.point(volume, eos.energy_at(volume, eos.reference_temperature())).sound_speed;
        (bulk * bulk + 4.0 / 3.0 * self.shear() * volume).sqrt()
    }

    /// The first constant out of its range: its key and what is allowed.
    pub fn fault(&self) -> Option<(&'static str, String)> {
        let s = &self.strength;
        let positive = |key, value: f64, unit: &str| {
            (value.is_nan() || value <= 0.0).then(|| (key, format!("is {value} {unit}, must be above 0 {unit}")))
        };
        let not_negative = |key, value: f64| {
            (value.is_nan() || value < 0.0).then(|| (key, format!("is {value}, must not be negative")))
        };
        positive("young", self.young.si(), "Pa")
            .or_else(|| {
                let inside = self.poisson > -1.0 && self.poisson < 0.5;
                (!inside).then(|| ("poisson", format!("is {}, must lie between -1 and 0.5", self.poisson)))
            })
            .or_else(|| not_negative("strength.a", s.a.si()))
            .or_else(|| not_negative("strength.b", s.b.si()))
            .or_else(|| positive("strength.n", s.n, ""))
            .or_else(|| not_negative("strength.c", s.c))
            .or_else(|| positive("strength.m", s.m, ""))
            .or_else(|| positive("strength.rate", s.rate.si(), "1/s"))
            .or_else(|| {
                let (room, melting) = (s.reference_temperature.si(), s.melting_temperature.si());
                (melting <= room).then(|| {
                    ("strength.melting_temperature", format!("is {melting} K, must be above the reference {room} K"))
                })
            })
            .or_else(|| self.damage.as_ref().and_then(|d| positive("damage.least", d.least, "")))
            .or_else(|| self.spall.and_then(|p| positive("spall", p.si(), "Pa")))
    }
}

/// Reads a material from a shipped one's name or from a table of all constants.
///
/// # Errors
/// An unknown name, or a table with a missing, unknown or malformed constant.
pub fn by_name_or_table<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Material, D::Error> {
    struct Either;
    impl<'de> Visitor<'de> for Either {
        type Value = Material;
        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            write!(f, "a material's name ({}) or a table of its constants", Material::NAMES.join(", "))
        }
        fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Material, E> {
            Material::named(name).ok_or_else(|| {
                E::custom(format_args!("unknown material `{name}`: expected one of {}", Material::NAMES.join(", ")))
            })
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Material, A::Error> {
            Material::deserialize(MapAccessDeserializer::new(map))
        }
    }
    deserializer.deserialize_any(Either)
}

/// JSON schema of what [`by_name_or_table`] reads.
pub fn name_or_table(generator: &mut SchemaGenerator) -> Schema {
    let name = json_schema!({
        "type": "string",
        "description": "A shipped material, or a [material.NAME] of the file.",
        "examples": Material::NAMES,
    });
    json_schema!({ "anyOf": [name, generator.subschema_for::<Material>()] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_materials_are_in_range() {
        for name in Material::NAMES {
            let material = Material::named(name).unwrap();
            assert_eq!(material.fault(), None);
            assert_eq!(material.name, name);
        }
    }

    /// Table 2 of the paper: E 117 GPa with nu .3, E 69 GPa with nu .35.
    #[test]
    fn shear_moduli() {
        assert!((Material::named("copper").unwrap().shear() - 45e9).abs() < 1.0);
        assert!((Material::named("aluminium").unwrap().shear() - 25.5556e9).abs() < 1e5);
    }
}
