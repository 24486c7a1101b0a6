//! From an energy to the force state: slopes of W by everything that follows the deformation, last definitions first.
//!
//! The energy of a body is the sum of W V over its nodes. A bond quantity q of node i enters it through sums weighted by the
//! volume of the other end, so its slope is per both volumes; that by the relative position is the force state
//! (Silling et al. 2007, J. Elasticity 88, eq. 29).

use super::algebra::{Atom, Kind, Product, Sum, dot, outer, summed};
use super::factors::factors;
use super::read::{Scope, boolean, scalar, vector};
use super::{Bonds, Line, Meaning};
use crate::ir::{CompareOp, Home, Shape};
use crate::ratio::Ratio;

#[derive(Clone, Debug, PartialEq)]
enum Place {
    Node,
    Bond(Bonds),
}

/// A force state on some bonds.
pub(super) struct State {
    pub bonds: Bonds,
    /// Along the bond, and what else there is.
    pub along: Sum,
    pub vector: Sum,
}

pub(super) struct Slopes<'s, 'a> {
    scope: &'s Scope<'a>,
    /// What is differentiated, in names.
    energy: String,
    found: Vec<(String, Place, Sum)>,
    pub states: Vec<State>,
    pub lines: Vec<Line>,
}

impl<'s, 'a> Slopes<'s, 'a> {
    /// The slopes of an energy density.
    pub(super) fn of(scope: &'s Scope<'a>, name: &str, energy: &Sum) -> Option<Slopes<'s, 'a>> {
        let mut slopes = Slopes {
            scope,
            energy: name.into(),
            found: vec![],
            states: vec![],
            lines: vec![],
        };
        slopes.back(energy, &Sum::int(1), &Place::Node)?;
        // Whoever uses a definition comes behind it.
        for def in scope.own().rev() {
            while let Some(k) = slopes.found.iter().position(|(n, ..)| *n == def.name) {
                let (name, place, slope) = slopes.found.remove(k);
                let slope = slopes.named(&name, &place, slope)?;
                let value = scope.value(&name)?;
                slopes.back(&value, &slope, &place)?;
            }
        }
        slopes.found.is_empty().then_some(slopes)
    }

    /// A slope of several terms, or with a sum over bonds, gets a name; one that is another quantity is that.
    fn named(&mut self, of: &str, place: &Place, slope: Sum) -> Option<Sum> {
        let slope = self.recognised(slope);
        let alias = slope.single().is_some();
        let long = slope.0.len() > 1 || slope.0.iter().any(has_reduction);
        if !alias && !long {
            return Some(slope);
        }
        let def = self.scope.def(of)?;
        // Only the symmetric part of it meets a change of what is symmetric, and the name promises that.
        let slope = match def.shape == Shape::Symmetric && slope.shape() != Shape::Symmetric {
            true => slope.mapped("sym", Shape::Symmetric)?,
            false => slope,
        };
        let bonds = match place {
            Place::Bond(bonds) => Some(bonds.clone()),
            Place::Node => None,
        };
        let mark = bonds.as_ref().map_or_else(String::new, Bonds::mark);
        let meaning = Meaning::Slope(self.energy.clone(), of.into(), bonds);
        let name = format!("d{}_d{of}{mark}", self.energy);
        let name = self.scope.called(&meaning, name);
        self.lines.push(Line {
            meaning,
            name: name.clone(),
            home: def.home,
            shape: def.shape,
            value: slope.clone(),
        });
        Some(match alias {
            true => slope,
            false => Atom::name(&name, def.shape, def.home).sum(),
        })
    }

    /// A slope that is a tensor quantity of the law, opened: the stress, for instance.
    fn recognised(&self, slope: Sum) -> Sum {
        if slope.0.len() < 2 {
            return slope;
        }
        let scope = self.scope;
        let inside = |atom: &Atom| match &atom.kind {
            Kind::Name(name) if scope.is_own(name) && scope.is_moving(name) => {
                let def = scope.def(name)?;
                let opens = def.home == Home::Node && def.shape == Shape::Symmetric;
                opens.then(|| scope.value(name))?
            }
            _ => None,
        };
        let Some(opened) = slope.opened(&inside) else {
            return slope;
        };
        let same = scope.own().find_map(|def| {
            let atom = Atom::name(&def.name, def.shape, def.home);
            let value = inside(&atom)?.opened(&inside)?;
            (value == opened).then(|| atom.sum())
        });
        same.unwrap_or(slope)
    }

