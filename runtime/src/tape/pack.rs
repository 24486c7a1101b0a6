//! Packing a checked tape: dead operations go, flavour cases resolve, registers are reused.
//!
//! The tape of a bond runs over blocks of bonds. What is the same for all of them, and what a traversal hands over
//! bond by bond, has its registers before the first operation ([`Filled`]).
use super::check::{Checked, Checker, Kind};
use super::{Code, Limits, Place, TapeError};
use crate::body::Flavour;
use crate::spec::{Op, SweepSpec, Tape};

/// An input of a tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Leaf {
    Const,
    Param,
    Var,
    Delta,
    Own,
    Nbr,
    Geo,
    Pre,
    Acc,
    History,
    Reverse,
    Xi,
    Eta,
    Ix,
    X,
    Omega,
    Weight,
    Ball,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum One {
    Neg,
    Abs,
    Sqrt,
    Rsqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Two {
    Add,
    Sub,
    Mul,
    Div,
    Min,
    Max,
    Pow,
}

/// Registers of a bond tape that are filled before it runs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Filled {
    /// Literals and prologue values, once for all bonds of a node.
    pub same: Vec<Step>,
    /// By component: xi, eta, and xi + eta.
    pub xi: Option<[u8; 3]>,
    pub eta: Option<[u8; 3]>,
    pub y: Option<[u8; 3]>,
    /// 1/|xi|.
    pub ix: Option<u8>,
}

/// One instruction; the first register is the target. Numbers and truth values have registers of their own.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step {
    Lit(u8, f64),
    Leaf(u8, Leaf, u16),
    One(u8, One, u8),
    Two(u8, Two, u8, u8),
    Fma(u8, u8, u8, u8),
    Powi(u8, u8, i32),
    Select(u8, u8, u8, u8),
    Lt(u8, u8, u8),
    Le(u8, u8, u8),
    And(u8, u8, u8),
    Or(u8, u8, u8),
    Not(u8, u8),
    Kill(u8),
    AddTo(u8, u8, u8),
    MaxTo(u8, u8),
    PutHistory(u8, u8),
}

impl Code {
    /// Whether it reads a parameter of those that `asked` names.
    pub(crate) fn reads(&self, asked: &impl Fn(usize) -> bool) -> bool {
        let mut steps = self.steps.iter();
        steps.any(|step| matches!(*step, Step::Leaf(_, Leaf::Param, k) if asked(k as usize)))
    }

    /// Checks `tape` for its place and packs it.
    pub(crate) fn new(
        tape: &Tape,
        place: Place,
        limits: &Limits,
        flavour: Flavour,
    ) -> Result<Code, TapeError> {
        let checked = Checker {
            tape,
            place,
            limits,
            flavour,
        }
        .check()?;
        Packer::new(tape, checked, place).pack(limits, flavour)
    }
}

/// What a traversal hands over for a bond: component of a vector, or 1/|xi|.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Given {
    Xi(u8),
    Eta(u8),
    /// xi + eta: an addition in the tape, one value to the traversal.
    Y(u8),
    Ix,
}

/// Registers that an operation reads.
pub(crate) fn operands(op: &Op) -> Vec<u32> {
    let mut op = op.clone();
    operands_mut(&mut op).into_iter().map(|r| *r).collect()
}

fn operands_mut(op: &mut Op) -> Vec<&mut u32> {
    match op {
        Op::Case(r) => r.iter_mut().collect(),
        Op::Add(a, b)
        | Op::Sub(a, b)
        | Op::Mul(a, b)
        | Op::Div(a, b)
        | Op::Min(a, b)
        | Op::Max(a, b)
        | Op::Pow(a, b)
        | Op::Lt(a, b)
        | Op::Le(a, b)
        | Op::And(a, b)
        | Op::Or(a, b)
        | Op::AddTo(_, a, b) => vec![a, b],
        Op::Fma(a, b, c) | Op::Select(a, b, c) => vec![a, b, c],
        Op::Neg(a)
        | Op::Abs(a)
        | Op::Sqrt(a)
        | Op::Rsqrt(a)
        | Op::Exp(a)
        | Op::Ln(a)
        | Op::Sin(a)
        | Op::Cos(a)
        | Op::Tan(a)
        | Op::Powi(a, _)
        | Op::Not(a)
        | Op::Kill(a)
        | Op::MaxTo(_, a)
        | Op::PutHistory(_, a) => vec![a],
        _ => vec![],
    }
}

/// The bond tape of a sweep in a cloud: forms its reference-bond values from the streams, which it reads in their place.
pub(crate) fn with_streams(s: &SweepSpec) -> Result<Tape, TapeError> {
    let formed = &s.from_streams;
    let mut ops = formed.ops.clone();
    let by = ops.len() as u32;
    for op in &s.bond.ops {
        let mut op = op.clone();
        if let Op::Geo(k) = op {
            let value = formed
                .outs
                .get(k as usize)
                .ok_or_else(|| TapeError(format!("no streams give reference-bond value {k}")))?;
            // Another name of a register.
            op = Op::Case([*value; 5]);
        } else {
            for r in operands_mut(&mut op) {
                *r += by;
            }
        }
        ops.push(op);
    }
    let outs = s.bond.outs.iter().map(|r| r + by).collect();
    Ok(Tape { ops, outs })
}

