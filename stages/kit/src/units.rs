//! Physical quantities as people write them (`"6.7 km/s"`) and as the solvers use them (SI).
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

/// A unit: its symbol, what it measures, and its size in SI as `factor * 10^exponent`.
///
/// The power of ten is kept apart so that `"2.5 mm"` and `"0.0025 m"` give the same bits.
struct Unit(&'static str, Dimension, f64, i32);

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Dimension {
    Length,
    Time,
    Velocity,
    Temperature,
    Pressure,
    Density,
    SpecificVolume,
    SpecificEnergy,
    SpecificHeat,
    ElectronicHeat,
    MolarMass,
    Rate,
    Angle,
    Energy,
}

impl Dimension {
    /// Symbol of the SI unit.
    pub const fn si(self) -> &'static str {
        match self {
            Dimension::Length => "m",
            Dimension::Time => "s",
            Dimension::Velocity => "m/s",
            Dimension::Temperature => "K",
            Dimension::Pressure => "Pa",
            Dimension::Density => "kg/m3",
            Dimension::SpecificVolume => "m3/kg",
            Dimension::SpecificEnergy => "J/kg",
            Dimension::SpecificHeat => "J/kg/K",
            Dimension::ElectronicHeat => "J/kg/K2",
            Dimension::MolarMass => "kg/mol",
            Dimension::Rate => "1/s",
            Dimension::Angle => "rad",
            Dimension::Energy => "J",
        }
    }

    /// A quantity of this dimension as a person may write it.
    pub const fn example(self) -> &'static str {
        match self {
            Dimension::Length => "2.5 mm",
            Dimension::Time => "20 us",
            Dimension::Velocity => "6.7 km/s",
            Dimension::Temperature => "300 K",
            Dimension::Pressure => "0.1 GPa",
            Dimension::Density => "8.93 g/cm3",
            Dimension::SpecificVolume => "0.112 cm3/g",
            Dimension::SpecificEnergy => "5.2 MJ/kg",
            Dimension::SpecificHeat => "385 J/kg/K",
            Dimension::ElectronicHeat => "7.7 mJ/kg/K2",
            Dimension::MolarMass => "63.546 g/mol",
            Dimension::Rate => "1 1/s",
            Dimension::Angle => "30 deg",
            Dimension::Energy => "100 keV",
        }
    }

    /// Symbols of the units that measure it.
    pub fn symbols(self) -> impl Iterator<Item = &'static str> {
        UNITS.iter().filter(move |u| u.1 == self).map(|u| u.0)
    }

    /// JSON schema of a quantity: text with a unit; `unit` is the SI unit, `units` are all that may be written.
    fn schema(self) -> Schema {
        let units: Vec<_> = self.symbols().collect();
        let spelled: Vec<_> =
            units.iter().map(|u| u.replace('u', "[u\u{b5}]").replace("angstrom", "(angstrom|\u{c5})")).collect();
        json_schema!({
            "type": "string",
            "pattern": format!(r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*({})\s*$", spelled.join("|")),
            "description": format!("{self:?}: a number with a unit ({}).", units.join(", ")),
            "examples": [self.example()],
            "unit": self.si(),
            "units": units,
        })
    }
}

