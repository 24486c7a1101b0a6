//! Text -> [`ast`]. The only file that names `Rule`.
//!
//! A definition that cannot be read is skipped to the next one, reported at the token where reading
//! stopped, and its name is remembered in `broken`, so that its uses are no errors.

use crate::ast::{self, Argument, Expr, ExprKind, Name, Text};
use crate::check::syntax;
use crate::diag::Diagnostic;
use crate::ir::{BinaryOp, CompareOp, Home, Shape};
use crate::span::Span;
use pest::Parser;
use pest::error::{Error, ErrorVariant, InputLocation};
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
    /// The grammar and this file disagree.
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
    /// Parses `text`, which starts at byte `offset` of the source.
    fn parse(
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

    fn syntax_error(&self, error: &Error<Rule>, offset: usize) -> Diagnostic {
        let at = offset
            + match error.location {
                InputLocation::Pos(at) => at,
                InputLocation::Span((at, _)) => at,
            };
        let token = self.token_at(at);
        let span = self.range(at, at + token.len());
        match &error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                let expected = syntax::in_order(positives.iter().map(|rule| expectation(*rule)));
                syntax::unexpected(span, token, self.end_of_line_before(at), &expected)
            }
            ErrorVariant::CustomError { .. } => syntax::too_deep(span),
        }
    }

    /// Where the line before a token ends: what is missing is missing there.
    fn end_of_line_before(&self, at: usize) -> Option<Span> {
        let end = self.text.get(..at)?.trim_end().len();
        self.text
            .get(end..at)?
            .contains('\n')
            .then(|| self.range(end.saturating_sub(1), end))
    }

    fn token_at(&self, at: usize) -> &'t str {
        let rest = self.text.get(at..).unwrap_or_default();
        Grammar::parse(Rule::token, rest).map_or("", |pairs| pairs.as_str())
    }

    fn failure(&self, failure: Failure) -> Diagnostic {
        match failure {
            Failure::TooHigh(span) => syntax::too_deep(span),
            Failure::Unexpected => syntax::unreadable(self.range(0, self.text.len())),
        }
    }

    fn range(&self, start: usize, end: usize) -> Span {
        Span {
            start: start as u32,
            end: end as u32,
            prelude: self.prelude,
        }
    }

    fn span(&self, pair: &Pair<Rule>) -> Span {
        let span = pair.as_span();
        self.range(span.start(), span.end())
    }

    // ---- files

    fn file(&self, pairs: Pairs<'t, Rule>, report: &mut Vec<Diagnostic>) -> ast::File {
        let mut file = ast::File::default();
        let mut scraps = 0;
        for pair in pairs.flat_map(Pair::into_inner) {
            match pair.as_rule() {
                Rule::top_item => {
                    if let Err(failure) = self.top_item(pair, &mut file, report) {
                        report.push(self.failure(failure));
                    }
                }
                Rule::top_scrap => {
                    // What follows a broken model is often the rest of it: only the first scrap is news.
                    if scraps == 0 {
                        self.scrap(&pair, Rule::top_probe, report);
                    }
                    scraps += 1;
                    file.broken.extend(self.declared(&pair));
                }
                _ => {}
            }
        }
        file
    }

    /// Says where a scrap goes wrong.
    fn scrap(&self, pair: &Pair<'t, Rule>, probe: Rule, report: &mut Vec<Diagnostic>) {
        let start = pair.as_span().start();
        let rest = self.text.get(start..).unwrap_or_default();
        if self.parse(probe, rest, start, report).is_some() {
            report.push(syntax::unreadable(self.span(pair)));
        }
    }

    /// The name that a scrap would have declared.
    fn declared(&self, pair: &Pair<'t, Rule>) -> Option<Name> {
        let start = pair.as_span().start();
        let words = Grammar::parse(Rule::name_probe, self.text.get(start..)?).ok()?;
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

    fn top_item(
        &self,
        pair: Pair<'t, Rule>,
        file: &mut ast::File,
        report: &mut Vec<Diagnostic>,
    ) -> Build<()> {
        let item = Children::of(pair).any()?;
        match item.as_rule() {
            Rule::model => file.models.push(self.model(item, report)?),
            Rule::influence_fn => file.influences.push(self.influence_fn(item)?),
            Rule::function => file.functions.push(self.function(item)?),
            Rule::definition => file.definitions.push(self.definition(item)?),
            _ => return Err(Failure::Unexpected),
        }
        Ok(())
    }

    fn model(&self, pair: Pair<'t, Rule>, report: &mut Vec<Diagnostic>) -> Build<ast::Model> {
        let mut parts = Children::of(pair);
        parts.expect(Rule::kw_model)?;
        let name = self.name(&parts.expect(Rule::ident)?);
        let title = parts.accept(Rule::string).map(|pair| self.string(&pair));
        let mut model = ast::Model {
            name,
            title,
            cites: Vec::new(),
            items: Vec::new(),
            broken: Vec::new(),
        };
        for part in parts {
            match part.as_rule() {
                Rule::citation => {
                    let strings = part
                        .into_inner()
                        .filter(|part| part.as_rule() == Rule::string);
                    model.cites.extend(strings.map(|part| self.string(&part)));
                }
                Rule::item => match self.item(part) {
                    Ok(item) => model.items.push(item),
                    Err(failure) => report.push(self.failure(failure)),
                },
                Rule::item_scrap => {
                    self.scrap(&part, Rule::item_probe, report);
                    model.broken.extend(self.declared(&part));
                }
                _ => {}
            }
        }
        Ok(model)
    }

    fn function(&self, pair: Pair<'t, Rule>) -> Build<ast::Function> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let mut params = Vec::new();
        loop {
            let part = parts.any()?;
            match part.as_rule() {
                Rule::ident => params.push(self.name(&part)),
                Rule::expression => {
                    return Ok(ast::Function {
                        name,
                        params,
                        body: self.expression(part)?,
                    });
                }
                _ => {}
            }
        }
    }

    fn influence_fn(&self, pair: Pair<'t, Rule>) -> Build<ast::InfluenceFn> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let variable = self.name(&parts.skip_to(Rule::ident)?);
        let mut params = Vec::new();
        loop {
            let part = parts.any()?;
            match part.as_rule() {
                Rule::influence_param => params.push(self.param(part)?),
                Rule::expression => {
                    let body = self.expression(part)?;
                    let doc = parts.accept(Rule::string).map(|pair| self.string(&pair));
                    return Ok(ast::InfluenceFn {
                        name,
                        variable,
                        params,
                        body,
                        doc,
                    });
                }
                _ => {}
            }
        }
    }

    // ---- the body of a model

    fn item(&self, pair: Pair<'t, Rule>) -> Build<ast::Item> {
        let item = Children::of(pair).any()?;
        Ok(match item.as_rule() {
            Rule::influence_slot => ast::Item::Influence(self.influence_slot(item)?),
            Rule::param => ast::Item::Param(self.param(item)?),
            Rule::definition => ast::Item::Definition(self.definition(item)?),
            Rule::response => ast::Item::Response(self.response(item)?),
            Rule::field => ast::Item::Field(self.field(item)?),
            Rule::history => ast::Item::History(self.history(item)?),
            Rule::update => ast::Item::Update(self.update(item)?),
            Rule::family => ast::Item::Family(self.family(item)?),
            Rule::breaking => ast::Item::Break(self.breaking(item)?),
            _ => return Err(Failure::Unexpected),
        })
    }

    fn influence_slot(&self, pair: Pair<'t, Rule>) -> Build<ast::InfluenceSlot> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let default = parts.find(|part| part.as_rule() == Rule::expression);
        Ok(ast::InfluenceSlot {
            name,
            default: default.map(|part| self.expression(part)).transpose()?,
        })
    }

    /// A parameter of a law or of an influence function.
    fn param(&self, pair: Pair<'t, Rule>) -> Build<ast::Param> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let kind = self.kind(parts.skip_to(Rule::kind)?)?;
        let mut param = ast::Param {
            name,
            kind,
            bounds: Vec::new(),
            default: None,
            doc: None,
        };
        for part in parts {
            match part.as_rule() {
                Rule::bound => param.bounds.push(self.bound(part)?),
                Rule::default => param.default = Some(self.default(part)?),
                Rule::string => param.doc = Some(self.string(&part)),
                _ => {}
            }
        }
        Ok(param)
    }

    fn default(&self, pair: Pair<'t, Rule>) -> Build<ast::Quantity> {
        self.quantity(Children::of(pair).skip_to(Rule::quantity)?)
    }

    fn definition(&self, pair: Pair<'t, Rule>) -> Build<ast::Definition> {
        let mut parts = Children::of(pair);
        let home = match parts.expect(Rule::home_word)?.as_str() {
            "let" => Home::Constant,
            "node" => Home::Node,
            _ => Home::Bond,
        };
        let name = self.name(&parts.expect(Rule::ident)?);
        let annotation = self.optional_annotation(&mut parts)?;
        Ok(ast::Definition {
            home,
            name,
            annotation,
            expr: self.last_expression(parts)?,
        })
    }

    fn last_expression(&self, mut parts: Children<'t>) -> Build<Expr> {
        self.expression(parts.skip_to(Rule::expression)?)
    }

    fn response(&self, pair: Pair<'t, Rule>) -> Build<ast::Response> {
        let mut parts = Children::of(pair);
        let kind = match parts.expect(Rule::response_word)?.as_str() {
            "energy" => ast::ResponseKind::Energy,
            "pair" => ast::ResponseKind::Pair,
            "state" => ast::ResponseKind::State,
            _ => ast::ResponseKind::Rate,
        };
        let family = self.optional_family(&mut parts)?;
        let name = self.name(&parts.expect(Rule::ident)?);
        let annotation = self.optional_annotation(&mut parts)?;
        Ok(ast::Response {
            kind,
            family,
            name,
            annotation,
            expr: self.last_expression(parts)?,
        })
    }

    fn field(&self, pair: Pair<'t, Rule>) -> Build<ast::Field> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let annotation = self.annotation(parts.expect(Rule::annotation)?)?;
        Ok(ast::Field {
            name,
            annotation,
            doc: parts.accept(Rule::string).map(|pair| self.string(&pair)),
        })
    }

    fn history(&self, pair: Pair<'t, Rule>) -> Build<ast::History> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let annotation = self.annotation(parts.expect(Rule::annotation)?)?;
        let initial = parts
            .accept(Rule::default)
            .map(|part| self.default(part))
            .transpose()?;
        parts.expect(Rule::kw_on)?;
        let home = if parts.any()?.as_rule() == Rule::kw_node {
            Home::Node
        } else {
            Home::Bond
        };
        let family = self.optional_family(&mut parts)?;
        let doc = parts.accept(Rule::string).map(|pair| self.string(&pair));
        Ok(ast::History {
            name,
            annotation,
            initial,
            home,
            family,
            doc,
        })
    }

    fn update(&self, pair: Pair<'t, Rule>) -> Build<ast::Update> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        Ok(ast::Update {
            name,
            expr: self.last_expression(parts)?,
        })
    }

    fn family(&self, pair: Pair<'t, Rule>) -> Build<ast::Family> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let base = self.name(&parts.skip_to(Rule::ident)?);
        Ok(ast::Family {
            name,
            base,
            filter: self.last_expression(parts)?,
        })
    }

    fn breaking(&self, pair: Pair<'t, Rule>) -> Build<ast::Break> {
        let mut parts = Children::of(pair);
        let span = self.span(&parts.expect(Rule::kw_break)?);
        let family = self.optional_family(&mut parts)?;
        let after = parts.accept(Rule::kw_after).is_some();
        Ok(ast::Break {
            family,
            after,
            when: self.last_expression(parts)?,
            span,
        })
    }

    fn optional_family(&self, parts: &mut Children<'t>) -> Build<Option<Name>> {
        let Some(reference) = parts.accept(Rule::family_ref) else {
            return Ok(None);
        };
        Ok(Some(
            self.name(&Children::of(reference).skip_to(Rule::ident)?),
        ))
    }

    fn optional_annotation(&self, parts: &mut Children<'t>) -> Build<Option<ast::Annotation>> {
        parts
            .accept(Rule::annotation)
            .map(|pair| self.annotation(pair))
            .transpose()
    }

    fn annotation(&self, pair: Pair<'t, Rule>) -> Build<ast::Annotation> {
        let mut annotation = ast::Annotation {
            shape: None,
            kind: None,
            span: self.span(&pair),
        };
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::shape_word => annotation.shape = Some(shape(part.as_str())),
                Rule::kind => annotation.kind = Some(self.kind(part)?),
                _ => {}
            }
        }
        Ok(annotation)
    }

    fn kind(&self, pair: Pair<'t, Rule>) -> Build<ast::Kind> {
        let part = Children::of(pair).any()?;
        match part.as_rule() {
            Rule::ident => Ok(ast::Kind::Named(self.name(&part))),
            _ => Ok(ast::Kind::Unit(self.unit(part)?)),
        }
    }

    fn bound(&self, pair: Pair<'t, Rule>) -> Build<ast::Bound> {
        let span = self.span(&pair);
        let mut parts = Children::of(pair);
        if let Some(op) = parts.accept(Rule::compare) {
            return Ok(ast::Bound::Side(
                comparison(op.as_str()),
                self.quantity(parts.any()?)?,
            ));
        }
        parts.expect(Rule::kw_in)?;
        let lower_in = parts.any()?.as_rule() == Rule::bra;
        let lower = self.quantity(parts.any()?)?;
        parts.expect(Rule::comma)?;
        let upper = self.quantity(parts.any()?)?;
        let upper_in = parts.any()?.as_rule() == Rule::ket;
        Ok(ast::Bound::Interval {
            lower,
            lower_in,
            upper,
            upper_in,
            span,
        })
    }

    // ---- numbers and units

    fn quantity(&self, pair: Pair<'t, Rule>) -> Build<ast::Quantity> {
        let mut quantity = ast::Quantity {
            value: 0.0,
            unit: None,
            span: self.span(&pair),
        };
        let mut sign = 1.0;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::minus => sign = -1.0,
                Rule::infinity => quantity.value = f64::INFINITY,
                Rule::literal => quantity.value = literal(&part)?,
                _ => quantity.unit = Some(self.unit(part)?),
            }
        }
        quantity.value *= sign;
        Ok(quantity)
    }

    /// From any rule that holds unit names: the product of their powers.
    fn unit(&self, pair: Pair<'t, Rule>) -> Build<ast::UnitExpr> {
        let span = self.span(&pair);
        let mut factors = Vec::new();
        self.unit_factors(pair, 1.0, 0, &mut factors)?;
        Ok(ast::UnitExpr { factors, span })
    }

    fn unit_factors(
        &self,
        pair: Pair<'t, Rule>,
        power: f64,
        height: usize,
        factors: &mut Vec<(Name, f64)>,
    ) -> Build<()> {
        if height > MAX_HEIGHT {
            return Err(Failure::TooHigh(self.span(&pair)));
        }
        let own = pair
            .clone()
            .into_inner()
            .find(|part| part.as_rule() == Rule::unit_power);
        let power = power * own.map_or(Ok(1.0), |part| unit_power(&part))?;
        let mut sign = 1.0;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::unit_op => sign = if part.as_str() == "/" { -1.0 } else { 1.0 },
                Rule::unit_name => factors.push((
                    Name {
                        text: part.as_str().into(),
                        span: self.span(&part),
                    },
                    power,
                )),
                Rule::unit | Rule::unit_factor | Rule::unit_simple => {
                    self.unit_factors(part, sign * power, height + 1, factors)?;
                    sign = 1.0;
                }
                _ => {}
            }
        }
        Ok(())
    }

    // ---- expressions

    fn expression(&self, pair: Pair<'t, Rule>) -> Build<Expr> {
        self.tree(pair, 0).map(|(expr, _)| expr)
    }

    /// An expression and its height. `depth` counts what encloses it.
    fn tree(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let span = self.span(&pair);
        if depth > MAX_HEIGHT {
            return Err(Failure::TooHigh(span));
        }
        let (expr, height) = match pair.as_rule() {
            Rule::expression
            | Rule::conjunction
            | Rule::additive
            | Rule::product
            | Rule::comparison => self.chain(pair, depth),
            Rule::negation => self.prefixed(pair, Rule::kw_not, ExprKind::Not, depth),
            Rule::unary | Rule::exponent => self.prefixed(pair, Rule::minus, ExprKind::Neg, depth),
            Rule::power => self.power(pair, depth),
            Rule::raised => self.raised(pair, depth),
            Rule::postfix => self.postfix(pair, depth),
            Rule::number => self.number(pair),
            Rule::name => Ok((
                Expr {
                    kind: ExprKind::Name(spelled(pair.as_str())),
                    span,
                },
                1,
            )),
            Rule::group => self.tree(Children::of(pair).skip_to(Rule::expression)?, depth + 1),
            Rule::call => self.call(pair, depth),
            Rule::case => self.case(pair, depth),
            _ => Err(Failure::Unexpected),
        }?;
        if height > MAX_HEIGHT {
            Err(Failure::TooHigh(span))
        } else {
            Ok((expr, height))
        }
    }

    /// Operands with operators between them, grouped from the left.
    fn chain(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let mut parts = Children::of(pair);
        let (mut left, mut height) = self.tree(parts.any()?, depth)?;
        while let Some(op) = parts.next() {
            let (right, right_height) = self.tree(parts.any()?, depth)?;
            height = height.max(right_height) + 1;
            let span = join(left.span, right.span);
            let (left_box, right_box) = (Box::new(left), Box::new(right));
            let kind = match binary(&op) {
                Some(operator) => ExprKind::Binary(operator, left_box, right_box),
                None => ExprKind::Compare(comparison(op.as_str()), left_box, right_box),
            };
            left = Expr { kind, span };
            if height > MAX_HEIGHT {
                return Err(Failure::TooHigh(span));
            }
        }
        Ok((left, height))
    }

    fn prefixed(
        &self,
        pair: Pair<'t, Rule>,
        sign: Rule,
        wrap: fn(Box<Expr>) -> ExprKind,
        depth: usize,
    ) -> Build<(Expr, usize)> {
        let span = self.span(&pair);
        let mut parts = Children::of(pair);
        let mut starts = Vec::new();
        while let Some(mark) = parts.accept(sign) {
            starts.push(mark.as_span().start());
        }
        let (mut expr, height) = self.tree(parts.any()?, depth)?;
        if height + starts.len() > MAX_HEIGHT {
            return Err(Failure::TooHigh(span));
        }
        let height = height + starts.len();
        for start in starts.into_iter().rev() {
            expr = Expr {
                kind: wrap(Box::new(expr)),
                span: Span {
                    start: start as u32,
                    ..span
                },
            };
        }
        Ok((expr, height))
    }

    /// `a^b^c` is `a^(b^c)`.
    fn power(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let operands = pair.into_inner().filter(|part| part.as_rule() != Rule::hat);
        let mut operands: Vec<_> = operands
            .map(|part| self.tree(part, depth))
            .collect::<Build<_>>()?;
        let (mut result, mut height) = operands.pop().ok_or(Failure::Unexpected)?;
        while let Some((base, base_height)) = operands.pop() {
            height = height.max(base_height) + 1;
            let span = join(base.span, result.span);
            if height > MAX_HEIGHT {
                return Err(Failure::TooHigh(span));
            }
            result = raise(base, result, span);
        }
        Ok((result, height))
    }

    fn raised(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let span = self.span(&pair);
        let mut parts = Children::of(pair);
        let (base, height) = self.tree(parts.any()?, depth)?;
        let Some(mark) = parts.next() else {
            return Ok((base, height));
        };
        let exponent = if mark.as_rule() == Rule::cube {
            3.0
        } else {
            2.0
        };
        let exponent = Expr {
            kind: ExprKind::Number(exponent, None),
            span: self.span(&mark),
        };
        Ok((
            Expr {
                kind: ExprKind::Binary(BinaryOp::Pow, Box::new(base), Box::new(exponent)),
                span,
            },
            height + 1,
        ))
    }

    fn postfix(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let mut parts = Children::of(pair);
        let (mut expr, mut height) = self.tree(parts.any()?, depth)?;
        for mark in parts {
            let span = join(expr.span, self.span(&mark));
            height += 1;
            if height > MAX_HEIGHT {
                return Err(Failure::TooHigh(span));
            }
            let kind = match mark.as_rule() {
                Rule::prime => ExprKind::Prime(Box::new(expr)),
                _ => ExprKind::Component(
                    Box::new(expr),
                    self.name(&Children::of(mark).expect(Rule::ident)?),
                ),
            };
            expr = Expr { kind, span };
        }
        Ok((expr, height))
    }

    fn number(&self, pair: Pair<'t, Rule>) -> Build<(Expr, usize)> {
        let span = self.span(&pair);
        let mut parts = Children::of(pair);
        let value = literal(&parts.expect(Rule::literal)?)?;
        let unit = parts.next().map(|part| self.unit(part)).transpose()?;
        Ok((
            Expr {
                kind: ExprKind::Number(value, unit),
                span,
            },
            1,
        ))
    }

    fn call(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let span = self.span(&pair);
        let mut parts = Children::of(pair);
        let name = self.name(&parts.expect(Rule::ident)?);
        let family = self.optional_family(&mut parts)?;
        let (mut args, mut height) = (Vec::new(), 0);
        for part in parts.filter(|part| part.as_rule() == Rule::argument) {
            let mut argument = Children::of(part);
            let name = argument.accept(Rule::ident).map(|pair| self.name(&pair));
            let (value, value_height) =
                self.tree(argument.skip_to(Rule::expression)?, depth + 1)?;
            height = height.max(value_height);
            args.push(Argument { name, value });
        }
        let kind = match (name.text.as_str(), args.len()) {
            // The prime of texts in which a lone quote is no token, such as Rust.
            ("other", 1) => ExprKind::Prime(Box::new(args.swap_remove(0).value)),
            _ => ExprKind::Call { name, family, args },
        };
        Ok((Expr { kind, span }, height + 1))
    }

    fn case(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let span = self.span(&pair);
        let (mut arms, mut height) = (Vec::new(), 0);
        for part in pair.into_inner().filter(|part| part.as_rule() == Rule::arm) {
            let mut arm = Children::of(part);
            let flavour = arm.expect(Rule::flavour)?;
            let name = Name {
                text: flavour.as_str().into(),
                span: self.span(&flavour),
            };
            let (value, value_height) = self.tree(arm.skip_to(Rule::expression)?, depth + 1)?;
            height = height.max(value_height);
            arms.push((name, value));
        }
        Ok((
            Expr {
                kind: ExprKind::Case(arms),
                span,
            },
            height + 1,
        ))
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

fn raise(base: Expr, exponent: Expr, span: Span) -> Expr {
    Expr {
        kind: ExprKind::Binary(BinaryOp::Pow, Box::new(base), Box::new(exponent)),
        span,
    }
}

fn join(left: Span, right: Span) -> Span {
    Span {
        start: left.start,
        end: right.end,
        prelude: left.prelude,
    }
}

fn literal(pair: &Pair<Rule>) -> Build<f64> {
    pair.as_str().parse().map_err(|_| Failure::Unexpected)
}

fn unit_power(pair: &Pair<Rule>) -> Build<f64> {
    match pair.as_str() {
        "²" => Ok(2.0),
        "³" => Ok(3.0),
        text => text
            .trim_start_matches('^')
            .trim()
            .parse()
            .map_err(|_| Failure::Unexpected),
    }
}

fn shape(word: &str) -> Shape {
    match word {
        "vector" => Shape::Vector,
        "symmetric" => Shape::Symmetric,
        "tensor" => Shape::Tensor,
        _ => Shape::Scalar,
    }
}

fn binary(op: &Pair<Rule>) -> Option<BinaryOp> {
    match (op.as_rule(), op.as_str()) {
        (Rule::kw_or, _) => Some(BinaryOp::Or),
        (Rule::kw_and, _) => Some(BinaryOp::And),
        (Rule::add_op, "+") => Some(BinaryOp::Add),
        (Rule::add_op, _) => Some(BinaryOp::Sub),
        (Rule::mul_op, "/") => Some(BinaryOp::Div),
        (Rule::mul_op, _) => Some(BinaryOp::Mul),
        _ => None,
    }
}

fn comparison(op: &str) -> CompareOp {
    match op {
        "<" => CompareOp::Lt,
        "<=" | "≤" => CompareOp::Le,
        ">" => CompareOp::Gt,
        _ => CompareOp::Ge,
    }
}

/// A Greek letter and its name are the same letter: `ω_g` is `omega_g`.
fn spelled(word: &str) -> String {
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

/// What a rule is called in "expected ..".
fn expectation(rule: Rule) -> syntax::Expected {
    use syntax::Expected::*;
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
        Rule::item | Rule::item_word | Rule::item_scrap => Word("the next definition"),
        Rule::top_item | Rule::top_word | Rule::top_scrap | Rule::model | Rule::function => {
            Word("`model`, `influence` or `fn`")
        }
        Rule::kind | Rule::annotation => Word("a kind such as `number`, `pressure` or `[J/m^2]`"),
        Rule::bound => Word("bounds such as `> 0`"),
        Rule::default => Token("="),
        Rule::citation | Rule::kw_cite => Token("cite"),
        Rule::unit
        | Rule::unit_factor
        | Rule::unit_simple
        | Rule::unit_name
        | Rule::unit_tail
        | Rule::unit_one => Word("a unit"),
        Rule::unit_bracket => Unit,
        Rule::unit_exponent => Word("an integer"),
        Rule::unit_op | Rule::unit_power | Rule::minus | Rule::kw_not => Unit,
        Rule::arm | Rule::flavour => {
            Word("a flavour (bar, slab, plane_stress, plane_strain or 3d)")
        }
        Rule::family_ref => Unit,
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
        Rule::kw_when => Token("when"),
        Rule::kw_after => Token("after"),
        Rule::kw_on => Token("on"),
        Rule::kw_in => Token("in"),
        Rule::kw_flavour => Token("flavour"),
        Rule::kw_node => Token("node"),
        Rule::kw_bond => Token("bond"),
        _ => Unit,
    }
}
