//! Probes: what is set, the nodes, and what is expected of them.

use super::{Build, Children, Failure, Reader, Rule};
use crate::ast::{self, Components, Expectation, Name, ProbeLine, Setting};
use pest::iterators::Pair;

impl<'t> Reader<'t> {
    pub(super) fn probe(&self, pair: Pair<'t, Rule>) -> Build<ast::Probe> {
        let mut parts = Children::of(pair);
        let name = self.name(&parts.skip_to(Rule::ident)?);
        let flavour = parts.skip_to(Rule::flavour)?;
        let flavour = Name {
            text: flavour.as_str().into(),
            span: self.span(&flavour),
        };
        let (mut settings, mut lines) = (Vec::new(), Vec::new());
        for part in parts {
            match part.as_rule() {
                Rule::setting => settings.push(self.setting(part)?),
                Rule::probe_line => lines.push(self.probe_line(Children::of(part).any()?)?),
                _ => {}
            }
        }
        Ok(ast::Probe {
            name,
            flavour,
            settings,
            lines,
        })
    }

    fn probe_line(&self, pair: Pair<'t, Rule>) -> Build<ProbeLine> {
        let (rule, mut parts) = (pair.as_rule(), Children::of(pair));
        match rule {
            Rule::probe_let => {
                let name = self.name(&parts.skip_to(Rule::ident)?);
                Ok(ProbeLine::Let(name, self.last_expression(parts)?))
            }
            Rule::probe_node => Ok(ProbeLine::Node {
                name: self.name(&parts.skip_to(Rule::ident)?),
                position: self.components(parts.skip_to(Rule::components)?)?,
                settings: self.settings(parts)?,
            }),
            Rule::probe_lattice => Ok(ProbeLine::Lattice {
                span: self.span(&parts.expect(Rule::kw_lattice)?),
                spacing: self.expression(parts.skip_to(Rule::expression)?)?,
                settings: self.settings(parts)?,
            }),
            Rule::probe_cut => Ok(ProbeLine::Cut(
                self.name(&parts.skip_to(Rule::ident)?),
                self.name(&parts.skip_to(Rule::ident)?),
            )),
            Rule::expectation => self.expectation(parts).map(ProbeLine::Expect),
            _ => Err(Failure::Unexpected),
        }
    }

    fn expectation(&self, mut parts: Children<'t>) -> Build<Expectation> {
        parts.expect(Rule::kw_expect)?;
        let rate = parts.accept(Rule::kw_rate).is_some();
        let name = self.name(&parts.expect(Rule::ident)?);
        let place = match parts.accept(Rule::place) {
            None => Vec::new(),
            Some(place) => place
                .into_inner()
                .filter(|part| part.as_rule() == Rule::ident)
                .map(|part| self.name(&part))
                .collect(),
        };
        let value = self.components(parts.skip_to(Rule::components)?)?;
        let within = parts.find(|part| part.as_rule() == Rule::expression);
        Ok(Expectation {
            rate,
            name,
            place,
            value,
            within: within.map(|part| self.expression(part)).transpose()?,
        })
    }

    fn settings(&self, parts: Children<'t>) -> Build<Vec<Setting>> {
        parts
            .filter(|part| part.as_rule() == Rule::setting)
            .map(|part| self.setting(part))
            .collect()
    }

    fn setting(&self, pair: Pair<'t, Rule>) -> Build<Setting> {
        let mut parts = Children::of(pair);
        Ok(Setting {
            name: self.name(&parts.expect(Rule::ident)?),
            value: self.components(parts.skip_to(Rule::components)?)?,
        })
    }

    fn components(&self, pair: Pair<'t, Rule>) -> Build<Components> {
        let span = self.span(&pair);
        let written = Children::of(pair).any()?;
        let rows = match written.as_rule() {
            Rule::rows => written
                .into_inner()
                .filter(|part| part.as_rule() == Rule::row)
                .map(|part| self.row(part))
                .collect::<Build<_>>()?,
            Rule::row => vec![self.row(written)?],
            _ => vec![vec![self.expression(written)?]],
        };
        Ok(Components { rows, span })
    }

    fn row(&self, pair: Pair<'t, Rule>) -> Build<Vec<ast::Expr>> {
        pair.into_inner()
            .filter(|part| part.as_rule() == Rule::expression)
            .map(|part| self.expression(part))
            .collect()
    }
}
