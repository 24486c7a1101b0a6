//! Lowered and derived: normal forms, homes and times of what a law answers.

use super::Report;
use crate::ir::Home;
use crate::poly::{Algebra, Atom, AtomId, Func, Poly, Rate};
use crate::schedule::Responses;

pub(super) fn check(algebra: &Algebra, r: &Responses) -> Vec<String> {
    let mut report = Report::default();
    for (k, atom) in algebra.atoms().iter().enumerate() {
        report.at(format!("atom {k}"));
        for p in parts(atom) {
            normal(&mut report, algebra, p, k);
        }
        match atom {
            Atom::Prime(a) if a.0 as usize >= k => {
                report.add("the other end of a later atom".into())
            }
            Atom::Sum(_, _, body) if algebra.nature_of(body).home == Home::Node => {
                report.add("a sum of a value of the node".into());
            }
            Atom::Ball(body) if algebra.nature_of(body).rate != Rate::Reference => {
                report.add("an integral over what moves".into());
            }
            _ => {}
        }
    }
    let named = r
        .named
        .iter()
        .flat_map(|(n, ps)| ps.iter().map(move |p| (n.as_str(), p)));
    let answers = r.force.iter().map(|p| ("force", p));
    let rates = r
        .rates
        .iter()
        .flat_map(|r| [("rate", &r.drive), ("damping", &r.damping)]);
    let after_step = r.after_step.iter().map(|p| ("after step", p));
    let answers = answers
        .chain(rates)
        .chain(after_step)
        .chain(r.energy.iter().map(|p| ("energy", p)))
        .chain(named)
        .chain(r.parts.iter().map(|p| ("part of the body", p)));
    let answers = answers.chain(r.node_updates.iter().map(|(_, p)| ("update", p)));
    let bonds = r
        .bond_updates
        .iter()
        .map(|(_, _, p)| ("update of bonds", p));
    let breaks = r
        .breaks
        .iter()
        .chain(&r.late_breaks)
        .map(|(_, p)| ("break", p));
    for (name, p) in answers.chain(bonds.clone()).chain(breaks.clone()) {
        report.at(name.into());
        normal(&mut report, algebra, p, algebra.atoms().len());
        if algebra.nature_of(p).rate == Rate::Tangent {
            report.add("depends on the increment of the tangent".into());
        }
        let of_bonds = name == "break" || name == "update of bonds";
        if !of_bonds && algebra.nature_of(p).home == Home::Bond {
            report.add("is a value of a bond".into());
        }
    }
    for (_, p) in breaks {
        report.at("break".into());
        if !p.as_atom().is_some_and(|a| algebra.is_truth(a)) {
            report.add("is no condition".into());
        }
    }
    for p in &r.weights {
        report.at("weight".into());
        normal(&mut report, algebra, p, algebra.atoms().len());
        if algebra.nature_of(p).rate != Rate::Reference {
            report.add("is not of the reference body".into());
        }
    }
    for p in &r.tangent {
        report.at("tangent".into());
        normal(&mut report, algebra, p, algebra.atoms().len());
        if !linear(algebra, p) {
            report.add("is not linear in the increment".into());
        }
    }
    if !r.tangent.is_empty() && r.tangent.len() != r.force.len() {
        report.at("tangent".into());
        report.add(format!(
            "{} components of {} forces",
            r.tangent.len(),
            r.force.len()
        ));
    }
    report.found
}

fn parts(atom: &Atom) -> Vec<&Poly> {
    match atom {
        Atom::Case(ps) | Atom::Func(_, ps) => ps.iter().collect(),
        Atom::Ball(p) | Atom::Sum(_, _, p) | Atom::Named(_, p) => vec![p],
        _ => vec![],
    }
}

/// Terms and factors in order and different, no zeros, nothing but atoms below `end`.
fn normal(report: &mut Report, algebra: &Algebra, p: &Poly, end: usize) {
    if p.0.windows(2).any(|w| w[0].0 >= w[1].0) {
        report.add("terms are out of order or equal".into());
    }
    for (m, c) in &p.0 {
        if c.is_zero() {
            report.add("a term is zero".into());
        }
        if m.0.windows(2).any(|w| w[0].0 >= w[1].0) || m.0.iter().any(|(_, n)| *n == 0) {
            report.add("factors are out of order, or to the power of zero".into());
        }
        if m.0
            .iter()
            .any(|(a, _)| a.0 as usize >= end.min(algebra.atoms().len()))
        {
            report.add("refers to an atom that comes later".into());
        }
    }
}

fn linear(algebra: &Algebra, p: &Poly) -> bool {
    p.0.iter().all(|(m, _)| {
        let moved = |(a, _): &&(AtomId, i32)| algebra.nature(*a).rate == Rate::Tangent;
        let mut factors = m.0.iter().filter(moved);
        match (factors.next(), factors.next()) {
            (Some((a, 1)), None) => linear_atom(algebra, *a),
            _ => false,
        }
    })
}

fn linear_atom(algebra: &Algebra, id: AtomId) -> bool {
    match algebra.atom(id) {
        Atom::DEta(_) => true,
        Atom::Sum(r, _, body) => !r.is_extreme() && linear(algebra, body),
        Atom::Named(_, p) => linear(algebra, p),
        Atom::Prime(a) => linear_atom(algebra, *a),
        Atom::Func(Func::Select, args) => {
            algebra.nature_of(&args[0]).rate != Rate::Tangent
                && args[1..].iter().all(|p| linear(algebra, p))
        }
        _ => false,
    }
}
