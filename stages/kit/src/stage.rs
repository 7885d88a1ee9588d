//! The one trait that makes a stage, and its type-erased form.
use crate::engine::{Engine, EngineError};
use crate::view::{Scalar, View};
use crate::{Artifact, ByInput, Cancelled, Ctx, File, Inputs, LoadError, Port, Reach};
use hvi_cache::{Digest, Recipe, Store, StoreError};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;

/// Why a stage has no result.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum StageError {
    #[error("cancelled")]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A program outside failed: unlike the physics, it may do better at another try.
    #[error(transparent)]
    Engine(EngineError),
    /// The physics went wrong: a solver did not converge, a state left the model's range. The text says where (step,
    /// time, particle), what, what was allowed, and what to do next.
    #[error("{0}")]
    Physics(String),
}
impl From<EngineError> for StageError {
    fn from(e: EngineError) -> StageError {
        match e {
            EngineError::Cancelled(c) => StageError::Cancelled(c),
            other => StageError::Engine(other),
        }
    }
}
impl StageError {
    /// A failure of the physics, from any error that says where and what.
    pub fn physics(why: impl std::fmt::Display) -> StageError {
        StageError::Physics(why.to_string())
    }
}

/// A parameter outside its range.
#[derive(Debug, PartialEq)]
pub struct Invalid {
    /// Dotted key, e.g. `"plate.thickness"`.
    pub key: String,
    /// What it is, what is allowed, with units.
    pub why: String,
}
impl Invalid {
    /// The key `key` is invalid because of `why`.
    pub fn new(key: &str, why: impl Into<String>) -> Invalid {
        Invalid { key: key.into(), why: why.into() }
    }
}

/// One pure step of a pipeline: the same parameters and inputs give the same output, bit for bit,
/// whatever the clock, the thread count or the host.
pub trait Stage: 'static {
    /// Name in pipeline files and cache keys.
    const NAME: &'static str;
    /// One line for people: what it makes, by which method.
    const SUMMARY: &'static str;
    /// Parameters, with defaults; quantities as types of [`crate::units`]; `#[serde(deny_unknown_fields)]`. The fields'
    /// docs are what the reference and the editors' schema say of them.
    type Params: Serialize + DeserializeOwned + JsonSchema + Send + Sync;
    /// Input ports.
    type Inputs: Inputs;
    /// What it makes.
    type Output: Artifact;

    /// Checks ranges, before anything runs.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    fn check(_params: &Self::Params) -> Result<(), Invalid> {
        Ok(())
    }

    /// Checks the files among the inputs, by dotted key, together with the parameters, before anything runs.
    ///
    /// # Errors
    /// The key of the first file that is no good, or of the parameter that asks for one that is not there.
    fn check_files(_params: &Self::Params, _files: &BTreeMap<String, File>) -> Result<(), Invalid> {
        Ok(())
    }

    /// Predicted core-seconds, for the order of work and the time left; never enters a result.
    fn cost(_params: &Self::Params) -> f64 {
        0.1
    }

    /// Threads and memory one run can use; never enters a result.
    fn needs(_params: &Self::Params) -> Needs {
        Needs::default()
    }

    /// What the parameters alone show, before anything is computed: a scene's set-up; never enters a result.
    fn sketch(_params: &Self::Params) -> Vec<View> {
        Vec::new()
    }

    /// The states that the parameters bring matter to, by input; never enters a result.
    fn reach(_params: &Self::Params) -> ByInput {
        Vec::new()
    }

    /// Whether matter in the state that the parameters ask for matters where `reach` is all that happens to it; nothing where they
    /// ask for no state of matter. Never enters a result.
    fn is_reached(_params: &Self::Params, _reach: &Reach) -> Option<bool> {
        None
    }

    /// The program outside that computes these parameters, if one does: its version enters the key.
    fn engine(_params: &Self::Params) -> Option<&'static Engine> {
        None
    }

    /// Computes the output.
    ///
    /// # Errors
    /// [`StageError`] where the physics fails, or the run is cancelled.
    fn run(params: &Self::Params, inputs: Self::Inputs, ctx: &Ctx<'_>) -> Result<Self::Output, StageError>;
}

