//! Written expression -> typed expression. Names become ids, functions are inlined, and every node
//! gets its shape, home and unit.
//!
//! `None` means: wrong, and reported. Whoever uses such a value is silent, so that one mistake is one
//! finding. Operands are elaborated before any of them is given up, so that all mistakes are found.

use crate::ast;
use crate::check;
use crate::diag::Diagnostic;
use crate::ir::{
    self, DefId, ExprId, ExprKind, FamilyId, FieldId, Flavour, HistoryId, Home, InfluenceId,
    ParamId, Reduction, Shape,
};
use crate::resolve::facts::Facts;
use crate::resolve::library::Library;
use crate::resolve::names;
use crate::span::Span;
use crate::units::{self, Unit};
use std::collections::{HashMap, HashSet};

/// Functions inside functions, the height of an expression, and the expressions of one law: bounds that only a law written to
/// exhaust the compiler reaches.
const MAX_CALLS: usize = 40;
const MAX_HEIGHT: usize = 240;
const MAX_STEPS: usize = 100_000;

/// What a name of a model stands for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Symbol {
    Param(ParamId),
    Def(DefId),
    Influence(InfluenceId),
    Field(FieldId),
    History(HistoryId),
    Family(FamilyId),
    /// Its definition is wrong and reported, or not reached yet.
    Broken,
}

/// Where names are looked up: the model, the body of a function, or a library definition.
struct Scope {
    name: String,
    locals: Vec<(String, Option<ExprId>)>,
    /// True where the symbols of the model are visible.
    model: bool,
    /// True in text of the prelude, which sees nothing but the prelude.
    prelude: bool,
    /// What brought us here, in the text of the user.
    call: Option<Span>,
}

/// What kind of text is elaborated.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Context {
    Law,
    /// A function of the bond length: its units need not work out.
    Influence,
    /// An expression of a scene.
    Scene,
}

/// A law, an influence function or an expression under construction.
pub(crate) struct Elaborator<'a> {
    pub library: &'a Library<'a>,
    pub report: &'a mut Vec<Diagnostic>,
    pub context: Context,
    pub symbols: HashMap<String, Symbol>,
    pub params: Vec<ir::Param>,
    pub influences: Vec<ir::Influence>,
    pub families: Vec<ir::Family>,
    pub fields: Vec<ir::Field>,
    /// Initial value, home, shape and unit; the update is filled in last.
    pub histories: Vec<ir::History>,
    pub defs: Vec<ir::Def>,
    pub exprs: Vec<ir::Expr>,
    facts: Vec<Facts>,
    shared: HashMap<(String, bool), Option<DefId>>,
    scopes: Vec<Scope>,
    /// Functions in which something was found.
    faulty: HashSet<String>,
    height: usize,
    /// Expressions elaborated so far, inlined ones included.
    steps: usize,
}

impl<'a> Elaborator<'a> {
    pub(crate) fn new(
        library: &'a Library<'a>,
        context: Context,
        report: &'a mut Vec<Diagnostic>,
    ) -> Self {
        let scope = Scope {
            name: String::new(),
            locals: Vec::new(),
            model: context == Context::Law,
            prelude: false,
            call: None,
        };
        Elaborator {
            library,
            report,
            context,
            symbols: HashMap::new(),
            params: Vec::new(),
            influences: Vec::new(),
            families: Vec::new(),
            fields: Vec::new(),
            histories: Vec::new(),
            defs: Vec::new(),
            exprs: Vec::new(),
            facts: Vec::new(),
            shared: HashMap::new(),
            scopes: vec![scope],
            faulty: HashSet::new(),
            height: 0,
            steps: 0,
        }
    }

