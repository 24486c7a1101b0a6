//! Pieces as lines: where they break, how deep they stand, and what stands between two tokens.

use super::pieces::Piece;
use crate::words::{ITEMS, TOP};

/// A line of the canonical form, without its columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Line {
    pub indent: usize,
    /// The tokens, each with whether a blank stands before it.
    pub tokens: Vec<(String, bool)>,
    pub comment: Option<String>,
    /// True where an item starts.
    pub starts: bool,
    /// An empty line stands before it.
    pub gap: bool,
}

impl Line {
    pub(super) fn text(&self) -> String {
        joined(&self.tokens)
    }
}

/// Tokens as they stand on a line.
pub(super) fn joined(tokens: &[(String, bool)]) -> String {
    let mut text = String::new();
    for (token, blank) in tokens {
        if *blank && !text.is_empty() {
            text.push(' ');
        }
        text.push_str(token);
    }
    text
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum Bracket {
    /// `(`, `[`
    Round,
    Model,
    Probe,
    Case,
}

const PROBE: [&str; 5] = ["let", "node", "lattice", "break", "expect"];
/// What puts a blank on both sides, if the author put one on either.
const OPERATORS: [&str; 12] = ["+", "-", "*", "/", "·", "<", ">", "<=", ">=", "≤", "≥", "^"];

struct Writer<'p, 't> {
    pieces: &'p [Piece<'t>],
    open: Vec<Bracket>,
    lines: Vec<Line>,
    line: Line,
    /// The first word of the item at hand: `model`, `probe`, ..
    item: &'t str,
}

pub(super) fn of(pieces: &[Piece]) -> Vec<Line> {
    let mut writer = Writer {
        pieces,
        open: Vec::new(),
        lines: Vec::new(),
        line: Line::default(),
        item: "",
    };
    for k in 0..pieces.len() {
        match pieces[k].comment {
            true => writer.comment(k),
            false => writer.token(k),
        }
    }
    writer.end();
    writer.lines
}

