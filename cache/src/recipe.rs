//! What identifies a computation, and how two of them differ.
use crate::Digest;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Digests in one input port: one, or a list in sweep order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "the enum's line says it")]
pub enum Slot {
    One(Digest),
    Many(Vec<Digest>),
}

/// Everything a result may depend on; its canonical bytes are the pre-image of the cache key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Bump to invalidate every cache.
    pub format: u32,
    /// Name of the stage.
    pub stage: String,
    /// Digest of the stage crate's code, of the workspace crates it uses, and of its locked dependencies.
    pub code: Digest,
    /// Parameters after defaults and unit conversion.
    pub params: Value,
    /// Version of the program outside that computes it, if one does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engine: Option<String>,
    /// Inputs by the content of what is plugged in.
    pub inputs: BTreeMap<String, Slot>,
}

/// One field in which two recipes differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Dotted name of the field, e.g. `params.velocity`.
    pub field: String,
    /// Value then, if the field was there.
    pub old: Option<String>,
    /// Value now, if the field is there.
    pub new: Option<String>,
}

/// A recipe whose parts lie elsewhere: what is needed to look its result up.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "as in Recipe")]
pub struct Asked<'a> {
    pub format: u32,
    pub stage: &'a str,
    pub code: Digest,
    pub params: &'a Value,
    pub engine: Option<&'a str>,
    /// In the order of their names.
    pub inputs: Vec<(&'a str, Plugged<'a>)>,
}

/// As [`Slot`].
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "as in Slot")]
pub enum Plugged<'a> {
    One(Digest),
    Many(Cow<'a, [Digest]>),
}

impl Asked<'_> {
    /// Walks every field in a fixed order: the one walk that makes the key and the explanation.
    ///
    /// Each leaf is `(dotted name, type tag, text)`; floats print shortest-round-trip, maps are sorted.
    fn walk(&self, leaf: &mut dyn FnMut(&str, char, &str)) {
        let mut path = Path::default();
        path.number("format", self.format, 'u', leaf);
        leaf("stage", 's', self.stage);
        leaf("code", 'd', self.code.hex().as_str());
        path.below("params", |path| path.value(self.params, leaf));
        if let Some(version) = self.engine {
            leaf("engine", 's', version);
        }
        for (port, plugged) in &self.inputs {
            path.name.push_str("inputs.");
            path.name.push_str(port);
            match plugged {
                Plugged::One(d) => leaf(&path.name, 'd', d.hex().as_str()),
                Plugged::Many(ds) => {
                    path.number("", ds.len(), 'n', leaf);
                    for (i, d) in ds.iter().enumerate() {
                        path.item(i, |path| leaf(&path.name, 'd', d.hex().as_str()));
                    }
                }
            }
            path.name.clear();
        }
    }

    /// The cache key: BLAKE3 over every leaf, each part prefixed by its length, each leaf by its type.
    pub fn key(&self) -> Digest {
        let mut image = Vec::with_capacity(2048);
        self.walk(&mut |name, tag, text| {
            for part in [name, text] {
                image.extend_from_slice(&(part.len() as u64).to_le_bytes());
                image.extend_from_slice(part.as_bytes());
            }
            image.push(tag as u8);
        });
        Digest::of(&image)
    }
}

impl Recipe {
    /// The current [`Recipe::format`].
    pub const FORMAT: u32 = 1;

    fn asked(&self) -> Asked<'_> {
        let plugged = |slot| match slot {
            &Slot::One(d) => Plugged::One(d),
            Slot::Many(ds) => Plugged::Many(Cow::Borrowed(ds)),
        };
        Asked {
            format: self.format,
            stage: &self.stage,
            code: self.code,
            params: &self.params,
            engine: self.engine.as_deref(),
            inputs: self.inputs.iter().map(|(port, slot)| (port.as_str(), plugged(slot))).collect(),
        }
    }

    /// The cache key: see [`Asked::key`].
    pub fn key(&self) -> Digest {
        self.asked().key()
    }

    /// Every field that enters the key, dotted name and value, in the order of the walk; lengths of lists and tables, which
    /// enter too, are left out.
    pub fn fields(&self) -> Vec<(String, String)> {
        let mut all = Vec::new();
        self.asked().walk(&mut |name, tag, text| {
            if !matches!(tag, 'n' | 'm') {
                all.push((name.to_string(), text.to_string()));
            }
        });
        all
    }

    /// The fields in which `self` differs from an `older` recipe, in the order of the walk.
    pub fn changes_since(&self, older: &Recipe) -> Vec<Change> {
        let leaves = |recipe: &Recipe| {
            let mut all = Vec::new();
            recipe.asked().walk(&mut |name, tag, text| all.push((name.to_string(), (tag, text.to_string()))));
            all
        };
        let (old, new) = (leaves(older), leaves(self));
        let then: BTreeMap<_, _> = old.iter().cloned().collect();
        let now: BTreeMap<_, _> = new.iter().cloned().collect();
        let changed = new.iter().filter(|(name, leaf)| then.get(name) != Some(leaf));
        let gone = old.iter().filter(|(name, _)| !now.contains_key(name));
        let text = |leaf: Option<&(char, String)>| leaf.map(|(_, text)| text.clone());
        changed
            .map(|(name, now)| Change { field: name.clone(), old: text(then.get(name)), new: text(Some(now)) })
            .chain(gone.map(|(name, then)| Change { field: name.clone(), old: text(Some(then)), new: None }))
            .collect()
    }
}

