//! Typed reading of one table of a scene. Every question marks its key as known; what is left over is an
//! unknown key. All problems are collected, none stops the reading.

use std::cell::RefCell;
use std::ops::Range;

use super::document::{Data, Entry, Value};
use super::problem::Problem;
use super::reader::Reader;
use crate::language::Exponents;

/// A value with its place in the text, for problems that show only later.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Placed<T> {
    pub value: T,
    pub span: Range<usize>,
}

pub(super) struct Section<'a> {
    pub reader: &'a Reader<'a>,
    /// As a message names it: `[body]`.
    pub title: String,
    /// Where a missing key is complained about.
    pub span: Range<usize>,
    entries: &'a [Entry],
    asked: RefCell<Vec<String>>,
    /// Required keys that are not there, with an example.
    missing: RefCell<Vec<(String, String)>>,
}

impl<'a> Section<'a> {
    pub fn new(
        reader: &'a Reader<'a>,
        title: impl Into<String>,
        span: Range<usize>,
        entries: &'a [Entry],
    ) -> Section<'a> {
        Section {
            reader,
            title: title.into(),
            span,
            entries,
            asked: RefCell::default(),
            missing: RefCell::default(),
        }
    }

    /// The value of a key, which is known from now on.
    pub fn value(&self, key: &str) -> Option<&'a Value> {
        self.entry(key).map(|e| &e.value)
    }

    pub fn entry(&self, key: &str) -> Option<&'a Entry> {
        let mut asked = self.asked.borrow_mut();
        if !asked.iter().any(|k| k == key) {
            asked.push(key.to_string());
        }
        self.entries.iter().find(|e| e.key == key)
    }

    pub fn entries(&self) -> &'a [Entry] {
        self.entries
    }

    /// Notes that `key` is absent where it is needed. `example` shows what a value looks like.
    pub fn require<T>(&self, key: &str, found: Option<T>, example: &str) -> Option<T> {
        if found.is_none() && self.value(key).is_none() {
            self.missing.borrow_mut().push((key.into(), example.into()));
        }
        found
    }

    /// Complains about every key that nobody asked for, and about every key that is missing. A misspelt key
    /// is told once.
    pub fn finish(self) {
        let asked = self.asked.borrow().clone();
        let known: Vec<&str> = asked.iter().map(String::as_str).collect();
        let unknown = |e: &&Entry| !known.contains(&e.key.as_str());
        let mut blamed: Vec<&'a str> = Vec::new();
        for entry in self.entries.iter().filter(unknown) {
            let near = nearest(&entry.key, &known);
            self.missing
                .borrow_mut()
                .retain(|(key, _)| near != Some(key));
            self.reader
                .complain(unknown_key(&self.title, entry, near, &known));
            blamed.push(&entry.key);
        }
        self.absent(blamed);
    }

    /// Complains about missing keys only: for a section that cannot be read to its end.
    pub fn abandon(&self) {
        self.absent(Vec::new());
    }

    /// Missing keys, each once. `blamed` are keys that have been complained about.
    fn absent(&self, mut blamed: Vec<&'a str>) {
        let asked = self.asked.borrow();
        for (key, example) in self.missing.take() {
            // Written otherwise: that is one problem, not two. A key is one of those that are missing, not several.
            let meant = |e: &&Entry| {
                let free = !asked.contains(&e.key) && !blamed.contains(&e.key.as_str());
                free && nearest(&e.key, &[&key]).is_some()
            };
            if let Some(entry) = self.entries.iter().find(meant) {
                blamed.push(&entry.key);
                let problem = unknown_key(&self.title, entry, Some(&key), &[]);
                self.reader.complain(problem);
                continue;
            }
            let problem = Problem::new(format!("{} has no `{key}`", self.title))
                .at(self.span.clone(), format!("`{key}` is missing here"))
                .help(format!("add {key} = {example}"));
            self.reader.complain(problem);
        }
    }

    pub fn text(&self, key: &str) -> Option<Placed<&'a str>> {
        let value = self.value(key)?;
        match &value.data {
            Data::Text(s) => Some(Placed {
                value: s.as_str(),
                span: value.span.clone(),
            }),
            _ => self.reader.wrong_type(value, "a text in quotes"),
        }
    }

    pub fn flag(&self, key: &str) -> Option<bool> {
        let value = self.value(key)?;
        match value.data {
            Data::Flag(b) => Some(b),
            _ => self.reader.wrong_type(value, "true or false"),
        }
    }

    /// A whole number of at least `least`.
    pub fn count(&self, key: &str, least: u64) -> Option<u64> {
        let value = self.value(key)?;
        match value.data {
            Data::Number(n, true) if n >= least as f64 => Some(n as u64),
            Data::Number(..) => {
                let problem = Problem::new(format!("`{key}` must be a whole number")).at(
                    value.span.clone(),
                    format!("expected a whole number, {least} or more"),
                );
                self.reader.complain(problem);
                None
            }
            _ => self.reader.wrong_type(value, "a whole number"),
        }
    }

    /// One of several words.
    pub fn choice<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Option<T> {
        let word = self.text(key)?;
        if let Some((_, chosen)) = words.iter().find(|(w, _)| *w == word.value) {
            return Some(*chosen);
        }
        let names: Vec<&str> = words.iter().map(|(w, _)| *w).collect();
        let problem = Problem::new(format!("`{key}` cannot be \"{}\"", word.value))
            .at(word.span, format!("expected {}", listed(&names)));
        self.reader.complain(match nearest(word.value, &names) {
            Some(near) => problem.help(format!("did you mean \"{near}\"?")),
            None => problem,
        });
        None
    }

    /// A number with a unit, in SI.
    pub fn quantity(&self, key: &str, unit: Exponents) -> Option<Placed<f64>> {
        let value = self.value(key)?;
        let found = self.reader.quantity(value, unit)?;
        Some(Placed {
            value: found,
            span: value.span.clone(),
        })
    }

    pub fn positive(&self, key: &str, unit: Exponents) -> Option<Placed<f64>> {
        let found = self.quantity(key, unit)?;
        if found.value > 0.0 {
            return Some(found);
        }
        let problem = Problem::new(format!("`{key}` must be positive")).at(
            found.span,
            format!("this is {}", self.reader.shown(found.value, unit)),
        );
        self.reader.complain(problem);
        None
    }

    /// One quantity per dimension; the components beyond are 0.
    pub fn vector(&self, key: &str, unit: Exponents, dim: usize) -> Option<[f64; 3]> {
        self.reader.vector(self.value(key)?, unit, dim)
    }

    /// A table under `key`.
    pub fn section(&self, key: &str) -> Option<Section<'a>> {
        let entry = self.entry(key)?;
        self.reader.section_of(
            &entry.value,
            title_of(&self.title, key),
            entry.key_span.clone(),
        )
    }

    /// The tables of `[[key]]`; one table alone counts as a list of one.
    pub fn sections(&self, key: &str) -> Vec<Section<'a>> {
        let Some(entry) = self.entry(key) else {
            return Vec::new();
        };
        let title = format!("[{}]", title_of(&self.title, key));
        let Data::List(items) = &entry.value.data else {
            return self
                .reader
                .section_of(&entry.value, title, entry.key_span.clone())
                .into_iter()
                .collect();
        };
        items
            .iter()
            .filter_map(|v| self.reader.section_of(v, title.clone(), v.span.clone()))
            .collect()
    }
}

