//! Laws written as data by hand, the way the compiler writes them.
use crate::spec::{
    FamilySpec, HistorySpec, Op, ParamSpec, SlotKind, SlotSpec, Spec, Stage, SweepSpec, Tape,
};

pub fn param(name: &str) -> ParamSpec {
    ParamSpec {
        name: name.into(),
        doc: String::new(),
        unit: String::new(),
        exponents: [0; 7],
        lower: None,
        upper: None,
        default: None,
    }
}

pub fn slot(name: &str, kind: SlotKind) -> SlotSpec {
    SlotSpec {
        name: name.into(),
        kind,
    }
}

pub fn empty(law: &str, dim: usize) -> Spec {
    Spec {
        law: law.into(),
        title: law.into(),
        cites: vec![],
        dim,
        params: vec![],
        influences: vec![],
        families: vec![FamilySpec {
            name: "horizon".into(),
            filter: None,
        }],
        fields: vec![],
        histories: Vec::<HistorySpec>::new(),
        slots: vec![],
        constants: Tape::default(),
        sweeps: vec![],
        force: vec![],
        tangent: vec![],
        energy: None,
        rates: vec![],
        breaks: false,
        pairwise: false,
        named: vec![],
    }
}

pub fn sweep(name: &str, stage: Stage) -> SweepSpec {
    SweepSpec {
        name: name.into(),
        stage,
        family: 0,
        reference: false,
        kills: false,
        own: vec![],
        nbr: vec![],
        out: vec![],
        history: vec![],
        geometry: Tape::default(),
        pre: Tape::default(),
        bond: Tape::default(),
        accumulators: 0,
        post: Tape::default(),
    }
}

/// A tape under construction.
#[derive(Default)]
pub struct Writer(pub Vec<Op>);

impl Writer {
    pub fn op(&mut self, op: Op) -> u32 {
        self.0.push(op);
        self.0.len() as u32 - 1
    }

    /// Deformed bond vector and 1/|Y|.
    pub fn stretched(&mut self, dim: u8) -> (Vec<u32>, u32) {
        let mut y = vec![];
        for a in 0..dim {
            let (xi, eta) = (self.op(Op::Xi(a)), self.op(Op::Eta(a)));
            y.push(self.op(Op::Add(xi, eta)));
        }
        let mut square = self.op(Op::Mul(y[0], y[0]));
        for &c in &y[1..] {
            square = self.op(Op::Fma(c, c, square));
        }
        let iy = self.op(Op::Rsqrt(square));
        (y, iy)
    }

    pub fn tape(self, outs: Vec<u32>) -> Tape {
        Tape { ops: self.0, outs }
    }
}

pub fn accumulated(n: u32) -> Tape {
    Tape {
        ops: (0..n).map(Op::Acc).collect(),
        outs: (0..n).collect(),
    }
}

/// Parameters c, s0; f = sum c s Y/|Y| w, broken where s > s0.
pub fn pmb(dim: usize) -> Spec {
    let mut spec = empty("pmb", dim);
    spec.params = vec![param("c"), param("s0")];
    spec.constants = Tape {
        ops: vec![Op::Param(0), Op::Param(1)],
        outs: vec![0, 1],
    };
    spec.slots = (0..dim)
        .map(|a| slot(&format!("f{a}"), SlotKind::Computed(Stage::Step)))
        .collect();
    spec.force = (0..dim as u32).collect();
    spec.breaks = true;
    let mut s = sweep("force", Stage::Step);
    s.kills = true;
    s.out = spec.force.clone();
    s.accumulators = dim as u32;
    s.post = accumulated(dim as u32);
    let mut g = Writer::default();
    let (w, c) = (g.op(Op::Weight), g.op(Op::Const(0)));
    let cw = g.op(Op::Mul(w, c));
    let (x, s0, one) = (g.op(Op::X), g.op(Op::Const(1)), g.op(Op::Lit(1.0)));
    let limit = g.op(Op::Add(one, s0));
    let limit = g.op(Op::Mul(x, limit));
    let limit = g.op(Op::Div(one, limit));
    s.geometry = g.tape(vec![cw, limit]);
    let mut b = Writer::default();
    let (y, iy) = b.stretched(dim as u8);
    let limit = b.op(Op::Geo(1));
    let broken = b.op(Op::Lt(iy, limit));
    b.op(Op::Kill(broken));
    let ix = b.op(Op::Ix);
    let d = b.op(Op::Sub(ix, iy));
    let cw = b.op(Op::Geo(0));
    let f = b.op(Op::Mul(cw, d));
    for (a, &y) in y.iter().enumerate() {
        b.op(Op::AddTo(a as u32, f, y));
    }
    s.bond = b.tape(vec![]);
    spec.sweeps = vec![s];
    spec
}
