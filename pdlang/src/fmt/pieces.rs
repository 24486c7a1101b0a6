//! A text as tokens and comments, with what the author put between them.

use std::ops::Range;

#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Piece<'t> {
    pub text: &'t str,
    pub comment: bool,
    /// Line ends before it; two or more are a paragraph.
    pub breaks: usize,
    /// Whether anything stands between it and the piece before.
    pub apart: bool,
}

/// `tokens` are those of the grammar. Between them there is white space, and there are comments.
pub(super) fn of<'t>(text: &'t str, tokens: &[Range<usize>]) -> Vec<Piece<'t>> {
    let mut pieces = Vec::new();
    let mut at = 0;
    for token in tokens {
        let mut next = gap(text, at..token.start, &mut pieces);
        next.text = text.get(token.clone()).unwrap_or_default();
        pieces.push(next);
        at = token.end;
    }
    gap(text, at..text.len(), &mut pieces);
    pieces
}

/// Adds the comments of a gap, and says how far apart from them the next token is.
fn gap<'t>(text: &'t str, range: Range<usize>, pieces: &mut Vec<Piece<'t>>) -> Piece<'t> {
    let mut next = Piece {
        text: "",
        comment: false,
        breaks: 0,
        apart: !range.is_empty(),
    };
    let rest = text.get(range).unwrap_or_default();
    for (k, line) in rest.split('\n').enumerate() {
        next.breaks += usize::from(k > 0);
        let line = line.trim();
        if !line.is_empty() {
            pieces.push(Piece {
                text: line,
                comment: true,
                apart: true,
                ..next
            });
            next.breaks = 0;
        }
    }
    next
}
