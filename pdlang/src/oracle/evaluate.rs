//! Expressions, read off the IR.

use super::body::State;
use super::influence::compare;
use super::number::Real;
use super::value::{self, Value};
use super::{Error, Oracle};
use crate::ir::{
    BinaryOp, Builtin, ExprId, ExprKind, FamilyId, FieldId, HistoryId, Home, Law, Reduction,
};
use std::cell::RefCell;
use std::collections::HashMap;

/// Where an expression is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// A constant.
    Nowhere,
    Node(usize),
    /// A directed bond of the body.
    Bond(usize),
    /// A reference bond vector without a body, under `ball`.
    Reference([f64; 3]),
}

/// How an unbounded body moves of which one node stands for all.
pub(super) struct Wave<'o, T> {
    /// Relative displacement per bond.
    pub eta: Vec<[T; 3]>,
    /// What a scalar field gains.
    pub field: Option<(FieldId, T)>,
    /// Whether the bonds stand for the infinitely many of a continuum, where they are counted.
    pub dense: bool,
    /// What a number of the node is at the other end of a bond.
    pub there: &'o dyn Fn(usize, T) -> T,
}

/// What a definition must find of the stack, and what it is given where that is not there [bytes].
const STACK: (usize, usize) = (256 << 10, 8 << 20);

type Last<T> = HashMap<(ExprId, bool), (Place, Value<T>)>;

/// One pass over one state. Sums and node definitions are remembered per node, what many read at a bond until the next.
pub(super) struct Evaluator<'o, 'a, T> {
    oracle: &'o Oracle<'a>,
    state: &'o State,
    u: Vec<[T; 3]>,
    /// A uniform displacement gradient, on top.
    gradient: Option<[[T; 3]; 3]>,
    /// Bond and component whose relative displacement alone carries a derivative.
    stretched: Option<(usize, usize, T)>,
    /// A wave that one node stands for, on top.
    wave: Option<Wave<'o, T>>,
    /// Per expression, filled when first asked for: per node, and at the end for constants.
    known: RefCell<Vec<Vec<Option<Value<T>>>>>,
    /// By expression, and by which way the bond leads: where it was read last.
    last: RefCell<Last<T>>,
}

impl<'o, 'a, T: Real> Evaluator<'o, 'a, T> {
    pub(super) fn new(
        oracle: &'o Oracle<'a>,
        state: &'o State,
        u: Vec<[T; 3]>,
    ) -> Result<Self, Error> {
        if !state.fits(oracle.law, oracle.body) {
            return Err(Error(
                "the state is not one of this law on this body".into(),
            ));
        }
        Ok(Evaluator {
            oracle,
            state,
            u,
            gradient: None,
            stretched: None,
            wave: None,
            known: RefCell::new(vec![Vec::new(); oracle.law.exprs.len()]),
            last: RefCell::new(HashMap::new()),
        })
    }

    /// Strains every bond by a uniform displacement gradient as well.
    pub(super) fn strained(mut self, gradient: [[T; 3]; 3]) -> Self {
        self.gradient = Some(gradient);
        self
    }

    /// Lets a wave pass as well, over a body of one node whose bonds lead to itself.
    pub(super) fn waved(mut self, wave: Wave<'o, T>) -> Self {
        self.wave = Some(wave);
        self
    }

    /// A number of the node that stands for all as the other end of bond `b` has it.
    pub(super) fn there(&self, b: usize, value: T) -> T {
        match &self.wave {
            Some(wave) => (wave.there)(b, value),
            None => value,
        }
    }

    /// Whether bond `b` belongs to the family and is intact.
    pub(super) fn intact(&self, family: FamilyId, b: usize) -> bool {
        self.oracle.member[family.index()][b] && self.state.intact[family.index()][b]
    }

    /// Direction of the deformed bond, Y/|Y|.
    pub(super) fn direction(&self, b: usize) -> Result<Value<T>, Error> {
        let y = self.xi(Place::Bond(b))?.add(self.eta(Place::Bond(b))?)?;
        y.div(Value::Scalar(y.norm()?))
    }

