//! The tangent: what a small change of the displacements changes, quantity by quantity.

use super::algebra::{Atom, Kind, Sum, dot, outer, summed};
use super::factors::factors;
use super::read::{Scope, boolean, scalar, vector};
use super::slopes::select;
use super::{Line, Meaning};
use crate::ir::{CompareOp, Home, Shape};
use crate::ratio::Ratio;

pub(super) struct Changes<'s, 'a> {
    scope: &'s Scope<'a>,
    /// Named results of the derivation, which change too.
    named: Vec<Line>,
    /// Names whose change is needed.
    needed: Vec<String>,
}

impl<'s, 'a> Changes<'s, 'a> {
    /// The change of `last`, and before it that of everything that it needs. `scope` knows which of `named` move.
    pub(super) fn of(scope: &'s Scope<'a>, named: &[Line], last: &[Line]) -> Option<Vec<Line>> {
        let mut changes = Changes {
            scope,
            named: named.to_vec(),
            needed: vec![],
        };
        let mut lines: Vec<Line> = vec![];
        for line in last {
            lines.push(changes.line(line)?);
        }
        // Until nothing more is needed: each name adds those that it is made of.
        let mut k = 0;
        let mut found: Vec<Line> = vec![];
        while k < changes.needed.len() {
            let name = changes.needed[k].clone();
            found.push(changes.line_of(&name)?);
            k += 1;
        }
        // In the order in which they can be computed.
        let order: Vec<String> = ["e", "M"]
            .map(String::from)
            .into_iter()
            .chain(scope.own().map(|d| d.name.clone()))
            .chain(named.iter().map(|l| l.name.clone()))
            .collect();
        let place = |line: &Line| match &line.meaning {
            Meaning::Change(of) => order.iter().position(|n| n == of).unwrap_or(order.len()),
            _ => order.len(),
        };
        found.sort_by_key(place);
        found.extend(lines);
        Some(found)
    }

    fn line(&mut self, line: &Line) -> Option<Line> {
        Some(Line {
            meaning: Meaning::Change(line.name.clone()),
            name: self.scope.change(&line.name),
            value: self.sum(&line.value)?,
            ..line.clone()
        })
    }

    fn line_of(&mut self, name: &str) -> Option<Line> {
        let scope = self.scope;
        if let Some(k) = self.named.iter().position(|l| l.name == name) {
            let line = self.named[k].clone();
            return self.line(&line);
        }
        let of_bond = |shape, value| Line {
            meaning: Meaning::Change(name.into()),
            name: scope.change(name),
            home: Home::Bond,
            shape,
            value,
        };
        match name {
            "e" if scope.is_prelude("e") => {
                let value = dot(&scope.bond("M")?, &self.small())?;
                Some(of_bond(Shape::Scalar, value))
            }
            "M" if scope.is_prelude("M") => {
                let along = self.extension()?.times(&scope.bond("M")?)?;
                let across = self.small().minus(&along)?;
                Some(of_bond(Shape::Vector, across.over(&scope.bond("y")?)?))
            }
            _ => {
                let def = scope.def(name)?;
                let value = scope.value(name)?;
                Some(Line {
                    meaning: Meaning::Change(name.into()),
                    name: scope.change(name),
                    home: def.home,
                    shape: def.shape,
                    value: self.sum(&value)?,
                })
            }
        }
    }

    fn need(&mut self, name: &str, shape: Shape, home: Home) -> Sum {
        if !self.needed.iter().any(|n| n == name) {
            self.needed.push(name.into());
        }
        Atom::name(&self.scope.change(name), shape, home).sum()
    }

    /// The change of the relative displacement.
    fn small(&self) -> Sum {
        Atom::name(&self.scope.change("eta"), Shape::Vector, Home::Bond).sum()
    }

    /// The change of the extension.
    fn extension(&mut self) -> Option<Sum> {
        match self.scope.is_prelude("e") {
            true => Some(self.need("e", Shape::Scalar, Home::Bond)),
            false => dot(&self.scope.bond("M")?, &self.small()),
        }
    }

    fn sum(&mut self, value: &Sum) -> Option<Sum> {
        let mut all = Sum::ZERO;
        for p in &value.0 {
            for factor in factors(p, |atom| self.scope.atom_moves(atom))? {
                let own = self.atom(factor.atom)?;
                all = all.plus(&factor.change(&own)?)?;
            }
        }
        Some(all)
    }

