//! Laws written as data by hand, the way the compiler writes them.
use crate::spec::{
    FamilySpec, HistorySpec, Op, ParamSpec, RateSpec, SlotKind, SlotSpec, Spec, Stage, Stepped,
    SweepSpec, Tape,
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
        meet: Default::default(),
    }
}

pub fn slot(name: &str, kind: SlotKind) -> SlotSpec {
    SlotSpec {
        name: name.into(),
        kind,
        part: None,
    }
}

pub fn empty(law: &str, dim: usize) -> Spec {
    Spec {
        law: law.into(),
        title: law.into(),
        cites: vec![],
        flavours: vec![],
        dim,
        params: vec![],
        influences: vec![],
        families: vec![FamilySpec {
            name: "horizon".into(),
            filter: None,
        }],
        fields: vec![],
        parts: vec![],
        histories: Vec::<HistorySpec>::new(),
        weights: vec![],
        slots: vec![],
        constants: Tape::default(),
        sweeps: vec![],
        force: vec![],
        tangent: vec![],
        energy: None,
        rates: vec![],
        after_step: vec![],
        breaks: false,
        pairwise: false,
        linearised: false,
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
        single: false,
        own: vec![],
        nbr: vec![],
        out: vec![],
        history: vec![],
        geometry: Tape::default(),
        streams: Tape::default(),
        from_streams: Tape::default(),
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
    spec.sweeps = vec![s.keeping_all()];
    spec
}

/// A law whose breaking sweep reads a family value at both ends: m = sum w x, A = sum w (m_i + m_j) e (broken
/// where s > s0), f = sum w c (A_i + A_j) Y/|Y|. Parameters c, s0.
pub fn live(dim: usize) -> Spec {
    let d = dim as u32;
    let mut spec = pmb(dim);
    spec.law = "live".into();
    spec.slots
        .push(slot("m", SlotKind::Computed(Stage::Family)));
    spec.slots.push(slot("A", SlotKind::Computed(Stage::Step)));
    spec.named = vec![("m".into(), vec![d])];
    let (m, a) = (d, d + 1);

    let mut volume = sweep("volume", Stage::Family);
    (volume.out, volume.accumulators, volume.post) = (vec![m], 1, accumulated(1));
    let mut g = Writer::default();
    let (w, x) = (g.op(Op::Weight), g.op(Op::X));
    let wx = g.op(Op::Mul(w, x));
    volume.geometry = g.tape(vec![wx]);
    let mut b = Writer::default();
    let (wx, one) = (b.op(Op::Geo(0)), b.op(Op::Lit(1.0)));
    b.op(Op::AddTo(0, wx, one));
    volume.bond = b.tape(vec![]);

    let mut first = sweep("first", Stage::Step);
    (first.kills, first.own, first.nbr, first.out) = (true, vec![m], vec![m], vec![a]);
    (first.accumulators, first.post) = (1, accumulated(1));
    first.geometry = spec.sweeps[0].geometry.clone();
    first.pre = Tape {
        ops: vec![Op::Own(0)],
        outs: vec![0],
    };
    let mut b = Writer::default();
    let (_, iy) = b.stretched(dim as u8);
    let limit = b.op(Op::Geo(1));
    let broken = b.op(Op::Lt(iy, limit));
    b.op(Op::Kill(broken));
    let ix = b.op(Op::Ix);
    let stretch = b.op(Op::Sub(ix, iy));
    let (own, other, cw) = (b.op(Op::Pre(0)), b.op(Op::Nbr(0)), b.op(Op::Geo(0)));
    let both = b.op(Op::Add(own, other));
    let t = b.op(Op::Mul(both, stretch));
    b.op(Op::AddTo(0, cw, t));
    first.bond = b.tape(vec![]);

    let mut second = sweep("second", Stage::Step);
    (second.own, second.nbr, second.out) = (vec![a], vec![a], spec.force.clone());
    (second.accumulators, second.post) = (d, accumulated(d));
    second.geometry = spec.sweeps[0].geometry.clone();
    second.pre = first.pre.clone();
    let mut b = Writer::default();
    let (y, iy) = b.stretched(dim as u8);
    let (own, other, cw) = (b.op(Op::Pre(0)), b.op(Op::Nbr(0)), b.op(Op::Geo(0)));
    let both = b.op(Op::Add(own, other));
    let t = b.op(Op::Mul(both, cw));
    let t = b.op(Op::Mul(t, iy));
    for (k, &y) in y.iter().enumerate() {
        b.op(Op::AddTo(k as u32, t, y));
    }
    second.bond = b.tape(vec![]);
    spec.sweeps = [volume, first, second].map(SweepSpec::keeping_all).into();
    spec
}

/// Directed history: h_ij grows by w xi_0 + 1 at every commit; f_0 = sum w (h_ij - 2 h_ji). A node history n counts
/// commits twice over.
pub fn memory(dim: usize) -> Spec {
    let mut spec = empty("memory", dim);
    spec.slots = (0..dim)
        .map(|a| slot(&format!("f{a}"), SlotKind::Computed(Stage::Step)))
        .collect();
    spec.slots.push(slot("n", SlotKind::State));
    spec.slots
        .push(slot("n.next", SlotKind::Computed(Stage::Update)));
    let (n, next) = (dim as u32, dim as u32 + 1);
    spec.force = (0..dim as u32).collect();
    let history = |name: &str, bond, initial, slot| HistorySpec {
        name: name.into(),
        bond,
        family: 0,
        initial,
        slot,
    };
    spec.histories = vec![
        history("n", false, 3.0, Some((n, next))),
        history("h", true, 0.5, None),
    ];

    let mut force = sweep("force", Stage::Step);
    (force.history, force.out, force.accumulators) = (vec![1], spec.force.clone(), 1);
    force.geometry = Tape {
        ops: vec![Op::Weight],
        outs: vec![0],
    };
    let mut b = Writer::default();
    let (h, r, w, two) = (
        b.op(Op::History(0)),
        b.op(Op::Reverse(0)),
        b.op(Op::Geo(0)),
        b.op(Op::Lit(-2.0)),
    );
    let t = b.op(Op::Fma(two, r, h));
    b.op(Op::AddTo(0, w, t));
    force.bond = b.tape(vec![]);
    force.post = Tape {
        ops: vec![Op::Acc(0)],
        outs: vec![0; dim],
    };

    let mut update = sweep("update", Stage::Update);
    (update.history, update.own, update.out) = (vec![1], vec![n], vec![next]);
    update.geometry = force.geometry.clone();
    update.pre = Tape {
        ops: vec![Op::Own(0)],
        outs: vec![0],
    };
    let mut b = Writer::default();
    let (h, w, xi, one) = (
        b.op(Op::History(0)),
        b.op(Op::Geo(0)),
        b.op(Op::Xi(0)),
        b.op(Op::Lit(1.0)),
    );
    let grown = b.op(Op::Fma(w, xi, one));
    let grown = b.op(Op::Add(h, grown));
    b.op(Op::PutHistory(0, grown));
    update.bond = b.tape(vec![]);
    update.post = Tape {
        ops: vec![Op::Pre(0), Op::Lit(2.0), Op::Add(0, 1)],
        outs: vec![2],
    };
    spec.sweeps = [force, update].map(SweepSpec::keeping_all).into();
    spec
}

/// dT/dt = sum k (T_j - T_i) w over the family of bonds along the first axis.
pub fn heat(dim: usize) -> Spec {
    let mut spec = empty("heat", dim);
    spec.params = vec![param("k")];
    spec.constants = Tape {
        ops: vec![Op::Param(0)],
        outs: vec![0],
    };
    let mut along = Writer::default();
    let (x, xi, limit) = (
        along.op(Op::X),
        along.op(Op::Xi(0)),
        along.op(Op::Lit(0.99)),
    );
    let (size, limit) = (along.op(Op::Abs(xi)), along.op(Op::Mul(x, limit)));
    let keep = along.op(Op::Lt(limit, size));
    spec.families.push(FamilySpec {
        name: "along".into(),
        filter: Some(along.tape(vec![keep])),
    });
    spec.slots = vec![
        slot("T", SlotKind::State),
        slot("dT", SlotKind::Computed(Stage::Step)),
    ];
    spec.fields = vec![crate::spec::FieldSpec {
        name: "T".into(),
        slots: vec![0],
        components: vec![String::new()],
        exponents: [0; 7],
        part: None,
    }];
    spec.rates = vec![RateSpec {
        field: 0,
        rate: 1,
        damping: None,
        stepped: Stepped::Together,
    }];
    let mut s = sweep("rate", Stage::Step);
    (s.family, s.own, s.nbr, s.out) = (1, vec![0], vec![0], vec![1]);
    (s.accumulators, s.post) = (1, accumulated(1));
    s.geometry = Tape {
        ops: vec![Op::Weight, Op::Const(0), Op::Mul(0, 1)],
        outs: vec![2],
    };
    s.pre = Tape {
        ops: vec![Op::Own(0)],
        outs: vec![0],
    };
    let mut b = Writer::default();
    let (here, there, k) = (b.op(Op::Pre(0)), b.op(Op::Nbr(0)), b.op(Op::Geo(0)));
    let d = b.op(Op::Sub(there, here));
    b.op(Op::AddTo(0, k, d));
    s.bond = b.tape(vec![]);
    spec.sweeps = vec![s.keeping_all()];
    spec
}
