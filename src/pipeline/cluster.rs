//! `[run.slurm]`: what jobs ask of a cluster. Words go to a command line, so they are checked.
use super::{amount, whole};
use crate::mistake::Mistake;
use crate::value::{Node, Table, Value};
use std::time::Duration;

/// `[run.slurm]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Options of `sbatch` that are passed on as they are, by name: `partition`, `account`, `qos`, `constraint`.
    pub words: Vec<(&'static str, String)>,
    /// The longest that a job may take.
    pub time: Option<Duration>,
    /// Least memory that a job asks for [B].
    pub memory: u64,
    /// Most cores of one node of the study.
    pub cores: usize,
    /// Modules that a job loads first.
    pub modules: Vec<String>,
    /// Nodes that are foretold to take less go into one job together, up to this.
    pub pack: Duration,
    /// Most jobs of one array.
    pub array: usize,
}

impl Default for Profile {
    fn default() -> Profile {
        Profile {
            words: Vec::new(),
            time: None,
            memory: 0,
            cores: 64,
            modules: Vec::new(),
            pack: Duration::from_secs(60),
            // Slurm's own default of MaxArraySize is 1001.
            array: 1000,
        }
    }
}

/// Names of the options that are words.
const WORDS: [&str; 4] = ["partition", "account", "qos", "constraint"];

/// All keys.
pub const KEYS: [&str; 10] =
    ["partition", "account", "qos", "constraint", "time", "memory", "cores", "modules", "pack", "array"];

impl Profile {
    /// Takes the keys of a table over.
    ///
    /// # Errors
    /// [`Mistake`] at the key or the value that can't be used.
    pub fn read(&mut self, table: &Table) -> Result<(), Mistake> {
        for (key, value) in &table.0 {
            match key.text.as_str() {
                "time" => self.time = Some(amount(value, "a time: time = \"12 h\"", crate::amount::time)?),
                "pack" => self.pack = amount(value, "a time: pack = \"5 min\"", crate::amount::time)?,
                "memory" => self.memory = amount(value, "a size: memory = \"4 GB\"", crate::amount::size)?,
                "cores" => self.cores = whole("cores", value, 1..=4096)? as usize,
                "array" => self.array = whole("array", value, 1..=100_000)? as usize,
                "modules" => {
                    let Node::List(items) = &value.node else {
                        return Err(Mistake::new("expected a list of names: modules = [\"lammps\"]")
                            .at(&value.at, value.kind()));
                    };
                    self.modules = items.iter().map(word).collect::<Result<_, _>>()?;
                }
                other => match WORDS.iter().find(|name| **name == other) {
                    Some(name) => {
                        self.words.retain(|(known, _)| known != name);
                        self.words.push((name, word(value)?));
                    }
                    None => {
                        let mistake = Mistake::new(format!("unknown key `{other}` in [run.slurm]"));
                        return Err(mistake.at(&key.at, "not known here").nearest(other, KEYS));
                    }
                },
            }
        }
        Ok(())
    }
}

/// A word that means nothing to a shell.
fn word(value: &Value) -> Result<String, Mistake> {
    let text = value.text("a name")?;
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./,:+=&|".contains(c);
    if text.is_empty() || text.starts_with('-') || !text.chars().all(plain) {
        let title = format!("`{text}` is no name that a cluster knows");
        return Err(Mistake::new(title).at(&value.at, "use letters, digits and _ - . / , : + = & |"));
    }
    Ok(text.into())
}
