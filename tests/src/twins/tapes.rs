//! PMB and frozen LPS in three dimensions as tapes, operation by operation as in [`super::bodies`].
use pdlang_runtime::spec::{
    FamilySpec, Op, ParamSpec, SlotKind, SlotSpec, Spec, Stage, SweepSpec, Tape,
};

fn param(name: &str) -> ParamSpec {
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

fn slots(names: &[(&str, Stage)]) -> Vec<SlotSpec> {
    let slot = |&(name, stage): &(&str, Stage)| SlotSpec {
        name: name.into(),
        kind: SlotKind::Computed(stage),
        part: None,
    };
    names.iter().map(slot).collect()
}

fn spec(law: &str, params: &[&str], names: &[(&str, Stage)], sweeps: Vec<SweepSpec>) -> Spec {
    let n = params.len() as u32;
    Spec {
        law: law.into(),
        title: law.into(),
        cites: vec![],
        flavours: vec![],
        dim: 3,
        params: params.iter().map(|p| param(p)).collect(),
        influences: vec![],
        families: vec![FamilySpec {
            name: "horizon".into(),
            filter: None,
        }],
        fields: vec![],
        parts: vec![],
        histories: vec![],
        weights: vec![],
        slots: slots(names),
        constants: Tape {
            ops: (0..n).map(Op::Param).collect(),
            outs: (0..n).collect(),
        },
        sweeps,
        force: vec![0, 1, 2],
        tangent: vec![],
        energy: None,
        rates: vec![],
        after_step: vec![],
        breaks: true,
        pairwise: true,
        linearised: false,
        named: vec![],
    }
}

fn sweep(name: &str, stage: Stage) -> SweepSpec {
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

#[derive(Default)]
struct Writer(Vec<Op>);

impl Writer {
    fn op(&mut self, op: Op) -> u32 {
        self.0.push(op);
        self.0.len() as u32 - 1
    }
    fn mul(&mut self, a: u32, b: u32) -> u32 {
        self.op(Op::Mul(a, b))
    }
    fn tape(self, outs: &[u32]) -> Tape {
        Tape {
            ops: self.0,
            outs: outs.to_vec(),
        }
    }
    /// Y, |Y|^2, 1/|Y|.
    fn deformed(&mut self) -> ([u32; 3], u32, u32) {
        let mut y = [0; 3];
        for (a, y) in y.iter_mut().enumerate() {
            let (xi, eta) = (self.op(Op::Xi(a as u8)), self.op(Op::Eta(a as u8)));
            *y = self.op(Op::Add(xi, eta));
        }
        let s = self.mul(y[0], y[0]);
        let s = self.op(Op::Fma(y[1], y[1], s));
        let s = self.op(Op::Fma(y[2], y[2], s));
        let iy = self.op(Op::Rsqrt(s));
        (y, s, iy)
    }
    fn kill(&mut self, square: u32) {
        let limit = self.op(Op::Geo(1));
        let m = self.op(Op::Lt(limit, square));
        self.op(Op::Kill(m));
    }
    fn stretch_part(&mut self, iy: u32) -> u32 {
        let ix = self.op(Op::Ix);
        self.op(Op::Sub(ix, iy))
    }
    fn add_along(&mut self, f: u32, y: [u32; 3]) {
        for (a, y) in y.into_iter().enumerate() {
            self.op(Op::AddTo(a as u32, f, y));
        }
    }
    /// (1 + s0)^2, s0 a constant.
    fn stretched(&mut self, s0: u32) -> u32 {
        let (s0, one) = (self.op(Op::Const(s0)), self.op(Op::Lit(1.0)));
        let stretched = self.op(Op::Add(one, s0));
        self.mul(stretched, stretched)
    }
    /// x^2 (1 + s0)^2.
    fn limit(&mut self, s0: u32) -> u32 {
        let x = self.op(Op::X);
        let square = self.mul(x, x);
        let stretched = self.stretched(s0);
        self.mul(square, stretched)
    }
    /// The same in a cloud, where (1 + s0)^2 is a stream.
    fn formed_limit(&mut self, stretched: u32) -> u32 {
        let xi = [0, 1, 2].map(|a| self.op(Op::Xi(a)));
        let s = self.mul(xi[0], xi[0]);
        let s = self.op(Op::Fma(xi[1], xi[1], s));
        let s = self.op(Op::Fma(xi[2], xi[2], s));
        let stretched = self.op(Op::Geo(stretched));
        self.mul(stretched, s)
    }
}

fn accumulators(n: u32) -> Tape {
    Tape {
        ops: (0..n).map(Op::Acc).collect(),
        outs: (0..n).collect(),
    }
}

/// Parameters c, s0.
pub fn pmb() -> Spec {
    let mut s = sweep("force", Stage::Step);
    (s.kills, s.out, s.accumulators, s.post) = (true, vec![0, 1, 2], 3, accumulators(3));
    let mut g = Writer::default();
    let (w, c) = (g.op(Op::Weight), g.op(Op::Const(0)));
    let cw = g.mul(w, c);
    let limit = g.limit(1);
    s.geometry = g.tape(&[cw, limit]);
    let mut g = Writer::default();
    let (w, c) = (g.op(Op::Weight), g.op(Op::Const(0)));
    let (cw, stretched) = (g.mul(w, c), g.stretched(1));
    s.streams = g.tape(&[cw, stretched]);
    let mut g = Writer::default();
    let (cw, limit) = (g.op(Op::Geo(0)), g.formed_limit(1));
    s.from_streams = g.tape(&[cw, limit]);
    let mut b = Writer::default();
    let (y, square, iy) = b.deformed();
    b.kill(square);
    let d = b.stretch_part(iy);
    let cw = b.op(Op::Geo(0));
    let f = b.mul(cw, d);
    b.add_along(f, y);
    s.bond = b.tape(&[]);
    let names = ["fx", "fy", "fz"].map(|n| (n, Stage::Step));
    spec("pmb", &["c", "s0"], &names, vec![s])
}

/// Parameters 3K - 5G, 15G, s0; omega = 1/x; slots f, m, B = 15G/m, 9 (3K - 5G)/m^2, A.
pub fn lps() -> Spec {
    let names = [
        ("fx", Stage::Step),
        ("fy", Stage::Step),
        ("fz", Stage::Step),
        ("B", Stage::Reference),
        ("q", Stage::Reference),
        ("A", Stage::Step),
    ];
    let sweeps = vec![weighted_volume(), dilatation(), force()];
    let mut s = spec("lps_frozen", &["3K-5G", "15G", "s0"], &names, sweeps);
    s.named = vec![("reference".into(), vec![3, 4])];
    s
}

/// m = sum w omega x^2 = sum w x.
fn weighted_volume() -> SweepSpec {
    let mut s = sweep("weighted volume", Stage::Reference);
    (s.reference, s.out, s.accumulators) = (true, vec![3, 4], 1);
    let mut g = Writer::default();
    let (w, x) = (g.op(Op::Weight), g.op(Op::X));
    let wx = g.mul(w, x);
    s.geometry = g.tape(&[wx]);
    let mut p = Writer::default();
    let (k, g15) = (p.op(Op::Const(0)), p.op(Op::Const(1)));
    s.pre = p.tape(&[k, g15]);
    let mut b = Writer::default();
    let (wx, one) = (b.op(Op::Geo(0)), b.op(Op::Lit(1.0)));
    b.op(Op::AddTo(0, wx, one));
    s.bond = b.tape(&[]);
    let mut p = Writer::default();
    let (m, k, g15) = (p.op(Op::Acc(0)), p.op(Op::Pre(0)), p.op(Op::Pre(1)));
    let bulk = p.op(Op::Div(g15, m));
    let three = p.op(Op::Lit(3.0));
    let a = p.mul(three, k);
    let a = p.op(Op::Div(a, m));
    let a = p.op(Op::Div(a, m));
    s.post = p.tape(&[bulk, a]);
    s.keeping_all()
}

/// theta = 3/m sum w omega x e; A = (3K - 5G) theta/m.
fn dilatation() -> SweepSpec {
    let mut s = sweep("dilatation", Stage::Step);
    (s.kills, s.own, s.out, s.accumulators) = (true, vec![4], vec![5], 1);
    let mut g = Writer::default();
    let (w, x) = (g.op(Op::Weight), g.op(Op::X));
    let wx = g.mul(w, x);
    let limit = g.limit(2);
    s.geometry = g.tape(&[wx, limit]);
    let mut g = Writer::default();
    let (w, x) = (g.op(Op::Weight), g.op(Op::X));
    let (wx, stretched) = (g.mul(w, x), g.stretched(2));
    s.streams = g.tape(&[wx, stretched]);
    let mut g = Writer::default();
    let (wx, limit) = (g.op(Op::Geo(0)), g.formed_limit(1));
    s.from_streams = g.tape(&[wx, limit]);
    let mut p = Writer::default();
    let own = p.op(Op::Own(0));
    s.pre = p.tape(&[own]);
    let mut b = Writer::default();
    let (_, square, iy) = b.deformed();
    b.kill(square);
    let d = b.stretch_part(iy);
    let y = b.mul(square, iy);
    let e = b.mul(y, d);
    let g = b.op(Op::Geo(0));
    b.op(Op::AddTo(0, g, e));
    s.bond = b.tape(&[]);
    let mut p = Writer::default();
    let (sum, q) = (p.op(Op::Acc(0)), p.op(Op::Pre(0)));
    let a = p.mul(sum, q);
    s.post = p.tape(&[a]);
    s
}

fn force() -> SweepSpec {
    let mut s = sweep("force", Stage::Step);
    (s.own, s.nbr, s.out) = (vec![5, 3], vec![5, 3], vec![0, 1, 2]);
    (s.accumulators, s.post) = (3, accumulators(3));
    let mut g = Writer::default();
    let w = g.op(Op::Weight);
    s.geometry = g.tape(&[w]);
    let mut g = Writer::default();
    let (w, x) = (g.op(Op::Weight), g.op(Op::X));
    let wx = g.mul(w, x);
    s.streams = g.tape(&[wx]);
    let mut g = Writer::default();
    let (wx, ix) = (g.op(Op::Geo(0)), g.op(Op::Ix));
    let w = g.mul(wx, ix);
    s.from_streams = g.tape(&[w]);
    let mut p = Writer::default();
    let own = [p.op(Op::Own(0)), p.op(Op::Own(1))];
    s.pre = p.tape(&own);
    let mut b = Writer::default();
    let (y, _, iy) = b.deformed();
    let d = b.stretch_part(iy);
    let (a, q) = (b.op(Op::Pre(0)), b.op(Op::Nbr(0)));
    let a = b.op(Op::Add(a, q));
    let (c, q) = (b.op(Op::Pre(1)), b.op(Op::Nbr(1)));
    let c = b.op(Op::Add(c, q));
    let t = b.mul(a, iy);
    let t = b.op(Op::Fma(c, d, t));
    let g = b.op(Op::Geo(0));
    let t = b.mul(g, t);
    b.add_along(t, y);
    s.bond = b.tape(&[]);
    s
}