impl<'t> Writer<'_, 't> {
    /// How many blocks are open: models and probes.
    fn blocks(&self) -> usize {
        let block = |b: &&Bracket| matches!(b, Bracket::Model | Bracket::Probe);
        self.open.iter().filter(block).count()
    }

    /// Brackets that are open inside of the item at hand.
    fn inner(&self) -> usize {
        self.open.len() - self.blocks()
    }

    fn end(&mut self) {
        let line = std::mem::take(&mut self.line);
        if !line.tokens.is_empty() || line.comment.is_some() {
            self.lines.push(line);
        }
    }

    fn previous(&self, k: usize) -> Option<&Piece<'t>> {
        self.pieces[..k].iter().rev().find(|piece| !piece.comment)
    }

    fn next(&self, k: usize) -> Option<usize> {
        (k..self.pieces.len()).find(|k| !self.pieces[*k].comment)
    }

    /// Whether token `k` starts an item of the block at hand.
    fn starts(&self, k: usize) -> bool {
        if self.inner() > 0 {
            return false;
        }
        let word = self.pieces[k].text;
        let before = self.previous(k).map_or("", |piece| piece.text);
        match self.open.last() {
            Some(Bracket::Probe) => PROBE.contains(&word),
            Some(_) if matches!(word, "force" | "energy") => self.names_a_response(k),
            Some(_) if word == "after" => self
                .next(k + 1)
                .is_some_and(|n| self.pieces[n].text == "step"),
            Some(_) => ITEMS.contains(&word) && before != "on",
            None => TOP.contains(&word),
        }
    }

    /// Whether a name and `=` or `:` follow: `force` and `energy` are kinds too.
    fn names_a_response(&self, k: usize) -> bool {
        let text = |k: usize| self.pieces[k].text;
        let name = self.next(k + 1);
        let sign = name.and_then(|name| self.next(name + 1));
        let word = |text: &str| text.starts_with(|c: char| c.is_alphabetic() || c == '_');
        name.is_some_and(|k| word(text(k))) && sign.is_some_and(|k| matches!(text(k), "=" | ":"))
    }

    fn closes_block(&self, k: usize) -> bool {
        let last = self.open.last();
        self.pieces[k].text == "}" && matches!(last, Some(Bracket::Model | Bracket::Probe))
    }

    /// Whether token `k` begins a line whatever the author says.
    fn begins(&self, k: usize) -> bool {
        let piece = &self.pieces[k];
        let cited =
            matches!(piece.text, "cite" | "for") && self.item == "model" && self.open.is_empty();
        let opens = piece.text == "{" && self.item == "model" && self.open.is_empty();
        self.starts(k)
            || self.closes_block(k)
            || cited
            || opens && self.lines.last().is_some_and(|line| self.is_cite(line))
            || opens && self.is_cite(&self.line)
    }

    fn is_cite(&self, line: &Line) -> bool {
        let header = |word: &str| word == "cite" || word == "for";
        self.item == "model" && line.tokens.first().is_some_and(|(word, _)| header(word))
    }

    /// How deep a line that begins with token `k` stands.
    fn indent(&self, k: Option<usize>) -> usize {
        let Some(k) = k else { return 0 };
        let blocks = self.blocks();
        let closer = matches!(self.pieces[k].text, "}" | ")" | "]");
        match (self.starts(k), self.closes_block(k), closer) {
            (true, ..) => 2 * blocks,
            (_, true, _) => 2 * (blocks - 1),
            (_, _, true) => 2 * (blocks + self.inner().saturating_sub(1)),
            _ if self.pieces[k].text == "{" && self.item == "model" && self.open.is_empty() => 0,
            _ => 2 * (blocks + self.inner().max(1)),
        }
    }

    /// An empty line stands where the author has one, but not at the ends of a block.
    fn gap(&self, k: usize) -> bool {
        let before = k.checked_sub(1).map(|k| &self.pieces[k]);
        let opened = before.is_none_or(|b| b.text == "{" && !b.comment && self.inner() == 0);
        let closing = !self.pieces[k].comment && self.closes_block(k);
        self.pieces[k].breaks > 1 && !opened && !closing
    }

    fn comment(&mut self, k: usize) {
        let piece = &self.pieces[k];
        let trailing = piece.breaks == 0 && k > 0;
        if trailing && self.line.tokens.is_empty() && self.line.comment.is_none() {
            // The line that it belongs to has ended: behind an opening brace.
            if let Some(last) = self.lines.last_mut().filter(|line| line.comment.is_none()) {
                last.comment = Some(piece.text.into());
                return;
            }
        }
        if !trailing || self.line.tokens.is_empty() {
            self.end();
            let next = self.next(k);
            // At the end of a block a comment stands as deep as the items of the block.
            let deep = match next {
                Some(next) if self.closes_block(next) => 2 * self.blocks(),
                next => self.indent(next),
            };
            (self.line.indent, self.line.gap) = (deep, self.gap(k));
        }
        self.line.comment = Some(piece.text.into());
        self.end();
    }

    fn token(&mut self, k: usize) {
        let piece = self.pieces[k];
        let starts = self.starts(k);
        let fresh = self.line.tokens.is_empty();
        if !fresh && (self.begins(k) || piece.breaks > 0 && self.may_break(k)) {
            self.end();
        }
        if self.line.tokens.is_empty() {
            self.line.indent = self.indent(Some(k));
            self.line.starts = starts;
            self.line.gap =
                self.gap(k) && (starts || self.closes_block(k) || self.line.indent == 0);
        }
        if starts {
            self.item = piece.text;
        }
        let blank = self.blank(k);
        self.line.tokens.push((piece.text.into(), blank));
        self.bracket(k);
    }

    /// Titles, strings, the opening brace and the end of a list stay on their line.
    fn may_break(&self, k: usize) -> bool {
        let text = self.pieces[k].text;
        let after_comma = self.previous(k).is_some_and(|p| p.text == ",");
        let cited = self.is_cite(&self.line) && after_comma;
        let header = text == "{" || text == "," || text.starts_with('"') && !cited;
        !header
    }

    fn bracket(&mut self, k: usize) {
        match self.pieces[k].text {
            "(" | "[" => self.open.push(Bracket::Round),
            "{" => {
                let case = self.previous(k).is_some_and(|p| p.text == "flavour");
                let kind = match (case, self.item) {
                    (true, _) => Bracket::Case,
                    (_, "probe") => Bracket::Probe,
                    _ => Bracket::Model,
                };
                self.open.push(kind);
                if kind != Bracket::Case {
                    self.end();
                }
            }
            ")" | "]" => drop(self.open.pop()),
            "}" => {
                let in_item = self.open.pop() == Some(Bracket::Case);
                self.item = if in_item { self.item } else { "" };
            }
            _ => {}
        }
    }

    /// Whether a blank stands before token `k`.
    fn blank(&self, k: usize) -> bool {
        let Some(before) = self.previous(k) else {
            return false;
        };
        let (text, apart) = (self.pieces[k].text, self.pieces[k].apart);
        let apart_after = self.next(k + 1).is_some_and(|next| self.pieces[next].apart);
        let in_case = self.open.last() == Some(&Bracket::Case);
        match (before.text, text) {
            (_, "," | ";" | ")" | "]") | ("(" | "[", _) => false,
            (_, "=" | "{" | "}") | ("=" | "," | ";" | "{", _) => true,
            (_, ":") => !in_case,
            (":", _) => true,
            // A sign belongs to what follows.
            (_, op) if OPERATORS.contains(&op) && self.ends_operand(before.text) => {
                apart || apart_after
            }
            (op, _) if OPERATORS.contains(&op) && self.is_infix(k) => apart || self.infix_apart(k),
            _ => apart,
        }
    }

    fn ends_operand(&self, text: &str) -> bool {
        let word = |c: char| c.is_alphanumeric() || c == '_';
        text.chars().next_back().is_some_and(word) && !is_word_operator(text)
            || matches!(text, ")" | "]" | "}" | "'" | "′" | "²" | "³" | "%")
    }

    /// Whether the operator before token `k` stands between two operands.
    fn is_infix(&self, k: usize) -> bool {
        self.operator_before(k)
            .and_then(|op| self.previous(op))
            .is_some_and(|left| self.ends_operand(left.text))
    }

    fn infix_apart(&self, k: usize) -> bool {
        self.operator_before(k)
            .is_some_and(|op| self.pieces[op].apart)
    }

    fn operator_before(&self, k: usize) -> Option<usize> {
        (0..k).rev().find(|k| !self.pieces[*k].comment)
    }
}

fn is_word_operator(text: &str) -> bool {
    matches!(
        text,
        "and" | "or" | "not" | "where" | "when" | "within" | "in" | "lattice"
    )
}
