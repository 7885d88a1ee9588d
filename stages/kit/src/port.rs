//! Named, typed inputs.
use crate::{Artifact, LoadError, load};
use hvi_cache::{Slot, Store};
use std::collections::BTreeMap;

/// How many results a port takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arity {
    /// Exactly one: `"@copper"`.
    One,
    /// One or more, such as all points of a sweep, in its order: `"@states[*]"`.
    Many,
    /// As [`Arity::Many`], or none.
    Any,
    /// One at each place whose key ends in the port's name, by dotted path: `projectile.eos`, `plate.eos`.
    Places,
}

/// A named, typed input of a stage.
pub struct Port {
    /// The key that holds the reference; with [`Arity::Places`] the last part of the dotted key.
    pub name: &'static str,
    /// Kind of artifact it takes.
    pub kind: &'static str,
    /// How many.
    pub arity: Arity,
    /// What it is for, for people.
    pub about: &'static str,
}

/// A stage's inputs: a struct of artifacts, one field per port.
pub trait Inputs: Sized {
    /// The ports, in the fields' order.
    const PORTS: &'static [Port];
    /// Loads every artifact. The plan has checked names, kinds and arities.
    ///
    /// # Errors
    /// [`LoadError`] of the first artifact that can't be had.
    fn load(slots: &BTreeMap<String, Slot>, store: &Store) -> Result<Self, LoadError>;
}
impl Inputs for () {
    const PORTS: &'static [Port] = &[];
    fn load(_: &BTreeMap<String, Slot>, _: &Store) -> Result<(), LoadError> {
        Ok(())
    }
}

/// What can stand in a port.
pub trait Plug: Sized {
    /// Kind of artifact.
    const KIND: &'static str;
    /// How many.
    const ARITY: Arity;
    /// Loads from the slots what belongs to the port `name`.
    ///
    /// # Errors
    /// [`LoadError`] where an artifact can't be had.
    fn load(name: &str, slots: &BTreeMap<String, Slot>, store: &Store) -> Result<Self, LoadError>;
}

fn one(slots: &BTreeMap<String, Slot>, name: &str) -> Option<hvi_cache::Digest> {
    match slots.get(name)? {
        Slot::One(d) => Some(*d),
        Slot::Many(ds) => ds.first().copied(),
    }
}

impl<A: Artifact> Plug for A {
    const KIND: &'static str = A::KIND;
    const ARITY: Arity = Arity::One;
    fn load(name: &str, slots: &BTreeMap<String, Slot>, store: &Store) -> Result<A, LoadError> {
        load(store, one(slots, name).expect("the plan checked that the port is filled"))
    }
}
impl<A: Artifact> Plug for Vec<A> {
    const KIND: &'static str = A::KIND;
    const ARITY: Arity = Arity::Many;
    fn load(name: &str, slots: &BTreeMap<String, Slot>, store: &Store) -> Result<Self, LoadError> {
        match slots.get(name) {
            Some(Slot::Many(ds)) => ds.iter().map(|d| load(store, *d)).collect(),
            Some(Slot::One(d)) => Ok(vec![load(store, *d)?]),
            None => Ok(Vec::new()),
        }
    }
}

/// Any number of artifacts, none included: see [`Arity::Any`].
pub struct Any<A>(pub Vec<A>);
impl<A: Artifact> Plug for Any<A> {
    const KIND: &'static str = A::KIND;
    const ARITY: Arity = Arity::Any;
    fn load(name: &str, slots: &BTreeMap<String, Slot>, store: &Store) -> Result<Self, LoadError> {
        <Vec<A> as Plug>::load(name, slots, store).map(Any)
    }
}

/// Artifacts by the dotted path of the key that named them: see [`Arity::Places`].
pub struct Places<A>(pub BTreeMap<String, A>);
impl<A: Artifact> Plug for Places<A> {
    const KIND: &'static str = A::KIND;
    const ARITY: Arity = Arity::Places;
    fn load(name: &str, slots: &BTreeMap<String, Slot>, store: &Store) -> Result<Self, LoadError> {
        slots
            .iter()
            .filter(|(path, _)| path.rsplit('.').next() == Some(name))
            .map(|(path, _)| Ok((path.clone(), load(store, one(slots, path).expect("just seen"))?)))
            .collect::<Result<_, _>>()
            .map(Places)
    }
}

/// Declares an input struct: `inputs! { pub struct FitInputs { states: Vec<State> } }`.
#[macro_export]
macro_rules! inputs {
    ($(#[$m:meta])* $v:vis struct $name:ident { $($(#[doc = $doc:literal])* $field:ident : $ty:ty),* $(,)? }) => {
        $(#[$m])* $v struct $name { $($(#[doc = $doc])* pub $field: $ty),* }
        impl $crate::Inputs for $name {
            const PORTS: &'static [$crate::Port] = &[$($crate::Port {
                name: stringify!($field), kind: <$ty as $crate::Plug>::KIND, arity: <$ty as $crate::Plug>::ARITY,
                about: concat!($($doc),*),
            }),*];
            fn load(slots: &::std::collections::BTreeMap<String, $crate::Slot>, store: &$crate::Store)
                -> Result<Self, $crate::LoadError> {
                Ok(Self { $($field: <$ty as $crate::Plug>::load(stringify!($field), slots, store)?),* })
            }
        }
    };
}
