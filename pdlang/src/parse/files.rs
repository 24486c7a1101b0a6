//! Files: models and library definitions.

use super::{Build, Children, Failure, Reader, Rule};
use crate::ast;
use crate::diag::Diagnostic;
use pest::iterators::{Pair, Pairs};

impl<'t> Reader<'t> {
    pub(super) fn file(&self, pairs: Pairs<'t, Rule>, report: &mut Vec<Diagnostic>) -> ast::File {
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
                    file.broken.extend(self.declared(&pair, Rule::top_probe));
                }
                _ => {}
            }
        }
        file
    }

    pub(super) fn top_item(
        &self,
        pair: Pair<'t, Rule>,
        file: &mut ast::File,
        report: &mut Vec<Diagnostic>,
    ) -> Build<()> {
        let item = Children::of(pair).any()?;
        match item.as_rule() {
            Rule::use_file => {
                let path = Children::of(item).skip_to(Rule::string)?;
                file.uses.push(self.string(&path));
            }
            Rule::model => file.models.push(self.model(item, report)?),
            Rule::influence_fn => file.influences.push(self.influence_fn(item)?),
            Rule::function => file.functions.push(self.function(item)?),
            Rule::definition => file.definitions.push(self.definition(item)?),
            _ => return Err(Failure::Unexpected),
        }
        Ok(())
    }

    pub(super) fn model(
        &self,
        pair: Pair<'t, Rule>,
        report: &mut Vec<Diagnostic>,
    ) -> Build<ast::Model> {
        let mut parts = Children::of(pair);
        parts.expect(Rule::kw_model)?;
        let name = self.name(&parts.expect(Rule::ident)?);
        let title = parts.accept(Rule::string).map(|pair| self.string(&pair));
        let mut model = ast::Model {
            name,
            title,
            cites: Vec::new(),
            flavours: Vec::new(),
            items: Vec::new(),
            broken: Vec::new(),
            complete: true,
        };
        for part in parts {
            match part.as_rule() {
                Rule::citation => {
                    let strings = part
                        .into_inner()
                        .filter(|part| part.as_rule() == Rule::string);
                    model.cites.extend(strings.map(|part| self.string(&part)));
                }
                Rule::serves => {
                    let flavours = part
                        .into_inner()
                        .filter(|part| part.as_rule() == Rule::flavour);
                    model.flavours.extend(flavours.map(|part| self.name(&part)));
                }
                Rule::item => match self.item(part) {
                    Ok(item) => model.items.push(item),
                    Err(failure) => {
                        model.complete = false;
                        report.push(self.failure(failure));
                    }
                },
                Rule::item_scrap => {
                    model.complete = false;
                    self.scrap(&part, Rule::item_probe, report);
                    model.broken.extend(self.declared(&part, Rule::item_probe));
                }
                _ => {}
            }
        }
        Ok(model)
    }

    pub(super) fn function(&self, pair: Pair<'t, Rule>) -> Build<ast::Function> {
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

    pub(super) fn influence_fn(&self, pair: Pair<'t, Rule>) -> Build<ast::InfluenceFn> {
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
}
