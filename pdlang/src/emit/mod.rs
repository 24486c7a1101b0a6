//! Every stage of the journey as text: what `pdlang emit` prints.
//!
//! Contract. Each function is total on laws that the checks accept, and prints the same for the same text:
//! the snapshots of the tests rest on it.

mod ast;
mod ir;
mod latex;
mod page;
mod symbols;

use crate::assemble::{self, Kinematics};
use crate::diag::Diagnostic;
use crate::files::{self, Files};
use crate::front;
use crate::rust;

/// What can be printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stage {
    /// The tree as it was read.
    Ast,
    /// The law after all checks, with functions inlined.
    Ir,
    /// The sweeps of each dimension, after derivation and scheduling.
    Passes,
    /// The kernels.
    Rust,
    /// The page of the law, as LaTeX and as Markdown.
    Latex,
    Markdown,
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
        }
    }
}

/// The laws of a text at one stage, one after the other. `link` is where a page says that the text is.
///
/// # Errors
/// All findings, when one of them is an error.
pub fn emit(text: &str, stage: Stage, link: Option<&str>) -> Result<String, Vec<Diagnostic>> {
    emit_in(
        text,
        "",
        &mut files::nowhere,
        stage,
        Kinematics::General,
        link,
    )
}

/// As [`emit`], for the text of the file at `path`, which may use others. Passes and kernels are those of the
/// kinematics; the other stages are of the law as it is written.
///
/// # Errors
/// As [`emit`].
pub fn emit_in(
    text: &str,
    path: &str,
    files: &mut Files,
    stage: Stage,
    kinematics: Kinematics,
    link: Option<&str>,
) -> Result<String, Vec<Diagnostic>> {
    let source = front::source(text, path, files);
    if source.checked.has_errors() {
        return Err(source.checked.diagnostics);
    }
    let laws = source.checked.laws.iter().zip(&source.models);
    let one = |(law, model): (&crate::ir::Law, &crate::ast::Model)| {
        Ok(match stage {
            Stage::Ast => ast::model(model),
            Stage::Ir => ir::law(law),
            Stage::Passes => {
                let specs = assemble::specs(law, kinematics)?;
                specs.iter().map(ToString::to_string).collect()
            }
            Stage::Rust => laid_out(&rust::module(&assemble::specs(law, kinematics)?).to_string()),
            Stage::Latex => page::latex(law, model, &source),
            Stage::Markdown => page::markdown(law, model, &source, link),
        })
    };
    let parts: Result<Vec<String>, Vec<Diagnostic>> = laws.map(one).collect();
    Ok(parts?.join("\n"))
}

/// Rust tokens with a statement per line. What stands between quotes is left alone.
fn laid_out(tokens: &str) -> String {
    let (mut out, mut line, mut depth) = (String::new(), String::new(), 0_usize);
    let (mut quoted, mut escaped, mut inside) = (false, false, 0_i32);
    let mut end = |line: &mut String, depth: usize| {
        if !line.trim().is_empty() {
            out.push_str(&"    ".repeat(depth));
            out.push_str(line.trim());
            out.push('\n');
        }
        line.clear();
    };
    for letter in tokens.chars() {
        if letter == '}' && !quoted {
            end(&mut line, depth);
            depth = depth.saturating_sub(1);
        }
        line.push(letter);
        if letter == '"' && !escaped {
            quoted = !quoted;
        }
        inside += match letter {
            '[' | '(' if !quoted => 1,
            ']' | ')' if !quoted => -1,
            _ => 0,
        };
        escaped = quoted && letter == '\\' && !escaped;
        // The `;` of an array type ends nothing.
        if !quoted && (matches!(letter, '{' | '}') || letter == ';' && inside == 0) {
            end(&mut line, depth);
            depth += usize::from(letter == '{');
        }
    }
    end(&mut line, depth);
    out
}

#[cfg(test)]
mod tests;
