//! Runs a compiled law the plain way: each tape as written, over the oracle's explicit bond list.
//!
//! It stands between the oracle and the engine. Where it agrees with the oracle the compiler is right;
//! where the engine differs from it, a traversal is wrong.

use pdlang::ir;
use pdlang::oracle::{Ball, Body, State, Value, integrate};
use pdlang_runtime::spec::{InfluenceFn, Op, SlotKind, Spec, Stage, SweepSpec, Tape};

/// The choices of a scene, as the engine takes them.
pub struct Settings {
    pub flavour: ir::Flavour,
    pub params: Vec<f64>,
    pub influences: Vec<(InfluenceFn, Vec<f64>)>,
    pub horizon: f64,
    pub ball: Ball,
    /// Weights that are 1 instead of computed.
    pub without: Vec<String>,
}

/// A law on a body.
pub struct Plain<'a> {
    spec: &'a Spec,
    body: &'a Body,
    settings: &'a Settings,
    pub constants: Vec<f64>,
    /// Per slot and node.
    pub slots: Vec<Vec<f64>>,
    /// Per bond history or weight (their numbers in the spec) and bond.
    pub histories: Vec<Vec<f64>>,
    next_histories: Vec<Vec<f64>>,
    /// Per family and bond.
    pub intact: Vec<Vec<bool>>,
    member: Vec<Vec<bool>>,
    reverse: Vec<usize>,
}

/// What an operation may read, beside registers.
struct Read<'p, 'a> {
    plain: &'p Plain<'a>,
    constants: &'p [f64],
    node: usize,
    /// Reference vector, index and geometry of a bond.
    xi: [f64; 3],
    bond: Option<usize>,
    geo: &'p [f64],
    pre: &'p [f64],
    acc: &'p [f64],
    sweep: Option<&'p SweepSpec>,
    weight: f64,
}

/// What the effects of a bond tape did.
#[derive(Default)]
struct Effects {
    killed: bool,
    added: Vec<(u32, f64)>,
    raised: Vec<(u32, f64)>,
    put: Vec<(u32, f64)>,
}

fn tape_of(f: &InfluenceFn, values: &[f64], r: f64, horizon: f64) -> f64 {
    let mut regs: Vec<f64> = Vec::with_capacity(f.body.ops.len());
    for op in &f.body.ops {
        let value = match op {
            Op::Var(0) => r,
            Op::Var(k) => values[*k as usize - 1],
            Op::Delta => horizon,
            other => arithmetic(other, &regs),
        };
        regs.push(value);
    }
    regs[f.body.outs[0] as usize]
}

