//! Calls: sums, integrals, built-in functions, and functions of the library, which are inlined.

use crate::ast;
use crate::check;
use crate::ir::{ExprId, FamilyId, Reduction};
use crate::resolve::elaborate::{Elaborator, Symbol};
use crate::resolve::lookup::Scope;
use crate::resolve::names;
use crate::span::Span;

impl Elaborator<'_> {
    pub(super) fn call(
        &mut self,
        name: &ast::Name,
        family: Option<&ast::Name>,
        args: &[ast::Argument],
        span: Span,
    ) -> Option<ExprId> {
        let reduction = names::reduction(&name.text, args.len());
        if let Some(family) = family.filter(|_| reduction.is_none()) {
            return self.wrong(check::arity::no_family(name, family.span));
        }
        let named = args.iter().find_map(|arg| arg.name.as_ref());
        if let Some(named) = named {
            return self.wrong(check::arity::by_position(name, named));
        }
        let values: Vec<Option<ExprId>> =
            args.iter().map(|arg| self.elaborate(&arg.value)).collect();
        if let Some(reduction) = reduction {
            return self.reduction(reduction, name, family, values, span);
        }
        match name.text.as_str() {
            "ball" => {
                let values = self.exactly(1, name, values)?;
                self.ball(values[0], span)
            }
            "under" => {
                let values = self.exactly(2, name, values)?;
                self.under(values[0], values[1], span)
            }
            "other" => self.exactly(1, name, values).and(None),
            _ => match names::BUILTINS
                .iter()
                .find(|builtin| builtin.0 == name.text)
            {
                Some((_, builtin, arity, _)) => {
                    let values = self.exactly(*arity, name, values)?;
                    self.builtin(*builtin, name, values, span)
                }
                None => self.inline(name, values, span),
            },
        }
    }

    /// The arguments, if there are as many as there should be and none is wrong.
    pub(super) fn exactly(
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

    pub(super) fn reduction(
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
    pub(super) fn inline(
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
            let params = &function.params;
            return self.wrong(check::arity::of_function(name, values.len(), params));
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
        let prelude = self.library.is_prelude_function(&name.text, prelude);
        let scope = Scope {
            name: format!("{}()", name.text),
            locals,
            model: false,
            prelude,
            call: Some(span),
        };
        let before = self.exprs.len();
        let value = self.inside(scope, name.span, |law| law.elaborate(&function.body))?;
        // What is said of the value is said of the call; an argument that came through stands where it was written.
        if value.index() >= before {
            self.exprs[value.index()].span = span;
        }
        Some(value)
    }

    pub(super) fn unknown_function(&mut self, name: &ast::Name) -> Option<ExprId> {
        let mut candidates: Vec<String> =
            names::FORMS.iter().map(|form| form.0.to_string()).collect();
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
}
