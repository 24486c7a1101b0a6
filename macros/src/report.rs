//! What the library says about a text, as Rust items: the laws, or errors at their places.

use crate::layout::Layout;
use pdlang::assemble::Kinematics;
use pdlang::diag::{Diagnostic, Severity};
use pdlang::files::Files;
use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream};
use quote::{quote, quote_spanned};
use std::collections::BTreeSet;

/// A message under the tokens from `first` to `last`.
pub struct Report {
    pub message: String,
    pub first: Span,
    pub last: Span,
}

impl Report {
    /// A diagnostic of inline text, under its own tokens.
    pub fn inline(diagnostic: &Diagnostic, layout: &Layout) -> Report {
        let own = diagnostic.labels.first().filter(|(span, _)| !span.prelude);
        let (first, last) = match own {
            Some((span, _)) => layout.spans(span.start as usize..span.end as usize),
            None => (Span::call_site(), Span::call_site()),
        };
        Report {
            message: in_words(diagnostic, &layout.text),
            first,
            last,
        }
    }

    /// rustc underlines from the span of the path to the span of the group.
    fn error(&self) -> TokenStream {
        let message = &self.message;
        let name = quote_spanned!(self.first=> ::core::compile_error!);
        let mut argument = Group::new(Delimiter::Brace, quote!(#message));
        argument.set_span(self.last);
        quote!(#name #argument)
    }

    /// A use of a deprecated constant is the one warning that stable Rust lets a macro give.
    fn warning(&self) -> TokenStream {
        let message = &self.message;
        let law = Ident::new("LAW", self.first);
        quote!(const _: () = { #[deprecated(note = #message)] const LAW: () = (); #law };)
    }
}

/// The items of a text. On errors the modules of its laws are still there, empty, so that an editor can
/// complete `lps::LAW` and rustc does not complain about it as well.
pub fn expand(
    text: &str,
    path: &str,
    files: &mut Files,
    kinematics: Kinematics,
    report: impl Fn(&Diagnostic) -> Report,
) -> TokenStream {
    let say = |diagnostic: &Diagnostic| match diagnostic.severity {
        Severity::Error => report(diagnostic).error(),
        Severity::Warning => report(diagnostic).warning(),
    };
    match pdlang::compile::rust(text, path, files, kinematics) {
        Ok((items, warnings)) => warnings.iter().map(say).chain([items]).collect(),
        Err(findings) => findings
            .iter()
            .map(say)
            .chain(names(text).into_iter().map(empty_law))
            .collect(),
    }
}

/// Names after the word `model`, read without a grammar, because the text has errors.
fn names(text: &str) -> BTreeSet<&str> {
    text.lines()
        .filter_map(|line| line.trim_start().strip_prefix("model "))
        .filter_map(|head| head.trim_start().split(|c| !is_word(c)).next())
        .filter(|name| syn::parse_str::<Ident>(name).is_ok())
        .collect()
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn empty_law(name: &str) -> TokenStream {
    let module = Ident::new(name, Span::call_site());
    quote! {
        pub mod #module {
            pub static LAW: ::pdlang_runtime::kernel::CompiledLaw =
                ::pdlang_runtime::kernel::CompiledLaw { name: #name, kernels: &[] };
        }
    }
}

/// A diagnostic without a picture of the source, which rustc draws itself. The labels beyond the first quote
/// what they speak of, because a macro cannot underline twice.
fn in_words(diagnostic: &Diagnostic, text: &str) -> String {
    let mut words = format!("[{}]: {}", diagnostic.code, diagnostic.message);
    let mut labels = diagnostic
        .labels
        .iter()
        .filter(|(span, label)| !span.prelude && !label.is_empty());
    if let Some((_, label)) = labels.next() {
        words += &format!("\n{label}");
    }
    for (span, label) in labels {
        let quoted = text
            .get(span.start as usize..span.end as usize)
            .unwrap_or_default();
        words += &format!("\n`{}`: {label}", quoted.trim());
    }
    if let Some(help) = &diagnostic.help {
        words += &format!("\nhelp: {help}");
    }
    words
}

/// A rendered snippet without its first word, which rustc writes itself.
pub fn plain(snippet: &str) -> String {
    let rest = snippet
        .strip_prefix("error")
        .or(snippet.strip_prefix("warning"))
        .unwrap_or(snippet);
    rest.trim_end().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_laws_of_a_text_with_errors_are_named_once() {
        let text =
            "model b \"B\" {\n  model a{ }\n# model c\nmodel b\nmodel 3d\nmodel type\nmodelling";
        assert_eq!(names(text).into_iter().collect::<Vec<_>>(), ["a", "b"]);
    }

    #[test]
    fn a_snippet_loses_the_word_that_rustc_writes() {
        assert_eq!(
            plain("error[PD002]: no\n --> a.pd\n"),
            "[PD002]: no\n --> a.pd"
        );
        assert_eq!(plain("warning[PD102]: unused"), "[PD102]: unused");
    }
}