fn arithmetic(op: &Op, regs: &[f64]) -> f64 {
    let r = |k: &u32| regs[*k as usize];
    let truth = |b: bool| f64::from(u8::from(b));
    match op {
        Op::Lit(v) => *v,
        Op::Inf => f64::INFINITY,
        Op::Add(a, b) => r(a) + r(b),
        Op::Sub(a, b) => r(a) - r(b),
        Op::Mul(a, b) => r(a) * r(b),
        Op::Div(a, b) => r(a) / r(b),
        Op::Fma(a, b, c) => r(a).mul_add(r(b), r(c)),
        Op::Neg(a) => -r(a),
        Op::Abs(a) => r(a).abs(),
        Op::Min(a, b) => r(a).min(r(b)),
        Op::Max(a, b) => r(a).max(r(b)),
        Op::Sqrt(a) => r(a).sqrt(),
        Op::Rsqrt(a) => 1.0 / r(a).sqrt(),
        Op::Exp(a) => r(a).exp(),
        Op::Ln(a) => r(a).ln(),
        Op::Sin(a) => r(a).sin(),
        Op::Cos(a) => r(a).cos(),
        Op::Tan(a) => r(a).tan(),
        Op::Pow(a, b) => r(a).powf(r(b)),
        Op::Powi(a, n) => r(a).powi(*n),
        Op::Lt(a, b) => truth(r(a) < r(b)),
        Op::Le(a, b) => truth(r(a) <= r(b)),
        Op::And(a, b) => truth(r(a) != 0.0 && r(b) != 0.0),
        Op::Or(a, b) => truth(r(a) != 0.0 || r(b) != 0.0),
        Op::Not(a) => truth(r(a) == 0.0),
        Op::Select(c, a, b) => {
            if r(c) != 0.0 {
                r(a)
            } else {
                r(b)
            }
        }
        other => panic!("{other:?} is not arithmetic"),
    }
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

impl<'a> Plain<'a> {
    /// At rest: all bonds intact, fields zero, histories at their start; reference and family values known.
    pub fn new(spec: &'a Spec, body: &'a Body, settings: &'a Settings) -> Plain<'a> {
        let (nodes, bonds) = (body.nodes.len(), body.bonds.len());
        let mut plain = Plain {
            spec,
            body,
            settings,
            constants: Vec::new(),
            slots: vec![vec![0.0; nodes]; spec.slots.len()],
            histories: Vec::new(),
            next_histories: Vec::new(),
            intact: vec![vec![true; bonds]; spec.families.len()],
            member: vec![vec![true; bonds]; spec.families.len()],
            reverse: body.bonds.iter().map(|b| reverse(body, b)).collect(),
        };
        for h in &spec.histories {
            plain.histories.push(if h.bond {
                vec![h.initial; bonds]
            } else {
                Vec::new()
            });
            if let Some((slot, _)) = h.slot {
                plain.slots[slot as usize] = vec![h.initial; nodes];
            }
        }
        let ones = spec.weights.iter().map(|_| vec![1.0; bonds]);
        plain.histories.extend(ones);
        plain.next_histories = plain.histories.clone();
        plain.constants = plain.tape(&spec.constants, &plain.reader(0)).0;
        plain.filter();
        for (slot, s) in spec.slots.iter().enumerate() {
            if let SlotKind::Position(a) = s.kind {
                plain.slots[slot] = body.nodes.iter().map(|n| n.position[a as usize]).collect();
            }
        }
        plain
    }

    fn filter(&mut self) {
        for (k, family) in self.spec.families.iter().enumerate() {
            let Some(filter) = &family.filter else {
                continue;
            };
            let keep = |b: usize| {
                let mut reader = self.reader(self.body.bonds[b].from);
                reader.xi = self.body.bonds[b].xi;
                self.tape(filter, &reader).0[0] != 0.0
            };
            self.member[k] = (0..self.body.bonds.len()).map(keep).collect();
        }
    }

    /// Takes over velocities and intact bonds, and runs the sweeps before the force.
    pub fn force(&mut self, state: &State) -> Vec<[f64; 3]> {
        for (slot, s) in self.spec.slots.iter().enumerate() {
            if let SlotKind::Velocity(a) = s.kind {
                self.slots[slot] = state.v.iter().map(|v| v[a as usize]).collect();
            }
            if s.kind == SlotKind::TimeStep {
                self.slots[slot].fill(state.dt);
            }
        }
        self.intact.clone_from(&state.intact);
        for stage in [Stage::Reference, Stage::Family, Stage::Step] {
            self.run(stage, state);
        }
        self.vectors(&self.spec.force)
    }

    /// After [`Plain::force`] at the same state.
    pub fn energy(&mut self, state: &State) -> Vec<f64> {
        self.run(Stage::Energy, state);
        self.spec
            .energy
            .map_or_else(Vec::new, |slot| self.slots[slot as usize].clone())
    }

    /// After [`Plain::force`] at the same state.
    pub fn tangent(&mut self, state: &State, du: &[[f64; 3]]) -> Vec<[f64; 3]> {
        for (slot, s) in self.spec.slots.iter().enumerate() {
            if let SlotKind::Increment(a) = s.kind {
                self.slots[slot] = du.iter().map(|d| d[a as usize]).collect();
            }
        }
        self.run(Stage::Tangent, state);
        self.vectors(&self.spec.tangent)
    }

    /// After [`Plain::force`] at the same state.
    pub fn commit(&mut self, state: &State) {
        self.run(Stage::Update, state);
        self.histories.clone_from(&self.next_histories);
        for h in &self.spec.histories {
            if let Some((current, next)) = h.slot {
                self.slots[current as usize] = self.slots[next as usize].clone();
            }
        }
    }

    /// Values of the slots, as vectors.
    pub fn vectors(&self, slots: &[u32]) -> Vec<[f64; 3]> {
        let component =
            |i: usize, a: usize| slots.get(a).map_or(0.0, |s| self.slots[*s as usize][i]);
        (0..self.body.nodes.len())
            .map(|i| std::array::from_fn(|a| component(i, a)))
            .collect()
    }

    fn run(&mut self, stage: Stage, state: &State) {
        let spec = self.spec;
        for sweep in spec.sweeps.iter().filter(|sweep| sweep.stage == stage) {
            let mut results = Vec::new();
            let mut killed = Vec::new();
            for node in 0..self.body.nodes.len() {
                results.push(self.node(sweep, node, state, &mut killed));
            }
            for (node, (values, put)) in results.into_iter().enumerate() {
                for (slot, value) in sweep.out.iter().zip(values) {
                    self.slots[*slot as usize][node] = value;
                }
                for (history, bond, value) in put {
                    self.next_histories[history][bond] = value;
                }
            }
            if stage == Stage::Reference {
                self.weigh(sweep);
            }
            for bond in killed {
                self.intact[sweep.family as usize][bond] = false;
            }
        }
    }

    /// A weight that was written is there for the next sweep.
    fn weigh(&mut self, sweep: &SweepSpec) {
        for h in sweep.history.iter().map(|h| *h as usize) {
            let weight = &self.spec.weights[h - self.spec.histories.len()];
            if !self.settings.without.contains(&weight.name) {
                self.histories[h] = self.next_histories[h].clone();
            }
        }
    }

    /// Values of the sweep's outputs at a node, and histories put: (history, bond, value).
    #[allow(clippy::type_complexity)]
    fn node(
        &self,
        sweep: &SweepSpec,
        node: usize,
        state: &State,
        killed: &mut Vec<usize>,
    ) -> (Vec<f64>, Vec<(usize, usize, f64)>) {
        let mut reader = self.reader(node);
        reader.sweep = Some(sweep);
        let pre = self.tape(&sweep.pre, &reader).0;
        let mut acc = vec![0.0; sweep.accumulators as usize];
        for op in &sweep.bond.ops {
            if let Op::MaxTo(k, _) = op {
                acc[*k as usize] = f64::NEG_INFINITY;
            }
        }
        let mut put = Vec::new();
        for (b, bond) in self.body.bonds.iter().enumerate() {
            let family = sweep.family as usize;
            let counts = self.member[family][b] && (sweep.reference || self.intact[family][b]);
            if bond.from != node || !counts || sweep.bond.ops.is_empty() {
                continue;
            }
            let mut reader = self.reader(node);
            (reader.sweep, reader.xi, reader.bond) = (Some(sweep), bond.xi, Some(b));
            reader.weight = bond.weight;
            let geo = self.tape(&sweep.geometry, &reader).0;
            (reader.geo, reader.pre) = (&geo, &pre);
            let effects = self.bond(&sweep.bond, &reader, state);
            for (k, v) in effects.added {
                acc[k as usize] += v;
            }
            for (k, v) in effects.raised {
                acc[k as usize] = f64::max(acc[k as usize], v);
            }
            for (k, v) in effects.put {
                put.push((sweep.history[k as usize] as usize, b, v));
            }
            if effects.killed {
                killed.push(b);
            }
        }
        let mut reader = self.reader(node);
        (reader.sweep, reader.pre, reader.acc) = (Some(sweep), &pre, &acc);
        (self.tape(&sweep.post, &reader).0, put)
    }

    fn reader(&self, node: usize) -> Read<'_, 'a> {
        Read {
            plain: self,
            constants: &self.constants,
            node,
            xi: [0.0; 3],
            bond: None,
            geo: &[],
            pre: &[],
            acc: &[],
            sweep: None,
            weight: 0.0,
        }
    }

    /// Outputs of a tape without effects, and its registers.
    fn tape(&self, tape: &Tape, read: &Read) -> (Vec<f64>, Vec<f64>) {
        let mut regs = Vec::with_capacity(tape.ops.len());
        for op in &tape.ops {
            let value = read.value(op, &regs, None);
            regs.push(value);
        }
        (tape.outs.iter().map(|r| regs[*r as usize]).collect(), regs)
    }

    fn bond(&self, tape: &Tape, read: &Read, state: &State) -> Effects {
        let mut effects = Effects::default();
        let mut regs: Vec<f64> = Vec::with_capacity(tape.ops.len());
        for op in &tape.ops {
            let reg = |k: &u32| regs[*k as usize];
            let value = match op {
                Op::Kill(c) => {
                    effects.killed |= reg(c) != 0.0;
                    0.0
                }
                Op::AddTo(k, a, b) => {
                    if !effects.killed {
                        effects.added.push((*k, reg(a) * reg(b)));
                    }
                    0.0
                }
                Op::MaxTo(k, v) => {
                    if !effects.killed {
                        effects.raised.push((*k, reg(v)));
                    }
                    0.0
                }
                Op::PutHistory(k, v) => {
                    effects.put.push((*k, reg(v)));
                    0.0
                }
                other => read.value(other, &regs, Some(state)),
            };
            regs.push(value);
        }
        effects
    }
}

impl Read<'_, '_> {
    fn value(&self, op: &Op, regs: &[f64], state: Option<&State>) -> f64 {
        let (plain, sweep) = (self.plain, self.sweep);
        let bond = || &plain.body.bonds[self.bond.expect("a bond is at hand")];
        let history = |k: &u32| sweep.expect("a sweep runs").history[*k as usize] as usize;
        match op {
            Op::Const(k) => self.constants[*k as usize],
            Op::Param(k) => plain.settings.params[*k as usize],
            Op::Delta => plain.settings.horizon,
            Op::Case(arms) => regs[arms[plain.settings.flavour as usize] as usize],
            Op::Ball(tape) => self.ball(tape),
            Op::Own(k) => {
                plain.slots[sweep.expect("a sweep runs").own[*k as usize] as usize][self.node]
            }
            Op::Nbr(k) => {
                plain.slots[sweep.expect("a sweep runs").nbr[*k as usize] as usize][bond().to]
            }
            Op::Geo(k) => self.geo[*k as usize],
            Op::Pre(k) => self.pre[*k as usize],
            Op::Acc(k) => self.acc[*k as usize],
            Op::History(k) => plain.histories[history(k)][self.bond.expect("a bond is at hand")],
            Op::Reverse(k) => {
                let b = plain.reverse[self.bond.expect("a bond is at hand")];
                plain.histories[history(k)][b]
            }
            Op::Xi(a) => self.xi[*a as usize],
            Op::Eta(a) => {
                let u = &state.expect("a state is at hand").u;
                u[bond().to][*a as usize] - u[bond().from][*a as usize]
            }
            Op::Ix => 1.0 / self.xi.iter().map(|c| c * c).sum::<f64>().sqrt(),
            Op::X => length(self.xi),
            Op::Omega(k) => {
                let (f, values) = &plain.settings.influences[*k as usize];
                tape_of(f, values, length(self.xi), plain.settings.horizon)
            }
            Op::Weight => self.weight,
            other => arithmetic(other, regs),
        }
    }

    fn ball(&self, tape: &Tape) -> f64 {
        let at = |xi: [f64; 3]| {
            let mut reader = self.plain.reader(0);
            reader.xi = xi;
            self.plain.tape(tape, &reader).0[0]
        };
        match &self.plain.settings.ball {
            Ball::Lattice(family) => family.iter().map(|(xi, w)| at(*xi) * w).sum(),
            Ball::Integral { cross } => {
                let shell = |r: f64| match self.plain.settings.flavour.dim() {
                    1 => 2.0 * cross,
                    2 => std::f64::consts::TAU * r * cross,
                    _ => 2.0 * std::f64::consts::TAU * r * r,
                };
                let f = |r: f64| Ok(at([r, 0.0, 0.0]) * shell(r));
                integrate(self.plain.settings.horizon, &f).expect("the integral exists")
            }
        }
    }
}

fn reverse(body: &Body, bond: &pdlang::oracle::Bond) -> usize {
    let opposite = |b: &pdlang::oracle::Bond| {
        let gap: f64 = (0..3).map(|k| (bond.xi[k] + b.xi[k]).abs()).sum();
        (b.from, b.to) == (bond.to, bond.from) && gap <= 1e-9 * bond.length()
    };
    body.bonds
        .iter()
        .position(opposite)
        .expect("every bond has its reverse")
}

/// Components of a value of the given dimension, without repetition, in the order of the slots.
pub fn components(value: &Value<f64>, dim: usize, symmetric: bool) -> Vec<f64> {
    match value {
        Value::Scalar(a) => vec![*a],
        Value::Vector(a) => a[..dim].to_vec(),
        Value::Tensor(t) => {
            let first = |i: usize| if symmetric { i } else { 0 };
            (0..dim)
                .flat_map(|i| t[i][first(i)..dim].to_vec())
                .collect()
        }
        Value::Boolean(b) => vec![f64::from(u8::from(*b))],
    }
}
