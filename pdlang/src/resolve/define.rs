//! Definitions, responses, breaks, updates and families: whole expressions, and what each must be.

use crate::ast::{self, Name, ResponseKind};
use crate::check;
use crate::ir::{self, DefId, ExprId, ExprKind, FamilyId, Home, Response, Shape, WeightId};
use crate::resolve::elaborate::{Elaborator, Symbol};
use crate::resolve::facts::{BOND, NODE, REFERENCE};
use crate::resolve::walk::operands;
use crate::span::Span;
use crate::units::{self, Unit};

impl Elaborator<'_> {
    /// A `let`, `node` or `bond`, as the next definition of the law.
    pub(crate) fn define(&mut self, written: &ast::Definition) -> Option<DefId> {
        let expr = self.elaborate(&written.expr)?;
        let fits = self.lives_at(home_word(written.home), &written.name, written.home, expr);
        self.matches(written.annotation.as_ref(), expr)?;
        fits?;
        let (shape, unit) = (self.expr(expr).shape, self.expr(expr).unit.clone());
        self.defs.push(ir::Def {
            name: written.name.text.clone(),
            home: written.home,
            shape,
            unit,
            expr,
            span: written.name.span,
        });
        Some(DefId(self.defs.len() as u32 - 1))
    }

    /// Whether a value lives at `home` or nearer to the constants.
    fn lives_at(&mut self, what: &str, name: &Name, home: Home, id: ExprId) -> Option<()> {
        if self.expr(id).home <= home {
            return Some(());
        }
        let far = self.expr(id).home;
        let blamed = self.blamed(id, |law, part| law.expr(part).home == far);
        self.wrong(check::homes::too_far(
            what,
            name,
            home,
            self.expr(id),
            blamed,
        ))
    }

    /// Whether a value is what its annotation says.
    fn matches(&mut self, annotation: Option<&ast::Annotation>, id: ExprId) -> Option<()> {
        let Some(annotation) = annotation else {
            return Some(());
        };
        if let Some(declared) = annotation
            .shape
            .filter(|declared| !check::annotations::admits(*declared, self.expr(id).shape))
        {
            return self.wrong(check::annotations::wrong_shape(
                annotation,
                declared,
                self.expr(id),
            ));
        }
        let Some(kind) = &annotation.kind else {
            return Some(());
        };
        let declared = units::of_kind(kind, self.report)?;
        if declared == self.expr(id).unit || self.facts(id).any_unit {
            return Some(());
        }
        let (declared, found) = (self.describe(&declared), self.describe(&self.expr(id).unit));
        self.wrong(check::annotations::wrong_unit(
            annotation,
            &declared,
            self.expr(id),
            &found,
        ))
    }

    // ---- responses

    pub(crate) fn respond(&mut self, written: &ast::Response) -> Option<Response> {
        let family = self.response_family(written);
        let expr = self.elaborate(&written.expr)?;
        let response = match written.kind {
            ResponseKind::Energy => self.energy(written, expr),
            ResponseKind::Pair => self
                .bond_force("a pair force", written, expr)
                .and_then(|()| Some(Response::Pair(family?, expr))),
            ResponseKind::State => self
                .state(written, expr)
                .and_then(|()| Some(Response::State(family?, expr))),
            ResponseKind::Force => self.node_force(written, expr),
            ResponseKind::Rate => self.rate(written, expr),
        }?;
        self.matches(written.annotation.as_ref(), expr)?;
        Some(response)
    }

    fn response_family(&mut self, written: &ast::Response) -> Option<FamilyId> {
        match (&written.family, written.kind) {
            (Some(family), ResponseKind::Energy) => {
                self.wrong(check::responses::no_family("an energy", family))
            }
            (Some(family), ResponseKind::Force) => {
                self.wrong(check::responses::no_family("the force of a node", family))
            }
            (Some(family), ResponseKind::Rate) => {
                self.wrong(check::responses::no_family("a rate", family))
            }
            (family, _) => self.family(family.as_ref()),
        }
    }

    fn energy(&mut self, written: &ast::Response, expr: ExprId) -> Option<Response> {
        self.scalar(expr, "an energy")?;
        self.lives_at("energy", &written.name, Home::Node, expr)?;
        if self.facts(expr).second_ring[0] {
            let place = self.second_ring(expr);
            return self.wrong(check::rings::second(&written.name, place));
        }
        if self.facts(expr).extreme {
            let place = self.blamed(expr, |law, part| law.facts(part).extreme);
            return self.wrong(check::rings::extreme(&written.name, place));
        }
        self.has_unit("the energy density", expr, &Unit::energy_density())?;
        Some(Response::Energy(expr))
    }

    /// The prime, or the definition with the prime, that reads a moving sum at the other end.
    fn second_ring(&self, mut id: ExprId) -> Span {
        loop {
            let kind = &self.expr(id).kind;
            let inner = operands(kind)
                .into_iter()
                .find(|part| self.facts(*part).second_ring[0]);
            match (kind, inner) {
                (ExprKind::Prime(_) | ExprKind::Def(_), _) | (_, None) => {
                    return self.expr(id).span;
                }
                (_, Some(inner)) => id = inner,
            }
        }
    }

    fn state(&mut self, written: &ast::Response, expr: ExprId) -> Option<()> {
        match self.expr(expr).shape {
            Shape::Vector => self.has_unit("the force state", expr, &Unit::bond_force()),
            _ => self.bond_force("the force state", written, expr),
        }
    }

    fn bond_force(&mut self, what: &str, written: &ast::Response, expr: ExprId) -> Option<()> {
        let what_shape = match written.kind {
            ResponseKind::State => "a force state along the bond",
            _ => "a pair force",
        };
        self.scalar(expr, what_shape)?;
        self.has_unit(what, expr, &Unit::bond_force())
    }

    fn node_force(&mut self, written: &ast::Response, expr: ExprId) -> Option<Response> {
        self.is_like("the force of a node", Shape::Vector, expr)?;
        self.lives_at("force", &written.name, Home::Node, expr)?;
        let unit = Unit::force_density();
        self.has_unit("the force density", expr, &unit)?;
        Some(Response::Force(expr))
    }

    fn rate(&mut self, written: &ast::Response, expr: ExprId) -> Option<Response> {
        let field = match self.symbols.get(&written.name.text) {
            Some(Symbol::Field(field)) => *field,
            Some(Symbol::Broken) => return None,
            _ => {
                let known: Vec<String> =
                    self.fields.iter().map(|field| field.name.clone()).collect();
                return self.wrong(check::names::nothing_to_change(
                    &written.name,
                    "field",
                    &known,
                ));
            }
        };
        let (shape, unit) = (
            self.fields[field.index()].shape,
            self.fields[field.index()].unit.clone(),
        );
        self.is_like("a rate", shape, expr)?;
        self.lives_at("rate", &written.name, Home::Node, expr)?;
        self.has_unit(
            &format!("the rate of `{}`", written.name.text),
            expr,
            &unit.per(&Unit::time()),
        )?;
        Some(Response::Rate(field, expr))
    }

    fn is_like(&mut self, what: &str, shape: Shape, expr: ExprId) -> Option<()> {
        match check::annotations::admits(shape, self.expr(expr).shape) {
            true => Some(()),
            false => self.wrong(check::shapes::not_a(what, shape, self.expr(expr))),
        }
    }

    fn has_unit(&mut self, what: &str, expr: ExprId, expected: &Unit) -> Option<()> {
        let found = self.expr(expr).unit.clone();
        let span = self.expr(expr).span;
        if found == *expected || self.facts(expr).any_unit {
            return Some(());
        }
        let factor = found.per(expected);
        if factor.base == Unit::NUMBER.base {
            let name = |k: &u32| {
                self.influences
                    .get(*k as usize)
                    .map_or("influence", |influence| influence.name.as_str())
            };
            let names: Vec<String> = factor
                .opaque
                .iter()
                .map(|(k, _)| format!("`{}`", name(k)))
                .collect();
            return self.wrong(check::unit_of_response::depends_on_influence(
                what,
                span,
                &names.join(", "),
            ));
        }
        let (found, expected, factor) = (
            self.describe(&found),
            self.describe(expected),
            self.describe(&factor.inverse()),
        );
        self.wrong(check::unit_of_response::wrong(
            what, span, &found, &expected, &factor,
        ))
    }

    /// Whether the whole of a scene's expression is a scalar of this unit.
    pub(crate) fn is_scalar_of(&mut self, expr: ExprId, expected: &Unit) -> bool {
        if self.scalar(expr, "the expression").is_none() {
            return false;
        }
        let (found, span) = (self.expr(expr).unit.clone(), self.expr(expr).span);
        let fits = found == *expected || self.facts(expr).any_unit;
        if !fits {
            let (found, expected) = (self.describe(&found), self.describe(expected));
            self.complain(check::quantities::wrong_unit(
                "the expression",
                span,
                Some(&found),
                &expected,
            ));
        }
        fits
    }

    // ---- breaks, updates, families

    pub(crate) fn breaking(&mut self, written: &ast::Break) -> Option<ir::Break> {
        let family = self.family(written.family.as_ref());
        let when = self.elaborate(&written.when)?;
        self.boolean(when, "break when")?;
        match self.expr(when).home {
            Home::Constant => {
                let mut mentioned = Vec::new();
                crate::resolve::walk::mentioned(&written.when, &mut mentioned);
                let hides = |name: &&String| self.library.prelude.definitions.contains_key(*name);
                let hidden = mentioned.iter().find(hides).map(String::as_str);
                return self.wrong(check::breaks::constant(written.when.span, hidden));
            }
            Home::Node => self.report.push(check::breaks::of_node(written.when.span)),
            Home::Bond => {}
        }
        Some(ir::Break {
            family: family?,
            when,
            after: written.after,
            span: written.span,
        })
    }

    pub(crate) fn update(&mut self, written: &ast::Update) -> Option<()> {
        let id = match self.symbols.get(&written.name.text) {
            Some(Symbol::History(id)) => *id,
            Some(Symbol::Broken) => return None,
            _ => {
                let known: Vec<String> = self
                    .histories
                    .iter()
                    .map(|history| history.name.clone())
                    .collect();
                return self.wrong(check::names::nothing_to_change(
                    &written.name,
                    "history",
                    &known,
                ));
            }
        };
        let expr = self.elaborate(&written.expr)?;
        let history = &self.histories[id.index()];
        let (shape, home, unit) = (history.shape, history.home, history.unit.clone());
        self.is_like("an update", shape, expr)?;
        self.lives_at("update", &written.name, home, expr)?;
        self.has_unit(
            &format!("the update of `{}`", written.name.text),
            expr,
            &unit,
        )?;
        self.histories[id.index()].update = expr;
        Some(())
    }

    /// What replaces the velocity when a step is accepted.
    pub(crate) fn after_step(&mut self, written: &ast::AfterStep) -> Option<ExprId> {
        if written.name.text != "velocity" {
            return self.wrong(check::responses::not_the_velocity(&written.name));
        }
        let expr = self.elaborate(&written.expr)?;
        self.is_like("a velocity", Shape::Vector, expr)?;
        self.lives_at("velocity", &written.name, Home::Node, expr)?;
        self.has_unit("the velocity", expr, &Unit::velocity())?;
        Some(expr)
    }

    /// A weight, as the next one of the law.
    pub(crate) fn weigh(&mut self, written: &ast::Weight) -> Option<WeightId> {
        if written.doc.is_none() {
            self.report
                .push(check::descriptions::missing("weight", &written.name));
        }
        let expr = self.elaborate(&written.expr)?;
        self.scalar(expr, "a weight")?;
        self.pure_number(expr, "a weight")?;
        if let Some((place, why)) = self.beyond(expr, REFERENCE) {
            return self.wrong(check::weights::changes(&written.name, place, why));
        }
        let doc = written.doc.as_ref().map(|doc| doc.text.clone());
        self.weights.push(ir::Weight {
            name: written.name.text.clone(),
            doc: doc.unwrap_or_default(),
            expr,
            span: written.name.span,
        });
        Some(WeightId(self.weights.len() as u32 - 1))
    }

    /// The part of the body that a field lives on.
    pub(crate) fn live(&mut self, written: &ast::Field) -> Option<()> {
        let Some(when) = &written.lives else {
            return Some(());
        };
        let span = when.span;
        let when = self.elaborate(when)?;
        self.boolean(when, "where")?;
        if self.expr(when).home == Home::Bond {
            let place = self.blamed(when, |law, part| law.expr(part).home == Home::Bond);
            let why = "this is a bond value: each bond of the node has its own";
            return self.wrong(check::parts::changes(&written.name, place, why));
        }
        if let Some((place, why)) = self.beyond(when, NODE) {
            return self.wrong(check::parts::changes(&written.name, place, why));
        }
        let text = self
            .library
            .text
            .get(span.start as usize..span.end as usize);
        let words: Vec<&str> = text.unwrap_or_default().split_whitespace().collect();
        if let Some(Symbol::Field(id)) = self.symbols.get(&written.name.text) {
            let text = words.join(" ");
            self.fields[id.index()].lives = Some(ir::Lives { when, text });
        }
        Some(())
    }

    pub(crate) fn filter(&mut self, written: &ast::Family) -> Option<()> {
        let filter = self.elaborate(&written.filter)?;
        self.boolean(filter, "where")?;
        if let Some((place, why)) = self.beyond(filter, BOND) {
            return self.wrong(check::families::changes(&written.name, place, why));
        }
        if let Some(Symbol::Family(id)) = self.symbols.get(&written.name.text) {
            self.families[id.index()].filter = Some(filter);
        }
        Some(())
    }
}

fn home_word(home: Home) -> &'static str {
    match home {
        Home::Constant => "constant",
        Home::Node => "node value",
        Home::Bond => "bond value",
    }
}
