//! Definitions that laws share: the prelude, and what a file defines outside of its models.

use crate::ast;
use crate::check;
use crate::diag::Diagnostic;
use crate::ir;
use crate::parse;
use crate::resolve::influence;
use crate::units::Unit;
use std::collections::{HashMap, HashSet};
use std::sync::LazyLock;

/// The shared definitions of one text, by name.
#[derive(Default)]
pub(crate) struct Shelf {
    pub functions: HashMap<String, ast::Function>,
    pub definitions: HashMap<String, ast::Definition>,
    pub influences: Vec<ir::InfluenceFn>,
    /// Names whose definition has an error that is reported already.
    pub broken: HashSet<String>,
}

/// What a file can see: its own shelf, and behind it the prelude.
pub(crate) struct Library<'a> {
    pub own: Shelf,
    pub prelude: &'a Shelf,
    /// The file itself, from which influence functions without a name take theirs.
    pub text: &'a str,
    /// Constants that a scene gives names: SI value and unit.
    pub constants: Vec<(String, f64, Unit)>,
}

/// The text that spans of the prelude point into.
pub(crate) const PRELUDE_TEXT: &str = include_str!("../prelude.pd");

static PRELUDE: LazyLock<Shelf> = LazyLock::new(|| {
    let mut report = Vec::new();
    let file = parse::file(PRELUDE_TEXT, true, &mut report);
    let nothing = Shelf::default();
    let shelf = Library::of(file, "", &nothing, &mut report).own;
    debug_assert!(report.is_empty(), "the prelude has errors: {report:?}");
    shelf
});

pub(crate) fn prelude() -> &'static Shelf {
    &PRELUDE
}

impl<'a> Library<'a> {
    /// The library that `file` sees; its models are left aside.
    pub(crate) fn of(
        file: ast::File,
        text: &'a str,
        prelude: &'a Shelf,
        report: &mut Vec<Diagnostic>,
    ) -> Library<'a> {
        let mut library = Library {
            own: Shelf::default(),
            prelude,
            text,
            constants: Vec::new(),
        };
        library.own.broken = file.broken.into_iter().map(|name| name.text).collect();
        library.add_functions(file.functions, report);
        library.add_definitions(file.definitions, report);
        library.add_influences(file.influences, report);
        library
    }

    fn add_functions(&mut self, functions: Vec<ast::Function>, report: &mut Vec<Diagnostic>) {
        let mut first = HashMap::new();
        for function in functions {
            let name = function.name.clone();
            if !check::reserved::allowed_function(&name, report)
                || !check::duplicates::first(&mut first, &name, report)
            {
                continue;
            }
            for (k, param) in function.params.iter().enumerate() {
                check::reserved::allowed(param, report);
                check::duplicates::among(&function.params[..k], param, report);
            }
            if self.prelude.functions.contains_key(&name.text) {
                report.push(check::shadowing::warning(&name, "function"));
            }
            self.own.functions.insert(name.text, function);
        }
    }

    fn add_definitions(&mut self, definitions: Vec<ast::Definition>, report: &mut Vec<Diagnostic>) {
        let mut first = HashMap::new();
        for definition in definitions {
            let name = definition.name.clone();
            if !check::reserved::allowed(&name, report)
                || !check::duplicates::first(&mut first, &name, report)
            {
                continue;
            }
            if self.prelude.definitions.contains_key(&name.text) {
                report.push(check::shadowing::warning(&name, "definition"));
            }
            self.own.definitions.insert(name.text, definition);
        }
    }

    fn add_influences(&mut self, influences: Vec<ast::InfluenceFn>, report: &mut Vec<Diagnostic>) {
        let mut first = HashMap::new();
        for written in influences {
            let name = written.name.clone();
            if !check::duplicates::first(&mut first, &name, report) {
                continue;
            }
            if self
                .prelude
                .influences
                .iter()
                .any(|known| known.name == name.text)
            {
                report.push(check::shadowing::warning(&name, "influence function"));
            }
            match influence::function(&written, self, report) {
                Some(function) => self.own.influences.push(function),
                None => drop(self.own.broken.insert(name.text)),
            }
        }
    }

    /// A function, as seen from the file or from the prelude itself.
    pub(crate) fn function(&self, name: &str, from_prelude: bool) -> Option<&ast::Function> {
        let own = if from_prelude {
            None
        } else {
            self.own.functions.get(name)
        };
        own.or_else(|| self.prelude.functions.get(name))
    }

    /// Whether [`Library::function`] answers with one of the prelude, which sees nothing but the prelude.
    pub(crate) fn is_prelude_function(&self, name: &str, from_prelude: bool) -> bool {
        from_prelude || !self.own.functions.contains_key(name)
    }

    pub(crate) fn definition(&self, name: &str, from_prelude: bool) -> Option<&ast::Definition> {
        let own = if from_prelude {
            None
        } else {
            self.own.definitions.get(name)
        };
        own.or_else(|| self.prelude.definitions.get(name))
    }

    pub(crate) fn influence(&self, name: &str) -> Option<&ir::InfluenceFn> {
        self.influences().find(|known| known.name == name)
    }

    /// All influence functions, those of the file first.
    pub(crate) fn influences(&self) -> impl Iterator<Item = &ir::InfluenceFn> {
        self.own.influences.iter().chain(&self.prelude.influences)
    }
}
