//! One tape: operands before use, types, inputs that exist and may stand there, nothing that nobody reads.

use std::collections::BTreeSet;

use super::Report;
use crate::tape::{Op, Tape, operands};

/// Where a tape stands decides what it may read and do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Place {
    Influence,
    Meet,
    Constants,
    Ball,
    Filter,
    Geometry,
    FromStreams,
    Pre,
    Bond,
    Post,
}

/// What a tape reads and writes outside of its registers.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Port {
    Const,
    Param,
    Var,
    Omega,
    Own,
    Nbr,
    Geo,
    Pre,
    Acc,
    History,
    Axis,
    AddTo,
    MaxTo,
    Put,
    Kill,
}

pub(super) type Ports = BTreeSet<(Port, u32)>;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Number,
    Truth,
    Effect,
}

fn kind(op: &Op, kinds: &[Kind]) -> Kind {
    match op {
        Op::Lt(..) | Op::Le(..) | Op::And(..) | Op::Or(..) | Op::Not(_) => Kind::Truth,
        Op::Kill(_) | Op::AddTo(..) | Op::MaxTo(..) | Op::PutHistory(..) => Kind::Effect,
        Op::Case(r) => kinds.get(r[0] as usize).copied().unwrap_or(Kind::Number),
        _ => Kind::Number,
    }
}

/// The kind that operand number `n` must have; none where the operands must be alike.
fn wanted(op: &Op, n: usize) -> Option<Kind> {
    match op {
        Op::And(..) | Op::Or(..) | Op::Not(_) | Op::Kill(_) => Some(Kind::Truth),
        Op::Select(..) if n == 0 => Some(Kind::Truth),
        Op::Case(_) => None,
        _ => Some(Kind::Number),
    }
}

/// The port of an operation, and where it may stand.
fn port(op: &Op) -> Option<(Port, u32, &'static [Place])> {
    use Place::*;
    Some(match *op {
        Op::Const(k) => (Port::Const, k, &[Filter, Geometry, Pre, Post]),
        Op::Param(k) => (Port::Param, k, &[Constants, Ball]),
        Op::Var(k) => (Port::Var, k, &[Influence, Meet]),
        Op::Omega(k) => (Port::Omega, k, &[Ball, Filter, Geometry]),
        Op::Own(k) => (Port::Own, k, &[Pre, Post]),
        Op::Nbr(k) => (Port::Nbr, k, &[Bond]),
        Op::Geo(k) => (Port::Geo, k, &[Bond, FromStreams]),
        Op::Pre(k) => (Port::Pre, k, &[Bond, Post]),
        Op::Acc(k) => (Port::Acc, k, &[Post]),
        Op::History(k) | Op::Reverse(k) => (Port::History, k, &[Bond]),
        Op::Xi(a) => (Port::Axis, a.into(), &[Filter, Geometry, FromStreams, Bond]),
        Op::Eta(a) => (Port::Axis, a.into(), &[Bond]),
        Op::AddTo(k, ..) => (Port::AddTo, k, &[Bond]),
        Op::MaxTo(k, _) => (Port::MaxTo, k, &[Bond]),
        Op::PutHistory(k, _) => (Port::Put, k, &[Bond]),
        Op::Kill(_) => (Port::Kill, 0, &[Bond]),
        _ => return None,
    })
}

/// Where what is no port may stand; none: anywhere.
fn places(op: &Op) -> Option<&'static [Place]> {
    use Place::*;
    match op {
        Op::Delta => Some(&[Influence, Constants, Ball]),
        Op::Ball(_) => Some(&[Constants]),
        Op::Case(_) => Some(&[Constants, Ball]),
        Op::X => Some(&[Ball, Filter, Geometry]),
        Op::Weight => Some(&[Filter, Geometry]),
        Op::Ix => Some(&[Bond, FromStreams]),
        _ => port(op).map(|(.., places)| places),
    }
}

/// Checks a tape; `limit` is the number of inputs of a kind.
pub(super) fn check(
    report: &mut Report,
    tape: &Tape,
    place: Place,
    limit: &dyn Fn(Port) -> usize,
) -> Ports {
    let mut ports = Ports::new();
    let mut kinds: Vec<Kind> = Vec::new();
    for (n, op) in tape.ops.iter().enumerate() {
        if places(op).is_some_and(|p| !p.contains(&place)) {
            report.add(format!(
                "{place:?} operation {n}: {op:?} may not stand there"
            ));
        }
        if let Some((kind, k, _)) = port(op) {
            ports.insert((kind, k));
            if kind != Port::Kill && k as usize >= limit(kind) {
                report.add(format!("{place:?} operation {n}: {op:?} does not exist"));
            }
        }
        if let Op::Ball(inner) = op {
            ports.extend(check(report, inner, Place::Ball, limit));
            if inner.outs.len() != 1 {
                report.add(format!(
                    "operation {n}: an integral of {} values",
                    inner.outs.len()
                ));
            }
        }
        let read = operands(op);
        let early = read.iter().any(|r| *r as usize >= n);
        if early {
            report.add(format!(
                "{place:?} operation {n}: {op:?} reads what comes later"
            ));
        } else {
            let first = read.first().map(|r| kinds[*r as usize]);
            let fits = |(m, r): (usize, &u32)| {
                let found = kinds[*r as usize];
                found != Kind::Effect && Some(found) == wanted(op, m).or(first)
            };
            if !read.iter().enumerate().all(fits) {
                report.add(format!(
                    "{place:?} operation {n}: {op:?} has an operand of the wrong type"
                ));
            }
        }
        kinds.push(kind(op, &kinds));
    }
    let answer = if place == Place::Filter {
        Kind::Truth
    } else {
        Kind::Number
    };
    for r in &tape.outs {
        if kinds.get(*r as usize) != Some(&answer) {
            report.add(format!(
                "{place:?} output register {r} is missing or of the wrong type"
            ));
        }
    }
    dead(report, tape, place, &kinds);
    ports
}

/// Every operation leads to an output or an effect.
fn dead(report: &mut Report, tape: &Tape, place: Place, kinds: &[Kind]) {
    let mut live = vec![false; tape.ops.len()];
    for r in &tape.outs {
        if let Some(l) = live.get_mut(*r as usize) {
            *l = true;
        }
    }
    for n in (0..tape.ops.len()).rev() {
        if live[n] || kinds[n] == Kind::Effect {
            live[n] = true;
            for r in operands(&tape.ops[n]) {
                if let Some(l) = live.get_mut(r as usize) {
                    *l = true;
                }
            }
        } else {
            report.add(format!(
                "{place:?} operation {n}: {:?} is read by nobody",
                tape.ops[n]
            ));
        }
    }
}