/// `[a]`, `[a.b]`, for messages.
fn title_of(parent: &str, key: &str) -> String {
    match parent.trim_start_matches('[').trim_end_matches(']') {
        "" | "the scene" => format!("[{key}]"),
        parent => format!("[{parent}.{key}]"),
    }
}

fn unknown_key(title: &str, entry: &Entry, near: Option<&str>, known: &[&str]) -> Problem {
    let problem = Problem::new(format!("unknown key `{}` in {title}", entry.key))
        .at(entry.key_span.clone(), "no such key");
    match near {
        Some(near) => problem.help(format!("did you mean `{near}`?")),
        None => problem.help(format!("known keys: {}", ticked(known))),
    }
}

/// What is also called so: in probes, in papers and in other programs.
const ALSO: [(&str, &str); 8] = [
    ("area", "cross_section"),
    ("dx", "spacing"),
    ("h", "thickness"),
    ("delta", "horizon"),
    ("rho", "density"),
    ("law", "model"),
    ("dimension", "flavour"),
    ("t_end", "until"),
];

/// The most similar of some words, if one is similar at all.
pub fn nearest<'w>(word: &str, words: &[&'w str]) -> Option<&'w str> {
    let also = ALSO.iter().filter(|(other, _)| *other == word);
    let mut called = also.filter_map(|(_, name)| words.iter().find(|w| *w == name).copied());
    if let Some(name) = called.next() {
        return Some(name);
    }
    words
        .iter()
        .map(|w| (strsim::normalized_damerau_levenshtein(word, w), *w))
        .filter(|(likeness, _)| *likeness >= 0.5)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, w)| w)
}

/// `"a", "b" or "c"`.
pub(super) fn listed(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|w| format!("\"{w}\"")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
        None => String::new(),
    }
}

fn ticked(words: &[&str]) -> String {
    words
        .iter()
        .map(|w| format!("`{w}`"))
        .collect::<Vec<_>>()
        .join(", ")
}