    /// Makes `Var(0)`, `Var(1)`, .. visible under these names.
    pub(crate) fn add_variables<'n>(&mut self, variables: impl Iterator<Item = (&'n str, Unit)>) {
        for (k, (name, unit)) in variables.enumerate() {
            let value = self.push(
                ExprKind::Var(k as u32),
                Shape::Scalar,
                Home::Constant,
                unit,
                Span::default(),
            );
            self.scopes[0].locals.push((name.to_string(), value));
        }
    }

    // ---- what passes and checks ask

    pub(crate) fn expr(&self, id: ExprId) -> &ir::Expr {
        &self.exprs[id.index()]
    }

    pub(crate) fn facts(&self, id: ExprId) -> &Facts {
        &self.facts[id.index()]
    }

    /// A unit in words.
    pub(crate) fn describe(&self, unit: &Unit) -> String {
        let names: Vec<String> = self
            .influences
            .iter()
            .map(|influence| influence.name.clone())
            .collect();
        unit.describe(&names)
    }

    /// Reports a finding. What it says about the inside of the prelude is said about its use; what it
    /// says about the inside of a function of the file, together with its use.
    pub(crate) fn complain(&mut self, finding: Diagnostic) {
        let mut inner = self.scopes.iter().rev();
        let used = inner.find_map(|scope| {
            Some((
                scope.name.as_str(),
                scope.call.filter(|call| !call.prelude)?,
            ))
        });
        let finding = match used {
            Some((name, call)) if finding.labels.iter().any(|(span, _)| span.prelude) => {
                finding.seen_from(name, call)
            }
            Some((name, call)) => finding.at(call, format!("`{name}` is used here")),
            None => finding,
        };
        self.report.push(finding);
    }

    /// `None`, having said why.
    pub(crate) fn wrong<T>(&mut self, finding: Diagnostic) -> Option<T> {
        self.complain(finding);
        None
    }

    pub(crate) fn push(
        &mut self,
        kind: ExprKind,
        shape: Shape,
        home: Home,
        unit: Unit,
        span: Span,
    ) -> Option<ExprId> {
        let definition = match &kind {
            ExprKind::Def(def) => Some(self.facts(self.defs[def.index()].expr)),
            _ => None,
        };
        let mut facts = Facts::new(&kind, definition, |id| self.facts(id));
        facts.any_unit &= unit.is_number();
        if facts.height as usize > MAX_HEIGHT {
            return self.wrong(check::size::too_deep(span));
        }
        self.exprs.push(ir::Expr {
            kind,
            shape,
            home,
            unit,
            span,
        });
        self.facts.push(facts);
        Some(ExprId(self.exprs.len() as u32 - 1))
    }

    /// As `push`, for a value whose unit may be any.
    pub(crate) fn push_any_unit(
        &mut self,
        kind: ExprKind,
        home: Home,
        span: Span,
    ) -> Option<ExprId> {
        let id = self.push(kind, Shape::Scalar, home, Unit::NUMBER, span)?;
        self.facts[id.index()].any_unit = true;
        Some(id)
    }

    // ---- expressions

    pub(crate) fn elaborate(&mut self, written: &ast::Expr) -> Option<ExprId> {
        if self.height >= MAX_HEIGHT {
            return self.wrong(check::size::too_deep(written.span));
        }
        self.steps += 1;
        if self.steps >= MAX_STEPS {
            // Said once; from here on every expression is given up.
            return match self.steps == MAX_STEPS {
                true => self.wrong(check::size::too_large(written.span)),
                false => None,
            };
        }
        self.height += 1;
        let result = self.dispatch(written);
        self.height -= 1;
        result
    }

    fn dispatch(&mut self, written: &ast::Expr) -> Option<ExprId> {
        let span = written.span;
        match &written.kind {
            ast::ExprKind::Number(value, unit) => self.number(*value, unit.as_ref(), span),
            ast::ExprKind::Name(name) => self.name(name, span),
            ast::ExprKind::Call { name, family, args } => {
                self.call(name, family.as_ref(), args, span)
            }
            ast::ExprKind::Neg(inner) => self
                .elaborate(inner)
                .and_then(|inner| self.negative(inner, span)),
            ast::ExprKind::Not(inner) => self
                .elaborate(inner)
                .and_then(|inner| self.negation(inner, span)),
            ast::ExprKind::Binary(op, left, right) => {
                let (left, right) = self.both(left, right);
                self.binary(*op, left?, right?, span)
            }
            ast::ExprKind::Compare(op, left, right) => {
                let (left, right) = self.both(left, right);
                self.comparison(*op, left?, right?, span)
            }
            ast::ExprKind::Component(inner, axes) => self
                .elaborate(inner)
                .and_then(|inner| self.component(inner, axes, span)),
            ast::ExprKind::Prime(inner) => self
                .elaborate(inner)
                .and_then(|inner| self.prime(inner, span)),
            ast::ExprKind::Case(arms) => self.case(arms, span),
        }
    }

    fn both(&mut self, left: &ast::Expr, right: &ast::Expr) -> (Option<ExprId>, Option<ExprId>) {
        (self.elaborate(left), self.elaborate(right))
    }

    fn number(&mut self, value: f64, unit: Option<&ast::UnitExpr>, span: Span) -> Option<ExprId> {
        let (factor, unit) = match unit {
            None => (1.0, Unit::NUMBER),
            Some(unit) => match units::evaluate(unit, self.report) {
                Some(known) => known,
                None => return None,
            },
        };
        self.push(
            ExprKind::Number(units::scale(value, factor)),
            Shape::Scalar,
            Home::Constant,
            unit,
            span,
        )
    }

    // ---- names

    fn name(&mut self, name: &str, span: Span) -> Option<ExprId> {
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
    fn seen_from(&mut self, value: ExprId, span: Span) -> Option<ExprId> {
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

    fn symbol(&mut self, symbol: Symbol, name: &str, span: Span) -> Option<ExprId> {
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
            Symbol::Family(_) => self.wrong(check::names::family_as_value(name, span)),
            Symbol::Broken => None,
        }
    }

    fn definition(&mut self, id: DefId, span: Span) -> Option<ExprId> {
        let def = &self.defs[id.index()];
        let (shape, home, unit) = (def.shape, def.home, def.unit.clone());
        self.push(ExprKind::Def(id), shape, home, unit, span)
    }

    fn primitive(&mut self, name: &str, span: Span) -> Option<ExprId> {
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
                self.wrong(check::names::unknown_value(
                    name,
                    span,
                    &candidates,
                    meaning,
                ))
            }
        }
    }

    /// What a name means elsewhere, when it is no value here.
    fn other_meaning(&self, name: &str) -> Option<check::names::Meaning> {
        use check::names::Meaning;
        if names::is_function(name) || self.library.function(name, false).is_some() {
            return Some(Meaning::Function);
        }
        let in_laws = names::is_primitive(name) || self.library.definition(name, false).is_some();
        in_laws.then_some(Meaning::ValueOfLaws)
    }

    /// Every value that could have been meant here.
    fn visible_values(&self) -> Vec<String> {
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
    fn shared(&mut self, name: &str, from_prelude: bool, span: Span) -> Option<DefId> {
        let written = self.library.definition(name, from_prelude)?;
        let key = (name.to_string(), written.name.span.prelude);
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
    fn inside<T>(
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
    fn say_once(&mut self, found: usize, name: String, prelude: bool) {
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

    // ---- calls

    fn call(
        &mut self,
        name: &ast::Name,
        family: Option<&ast::Name>,
        args: &[ast::Argument],
        span: Span,
    ) -> Option<ExprId> {
        if let Some(family) = family.filter(|_| !matches!(name.text.as_str(), "sum" | "sum0")) {
            return self.wrong(check::arity::no_family(name, family.span));
        }
        let named = args.iter().find_map(|arg| arg.name.as_ref());
        if let Some(named) = named {
            return self.wrong(check::arity::by_position(name, named));
        }
        let values: Vec<Option<ExprId>> =
            args.iter().map(|arg| self.elaborate(&arg.value)).collect();
        match name.text.as_str() {
            "sum" => self.reduction(Reduction::Sum, name, family, values, span),
            "sum0" => self.reduction(Reduction::Sum0, name, family, values, span),
            "ball" => {
                let values = self.exactly(1, name, values)?;
                self.ball(values[0], span)
            }
            "other" => self.exactly(1, name, values).and(None),
            _ => match names::BUILTINS
                .iter()
                .find(|builtin| builtin.0 == name.text)
            {
                Some((_, builtin, arity)) => {
                    let values = self.exactly(*arity, name, values)?;
                    self.builtin(*builtin, name, values, span)
                }
                None => self.inline(name, values, span),
            },
        }
    }

    /// The arguments, if there are as many as there should be and none is wrong.
    fn exactly(
        &mut self,
        arity: usize,
        name: &ast::Name,
        values: Vec<Option<ExprId>>,
    ) -> Option<Vec<ExprId>> {
        if values.len() != arity {
            return self.wrong(check::arity::count(name, values.len(), arity));
        }
        values.into_iter().collect()
    }

    fn reduction(
        &mut self,
        reduction: Reduction,
        name: &ast::Name,
        family: Option<&ast::Name>,
        values: Vec<Option<ExprId>>,
        span: Span,
    ) -> Option<ExprId> {
        let family = self.family(family);
        let values = self.exactly(1, name, values)?;
        self.reduce(reduction, name, family?, values[0], span)
    }

    /// The family of that name; without a name, the horizon.
    pub(crate) fn family(&mut self, name: Option<&ast::Name>) -> Option<FamilyId> {
        let Some(name) = name else {
            return Some(FamilyId(0));
        };
        match self.symbols.get(&name.text) {
            Some(Symbol::Family(id)) => Some(*id),
            Some(Symbol::Broken) => None,
            _ => {
                let known: Vec<String> = self
                    .families
                    .iter()
                    .map(|family| family.name.clone())
                    .collect();
                self.wrong(check::names::unknown_family(name, &known))
            }
        }
    }

    /// The body of a function with the arguments put in. The body sees its parameters and the library,
    /// never the model, so that nothing is captured.
    fn inline(
        &mut self,
        name: &ast::Name,
        values: Vec<Option<ExprId>>,
        span: Span,
    ) -> Option<ExprId> {
        let prelude = self.scopes.last()?.prelude;
        if !prelude && self.library.own.broken.contains(&name.text) {
            return None;
        }
        let Some(function) = self.library.function(&name.text, prelude) else {
            return self.unknown_function(name);
        };
        if values.len() != function.params.len() {
            return self.wrong(check::arity::count(
                name,
                values.len(),
                function.params.len(),
            ));
        }
        if values.contains(&None) {
            return None;
        }
        let locals = function
            .params
            .iter()
            .map(|param| param.text.clone())
            .zip(values)
            .collect();
        let prelude = function.name.span.prelude;
        let scope = Scope {
            name: format!("{}()", name.text),
            locals,
            model: false,
            prelude,
            call: Some(span),
        };
        self.inside(scope, name.span, |law| law.elaborate(&function.body))
    }

    fn unknown_function(&mut self, name: &ast::Name) -> Option<ExprId> {
        let mut candidates: Vec<String> =
            names::FORMS.iter().map(|form| form.to_string()).collect();
        candidates.extend(names::BUILTINS.iter().map(|builtin| builtin.0.to_string()));
        candidates.extend(
            self.library
                .own
                .functions
                .keys()
                .chain(self.library.prelude.functions.keys())
                .cloned(),
        );
        candidates.sort();
        let is_value = self.visible_values().contains(&name.text);
        let is_influence = self.library.influence(&name.text).is_some();
        self.wrong(check::names::unknown_function(
            name,
            &candidates,
            is_value,
            is_influence,
        ))
    }

    // ---- case

    fn case(&mut self, arms: &[(ast::Name, ast::Expr)], span: Span) -> Option<ExprId> {
        let complete = check::flavours::complete(arms, span);
        let values: Vec<Option<ExprId>> = arms.iter().map(|(_, arm)| self.elaborate(arm)).collect();
        if !complete.is_empty() {
            complete
                .into_iter()
                .for_each(|finding| self.complain(finding));
            return None;
        }
        let arm = |flavour: Flavour| {
            arms.iter()
                .position(|(name, _)| name.text == flavour.name())
                .and_then(|k| values[k])
        };
        let mut ids = [ExprId(0); 5];
        for (id, flavour) in ids.iter_mut().zip(Flavour::ALL) {
            *id = arm(flavour)?;
        }
        self.alternatives(ids, span)
    }
}