    /// Value of expression `id` at `place`.
    pub(super) fn at(&self, id: ExprId, place: Place) -> Result<Value<T>, Error> {
        match self.oracle.shared[id.index()] {
            true => self.remember(id, place, || self.form(id, place)),
            false => self.form(id, place),
        }
    }

    /// What is not inlined here is so for the stack: the frame of what is deepest would be that of all.
    fn form(&self, id: ExprId, place: Place) -> Result<Value<T>, Error> {
        match &self.oracle.law.exprs[id.index()].kind {
            ExprKind::Number(v) => number(*v),
            ExprKind::Pi => number(std::f64::consts::PI),
            ExprKind::Dim => number(self.oracle.dim() as f64),
            ExprKind::Delta => number(self.oracle.settings.horizon),
            ExprKind::Identity => Ok(value::identity(self.oracle.dim())),
            ExprKind::Var(_) => Err(Error("a law has no free variables".into())),
            ExprKind::Param(p) => number(self.oracle.settings.params[p.index()]),
            ExprKind::Def(def) => self.definition(def.index(), place),
            ExprKind::Field(f) => self.field(*f, place),
            ExprKind::History(h) => self.history(*h, place),
            ExprKind::Influence(slot) => self.influence(slot.index(), place),
            ExprKind::Weight(w) => number(self.oracle.weights[w.index()][self.bond(place)?]),
            ExprKind::Xi => self.xi(place),
            ExprKind::Eta => self.eta(place),
            ExprKind::Velocity => Ok(Value::Vector(self.state.v[self.node(place)?]).lift()),
            ExprKind::Position => {
                Ok(Value::Vector(self.oracle.body.nodes[self.node(place)?].position).lift())
            }
            ExprKind::TimeStep => number(self.state.dt),
            ExprKind::Neg(a) => Ok(self.at(*a, place)?.map(|x| -x)),
            ExprKind::Not(a) => Ok(Value::Boolean(!self.at(*a, place)?.boolean()?)),
            ExprKind::Binary(op, a, b) => self.binary(*op, *a, *b, place),
            ExprKind::Compare(op, a, b) => {
                let (a, b) = (self.at(*a, place)?.scalar()?, self.at(*b, place)?.scalar()?);
                Ok(Value::Boolean(compare(*op, a.value(), b.value())))
            }
            ExprKind::Call(builtin, args) => self.call(*builtin, args, place),
            ExprKind::Vector(parts) => self.vector(parts, place),
            ExprKind::Component(a, index) => self.component(*a, index, place),
            ExprKind::Reduce(reduction, family, a) => {
                let node = self.node(place)?;
                self.remember(id, Place::Node(node), || {
                    self.sum(*reduction, *family, *a, id, node)
                })
            }
            ExprKind::Ball(a) => self.ball(id, *a),
            ExprKind::Prime(a) => self.other_end(*a, place),
            ExprKind::Case(arms) => self.at(arms[self.oracle.settings.flavour as usize], place),
        }
    }

    /// Whether a node belongs to the part of the body that a field lives on.
    pub(super) fn lives(&self, field: FieldId, node: usize) -> Result<bool, Error> {
        match &self.oracle.law.fields[field.index()].lives {
            Some(lives) => self.at(lives.when, Place::Node(node))?.boolean(),
            None => Ok(true),
        }
    }

    fn remember(
        &self,
        id: ExprId,
        place: Place,
        compute: impl FnOnce() -> Result<Value<T>, Error>,
    ) -> Result<Value<T>, Error> {
        let nodes = self.oracle.body.nodes.len();
        let k = match place {
            Place::Node(i) => i,
            Place::Nowhere => nodes,
            Place::Bond(_) | Place::Reference(_) => return self.remember_last(id, place, compute),
        };
        if let Some(Some(value)) = self.known.borrow()[id.index()].get(k) {
            return Ok(*value);
        }
        let value = compute()?;
        let row = &mut self.known.borrow_mut()[id.index()];
        row.resize(nodes + 1, None);
        row[k] = Some(value);
        Ok(value)
    }

