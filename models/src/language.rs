//! The language of the compiler, as the runtime's scenes ask for it.

use std::ops::Range;
use std::path::Path;

use pdlang::assemble::Kinematics;
use pdlang::diag::Diagnostic;
use pdlang::ir::{self, ExprKind};
use pdlang::span::Span;
use pdlang::units::Unit;
use pdlang::{assemble, direct, front, quantity};
use pdlang_runtime::engine::Law;
use pdlang_runtime::language::{
    Compiled, Complaint, Constant, Expected, Exponents, Language, LawError, Variable,
};
use pdlang_runtime::scene::nearest;
use pdlang_runtime::spec::{InfluenceFn, Op, Spec, Tape};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::registry;

/// Expressions, laws and influence functions through the compiler.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pdlang;

impl Language for Pdlang {
    fn expression(
        &self,
        text: &str,
        variables: &[Variable],
        expected: Expected,
    ) -> Result<Compiled, Vec<Complaint>> {
        if let Ok(number) = quantity::parse(text) {
            let read = literal(text, &number, expected);
            // `1 um*t` grows with the time, where a micrometre times a tonne is not what is wanted.
            return match mentions(text, variables)
                && (expected == Expected::Scalar || read.is_err())
            {
                true => strict(text, variables, expected).or(read),
                false => read,
            };
        }
        strict(text, variables, expected).or_else(|problems| {
            plain(text, variables, expected).ok_or_else(|| complaints(text, &problems))
        })
    }

    fn law(&self, name: &str, directory: &Path, dim: usize) -> Result<Law, LawError> {
        if let Some(law) = registry::find(name).and_then(|entry| entry.compiled(dim)) {
            return Ok(law);
        }
        let source = source(name, directory)?;
        interpreted(&source.law, dim, Kinematics::General).map_err(|d| source.broken(&d))
    }

    fn linearised(&self, name: &str, directory: &Path, dim: usize) -> Result<Law, LawError> {
        let compiled = registry::find(name).and_then(|entry| entry.compiled_linearised(dim));
        if let Some(law) = compiled {
            return Ok(law);
        }
        let source = source(name, directory)?;
        interpreted(&source.law, dim, Kinematics::Linearised).map_err(|found| LawError {
            message: format!("the law `{name}` cannot be linearised"),
            help: Some("leave `linearised` out".into()),
            ..source.broken(&found)
        })
    }

    fn influence(
        &self,
        text: &str,
        constants: &[Constant],
    ) -> Result<(InfluenceFn, Vec<f64>), Vec<Complaint>> {
        let (function, values) = influence(text, constants).map_err(|d| complaints(text, &d))?;
        match carried(&assemble::influence_fn(&function)) {
            Ok(function) => Ok((function, values)),
            Err(message) => Err(vec![whole(text, message)]),
        }
    }

    fn unit_name(&self, unit: Exponents) -> String {
        Unit {
            base: unit,
            opaque: Vec::new(),
        }
        .symbol()
    }
}

/// A law by the name of the catalogue, or by the path of a `.pd` file relative to `directory`.
///
/// # Errors
/// When there is no such law, or when its text has errors.
pub fn find(name: &str, directory: &Path) -> Result<ir::Law, LawError> {
    source(name, directory).map(|source| source.law)
}

/// A law and where it stands.
struct Source {
    /// As messages call it.
    name: String,
    text: String,
    law: ir::Law,
}

impl Source {
    fn broken(&self, diagnostics: &[Diagnostic]) -> LawError {
        broken(&self.name, &self.text, diagnostics)
    }
}

fn source(name: &str, directory: &Path) -> Result<Source, LawError> {
    if is_path(name) {
        return law_file(&directory.join(name));
    }
    let entry = registry::find(name).ok_or_else(|| unknown(name))?;
    let law = entry.law().map_err(|d| broken(name, entry.text, &d))?;
    Ok(Source {
        name: name.into(),
        text: entry.text.into(),
        law,
    })
}

