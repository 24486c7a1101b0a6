//! Checking a tape for its place: inputs that there are, operands that are defined and of the right kind.
use super::{TapeError, operands};
use crate::body::Flavour;
use crate::spec::{Op, Tape};

/// Where a tape stands decides what it may read and do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Expression,
    Influence,
    Constants,
    Ball,
    Geometry,
    Filter,
    Pre,
    Bond,
    Post,
}

/// How many of each input there are.
#[derive(Clone, Debug, Default)]
pub(crate) struct Limits {
    pub dim: usize,
    pub variables: usize,
    pub params: usize,
    pub influences: usize,
    pub constants: usize,
    pub own: usize,
    pub nbr: usize,
    pub geometry: usize,
    pub pre: usize,
    pub accumulators: usize,
    pub history: usize,
    pub kills: bool,
    pub updates: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Truth,
    Effect,
}

/// Register aliases (a flavour case is the register it chooses) and the kind of every register.
pub(super) struct Checked {
    pub alias: Vec<usize>,
    pub kinds: Vec<Kind>,
}

pub(super) struct Checker<'a> {
    pub tape: &'a Tape,
    pub place: Place,
    pub limits: &'a Limits,
    pub flavour: Flavour,
}

impl Checker<'_> {
    pub fn check(&self) -> Result<Checked, TapeError> {
        let mut c = Checked {
            alias: vec![],
            kinds: vec![],
        };
        for (n, op) in self.tape.ops.iter().enumerate() {
            self.check_input(op)
                .map_err(|e| TapeError(format!("operation {n}: {e}")))?;
            for r in operands(op) {
                if r as usize >= n {
                    return Err(TapeError(format!(
                        "operation {n} reads register {r} before it is defined"
                    )));
                }
            }
            let alias = match op {
                Op::Case(r) => c.alias[r[flavour_index(self.flavour)] as usize],
                _ => n,
            };
            c.alias.push(alias);
            let kind = if alias == n { kind(op) } else { c.kinds[alias] };
            c.kinds.push(kind);
            check_kinds(op, &c.kinds).map_err(|()| {
                TapeError(format!("operation {n} has an operand of the wrong kind"))
            })?;
        }
        let wanted = if self.place == Place::Filter {
            Kind::Truth
        } else {
            Kind::Number
        };
        for &r in &self.tape.outs {
            match c.kinds.get(r as usize) {
                Some(&k) if k == wanted => {}
                _ => {
                    return Err(TapeError(format!(
                        "output register {r} is missing or of the wrong kind"
                    )));
                }
            }
        }
        Ok(c)
    }

    /// Inputs and effects must exist and be allowed in this place.
    fn check_input(&self, op: &Op) -> Result<(), String> {
        use Place::*;
        let l = self.limits;
        let reference = [Geometry, Filter];
        let (places, k, n): (&[Place], usize, usize) = match *op {
            Op::Const(k) => (&[Geometry, Filter, Pre, Post], k as usize, l.constants),
            Op::Param(k) => (&[Constants, Ball], k as usize, l.params),
            Op::Var(k) => (&[Expression, Influence], k as usize, l.variables),
            Op::Delta => (&[Constants, Influence, Ball], 0, 1),
            Op::Own(k) => (&[Pre, Post], k as usize, l.own),
            Op::Nbr(k) => (&[Bond], k as usize, l.nbr),
            Op::Geo(k) => (&[Bond], k as usize, l.geometry),
            Op::Pre(k) => (&[Bond, Post], k as usize, l.pre),
            Op::Acc(k) => (&[Post], k as usize, l.accumulators),
            Op::History(k) | Op::Reverse(k) => (&[Bond], k as usize, l.history),
            Op::Xi(a) => (&[Geometry, Filter, Bond], a as usize, l.dim),
            Op::Eta(a) => (&[Bond], a as usize, l.dim),
            Op::Ix => (&[Bond], 0, 1),
            Op::X => (&[Geometry, Filter, Ball], 0, 1),
            Op::Omega(k) => (&[Geometry, Filter, Ball], k as usize, l.influences),
            Op::Weight => (&reference, 0, 1),
            Op::Ball(_) => (&[Constants], 0, 1),
            Op::Kill(_) => (&[Bond], 0, l.kills as usize),
            Op::AddTo(k, ..) | Op::MaxTo(k, _) => (&[Bond], k as usize, l.accumulators),
            Op::PutHistory(k, _) if l.updates => (&[Bond], k as usize, l.history),
            Op::PutHistory(..) => (&[], 0, 0),
            _ => return Ok(()),
        };
        match (places.contains(&self.place), k < n) {
            (true, true) => Ok(()),
            (true, false) => Err(format!("{op:?} is out of range (there are {n})")),
            (false, _) => Err(format!("{op:?} may not stand in a {:?} tape", self.place)),
        }
    }
}

/// Position of a flavour in `Op::Case`.
fn flavour_index(f: Flavour) -> usize {
    match f {
        Flavour::Bar => 0,
        Flavour::Slab => 1,
        Flavour::PlaneStress => 2,
        Flavour::PlaneStrain => 3,
        Flavour::Solid => 4,
    }
}

fn kind(op: &Op) -> Kind {
    match op {
        Op::Lt(..) | Op::Le(..) | Op::And(..) | Op::Or(..) | Op::Not(_) => Kind::Truth,
        Op::Kill(_) | Op::AddTo(..) | Op::MaxTo(..) | Op::PutHistory(..) => Kind::Effect,
        _ => Kind::Number,
    }
}

/// Truth values go where truth values belong, numbers everywhere else.
fn check_kinds(op: &Op, kinds: &[Kind]) -> Result<(), ()> {
    for (position, r) in operands(op).into_iter().enumerate() {
        let found = kinds[r as usize];
        let fits = match op {
            Op::And(..) | Op::Or(..) | Op::Not(_) | Op::Kill(_) => found == Kind::Truth,
            Op::Select(..) if position == 0 => found == Kind::Truth,
            Op::Case(_) => found == kinds[kinds.len() - 1],
            _ => found == Kind::Number,
        };
        if !fits {
            return Err(());
        }
    }
    Ok(())
}
