//! Which potential a pipeline asks for: a built-in one by its name, or one from a file.
use super::{Format, Malformed, Potential, Tabulated, zhou_2004};
use hvi_kit::{Digest, File};
use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

macro_rules! built_in {
    ($($(#[$doc:meta])* $variant:ident $name:literal $potential:expr;)*) => {
        /// A potential that needs no file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        pub enum BuiltIn { $($(#[$doc])* #[serde(rename = $name)] $variant),* }
        impl BuiltIn {
            /// All of them.
            pub const ALL: &[BuiltIn] = &[$(BuiltIn::$variant),*];
            /// Its name.
            pub fn name(self) -> &'static str {
                match self { $(BuiltIn::$variant => $name),* }
            }
            /// The potential itself.
            pub fn potential(self) -> Potential {
                match self { $(BuiltIn::$variant => $potential),* }
            }
        }
    };
}
built_in! {
    /// Copper, EAM1 of Y. Mishin et al., Phys. Rev. B 63, 224106 (2001).
    Mishin2001 "mishin-2001" Potential::Mishin2001;
    /// Copper of X. W. Zhou et al., Phys. Rev. B 69, 144113 (2004), as are all that follow.
    ZhouCu "zhou-2004-Cu" Potential::Zhou2004(&zhou_2004::CU);
    /// Silver.
    ZhouAg "zhou-2004-Ag" Potential::Zhou2004(&zhou_2004::AG);
    /// Gold.
    ZhouAu "zhou-2004-Au" Potential::Zhou2004(&zhou_2004::AU);
    /// Nickel.
    ZhouNi "zhou-2004-Ni" Potential::Zhou2004(&zhou_2004::NI);
    /// Palladium.
    ZhouPd "zhou-2004-Pd" Potential::Zhou2004(&zhou_2004::PD);
    /// Platinum.
    ZhouPt "zhou-2004-Pt" Potential::Zhou2004(&zhou_2004::PT);
    /// Aluminium.
    ZhouAl "zhou-2004-Al" Potential::Zhou2004(&zhou_2004::AL);
    /// Lead.
    ZhouPb "zhou-2004-Pb" Potential::Zhou2004(&zhou_2004::PB);
    /// Iron.
    ZhouFe "zhou-2004-Fe" Potential::Zhou2004(&zhou_2004::FE);
    /// Molybdenum.
    ZhouMo "zhou-2004-Mo" Potential::Zhou2004(&zhou_2004::MO);
    /// Tantalum.
    ZhouTa "zhou-2004-Ta" Potential::Zhou2004(&zhou_2004::TA);
    /// Tungsten.
    ZhouW "zhou-2004-W" Potential::Zhou2004(&zhou_2004::W);
    /// Magnesium.
    ZhouMg "zhou-2004-Mg" Potential::Zhou2004(&zhou_2004::MG);
    /// Cobalt.
    ZhouCo "zhou-2004-Co" Potential::Zhou2004(&zhou_2004::CO);
    /// Titanium.
    ZhouTi "zhou-2004-Ti" Potential::Zhou2004(&zhou_2004::TI);
    /// Zirconium.
    ZhouZr "zhou-2004-Zr" Potential::Zhou2004(&zhou_2004::ZR);
}

/// Which potential: `"mishin-2001"`, or `{ file = "Cu_u3.eam", format = "funcfl" }`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Named {
    /// A name.
    BuiltIn(BuiltIn),
    /// A file, which is an input of the stage.
    File(FromFile),
}

/// How to read the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FromFile {
    /// Its format: `funcfl`, `setfl` or `eam/fs` (LAMMPS' pair styles `eam`, `eam/alloy` and `eam/fs`).
    pub format: Format,
    /// Which of the file's elements, if it has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element: Option<String>,
}

// Untagged enums derive this too, but then say nothing of what was wrong.
impl<'de> Deserialize<'de> for Named {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Named, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Named;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "the name of a potential, or {{ file = \"...\", format = \"funcfl, setfl or eam/fs\" }}")
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<Named, E> {
                BuiltIn::deserialize(StrDeserializer::new(name)).map(Named::BuiltIn)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Named, A::Error> {
                FromFile::deserialize(MapAccessDeserializer::new(map)).map(Named::File)
            }
        }
        d.deserialize_any(Either)
    }
}

/// Why there is no potential.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum Unreadable {
    #[error("it needs `file`, the name of a potential file")]
    Missing,
    #[error("a built-in potential takes no file")]
    Needless,
    #[error("not a text file: {0}")]
    Binary(String),
    #[error("not a potential file of format {format}: {why}")]
    Malformed { format: Format, why: Malformed },
}

/// Potentials that were read, by content and by how they were read.
type Read = BTreeMap<(Digest, Format, Option<String>), Arc<Tabulated>>;

impl Named {
    /// The potential, read from `file` if it is one from a file. A file is read once in a process.
    ///
    /// # Errors
    /// [`Unreadable`] where the file is not of the format that was said, or where there is none.
    pub fn potential(&self, file: Option<&File>) -> Result<Potential, Unreadable> {
        static READ: Mutex<Read> = Mutex::new(BTreeMap::new());
        let (how, file) = match (self, file) {
            (Named::BuiltIn(built_in), None) => return Ok(built_in.potential()),
            (Named::BuiltIn(_), Some(_)) => return Err(Unreadable::Needless),
            (Named::File(_), None) => return Err(Unreadable::Missing),
            (Named::File(how), Some(file)) => (how, file),
        };
        let key = (Digest::of(&file.0), how.format, how.element.clone());
        let mut read = READ.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(table) = read.get(&key) {
            return Ok(Potential::Tabulated(Arc::clone(table)));
        }
        let text = file.text().map_err(|e| Unreadable::Binary(e.to_string()))?;
        let table = Tabulated::read(text, how.format, how.element.as_deref())
            .map_err(|why| Unreadable::Malformed { format: how.format, why })?;
        let table = Arc::clone(read.entry(key).or_insert(Arc::new(table)));
        Ok(Potential::Tabulated(table))
    }
}