/// A choice of influence function, as the compiler has it.
pub(crate) fn influence(
    text: &str,
    constants: &[Constant],
) -> Result<(ir::InfluenceFn, Vec<f64>), Vec<Diagnostic>> {
    let constants: Vec<(&str, f64, Unit)> = constants
        .iter()
        .map(|c| (c.name.as_str(), c.value, of(c.unit)))
        .collect();
    front::influence_call(text, &constants)
}

/// Whether a word of a text is the name of a variable.
fn mentions(text: &str, variables: &[Variable]) -> bool {
    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    words
        .into_iter()
        .any(|word| variables.iter().any(|v| v.name == word))
}

/// A number with or without a unit; without one it is in SI.
fn literal(
    text: &str,
    number: &quantity::Quantity,
    expected: Expected,
) -> Result<Compiled, Vec<Complaint>> {
    let trimmed = text.trim_start();
    let start = text.len() - trimmed.len();
    let span = start..start + trimmed.trim_end().len();
    let complain = |message: String, label: String, help: String| {
        Err(vec![Complaint {
            span: span.clone(),
            message,
            label,
            help: Some(help),
        }])
    };
    let tape = Tape {
        ops: vec![Op::Lit(number.value)],
        outs: vec![0],
    };
    match expected {
        Expected::Unit(unit) if number.has_unit && number.unit.base != unit => {
            let wanted = Unit {
                base: unit,
                opaque: Vec::new(),
            }
            .symbol();
            complain(
                format!(
                    "wrong unit: expected {wanted}, found {}",
                    number.unit.symbol()
                ),
                format!("this is in {}", number.unit.symbol()),
                format!("give it in {wanted}, or as a plain number in SI units"),
            )
        }
        Expected::Condition => complain(
            "expected a condition, found a number".into(),
            "this is not true or false".into(),
            "compare something, as in `x < 1 mm`".into(),
        ),
        Expected::Unit(unit) => Ok(Compiled { tape, unit }),
        Expected::Scalar => Ok(Compiled {
            tape,
            unit: number.unit.base,
        }),
    }
}

/// With every unit checked.
fn strict(
    text: &str,
    variables: &[Variable],
    expected: Expected,
) -> Result<Compiled, Vec<Diagnostic>> {
    let variables: Vec<(&str, Unit)> = variables
        .iter()
        .map(|v| (v.name.as_str(), of(v.unit)))
        .collect();
    let wanted = match expected {
        Expected::Unit(unit) => Some(of(unit)),
        _ => None,
    };
    let found = front::expression(text, &variables, wanted.as_ref())?;
    compiled(&found, expected)
}

/// As plain numbers in SI, for an expression in which no unit appears: neither written nor in a constant.
fn plain(text: &str, variables: &[Variable], expected: Expected) -> Option<Compiled> {
    let coordinate = |v: &Variable| matches!(v.name.as_str(), "x" | "y" | "z" | "t");
    let bare: Vec<(&str, Unit)> = variables
        .iter()
        .map(|v| {
            (
                v.name.as_str(),
                if coordinate(v) {
                    Unit::NUMBER
                } else {
                    of(v.unit)
                },
            )
        })
        .collect();
    let number = matches!(expected, Expected::Unit(_)).then_some(Unit::NUMBER);
    let found = front::expression(text, &bare, number.as_ref()).ok()?;
    let written = |e: &ir::Expr| !matches!(e.kind, ExprKind::Number(_)) || e.unit.is_number();
    let compiled = compiled(&found, expected).ok()?;
    let read = |op: &Op| match op {
        Op::Var(k) => bare
            .get(*k as usize)
            .is_some_and(|(_, unit)| unit.is_number()),
        _ => true,
    };
    if !found.exprs.iter().all(written) || !compiled.tape.ops.iter().all(read) {
        return None;
    }
    match expected {
        Expected::Unit(unit) => Some(Compiled { unit, ..compiled }),
        _ => Some(compiled),
    }
}