    fn atom(&mut self, atom: &Atom) -> Option<Sum> {
        match &atom.kind {
            Kind::Name(name) => self.name(name, atom),
            Kind::Prime(inner) => {
                let own = self.atom(inner)?;
                self.scope.primed(&own)
            }
            Kind::Sum(inner) => self.sum(inner),
            Kind::Component(inner, axes) => {
                let own = self.sum(inner)?;
                Some(match own.is_zero() {
                    true => own,
                    false => scalar(Kind::Component(own, axes.clone()), atom.home),
                })
            }
            Kind::Vector(parts) => {
                let parts = parts.iter().map(|p| self.sum(p)).collect::<Option<_>>()?;
                Some(vector(parts))
            }
            Kind::Power(a, b) => {
                (!self.scope.sum_moves(b)).then_some(())?;
                let less = Kind::Power(a.clone(), b.minus(&Sum::int(1))?);
                self.sum(a)?.times(b)?.times(&scalar(less, atom.home))
            }
            Kind::Call(name, family, args) => self.call(name, family.as_deref(), args, atom),
            _ => None,
        }
    }

    fn name(&mut self, name: &str, atom: &Atom) -> Option<Sum> {
        let scope = self.scope;
        let named = self.named.iter().any(|l| l.name == *name);
        if named || scope.is_own(name) {
            return Some(self.need(name, atom.shape, atom.home));
        }
        if scope.is_prelude(name) {
            match name {
                "eta" | "Y" => return Some(self.small()),
                "e" | "y" => return self.extension(),
                "s" => return self.extension()?.over(&scope.bond("x")?),
                "M" => return Some(self.need("M", Shape::Vector, Home::Bond)),
                _ => {}
            }
        }
        self.sum(&scope.value(name)?)
    }

    fn call(&mut self, name: &str, family: Option<&str>, args: &[Sum], atom: &Atom) -> Option<Sum> {
        let a = args.first()?;
        let own = || atom.clone().sum();
        let call = |name: &str| Atom::call(name, vec![a.clone()], Shape::Scalar).sum();
        match (name, args) {
            ("sum" | "sum0", [a]) => summed(name, family, &self.sum(a)?),
            ("dot", [a, b]) => {
                let (da, db) = (self.sum(a)?, self.sum(b)?);
                dot(&da, b)?.plus(&dot(a, &db)?)
            }
            ("outer", [a, b]) => {
                let (da, db) = (self.sum(a)?, self.sum(b)?);
                outer(&da, b)?.plus(&outer(a, &db)?)
            }
            ("tr", _) => self.sum(a)?.mapped("tr", Shape::Scalar),
            ("sym", _) => self.sum(a)?.mapped("sym", Shape::Symmetric),
            ("dev", _) => self.sum(a)?.mapped("dev", atom.shape),
            ("transpose", _) => self.sum(a)?.transposed(),
            ("inverse", _) => {
                let change = self.sum(a)?;
                own().times(&change)?.times(&own())?.scaled(Ratio::int(-1))
            }
            ("det", _) => {
                let inverse = Atom::call("inverse", vec![a.clone()], a.shape()).sum();
                let change = self.sum(a)?;
                own().times(&inverse.times(&change)?.mapped("tr", Shape::Scalar)?)
            }
            ("norm", _) => dot(a, &self.sum(a)?)?.over(&own()),
            ("sqrt", _) => self.sum(a)?.over(&own().scaled(Ratio::int(2))?),
            ("exp", _) => self.sum(a)?.times(&own()),
            ("ln", _) => self.sum(a)?.over(a),
            ("sin", _) => self.sum(a)?.times(&call("cos")),
            ("cos", _) => self.sum(a)?.times(&call("sin").scaled(Ratio::int(-1))?),
            ("tan", _) => self.sum(a)?.over(&call("cos").power(Ratio::int(2))?),
            ("abs", _) => {
                let negative =
                    boolean(Kind::Compare(CompareOp::Lt, a.clone(), Sum::ZERO), a.home());
                let sign = select(&negative, Sum::int(-1), Sum::int(1));
                self.sum(a)?.times(&sign)
            }
            ("min" | "max", [a, b]) => {
                let op = if name == "min" {
                    CompareOp::Le
                } else {
                    CompareOp::Ge
                };
                let first = boolean(Kind::Compare(op, a.clone(), b.clone()), atom.home);
                Some(select(&first, self.sum(a)?, self.sum(b)?))
            }
            ("select", [c, a, b]) => Some(select(c, self.sum(a)?, self.sum(b)?)),
            _ => None,
        }
    }
}
