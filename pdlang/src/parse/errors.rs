//! Where a text cannot be read, and what could have stood there.

use super::{Failure, Grammar, Reader, Rule, spelled};
use crate::ast::Name;
use crate::check::habits;
use crate::check::syntax::{self, Expected};
use crate::diag::Diagnostic;
use crate::span::Span;
use pest::Parser;
use pest::error::{Error, ErrorVariant, InputLocation};
use pest::iterators::{Pair, Pairs};

/// A text with more errors than this is no law with errors.
const MAX_PROBES: usize = 40;

impl<'t> Reader<'t> {
    /// Parses `text`, which starts at byte `offset` of the source.
    pub(super) fn parse(
        &self,
        rule: Rule,
        text: &'t str,
        offset: usize,
        report: &mut Vec<Diagnostic>,
    ) -> Option<Pairs<'t, Rule>> {
        match Grammar::parse(rule, text) {
            Ok(pairs) => Some(pairs),
            Err(error) => {
                report.push(self.syntax_error(&error, offset));
                None
            }
        }
    }

    pub(super) fn syntax_error(&self, error: &Error<Rule>, offset: usize) -> Diagnostic {
        let at = offset
            + match error.location {
                InputLocation::Pos(at) => at,
                InputLocation::Span((at, _)) => at,
            };
        let before = self.text.get(..at).unwrap_or_default();
        let line = &before[before.rfind('\n').map_or(0, |end| end + 1)..];
        let habit = habits::token(line, self.text.get(at..).unwrap_or_default());
        // A blank is no token to point at: what stands before it cannot end there.
        let blank = self.token_at(at).trim().is_empty() && line.ends_with('.');
        let at = if blank { at - 1 } else { at };
        let token = self.token_at(at);
        let span = self.range(at, at + token.len());
        match &error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                let expected = positives.iter().map(|rule| expectation(*rule)).collect();
                let finding = syntax::unexpected(span, token, self.line_before(at), expected);
                match habit {
                    Some(remedy) => finding.help(remedy),
                    None => finding,
                }
            }
            ErrorVariant::CustomError { .. } => syntax::too_deep(span),
        }
    }

    /// The end of the last token on an earlier line: what is missing is missing there.
    fn line_before(&self, at: usize) -> Option<Span> {
        let before = self.text.get(..at)?;
        let tokens = Grammar::parse(Rule::tokens, before).ok()?;
        let last = tokens
            .flat_map(Pair::into_inner)
            .filter(|pair| pair.as_rule() == Rule::token)
            .last()?;
        let end = last.as_span().end();
        before
            .get(end..)?
            .contains('\n')
            .then(|| self.range(last.as_span().start(), end))
    }

    pub(super) fn token_at(&self, at: usize) -> &'t str {
        let rest = self.text.get(at..).unwrap_or_default();
        Grammar::parse(Rule::token, rest).map_or("", |pairs| pairs.as_str())
    }

    pub(super) fn failure(&self, failure: Failure) -> Diagnostic {
        match failure {
            Failure::TooHigh(span) => syntax::too_deep(span),
            Failure::Unexpected => syntax::unreadable(self.range(0, self.text.len())),
        }
    }

    /// Says where a scrap goes wrong, if not enough has been said already.
    pub(super) fn scrap(&self, pair: &Pair<'t, Rule>, again: Rule, report: &mut Vec<Diagnostic>) {
        if report.len() >= MAX_PROBES {
            return;
        }
        let start = pair.as_span().start();
        let rest = self.text.get(start..).unwrap_or_default();
        if self.parse(again, rest, start, report).is_some() {
            report.push(syntax::unreadable(self.span(pair)));
        }
    }

    /// The names that a scrap would have declared: at its start, and where reading stopped.
    pub(super) fn declared(&self, pair: &Pair<'t, Rule>, again: Rule) -> Vec<Name> {
        let scrap = pair.as_str();
        let stopped = Grammar::parse(again, scrap)
            .err()
            .map(|error| match error.location {
                InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
            });
        [Some(0), stopped]
            .into_iter()
            .flatten()
            .filter_map(|at| self.declared_at(pair.as_span().start() + at, scrap.get(at..)?))
            .collect()
    }

    fn declared_at(&self, start: usize, text: &'t str) -> Option<Name> {
        let words = Grammar::parse(Rule::name_probe, text).ok()?;
        let ident = words
            .flat_map(Pair::into_inner)
            .find(|pair| pair.as_rule() == Rule::ident)?;
        Some(Name {
            text: spelled(ident.as_str()),
            span: self.range(
                start + ident.as_span().start(),
                start + ident.as_span().end(),
            ),
        })
    }
}

