//! The doorway from Rust to the language: a law written inside a Rust program, or in a file beside it,
//! becomes a kernel that the runtime can run.
//!
//! Both macros stand where an item may stand and give one `pub mod` per law, named as the law and holding
//! `pub static LAW: pdlang_runtime::kernel::CompiledLaw`. A crate that uses them also depends on
//! `pdlang-runtime`. Nothing is decided here: the macros read tokens or a file, call the `pdlang` library
//! and carry its diagnostics to the place in the source that they speak of.

mod file;
mod kinematics;
mod layout;
mod report;

use proc_macro::TokenStream;

/// Laws and influence functions, written inline.
///
/// ```text
/// pdlang_macros::model! {
///     model spring "Prototype microelastic" cite "Silling and Askari 2005, eq. 13" {
///         param K : pressure > 0 "bulk modulus"
///         ..
///     }
/// }
/// let law = pdlang_runtime::law::Law::compiled(&spring::LAW, 3);
/// ```
///
/// With the word `linearised` in front, the laws are those for small displacements.
///
/// Rust's lexer reads the text first. It refuses a prime as in `T'` and signs such as `·`: put a law that needs
/// them into a file. Every error of the text is reported, each underlining its own tokens.
#[proc_macro]
pub fn model(tokens: TokenStream) -> TokenStream {
    let (kinematics, tokens) = kinematics::taken_off(tokens.into());
    let layout = layout::Layout::of(tokens);
    report::expand(
        &layout.text,
        "",
        &mut pdlang::files::nowhere,
        kinematics,
        |diagnostic| report::Report::inline(diagnostic, &layout),
    )
    .into()
}

/// The laws and influence functions of one or more `.pd` files.
///
/// ```text
/// pdlang_macros::include_model!("laws/lps.pd", "laws/gpmb.pd");
/// ```
///
/// `include_model!(linearised "laws/lps.pd")` gives the laws for small displacements.
///
/// Paths start at the folder of the crate's `Cargo.toml`, those of a `use` at the folder of the file that it
/// stands in. The crate is built again when a file changes. An
/// error is reported at the path, with the lines of the file that it speaks of.
#[proc_macro]
pub fn include_model(paths: TokenStream) -> TokenStream {
    file::include(paths.into())
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}
