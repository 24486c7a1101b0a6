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
    ParamId, Shape, WeightId,
};
use crate::resolve::facts::{Facts, NODE};
use crate::resolve::library::Library;
use crate::resolve::lookup::Scope;
use crate::resolve::under::Copies;
use crate::span::Span;
use crate::units::{self, Unit};
use std::collections::{HashMap, HashSet};

/// The height of an expression, that with all its definitions, and the expressions of one law: bounds that only a law
/// written to exhaust the compiler reaches.
const MAX_HEIGHT: usize = 240;
const MAX_DEPTH: u32 = 400;
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
    Weight(WeightId),
    /// Its definition is wrong and reported, or not reached yet.
    Broken,
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
    /// Names of the fields that have a rate.
    pub(super) rated: HashSet<String>,
    /// Initial value, home, shape and unit; the update is filled in last.
    pub histories: Vec<ir::History>,
    pub weights: Vec<ir::Weight>,
    pub defs: Vec<ir::Def>,
    pub exprs: Vec<ir::Expr>,
    facts: Vec<Facts>,
    /// Copies of definitions for `under`.
    pub(super) copies: Copies,
    pub(super) shared: HashMap<(String, bool), Option<DefId>>,
    pub(super) scopes: Vec<Scope>,
    /// Functions in which something was found.
    pub(super) faulty: HashSet<String>,
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
            rated: HashSet::new(),
            histories: Vec::new(),
            weights: Vec::new(),
            defs: Vec::new(),
            exprs: Vec::new(),
            facts: Vec::new(),
            copies: Copies::new(),
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

    /// Makes the constants of the library visible, as the numbers that they are.
    pub(crate) fn add_constants(&mut self) {
        for (name, value, unit) in &self.library.constants {
            let value = self.push(
                ExprKind::Number(*value),
                Shape::Scalar,
                Home::Constant,
                unit.clone(),
                Span::default(),
            );
            self.scopes[0].locals.push((name.clone(), value));
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
            ExprKind::Weight(weight) => Some(self.facts(self.weights[weight.index()].expr)),
            _ => None,
        };
        let mut facts = Facts::new(&kind, definition, |id| self.facts(id));
        if let ExprKind::Field(f) = &kind
            && self.rated.contains(&self.fields[f.index()].name)
        {
            facts.beyond[NODE] = Some("this is a field with a rate, which evolves");
        }
        facts.any_unit &= unit.is_number();
        if facts.height as usize > MAX_HEIGHT {
            return self.wrong(check::size::too_deep(span));
        }
        if facts.size > MAX_STEPS {
            return self.wrong(check::size::too_large(span));
        }
        if facts.depth > MAX_DEPTH {
            return self.wrong(check::size::leans_too_far(span, MAX_DEPTH));
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
        self.step(written.span)?;
        self.height += 1;
        let result = self.dispatch(written);
        self.height -= 1;
        result
    }

    /// Counts an expression; `None` beyond what a law may have.
    pub(super) fn step(&mut self, span: Span) -> Option<()> {
        self.steps += 1;
        match self.steps {
            // Said once; from here on every expression is given up.
            MAX_STEPS => self.wrong(check::size::too_large(span)),
            steps => (steps < MAX_STEPS).then_some(()),
        }
    }

    pub(super) fn dispatch(&mut self, written: &ast::Expr) -> Option<ExprId> {
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
                let before = self.report.len();
                let (a, b) = self.both(left, right);
                if b.is_none() {
                    self.unit_continued(*op, left, right, before);
                }
                self.binary(*op, a?, b?, span)
            }
            ast::ExprKind::Compare(op, left, right) => {
                let (left, right) = self.both(left, right);
                self.comparison(*op, left?, right?, span)
            }
            ast::ExprKind::Vector(parts) => self.vector(parts, span),
            ast::ExprKind::Component(inner, axes) => self
                .elaborate(inner)
                .and_then(|inner| self.component(inner, axes, span)),
            ast::ExprKind::Prime(inner) => self
                .elaborate(inner)
                .and_then(|inner| self.prime(inner, span)),
            ast::ExprKind::Case(arms) => self.case(arms, span),
        }
    }

    /// `m^2/s` behind a number: what is said of the `s`, which is no value, says that it is read as one.
    fn unit_continued(
        &mut self,
        op: ir::BinaryOp,
        left: &ast::Expr,
        right: &ast::Expr,
        before: usize,
    ) {
        let joins = matches!(op, ir::BinaryOp::Mul | ir::BinaryOp::Div);
        let Some(name) = first_name(right).filter(|_| joins && ends_in_unit(left)) else {
            return;
        };
        let (name, place) = name;
        let said = &mut self.report[before..];
        let said = said.iter_mut().find(|finding| finding.span() == place);
        if let Some(finding) = said.filter(|_| units::known_units().any(|unit| unit == name)) {
            *finding = check::names::unit_without_brackets(finding.clone());
        }
    }

    pub(super) fn both(
        &mut self,
        left: &ast::Expr,
        right: &ast::Expr,
    ) -> (Option<ExprId>, Option<ExprId>) {
        (self.elaborate(left), self.elaborate(right))
    }

    pub(super) fn number(
        &mut self,
        value: f64,
        unit: Option<&ast::UnitExpr>,
        span: Span,
    ) -> Option<ExprId> {
        let (factor, unit) = match unit {
            None => (1.0, Unit::NUMBER),
            Some(unit) => units::evaluate(unit, self.report)?,
        };
        self.push(
            ExprKind::Number(units::scale(value, factor)),
            Shape::Scalar,
            Home::Constant,
            unit,
            span,
        )
    }

    // ---- vectors and cases

    pub(super) fn vector(&mut self, parts: &[ast::Expr], span: Span) -> Option<ExprId> {
        let values: Vec<Option<ExprId>> = parts.iter().map(|part| self.elaborate(part)).collect();
        if self.context != Context::Law {
            return self.wrong(check::components::outside_of_law(span));
        }
        if parts.len() > 3 {
            return self.wrong(check::components::too_many(span, parts.len()));
        }
        let values = values.into_iter().collect::<Option<_>>()?;
        self.components(values, span)
    }

    pub(super) fn case(&mut self, arms: &[(ast::Name, ast::Expr)], span: Span) -> Option<ExprId> {
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

/// The name of a factor: `s`, `m` in `m^3`.
fn first_name(factor: &ast::Expr) -> Option<(&str, Span)> {
    match &factor.kind {
        ast::ExprKind::Name(name) => Some((name, factor.span)),
        ast::ExprKind::Binary(ir::BinaryOp::Pow, base, _) => first_name(base),
        _ => None,
    }
}

/// Whether factors start with a number with a unit, behind which nothing but names stands.
fn ends_in_unit(factors: &ast::Expr) -> bool {
    match &factors.kind {
        ast::ExprKind::Number(_, unit) => unit.is_some(),
        ast::ExprKind::Binary(ir::BinaryOp::Mul | ir::BinaryOp::Div, left, right) => {
            first_name(right).is_some() && ends_in_unit(left)
        }
        _ => false,
    }
}
