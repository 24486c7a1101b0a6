//! Laws written by hand for the tests of the simulation.

use crate::engine::tests::laws::{self, Writer, accumulated, slot, sweep};
use crate::spec::{FieldSpec, Op, RateSpec, SlotKind, Spec, Stage, Stepped, Tape};

/// c and the critical stretch; f = sum c s Y/|Y| w, W = sum c/4 s^2 x w, and the tangent of f.
pub fn pmb(dim: usize) -> Spec {
    let mut spec = laws::pmb(dim);
    spec.pairwise = true;
    energy(&mut spec);
    tangent(&mut spec, dim);
    spec
}

fn energy(spec: &mut Spec) {
    let w = spec.slots.len() as u32;
    spec.slots
        .push(slot("W", SlotKind::Computed(Stage::Energy)));
    spec.energy = Some(w);
    let mut s = sweep("energy", Stage::Energy);
    s.out = vec![w];
    s.accumulators = 1;
    s.post = accumulated(1);
    let mut g = Writer::default();
    let (w, c, x, quarter) = (
        g.op(Op::Weight),
        g.op(Op::Const(0)),
        g.op(Op::X),
        g.op(Op::Lit(0.25)),
    );
    let cw = g.op(Op::Mul(w, c));
    let cwx = g.op(Op::Mul(cw, x));
    let k = g.op(Op::Mul(cwx, quarter));
    s.geometry = g.tape(vec![k]);
    let mut b = Writer::default();
    let (_, iy) = b.stretched(spec.dim as u8);
    let ix = b.op(Op::Ix);
    let ratio = b.op(Op::Div(ix, iy));
    let one = b.op(Op::Lit(1.0));
    let stretch = b.op(Op::Sub(ratio, one));
    let square = b.op(Op::Mul(stretch, stretch));
    let k = b.op(Op::Geo(0));
    b.op(Op::AddTo(0, square, k));
    s.bond = b.tape(vec![]);
    spec.sweeps.push(s.keeping_all());
}

fn tangent(spec: &mut Spec, dim: usize) {
    let d = dim as u32;
    let first = spec.slots.len() as u32;
    for a in 0..dim {
        spec.slots.push(slot("du", SlotKind::Increment(a as u8)));
    }
    for _ in 0..dim {
        spec.slots
            .push(slot("df", SlotKind::Computed(Stage::Tangent)));
    }
    spec.tangent = (first + d..first + 2 * d).collect();
    let mut s = sweep("tangent", Stage::Tangent);
    s.out = spec.tangent.clone();
    s.own = (first..first + d).collect();
    s.nbr = s.own.clone();
    s.accumulators = d;
    s.post = accumulated(d);
    s.pre = Tape {
        ops: (0..d).map(Op::Own).collect(),
        outs: (0..d).collect(),
    };
    let mut g = Writer::default();
    let (w, c) = (g.op(Op::Weight), g.op(Op::Const(0)));
    let cw = g.op(Op::Mul(w, c));
    s.geometry = g.tape(vec![cw]);
    s.bond = increment(dim);
    spec.sweeps.push(s.keeping_all());
}

/// d[(1/x - 1/y) Y] = (1/x - 1/y) d + (Y.d / y^3) Y for d = du' - du.
fn increment(dim: usize) -> Tape {
    let mut b = Writer::default();
    let (y, iy) = b.stretched(dim as u8);
    let mut d = vec![];
    for a in 0..dim as u32 {
        let (there, here) = (b.op(Op::Nbr(a)), b.op(Op::Pre(a)));
        d.push(b.op(Op::Sub(there, here)));
    }
    let mut along = b.op(Op::Mul(y[0], d[0]));
    for a in 1..dim {
        along = b.op(Op::Fma(y[a], d[a], along));
    }
    let cube = b.op(Op::Powi(iy, 3));
    let factor = b.op(Op::Mul(along, cube));
    let ix = b.op(Op::Ix);
    let slack = b.op(Op::Sub(ix, iy));
    let cw = b.op(Op::Geo(0));
    for a in 0..dim {
        let straight = b.op(Op::Mul(slack, d[a]));
        let df = b.op(Op::Fma(factor, y[a], straight));
        b.op(Op::AddTo(a as u32, df, cw));
    }
    b.tape(vec![])
}

/// rate T = sum k (T' - T) w, parameter k; no motion.
pub fn heat(dim: usize) -> Spec {
    let mut spec = laws::empty("heat", dim);
    spec.params = vec![laws::param("k")];
    spec.constants = Tape {
        ops: vec![Op::Param(0)],
        outs: vec![0],
    };
    spec.slots = vec![
        slot("T", SlotKind::State),
        slot("dT", SlotKind::Computed(Stage::Step)),
    ];
    spec.fields = vec![FieldSpec {
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
    (s.own, s.nbr, s.out) = (vec![0], vec![0], vec![1]);
    s.accumulators = 1;
    s.pre = Tape {
        ops: vec![Op::Own(0)],
        outs: vec![0],
    };
    s.post = accumulated(1);
    let mut g = Writer::default();
    let (w, k) = (g.op(Op::Weight), g.op(Op::Const(0)));
    let kw = g.op(Op::Mul(w, k));
    s.geometry = g.tape(vec![kw]);
    let mut b = Writer::default();
    let (there, here) = (b.op(Op::Nbr(0)), b.op(Op::Pre(0)));
    let difference = b.op(Op::Sub(there, here));
    let kw = b.op(Op::Geo(0));
    b.op(Op::AddTo(0, difference, kw));
    s.bond = b.tape(vec![]);
    spec.sweeps = vec![s.keeping_all()];
    spec
}
