//! Expressions. Trees are bounded in height while they are built, so that no pass runs out of stack.

use super::numbers::literal;
use super::{Build, Children, Failure, MAX_HEIGHT, Reader, Rule, spelled};
use crate::ast::{Argument, Expr, ExprKind, Name};
use crate::ir::{BinaryOp, CompareOp};
use crate::span::Span;
use pest::iterators::Pair;

impl<'t> Reader<'t> {
    pub(super) fn expression(&self, pair: Pair<'t, Rule>) -> Build<Expr> {
        self.tree(pair, 0).map(|(expr, _)| expr)
    }

    /// An expression and its height. `depth` counts what encloses it.
    pub(super) fn tree(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let pair = innermost(pair);
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
            Rule::group => self.group(pair, depth),
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
    pub(super) fn chain(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let whole = self.span(&pair);
        let mut parts = Children::of(pair);
        let (mut left, mut height) = self.tree(parts.any()?, depth)?;
        while let Some(op) = parts.next() {
            let operand = parts.any()?;
            let span = join(whole, self.span(&operand));
            let (right, right_height) = self.tree(operand, depth)?;
            height = height.max(right_height) + 1;
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

    pub(super) fn prefixed(
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
    pub(super) fn power(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let operands = pair.into_inner().filter(|part| part.as_rule() != Rule::hat);
        let mut operands: Vec<_> = operands
            .map(|part| Ok((self.span(&part), self.tree(part, depth)?)))
            .collect::<Build<_>>()?;
        let (mut written, (mut result, mut height)) = operands.pop().ok_or(Failure::Unexpected)?;
        while let Some((base_written, (base, base_height))) = operands.pop() {
            height = height.max(base_height) + 1;
            let span = join(base_written, written);
            written = span;
            if height > MAX_HEIGHT {
                return Err(Failure::TooHigh(span));
            }
            result = raise(base, result, span);
        }
        Ok((result, height))
    }

    pub(super) fn raised(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
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

    pub(super) fn postfix(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let whole = self.span(&pair);
        let mut parts = Children::of(pair);
        let (mut expr, mut height) = self.tree(parts.any()?, depth)?;
        for mark in parts {
            let span = join(whole, self.span(&mark));
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

    /// What stands in parentheses: an expression, or the components of a vector.
    pub(super) fn group(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
        let span = self.span(&pair);
        let (mut components, mut height) = (Vec::new(), 0);
        for part in Children::of(pair).filter(|part| part.as_rule() == Rule::expression) {
            let (component, component_height) = self.tree(part, depth + 1)?;
            height = height.max(component_height);
            components.push(component);
        }
        match components.len() {
            0 => Err(Failure::Unexpected),
            1 => Ok((components.swap_remove(0), height)),
            _ => {
                let kind = ExprKind::Vector(components);
                Ok((Expr { kind, span }, height + 1))
            }
        }
    }

    pub(super) fn number(&self, pair: Pair<'t, Rule>) -> Build<(Expr, usize)> {
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

    pub(super) fn call(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
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

    pub(super) fn case(&self, pair: Pair<'t, Rule>, depth: usize) -> Build<(Expr, usize)> {
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
}

/// Steps through the levels of precedence at which nothing stands but the next level.
fn innermost(mut pair: Pair<Rule>) -> Pair<Rule> {
    loop {
        let mut parts = match pair.as_rule() {
            Rule::expression | Rule::conjunction | Rule::negation | Rule::comparison => {
                pair.clone()
            }
            Rule::additive | Rule::product | Rule::unary | Rule::power => pair.clone(),
            Rule::exponent | Rule::raised | Rule::postfix => pair.clone(),
            _ => return pair,
        }
        .into_inner();
        match (parts.next(), parts.next()) {
            (Some(only), None) => pair = only,
            _ => return pair,
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

pub(super) fn comparison(op: &str) -> CompareOp {
    match op {
        "<" => CompareOp::Lt,
        "<=" | "≤" => CompareOp::Le,
        ">" => CompareOp::Gt,
        _ => CompareOp::Ge,
    }
}
