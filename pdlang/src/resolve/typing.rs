//! The rules of the language for one operation: which shapes, homes and units may meet, and what results.

use crate::ast;
use crate::check;
use crate::ir::{BinaryOp, Builtin, CompareOp, ExprId, ExprKind, FamilyId, Home, Reduction, Shape};
use crate::resolve::elaborate::{Context, Elaborator};
use crate::resolve::facts::{BOND, LENGTH};
use crate::resolve::walk::operands;
use crate::span::Span;
use crate::units::Unit;

impl Elaborator<'_> {
    fn shape(&self, id: ExprId) -> Shape {
        self.expr(id).shape
    }

    fn unit(&self, id: ExprId) -> Unit {
        self.expr(id).unit.clone()
    }

    fn home_of(&self, ids: &[ExprId]) -> Home {
        ids.iter()
            .map(|id| self.expr(*id).home)
            .max()
            .unwrap_or(Home::Constant)
    }

    // ---- operators

    pub(crate) fn negative(&mut self, inner: ExprId, span: Span) -> Option<ExprId> {
        self.numeric(inner, "-")?;
        let (shape, home, unit) = (self.shape(inner), self.home_of(&[inner]), self.unit(inner));
        self.push(ExprKind::Neg(inner), shape, home, unit, span)
    }

    pub(crate) fn negation(&mut self, inner: ExprId, span: Span) -> Option<ExprId> {
        self.boolean(inner, "not")?;
        let home = self.home_of(&[inner]);
        self.push(
            ExprKind::Not(inner),
            Shape::Boolean,
            home,
            Unit::NUMBER,
            span,
        )
    }

    pub(crate) fn binary(
        &mut self,
        op: BinaryOp,
        left: ExprId,
        right: ExprId,
        span: Span,
    ) -> Option<ExprId> {
        let (shape, unit) = match op {
            BinaryOp::Add => self.sum_of(left, right, "+"),
            BinaryOp::Sub => self.sum_of(left, right, "-"),
            BinaryOp::Mul => self.product_of(left, right),
            BinaryOp::Div => self.quotient_of(left, right),
            BinaryOp::Pow => return self.power(left, right, span),
            BinaryOp::And => self.both_true(left, right, "and"),
            BinaryOp::Or => self.both_true(left, right, "or"),
        }?;
        let home = self.home_of(&[left, right]);
        let kind = ExprKind::Binary(op, left, right);
        match self.is_any_unit(op, left, right) {
            true => self.push_any_unit(kind, home, span),
            false => self.push(kind, shape, home, unit, span),
        }
    }

    /// Whether nothing is known about the unit of a result: in influence functions only, and for sums of zeros.
    fn is_any_unit(&self, op: BinaryOp, left: ExprId, right: ExprId) -> bool {
        let (left, right) = (self.facts(left).any_unit, self.facts(right).any_unit);
        match op {
            BinaryOp::Add | BinaryOp::Sub => left && right,
            BinaryOp::Mul | BinaryOp::Div => self.context == Context::Influence && (left || right),
            _ => false,
        }
    }

    fn sum_of(&mut self, left: ExprId, right: ExprId, op: &str) -> Option<(Shape, Unit)> {
        self.numeric(left, op)?;
        self.numeric(right, op)?;
        let shape = match (self.shape(left), self.shape(right)) {
            (a, b) if a == b => a,
            (Shape::Symmetric, Shape::Tensor) | (Shape::Tensor, Shape::Symmetric) => Shape::Tensor,
            _ => return self.wrong(check::shapes::unlike(op, self.expr(left), self.expr(right))),
        };
        Some((shape, self.common_unit(left, right, op)?))
    }

    fn product_of(&mut self, left: ExprId, right: ExprId) -> Option<(Shape, Unit)> {
        self.numeric(left, "*")?;
        self.numeric(right, "*")?;
        let shape = match (self.shape(left), self.shape(right)) {
            (Shape::Scalar, any) | (any, Shape::Scalar) => any,
            (Shape::Tensor | Shape::Symmetric, Shape::Vector) => Shape::Vector,
            (Shape::Tensor | Shape::Symmetric, Shape::Tensor | Shape::Symmetric) => Shape::Tensor,
            _ => return self.wrong(check::shapes::no_product(self.expr(left), self.expr(right))),
        };
        Some((shape, self.unit(left).times(&self.unit(right))))
    }

    fn quotient_of(&mut self, left: ExprId, right: ExprId) -> Option<(Shape, Unit)> {
        self.numeric(left, "/")?;
        if self.shape(right) != Shape::Scalar {
            return self.wrong(check::shapes::not_a(
                "divisor",
                Shape::Scalar,
                self.expr(right),
            ));
        }
        Some((self.shape(left), self.unit(left).per(&self.unit(right))))
    }

    fn both_true(&mut self, left: ExprId, right: ExprId, op: &str) -> Option<(Shape, Unit)> {
        self.boolean(left, op)?;
        self.boolean(right, op)?;
        Some((Shape::Boolean, Unit::NUMBER))
    }

    fn power(&mut self, base: ExprId, exponent: ExprId, span: Span) -> Option<ExprId> {
        if self.shape(base) != Shape::Scalar {
            return self.wrong(check::shapes::no_power(self.expr(base)));
        }
        self.scalar(exponent, "an exponent")?;
        self.pure_number(exponent, "an exponent")?;
        let home = self.home_of(&[base, exponent]);
        let kind = ExprKind::Binary(BinaryOp::Pow, base, exponent);
        let unit = self.unit(base);
        if unit.is_number() && !self.facts(base).any_unit {
            return self.push(kind, Shape::Scalar, home, Unit::NUMBER, span);
        }
        match self
            .facts(exponent)
            .literal
            .and_then(|value| unit.power(value))
        {
            Some(unit) if !self.facts(base).any_unit => {
                self.push(kind, Shape::Scalar, home, unit, span)
            }
            _ if self.context == Context::Influence => self.push_any_unit(kind, home, span),
            _ => {
                let unit = self.describe(&unit);
                self.wrong(check::exponents::unknown(
                    self.expr(exponent),
                    self.expr(base),
                    &unit,
                ))
            }
        }
    }

    pub(crate) fn comparison(
        &mut self,
        op: CompareOp,
        left: ExprId,
        right: ExprId,
        span: Span,
    ) -> Option<ExprId> {
        self.scalar(left, "a side of a comparison")?;
        self.scalar(right, "a side of a comparison")?;
        self.common_unit(left, right, check::unit_mismatch::symbol(op))?;
        let home = self.home_of(&[left, right]);
        self.push(
            ExprKind::Compare(op, left, right),
            Shape::Boolean,
            home,
            Unit::NUMBER,
            span,
        )
    }

    pub(crate) fn component(
        &mut self,
        inner: ExprId,
        axes: &ast::Name,
        span: Span,
    ) -> Option<ExprId> {
        let indices = match check::components::indices(self.expr(inner), axes) {
            Ok(indices) => indices,
            Err(finding) => return self.wrong(*finding),
        };
        let (home, unit) = (self.home_of(&[inner]), self.unit(inner));
        self.push(
            ExprKind::Component(inner, indices),
            Shape::Scalar,
            home,
            unit,
            span,
        )
    }

    /// A vector by its components: scalars of one unit.
    pub(crate) fn components(&mut self, parts: Vec<ExprId>, span: Span) -> Option<ExprId> {
        let mut unit = Unit::NUMBER;
        let mut model: Option<ExprId> = None;
        for &part in &parts {
            self.scalar(part, "a component")?;
            if let Some(model) = model {
                unit = self.common_unit(model, part, "the components of a vector")?;
            }
            if model.is_none_or(|model| self.facts(model).any_unit) {
                (model, unit) = (Some(part), self.unit(part));
            }
        }
        let home = self.home_of(&parts);
        self.push(ExprKind::Vector(parts), Shape::Vector, home, unit, span)
    }

    /// The arms of a case, one per flavour: alike in shape and unit.
    pub(crate) fn alternatives(&mut self, arms: [ExprId; 5], span: Span) -> Option<ExprId> {
        let mut shape = self.shape(arms[0]);
        let mut unit = self.unit(arms[0]);
        let mut model = arms[0];
        for &arm in &arms[1..] {
            shape = match (shape, self.shape(arm)) {
                (a, b) if a == b => a,
                (Shape::Symmetric, Shape::Tensor) | (Shape::Tensor, Shape::Symmetric) => {
                    Shape::Tensor
                }
                _ => {
                    return self.wrong(check::shapes::unlike(
                        "the arms of a case",
                        self.expr(model),
                        self.expr(arm),
                    ));
                }
            };
            unit = self.common_unit(model, arm, "the arms of a case")?;
            if !self.facts(arm).any_unit {
                model = arm;
            }
        }
        let home = self.home_of(&arms);
        self.push(ExprKind::Case(arms), shape, home, unit, span)
    }

    // ---- changes of home

    pub(crate) fn prime(&mut self, inner: ExprId, span: Span) -> Option<ExprId> {
        if self.context != Context::Law {
            return self.wrong(check::primes::outside_of_law(span));
        }
        let (shape, unit) = (self.shape(inner), self.unit(inner));
        match (&self.expr(inner).kind, self.expr(inner).home) {
            (ExprKind::Prime(_), _) => self.wrong(check::primes::twice(span)),
            (_, Home::Constant) => self.wrong(check::primes::constant(span)),
            _ => self.push(ExprKind::Prime(inner), shape, Home::Bond, unit, span),
        }
    }

    pub(crate) fn reduce(
        &mut self,
        reduction: Reduction,
        name: &ast::Name,
        family: FamilyId,
        inner: ExprId,
        span: Span,
    ) -> Option<ExprId> {
        if self.context != Context::Law {
            return self.wrong(check::names::only_in_laws(name));
        }
        match reduction {
            Reduction::Sum | Reduction::Sum0 => self.numeric(inner, "a sum")?,
            Reduction::Mean => self.numeric(inner, "a mean")?,
            Reduction::Min | Reduction::Max => self.scalar(inner, "an extreme")?,
            Reduction::Count => self.boolean(inner, "count")?,
        }
        if self.expr(inner).home == Home::Node {
            return self.wrong(check::sums::node_value(
                name,
                self.expr(inner),
                self.is_name(inner),
            ));
        }
        let (shape, unit) = match reduction {
            Reduction::Sum | Reduction::Sum0 => {
                (self.shape(inner), self.unit(inner).times(&Unit::volume()))
            }
            Reduction::Count => (Shape::Scalar, Unit::NUMBER),
            _ => (self.shape(inner), self.unit(inner)),
        };
        self.push(
            ExprKind::Reduce(reduction, family, inner),
            shape,
            Home::Node,
            unit,
            span,
        )
    }

    /// Whether an expression is a lone name, that a prime could follow.
    fn is_name(&self, id: ExprId) -> bool {
        matches!(
            self.expr(id).kind,
            ExprKind::Def(_)
                | ExprKind::Field(_)
                | ExprKind::Velocity
                | ExprKind::Position
                | ExprKind::History(_)
        )
    }

    pub(crate) fn ball(&mut self, inner: ExprId, span: Span) -> Option<ExprId> {
        if self.context != Context::Law {
            return self.wrong(check::balls::only_in_laws(span));
        }
        self.scalar(inner, "what `ball` integrates")?;
        if let Some((place, why)) = self.beyond(inner, LENGTH) {
            return self.wrong(check::balls::changes(place, why));
        }
        let unit = self.unit(inner).times(&Unit::volume());
        self.push(
            ExprKind::Ball(inner),
            Shape::Scalar,
            Home::Constant,
            unit,
            span,
        )
    }

    /// Where an expression is more than a function of the reference body, of a reference bond, or of its length,
    /// and why. That it changes is worse than that it depends on the direction.
    pub(crate) fn beyond(&self, id: ExprId, want: usize) -> Option<(Span, &'static str)> {
        let flaws = &self.facts(id).beyond;
        let want = (BOND..want).find(|k| flaws[*k].is_some()).unwrap_or(want);
        let why = flaws[want]?;
        Some((
            self.blamed(id, |law, part| law.facts(part).beyond[want].is_some()),
            why,
        ))
    }

    /// The innermost operand, or operand of an operand, that has a flaw.
    pub(crate) fn blamed(&self, mut id: ExprId, flawed: impl Fn(&Self, ExprId) -> bool) -> Span {
        while let Some(part) = operands(&self.expr(id).kind)
            .into_iter()
            .find(|part| flawed(self, *part))
        {
            id = part;
        }
        self.expr(id).span
    }

    // ---- built-in functions

    pub(crate) fn builtin(
        &mut self,
        builtin: Builtin,
        name: &ast::Name,
        args: Vec<ExprId>,
        span: Span,
    ) -> Option<ExprId> {
        let (shape, unit) = match builtin {
            Builtin::Norm => self
                .vectors(name, &args)
                .map(|()| (Shape::Scalar, self.unit(args[0]))),
            Builtin::Dot => self
                .vectors(name, &args)
                .map(|()| (Shape::Scalar, self.unit_product(&args))),
            Builtin::Outer => self
                .vectors(name, &args)
                .map(|()| (self.outer_shape(&args), self.unit_product(&args))),
            Builtin::Trace => self
                .tensor(name, args[0])
                .map(|()| (Shape::Scalar, self.unit(args[0]))),
            Builtin::Sym => self
                .tensor(name, args[0])
                .map(|()| (Shape::Symmetric, self.unit(args[0]))),
            Builtin::Dev | Builtin::Transpose => self
                .tensor(name, args[0])
                .map(|()| (self.shape(args[0]), self.unit(args[0]))),
            Builtin::Diag => self
                .diagonal(name, args[0])
                .map(|shape| (shape, self.unit(args[0]))),
            Builtin::Inverse => self
                .tensor(name, args[0])
                .map(|()| (self.shape(args[0]), self.unit(args[0]).inverse())),
            Builtin::Det => self.determinant(name, args[0]),
            Builtin::Sqrt => self.square_root(args[0]),
            Builtin::Abs => self
                .scalar(args[0], "the argument of `abs`")
                .map(|()| (Shape::Scalar, self.unit(args[0]))),
            Builtin::Exp | Builtin::Ln | Builtin::Sin | Builtin::Cos | Builtin::Tan => {
                self.of_number(name, args[0])
            }
            Builtin::Min | Builtin::Max => self.extreme(name, args[0], args[1]),
            Builtin::Select => self.selected(&args),
        }?;
        let home = self.home_of(&args);
        self.push(ExprKind::Call(builtin, args), shape, home, unit, span)
    }

    fn unit_product(&self, args: &[ExprId]) -> Unit {
        self.unit(args[0]).times(&self.unit(args[1]))
    }

    fn diagonal(&mut self, name: &ast::Name, arg: ExprId) -> Option<Shape> {
        match self.shape(arg) {
            Shape::Vector => Some(Shape::Symmetric),
            _ => self.tensor(name, arg).map(|()| Shape::Vector),
        }
    }

    fn outer_shape(&self, args: &[ExprId]) -> Shape {
        if self.facts(args[0]).structure == self.facts(args[1]).structure {
            Shape::Symmetric
        } else {
            Shape::Tensor
        }
    }

    fn determinant(&mut self, name: &ast::Name, arg: ExprId) -> Option<(Shape, Unit)> {
        self.tensor(name, arg)?;
        self.pure_number(
            arg,
            "the argument of `det`, whose unit would depend on the dimension,",
        )?;
        Some((Shape::Scalar, Unit::NUMBER))
    }

    fn square_root(&mut self, arg: ExprId) -> Option<(Shape, Unit)> {
        self.scalar(arg, "the argument of `sqrt`")?;
        match self.unit(arg).power(0.5) {
            Some(unit) => Some((Shape::Scalar, unit)),
            None => {
                let unit = self.describe(&self.unit(arg));
                self.wrong(check::exponents::no_root(self.expr(arg), &unit))
            }
        }
    }

    fn of_number(&mut self, name: &ast::Name, arg: ExprId) -> Option<(Shape, Unit)> {
        let what = format!("the argument of `{}`", name.text);
        self.scalar(arg, &what)?;
        self.pure_number(arg, &what)?;
        Some((Shape::Scalar, Unit::NUMBER))
    }

    fn extreme(&mut self, name: &ast::Name, left: ExprId, right: ExprId) -> Option<(Shape, Unit)> {
        let what = format!("an argument of `{}`", name.text);
        self.scalar(left, &what)?;
        self.scalar(right, &what)?;
        Some((Shape::Scalar, self.common_unit(left, right, &name.text)?))
    }

    fn selected(&mut self, args: &[ExprId]) -> Option<(Shape, Unit)> {
        self.boolean(args[0], "select")?;
        self.scalar(args[1], "what `select` chooses from")?;
        self.scalar(args[2], "what `select` chooses from")?;
        Some((Shape::Scalar, self.common_unit(args[1], args[2], "select")?))
    }

    // ---- what an operation asks of its operands

    pub(crate) fn scalar(&mut self, id: ExprId, what: &str) -> Option<()> {
        match self.shape(id) {
            Shape::Scalar => Some(()),
            _ => self.wrong(check::shapes::not_a(what, Shape::Scalar, self.expr(id))),
        }
    }

    fn numeric(&mut self, id: ExprId, op: &str) -> Option<()> {
        match self.shape(id) {
            Shape::Boolean => self.wrong(check::shapes::condition_as_value(op, self.expr(id))),
            _ => Some(()),
        }
    }

    pub(crate) fn boolean(&mut self, id: ExprId, op: &str) -> Option<()> {
        match self.shape(id) {
            Shape::Boolean => Some(()),
            _ => self.wrong(check::shapes::value_as_condition(op, self.expr(id))),
        }
    }

    fn vectors(&mut self, name: &ast::Name, args: &[ExprId]) -> Option<()> {
        let what = format!("an argument of `{}`", name.text);
        for &arg in args {
            if self.shape(arg) != Shape::Vector {
                return self.wrong(check::shapes::not_a(&what, Shape::Vector, self.expr(arg)));
            }
        }
        Some(())
    }

    fn tensor(&mut self, name: &ast::Name, arg: ExprId) -> Option<()> {
        match self.shape(arg) {
            Shape::Tensor | Shape::Symmetric => Some(()),
            _ => {
                let what = format!("the argument of `{}`", name.text);
                self.wrong(check::shapes::not_a(&what, Shape::Tensor, self.expr(arg)))
            }
        }
    }

    pub(crate) fn pure_number(&mut self, id: ExprId, what: &str) -> Option<()> {
        if self.expr(id).unit.is_number() || self.facts(id).any_unit {
            return Some(());
        }
        let unit = self.describe(&self.unit(id));
        self.wrong(check::numbers::has_unit(what, self.expr(id), &unit))
    }

    /// The unit of two values that must be alike in it. Zero, infinity and the unknown fit any.
    fn common_unit(&mut self, left: ExprId, right: ExprId, op: &str) -> Option<Unit> {
        let (left_unit, right_unit) = (self.unit(left), self.unit(right));
        if left_unit == right_unit || self.facts(right).any_unit {
            return Some(left_unit);
        }
        if self.facts(left).any_unit {
            return Some(right_unit);
        }
        let (found, other) = (self.describe(&left_unit), self.describe(&right_unit));
        self.wrong(check::unit_mismatch::between(
            op,
            (self.expr(left), &found),
            (self.expr(right), &other),
        ))
    }
}
