//! The whole journey on one screen.
//!
//! ```text
//! text --front: parse, resolve, check--> ir::Law            no names left, shapes, homes and units right
//!      --lower--> poly::Poly                                scalars of one dimension, equal things equal
//!      --linear--> poly::Poly                               where it is asked for: what is left for small displacements
//!      --derive--> force state, tangent                     from the energy, through the sums
//!      --schedule--> drafts                                 which sum when, which node quantity where
//!      --sweep, constants--> spec::Spec                     straight-line tapes; what the runtime reads
//!      --rust--> TokenStream                                the same tapes as Rust
//! ```

use proc_macro2::TokenStream;

use crate::assemble::{self, Kinematics};
use crate::diag::Diagnostic;
use crate::files::{self, Files};
use crate::front;
use crate::ir::{InfluenceFn, Law};
use crate::rust;
use crate::spec::Spec;

/// A law with its kernels as data, for bodies of every number of dimensions that it is meant for.
#[derive(Clone, Debug)]
pub struct Compiled {
    pub law: Law,
    pub specs: Vec<Spec>,
}

/// What a file holds, compiled, and its warnings.
#[derive(Clone, Debug, Default)]
pub struct Output {
    pub laws: Vec<Compiled>,
    pub influences: Vec<InfluenceFn>,
    pub warnings: Vec<Diagnostic>,
}

/// Compiles every law of a text.
///
/// # Errors
/// All errors (and warnings) of the text, if there is an error.
pub fn compile(text: &str) -> Result<Output, Vec<Diagnostic>> {
    compile_in(text, "", &mut files::nowhere, Kinematics::General)
}

/// As [`compile`], for the text of the file at `path`, which may use others.
///
/// # Errors
/// As [`compile`].
pub fn compile_in(
    text: &str,
    path: &str,
    files: &mut Files,
    kinematics: Kinematics,
) -> Result<Output, Vec<Diagnostic>> {
    let checked = front::file_in(text, path, files);
    if checked.diagnostics.iter().any(Diagnostic::is_error) {
        return Err(checked.diagnostics);
    }
    let laws = checked
        .laws
        .into_iter()
        .map(|law| {
            let specs = assemble::specs(&law, kinematics)?;
            Ok(Compiled { law, specs })
        })
        .collect::<Result<_, Vec<Diagnostic>>>()?;
    Ok(Output {
        laws,
        influences: checked.influences,
        warnings: checked.diagnostics,
    })
}

/// The laws of a text, which may use files, as Rust modules that name only the runtime's interface.
///
/// # Errors
/// As [`compile`].
pub fn rust(
    text: &str,
    path: &str,
    files: &mut Files,
    kinematics: Kinematics,
) -> Result<(TokenStream, Vec<Diagnostic>), Vec<Diagnostic>> {
    let output = compile_in(text, path, files, kinematics)?;
    let modules: TokenStream = output.laws.iter().map(|c| rust::module(&c.specs)).collect();
    Ok((modules, output.warnings))
}
