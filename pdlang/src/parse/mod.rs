//! Text -> [`ast`]. Only this folder names `Rule`.
//!
//! A definition that cannot be read is skipped to the next one, reported at the token where reading
//! stopped, and its name is remembered in `broken`, so that its uses are no errors.

mod errors;
mod expressions;
mod files;
mod items;
mod numbers;
mod probes;

use crate::ast::{self, Expr, Name, Text};
use crate::diag::Diagnostic;
use crate::span::Span;
use pest::Parser;
use pest::iterators::{Pair, Pairs};

#[derive(pest_derive::Parser)]
#[grammar = "grammar.pest"]
struct Grammar;

/// Height of an expression tree. Every pass recurses over it, and a formula of a paper stays below 30.
const MAX_HEIGHT: usize = 120;

/// Reads a file. What is not returned is reported.
pub(crate) fn file(text: &str, prelude: bool, report: &mut Vec<Diagnostic>) -> ast::File {
    let reader = Reader { text, prelude };
    let Some(pairs) = reader.parse(Rule::file, text, 0, report) else {
        return ast::File::default();
    };
    reader.file(pairs, report)
}

/// Where the tokens of a text stand; between them there is white space, and there are comments.
pub(crate) fn tokens(text: &str) -> Vec<std::ops::Range<usize>> {
    let pairs = Grammar::parse(Rule::tokens, text).into_iter().flatten();
    let tokens = pairs.flat_map(Pair::into_inner);
    tokens
        .filter(|pair| pair.as_rule() == Rule::token)
        .map(|pair| {
            let span = pair.as_span();
            span.start()..span.start() + span.as_str().trim_end().len()
        })
        .collect()
}

pub(crate) fn expression(text: &str) -> Result<Expr, Vec<Diagnostic>> {
    alone(text, Rule::expression_only, Reader::expression)
}

pub(crate) fn quantity(text: &str) -> Result<ast::Quantity, Vec<Diagnostic>> {
    alone(text, Rule::quantity_only, Reader::quantity)
}

pub(crate) fn unit(text: &str) -> Result<ast::UnitExpr, Vec<Diagnostic>> {
    alone(text, Rule::unit_only, Reader::unit)
}

fn alone<'t, T>(
    text: &'t str,
    rule: Rule,
    build: fn(&Reader<'t>, Pair<'t, Rule>) -> Build<T>,
) -> Result<T, Vec<Diagnostic>> {
    let reader = Reader {
        text,
        prelude: false,
    };
    let mut report = Vec::new();
    let outer = reader
        .parse(rule, text, 0, &mut report)
        .and_then(|mut pairs| pairs.next());
    let Some(inner) = outer.and_then(|pair| pair.into_inner().next()) else {
        return Err(report);
    };
    build(&reader, inner).map_err(|failure| vec![reader.failure(failure)])
}

/// Why a tree could not be built from what the grammar accepted.
enum Failure {
    TooHigh(Span),
    /// The grammar and this folder disagree.
    Unexpected,
}

type Build<T> = Result<T, Failure>;

struct Reader<'t> {
    text: &'t str,
    prelude: bool,
}

/// The children of a rule, taken in order.
struct Children<'t>(std::iter::Peekable<Pairs<'t, Rule>>);

impl<'t> Children<'t> {
    fn of(pair: Pair<'t, Rule>) -> Self {
        Children(pair.into_inner().peekable())
    }

    /// The next child, if it is what is asked for.
    fn accept(&mut self, rule: Rule) -> Option<Pair<'t, Rule>> {
        self.0.next_if(|pair| pair.as_rule() == rule)
    }

    fn expect(&mut self, rule: Rule) -> Build<Pair<'t, Rule>> {
        self.accept(rule).ok_or(Failure::Unexpected)
    }

    /// Passes over what separates and what was only punctuation.
    fn skip_to(&mut self, rule: Rule) -> Build<Pair<'t, Rule>> {
        self.0
            .find(|pair| pair.as_rule() == rule)
            .ok_or(Failure::Unexpected)
    }

    fn any(&mut self) -> Build<Pair<'t, Rule>> {
        self.0.next().ok_or(Failure::Unexpected)
    }
}

impl<'t> Iterator for Children<'t> {
    type Item = Pair<'t, Rule>;
    fn next(&mut self) -> Option<Self::Item> {
        self.0.next()
    }
}

impl<'t> Reader<'t> {
    fn range(&self, start: usize, end: usize) -> Span {
        Span {
            start: start as u32,
            end: end as u32,
            prelude: self.prelude,
        }
    }

    fn span(&self, pair: &Pair<Rule>) -> Span {
        self.range(pair.as_span().start(), end(pair.clone()))
    }

    fn name(&self, pair: &Pair<Rule>) -> Name {
        Name {
            text: spelled(pair.as_str()),
            span: self.span(pair),
        }
    }

    fn string(&self, pair: &Pair<Rule>) -> Text {
        let quoted = pair.as_str();
        let inside = quoted
            .get(1..quoted.len().saturating_sub(1))
            .unwrap_or_default();
        Text {
            text: inside.replace("\\\"", "\"").replace("\\\\", "\\"),
            span: self.span(pair),
        }
    }
}

/// Where the last token of a rule ends: the rule itself may hold white space behind it.
fn end(mut pair: Pair<Rule>) -> usize {
    while pair.as_rule() != Rule::string {
        match pair.clone().into_inner().next_back() {
            Some(last) => pair = last,
            None => break,
        }
    }
    pair.as_span().end()
}

/// A Greek letter and its name are the same letter: `ω_g` is `omega_g`.
pub(crate) fn spelled(word: &str) -> String {
    const GREEK: [(char, &str); 24] = [
        ('α', "alpha"),
        ('β', "beta"),
        ('γ', "gamma"),
        ('δ', "delta"),
        ('ε', "epsilon"),
        ('ζ', "zeta"),
        ('η', "eta"),
        ('θ', "theta"),
        ('ι', "iota"),
        ('κ', "kappa"),
        ('λ', "lambda"),
        ('μ', "mu"),
        ('µ', "mu"),
        ('ν', "nu"),
        ('ξ', "xi"),
        ('π', "pi"),
        ('ρ', "rho"),
        ('σ', "sigma"),
        ('τ', "tau"),
        ('υ', "upsilon"),
        ('φ', "phi"),
        ('χ', "chi"),
        ('ψ', "psi"),
        ('ω', "omega"),
    ];
    let mut text = String::with_capacity(word.len());
    for letter in word.chars() {
        match GREEK.iter().find(|(greek, _)| *greek == letter) {
            Some((_, name)) => text.push_str(name),
            None => text.push(letter),
        }
    }
    text
}
