//! Formulas as sums of products, so that like terms meet and a slope can be taken.
//!
//! Contract. Every constructor simplifies what a reader would: products of numbers, like terms, powers of one base, the unit
//! tensor, transposes of symmetric tensors. Sums stay as they are written unless [`Sum::opened`] multiplies them out. Arithmetic
//! is exact; `None` where it would overflow.

use crate::ast;
use crate::ir::{BinaryOp, CompareOp, Home, Shape};
use crate::ratio::Ratio;

/// What is not a sum or a product.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    Name(String),
    /// A built-in function, a reduction with its family, or a function of the library.
    Call(String, Option<String>, Vec<Sum>),
    /// A value at the other end.
    Prime(Box<Atom>),
    /// A sum as a factor.
    Sum(Sum),
    /// Base and exponent, where that is no number.
    Power(Sum, Sum),
    Component(Sum, String),
    Vector(Vec<Sum>),
    Compare(CompareOp, Sum, Sum),
    Logic(BinaryOp, Sum, Sum),
    Not(Sum),
    /// As it was written: a number with a unit, a choice by flavour of constants.
    Written(ast::Expr),
}

#[derive(Clone, Debug)]
pub(super) struct Atom {
    pub kind: Kind,
    pub shape: Shape,
    pub home: Home,
}

impl PartialEq for Atom {
    fn eq(&self, other: &Atom) -> bool {
        match (&self.kind, &other.kind) {
            // Where it stands is no difference.
            (Kind::Written(a), Kind::Written(b)) => {
                format!("{:?}", bare(a)) == format!("{:?}", bare(b))
            }
            (a, b) => a == b,
        }
    }
}

fn bare(e: &ast::Expr) -> String {
    super::super::plain::expr(e)
}

/// A number, scalars with their powers, and tensors whose order matters, a vector at most at the end.
#[derive(Clone, Debug)]
pub(super) struct Product {
    pub number: Ratio,
    pub scalars: Vec<(Atom, Ratio)>,
    pub tensors: Vec<Atom>,
}

impl PartialEq for Product {
    fn eq(&self, other: &Product) -> bool {
        self.number == other.number && self.like(other)
    }
}

/// Terms in the order in which they were met.
#[derive(Clone, Debug)]
pub(super) struct Sum(pub Vec<Product>);

impl PartialEq for Sum {
    fn eq(&self, other: &Sum) -> bool {
        self.0.len() == other.0.len() && self.0.iter().all(|p| other.0.contains(p))
    }
}

pub(super) fn is_scalar(shape: Shape) -> bool {
    matches!(shape, Shape::Scalar | Shape::Boolean)
}

impl Atom {
    pub(super) fn name(name: &str, shape: Shape, home: Home) -> Atom {
        Atom {
            kind: Kind::Name(name.into()),
            shape,
            home,
        }
    }

    /// A function of its arguments, as near to the bonds as they are.
    pub(super) fn call(name: &str, args: Vec<Sum>, shape: Shape) -> Atom {
        let home = args.iter().map(Sum::home).max().unwrap_or(Home::Constant);
        Atom {
            kind: Kind::Call(name.into(), None, args),
            shape,
            home,
        }
    }

    pub(super) fn is(&self, name: &str) -> bool {
        matches!(&self.kind, Kind::Name(own) if own == name)
    }

    pub(super) fn sum(self) -> Sum {
        let (scalars, tensors) = match is_scalar(self.shape) {
            true => (vec![(self, Ratio::ONE)], vec![]),
            false => (vec![], vec![self]),
        };
        Sum(vec![Product {
            number: Ratio::ONE,
            scalars,
            tensors,
        }])
    }
}

impl Product {
    /// Equal but for the number.
    pub(super) fn like(&self, other: &Product) -> bool {
        self.scalars.len() == other.scalars.len()
            && self.tensors == other.tensors
            && self.scalars.iter().all(|s| other.scalars.contains(s))
    }

    pub(super) fn shape(&self) -> Shape {
        match self.tensors.as_slice() {
            [] => Shape::Scalar,
            [one] => one.shape,
            [.., last] if last.shape == Shape::Vector => Shape::Vector,
            _ => Shape::Tensor,
        }
    }

    pub(super) fn atoms(&self) -> impl Iterator<Item = &Atom> {
        self.scalars.iter().map(|(a, _)| a).chain(&self.tensors)
    }

    fn home(&self) -> Home {
        self.atoms().map(|a| a.home).max().unwrap_or(Home::Constant)
    }