    /// At a bond and its reverse, each until another is read.
    fn remember_last(
        &self,
        id: ExprId,
        place: Place,
        compute: impl FnOnce() -> Result<Value<T>, Error>,
    ) -> Result<Value<T>, Error> {
        let turned = matches!(place, Place::Bond(b) if self.oracle.reverse[b] < Some(b));
        if let Some((at, value)) = self.last.borrow().get(&(id, turned))
            && *at == place
        {
            return Ok(*value);
        }
        let value = compute()?;
        self.last.borrow_mut().insert((id, turned), (place, value));
        Ok(value)
    }

    fn definition(&self, k: usize, place: Place) -> Result<Value<T>, Error> {
        let def = &self.oracle.law.defs[k];
        let form = |place| stacker::maybe_grow(STACK.0, STACK.1, || self.at(def.expr, place));
        let known = |place| self.remember(def.expr, place, || form(place));
        match def.home {
            Home::Constant => known(Place::Nowhere),
            Home::Node => known(Place::Node(self.node(place)?)),
            Home::Bond => form(place),
        }
    }

    fn node(&self, place: Place) -> Result<usize, Error> {
        match place {
            Place::Node(i) => Ok(i),
            Place::Bond(b) => Ok(self.oracle.body.bonds[b].from),
            _ => Err(Error(
                "a node quantity is read where there is no node".into(),
            )),
        }
    }

    fn bond(&self, place: Place) -> Result<usize, Error> {
        match place {
            Place::Bond(b) => Ok(b),
            _ => Err(Error(
                "a bond quantity is read where there is no bond".into(),
            )),
        }
    }

    #[inline(never)]
    fn field(&self, field: FieldId, place: Place) -> Result<Value<T>, Error> {
        let node = self.node(place)?;
        let mut value = self.state.fields[field.index()][node].lift();
        if let Some((moved, gain)) = self.wave.as_ref().and_then(|wave| wave.field)
            && moved == field
        {
            value = value.add(Value::Scalar(gain))?;
        }
        Ok(match self.lives(field, node)? {
            true => value,
            false => value.map(|_| T::constant(0.0)),
        })
    }

    #[inline(never)]
    fn history(&self, id: HistoryId, place: Place) -> Result<Value<T>, Error> {
        let k = match self.oracle.law.histories[id.index()].home {
            Home::Bond => self.bond(place)?,
            _ => self.node(place)?,
        };
        Ok(self.state.histories[id.index()][k].lift())
    }

    #[inline(never)]
    fn influence(&self, slot: usize, place: Place) -> Result<Value<T>, Error> {
        match place {
            Place::Reference(xi) => {
                let r = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
                number(self.oracle.influence(slot, r)?)
            }
            _ => number(self.oracle.omega[slot][self.bond(place)?]),
        }
    }

    fn xi(&self, place: Place) -> Result<Value<T>, Error> {
        match place {
            Place::Reference(xi) => Ok(Value::Vector(xi).lift()),
            _ => Ok(Value::Vector(self.oracle.body.bonds[self.bond(place)?].xi).lift()),
        }
    }

    #[inline(never)]
    fn eta(&self, place: Place) -> Result<Value<T>, Error> {
        let b = self.bond(place)?;
        let bond = &self.oracle.body.bonds[b];
        let mut eta = std::array::from_fn(|a| self.u[bond.to][a] - self.u[bond.from][a]);
        if let Some(gradient) = &self.gradient {
            let xi = bond.xi.map(T::constant);
            for (eta, row) in eta.iter_mut().zip(gradient) {
                *eta = *eta + row[0] * xi[0] + row[1] * xi[1] + row[2] * xi[2];
            }
        }
        if let Some(wave) = &self.wave {
            eta = std::array::from_fn(|a| eta[a] + wave.eta[b][a]);
        }
        if let Some((only, a, unit)) = self.stretched
            && only == b
        {
            eta[a] = eta[a] + unit;
        }
        Ok(Value::Vector(eta))
    }