/// What a node asks of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Threads it can use with profit, 1 or more.
    pub threads: usize,
    /// Memory at its peak [B].
    pub memory: u64,
}
impl Default for Needs {
    fn default() -> Needs {
        Needs { threads: 1, memory: 64 << 20 }
    }
}

/// Parameters that a stage accepts.
pub struct Checked {
    /// In canonical form: defaults filled, SI units.
    pub params: serde_json::Value,
    /// Predicted core-seconds.
    pub cost: f64,
    /// The program outside that computes them, if one does.
    pub engine: Option<&'static Engine>,
}

/// A result that was made: digest and size of its bytes.
pub struct Made {
    /// Digest of the output's bytes.
    pub output: Digest,
    /// Their number.
    pub bytes: u64,
}

/// What a stored result shows.
pub struct Shown {
    /// Its row in a sweep's table.
    pub scalars: Vec<Scalar>,
    /// Its tables, figures and pictures.
    pub views: Vec<View>,
}

/// A stage with its types erased, for the plan and the executor.
pub struct StageDef {
    /// Name in pipeline files.
    pub name: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// Path of the stage's type: its first part names the crate whose code counts.
    pub type_name: fn() -> &'static str,
    /// Input ports.
    pub ports: &'static [Port],
    /// Kind of the output.
    pub output: &'static str,
    /// JSON schema of the parameters; the types in it go to the generator's definitions.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
    /// Parses parameters, fills defaults, checks ranges, and checks the files among the inputs (by dotted key) against them.
    pub check: fn(&serde_json::Value, &BTreeMap<String, File>) -> Result<Checked, Invalid>,
    /// Threads and memory for canonical parameters.
    pub needs: fn(&serde_json::Value) -> Needs,
    /// What canonical parameters alone show.
    pub sketch: fn(&serde_json::Value) -> Vec<View>,
    /// The states that canonical parameters bring matter to, by input: see [`Stage::reach`].
    pub reach: fn(&serde_json::Value) -> ByInput,
    /// Whether the state of canonical parameters matters: see [`Stage::is_reached`].
    pub is_reached: fn(&serde_json::Value, &Reach) -> Option<bool>,
    /// Loads inputs, runs, stores the output.
    pub run: fn(&Recipe, &Store, &Ctx<'_>) -> Result<Made, StageError>,
    /// Shows a stored output.
    pub show: fn(Digest, &Store) -> Result<Shown, LoadError>,
}

impl StageDef {
    /// The type-erased form of `S`.
    pub const fn of<S: Stage>() -> StageDef {
        StageDef {
            name: S::NAME,
            summary: S::SUMMARY,
            type_name: std::any::type_name::<S>,
            ports: S::Inputs::PORTS,
            output: <S::Output as Artifact>::KIND,
            schema: <S::Params as JsonSchema>::json_schema,
            check: |value, files| {
                // Where a value is wrong it is read again, with an eye on the way to it.
                let params = S::Params::deserialize(value).or_else(|_| {
                    serde_path_to_error::deserialize(value)
                        .map_err(|e| Invalid { key: e.path().to_string(), why: e.into_inner().to_string() })
                })?;
                S::check(&params)?;
                S::check_files(&params, files)?;
                let (cost, engine) = (S::cost(&params), S::engine(&params));
                Ok(Checked { params: serde_json::to_value(params).expect("parameters are plain data"), cost, engine })
            },
            needs: |value| S::Params::deserialize(value).map_or_else(|_| Needs::default(), |p| S::needs(&p)),
            sketch: |value| S::Params::deserialize(value).map_or_else(|_| Vec::new(), |p| S::sketch(&p)),
            reach: |value| S::Params::deserialize(value).map_or_else(|_| Vec::new(), |p| S::reach(&p)),
            is_reached: |value, reach| S::Params::deserialize(value).map_or(None, |p| S::is_reached(&p, reach)),
            run: |recipe, store, ctx| {
                let params = S::Params::deserialize(&recipe.params).expect("checked when it was planned");
                let inputs = S::Inputs::load(&recipe.inputs, store)?;
                let bytes = S::run(&params, inputs, ctx)?.encode();
                Ok(Made { output: store.put(&bytes)?, bytes: bytes.len() as u64 })
            },
            show: |digest, store| {
                let output: S::Output = crate::load(store, digest)?;
                Ok(Shown { scalars: output.scalars(), views: output.views() })
            },
        }
    }
}