    fn times_atom(&mut self, atom: Atom, power: Ratio) -> Option<()> {
        if !is_scalar(atom.shape) {
            if atom.is("I") && !self.tensors.is_empty() {
                return Some(());
            }
            if self.tensors.len() == 1 && self.tensors[0].is("I") {
                self.tensors.clear();
            }
            self.tensors.push(atom);
            return Some(());
        }
        match self.scalars.iter().position(|(known, _)| *known == atom) {
            Some(k) => {
                self.scalars[k].1 = self.scalars[k].1.add(power)?;
                if self.scalars[k].1.is_zero() {
                    self.scalars.remove(k);
                }
            }
            None => self.scalars.push((atom, power)),
        }
        Some(())
    }

    fn times(&self, other: &Product) -> Option<Product> {
        let mut product = self.clone();
        product.number = product.number.mul(other.number)?;
        for (atom, power) in &other.scalars {
            product.times_atom(atom.clone(), *power)?;
        }
        for atom in &other.tensors {
            product.times_atom(atom.clone(), Ratio::ONE)?;
        }
        Some(product)
    }
}

impl Sum {
    pub(super) const ZERO: Sum = Sum(Vec::new());

    pub(super) fn number(number: Ratio) -> Sum {
        let product = Product {
            number,
            scalars: vec![],
            tensors: vec![],
        };
        Sum(if number.is_zero() {
            vec![]
        } else {
            vec![product]
        })
    }

    pub(super) fn int(n: i64) -> Sum {
        Sum::number(Ratio::int(n))
    }

    pub(super) fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn shape(&self) -> Shape {
        let mut shapes = self.0.iter().map(Product::shape);
        let first = shapes.next().unwrap_or(Shape::Scalar);
        match shapes.all(|shape| shape == first) {
            true => first,
            false => Shape::Tensor,
        }
    }

    pub(super) fn home(&self) -> Home {
        let homes = self.0.iter().map(Product::home);
        homes.max().unwrap_or(Home::Constant)
    }

    /// The only atom that it consists of.
    pub(super) fn single(&self) -> Option<&Atom> {
        match self.0.as_slice() {
            [p] if p.number.is_one() => match (p.scalars.as_slice(), p.tensors.as_slice()) {
                ([(atom, power)], []) if power.is_one() => Some(atom),
                ([], [atom]) => Some(atom),
                _ => None,
            },
            _ => None,
        }
    }

    /// The number that it is.
    pub(super) fn value(&self) -> Option<Ratio> {
        match self.0.as_slice() {
            [] => Some(Ratio::ZERO),
            [p] if p.scalars.is_empty() && p.tensors.is_empty() => Some(p.number),
            _ => None,
        }
    }

    pub(super) fn plus(&self, other: &Sum) -> Option<Sum> {
        let mut terms = self.0.clone();
        for term in &other.0 {
            match terms.iter().position(|known| known.like(term)) {
                Some(k) => {
                    terms[k].number = terms[k].number.add(term.number)?;
                    if terms[k].number.is_zero() {
                        terms.remove(k);
                    }
                }
                None => terms.push(term.clone()),
            }
        }
        Some(Sum(terms))
    }

    pub(super) fn scaled(&self, by: Ratio) -> Option<Sum> {
        if by.is_zero() {
            return Some(Sum::ZERO);
        }
        let one = |p: &Product| {
            let number = p.number.mul(by)?;
            Some(Product {
                number,
                ..p.clone()
            })
        };
        self.0.iter().map(one).collect::<Option<_>>().map(Sum)
    }

    pub(super) fn minus(&self, other: &Sum) -> Option<Sum> {
        self.plus(&other.scaled(Ratio::int(-1))?)
    }

    /// The sum as one factor.
    fn factor(&self) -> Sum {
        if self.0.len() < 2 {
            return self.clone();
        }
        let atom = Atom {
            kind: Kind::Sum(self.clone()),
            shape: self.shape(),
            home: self.home(),
        };
        atom.sum()
    }

    pub(super) fn times(&self, other: &Sum) -> Option<Sum> {
        if self.is_zero() || other.is_zero() {
            return Some(Sum::ZERO);
        }
        if let Some(number) = self.value() {
            return other.factor_unless(number).scaled(number);
        }
        if let Some(number) = other.value() {
            return self.factor_unless(number).scaled(number);
        }
        let (a, b) = (self.factor(), other.factor());
        Some(Sum(vec![a.0[0].times(&b.0[0])?]))
    }

    /// A sign goes into the terms, another number stands before them.
    fn factor_unless(&self, number: Ratio) -> Sum {
        match number.as_int() {
            Some(1 | -1) => self.clone(),
            _ => self.factor(),
        }
    }

