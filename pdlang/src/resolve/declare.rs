//! The names of a model: every item is declared before any expression is read, so that order is free.

use crate::ast::{self, Item, Name, ResponseKind};
use crate::check;
use crate::ir::{self, ExprId, FamilyId, FieldId, HistoryId, Home, InfluenceId, ParamId, Shape};
use crate::resolve::elaborate::{Elaborator, Symbol};
use crate::resolve::{influence, meets, params};
use crate::span::Span;
use crate::units::{self, Unit};
use std::collections::HashMap;

impl Elaborator<'_> {
    pub(crate) fn declare(&mut self, model: &ast::Model) {
        self.families.push(ir::Family {
            name: "horizon".into(),
            filter: None,
        });
        for name in &model.broken {
            self.symbols.insert(name.text.clone(), Symbol::Broken);
        }
        let rated = |item: &Item| match item {
            Item::Response(r) if r.kind == ResponseKind::Rate => Some(r.name.text.clone()),
            _ => None,
        };
        self.rated = model.items.iter().filter_map(rated).collect();
        let mut seen = HashMap::new();
        for item in &model.items {
            let Some(name) = declared(item) else { continue };
            if !self.is_free(item, name, &mut seen) {
                continue;
            }
            let symbol = match item {
                Item::Influence(slot) => self.declare_influence(slot),
                Item::Param(param) => self.declare_param(param),
                Item::Field(field) => self.declare_field(field),
                Item::History(history) => self.declare_history(history),
                Item::Family(family) => self.declare_family(family),
                _ => None,
            };
            self.symbols
                .insert(name.text.clone(), symbol.unwrap_or(Symbol::Broken));
        }
    }

    /// Whether an item may have its name.
    fn is_free(&mut self, item: &Item, name: &Name, seen: &mut HashMap<String, Span>) -> bool {
        let free = check::reserved::allowed(name, self.report)
            && (!matches!(item, Item::Family(_))
                || check::reserved::allowed_family(name, self.report))
            && check::duplicates::first(seen, name, self.report);
        if free && self.library.prelude.definitions.contains_key(&name.text) {
            self.report
                .push(check::shadowing::warning(name, "definition"));
        }
        free
    }

    fn declare_influence(&mut self, slot: &ast::InfluenceSlot) -> Option<Symbol> {
        // A wrong default leaves the slot usable: its unit is opaque whatever the function is.
        let default = slot
            .default
            .as_ref()
            .and_then(|written| influence::choice(written, self.library, self.report));
        self.influences.push(ir::Influence {
            name: slot.name.text.clone(),
            default,
            span: slot.name.span,
        });
        Some(Symbol::Influence(InfluenceId(
            self.influences.len() as u32 - 1,
        )))
    }

    fn declare_param(&mut self, written: &ast::Param) -> Option<Symbol> {
        if written.doc.is_none() {
            self.report
                .push(check::descriptions::missing("param", &written.name));
        }
        let mut param = params::param(written, self.report)?;
        if let Some(meet) = &written.meet {
            param.meet = meets::meet(meet, &param.unit, self.library, self.report)?;
        }
        self.params.push(param);
        Some(Symbol::Param(ParamId(self.params.len() as u32 - 1)))
    }

    fn declare_field(&mut self, written: &ast::Field) -> Option<Symbol> {
        if written.doc.is_none() {
            self.report
                .push(check::descriptions::missing("field", &written.name));
        }
        let (shape, unit) = self.annotated(&written.annotation)?;
        let doc = written
            .doc
            .as_ref()
            .map(|doc| doc.text.clone())
            .unwrap_or_default();
        self.fields.push(ir::Field {
            name: written.name.text.clone(),
            doc,
            unit,
            shape,
            half: written.half,
            lives: None,
            span: written.name.span,
        });
        Some(Symbol::Field(FieldId(self.fields.len() as u32 - 1)))
    }

    fn declare_history(&mut self, written: &ast::History) -> Option<Symbol> {
        if written.doc.is_none() {
            self.report
                .push(check::descriptions::missing("history", &written.name));
        }
        let (shape, unit) = self.annotated(&written.annotation)?;
        let what = format!("the first value of `{}`", written.name.text);
        let initial = match &written.initial {
            None => 0.0,
            Some(initial) => params::value(&what, initial, &unit, self.report)?,
        };
        // A family may be declared further down: `histories_with_families` fills it in.
        let (name, span) = (written.name.text.clone(), written.name.span);
        self.histories.push(ir::History {
            name,
            home: written.home,
            shape,
            unit,
            initial,
            update: ExprId(0),
            family: FamilyId(0),
            span,
        });
        Some(Symbol::History(HistoryId(self.histories.len() as u32 - 1)))
    }

    fn declare_family(&mut self, written: &ast::Family) -> Option<Symbol> {
        if written.base.text != "horizon" {
            self.report.push(check::families::base(&written.base));
            return None;
        }
        self.families.push(ir::Family {
            name: written.name.text.clone(),
            filter: None,
        });
        Some(Symbol::Family(FamilyId(self.families.len() as u32 - 1)))
    }

    /// Declared shape and unit; what is left out is a scalar, a number.
    fn annotated(&mut self, annotation: &ast::Annotation) -> Option<(Shape, Unit)> {
        let unit = match &annotation.kind {
            None => Unit::NUMBER,
            Some(kind) => units::of_kind(kind, self.report)?,
        };
        Some((annotation.shape.unwrap_or(Shape::Scalar), unit))
    }
}

/// The name that an item declares. A response only has a label.
pub(crate) fn declared(item: &Item) -> Option<&Name> {
    match item {
        Item::Influence(slot) => Some(&slot.name),
        Item::Param(param) => Some(&param.name),
        Item::Definition(definition) => Some(&definition.name),
        Item::Field(field) => Some(&field.name),
        Item::History(history) => Some(&history.name),
        Item::Family(family) => Some(&family.name),
        Item::Weight(weight) => Some(&weight.name),
        Item::Response(_)
        | Item::Update(_)
        | Item::Break(_)
        | Item::AfterStep(_)
        | Item::Known(_)
        | Item::Probe(_) => None,
    }
}

/// What an item is called in findings.
pub(crate) fn item_word(item: &Item) -> &'static str {
    match item {
        Item::Influence(_) => "influence function",
        Item::Param(_) => "parameter",
        Item::Definition(ast::Definition {
            home: Home::Constant,
            ..
        }) => "constant",
        Item::Definition(ast::Definition {
            home: Home::Node, ..
        }) => "node value",
        Item::Definition(_) => "bond value",
        Item::Field(_) => "field",
        Item::History(_) => "history",
        Item::Family(_) => "family",
        Item::Weight(_) => "weight",
        Item::Response(_)
        | Item::Update(_)
        | Item::Break(_)
        | Item::AfterStep(_)
        | Item::Known(_)
        | Item::Probe(_) => "response",
    }
}
