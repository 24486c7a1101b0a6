//! Stand-in until the library has this.
pub mod diagnostic {
    pub use pdlang::span::Span;
    #[derive(PartialEq, Clone, Copy)]
    #[allow(dead_code)]
    pub enum Severity {
        Error,
        Warning,
    }
    pub struct Diagnostic {
        pub code: &'static str,
        pub severity: Severity,
        pub message: String,
        pub labels: Vec<(Span, String)>,
        pub help: Option<String>,
    }
    impl Diagnostic {
        pub fn render(&self, source: &str, path: &str, _color: bool) -> String {
            let s = self.labels[0].0;
            format!(
                "error[{}]: {}\n --> {path}\n  |\n1 | {}\n  | ^^^",
                self.code,
                self.message,
                &source[s.start as usize..s.end as usize]
            )
        }
    }
}
pub mod compile {
    use super::diagnostic::*;
    pub fn rust(text: &str, _: &()) -> Result<proc_macro2::TokenStream, Vec<Diagnostic>> {
        let mut out = vec![];
        for (i, _) in text.match_indices("bad") {
            let end = text[i..].find(['\n', ';']).map_or(text.len(), |n| i + n);
            out.push(Diagnostic {
                code: "PD001",
                severity: if text[i..].starts_with("bad_w") {
                    Severity::Warning
                } else {
                    Severity::Error
                },
                message: "a bad thing".into(),
                labels: vec![(
                    Span {
                        start: i as u32,
                        end: end as u32,
                        prelude: false,
                    },
                    "here".into(),
                )],
                help: Some("do better".into()),
            });
        }
        if out.is_empty() {
            let name = quote::format_ident!("{}", text.split_whitespace().nth(1).unwrap_or("x"));
            Ok(quote::quote!(pub mod #name { pub static LAW: u32 = 1; }))
        } else {
            Err(out)
        }
    }
}