fn compiled(found: &front::Expression, expected: Expected) -> Result<Compiled, Vec<Diagnostic>> {
    let root = &found.exprs[found.root.index()];
    let wanted = if expected == Expected::Condition {
        ir::Shape::Boolean
    } else {
        ir::Shape::Scalar
    };
    let words = |shape| match shape {
        ir::Shape::Boolean => "a condition",
        ir::Shape::Scalar => "a number",
        _ => "a vector or tensor",
    };
    let wrong = || {
        let message = format!("expected {}, found {}", words(wanted), words(root.shape));
        vec![Diagnostic::error("PD000", message).at(root.span, "")]
    };
    if root.shape != wanted {
        return Err(wrong());
    }
    let tape = carried(&direct::tape(&found.exprs, found.root))
        .map_err(|message| vec![Diagnostic::error("PD000", message)])?;
    Ok(Compiled {
        tape,
        unit: root.unit.base,
    })
}

fn of(unit: Exponents) -> Unit {
    Unit {
        base: unit,
        opaque: Vec::new(),
    }
}

fn complaints(text: &str, diagnostics: &[Diagnostic]) -> Vec<Complaint> {
    diagnostics
        .iter()
        .filter(|d| d.is_error())
        .map(|d| complaint(text, d))
        .collect()
}

fn complaint(text: &str, diagnostic: &Diagnostic) -> Complaint {
    let (span, label) = match diagnostic.labels.first() {
        Some((span, label)) => (range(*span, text), label.clone()),
        None => (0..text.len(), String::new()),
    };
    Complaint {
        span,
        message: diagnostic.message.clone(),
        label,
        help: diagnostic.help.clone(),
    }
}

fn range(span: Span, text: &str) -> Range<usize> {
    if span.prelude {
        0..text.len()
    } else {
        span.start as usize..span.end as usize
    }
}

fn whole(text: &str, message: String) -> Complaint {
    Complaint {
        span: 0..text.len(),
        message,
        label: String::new(),
        help: None,
    }
}

/// What the compiler writes, as the runtime reads it: the two meet as JSON only.
pub(crate) fn carried<T: DeserializeOwned>(written: &impl Serialize) -> Result<T, String> {
    serde_json::to_value(written)
        .and_then(serde_json::from_value)
        .map_err(|e| format!("this has no form that the runtime reads: {e}"))
}

fn is_path(name: &str) -> bool {
    name.ends_with(".pd") || name.contains(['/', '\\'])
}

fn law_file(path: &Path) -> Result<Source, LawError> {
    let shown = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|e| LawError {
        message: format!("cannot read the law file `{shown}`: {e}"),
        help: Some("a path is relative to the folder of the scene".into()),
        report: None,
    })?;
    let checked = front::file_in(&text, &shown, &mut crate::files::read);
    if checked.diagnostics.iter().any(Diagnostic::is_error) {
        return Err(broken(&shown, &text, &checked.diagnostics));
    }
    let count = checked.laws.len();
    match (checked.laws.into_iter().next(), count) {
        (Some(law), 1) => Ok(Source {
            name: shown,
            text,
            law,
        }),
        _ => Err(LawError {
            message: format!("`{shown}` holds {count} laws"),
            help: Some("a scene needs a file with one law".into()),
            report: None,
        }),
    }
}

/// A law as tapes.
pub(crate) fn interpreted(
    law: &ir::Law,
    dim: usize,
    kinematics: Kinematics,
) -> Result<Law, Vec<Diagnostic>> {
    let spec = assemble::spec(law, dim, kinematics)?;
    let spec: Spec = carried(&spec).map_err(|message| vec![Diagnostic::error("PD000", message)])?;
    Ok(Law::interpreted(spec))
}

fn unknown(name: &str) -> LawError {
    let names = registry::names();
    let near = nearest(name, &names);
    LawError {
        message: format!("there is no law `{name}` in the catalogue"),
        help: Some(match near {
            Some(near) => format!("did you mean \"{near}\"? `pdlang models` lists all"),
            None => format!("known laws: {}; or give a .pd file", names.join(", ")),
        }),
        report: None,
    }
}

fn broken(name: &str, text: &str, diagnostics: &[Diagnostic]) -> LawError {
    let errors = diagnostics.iter().filter(|d| d.is_error());
    let shown: Vec<String> = errors.map(|d| d.render(text, name, false)).collect();
    LawError {
        message: format!("the law `{name}` has errors"),
        help: None,
        report: Some(shown.join("\n\n")),
    }
}
