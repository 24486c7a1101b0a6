//! `under(H, q)`: a value for the uniform displacement gradient H.
//!
//! Contract. The result is `q` elaborated again with `H*xi` in the place of `eta`, through every sum and every
//! definition that it reads, so that nothing behind this file knows of `under`. What does not change with the
//! displacement is shared with the law; of each definition that does there is one copy per gradient.

use crate::check;
use crate::ir::{self, BinaryOp, DefId, ExprId, ExprKind, Home, Shape};
use crate::resolve::elaborate::{Context, Elaborator};
use crate::resolve::walk::{operands, with_operands};
use crate::span::Span;
use crate::units::Unit;
use std::collections::{BTreeSet, HashMap};

/// A gradient by its formula, and the copy of a definition that was made for it.
pub(crate) type Copies = HashMap<(u64, DefId), DefId>;

impl Elaborator<'_> {
    pub(super) fn under(&mut self, gradient: ExprId, value: ExprId, span: Span) -> Option<ExprId> {
        if self.context != Context::Law {
            return self.wrong(check::under::outside_of_law(span));
        }
        let written = self.expr(gradient);
        if !matches!(written.shape, Shape::Tensor | Shape::Symmetric) {
            return self.wrong(check::under::no_tensor(written));
        }
        if !written.unit.is_number() {
            let unit = self.describe(&written.unit);
            return self.wrong(check::under::unit(self.expr(gradient), &unit));
        }
        if written.home != Home::Constant {
            return self.wrong(check::under::not_uniform(written));
        }
        if self.facts(value).reads_state {
            let (name, through) = self.state_read(value);
            let place = self.expr(value).span;
            return self.wrong(check::under::undetermined(place, &name, through.as_deref()));
        }
        for def in self.moving(value) {
            self.copy_definition(def, gradient)?;
        }
        self.copy(value, gradient)
    }

    /// The definitions that a value reads and that change with the displacement, each after those it reads.
    fn moving(&self, value: ExprId) -> BTreeSet<DefId> {
        let (mut queue, mut found) = (vec![value], BTreeSet::new());
        while let Some(id) = queue.pop() {
            if !self.facts(id).moves {
                continue;
            }
            match self.expr(id).kind {
                ExprKind::Def(def) => {
                    if found.insert(def) {
                        queue.push(self.defs[def.index()].expr);
                    }
                }
                ref kind => queue.extend(operands(kind)),
            }
        }
        found
    }

    fn copy_definition(&mut self, def: DefId, gradient: ExprId) -> Option<()> {
        let key = (self.facts(gradient).structure, def);
        if self.copies.contains_key(&key) {
            return Some(());
        }
        let expr = self.copy(self.defs[def.index()].expr, gradient)?;
        let written = &self.defs[def.index()];
        // No output of the law, and by a name that no text can write.
        let copy = ir::Def {
            name: format!("{} under {}", written.name, self.copies.len() + 1),
            span: Span {
                prelude: true,
                ..written.span
            },
            expr,
            ..written.clone()
        };
        self.defs.push(copy);
        let id = DefId(self.defs.len() as u32 - 1);
        self.copies.insert(key, id);
        Some(())
    }

    fn copy(&mut self, id: ExprId, gradient: ExprId) -> Option<ExprId> {
        if !self.facts(id).moves {
            return Some(id);
        }
        let expr = self.expr(id).clone();
        self.step(expr.span)?;
        let kind = match &expr.kind {
            ExprKind::Eta => {
                let xi = self.push(
                    ExprKind::Xi,
                    Shape::Vector,
                    Home::Bond,
                    Unit::length(),
                    expr.span,
                )?;
                ExprKind::Binary(BinaryOp::Mul, gradient, xi)
            }
            ExprKind::Def(def) => {
                ExprKind::Def(self.copies[&(self.facts(gradient).structure, *def)])
            }
            kind => {
                let parts = operands(kind).into_iter();
                let parts: Vec<ExprId> = parts
                    .map(|part| self.copy(part, gradient))
                    .collect::<Option<_>>()?;
                with_operands(kind, &parts)
            }
        };
        self.push(kind, expr.shape, expr.home, expr.unit, expr.span)
    }

    /// What a gradient does not determine, and the definition through which it is read.
    fn state_read(&self, mut id: ExprId) -> (String, Option<String>) {
        let mut through = None;
        loop {
            let kind = &self.expr(id).kind;
            let name = match kind {
                ExprKind::Velocity => "velocity".into(),
                ExprKind::TimeStep => "dt".into(),
                ExprKind::Field(field) => self.fields[field.index()].name.clone(),
                ExprKind::History(history) => self.histories[history.index()].name.clone(),
                ExprKind::Def(def) => {
                    let def = &self.defs[def.index()];
                    through.get_or_insert_with(|| def.name.clone());
                    id = def.expr;
                    continue;
                }
                _ => {
                    let mut parts = operands(kind).into_iter();
                    match parts.find(|part| self.facts(*part).reads_state) {
                        Some(part) => id = part,
                        None => return (String::new(), through),
                    }
                    continue;
                }
            };
            return (name, through);
        }
    }
}
