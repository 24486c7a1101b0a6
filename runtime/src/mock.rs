//! Stand-in for the engine until it is merged: a bond-based law, neighbours found pair by pair.
use crate::body::Body;
use crate::spec::{InfluenceFn, Op, Spec, Tape};
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug)]
pub struct Law {
    pub spec: Spec,
}
impl Law {
    pub fn interpreted(spec: Spec) -> Law {
        Law { spec }
    }
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traversal {
    Auto,
    Lattice,
    Cloud,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    Scalar,
    Avx2,
    Avx512,
}
#[derive(Clone, Debug)]
pub struct Settings {
    pub params: Vec<f64>,
    pub influences: Vec<(InfluenceFn, Vec<f64>)>,
    pub horizon: f64,
    pub partial_volume: bool,
    pub lattice_constants: bool,
    pub traversal: Traversal,
    pub isa: Option<Isa>,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breaking {
    Held,
    Armed,
}
#[derive(Debug)]
pub struct SetupError(pub String);
impl std::fmt::Display for SetupError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FamilyState {
    pub intact: Vec<u8>,
    pub history: Vec<Vec<f64>>,
}
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub step: u64,
    pub time: f64,
    pub u: Vec<Vec<f64>>,
    pub v: Vec<Vec<f64>>,
    pub slots: Vec<Vec<f64>>,
    pub families: Vec<FamilyState>,
}
#[derive(Clone, Debug, Default)]
pub struct Report {
    pub nodes: usize,
    pub bonds: u64,
    pub traversal: String,
    pub isa: String,
    pub compiled: bool,
    pub bond_bytes: u64,
    pub node_bytes: u64,
    pub constants: Vec<(String, f64)>,
}

pub struct Engine {
    spec: Spec,
    dim: usize,
    x: Vec<[f64; 3]>,
    volume: Vec<f64>,
    slots: Vec<u32>,
    bonds: Vec<(u32, u32)>,
    c: f64,
    s0: f64,
    f: Vec<Vec<f64>>,
    df: Vec<Vec<f64>>,
    w: Vec<f64>,
    no_fail: Vec<bool>,
}
impl Engine {
    /// `params` of the mock: c [N/m^6] and critical stretch.
    pub fn new(body: &Body, law: Law, s: Settings) -> Result<Engine, SetupError> {
        let n = body.x.len();
        let dim = body.flavour.dim();
        let mut bonds = vec![];
        for i in 0..n {
            for j in 0..n {
                let r = r(body.x[i], body.x[j]);
                if i != j && r <= s.horizon * (1.0 + 1e-9) {
                    bonds.push((i as u32, j as u32));
                }
            }
        }
        Ok(Engine {
            spec: law.spec,
            dim,
            x: body.x.clone(),
            volume: body.volume.clone(),
            slots: (0..n as u32).collect(),
            bonds,
            c: s.params[0],
            s0: s.params[1],
            f: vec![vec![0.0; n]; dim],
            df: vec![vec![0.0; n]; dim],
            w: vec![0.0; n],
            no_fail: vec![false; n],
        })
    }
    pub fn spec(&self) -> &Spec {
        &self.spec
    }
    pub fn state(&self) -> State {
        let z = vec![vec![0.0; self.x.len()]; self.dim];
        State {
            step: 0,
            time: 0.0,
            u: z.clone(),
            v: z,
            slots: vec![],
            families: vec![FamilyState {
                intact: vec![1; self.bonds.len()],
                history: vec![],
            }],
        }
    }
    pub fn cut(&self, s: &mut State, crosses: &dyn Fn([f64; 3], [f64; 3]) -> bool) {
        for (b, &(i, j)) in self.bonds.iter().enumerate() {
            if crosses(self.x[i as usize], self.x[j as usize]) {
                s.families[0].intact[b] = 0;
            }
        }
    }
    pub fn no_fail(&mut self, nodes: &[bool]) {
        self.no_fail = nodes.to_vec();
    }
    fn bond(&self, s: &State, i: usize, j: usize) -> (f64, f64, [f64; 3]) {
        let mut xi = [0.0; 3];
        let mut y = [0.0; 3];
        for d in 0..self.dim {
            xi[d] = self.x[j][d] - self.x[i][d];
            y[d] = xi[d] + (s.u[d][j] - s.u[d][i]);
        }
        let n = |a: [f64; 3]| (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
        (n(xi), n(y), y)
    }
    pub fn forces(&mut self, s: &mut State, breaking: Breaking) -> usize {
        let mut broken = 0;
        for f in &mut self.f {
            f.fill(0.0);
        }
        for b in 0..self.bonds.len() {
            let (i, j) = (self.bonds[b].0 as usize, self.bonds[b].1 as usize);
            if s.families[0].intact[b] == 0 {
                continue;
            }
            let (x, y, yv) = self.bond(s, i, j);
            let st = y / x - 1.0;
            if breaking == Breaking::Armed && st > self.s0 && !self.no_fail[i] && !self.no_fail[j] {
                s.families[0].intact[b] = 0;
                broken += 1;
                continue;
            }
            for d in 0..self.dim {
                self.f[d][i] += self.c * st * self.volume[j] * yv[d] / y;
            }
        }
        broken
    }
    pub fn force(&self) -> &[Vec<f64>] {
        &self.f
    }
    pub fn rates(&self, _s: &State) -> Vec<(usize, &[f64])> {
        vec![]
    }
    pub fn energy(&mut self, s: &State) -> &[f64] {
        self.w.fill(0.0);
        for b in 0..self.bonds.len() {
            let (i, j) = (self.bonds[b].0 as usize, self.bonds[b].1 as usize);
            if s.families[0].intact[b] == 0 {
                continue;
            }
            let (x, y, _) = self.bond(s, i, j);
            self.w[i] += 0.25 * self.c * (y / x - 1.0).powi(2) * x * self.volume[j];
        }
        &self.w
    }
    pub fn tangent(&mut self, s: &State, du: &[Vec<f64>]) -> &[Vec<f64>] {
        for f in &mut self.df {
            f.fill(0.0);
        }
        for b in 0..self.bonds.len() {
            let (i, j) = (self.bonds[b].0 as usize, self.bonds[b].1 as usize);
            if s.families[0].intact[b] == 0 {
                continue;
            }
            let (x, y, yv) = self.bond(s, i, j);
            let mut p = 0.0;
            for d in 0..self.dim {
                p += yv[d] / y * (du[d][j] - du[d][i]);
            }
            let st = y / x - 1.0;
            for d in 0..self.dim {
                let m = yv[d] / y;
                self.df[d][i] +=
                    self.c * self.volume[j] * (p / x * m + st / y * (du[d][j] - du[d][i] - p * m));
            }
        }
        &self.df
    }
    pub fn commit(&mut self, _s: &mut State) {}
    pub fn damage(&self, s: &State) -> Vec<f64> {
        let (mut a, mut t) = (vec![0.0; self.x.len()], vec![0.0; self.x.len()]);
        for (b, &(i, j)) in self.bonds.iter().enumerate() {
            t[i as usize] += self.volume[j as usize];
            if s.families[0].intact[b] == 1 {
                a[i as usize] += self.volume[j as usize];
            }
        }
        a.iter()
            .zip(&t)
            .map(|(a, t)| if *t > 0.0 { 1.0 - a / t } else { 0.0 })
            .collect()
    }
    pub fn named(&self, _name: &str) -> Option<Vec<Vec<f64>>> {
        None
    }
    pub fn slot(&self, node: usize) -> usize {
        node
    }
    pub fn slots(&self) -> &[u32] {
        &self.slots
    }
    pub fn len(&self) -> usize {
        self.x.len()
    }
    pub fn volume(&self) -> &[f64] {
        &self.volume
    }
    pub fn report(&self) -> Report {
        Report {
            nodes: self.x.len(),
            bonds: self.bonds.len() as u64,
            traversal: "pairs".into(),
            isa: "scalar".into(),
            ..Report::default()
        }
    }
}
fn r(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// A minimal law for tests of the simulation.
pub fn test_law(dim: usize) -> Law {
    Law {
        spec: Spec {
            law: "mock".into(),
            title: "mock".into(),
            cites: vec![],
            dim,
            params: vec![],
            influences: vec![],
            families: vec![],
            fields: vec![],
            histories: vec![],
            slots: vec![],
            constants: Tape::default(),
            sweeps: vec![],
            force: (0..dim as u32).collect(),
            tangent: (0..dim as u32).collect(),
            energy: Some(0),
            rates: vec![],
            breaks: true,
            pairwise: true,
            named: vec![],
        },
    }
}
pub fn eval_scalar(t: &Tape, vars: &[f64]) -> f64 {
    let mut r: Vec<f64> = vec![];
    for op in &t.ops {
        let v = match *op {
            Op::Lit(v) => v,
            Op::Var(k) => vars[k as usize],
            Op::Add(a, b) => r[a as usize] + r[b as usize],
            Op::Sub(a, b) => r[a as usize] - r[b as usize],
            Op::Mul(a, b) => r[a as usize] * r[b as usize],
            Op::Sin(a) => r[a as usize].sin(),
            _ => f64::NAN,
        };
        r.push(v);
    }
    r[t.outs[0] as usize]
}