    /// A scalar to a power. `None` where that is no product of powers: the root of a square is not its base, and a root
    /// of a product need not be one of its factors.
    pub(super) fn power(&self, power: Ratio) -> Option<Sum> {
        if power.is_zero() {
            return Some(Sum::int(1));
        }
        if let (Some(number), Some(n)) = (self.value(), power.as_int()) {
            return number.powi(n).map(Sum::number);
        }
        let base = self.factor();
        let product = base.0.first()?;
        let whole = power.as_int();
        let rooted = match product.scalars.as_slice() {
            // An even power loses the sign.
            [(_, own)] => product.number.is_one() && own.as_int().is_none_or(|n| n % 2 != 0),
            _ => false,
        };
        if whole.is_none() && !rooted || !product.tensors.is_empty() {
            return None;
        }
        let number = whole.map_or(Some(Ratio::ONE), |n| product.number.powi(n))?;
        let raised = |(atom, own): &(Atom, Ratio)| Some((atom.clone(), own.mul(power)?));
        let scalars = product.scalars.iter().map(raised).collect::<Option<_>>()?;
        Some(Sum(vec![Product {
            number,
            scalars,
            tensors: vec![],
        }]))
    }

    pub(super) fn over(&self, other: &Sum) -> Option<Sum> {
        self.times(&other.power(Ratio::int(-1))?)
    }

    pub(super) fn transposed(&self) -> Option<Sum> {
        let one = |p: &Product| {
            if p.shape() == Shape::Vector {
                return None;
            }
            let turned = |a: &Atom| match (&a.kind, a.shape) {
                (_, Shape::Symmetric) => Some(a.clone()),
                (Kind::Sum(inner), _) => inner.transposed()?.factor().single().cloned(),
                (Kind::Call(name, _, args), _) if name == "transpose" => {
                    args.first()?.factor().single().cloned()
                }
                _ => Some(Atom::call(
                    "transpose",
                    vec![a.clone().sum()],
                    Shape::Tensor,
                )),
            };
            let tensors = p.tensors.iter().rev().map(turned).collect::<Option<_>>()?;
            Some(Product {
                tensors,
                ..p.clone()
            })
        };
        self.0.iter().map(one).collect::<Option<_>>().map(Sum)
    }

    /// A linear function of tensors, term by term: scalars stand before it.
    pub(super) fn mapped(&self, name: &str, shape: Shape) -> Option<Sum> {
        let mut sum = Sum::ZERO;
        for p in &self.0 {
            let outer = Product {
                tensors: vec![],
                ..p.clone()
            };
            let inner = Sum(vec![Product {
                number: Ratio::ONE,
                scalars: vec![],
                tensors: p.tensors.clone(),
            }]);
            let value = inner.under(name, shape)?;
            sum = sum.plus(&Sum(vec![outer]).times(&value)?)?;
        }
        Some(sum)
    }

    /// `sym`, `tr`, `dev`, of tensors alone.
    fn under(&self, name: &str, shape: Shape) -> Option<Sum> {
        let call = |inner: &Sum| Atom::call(name, vec![inner.clone()], shape).sum();
        Some(match (name, self.single()) {
            ("sym", Some(a)) if a.shape == Shape::Symmetric => self.clone(),
            ("sym", Some(a)) => match &a.kind {
                Kind::Call(inner, _, args) if inner == "transpose" => call(&args[0]),
                Kind::Sum(inner) => inner.mapped(name, shape)?,
                _ => call(self),
            },
            ("tr", Some(a)) if a.is("I") => Atom::name("dim", Shape::Scalar, Home::Constant).sum(),
            ("tr", Some(a)) => match &a.kind {
                Kind::Call(inner, _, args) if ["transpose", "sym"].contains(&inner.as_str()) => {
                    args[0].mapped("tr", Shape::Scalar)?
                }
                Kind::Call(inner, _, args) if inner == "outer" => dot(&args[0], &args[1])?,
                Kind::Sum(inner) => inner.mapped("tr", Shape::Scalar)?,
                _ => call(self),
            },
            (_, Some(a)) => match &a.kind {
                Kind::Sum(inner) => inner.mapped(name, shape)?,
                _ => call(self),
            },
            _ => call(self),
        })
    }

    /// All products of sums multiplied out, and what `inside` says in the place of a name.
    pub(super) fn opened(&self, inside: &dyn Fn(&Atom) -> Option<Sum>) -> Option<Sum> {
        let mut sum = Sum::ZERO;
        for p in &self.0 {
            let mut terms = Sum::number(p.number);
            for (atom, power) in &p.scalars {
                let factor = opened_atom(atom, inside)?;
                terms = match power.as_int() {
                    Some(1) => spread(&terms, &factor)?,
                    _ => spread(&terms, &atom.clone().sum().power(*power)?)?,
                };
            }
            for atom in &p.tensors {
                terms = spread(&terms, &opened_atom(atom, inside)?)?;
            }
            sum = sum.plus(&terms)?;
        }
        Some(sum)
    }
}