/// What a rule is called in "expected ..".
fn expectation(rule: Rule) -> Expected {
    use Expected::*;
    match rule {
        Rule::EOI => End,
        Rule::ident | Rule::name => Word("a name"),
        Rule::string | Rule::string_text => Word("a text in quotes"),
        Rule::quantity | Rule::literal | Rule::infinity => Word("a number"),
        Rule::expression
        | Rule::conjunction
        | Rule::negation
        | Rule::comparison
        | Rule::additive
        | Rule::product
        | Rule::unary
        | Rule::power
        | Rule::exponent
        | Rule::raised
        | Rule::postfix
        | Rule::number
        | Rule::group
        | Rule::call
        | Rule::case
        | Rule::argument => Word("an expression"),
        Rule::kw_or
        | Rule::kw_and
        | Rule::add_op
        | Rule::mul_op
        | Rule::compare
        | Rule::hat
        | Rule::square
        | Rule::cube
        | Rule::prime
        | Rule::component => Operator,
        Rule::item | Rule::item_word | Rule::item_scrap => Item,
        Rule::top_item | Rule::top_word | Rule::top_scrap => TopItem,
        Rule::kind | Rule::energy_kind | Rule::annotation => {
            Word("a kind such as `number`, `pressure` or `[J/m^2]`")
        }
        Rule::bound => Word("bounds such as `> 0`"),
        Rule::default => Token("="),
        Rule::citation | Rule::kw_cite => Token("cite"),
        Rule::serves | Rule::kw_for => Token("for"),
        Rule::unit
        | Rule::unit_factor
        | Rule::unit_simple
        | Rule::unit_name
        | Rule::unit_tail
        | Rule::unit_one => Word("a unit"),
        Rule::unit_exponent => Word("an integer"),
        Rule::arm | Rule::flavour => {
            Word("a flavour (bar, slab, plane_stress, plane_strain or 3d)")
        }
        Rule::equals => Token("="),
        Rule::colon => Token(":"),
        Rule::semicolon => Token(";"),
        Rule::comma => Token(","),
        Rule::open => Token("("),
        Rule::close => Token(")"),
        Rule::bra => Token("["),
        Rule::ket => Token("]"),
        Rule::left => Token("{"),
        Rule::right => Token("}"),
        Rule::kw_where => Token("where"),
        Rule::kw_meets | Rule::meet => Token("meets"),
        Rule::kw_when => Token("when"),
        Rule::kw_after => Token("after"),
        Rule::kw_at => Token("at"),
        Rule::kw_half => Token("half"),
        Rule::kw_step => Token("step"),
        Rule::kw_on => Token("on"),
        Rule::kw_in => Token("in"),
        Rule::kw_use => Token("use"),
        Rule::kw_within => Token("within"),
        Rule::kw_rate => Token("rate"),
        Rule::components | Rule::rows | Rule::row => {
            Word("a value, or components such as `(1 mm, 0, 0)`")
        }
        Rule::setting => Word("a setting such as `K = 1 GPa`"),
        Rule::place => Word("a place such as `(a)`"),
        Rule::probe_line
        | Rule::probe_let
        | Rule::probe_node
        | Rule::probe_lattice
        | Rule::probe_cut
        | Rule::expectation => Word("`let`, `node`, `lattice`, `break` or `expect`"),
        Rule::kw_flavour => Token("flavour"),
        Rule::kw_node => Token("node"),
        Rule::kw_bond => Token("bond"),
        _ => Anywhere,
    }
}
