//! What a name stands for, and from where it is seen.

use crate::check;
use crate::ir::{self, DefId, ExprId, ExprKind, Home, Shape};
use crate::resolve::elaborate::{Context, Elaborator, Symbol};
use crate::resolve::names;
use crate::span::Span;
use crate::units::Unit;

/// Functions inside of functions: a bound that only a law written to exhaust the compiler reaches.
const MAX_CALLS: usize = 40;

/// Where names are looked up: the model, the body of a function, or a library definition.
pub(super) struct Scope {
    pub name: String,
    pub locals: Vec<(String, Option<ExprId>)>,
    /// True where the symbols of the model are visible.
    pub model: bool,
    /// True in text of the prelude, which sees nothing but the prelude.
    pub prelude: bool,
    /// What brought us here, in the text of the user.
    pub call: Option<Span>,
}

impl Elaborator<'_> {
    pub(super) fn name(&mut self, name: &str, span: Span) -> Option<ExprId> {
        let scope = self.scopes.last()?;
        if let Some((_, value)) = scope.locals.iter().find(|(local, _)| local == name) {
            // A value seen through a variable is pointed at where the variable stands.
            return value.and_then(|value| self.seen_from(value, span));
        }
        let (model, prelude) = (scope.model, scope.prelude);
        if let Some(symbol) = self.symbols.get(name).copied().filter(|_| model) {
            return self.symbol(symbol, name, span);
        }
        if !prelude && self.library.own.broken.contains(name) {
            return None;
        }
        if self.context == Context::Law && self.library.definition(name, prelude).is_some() {
            let id = self.shared(name, prelude, span)?;
            return self.definition(id, span);
        }
        self.primitive(name, span)
    }

    /// A leaf again, with another span; what is more than a leaf is shared as it is.
    pub(super) fn seen_from(&mut self, value: ExprId, span: Span) -> Option<ExprId> {
        match self.expr(value) {
            ir::Expr {
                kind: ExprKind::Var(k),
                unit,
                ..
            } => {
                let (kind, unit) = (ExprKind::Var(*k), unit.clone());
                self.push(kind, Shape::Scalar, Home::Constant, unit, span)
            }
            _ => Some(value),
        }
    }

    pub(super) fn symbol(&mut self, symbol: Symbol, name: &str, span: Span) -> Option<ExprId> {
        match symbol {
            Symbol::Param(id) => {
                let unit = self.params[id.index()].unit.clone();
                self.push(
                    ExprKind::Param(id),
                    Shape::Scalar,
                    Home::Constant,
                    unit,
                    span,
                )
            }
            Symbol::Def(id) => self.definition(id, span),
            Symbol::Influence(id) => self.push(
                ExprKind::Influence(id),
                Shape::Scalar,
                Home::Bond,
                Unit::opaque(id.0),
                span,
            ),
            Symbol::Field(id) => {
                let (shape, unit) = (
                    self.fields[id.index()].shape,
                    self.fields[id.index()].unit.clone(),
                );
                self.push(ExprKind::Field(id), shape, Home::Node, unit, span)
            }
            Symbol::History(id) => {
                let history = &self.histories[id.index()];
                let (shape, home, unit) = (history.shape, history.home, history.unit.clone());
                self.push(ExprKind::History(id), shape, home, unit, span)
            }
            Symbol::Weight(id) => self.push(
                ExprKind::Weight(id),
                Shape::Scalar,
                Home::Bond,
                Unit::NUMBER,
                span,
            ),
            Symbol::Family(_) => self.wrong(check::names::family_as_value(name, span)),
            Symbol::Broken => None,
        }
    }

    pub(super) fn definition(&mut self, id: DefId, span: Span) -> Option<ExprId> {
        let def = &self.defs[id.index()];
        let (shape, home, unit) = (def.shape, def.home, def.unit.clone());
        self.push(ExprKind::Def(id), shape, home, unit, span)
    }

    pub(super) fn primitive(&mut self, name: &str, span: Span) -> Option<ExprId> {
        let known = match self.context {
            Context::Law => true,
            Context::Influence => names::PURE.contains(&name) || name == "delta",
            Context::Scene => names::PURE.contains(&name),
        };
        match names::PRIMITIVES
            .iter()
            .find(|primitive| known && primitive.name == name)
        {
            Some(found) => self.push(
                found.kind.clone(),
                found.shape,
                found.home,
                found.unit.clone(),
                span,
            ),
            None => {
                let candidates = self.visible_values();
                let meaning = self.other_meaning(name);
                let in_law = matches!(self.context, Context::Law);
                let habit = check::habits::value(name).filter(|_| in_law);
                self.wrong(check::names::unknown_value(
                    name,
                    span,
                    &candidates,
                    meaning,
                    habit,
                ))
            }
        }
    }

    /// What a name means elsewhere, when it is no value here.
    pub(super) fn other_meaning(&self, name: &str) -> Option<check::names::Meaning> {
        use check::names::Meaning;
        if names::is_function(name) || self.library.function(name, false).is_some() {
            return Some(Meaning::Function);
        }
        let in_laws = names::is_primitive(name) || self.library.definition(name, false).is_some();
        in_laws.then_some(Meaning::ValueOfLaws)
    }

    /// Every value that could have been meant here.
    pub(super) fn visible_values(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        if let Some(scope) = self.scopes.last() {
            names.extend(scope.locals.iter().map(|(name, _)| name.clone()));
            if scope.model {
                names.extend(self.symbols.keys().cloned());
            }
        }
        if self.context == Context::Law {
            names.extend(
                self.library
                    .own
                    .definitions
                    .keys()
                    .chain(self.library.prelude.definitions.keys())
                    .cloned(),
            );
            names.extend(
                names::PRIMITIVES
                    .iter()
                    .map(|primitive| primitive.name.to_string()),
            );
        } else {
            names.extend(names::PURE.map(String::from));
            names.extend((self.context == Context::Influence).then(|| "delta".to_string()));
        }
        names.sort();
        names.dedup();
        names
    }

    /// A library definition as a definition of this law, made at its first use.
    pub(super) fn shared(&mut self, name: &str, from_prelude: bool, span: Span) -> Option<DefId> {
        let written = self.library.definition(name, from_prelude)?;
        let prelude = from_prelude || !self.library.own.definitions.contains_key(name);
        let key = (name.to_string(), prelude);
        if let Some(known) = self.shared.get(&key) {
            return *known;
        }
        let scope = Scope {
            name: name.into(),
            locals: Vec::new(),
            model: false,
            prelude: key.1,
            call: Some(span),
        };
        let id = self.inside(scope, span, |law| law.define(written));
        self.shared.insert(key, id);
        id
    }

    /// Elaborates inside of another scope; a scope inside of itself is a cycle.
    pub(super) fn inside<T>(
        &mut self,
        scope: Scope,
        span: Span,
        body: impl FnOnce(&mut Self) -> Option<T>,
    ) -> Option<T> {
        let open: Vec<&str> = self.scopes[1..]
            .iter()
            .map(|open| open.name.as_str())
            .collect();
        if let Some(first) = open.iter().position(|name| *name == scope.name) {
            let chain: Vec<String> = open[first..].iter().map(|name| name.to_string()).collect();
            return self.wrong(check::cycles::recursion(&chain, span));
        }
        if self.scopes.len() > MAX_CALLS {
            return self.wrong(check::size::too_deep(span));
        }
        let (found, name, prelude) = (self.report.len(), scope.name.clone(), scope.prelude);
        self.scopes.push(scope);
        let result = body(self);
        self.scopes.pop();
        self.say_once(found, name, prelude);
        result
    }

    /// Of what was found in a function of the prelude, one finding is enough for a user; what was found
    /// in a function of the file is found again at its next use.
    pub(super) fn say_once(&mut self, found: usize, name: String, prelude: bool) {
        if self.report.len() == found {
            return;
        }
        let first_time = self.faulty.insert(name);
        let enough = match (prelude, first_time) {
            (true, _) => found + 1,
            (false, true) => self.report.len(),
            (false, false) => found,
        };
        self.report.truncate(enough);
    }
}
