//! Every stage of the journey as text: what `pdlang emit` prints.
//!
//! Contract. Each function is total on laws that the checks accept, and prints the same for the same text:
//! the snapshots of the tests rest on it.

mod ast;
mod broken;
mod computed;
pub mod derived;
mod formulas;
pub(crate) mod ir;
mod latex;
mod page;
mod plain;
mod render;
mod rust;
mod symbols;

pub use render::{Form, Part};

use crate::assemble::{self, Kinematics};
use crate::diag::Diagnostic;
use crate::files::{self, Files};
use crate::front;
use crate::ir::Law;
use crate::spec::Spec;

/// What can be printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stage {
    /// The tree as it was read.
    Ast,
    /// The law after all checks, with functions inlined.
    Ir,
    /// The sweeps, after derivation and scheduling.
    Passes,
    /// The kernels, as a macro writes them.
    Rust,
    /// The page of the law, as LaTeX, as Markdown and, of `pdlang models`, for a terminal.
    Latex,
    Markdown,
    Terminal,
    /// Sweeps with their formulas and costs; of `pdlang explain`.
    Explained,
}

impl Stage {
    pub const ALL: [Stage; 6] = [
        Stage::Ast,
        Stage::Ir,
        Stage::Passes,
        Stage::Rust,
        Stage::Latex,
        Stage::Markdown,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Stage::Ast => "ast",
            Stage::Ir => "ir",
            Stage::Passes => "passes",
            Stage::Rust => "rust",
            Stage::Latex => "latex",
            Stage::Markdown => "markdown",
            Stage::Terminal => "terminal",
            Stage::Explained => "explained",
        }
    }
}

/// What is wanted of a law.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    pub stage: Stage,
    /// Of the passes and kernels; the other stages are of the law as it is written.
    pub kinematics: Kinematics,
    /// Of the stages that have one; `None`: the highest that the law is for.
    pub dim: Option<usize>,
    /// Where a page says that the text is.
    pub link: Option<&'a str>,
    /// What the caller knows besides: it stands on the page too.
    pub more: &'a [Part],
}

/// The laws of a text at one stage, one after the other. `link` is where a page says that the text is.
///
/// # Errors
/// All findings, when one of them is an error.
pub fn emit(text: &str, stage: Stage, link: Option<&str>) -> Result<String, Vec<Diagnostic>> {
    let request = Request {
        stage,
        kinematics: Kinematics::General,
        dim: None,
        link,
        more: &[],
    };
    emit_in(text, "", &mut files::nowhere, request)
}

/// As [`emit`], for the text of the file at `path`, which may use others.
///
/// # Errors
/// As [`emit`]; or a law is not for that many dimensions.
pub fn emit_in(
    text: &str,
    path: &str,
    files: &mut Files,
    request: Request,
) -> Result<String, Vec<Diagnostic>> {
    let Request { stage, link, .. } = request;
    let source = front::source(text, path, files);
    if source.checked.has_errors() {
        return Err(source.checked.diagnostics);
    }
    let laws = source.checked.laws.iter().zip(&source.models);
    let one = |(law, model): (&crate::ir::Law, &crate::ast::Model)| {
        let page = |form| {
            let parts = page::parts(law, model, &source, form, request.more);
            render::page(form, &law.title, link, &parts)
        };
        Ok(match stage {
            Stage::Ast => ast::model(model),
            Stage::Ir => ir::law(law),
            Stage::Passes => spec(law, &request)?.to_string(),
            Stage::Rust => rust::page(crate::rust::module(&[spec(law, &request)?])),
            Stage::Latex => page(Form::Latex),
            Stage::Markdown => page(Form::Markdown),
            Stage::Terminal => page(Form::Terminal),
            Stage::Explained => crate::explain::text(&spec(law, &request)?),
        })
    };
    let parts: Result<Vec<String>, Vec<Diagnostic>> = laws.map(one).collect();
    Ok(parts?.join("\n"))
}

/// The law in as many dimensions as it was asked for.
fn spec(law: &Law, request: &Request) -> Result<Spec, Vec<Diagnostic>> {
    let served = || law.flavours.iter().map(|f| f.dim());
    let dim = request.dim.or_else(|| served().max()).unwrap_or(3);
    if !served().any(|d| d == dim) {
        let flavours: Vec<&str> = law.flavours.iter().map(|f| f.name()).collect();
        let what = format!("`{}` has no kernels in {dim}D", law.name);
        let label = format!("this law is for {}", flavours.join(", "));
        return Err(vec![Diagnostic::error("PD092", what).at(law.span, label)]);
    }
    assemble::spec(law, dim, request.kinematics)
}

#[cfg(test)]
mod tests;
