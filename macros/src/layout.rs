//! Tokens laid out as the text they came from.
//!
//! The language has one grammar, over text. So every token is put where it stands in its source, line by
//! line and column by column, with blanks where comments were. What the library then says about a range of
//! bytes is said about the tokens in that range. The same works for tokens that come through another macro,
//! where the text of the call is not the text of its tokens.

use proc_macro2::{Delimiter, Group, LineColumn, Span, TokenStream, TokenTree};
use std::ops::Range;

/// A text, and which bytes of it are which token.
pub struct Layout {
    pub text: String,
    /// In the order of the text.
    tokens: Vec<(Range<usize>, Span)>,
    /// Where the last token ended in its source.
    cursor: LineColumn,
}

impl Layout {
    pub fn of(tokens: TokenStream) -> Layout {
        let mut layout = Layout {
            text: String::new(),
            tokens: Vec::new(),
            cursor: LineColumn { line: 1, column: 0 },
        };
        layout.stream(tokens);
        layout
    }

    /// Spans of the first and of the last token that share a byte with `range`; of the token nearest to it
    /// where it holds none.
    pub fn spans(&self, range: Range<usize>) -> (Span, Span) {
        let first = self
            .tokens
            .partition_point(|(token, _)| token.end <= range.start);
        let after = self
            .tokens
            .partition_point(|(token, _)| token.start < range.end);
        if first < after {
            return (self.tokens[first].1, self.tokens[after - 1].1);
        }
        let before = first.checked_sub(1).map(|i| &self.tokens[i]);
        let nearest = match (before, self.tokens.get(first)) {
            (Some(a), Some(b))
                if range.start.saturating_sub(a.0.end) < b.0.start.saturating_sub(range.start) =>
            {
                a.1
            }
            (_, Some(b)) => b.1,
            (Some(a), None) => a.1,
            (None, None) => Span::call_site(),
        };
        (nearest, nearest)
    }

    fn stream(&mut self, tokens: TokenStream) {
        let mut tokens = tokens.into_iter();
        while let Some(token) = tokens.next() {
            match (doc_comment(&token), token) {
                (Some(comment), token) => {
                    self.put(&comment, token.span(), Some(token.span().start()));
                    tokens.find(|token| matches!(token, TokenTree::Group(_)));
                }
                (None, TokenTree::Group(group)) => self.group(&group),
                (None, leaf) => self.leaf(&leaf.to_string(), leaf.span()),
            }
        }
    }

    fn group(&mut self, group: &Group) {
        let (open, close) = match group.delimiter() {
            Delimiter::Parenthesis => ("(", ")"),
            Delimiter::Brace => ("{", "}"),
            Delimiter::Bracket => ("[", "]"),
            Delimiter::None => return self.stream(group.stream()),
        };
        self.leaf(open, group.span_open());
        self.stream(group.stream());
        self.leaf(close, group.span_close());
    }

    fn leaf(&mut self, token: &str, span: Span) {
        let own = span.source_text().is_some_and(|source| source == token);
        self.put(token, span, own.then(|| span.start()));
    }

    /// Appends a token at its place in the source, or after one blank where that is unknown or not ahead.
    fn put(&mut self, token: &str, span: Span, place: Option<LineColumn>) {
        let at = place.unwrap_or(self.cursor);
        if at.line > self.cursor.line {
            self.blank('\n', at.line - self.cursor.line);
            self.blank(' ', at.column);
        } else if place.is_some() && at.line == self.cursor.line && at.column >= self.cursor.column
        {
            self.blank(' ', at.column - self.cursor.column);
        } else {
            self.blank(' ', 1);
        }
        let start = self.text.len();
        self.text.push_str(token);
        self.tokens.push((start..self.text.len(), span));
        self.cursor = if place.is_some() {
            span.end()
        } else {
            self.cursor
        };
    }

    fn blank(&mut self, blank: char, count: usize) {
        self.text.extend(std::iter::repeat_n(blank, count));
    }
}

/// The text of a doc comment, which Rust hands over as `# [doc = ".."]`, every token with the span of the
/// whole comment.
fn doc_comment(token: &TokenTree) -> Option<String> {
    let source = token.span().source_text()?;
    (matches!(token, TokenTree::Punct(_)) && source.len() > 2 && source.starts_with('/'))
        .then_some(source)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(source: &str) -> Layout {
        Layout::of(source.parse().expect("a test's source is made of tokens"))
    }

    /// Line and column, both from the spans of the range's first and last token.
    fn place(layout: &Layout, range: Range<usize>) -> [(usize, usize); 2] {
        let (first, last) = layout.spans(range);
        [
            (first.start().line, first.start().column),
            (last.end().line, last.end().column),
        ]
    }

    #[test]
    fn tokens_without_comments_give_their_own_text_back() {
        let source =
            "model a \"Ä\" {\n  let c = 2*K^2 / ball(x*ω)  \n\n  energy W = c/4*sum(1e-3*[x]) }";
        assert_eq!(layout(source).text, source.replace("  \n", "\n"));
    }

    #[test]
    fn a_comment_becomes_a_gap_and_what_follows_keeps_its_place() {
        let source = "let a = /* why */ b // until here\nlet c = d";
        assert_eq!(layout(source).text, "let a =           b\nlet c = d");
    }

    #[test]
    fn a_doc_comment_is_kept_once() {
        let source = "/// Weighted volume.\nnode m = 1\n//! inner\nnode n = 2";
        assert_eq!(layout(source).text, source);
    }

    #[test]
    fn a_range_maps_to_its_first_and_last_token() {
        let source = "node m = sum(ω * x^2)\nnode t = m";
        let layout = layout(source);
        let start = source.find("sum").unwrap();
        let end = source.find("\n").unwrap();
        // Columns count characters: ω is one column and two bytes.
        assert_eq!(place(&layout, start..end), [(1, 9), (1, 21)]);
    }

    #[test]
    fn a_range_without_a_token_maps_to_the_nearest() {
        let layout = layout("a     b");
        assert_eq!(place(&layout, 2..3), [(1, 0), (1, 1)]);
        assert_eq!(place(&layout, 5..5), [(1, 6), (1, 7)]);
        assert_eq!(place(&layout, 7..7), [(1, 6), (1, 7)]);
        assert_eq!(place(&layout, 70..90), [(1, 6), (1, 7)]);
    }

    #[test]
    fn no_tokens_are_an_empty_text() {
        let layout = layout("");
        assert_eq!(layout.text, "");
        layout.spans(0..0);
    }
}
