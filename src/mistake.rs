//! What a user wrote wrong: where, what was expected, and the nearest right name; shown with the line and the text marked.
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A text that was read: a pipeline file, an included one, or a `--set` argument.
#[derive(Debug)]
pub struct Source {
    /// How it is called in messages.
    pub name: String,
    /// The text.
    pub text: String,
}

/// A place in a text.
#[derive(Clone, Debug)]
pub struct At {
    /// The text.
    pub source: Arc<Source>,
    /// Bytes in it.
    pub span: Range<usize>,
}

/// Input that can't be used: exit code 2, nothing run.
#[derive(Debug)]
pub struct Mistake {
    title: String,
    at: Option<At>,
    label: String,
    help: Vec<String>,
}

impl Mistake {
    /// A mistake with no place in a text.
    pub fn new(title: impl Into<String>) -> Mistake {
        Mistake { title: title.into(), at: None, label: String::new(), help: Vec::new() }
    }
    /// Marks a place in a text with a few words.
    pub fn at(mut self, at: &At, label: impl Into<String>) -> Mistake {
        self.at = Some(at.clone());
        self.label = label.into();
        self
    }
    /// Says what to do.
    pub fn help(mut self, help: impl Into<String>) -> Mistake {
        self.help.push(help.into());
        self
    }
    /// Names the nearest of `known` names, or all of them.
    pub fn nearest<'a>(self, wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Mistake {
        let mut known: Vec<&str> = known.into_iter().collect();
        let mut seen = std::collections::HashSet::new();
        known.retain(|name| seen.insert(*name));
        let score = |name: &&str| strsim::jaro_winkler(wrong, name);
        let best = known.iter().copied().max_by(|a, b| score(a).total_cmp(&score(b)));
        match best.filter(|b| score(b) > 0.75) {
            Some(best) => self.help(format!("did you mean `{best}`?")),
            None if known.is_empty() => self,
            None => self.help(format!("expected one of: {}", known.join(", "))),
        }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut group = Level::ERROR.primary_title(&self.title).elements(Vec::<annotate_snippets::Element<'_>>::new());
        if let Some(at) = &self.at {
            let mark = AnnotationKind::Primary.span(at.span.clone()).label(&self.label);
            group = group.element(Snippet::source(&at.source.text).path(&at.source.name).annotation(mark));
        }
        for help in &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        write!(f, "{}", Renderer::plain().render(&[group]))
    }
}