/// The dotted name of where the walk is, and room for a number's text: no leaf makes a string of its own.
#[derive(Default)]
struct Path {
    name: String,
    text: String,
}

impl Path {
    /// `inside` with `part` at the end of the name.
    fn below(&mut self, part: &str, inside: impl FnOnce(&mut Path)) {
        let end = self.name.len();
        self.name.push_str(part);
        inside(self);
        self.name.truncate(end);
    }

    /// `inside` with `[i]` at the end of the name.
    fn item(&mut self, i: usize, inside: impl FnOnce(&mut Path)) {
        let end = self.name.len();
        write!(self.name, "[{i}]").expect("a string takes all");
        inside(self);
        self.name.truncate(end);
    }

    fn number(&mut self, part: &str, value: impl std::fmt::Display, tag: char, leaf: &mut dyn FnMut(&str, char, &str)) {
        self.text.clear();
        write!(self.text, "{value}").expect("a string takes all");
        let end = self.name.len();
        self.name.push_str(part);
        leaf(&self.name, tag, &self.text);
        self.name.truncate(end);
    }

    fn value(&mut self, value: &Value, leaf: &mut dyn FnMut(&str, char, &str)) {
        match value {
            Value::Null => leaf(&self.name, '0', ""),
            Value::Bool(b) => leaf(&self.name, 'b', if *b { "true" } else { "false" }),
            Value::Number(n) => self.number("", n, 'f', leaf),
            Value::String(s) => leaf(&self.name, 's', s),
            Value::Array(items) => {
                self.number("", items.len(), 'n', leaf);
                items.iter().enumerate().for_each(|(i, v)| self.item(i, |path| path.value(v, leaf)));
            }
            Value::Object(map) => {
                self.number("", map.len(), 'm', leaf);
                let mut field = |(k, v): (&String, &Value)| {
                    let end = self.name.len();
                    self.name.push('.');
                    self.name.push_str(k);
                    self.value(v, leaf);
                    self.name.truncate(end);
                };
                // They are, unless some dependency switches serde_json's `preserve_order` on.
                if map.keys().is_sorted() {
                    map.iter().for_each(field);
                } else {
                    map.iter().collect::<BTreeMap<_, _>>().into_iter().for_each(&mut field);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn recipe() -> Recipe {
        Recipe {
            format: Recipe::FORMAT,
            stage: "md".into(),
            code: Digest::of(b"code"),
            params: json!({"atoms": 500, "temperature": "300.0 K", "list": [1, 2]}),
            engine: None,
            inputs: [("a".into(), Slot::One(Digest::of(b"a"))), ("b".into(), Slot::Many(vec![Digest::of(b"b")]))]
                .into(),
        }
    }

    #[test]
    fn every_field_counts() {
        let key = recipe().key();
        let changed = |f: fn(&mut Recipe)| {
            let mut r = recipe();
            f(&mut r);
            assert_ne!(r.key(), key, "{:?}", r.changes_since(&recipe()));
            r.changes_since(&recipe()).first().unwrap().field.clone()
        };
        assert_eq!(changed(|r| r.format += 1), "format");
        assert_eq!(changed(|r| r.stage = "eos".into()), "stage");
        assert_eq!(changed(|r| r.code = Digest::of(b"other")), "code");
        assert_eq!(changed(|r| r.params["atoms"] = json!(256)), "params.atoms");
        assert_eq!(changed(|r| r.params["atoms"] = json!("500")), "params.atoms",);
        assert_eq!(changed(|r| r.params["list"] = json!([2, 1])), "params.list[0]");
        assert_eq!(changed(|r| r.engine = Some("29 Sep 2021".into())), "engine");
        assert_eq!(changed(|r| drop(r.inputs.insert("a".into(), Slot::One(Digest::of(b"z"))))), "inputs.a");
        assert_eq!(changed(|r| drop(r.inputs.insert("b".into(), Slot::Many(vec![])))), "inputs.b");
    }

    /// The order of keys in the file doesn't count; `("ab", "cd")` and `("a", "bcd")` differ.
    #[test]
    fn canonical() {
        let mut r = recipe();
        r.params = json!({"list": [1, 2], "temperature": "300.0 K", "atoms": 500});
        assert_eq!(r.key(), recipe().key());
        let (mut a, mut b) = (recipe(), recipe());
        a.params = json!({"ab": "cd"});
        b.params = json!({"a": "bcd"});
        assert_ne!(a.key(), b.key());
    }

    /// One pinned key: a change of the canonical form must be deliberate, and bump [`Recipe::FORMAT`].
    #[test]
    fn pinned() {
        assert_eq!(recipe().key().short(), "a46ac99c98ae");
    }
}
