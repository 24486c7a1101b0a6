//! The doors of the language: texts in, typed laws and findings out. Nothing here panics, whatever the text.

use crate::diag::{self, Diagnostic};
use crate::files::{self, Files};
use crate::ir::{Expr, ExprId, InfluenceFn, Law, Shape};
use crate::parse;
use crate::resolve::library::{self, Library};
use crate::resolve::{self, Context, Elaborator};
use crate::units::Unit;
use crate::{ast, check};

/// What a file holds.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// The laws without errors.
    pub laws: Vec<Law>,
    /// The influence functions that the file defines; those of the prelude are in [`influences`].
    pub influences: Vec<InfluenceFn>,
    /// All findings, in the order of the text.
    pub diagnostics: Vec<Diagnostic>,
}

impl Checked {
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(Diagnostic::is_error)
    }
}

/// A text, as it was read and as it was understood.
pub(crate) struct Source<'a> {
    pub checked: Checked,
    /// What was understood of the laws with errors: to be looked at, not to be computed with.
    pub faulty: Vec<Law>,
    /// The tree of each model; of a text without errors, one per law.
    pub models: Vec<ast::Model>,
    pub library: Library<'a>,
}

/// Reads and checks a text of laws and library definitions that uses no files.
pub fn file(text: &str) -> Checked {
    file_in(text, "", &mut files::nowhere)
}

/// As [`file`], for the text of the file at `path`, which may use others.
pub fn file_in(text: &str, path: &str, files: &mut Files) -> Checked {
    source(text, path, files).checked
}

/// As [`file_in`], with the trees that the laws were made of.
pub(crate) fn source<'a>(text: &'a str, path: &str, files: &mut Files) -> Source<'a> {
    let mut report = Vec::new();
    let mut file = parse::file(text, false, &mut report);
    let mut models = std::mem::take(&mut file.models);
    if !file.uses.is_empty() && !resolve::modules::add(&mut file, path, files, &mut report) {
        models.clear();
        file = ast::File::default();
    }
    let library = Library::of(file, text, library::prelude(), &mut report);
    // What is to be said of a file that is used is said of it alone.
    report.retain(|finding| !finding.span().prelude);
    check_models_named_once(&models, &mut report);
    let (mut laws, mut faulty) = (Vec::new(), Vec::new());
    for model in &models {
        match resolve::law(model, &library, &mut report) {
            Ok(law) => laws.push(law),
            Err(law) => faulty.push(*law),
        }
    }
    diag::sort(&mut report);
    Source {
        checked: Checked {
            laws,
            influences: library.own.influences.clone(),
            diagnostics: report,
        },
        faulty,
        models,
        library,
    }
}

fn check_models_named_once(models: &[ast::Model], report: &mut Vec<Diagnostic>) {
    let mut seen = std::collections::HashMap::new();
    for model in models {
        check::duplicates::first(&mut seen, &model.name, report);
    }
}

/// The influence functions that every law finds defined.
pub fn influences() -> &'static [InfluenceFn] {
    &library::prelude().influences
}

/// An expression of a scene, such as an initial field. `Var(k)` is variable k.
#[derive(Clone, Debug)]
pub struct Expression {
    pub root: ExprId,
    pub exprs: Vec<Expr>,
}

impl Expression {
    /// Scalar or condition.
    pub fn shape(&self) -> Shape {
        self.exprs[self.root.index()].shape
    }

    pub fn unit(&self) -> &Unit {
        &self.exprs[self.root.index()].unit
    }
}

/// Reads an expression over variables with units. With `expected`, it must be a scalar of this unit;
/// literal zero fits any. Without, it may be a condition, and its unit is for the caller to judge.
///
/// # Errors
/// Findings that point into `text`.
pub fn expression(
    text: &str,
    variables: &[(&str, Unit)],
    expected: Option<&Unit>,
) -> Result<Expression, Vec<Diagnostic>> {
    let written = parse::expression(text)?;
    let library = Library::of(
        ast::File::default(),
        text,
        library::prelude(),
        &mut Vec::new(),
    );
    let mut report = Vec::new();
    let mut elaborator = Elaborator::new(&library, Context::Scene, &mut report);
    elaborator.add_variables(variables.iter().map(|(name, unit)| (*name, unit.clone())));
    let root = elaborator
        .elaborate(&written)
        .filter(|root| match expected {
            Some(unit) => elaborator.is_scalar_of(*root, unit),
            None => true,
        });
    let exprs = elaborator.exprs;
    match root {
        Some(root) if report.is_empty() => Ok(Expression { root, exprs }),
        _ => Err(report),
    }
}

/// Reads a choice of influence function: a name, a call with named parameters such as
/// `"softened(p = 0, eps = 0.5 mm)"`, or an expression in the bond length such as `"1/x"`. Known are
/// the functions of the prelude, and `constants` as names for numbers: SI value and unit.
///
/// Returns the function and a value for each of its parameters.
///
/// # Errors
/// Findings that point into `text`.
pub fn influence_call(
    text: &str,
    constants: &[(&str, f64, Unit)],
) -> Result<(InfluenceFn, Vec<f64>), Vec<Diagnostic>> {
    let written = parse::expression(text)?;
    let mut library = Library::of(
        ast::File::default(),
        text,
        library::prelude(),
        &mut Vec::new(),
    );
    let named = constants.iter();
    library.constants = named
        .map(|(name, value, unit)| (name.to_string(), *value, unit.clone()))
        .collect();
    let mut report = Vec::new();
    let function = resolve::influence::choice(&written, &library, &mut report);
    let values = function
        .as_ref()
        .and_then(|function| function.params.iter().map(|param| param.default).collect());
    function.zip(values).ok_or(report)
}
