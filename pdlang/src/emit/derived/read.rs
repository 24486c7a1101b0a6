//! Written expressions as sums of products, and what a law's names are.

use super::algebra::{Atom, Kind, Product, Sum, dot, is_scalar, outer, summed};
use super::{Line, Meaning};
use crate::ast::{self, Argument, Expr, ExprKind, Item};
use crate::front::Source;
use crate::ir::{BinaryOp, Def, Home, Law, Shape};
use crate::ratio::Ratio;
use crate::resolve::declare::declared;
use crate::resolve::{names, walk};
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Bond quantities of the prelude that are the same from both ends, and those that change their sign.
const EVEN: [&str; 4] = ["x", "y", "e", "s"];
const ODD: [&str; 4] = ["xi", "eta", "Y", "M"];

#[derive(Clone)]
pub(super) struct Scope<'a> {
    pub law: &'a Law,
    source: &'a Source<'a>,
    /// What the law declares: its definitions, and whatever else has a name.
    declared: HashMap<&'a str, Option<&'a ast::Definition>>,
    defs: HashMap<&'a str, &'a Def>,
    /// Definitions that follow the deformation.
    moving: HashSet<String>,
    /// Results of the derivation by what they mean: one name each.
    called: Rc<RefCell<Vec<(Meaning, String)>>>,
}

/// Arguments of a function that is read in place.
type Arguments = HashMap<String, Sum>;