const UNITS: &[Unit] = {
    use Dimension::*;
    &[
        Unit("m", Length, 1.0, 0),
        Unit("cm", Length, 1.0, -2),
        Unit("mm", Length, 1.0, -3),
        Unit("um", Length, 1.0, -6),
        Unit("nm", Length, 1.0, -9),
        Unit("angstrom", Length, 1.0, -10),
        Unit("s", Time, 1.0, 0),
        Unit("ms", Time, 1.0, -3),
        Unit("us", Time, 1.0, -6),
        Unit("ns", Time, 1.0, -9),
        Unit("ps", Time, 1.0, -12),
        Unit("fs", Time, 1.0, -15),
        Unit("m/s", Velocity, 1.0, 0),
        Unit("km/s", Velocity, 1.0, 3),
        Unit("mm/us", Velocity, 1.0, 3),
        Unit("cm/us", Velocity, 1.0, 4),
        Unit("K", Temperature, 1.0, 0),
        Unit("Pa", Pressure, 1.0, 0),
        Unit("kPa", Pressure, 1.0, 3),
        Unit("MPa", Pressure, 1.0, 6),
        Unit("GPa", Pressure, 1.0, 9),
        Unit("bar", Pressure, 1.0, 5),
        Unit("kbar", Pressure, 1.0, 8),
        Unit("Mbar", Pressure, 1.0, 11),
        Unit("kg/m3", Density, 1.0, 0),
        Unit("g/cm3", Density, 1.0, 3),
        Unit("m3/kg", SpecificVolume, 1.0, 0),
        Unit("cm3/g", SpecificVolume, 1.0, -3),
        Unit("J/kg", SpecificEnergy, 1.0, 0),
        Unit("J/g", SpecificEnergy, 1.0, 3),
        Unit("kJ/kg", SpecificEnergy, 1.0, 3),
        Unit("kJ/g", SpecificEnergy, 1.0, 6),
        Unit("MJ/kg", SpecificEnergy, 1.0, 6),
        Unit("J/kg/K", SpecificHeat, 1.0, 0),
        Unit("J/kg/K2", ElectronicHeat, 1.0, 0),
        Unit("mJ/kg/K2", ElectronicHeat, 1.0, -3),
        Unit("kg/mol", MolarMass, 1.0, 0),
        Unit("g/mol", MolarMass, 1.0, -3),
        Unit("1/s", Rate, 1.0, 0),
        Unit("1/us", Rate, 1.0, 6),
        Unit("rad", Angle, 1.0, 0),
        Unit("deg", Angle, std::f64::consts::PI / 180.0, 0),
        Unit("J", Energy, 1.0, 0),
        Unit("keV", Energy, 1.602176634, -16),
        Unit("MeV", Energy, 1.602176634, -13),
    ]
};

/// Splits `"6.7 km/s"` into its number text and its unit symbol (empty when there is none).
pub fn split(text: &str) -> Option<(&str, &str)> {
    let text = text.trim();
    let end = text
        .char_indices()
        .find(|&(i, c)| {
            let exponent = matches!(c, 'e' | 'E')
                && i > 0
                && text[i + 1..].starts_with(|d: char| d.is_ascii_digit() || d == '-' || d == '+');
            !(c.is_ascii_digit() || matches!(c, '.' | '+' | '-') || exponent)
        })
        .map_or(text.len(), |(i, _)| i);
    let (number, unit) = text.split_at(end);
    number.parse::<f64>().ok()?;
    Some((number, unit.trim()))
}

/// Value in SI of `text`, e.g. `si("6.7 km/s", Velocity) == Ok(6700.0)`.
///
/// # Errors
/// A sentence that says what was expected: no number, no unit, an unknown unit, a unit of something else, not finite.
pub fn si(text: &str, dimension: Dimension) -> Result<f64, String> {
    let accepted = || dimension.symbols().collect::<Vec<_>>().join(", ");
    let (number, symbol) =
        split(text).ok_or_else(|| format!("`{text}` is not a number with a unit (one of {})", accepted()))?;
    if symbol.is_empty() {
        return Err(format!("`{text}` has no unit: write one of {}, as in \"{text} {}\"", accepted(), dimension.si()));
    }
    let unit = unit(symbol);
    let Some(&Unit(_, found, factor, exponent)) = unit else {
        return Err(format!("unknown unit `{symbol}`: expected one of {}", accepted()));
    };
    if found != dimension {
        return Err(format!("`{symbol}` measures {found:?}, but {dimension:?} is wanted here: one of {}", accepted()));
    }
    let scaled = if exponent == 0 {
        number.parse::<f64>()
    } else {
        let (mantissa, own) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
        let power = own.parse::<i32>().map_err(|e| format!("`{text}`: {e}"))?.saturating_add(exponent);
        format!("{mantissa}e{power}").parse::<f64>()
    };
    let value = scaled.map_err(|e| format!("`{text}`: {e}"))? * factor;
    if value.is_finite() { Ok(value) } else { Err(format!("`{text}` is not finite")) }
}

/// What `symbol` measures, if it is a unit.
pub fn dimension(symbol: &str) -> Option<Dimension> {
    unit(symbol).map(|u| u.1)
}