    /// Weighted sum over the bonds of a node that the reduction sees. An empty sum is a zero of its shape.
    #[inline(never)]
    fn sum(
        &self,
        reduction: Reduction,
        family: FamilyId,
        a: ExprId,
        id: ExprId,
        node: usize,
    ) -> Result<Value<T>, Error> {
        let counts = |b: &usize| match reduction {
            Reduction::Sum0 => self.oracle.member[family.index()][*b],
            _ => self.intact(family, *b),
        };
        let dense = self.wave.as_ref().is_some_and(|wave| wave.dense);
        let one = T::constant(if dense { f64::INFINITY } else { 1.0 });
        let mut sum = empty(self.oracle.law, id);
        let mut volume = 0.0;
        for (k, &b) in self.oracle.bonds_of[node]
            .iter()
            .filter(|b| counts(b))
            .enumerate()
        {
            let value = self.at(a, Place::Bond(b))?;
            let weight = self.oracle.body.bonds[b].weight;
            volume += weight;
            sum = match reduction {
                Reduction::Sum | Reduction::Sum0 | Reduction::Mean => {
                    sum.add(value.scaled(T::constant(weight)))?
                }
                Reduction::Count if value.boolean()? => sum.add(Value::Scalar(one))?,
                Reduction::Count => sum,
                Reduction::Min if k > 0 => Value::Scalar(sum.scalar()?.min(value.scalar()?)),
                Reduction::Max if k > 0 => Value::Scalar(sum.scalar()?.max(value.scalar()?)),
                Reduction::Min | Reduction::Max => value,
            };
        }
        match reduction {
            Reduction::Mean if volume > 0.0 => Ok(sum.scaled(T::constant(1.0 / volume))),
            _ => Ok(sum),
        }
    }

    fn ball(&self, id: ExprId, integrand: ExprId) -> Result<Value<T>, Error> {
        match self.oracle.balls[id.index()] {
            Some(integral) => number(integral),
            None => number(self.oracle.ball(self.state, integrand)?),
        }
    }

    #[inline(never)]
    fn other_end(&self, a: ExprId, place: Place) -> Result<Value<T>, Error> {
        let b = self.bond(place)?;
        let value = match self.oracle.law.exprs[a.index()].home {
            Home::Bond => self.at(a, Place::Bond(self.oracle.reverse_of(b)?)),
            _ => self.at(a, Place::Node(self.oracle.body.bonds[b].to)),
        };
        Ok(value?.map(|x| self.there(b, x)))
    }

    #[inline(never)]
    fn binary(&self, op: BinaryOp, a: ExprId, b: ExprId, place: Place) -> Result<Value<T>, Error> {
        let (left, right) = (self.at(a, place)?, self.at(b, place)?);
        match op {
            BinaryOp::Add => left.add(right),
            BinaryOp::Sub => left.sub(right),
            BinaryOp::Mul => left.mul(right),
            BinaryOp::Div if self.is_empty_sum(b, right) => Ok(left.zeroed()),
            BinaryOp::Div => left.div(right),
            BinaryOp::Pow if self.is_empty_sum(a, left) && right.scalar()?.value() < 0.0 => {
                Ok(left.zeroed())
            }
            BinaryOp::Pow => Ok(Value::Scalar(left.scalar()?.pow(right.scalar()?))),
            BinaryOp::And => Ok(Value::Boolean(left.boolean()? && right.boolean()?)),
            BinaryOp::Or => Ok(Value::Boolean(left.boolean()? || right.boolean()?)),
        }
    }

    /// A sum without bonds is exactly zero; what divides by it is zero by rule.
    fn is_empty_sum(&self, id: ExprId, value: Value<T>) -> bool {
        self.oracle.sums[id.index()] && value.is_zero()
    }