impl<'a> Scope<'a> {
    pub(super) fn new(law: &'a Law, model: &'a ast::Model, source: &'a Source<'a>) -> Scope<'a> {
        let name = |item: &'a Item| {
            let definition = match item {
                Item::Definition(d) => Some(d),
                _ => None,
            };
            Some((declared(item)?.text.as_str(), definition))
        };
        let mut scope = Scope {
            law,
            source,
            declared: model.items.iter().filter_map(name).collect(),
            defs: HashMap::new(),
            moving: HashSet::new(),
            called: Rc::default(),
        };
        let seen = law.defs.iter().filter(|def| scope.sees(def));
        scope.defs = seen.map(|def| (def.name.as_str(), def)).collect();
        // In dependency order.
        for def in &law.defs {
            if scope
                .written(&def.name)
                .is_some_and(|d| scope.moves(&d.expr))
            {
                scope.moving.insert(def.name.clone());
            }
        }
        scope
    }

    /// With results of a derivation, those that follow the deformation known as such.
    pub(super) fn with(&self, lines: &[Line]) -> Scope<'a> {
        let mut scope = self.clone();
        for line in lines {
            if scope.sum_moves(&line.value) {
                scope.moving.insert(line.name.clone());
            }
        }
        scope
    }

    /// Definitions of the law and of its file, in dependency order.
    pub(super) fn own(&self) -> impl DoubleEndedIterator<Item = &'a Def> + '_ {
        let defs = &self.law.defs;
        defs.iter()
            .filter(|def| self.is_own(&def.name) && self.sees(def))
    }

    /// Whether a definition is not one of the prelude that the law hides: others of the prelude are made of it.
    fn sees(&self, def: &Def) -> bool {
        let prelude = self.source.library.definition(&def.name, true);
        self.is_prelude(&def.name) || prelude.is_none_or(|hidden| hidden.name.span != def.span)
    }

    pub(super) fn def(&self, name: &str) -> Option<&'a Def> {
        self.defs.get(name).copied()
    }

    pub(super) fn is_own(&self, name: &str) -> bool {
        match self.declared.get(name) {
            Some(definition) => definition.is_some(),
            None => self.source.library.own.definitions.contains_key(name),
        }
    }

    /// The name of a result: the one that is wanted, with underscores where something else is called so.
    pub(super) fn called(&self, meaning: &Meaning, wanted: String) -> String {
        let mut called = self.called.borrow_mut();
        if let Some((_, name)) = called.iter().find(|(known, _)| known == meaning) {
            return name.clone();
        }
        let mut name = wanted;
        while self.declared.contains_key(name.as_str())
            || self.defs.contains_key(name.as_str())
            || self.source.library.definition(&name, false).is_some()
            || called.iter().any(|(_, known)| *known == name)
        {
            name.push('_');
        }
        called.push((meaning.clone(), name.clone()));
        name
    }

    /// The name of the change of a quantity.
    pub(super) fn change(&self, of: &str) -> String {
        self.called(&Meaning::Change(of.into()), format!("d_{of}"))
    }

    pub(super) fn written(&self, name: &str) -> Option<&'a ast::Definition> {
        match self.declared.get(name) {
            Some(definition) => *definition,
            None => self.source.library.definition(name, false),
        }
    }

    /// Whether a bond quantity means what the prelude says.
    pub(super) fn is_prelude(&self, name: &str) -> bool {
        let primitive = names::PRIMITIVES.iter().any(|p| p.name == name);
        let hidden = self.declared.contains_key(name)
            || self.source.library.own.definitions.contains_key(name);
        primitive || !hidden && self.source.library.definition(name, true).is_some()
    }

    pub(super) fn is_moving(&self, name: &str) -> bool {
        let of_bond = ["eta", "Y", "y", "e", "s", "M"].contains(&name) && self.is_prelude(name);
        of_bond || self.moving.contains(name)
    }

    /// Whether an expression follows the deformation.
    fn moves(&self, e: &Expr) -> bool {
        match &e.kind {
            ExprKind::Number(..) => false,
            ExprKind::Name(name) => self.is_moving(name),
            // Of a gradient that is given.
            ExprKind::Call { name, .. } if ["under", "count"].contains(&name.text.as_str()) => {
                false
            }
            ExprKind::Call { name, args, .. } => {
                let inside = self.source.library.function(&name.text, false);
                args.iter().any(|arg| self.moves(&arg.value))
                    || inside.is_some_and(|f| {
                        let mut mentioned = vec![];
                        walk::mentioned(&f.body, &mut mentioned);
                        let free = |n: &String| f.params.iter().all(|p| p.text != **n);
                        mentioned.iter().any(|n| free(n) && self.is_moving(n))
                    })
            }
            // Which of two it is follows the deformation in jumps.
            ExprKind::Not(_) | ExprKind::Compare(..) => false,
            ExprKind::Neg(a) | ExprKind::Prime(a) | ExprKind::Component(a, _) => self.moves(a),
            ExprKind::Binary(_, a, b) => self.moves(a) || self.moves(b),
            ExprKind::Vector(parts) => parts.iter().any(|part| self.moves(part)),
            ExprKind::Case(arms) => arms.iter().any(|(_, arm)| self.moves(arm)),
        }
    }

    /// What a name stands for.
    pub(super) fn atom(&self, name: &str) -> Option<Atom> {
        let law = self.law;
        if let Some(def) = self.def(name) {
            return Some(Atom::name(name, def.shape, def.home));
        }
        if let Some(field) = law.fields.iter().find(|f| f.name == name) {
            return Some(Atom::name(name, field.shape, Home::Node));
        }
        if let Some(history) = law.histories.iter().find(|h| h.name == name) {
            return Some(Atom::name(name, history.shape, history.home));
        }
        let of_bond = law.influences.iter().any(|i| i.name == name)
            || law.weights.iter().any(|w| w.name == name);
        if of_bond {
            return Some(Atom::name(name, Shape::Scalar, Home::Bond));
        }
        if let Some(p) = names::PRIMITIVES.iter().find(|p| p.name == name) {
            return Some(Atom::name(name, p.shape, p.home));
        }
        let param = law.params.iter().any(|p| p.name == name);
        param.then(|| Atom::name(name, Shape::Scalar, Home::Constant))
    }

    /// A prelude quantity of the bond that other quantities are made of, although the law does not name it; written out where
    /// the law calls something else so.
    pub(super) fn bond(&self, name: &str) -> Option<Sum> {
        let shape = match name {
            "M" | "Y" => Shape::Vector,
            _ => Shape::Scalar,
        };
        match self.is_prelude(name) {
            true => Some(Atom::name(name, shape, Home::Bond).sum()),
            false => self.prelude(name),
        }
    }

    /// What a definition is made of.
    pub(super) fn value(&self, name: &str) -> Option<Sum> {
        match self.is_prelude(name) {
            true => self.prelude(name),
            false => self.read(&self.written(name)?.expr),
        }
    }

    /// The same for one of the prelude, which sees nothing but the prelude.
    fn prelude(&self, name: &str) -> Option<Sum> {
        let library = &self.source.library;
        let written = library.definition(name, true)?;
        let mut hidden = Arguments::new();
        let mut mentioned = vec![];
        walk::mentioned(&written.expr, &mut mentioned);
        for name in mentioned {
            if !self.is_prelude(&name) && library.definition(&name, true).is_some() {
                let value = self.prelude(&name)?;
                hidden.insert(name, value);
            }
        }
        self.read_in(&written.expr, &hidden)
    }

    pub(super) fn read(&self, e: &Expr) -> Option<Sum> {
        self.read_in(e, &Arguments::new())
    }

    fn read_in(&self, e: &Expr, inside: &Arguments) -> Option<Sum> {
        let read = |e: &Expr| self.read_in(e, inside);
        match &e.kind {
            ExprKind::Number(value, None) => match Ratio::from_f64(*value) {
                Some(number) => Some(Sum::number(number)),
                None => Some(constant(e).sum()),
            },
            ExprKind::Number(..) => Some(constant(e).sum()),
            ExprKind::Name(name) => match inside.get(name) {
                Some(given) => Some(given.clone()),
                None => match self.atom(name) {
                    Some(atom) => Some(atom.sum()),
                    None => self.value(name),
                },
            },
            ExprKind::Neg(a) => read(a)?.scaled(Ratio::int(-1)),
            ExprKind::Prime(a) => self.primed(&read(a)?),
            ExprKind::Binary(op, a, b) => self.binary(*op, read(a)?, read(b)?),
            ExprKind::Component(a, axes) => {
                let a = read(a)?;
                let home = a.home();
                let kind = Kind::Component(a, axes.text.clone());
                Some(scalar(kind, home))
            }
            ExprKind::Vector(parts) => {
                let parts: Vec<Sum> = parts.iter().map(read).collect::<Option<_>>()?;
                Some(vector(parts))
            }
            ExprKind::Compare(op, a, b) => {
                let (a, b) = (read(a)?, read(b)?);
                let home = a.home().max(b.home());
                Some(boolean(Kind::Compare(*op, a, b), home))
            }
            ExprKind::Not(a) => {
                let a = read(a)?;
                let home = a.home();
                Some(boolean(Kind::Not(a), home))
            }
            // Choices by flavour are of constants; others are not read.
            ExprKind::Case(arms) if !self.moves(e) && inside.is_empty() => {
                let arms: Vec<Sum> = arms
                    .iter()
                    .map(|(_, arm)| read(arm))
                    .collect::<Option<_>>()?;
                let home = arms.iter().map(Sum::home).max()?;
                let shape = arms.first()?.shape();
                let kind = Kind::Written(e.clone());
                Some(Atom { kind, shape, home }.sum())
            }
            ExprKind::Case(_) => None,
            ExprKind::Call { name, family, args } => self.call(
                &name.text,
                family.as_ref().map(|f| f.text.as_str()),
                args,
                inside,
            ),
        }
    }

    fn binary(&self, op: BinaryOp, a: Sum, b: Sum) -> Option<Sum> {
        match op {
            BinaryOp::Add => a.plus(&b),
            BinaryOp::Sub => a.minus(&b),
            BinaryOp::Mul => a.times(&b),
            BinaryOp::Div => a.over(&b),
            BinaryOp::Pow => match b.value().and_then(|n| a.power(n)) {
                Some(power) => Some(power),
                None => {
                    let home = a.home().max(b.home());
                    Some(scalar(Kind::Power(a, b), home))
                }
            },
            BinaryOp::And | BinaryOp::Or => {
                let home = a.home().max(b.home());
                Some(boolean(Kind::Logic(op, a, b), home))
            }
        }
    }

    fn call(
        &self,
        name: &str,
        family: Option<&str>,
        args: &[Argument],
        inside: &Arguments,
    ) -> Option<Sum> {
        let reduction = names::reduction(name, args.len()).is_some();
        let function = self.source.library.function(name, false);
        if let (Some(f), false) = (function, reduction) {
            let given: Vec<Sum> = args
                .iter()
                .map(|a| self.read_in(&a.value, inside))
                .collect::<Option<_>>()?;
            let still = given.iter().all(|g| !self.sum_moves(g));
            if still
                && given
                    .iter()
                    .all(|g| is_scalar(g.shape()) && g.home() == Home::Constant)
            {
                return Some(Atom::call(name, given, Shape::Scalar).sum());
            }
            let named = f.params.iter().map(|p| p.text.clone()).zip(given).collect();
            return self.read_in(&f.body, &named);
        }
        if name == "ball" || name == "under" {
            // Of the reference: as it stands.
            let shape = match (name, args.get(1)) {
                ("under", Some(a)) => self.read_in(&a.value, inside)?.shape(),
                _ => Shape::Scalar,
            };
            let all: Vec<Sum> = args
                .iter()
                .map(|a| self.read_in(&a.value, inside))
                .collect::<Option<_>>()?;
            let home = if name == "ball" {
                Home::Constant
            } else {
                Home::Node
            };
            let atom = Atom {
                kind: Kind::Call(name.into(), None, all),
                shape,
                home,
            };
            return Some(atom.sum());
        }
        let mut all: Vec<Sum> = args
            .iter()
            .map(|a| self.read_in(&a.value, inside))
            .collect::<Option<_>>()?;
        if reduction {
            let inner = all.pop()?;
            return match name {
                "sum" | "sum0" => summed(name, family, &inner),
                "mean" if self.sum_moves(&inner) => {
                    let volume = summed("sum", family, &Sum::int(1))?;
                    summed("sum", family, &inner)?.over(&volume)
                }
                _ => {
                    let atom = Atom {
                        kind: Kind::Call(
                            name.into(),
                            family.map(String::from),
                            vec![inner.clone()],
                        ),
                        shape: match inner.shape() {
                            Shape::Boolean => Shape::Scalar,
                            shape => shape,
                        },
                        home: Home::Node,
                    };
                    Some(atom.sum())
                }
            };
        }
        let shape = all.first()?.shape();
        match name {
            "dot" => dot(&all[0], all.get(1)?),
            "outer" => outer(&all[0], all.get(1)?),
            "transpose" => all[0].transposed(),
            "sym" => all[0].mapped("sym", Shape::Symmetric),
            "tr" => all[0].mapped("tr", Shape::Scalar),
            "dev" => all[0].mapped("dev", shape),
            "inverse" => Some(Atom::call(name, all, shape).sum()),
            "diag" if shape == Shape::Vector => Some(Atom::call(name, all, Shape::Symmetric).sum()),
            "diag" => Some(Atom::call(name, all, Shape::Vector).sum()),
            "norm" | "det" | "sqrt" | "abs" | "exp" | "ln" | "sin" | "cos" | "tan" | "min"
            | "max" | "select" => Some(Atom::call(name, all, Shape::Scalar).sum()),
            _ => None,
        }
    }

    /// Whether the value follows the deformation.
    pub(super) fn sum_moves(&self, sum: &Sum) -> bool {
        sum.0.iter().any(|p| {
            p.scalars.iter().any(|(a, _)| self.atom_moves(a))
                || p.tensors.iter().any(|a| self.atom_moves(a))
        })
    }

    pub(super) fn atom_moves(&self, atom: &Atom) -> bool {
        match &atom.kind {
            Kind::Name(name) => self.is_moving(name),
            Kind::Call(name, ..) if ["under", "ball", "count"].contains(&name.as_str()) => false,
            Kind::Not(_) | Kind::Compare(..) | Kind::Logic(..) => false,
            Kind::Call(_, _, args) | Kind::Vector(args) => args.iter().any(|a| self.sum_moves(a)),
            Kind::Prime(a) => self.atom_moves(a),
            Kind::Sum(a) | Kind::Component(a, _) => self.sum_moves(a),
            Kind::Power(a, b) => self.sum_moves(a) || self.sum_moves(b),
            Kind::Written(e) => self.moves(e),
        }
    }

    /// The same from the other end of the bond.
    pub(super) fn primed(&self, sum: &Sum) -> Option<Sum> {
        let mut all = Sum::ZERO;
        for p in &sum.0 {
            let mut product = Sum::number(p.number);
            for (atom, power) in &p.scalars {
                product = product.times(&self.primed_atom(atom)?.power(*power)?)?;
            }
            for atom in &p.tensors {
                product = product.times(&self.primed_atom(atom)?)?;
            }
            all = all.plus(&product)?;
        }
        Some(all)
    }

    fn primed_atom(&self, atom: &Atom) -> Option<Sum> {
        let same = || Some(atom.clone().sum());
        if atom.home == Home::Constant || atom.is("dt") {
            return same();
        }
        match &atom.kind {
            Kind::Name(name) if self.is_prelude(name) && EVEN.contains(&name.as_str()) => same(),
            Kind::Name(name) if self.law.influences.iter().any(|i| i.name == *name) => same(),
            Kind::Name(name) if self.is_prelude(name) && ODD.contains(&name.as_str()) => {
                atom.clone().sum().scaled(Ratio::int(-1))
            }
            Kind::Prime(inner) => Some((**inner).clone().sum()),
            Kind::Sum(inner) => Sum::int(1).times(&self.primed(inner)?),
            _ => Some(
                Atom {
                    kind: Kind::Prime(Box::new(atom.clone())),
                    shape: atom.shape,
                    home: Home::Bond,
                }
                .sum(),
            ),
        }
    }
}

fn constant(e: &Expr) -> Atom {
    Atom {
        kind: Kind::Written(e.clone()),
        shape: Shape::Scalar,
        home: Home::Constant,
    }
}

pub(super) fn scalar(kind: Kind, home: Home) -> Sum {
    Sum(vec![Product {
        number: Ratio::ONE,
        scalars: vec![(
            Atom {
                kind,
                shape: Shape::Scalar,
                home,
            },
            Ratio::ONE,
        )],
        tensors: vec![],
    }])
}

pub(super) fn boolean(kind: Kind, home: Home) -> Sum {
    Atom {
        kind,
        shape: Shape::Boolean,
        home,
    }
    .sum()
}

pub(super) fn vector(parts: Vec<Sum>) -> Sum {
    let home = parts.iter().map(Sum::home).max().unwrap_or(Home::Constant);
    Atom {
        kind: Kind::Vector(parts),
        shape: Shape::Vector,
        home,
    }
    .sum()
}
