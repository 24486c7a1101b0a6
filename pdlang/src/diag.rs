//! What is wrong with a text, where, and what to do.

use crate::span::Span;
use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Renderer, Snippet};
use std::ops::Range;

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Severity {
    Error,
    Warning,
}

/// One finding. Its code belongs to one check, and one file of `check/` holds that check.
#[derive(Clone, PartialEq, Debug)]
pub struct Diagnostic {
    /// `PD001` and so on for errors, `PD101` and so on for warnings.
    pub code: &'static str,
    pub severity: Severity,
    pub message: String,
    /// The first is the token that the message is about.
    pub labels: Vec<(Span, String)>,
    pub help: Option<String>,
}

impl Diagnostic {
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            message: message.into(),
            labels: Vec::new(),
            help: None,
        }
    }

    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic {
            severity: Severity::Warning,
            ..Self::error(code, message)
        }
    }

    /// Adds a place. The first one added is the token.
    pub fn at(mut self, span: Span, label: impl Into<String>) -> Self {
        self.labels.push((span, label.into()));
        self
    }

    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same finding about the use of a library definition: what it says about places inside of the
    /// prelude is said at `call`.
    pub(crate) fn seen_from(self, name: &str, call: Span) -> Self {
        let (inside, outside): (Vec<_>, Vec<_>) =
            self.labels.into_iter().partition(|(span, _)| span.prelude);
        let mut inside: Vec<String> = inside
            .into_iter()
            .map(|(_, label)| label)
            .filter(|label| !label.is_empty())
            .collect();
        inside.reverse();
        let mut labels = vec![(call, inside.join(" and "))];
        labels.extend(outside);
        Diagnostic {
            message: format!("in `{name}`: {}", self.message),
            labels,
            ..self
        }
    }

    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// Place of the token, for sorting and for editors.
    pub fn span(&self) -> Span {
        self.labels
            .first()
            .map_or_else(Span::default, |(span, _)| *span)
    }

    /// The finding as text for people: message, the lines of `source` with the places marked, help.
    /// `path` names the source; `color` adds terminal colours.
    pub fn render(&self, source: &str, path: &str, color: bool) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut snippet = Snippet::source(source).line_start(1).path(path);
        for (k, (span, label)) in self.labels.iter().enumerate() {
            snippet = snippet.annotation(annotation(k == 0, byte_range(*span, source), label));
        }
        let mut group: Group = level
            .primary_title(self.message.as_str())
            .id(self.code)
            .element(snippet);
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let renderer = if color {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        renderer.decor_style(DecorStyle::Ascii).render(&[group])
    }
}

fn annotation(primary: bool, range: Range<usize>, label: &str) -> Annotation<'_> {
    let kind = if primary {
        AnnotationKind::Primary
    } else {
        AnnotationKind::Context
    };
    match label {
        "" => kind.span(range),
        text => kind.span(range).label(text),
    }
}

/// The span as a range that `source` can be cut at, whatever text it came from.
fn byte_range(span: Span, source: &str) -> Range<usize> {
    let start = floor(source, span.start as usize);
    let end = floor(source, span.end as usize).max(start);
    start..end
}

fn floor(source: &str, at: usize) -> usize {
    (0..=at.min(source.len()))
        .rev()
        .find(|&k| source.is_char_boundary(k))
        .unwrap_or(0)
}

/// Places the findings in the order of the text, errors before warnings at the same place.
pub fn sort(diagnostics: &mut [Diagnostic]) {
    diagnostics.sort_by_key(|d| (d.span().start, d.severity, d.code));
}