    #[inline(never)]
    fn call(&self, builtin: Builtin, args: &[ExprId], place: Place) -> Result<Value<T>, Error> {
        let arg = |k: usize| match args.get(k) {
            Some(a) => self.at(*a, place),
            None => Err(Error(format!("{builtin:?} lacks an argument"))),
        };
        let scalar = |k: usize| arg(k)?.scalar();
        let dim = self.oracle.dim();
        match builtin {
            Builtin::Outer => arg(0)?.outer(arg(1)?),
            Builtin::Sym => arg(0)?.symmetric_part(),
            Builtin::Dev => arg(0)?.deviator(dim),
            Builtin::Transpose => arg(0)?.transpose(),
            Builtin::Diag => arg(0)?.diagonal(),
            Builtin::Inverse => self.inverse(args, arg(0)?),
            Builtin::Select if arg(0)?.boolean()? => arg(1),
            Builtin::Select => arg(2),
            Builtin::Norm => Ok(Value::Scalar(arg(0)?.norm()?)),
            Builtin::Dot => Ok(Value::Scalar(arg(0)?.dot(arg(1)?)?)),
            Builtin::Trace => Ok(Value::Scalar(arg(0)?.trace()?)),
            Builtin::Det => Ok(Value::Scalar(arg(0)?.determinant(dim)?)),
            Builtin::Sqrt => Ok(Value::Scalar(scalar(0)?.sqrt())),
            Builtin::Abs => Ok(Value::Scalar(scalar(0)?.abs())),
            Builtin::Exp => Ok(Value::Scalar(scalar(0)?.exp())),
            Builtin::Ln => Ok(Value::Scalar(scalar(0)?.ln())),
            Builtin::Sin => Ok(Value::Scalar(scalar(0)?.sin())),
            Builtin::Cos => Ok(Value::Scalar(scalar(0)?.cos())),
            Builtin::Tan => Ok(Value::Scalar(scalar(0)?.sin() / scalar(0)?.cos())),
            Builtin::Min => Ok(Value::Scalar(scalar(0)?.min(scalar(1)?))),
            Builtin::Max => Ok(Value::Scalar(scalar(0)?.max(scalar(1)?))),
        }
    }

    #[inline(never)]
    fn inverse(&self, args: &[ExprId], a: Value<T>) -> Result<Value<T>, Error> {
        let dim = self.oracle.dim();
        match args.first() {
            Some(id) if self.oracle.shapes[id.index()] && a.is_flat(dim)? => Ok(a.zeroed()),
            Some(id) if self.is_empty_sum(*id, Value::Scalar(a.determinant(dim)?)) => {
                Ok(a.zeroed())
            }
            _ => a.inverse(dim),
        }
    }

    #[inline(never)]
    fn vector(&self, parts: &[ExprId], place: Place) -> Result<Value<T>, Error> {
        let mut v = value::zero_vector();
        for (to, part) in v.iter_mut().zip(parts).take(self.oracle.dim()) {
            *to = self.at(*part, place)?.scalar()?;
        }
        Ok(Value::Vector(v))
    }

    /// A component beyond the dimension is zero: nothing moves or strains there.
    #[inline(never)]
    fn component(&self, a: ExprId, index: &[u8], place: Place) -> Result<Value<T>, Error> {
        match (self.at(a, place)?, index) {
            (Value::Vector(v), [k @ 0..3]) => Ok(Value::Scalar(v[*k as usize])),
            (Value::Tensor(t), [i @ 0..3, k @ 0..3]) => {
                Ok(Value::Scalar(t[*i as usize][*k as usize]))
            }
            _ => Err(Error("a component of what has none".into())),
        }
    }
}

impl<T: Real> Evaluator<'_, '_, super::Dual<T>> {
    /// Lets only the relative displacement of bond `b` along `a` carry a derivative.
    pub(super) fn stretch_only(&mut self, b: usize, a: usize) {
        let unit = super::Dual::new(T::constant(0.0), T::constant(1.0));
        self.stretched = Some((b, a, unit));
    }
}

fn number<T: Real>(value: f64) -> Result<Value<T>, Error> {
    Ok(Value::Scalar(T::constant(value)))
}

fn empty<T: Real>(law: &Law, id: ExprId) -> Value<T> {
    match law.exprs[id.index()].shape {
        crate::ir::Shape::Vector => Value::Vector(value::zero_vector()),
        crate::ir::Shape::Symmetric | crate::ir::Shape::Tensor => {
            Value::Tensor(value::zero_tensor())
        }
        _ => Value::Scalar(T::constant(0.0)),
    }
}
