//! TOML values that remember where they were written.
use crate::mistake::{At, Mistake, Source};
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// A value and its place.
#[derive(Clone, Debug)]
pub struct Value {
    /// What was written.
    pub node: Node,
    /// Where.
    pub at: At,
}

/// What a value is.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Node {
    Bool(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    List(Vec<Value>),
    Table(Table),
}

/// A table in the order it was written.
#[derive(Clone, Debug, Default)]
pub struct Table(pub Vec<(Key, Value)>);

/// A key and its place.
#[derive(Clone, Debug)]
pub struct Key {
    /// Its text.
    pub text: String,
    /// Where.
    pub at: At,
}

impl Key {
    /// Whether it can name a file and a reference, as the names of steps and blocks do.
    ///
    /// # Errors
    /// [`Mistake`] where it has other characters; `what` it would be the name of.
    pub fn plain(&self, what: &str) -> Result<(), Mistake> {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
        if !self.text.is_empty() && self.text.chars().all(plain) {
            return Ok(());
        }
        let mistake = Mistake::new(format!("`{}` is no name for {what}", self.text));
        Err(mistake.at(&self.at, "use letters, digits, `_` and `-`"))
    }
}

impl Table {
    /// Whether it has no other keys than `keys`; `of` it, for people.
    ///
    /// # Errors
    /// [`Mistake`] at the first other one.
    pub fn only(&self, keys: &[&str], of: &str) -> Result<(), Mistake> {
        let Some((wrong, _)) = self.0.iter().find(|(k, _)| !keys.contains(&k.text.as_str())) else { return Ok(()) };
        let mistake = Mistake::new(format!("unknown key `{}` in {of}", wrong.text)).at(&wrong.at, "not known here");
        Err(mistake.nearest(&wrong.text, keys.iter().copied()))
    }
    /// The value at `key`, without which `of`, which begins at `at`, can't be.
    ///
    /// # Errors
    /// [`Mistake`] where there is none.
    pub fn needed(&self, key: &str, of: &str, at: &At) -> Result<&Value, Mistake> {
        self.get(key).ok_or_else(|| Mistake::new(format!("{of} lacks `{key}`")).at(at, "here"))
    }
    /// The value at `key`.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.0.iter().find(|(k, _)| k.text == key).map(|(_, v)| v)
    }
    /// The value at `key`, to change it.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Value> {
        self.0.iter_mut().find(|(k, _)| k.text == key).map(|(_, v)| v)
    }
    /// Puts `value` at the literal key, in place of what was there.
    pub fn replace(&mut self, key: Key, value: Value) {
        match self.get_mut(&key.text) {
            Some(old) => *old = value,
            None => self.0.push((key, value)),
        }
    }
    /// Takes the entry at `key` out.
    pub fn take(&mut self, key: &str) -> Option<(Key, Value)> {
        let i = self.0.iter().position(|(k, _)| k.text == key)?;
        Some(self.0.remove(i))
    }
    /// Sets the value at a dotted path; tables on the way are made, other values on the way are a mistake.
    pub fn set(&mut self, path: &Key, value: Value) -> Result<(), Mistake> {
        let (first, rest) = path.text.split_once('.').map_or((path.text.as_str(), None), |(a, b)| (a, Some(b)));
        let i = self.0.iter().position(|(k, _)| k.text == first).unwrap_or_else(|| {
            let key = Key { text: first.into(), at: path.at.clone() };
            self.0.push((key, Value { node: Node::Table(Table::default()), at: path.at.clone() }));
            self.0.len() - 1
        });
        let Some(rest) = rest else {
            self.0[i].1 = value;
            return Ok(());
        };
        match &mut self.0[i].1.node {
            Node::Table(t) => t.set(&Key { text: rest.into(), at: path.at.clone() }, value),
            _ => {
                Err(Mistake::new(format!("`{first}` is no table, so `{}` can't be set", path.text))
                    .at(&path.at, "here"))
            }
        }
    }
    /// The place of the value at a dotted path, or of the nearest part of it that is there; `key` marks the key instead.
    pub fn place(&self, path: &str, key: bool) -> Option<At> {
        let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
        let first = first.split('[').next().unwrap_or(first);
        let (k, v) = self.0.iter().find(|(k, _)| k.text == first)?;
        let deeper = match (&v.node, rest) {
            (Node::Table(t), Some(rest)) => t.place(rest, key),
            _ => None,
        };
        Some(deeper.unwrap_or_else(|| if key { k.at.clone() } else { v.at.clone() }))
    }
}

