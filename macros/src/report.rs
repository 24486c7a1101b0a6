//! What the library says about a text, as Rust items: the laws, or errors at their places.

use crate::layout::Layout;
use crate::library::diagnostic::{Diagnostic, Severity};
use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream};
use quote::{quote, quote_spanned};

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
pub fn expand(text: &str, report: impl Fn(&Diagnostic) -> Report) -> TokenStream {
    let say = |diagnostic: &Diagnostic| match diagnostic.severity {
        Severity::Error => report(diagnostic).error(),
        Severity::Warning => report(diagnostic).warning(),
    };
    match crate::library::compile::rust(text, &Default::default()) {
        Ok(items) => items,
        Err(diagnostics) => diagnostics
            .iter()
            .map(say)
            .chain(names(text).map(empty_law))
            .collect(),
    }
}

/// Names after the word `model`, read without a grammar, because the text has errors.
fn names(text: &str) -> impl Iterator<Item = &str> {
    let words = text
        .lines()
        .filter_map(|line| line.trim_start().strip_prefix("model "));
    words.filter_map(|rest| {
        let end = rest
            .trim_start()
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        rest.trim_start()
            .get(..end)
            .filter(|name| syn::parse_str::<Ident>(name).is_ok())
    })
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
        words += &format!("\n`{quoted}`: {label}");
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
