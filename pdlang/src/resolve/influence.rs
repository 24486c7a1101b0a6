//! Influence functions: library definitions, and what a law or a scene chooses for one.

use crate::ast;
use crate::check::{bounds, duplicates, influences, quantities, reserved, suggest};
use crate::diag::Diagnostic;
use crate::ir::{ExprId, ExprKind, InfluenceFn, Param, Shape};
use crate::resolve::elaborate::{Context, Elaborator};
use crate::resolve::library::Library;
use crate::resolve::names;
use crate::resolve::params;
use crate::span::Span;
use crate::units::Unit;

/// `influence softened(r; p : number, eps : length > 0) = ..`
pub(crate) fn function(
    written: &ast::InfluenceFn,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<InfluenceFn> {
    let mut names = vec![written.variable.clone()];
    let mut good = reserved::allowed(&written.variable, report);
    for param in &written.params {
        good &= reserved::allowed(&param.name, report)
            && duplicates::among(&names, &param.name, report);
        names.push(param.name.clone());
    }
    let params: Vec<Option<Param>> = written
        .params
        .iter()
        .map(|param| params::param(param, report))
        .collect();
    let params: Vec<Param> = params.into_iter().collect::<Option<_>>().filter(|_| good)?;
    let variables = std::iter::once((written.variable.text.as_str(), Unit::length()));
    let variables = variables.chain(
        params
            .iter()
            .map(|param| (param.name.as_str(), param.unit.clone())),
    );
    let (body, exprs) = body(variables, &written.body, library, report)?;
    let doc = written
        .doc
        .as_ref()
        .map(|doc| doc.text.clone())
        .unwrap_or_default();
    Some(InfluenceFn {
        name: written.name.text.clone(),
        doc,
        params,
        body,
        exprs,
    })
}

type Body = (ExprId, Vec<crate::ir::Expr>);

fn body<'n>(
    variables: impl Iterator<Item = (&'n str, Unit)>,
    written: &ast::Expr,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<Body> {
    let mut elaborator = Elaborator::new(library, Context::Influence, report);
    elaborator.add_variables(variables);
    elaborator.add_constants();
    let root = elaborator.elaborate(written)?;
    if elaborator.expr(root).shape != Shape::Scalar {
        return elaborator.wrong(influences::not_scalar(written.span));
    }
    Some((root, elaborator.exprs))
}

/// What is chosen for an influence function: the name of one, a call with named parameters, or an
/// expression in the bond length `x`. The values chosen become the defaults of the parameters.
pub(crate) fn choice(
    written: &ast::Expr,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<InfluenceFn> {
    match &written.kind {
        ast::ExprKind::Name(name) if name != "x" && library.influence(name).is_some() => {
            call(name, &[], written.span, library, report)
        }
        ast::ExprKind::Name(name) if library.own.broken.contains(name) => None,
        ast::ExprKind::Call { name, args, .. } if library.influence(&name.text).is_some() => {
            call(&name.text, args, name.span, library, report)
        }
        ast::ExprKind::Name(name) if misspelt(name, library) => {
            unknown(name, written.span, library, report)
        }
        // Nothing but an influence function takes arguments by name, so nothing else can be meant.
        ast::ExprKind::Call { name, args, .. }
            if args.iter().any(|arg| arg.name.is_some()) || misspelt(&name.text, library) =>
        {
            unknown(&name.text, name.span, library, report)
        }
        _ => {
            let (body, exprs) = body(
                std::iter::once(("x", Unit::length())),
                written,
                library,
                report,
            )?;
            let name = library
                .text
                .get(written.span.start as usize..written.span.end as usize)
                .unwrap_or_default();
            Some(InfluenceFn {
                name: name.to_string(),
                doc: String::new(),
                params: Vec::new(),
                body,
                exprs,
            })
        }
    }
}

/// Whether this is no name at all, but nearly that of an influence function.
fn misspelt(name: &str, library: &Library) -> bool {
    let constants = library.constants.iter().map(|constant| constant.0.as_str());
    let primitives = names::PRIMITIVES.iter().map(|primitive| primitive.name);
    let builtins = names::BUILTINS.iter().map(|builtin| builtin.0);
    let mut known = constants.chain(primitives).chain(builtins).chain(["x"]);
    let functions = library.influences().map(|known| &known.name);
    !known.any(|known| known == name)
        && library.function(name, false).is_none()
        && library.definition(name, false).is_none()
        && suggest::nearest(name, functions).is_some()
}

fn unknown<T>(
    name: &str,
    span: Span,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<T> {
    let known: Vec<&str> = library.influences().map(|f| f.name.as_str()).collect();
    report.push(influences::unknown(name, span, &known));
    None
}

fn call(
    name: &str,
    args: &[ast::Argument],
    span: Span,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<InfluenceFn> {
    let mut function = library.influence(name)?.clone();
    let known: Vec<String> = function
        .params
        .iter()
        .map(|param| param.name.clone())
        .collect();
    let mut given = Vec::new();
    let mut good = true;
    for arg in args {
        good &= argument(&mut function, arg, &known, &mut given, library, report).is_some();
    }
    let missing: Vec<String> = function
        .params
        .iter()
        .filter(|param| param.default.is_none())
        .map(|param| param.name.clone())
        .collect();
    if good && !missing.is_empty() {
        report.push(influences::missing(name, &missing, span));
        return None;
    }
    good.then_some(function)
}

/// Puts one named argument in place.
fn argument(
    function: &mut InfluenceFn,
    arg: &ast::Argument,
    known: &[String],
    given: &mut Vec<String>,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let Some(name) = &arg.name else {
        report.push(influences::unnamed(&function.name, arg.value.span, known));
        return None;
    };
    let Some(param) = function
        .params
        .iter_mut()
        .find(|param| param.name == name.text)
    else {
        report.push(influences::unknown_parameter(&function.name, name, known));
        return None;
    };
    if given.contains(&name.text) {
        report.push(influences::twice(name));
        return None;
    }
    given.push(name.text.clone());
    let value = number(&name.text, &arg.value, &param.unit, library, report)?;
    if !bounds::contains(param.lower, param.upper, value) {
        report.push(influences::outside(&name.text, arg.value.span));
        return None;
    }
    param.default = Some(value);
    Some(())
}

/// SI value of an expression of numbers.
fn number(
    name: &str,
    written: &ast::Expr,
    unit: &Unit,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<f64> {
    let what = format!("`{name}`");
    let mut elaborator = Elaborator::new(library, Context::Scene, report);
    elaborator.add_constants();
    let root = elaborator.elaborate(written)?;
    let (value, any_unit) = (
        elaborator.facts(root).literal,
        elaborator.facts(root).any_unit,
    );
    let found = elaborator.expr(root).unit.clone();
    let has_unit = !found.is_number() || !matches!(elaborator.expr(root).kind, ExprKind::Number(_));
    if found != *unit && !any_unit {
        let symbol = has_unit.then(|| found.describe(&[]));
        report.push(quantities::wrong_unit(
            &what,
            written.span,
            symbol.as_deref(),
            &unit.describe(&[]),
        ));
        return None;
    }
    if value.is_none() {
        report.push(quantities::not_a_number(&what, written.span));
    }
    value
}
