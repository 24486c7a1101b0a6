//! What is wrong with a scene, and how it is shown.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

/// One thing that is wrong: message, places (the first is the one to look at), remedy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Problem {
    pub message: String,
    /// Byte ranges of the scene's text with what is to be said there.
    pub labels: Vec<(Range<usize>, String)>,
    pub help: Option<String>,
    /// Text of its own that explains further, such as the diagnostics of a law.
    pub report: Option<String>,
}

impl Problem {
    pub fn new(message: impl Into<String>) -> Problem {
        Problem {
            message: message.into(),
            ..Problem::default()
        }
    }

    pub fn at(mut self, span: Range<usize>, label: impl Into<String>) -> Problem {
        self.labels.push((span, label.into()));
        self
    }

    pub fn help(mut self, help: impl Into<String>) -> Problem {
        self.help = Some(help.into());
        self
    }

    fn place(&self) -> usize {
        self.labels.first().map_or(0, |(span, _)| span.start)
    }
}

/// Everything that is wrong with one scene, in the order of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Problems {
    pub path: String,
    pub text: String,
    pub list: Vec<Problem>,
}

impl Problems {
    /// A single problem without a place in the text, such as a file that cannot be read.
    pub fn without_text(path: &str, problem: Problem) -> Problems {
        Problems {
            path: path.to_string(),
            text: String::new(),
            list: vec![problem],
        }
    }

    pub(super) fn sorted(path: &str, text: &str, mut list: Vec<Problem>) -> Problems {
        list.sort_by_key(Problem::place);
        list.dedup();
        Problems {
            path: path.to_string(),
            text: text.to_string(),
            list,
        }
    }

    /// The messages as the terminal shows them, with the lines they are about.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        let shown: Vec<String> = self.list.iter().map(|p| self.show(p, &renderer)).collect();
        shown.join("\n\n")
    }

    fn show(&self, problem: &Problem, renderer: &Renderer) -> String {
        let mut group = Group::with_title(Level::ERROR.primary_title(problem.message.as_str()));
        if !problem.labels.is_empty() {
            group = group.element(self.snippet(problem));
        }
        if let Some(help) = &problem.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let mut shown = renderer.render(&[group]);
        if let Some(report) = &problem.report {
            shown.push_str("\n\n");
            shown.push_str(report.trim_end());
        }
        shown
    }

    fn snippet<'a>(
        &'a self,
        problem: &'a Problem,
    ) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
        let mut snippet = Snippet::source(self.text.as_str()).path(self.path.as_str());
        for (k, (span, label)) in problem.labels.iter().enumerate() {
            let kind = if k == 0 {
                AnnotationKind::Primary
            } else {
                AnnotationKind::Context
            };
            let mut annotation = kind.span(within(&self.text, span));
            if !label.is_empty() {
                annotation = annotation.label(label.as_str());
            }
            snippet = snippet.annotation(annotation);
        }
        snippet
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Problems {}

/// The range cut to the text and to character boundaries: a renderer must never be the thing that fails.
fn within(text: &str, span: &Range<usize>) -> Range<usize> {
    let floor = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = floor(span.start);
    start..floor(span.end).max(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_shows_place_and_remedy() {
        let text = "[body]\nspacing = -1\n";
        let problem = Problem::new("the spacing must be positive")
            .at(17..19, "this is negative")
            .help("give a length, for example \"0.5 mm\"");
        let shown = Problems::sorted("a.toml", text, vec![problem]).render(false);
        assert!(
            shown.starts_with("error: the spacing must be positive"),
            "{shown}"
        );
        assert!(shown.contains("a.toml:2:11"), "{shown}");
        assert!(shown.contains("this is negative"), "{shown}");
        assert!(shown.contains("for example"), "{shown}");
    }

    #[test]
    fn a_range_outside_of_the_text_is_cut() {
        assert_eq!(within("aé", &(2..9)), 1..3);
        assert_eq!(within("", &(5..9)), 0..0);
    }
}