/// Gives live values registers of one kind; a register is free after the last reader.
struct Pool {
    free: Vec<u8>,
    next: usize,
}

impl Pool {
    fn take(&mut self) -> Result<u8, TapeError> {
        if let Some(r) = self.free.pop() {
            return Ok(r);
        }
        let r = u8::try_from(self.next).map_err(|_| {
            TapeError("more than 256 values are alive at once; compile the law".into())
        })?;
        self.next += 1;
        Ok(r)
    }
}

struct Packer<'a> {
    tape: &'a Tape,
    checked: Checked,
    in_blocks: bool,
    /// Last operation that reads a register; none for dead ones, the length of the tape for outputs.
    last: Vec<Option<usize>>,
    place: Vec<u8>,
    numbers: Pool,
    truths: Pool,
}

impl<'a> Packer<'a> {
    fn new(tape: &'a Tape, checked: Checked, place: Place) -> Packer<'a> {
        let n = tape.ops.len();
        let pool = || Pool {
            free: vec![],
            next: 0,
        };
        let mut p = Packer {
            tape,
            checked,
            in_blocks: place == Place::Bond,
            last: vec![None; n],
            place: vec![0; n],
            numbers: pool(),
            truths: pool(),
        };
        for &r in &tape.outs {
            p.last[p.checked.alias[r as usize]] = Some(n);
        }
        for k in (0..n).rev() {
            if !p.runs(k) || p.given(k).is_some() {
                continue;
            }
            for r in operands(&tape.ops[k]) {
                let slot = &mut p.last[p.checked.alias[r as usize]];
                *slot = Some(slot.map_or(k, |l| l.max(k)));
            }
        }
        p
    }

    /// Neither dead nor another name of a register.
    fn runs(&self, k: usize) -> bool {
        let live = self.last[k].is_some() || self.checked.kinds[k] == Kind::Effect;
        self.checked.alias[k] == k && live
    }

    /// The same for all bonds of a node.
    fn same(&self, k: usize) -> bool {
        self.in_blocks && matches!(self.tape.ops[k], Op::Lit(_) | Op::Inf | Op::Pre(_))
    }

    fn given(&self, k: usize) -> Option<Given> {
        let op = |k: u32| &self.tape.ops[self.checked.alias[k as usize]];
        match self.tape.ops[k] {
            _ if !self.in_blocks => None,
            Op::Xi(a) => Some(Given::Xi(a)),
            Op::Eta(a) => Some(Given::Eta(a)),
            Op::Ix => Some(Given::Ix),
            Op::Add(a, b) => match (op(a), op(b)) {
                (Op::Xi(c), Op::Eta(d)) | (Op::Eta(d), Op::Xi(c)) if c == d => Some(Given::Y(*c)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Registers that are filled before the tape runs. They are never free.
    fn fill(&mut self) -> Result<Filled, TapeError> {
        let mut filled = Filled::default();
        let n = self.tape.ops.len();
        for k in 0..n {
            if !self.runs(k) {
                continue;
            }
            if let Some(given) = self.given(k) {
                self.place[k] = self.hand_over(&mut filled, given)?;
            } else if self.same(k) {
                self.place[k] = self.numbers.take()?;
                let op = &self.tape.ops[k];
                filled.same.push(step(op, self.place[k], &[]));
            } else {
                continue;
            }
            self.last[k] = Some(n);
        }
        Ok(filled)
    }

    fn hand_over(&mut self, filled: &mut Filled, given: Given) -> Result<u8, TapeError> {
        let (vector, a) = match given {
            Given::Xi(a) => (&mut filled.xi, a),
            Given::Eta(a) => (&mut filled.eta, a),
            Given::Y(a) => (&mut filled.y, a),
            Given::Ix => {
                let r = filled.ix.map_or_else(|| self.numbers.take(), Ok)?;
                filled.ix = Some(r);
                return Ok(r);
            }
        };
        if vector.is_none() {
            let mut fresh = || self.numbers.take();
            *vector = Some([fresh()?, fresh()?, fresh()?]);
        }
        Ok(vector.map_or(0, |v| v[a as usize]))
    }

    fn pack(mut self, limits: &Limits, flavour: Flavour) -> Result<Code, TapeError> {
        let mut code = Code {
            filled: self.fill()?,
            ..Code::default()
        };
        for k in 0..self.tape.ops.len() {
            if !self.runs(k) || self.same(k) || self.given(k).is_some() {
                continue;
            }
            let op = &self.tape.ops[k];
            let sources: Vec<u8> = operands(op)
                .iter()
                .map(|&r| self.place[self.checked.alias[r as usize]])
                .collect();
            self.release(op, k);
            let target = match self.checked.kinds[k] {
                Kind::Number => self.numbers.take()?,
                Kind::Truth => self.truths.take()?,
                Kind::Effect => 0,
            };
            self.place[k] = target;
            if let Op::Ball(inner) = op {
                let inner = Code::new(inner, Place::Ball, limits, flavour)?;
                if inner.outs.len() != 1 {
                    return Err(TapeError("a ball integral must have one output".into()));
                }
                code.balls.push(inner);
                code.steps.push(Step::Leaf(
                    target,
                    Leaf::Ball,
                    (code.balls.len() - 1) as u16,
                ));
            } else {
                code.steps.push(step(op, target, &sources));
            }
        }
        code.registers = self.numbers.next.max(self.truths.next);
        code.outs = self
            .tape
            .outs
            .iter()
            .map(|&r| self.place[self.checked.alias[r as usize]])
            .collect();
        Ok(code)
    }

    /// Frees the registers that operation `k` reads for the last time.
    fn release(&mut self, op: &Op, k: usize) {
        let mut freed: Vec<usize> = vec![];
        for r in operands(op) {
            let r = self.checked.alias[r as usize];
            if self.last[r] == Some(k) && !freed.contains(&r) {
                freed.push(r);
                match self.checked.kinds[r] {
                    Kind::Number => self.numbers.free.push(self.place[r]),
                    Kind::Truth => self.truths.free.push(self.place[r]),
                    Kind::Effect => {}
                }
            }
        }
    }
}

/// The packed form; `s` are the packed operands.
fn step(op: &Op, d: u8, s: &[u8]) -> Step {
    let one = |f| Step::One(d, f, s[0]);
    let two = |f| Step::Two(d, f, s[0], s[1]);
    let leaf = |leaf, k: u32| Step::Leaf(d, leaf, k as u16);
    match *op {
        Op::Lit(v) => Step::Lit(d, v),
        Op::Inf | Op::Case(_) | Op::Ball(_) => Step::Lit(d, f64::INFINITY),
        Op::Const(k) => leaf(Leaf::Const, k),
        Op::Param(k) => leaf(Leaf::Param, k),
        Op::Var(k) => leaf(Leaf::Var, k),
        Op::Delta => leaf(Leaf::Delta, 0),
        Op::Own(k) => leaf(Leaf::Own, k),
        Op::Nbr(k) => leaf(Leaf::Nbr, k),
        Op::Geo(k) => leaf(Leaf::Geo, k),
        Op::Pre(k) => leaf(Leaf::Pre, k),
        Op::Acc(k) => leaf(Leaf::Acc, k),
        Op::History(k) => leaf(Leaf::History, k),
        Op::Reverse(k) => leaf(Leaf::Reverse, k),
        Op::Xi(a) => leaf(Leaf::Xi, a as u32),
        Op::Eta(a) => leaf(Leaf::Eta, a as u32),
        Op::Ix => leaf(Leaf::Ix, 0),
        Op::X => leaf(Leaf::X, 0),
        Op::Omega(k) => leaf(Leaf::Omega, k),
        Op::Weight => leaf(Leaf::Weight, 0),
        Op::Add(..) => two(Two::Add),
        Op::Sub(..) => two(Two::Sub),
        Op::Mul(..) => two(Two::Mul),
        Op::Div(..) => two(Two::Div),
        Op::Min(..) => two(Two::Min),
        Op::Max(..) => two(Two::Max),
        Op::Pow(..) => two(Two::Pow),
        Op::Fma(..) => Step::Fma(d, s[0], s[1], s[2]),
        Op::Neg(_) => one(One::Neg),
        Op::Abs(_) => one(One::Abs),
        Op::Sqrt(_) => one(One::Sqrt),
        Op::Rsqrt(_) => one(One::Rsqrt),
        Op::Exp(_) => one(One::Exp),
        Op::Ln(_) => one(One::Ln),
        Op::Sin(_) => one(One::Sin),
        Op::Cos(_) => one(One::Cos),
        Op::Tan(_) => one(One::Tan),
        Op::Powi(_, n) => Step::Powi(d, s[0], n),
        Op::Lt(..) => Step::Lt(d, s[0], s[1]),
        Op::Le(..) => Step::Le(d, s[0], s[1]),
        Op::And(..) => Step::And(d, s[0], s[1]),
        Op::Or(..) => Step::Or(d, s[0], s[1]),
        Op::Not(_) => Step::Not(d, s[0]),
        Op::Select(..) => Step::Select(d, s[0], s[1], s[2]),
        Op::Kill(_) => Step::Kill(s[0]),
        Op::AddTo(k, ..) => Step::AddTo(k as u8, s[0], s[1]),
        Op::MaxTo(k, _) => Step::MaxTo(k as u8, s[0]),
        Op::PutHistory(k, _) => Step::PutHistory(k as u8, s[0]),
    }
}