fn opened_atom(atom: &Atom, inside: &dyn Fn(&Atom) -> Option<Sum>) -> Option<Sum> {
    match (&atom.kind, inside(atom)) {
        (_, Some(value)) => value.opened(inside),
        (Kind::Sum(inner), _) => inner.opened(inside),
        (Kind::Call(name, None, args), _) if ["tr", "sym"].contains(&name.as_str()) => {
            let shape = atom.shape;
            args[0].opened(inside)?.mapped(name, shape)
        }
        _ => Some(atom.clone().sum()),
    }
}

/// Terms that a page still shows; products of sums have many more than their text.
const MOST_TERMS: usize = 200;

fn spread(a: &Sum, b: &Sum) -> Option<Sum> {
    if a.0.len() * b.0.len() > MOST_TERMS {
        return None;
    }
    let mut sum = Sum::ZERO;
    for x in &a.0 {
        for y in &b.0 {
            sum = sum.plus(&Sum(vec![x.times(y)?]))?;
        }
    }
    Some(sum)
}

/// The scalar product of two vectors.
pub(super) fn dot(a: &Sum, b: &Sum) -> Option<Sum> {
    pair("dot", a, b, Shape::Scalar)
}

pub(super) fn outer(a: &Sum, b: &Sum) -> Option<Sum> {
    let shape = if a == b {
        Shape::Symmetric
    } else {
        Shape::Tensor
    };
    pair("outer", a, b, shape)
}

/// A function that is linear in both of its vectors: scalars stand before it.
fn pair(name: &str, a: &Sum, b: &Sum, shape: Shape) -> Option<Sum> {
    if a.is_zero() || b.is_zero() {
        return Some(Sum::ZERO);
    }
    let split = |s: &Sum| {
        let factor = s.factor();
        let p = factor.0.into_iter().next()?;
        let outer = Product {
            tensors: vec![],
            ..p.clone()
        };
        let inner = Product {
            number: Ratio::ONE,
            scalars: vec![],
            tensors: p.tensors,
        };
        Some((Sum(vec![outer]), Sum(vec![inner])))
    };
    let ((before, a), (more, b)) = (split(a)?, split(b)?);
    before
        .times(&more)?
        .times(&Atom::call(name, vec![a, b], shape).sum())
}

/// Components of one tensor times those of another.
pub(super) fn contracted(a: &Sum, b: &Sum) -> Option<Sum> {
    match (a.shape(), b.shape()) {
        (Shape::Vector, Shape::Vector) => dot(a, b),
        (x, y) if is_scalar(x) && is_scalar(y) => a.times(b),
        (x, y) if is_scalar(x) || is_scalar(y) || x == Shape::Vector || y == Shape::Vector => None,
        _ => a.transposed()?.times(b)?.mapped("tr", Shape::Scalar),
    }
}

/// A sum over bonds: what does not differ from bond to bond stands before it.
pub(super) fn summed(word: &str, family: Option<&str>, inner: &Sum) -> Option<Sum> {
    let mut sum = Sum::ZERO;
    let mut rest = Sum::ZERO;
    let mut before: Option<Sum> = None;
    let mut groups: Vec<(Sum, Sum)> = vec![];
    for p in &inner.0 {
        let (out, inn): (Vec<_>, Vec<_>) = p
            .scalars
            .iter()
            .cloned()
            .partition(|(a, _)| a.home != Home::Bond);
        // A tensor of the node stands before the sum where it is the first factor of a product.
        let first = p
            .tensors
            .iter()
            .take_while(|a| a.home != Home::Bond)
            .count();
        let first = first.min(p.tensors.len().saturating_sub(1));
        let out = Sum(vec![Product {
            number: p.number,
            scalars: out,
            tensors: p.tensors[..first].to_vec(),
        }]);
        let inn = Sum(vec![Product {
            number: Ratio::ONE,
            scalars: inn,
            tensors: p.tensors[first..].to_vec(),
        }]);
        groups.push((out, inn));
    }
    for (out, inn) in groups {
        if *before.get_or_insert_with(|| out.clone()) == out {
            rest = rest.plus(&inn)?;
        } else {
            sum = sum.plus(&reduced(word, family, &out, &inn)?)?;
        }
    }
    match before {
        Some(out) => reduced(word, family, &out, &rest)?.plus(&sum),
        None => Some(sum),
    }
}

fn reduced(word: &str, family: Option<&str>, out: &Sum, inn: &Sum) -> Option<Sum> {
    let atom = Atom {
        kind: Kind::Call(word.into(), family.map(String::from), vec![inn.clone()]),
        shape: match inn.shape() {
            Shape::Boolean => Shape::Scalar,
            shape => shape,
        },
        home: Home::Node,
    };
    out.times(&atom.sum())
}