    fn add(&mut self, name: &str, place: Place, slope: &Sum) -> Option<()> {
        match self
            .found
            .iter_mut()
            .find(|(n, p, _)| n == name && *p == place)
        {
            Some((.., known)) => *known = known.plus(slope)?,
            None => self.found.push((name.into(), place, slope.clone())),
        }
        Some(())
    }

    fn state(&mut self, bonds: &Bonds) -> &mut State {
        let k = match self.states.iter().position(|s| s.bonds == *bonds) {
            Some(k) => k,
            None => {
                self.states.push(State {
                    bonds: bonds.clone(),
                    along: Sum::ZERO,
                    vector: Sum::ZERO,
                });
                self.states.len() - 1
            }
        };
        &mut self.states[k]
    }

    /// Slopes of what `value` is made of, for the slope `by` of the value.
    fn back(&mut self, value: &Sum, by: &Sum, place: &Place) -> Option<()> {
        for p in &value.0 {
            for factor in factors(p, |atom| self.scope.atom_moves(atom))? {
                self.back_atom(factor.atom, &factor.slope(by)?, place)?;
            }
        }
        Some(())
    }

    fn back_atom(&mut self, atom: &Atom, by: &Sum, place: &Place) -> Option<()> {
        if by.is_zero() {
            return Some(());
        }
        match &atom.kind {
            Kind::Name(name) => self.back_name(name, by, place),
            Kind::Prime(inner) => {
                let Place::Bond(bonds) = place else {
                    return None;
                };
                // What a bond gives its other end, seen from there.
                let back = self.scope.primed(by)?;
                match inner.home {
                    Home::Bond => self.back_atom(inner, &back, place),
                    _ => {
                        let whole = summed(&bonds.word, bonds.family.as_deref(), &back)?;
                        self.back_atom(inner, &whole, &Place::Node)
                    }
                }
            }
            Kind::Sum(inner) => self.back(inner, by, place),
            Kind::Vector(_) | Kind::Not(_) | Kind::Compare(..) | Kind::Logic(..) => None,
            Kind::Written(_) => None,
            Kind::Component(inner, axes) => {
                let axis = |a: char| {
                    let one = |b| Sum::int(i64::from(a == b));
                    vector(['x', 'y', 'z'].map(one).to_vec())
                };
                let axes: Vec<char> = axes.chars().collect();
                let direction = match axes.as_slice() {
                    [a] => axis(*a),
                    [a, b] => outer(&axis(*a), &axis(*b))?,
                    _ => return None,
                };
                self.back(inner, &by.times(&direction)?, place)
            }
            Kind::Power(a, b) => {
                let slope = b.times(&scalar(
                    Kind::Power(a.clone(), b.minus(&Sum::int(1))?),
                    atom.home,
                ))?;
                (!self.scope.sum_moves(b)).then_some(())?;
                self.back(a, &by.times(&slope)?, place)
            }
            Kind::Call(name, family, args) => {
                self.back_call(name, family.as_deref(), args, atom, by, place)
            }
        }
    }

    fn back_name(&mut self, name: &str, by: &Sum, place: &Place) -> Option<()> {
        let scope = self.scope;
        if scope.is_own(name) {
            let def = scope.def(name)?;
            return match (def.home, place) {
                (Home::Node, Place::Bond(bonds)) => {
                    let whole = summed(&bonds.word, bonds.family.as_deref(), by)?;
                    self.add(name, Place::Node, &whole)
                }
                _ => self.add(name, place.clone(), by),
            };
        }
        let Place::Bond(bonds) = place.clone() else {
            return None;
        };
        if !scope.is_prelude(name) {
            return self.back(&scope.value(name)?, by, place);
        }
        let state = self.state(&bonds);
        match name {
            "e" | "y" => state.along = state.along.plus(by)?,
            "s" => state.along = state.along.plus(&by.over(&scope.bond("x")?)?)?,
            "Y" | "eta" => state.vector = state.vector.plus(by)?,
            "M" => {
                let y = scope.bond("y")?;
                state.vector = state.vector.plus(&by.over(&y)?)?;
                let less = dot(&scope.bond("M")?, by)?.over(&y)?;
                state.along = state.along.minus(&less)?;
            }
            _ => return self.back(&scope.value(name)?, by, place),
        }
        Some(())
    }