fn unit(symbol: &str) -> Option<&'static Unit> {
    if symbol.is_ascii() {
        return UNITS.iter().find(|u| u.0 == symbol);
    }
    let plain = symbol.replace('µ', "u").replace("Å", "angstrom");
    UNITS.iter().find(|u| u.0 == plain)
}

macro_rules! quantities { ($($(#[$doc:meta])* $name:ident),* $(,)?) => { $(
    $(#[$doc])*
    #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
    pub struct $name(f64);
    impl $name {
        /// From a value in SI.
        pub const fn new(si: f64) -> Self { Self(si) }
        /// Value in SI.
        pub const fn si(self) -> f64 { self.0 }
    }
    impl Serialize for $name {
        fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
            s.collect_str(&format_args!("{:?} {}", self.0, Dimension::$name.si()))
        }
    }
    impl JsonSchema for $name {
        fn schema_name() -> Cow<'static, str> {
            stringify!($name).into()
        }
        fn json_schema(_: &mut SchemaGenerator) -> Schema {
            Dimension::$name.schema()
        }
    }
    impl<'de> Deserialize<'de> for $name {
        fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
            struct Visit;
            impl serde::de::Visitor<'_> for Visit {
                type Value = $name;
                fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                    write!(f, "a quantity with a unit, as in \"1 {}\"", Dimension::$name.si())
                }
                fn visit_str<E: serde::de::Error>(self, v: &str) -> Result<$name, E> {
                    si(v, Dimension::$name).map($name).map_err(E::custom)
                }
            }
            d.deserialize_str(Visit)
        }
    }
)* } }
quantities! {
    /// Length [m].
    Length,
    /// Time [s].
    Time,
    /// Velocity [m/s].
    Velocity,
    /// Temperature [K].
    Temperature,
    /// Pressure or stress [Pa].
    Pressure,
    /// Mass density [kg/m3].
    Density,
    /// Volume per mass [m3/kg].
    SpecificVolume,
    /// Energy per mass [J/kg].
    SpecificEnergy,
    /// Heat capacity per mass [J/kg/K].
    SpecificHeat,
    /// Electronic heat coefficient per mass [J/kg/K2].
    ElectronicHeat,
    /// Mass of one mole [kg/mol].
    MolarMass,
    /// Rate [1/s].
    Rate,
    /// Angle [rad].
    Angle,
    /// Energy, as of a photon [J].
    Energy,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_length_in_any_unit_has_the_same_bits() {
        for text in ["2.5 mm", "0.0025 m", "2500 um", "2.5e-3 m", "0.25 cm", "2500µm"] {
            assert_eq!(si(text, Dimension::Length).unwrap().to_bits(), 0.0025f64.to_bits(), "{text}");
        }
    }

    #[test]
    fn canonical_text_reads_back_to_the_same_bits() {
        for x in [1e-15, 0.1 + 0.2, 6700.0, f64::MIN_POSITIVE, -1.0 / 3.0] {
            let text = serde_json::to_string(&Time::new(x)).unwrap();
            assert_eq!(serde_json::from_str::<Time>(&text).unwrap().si().to_bits(), x.to_bits(), "{text}");
        }
    }

    /// A schema's pattern takes what the parser takes; its example is right.
    #[test]
    fn examples_read_and_schemas_name_the_unit() {
        for dimension in UNITS.iter().map(|u| u.1) {
            assert!(si(dimension.example(), dimension).is_ok(), "{dimension:?}");
            let schema = dimension.schema();
            assert_eq!(schema.get("unit").unwrap(), dimension.si());
            assert_eq!(schema.get("units").unwrap()[0], dimension.si(), "{dimension:?}: SI comes first");
        }
    }

    #[test]
    fn mistakes_are_named() {
        let message = |text| si(text, Dimension::Velocity).unwrap_err();
        assert!(message("6.7").contains("has no unit"));
        assert!(message("6.7 mm").contains("measures Length"));
        assert!(message("6.7 parsec").contains("unknown unit `parsec`"));
        assert!(message("fast").contains("not a number with a unit"));
        assert!(message("1e400 m/s").contains("not finite"));
        assert!(message("1e2147483647 km/s").contains("not finite"));
    }
}
