//! The body of a model.

use super::expressions::comparison;
use super::{Build, Children, Failure, Reader, Rule};
use crate::ast::{self, Expr, Name};
use crate::ir::{Home, Shape};
use pest::iterators::Pair;

impl<'t> Reader<'t> {
    pub(super) fn item(&self, pair: Pair<'t, Rule>) -> Build<ast::Item> {
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
            Rule::weight => ast::Item::Weight(self.weight(item)?),
            Rule::breaking => ast::Item::Break(self.breaking(item)?),
            Rule::after_step => ast::Item::AfterStep(self.after_step(item)?),
            Rule::known => ast::Item::Known(self.known(item)?),
            Rule::probe => ast::Item::Probe(self.probe(item)?),
            _ => return Err(Failure::Unexpected),
        })
    }

    pub(super) fn influence_slot(&self, pair: Pair<'t, Rule>) -> Build<ast::InfluenceSlot> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let default = parts.find(|part| part.as_rule() == Rule::expression);
        Ok(ast::InfluenceSlot {
            name,
            default: default.map(|part| self.expression(part)).transpose()?,
        })
    }

    /// A parameter of a law or of an influence function.
    pub(super) fn param(&self, pair: Pair<'t, Rule>) -> Build<ast::Param> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let kind = self.kind(parts.skip_to(Rule::kind)?)?;
        let mut param = ast::Param {
            name,
            kind,
            bounds: Vec::new(),
            default: None,
            meet: None,
            doc: None,
        };
        for part in parts {
            match part.as_rule() {
                Rule::bound => param.bounds.push(self.bound(part)?),
                Rule::default => param.default = Some(self.default(part)?),
                Rule::meet => {
                    param.meet = Some(self.last_expression(Children::of(part))?);
                }
                Rule::string => param.doc = Some(self.string(&part)),
                _ => {}
            }
        }
        Ok(param)
    }

    pub(super) fn default(&self, pair: Pair<'t, Rule>) -> Build<ast::Quantity> {
        self.quantity(Children::of(pair).skip_to(Rule::quantity)?)
    }

    pub(super) fn definition(&self, pair: Pair<'t, Rule>) -> Build<ast::Definition> {
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

    pub(super) fn last_expression(&self, mut parts: Children<'t>) -> Build<Expr> {
        self.expression(parts.skip_to(Rule::expression)?)
    }

    pub(super) fn response(&self, pair: Pair<'t, Rule>) -> Build<ast::Response> {
        let mut parts = Children::of(pair);
        let kind = match parts.expect(Rule::response_word)?.as_str() {
            "energy" => ast::ResponseKind::Energy,
            "pair" => ast::ResponseKind::Pair,
            "state" => ast::ResponseKind::State,
            "force" => ast::ResponseKind::Force,
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

    pub(super) fn field(&self, pair: Pair<'t, Rule>) -> Build<ast::Field> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let annotation = self.annotation(parts.expect(Rule::annotation)?)?;
        let half = parts.accept(Rule::kw_at).is_some() && parts.accept(Rule::kw_half).is_some();
        let lives = match parts.accept(Rule::kw_where) {
            Some(_) => Some(self.expression(parts.expect(Rule::expression)?)?),
            None => None,
        };
        Ok(ast::Field {
            name,
            annotation,
            half,
            lives,
            doc: parts.accept(Rule::string).map(|pair| self.string(&pair)),
        })
    }

    pub(super) fn history(&self, pair: Pair<'t, Rule>) -> Build<ast::History> {
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

    pub(super) fn update(&self, pair: Pair<'t, Rule>) -> Build<ast::Update> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        Ok(ast::Update {
            name,
            expr: self.last_expression(parts)?,
        })
    }

    pub(super) fn family(&self, pair: Pair<'t, Rule>) -> Build<ast::Family> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let base = self.name(&parts.skip_to(Rule::ident)?);
        Ok(ast::Family {
            name,
            base,
            filter: self.last_expression(parts)?,
        })
    }

    pub(super) fn weight(&self, pair: Pair<'t, Rule>) -> Build<ast::Weight> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let expr = self.expression(parts.skip_to(Rule::expression)?)?;
        let doc = parts.accept(Rule::string).map(|pair| self.string(&pair));
        Ok(ast::Weight { name, expr, doc })
    }

    pub(super) fn breaking(&self, pair: Pair<'t, Rule>) -> Build<ast::Break> {
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

    pub(super) fn after_step(&self, pair: Pair<'t, Rule>) -> Build<ast::AfterStep> {
        let mut parts = Children::of(pair);
        Ok(ast::AfterStep {
            name: self.name(&parts.skip_to(Rule::ident)?),
            expr: self.last_expression(parts)?,
        })
    }

    pub(super) fn known(&self, pair: Pair<'t, Rule>) -> Build<ast::Known> {
        let mut checks = Vec::new();
        for part in Children::of(pair) {
            match part.as_rule() {
                Rule::ident => checks.push(self.name(&part)),
                Rule::string => {
                    let reason = self.string(&part);
                    return Ok(ast::Known { checks, reason });
                }
                _ => {}
            }
        }
        Err(Failure::Unexpected)
    }

    pub(super) fn optional_family(&self, parts: &mut Children<'t>) -> Build<Option<Name>> {
        let Some(reference) = parts.accept(Rule::family_ref) else {
            return Ok(None);
        };
        Ok(Some(
            self.name(&Children::of(reference).skip_to(Rule::ident)?),
        ))
    }

    pub(super) fn optional_annotation(
        &self,
        parts: &mut Children<'t>,
    ) -> Build<Option<ast::Annotation>> {
        parts
            .accept(Rule::annotation)
            .map(|pair| self.annotation(pair))
            .transpose()
    }

    pub(super) fn annotation(&self, pair: Pair<'t, Rule>) -> Build<ast::Annotation> {
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

    pub(super) fn kind(&self, pair: Pair<'t, Rule>) -> Build<ast::Kind> {
        let part = Children::of(pair).any()?;
        match part.as_rule() {
            Rule::ident | Rule::energy_kind => Ok(ast::Kind::Named(self.name(&part))),
            _ => Ok(ast::Kind::Unit(self.unit(part)?)),
        }
    }

    pub(super) fn bound(&self, pair: Pair<'t, Rule>) -> Build<ast::Bound> {
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
}

fn shape(word: &str) -> Shape {
    match word {
        "vector" => Shape::Vector,
        "symmetric" => Shape::Symmetric,
        "tensor" => Shape::Tensor,
        _ => Shape::Scalar,
    }
}