    fn back_call(
        &mut self,
        name: &str,
        family: Option<&str>,
        args: &[Sum],
        atom: &Atom,
        by: &Sum,
        place: &Place,
    ) -> Option<()> {
        let a = args.first()?;
        let own = || atom.clone().sum();
        let call = |name: &str| Atom::call(name, vec![a.clone()], Shape::Scalar).sum();
        let two = Ratio::int(2);
        let mut chain = |slope: Sum| self.back(a, &by.times(&slope)?, place);
        match (name, args) {
            ("sum" | "sum0", [a]) => {
                let bonds = Bonds {
                    word: name.into(),
                    family: family.map(String::from),
                };
                match place {
                    Place::Node => self.back(a, by, &Place::Bond(bonds)),
                    // A sum that is read at a bond belongs to the node.
                    Place::Bond(outer) => {
                        let whole = summed(&outer.word, outer.family.as_deref(), by)?;
                        self.back(a, &whole, &Place::Bond(bonds))
                    }
                }
            }
            ("dot", [a, b]) => {
                self.back(a, &by.times(b)?, place)?;
                self.back(b, &by.times(a)?, place)
            }
            ("outer", [a, b]) => {
                self.back(a, &by.times(b)?, place)?;
                self.back(b, &by.transposed()?.times(a)?, place)
            }
            ("tr", _) => chain(Atom::name("I", Shape::Symmetric, Home::Constant).sum()),
            ("sym", _) => self.back(a, &by.mapped("sym", Shape::Symmetric)?, place),
            ("dev", _) => self.back(a, &by.mapped("dev", by.shape())?, place),
            ("transpose", _) => self.back(a, &by.transposed()?, place),
            ("inverse", _) => {
                let turned = own().transposed()?;
                let slope = turned.times(by)?.times(&turned)?.scaled(Ratio::int(-1))?;
                self.back(a, &slope, place)
            }
            ("det", _) => {
                let inverse = Atom::call("inverse", vec![a.clone()], a.shape()).sum();
                chain(own().times(&inverse.transposed()?)?)
            }
            ("norm", _) => chain(a.over(&own())?),
            ("sqrt", _) => chain(Sum::int(1).over(&own().scaled(two)?)?),
            ("exp", _) => chain(own()),
            ("ln", _) => chain(Sum::int(1).over(a)?),
            ("sin", _) => chain(call("cos")),
            ("cos", _) => chain(call("sin").scaled(Ratio::int(-1))?),
            ("tan", _) => chain(call("cos").power(Ratio::int(-2))?),
            ("abs", _) => {
                let negative =
                    boolean(Kind::Compare(CompareOp::Lt, a.clone(), Sum::ZERO), a.home());
                chain(select(&negative, Sum::int(-1), Sum::int(1)))
            }
            ("min" | "max", [a, b]) => {
                let op = if name == "min" {
                    CompareOp::Le
                } else {
                    CompareOp::Ge
                };
                let first = boolean(Kind::Compare(op, a.clone(), b.clone()), atom.home);
                let (yes, no) = (
                    select(&first, Sum::int(1), Sum::ZERO),
                    select(&first, Sum::ZERO, Sum::int(1)),
                );
                self.back(a, &by.times(&yes)?, place)?;
                self.back(b, &by.times(&no)?, place)
            }
            ("select", [c, a, b]) => {
                let (yes, no) = (
                    select(c, Sum::int(1), Sum::ZERO),
                    select(c, Sum::ZERO, Sum::int(1)),
                );
                self.back(a, &by.times(&yes)?, place)?;
                self.back(b, &by.times(&no)?, place)
            }
            _ => None,
        }
    }
}

pub(super) fn select(condition: &Sum, yes: Sum, no: Sum) -> Sum {
    if yes == no {
        return yes;
    }
    Atom::call("select", vec![condition.clone(), yes, no], Shape::Scalar).sum()
}

fn has_reduction(p: &Product) -> bool {
    let reduces =
        |a: &Atom| matches!(&a.kind, Kind::Call(name, ..) if name == "sum" || name == "sum0");
    p.scalars.iter().any(|(a, _)| reduces(a)) || p.tensors.iter().any(reduces)
}