impl Value {
    /// As JSON, for the stages' parameter types.
    pub fn json(&self) -> serde_json::Value {
        match &self.node {
            Node::Bool(b) => (*b).into(),
            Node::Integer(i) => (*i).into(),
            Node::Float(x) => (*x).into(),
            Node::Text(s) => s.as_str().into(),
            Node::List(items) => items.iter().map(Value::json).collect(),
            Node::Table(t) => t.0.iter().map(|(k, v)| (k.text.clone(), v.json())).collect(),
        }
    }
    /// As a person writes it, in one line.
    pub fn label(&self) -> String {
        match &self.node {
            Node::Text(s) => s.clone(),
            Node::Table(t) => {
                let parts: Vec<_> = t.0.iter().map(|(k, v)| format!("{}={}", k.text, v.label())).collect();
                format!("{{{}}}", parts.join(", "))
            }
            Node::List(items) => format!("[{}]", items.iter().map(Value::label).collect::<Vec<_>>().join(", ")),
            _ => self.json().to_string(),
        }
    }
    /// What kind of value it is, for messages.
    pub fn kind(&self) -> &'static str {
        match self.node {
            Node::Bool(_) => "true or false",
            Node::Integer(_) | Node::Float(_) => "a number",
            Node::Text(_) => "text",
            Node::List(_) => "a list",
            Node::Table(_) => "a table",
        }
    }
    /// The text, or a mistake that says what was wanted.
    pub fn text(&self, wanted: &str) -> Result<&str, Mistake> {
        match &self.node {
            Node::Text(s) => Ok(s),
            _ => Err(Mistake::new(format!("expected {wanted}")).at(&self.at, format!("this is {}", self.kind()))),
        }
    }
    /// The table, or a mistake that says what was wanted.
    pub fn table(&self, wanted: &str) -> Result<&Table, Mistake> {
        match &self.node {
            Node::Table(t) => Ok(t),
            _ => Err(Mistake::new(format!("expected {wanted}")).at(&self.at, format!("this is {}", self.kind()))),
        }
    }
}

/// Parses a TOML document.
///
/// # Errors
/// [`Mistake`] at the place where it is no TOML, or holds a value that no pipeline has (a date, a NaN).
pub fn parse(source: &Arc<Source>) -> Result<Table, Mistake> {
    let document = DeTable::parse(&source.text).map_err(|e| {
        let mistake = Mistake::new(format!("{} is not valid TOML", source.name));
        let span = e.span().unwrap_or(0..0);
        mistake.at(&At { source: source.clone(), span }, e.message())
    })?;
    table(document.get_ref(), source)
}

fn table(found: &DeTable<'_>, source: &Arc<Source>) -> Result<Table, Mistake> {
    let at = |span| At { source: source.clone(), span };
    let entries = found.iter().map(|(k, v)| {
        let key = Key { text: k.get_ref().to_string(), at: at(k.span()) };
        Ok((key, value(v.get_ref(), at(v.span()), source)?))
    });
    entries.collect::<Result<_, _>>().map(Table)
}

fn value(found: &DeValue<'_>, at: At, source: &Arc<Source>) -> Result<Value, Mistake> {
    let node = match found {
        DeValue::String(s) => Node::Text(s.to_string()),
        DeValue::Boolean(b) => Node::Bool(*b),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(i) => Node::Integer(i),
            Err(e) => return Err(Mistake::new(format!("not an integer: {e}")).at(&at, "here")),
        },
        DeValue::Float(x) => match x.as_str().parse::<f64>() {
            Ok(x) if x.is_finite() => Node::Float(x),
            _ => return Err(Mistake::new("a number must be finite").at(&at, "this is not")),
        },
        DeValue::Array(items) => {
            let items = items.iter().map(|v| {
                let at = At { source: source.clone(), span: v.span() };
                value(v.get_ref(), at, source)
            });
            Node::List(items.collect::<Result<_, _>>()?)
        }
        DeValue::Table(t) => Node::Table(table(t, source)?),
        DeValue::Datetime(_) => return Err(Mistake::new("no stage takes a date").at(&at, "here")),
    };
    Ok(Value { node, at })
}
