//! The oracle against formulas worked out by hand, on laws put together without the front end.

use super::*;
use crate::ir::*;
use crate::span::Span;
use crate::units::Unit;

/// Builds a law expression by expression; units and spans do not matter to the oracle.
struct Builder(Law);

impl Builder {
    fn new(params: usize) -> Builder {
        let param = |k| Param {
            meet: Default::default(),
            name: format!("p{k}"),
            doc: String::new(),
            unit: Unit::default(),
            lower: None,
            upper: None,
            default: None,
            span: Span::default(),
        };
        let omega = Influence {
            name: "omega".into(),
            default: None,
            span: Span::default(),
        };
        Builder(Law {
            name: "test".into(),
            span: Span::default(),
            title: String::new(),
            cites: Vec::new(),
            flavours: ir::Flavour::ALL.to_vec(),
            params: (0..params).map(param).collect(),
            influences: vec![omega],
            families: vec![Family {
                name: "horizon".into(),
                filter: None,
            }],
            fields: Vec::new(),
            histories: Vec::new(),
            weights: Vec::new(),
            defs: Vec::new(),
            responses: Vec::new(),
            breaks: Vec::new(),
            after_step: None,
            knowns: Vec::new(),
            probes: Vec::new(),
            exprs: Vec::new(),
        })
    }

    fn push(&mut self, kind: ExprKind, shape: Shape, home: Home) -> ExprId {
        let (unit, span) = (Unit::default(), Span::default());
        self.0.exprs.push(Expr {
            kind,
            shape,
            home,
            unit,
            span,
        });
        ExprId(self.0.exprs.len() as u32 - 1)
    }

    fn scalar(&mut self, kind: ExprKind, home: Home) -> ExprId {
        self.push(kind, Shape::Scalar, home)
    }

    fn number(&mut self, v: f64) -> ExprId {
        self.scalar(ExprKind::Number(v), Home::Constant)
    }

    fn param(&mut self, k: u32) -> ExprId {
        self.scalar(ExprKind::Param(ParamId(k)), Home::Constant)
    }

    fn binary(&mut self, op: BinaryOp, a: ExprId, b: ExprId) -> ExprId {
        let (x, y) = (&self.0.exprs[a.index()], &self.0.exprs[b.index()]);
        let (shape, home) = (x.shape.max(y.shape), x.home.max(y.home));
        self.push(ExprKind::Binary(op, a, b), shape, home)
    }

    fn mul(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.binary(BinaryOp::Mul, a, b)
    }

    fn div(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.binary(BinaryOp::Div, a, b)
    }

    fn sub(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.binary(BinaryOp::Sub, a, b)
    }

    fn norm(&mut self, a: ExprId) -> ExprId {
        let home = self.0.exprs[a.index()].home;
        self.scalar(ExprKind::Call(Builtin::Norm, vec![a]), home)
    }

    fn sum(&mut self, a: ExprId) -> ExprId {
        let shape = self.0.exprs[a.index()].shape;
        self.push(
            ExprKind::Reduce(Reduction::Sum, FamilyId(0), a),
            shape,
            Home::Node,
        )
    }

    fn prime(&mut self, a: ExprId) -> ExprId {
        let shape = self.0.exprs[a.index()].shape;
        self.push(ExprKind::Prime(a), shape, Home::Bond)
    }

    fn define(&mut self, name: &str, expr: ExprId) -> ExprId {
        let Expr { shape, home, .. } = self.0.exprs[expr.index()];
        let (unit, span) = (Unit::default(), Span::default());
        self.0.defs.push(Def {
            name: name.into(),
            home,
            shape,
            unit,
            expr,
            span,
        });
        let def = DefId(self.0.defs.len() as u32 - 1);
        self.push(ExprKind::Def(def), shape, home)
    }

    fn xi(&mut self) -> ExprId {
        self.push(ExprKind::Xi, Shape::Vector, Home::Bond)
    }

    fn x(&mut self) -> ExprId {
        let xi = self.xi();
        self.norm(xi)
    }

    /// Extension e = |xi + eta| - |xi|.
    fn e(&mut self) -> ExprId {
        let (xi, x) = (self.xi(), self.x());
        let eta = self.push(ExprKind::Eta, Shape::Vector, Home::Bond);
        let y = self.binary(BinaryOp::Add, xi, eta);
        let y = self.norm(y);
        let e = self.sub(y, x);
        self.define("e", e)
    }

    fn omega(&mut self) -> ExprId {
        self.scalar(ExprKind::Influence(InfluenceId(0)), Home::Bond)
    }

    fn product(&mut self, factors: &[ExprId]) -> ExprId {
        let first = factors[0];
        factors[1..].iter().fold(first, |a, b| self.mul(a, *b))
    }
}

/// omega(r) = 1/r.
fn inverse_distance() -> InfluenceFn {
    let expr = |kind| Expr {
        kind,
        shape: Shape::Scalar,
        home: Home::Constant,
        unit: Unit::default(),
        span: Span::default(),
    };
    let exprs = vec![
        expr(ExprKind::Number(1.0)),
        expr(ExprKind::Var(0)),
        expr(ExprKind::Binary(BinaryOp::Div, ExprId(0), ExprId(1))),
    ];
    InfluenceFn {
        name: "inverse".into(),
        doc: String::new(),
        params: Vec::new(),
        body: ExprId(2),
        exprs,
    }
}

fn settings(flavour: Flavour, params: &[f64]) -> Settings {
    Settings {
        flavour,
        params: params.to_vec(),
        influences: vec![(inverse_distance(), Vec::new())],
        horizon: 1.7,
        ball: Ball::Integral { cross: 1.0 },
        without: Vec::new(),
    }
}

/// Nine nodes, all bonded, with unequal volumes.
fn cloud(dim: usize) -> Body {
    let wave = |i: usize, a: usize| {
        if a < dim {
            ((7 * i + 3 * a) as f64).sin()
        } else {
            0.0
        }
    };
    let nodes: Vec<Node> = (0..9)
        .map(|i| Node {
            position: std::array::from_fn(|a| wave(i, a)),
            volume: 1.0 + 0.1 * i as f64,
        })
        .collect();
    let bond = |i: usize, j: usize| Bond {
        from: i,
        to: j,
        xi: std::array::from_fn(|a| nodes[j].position[a] - nodes[i].position[a]),
        weight: nodes[j].volume,
    };
    let pairs = (0..9)
        .flat_map(|i| (0..9).map(move |j| (i, j)))
        .filter(|(i, j)| i != j);
    let bonds = pairs.map(|(i, j)| bond(i, j)).collect();
    Body { nodes, bonds }
}

fn deform(state: &mut State, dim: usize) {
    for (i, u) in state.u.iter_mut().enumerate() {
        for (a, u) in u.iter_mut().enumerate().take(dim) {
            *u = 0.05 * ((3 * i + 5 * a + 1) as f64).cos();
        }
    }
}

/// Length and direction of a deformed bond, and its extension.
fn kinematics(bond: &Bond, state: &State) -> (f64, [f64; 3], f64) {
    let y: [f64; 3] =
        std::array::from_fn(|a| bond.xi[a] + state.u[bond.to][a] - state.u[bond.from][a]);
    let length = y.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length, y.map(|c| c / length), length - bond.length())
}

fn assert_close(a: &[[f64; 3]], b: &[[f64; 3]], tolerance: f64) {
    let size = b.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
    for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!((a - b).abs() <= tolerance * size, "{a} is not {b}");
    }
}

/// W = p0/4 sum(omega e^2), whose force is p0 omega e M.
fn spring_energy() -> Law {
    let mut b = Builder::new(1);
    let (p, four, omega, e) = (b.param(0), b.number(4.0), b.omega(), b.e());
    let integrand = b.product(&[omega, e, e]);
    let (sum, quarter) = (b.sum(integrand), b.div(p, four));
    let w = b.mul(quarter, sum);
    b.0.responses.push(Response::Energy(w));
    b.0
}

/// The same force, stated as a pair force.
fn spring_pair() -> Law {
    let mut b = Builder::new(1);
    let (p, omega, e) = (b.param(0), b.omega(), b.e());
    let f = b.product(&[p, omega, e]);
    b.0.responses.push(Response::Pair(FamilyId(0), f));
    b.0
}

/// W = p0 theta^2/2 + p1/m sum(omega e^2), theta = dim/m sum(omega x e), m = sum(omega x^2).
fn dilatation_energy() -> Law {
    let mut b = Builder::new(2);
    let (omega, x, e) = (b.omega(), b.x(), b.e());
    let integrand = b.product(&[omega, x, x]);
    let m = b.sum(integrand);
    let m = b.define("m", m);
    let integrand = b.product(&[omega, x, e]);
    let sum = b.sum(integrand);
    let dim = b.scalar(ExprKind::Dim, Home::Constant);
    let factor = b.div(dim, m);
    let theta = b.mul(factor, sum);
    let theta = b.define("theta", theta);
    let (k, g, half) = (b.param(0), b.param(1), b.number(0.5));
    let volumetric = b.product(&[half, k, theta, theta]);
    let integrand = b.product(&[omega, e, e]);
    let sum = b.sum(integrand);
    let factor = b.div(g, m);
    let shear = b.mul(factor, sum);
    let w = b.binary(BinaryOp::Add, volumetric, shear);
    b.0.responses.push(Response::Energy(w));
    b.0
}

#[test]
fn the_force_of_an_energy_is_its_gradient() {
    for flavour in Flavour::ALL {
        let (body, settings) = (cloud(flavour.dim()), settings(flavour, &[2.0]));
        let (energy, pair) = (spring_energy(), spring_pair());
        let energy = Oracle::new(&energy, &body, &settings).unwrap();
        let pair = Oracle::new(&pair, &body, &settings).unwrap();
        let mut state = energy.state();
        deform(&mut state, flavour.dim());
        state.cut(&body, |i, j| (i, j) == (2, 5));
        assert_close(
            &energy.force(&state).unwrap(),
            &pair.force(&state).unwrap(),
            1e-14,
        );
        assert_close(
            &energy.bond_forces(&state).unwrap(),
            &pair.bond_forces(&state).unwrap(),
            1e-14,
        );
    }
}

#[test]
fn a_law_with_dilatation_has_the_published_force() {
    let (k, g) = (3.0, 5.0);
    let (body, settings) = (cloud(3), settings(Flavour::Solid, &[k, g]));
    let law = dilatation_energy();
    let oracle = Oracle::new(&law, &body, &settings).unwrap();
    let mut state = oracle.state();
    deform(&mut state, 3);
    state.cut(&body, |i, j| i + j == 7);
    let scalars = |name| -> Vec<f64> {
        oracle
            .named(&state, name)
            .unwrap()
            .iter()
            .map(|v| v.scalar().unwrap())
            .collect()
    };
    let (m, theta) = (scalars("m"), scalars("theta"));
    // t_i = (3 K theta_i/m_i) omega x + (2 g/m_i) omega e, and the force on i is sum (t_i + t_j) M w.
    let mut expected = vec![[0.0; 3]; 9];
    for (bond, _) in body
        .bonds
        .iter()
        .zip(&state.intact[0])
        .filter(|(_, intact)| **intact)
    {
        let (x, (_, direction, e)) = (bond.length(), kinematics(bond, &state));
        let t = |i: usize| 3.0 * k * theta[i] / m[i] + 2.0 * g / m[i] * e / x;
        for a in 0..3 {
            expected[bond.from][a] += (t(bond.from) + t(bond.to)) * direction[a] * bond.weight;
        }
    }
    assert_close(&oracle.force(&state).unwrap(), &expected, 1e-14);
    let scale = oracle.force_scale(&state).unwrap();
    assert!(expected.iter().flatten().all(|c| c.abs() <= scale));
}

#[test]
fn the_tangent_is_the_derivative_of_the_force() {
    let (energy, pair, coupled) = (spring_energy(), spring_pair(), dilatation_energy());
    for law in [energy, pair, coupled] {
        let (body, settings) = (
            cloud(2),
            settings(Flavour::PlaneStress, &[2.0, 3.0][..law.params.len()]),
        );
        let oracle = Oracle::new(&law, &body, &settings).unwrap();
        let mut state = oracle.state();
        deform(&mut state, 2);
        let du: Vec<[f64; 3]> = (0..9)
            .map(|i| [(i as f64).sin(), (2.0 * i as f64).cos(), 0.0])
            .collect();
        let moved = |h: f64| {
            let mut moved = state.clone();
            for (u, d) in moved.u.iter_mut().zip(&du) {
                *u = std::array::from_fn(|a| u[a] + h * d[a]);
            }
            oracle.force(&moved).unwrap()
        };
        let h = 1e-5;
        let (plus, minus) = (moved(h), moved(-h));
        let difference: Vec<[f64; 3]> = plus
            .iter()
            .zip(&minus)
            .map(|(p, m)| std::array::from_fn(|a| (p[a] - m[a]) / (2.0 * h)))
            .collect();
        // Central differences are good to h^2 = 1e-10 times the third derivative.
        assert_close(&oracle.tangent(&state, &du).unwrap(), &difference, 1e-7);
    }
}

#[test]
fn a_node_without_bonds_answers_nothing() {
    let (body, settings) = (cloud(3), settings(Flavour::Solid, &[3.0, 5.0]));
    let law = dilatation_energy();
    let oracle = Oracle::new(&law, &body, &settings).unwrap();
    let mut state = oracle.state();
    deform(&mut state, 3);
    state.cut(&body, |i, _| i == 4);
    assert_eq!(oracle.energy(&state).unwrap()[4], 0.0);
    assert_eq!(oracle.force(&state).unwrap()[4], [0.0; 3]);
    assert!(
        oracle
            .force(&state)
            .unwrap()
            .iter()
            .flatten()
            .all(|c| c.is_finite())
    );
}

#[test]
fn the_prime_of_a_bond_quantity_is_the_bond_from_the_other_end() {
    // T = 2z - z' with the bond history z: T_ij - T_ji = (z_ij + z_ji) M.
    let mut b = Builder::new(0);
    let two = b.number(2.0);
    let z = b.scalar(ExprKind::History(HistoryId(0)), Home::Bond);
    let (double, other) = (b.mul(two, z), b.prime(z));
    let t = b.sub(double, other);
    b.0.responses.push(Response::State(FamilyId(0), t));
    let e = b.e();
    b.0.histories.push(History {
        name: "z".into(),
        home: Home::Bond,
        shape: Shape::Scalar,
        unit: Unit::default(),
        initial: 0.25,
        update: e,
        family: FamilyId(0),
        span: Span::default(),
    });
    let (law, body, settings) = (b.0, cloud(3), settings(Flavour::Solid, &[]));
    let oracle = Oracle::new(&law, &body, &settings).unwrap();
    let mut state = oracle.state();
    deform(&mut state, 3);
    for (k, z) in state.histories[0].iter_mut().enumerate() {
        *z = Value::Scalar((k as f64).sin());
    }
    let z = |b: usize| state.histories[0][b].scalar().unwrap();
    let forces = oracle.bond_forces(&state).unwrap();
    let next = oracle.next_histories(&state).unwrap();
    for (k, bond) in body.bonds.iter().enumerate() {
        let back = body
            .bonds
            .iter()
            .position(|r| (r.from, r.to) == (bond.to, bond.from))
            .unwrap();
        let (_, direction, e) = kinematics(bond, &state);
        let expected = direction.map(|c| (z(k) + z(back)) * c);
        // Scaled by the largest history, 1.
        assert_close(&[forces[k], [1.0; 3]], &[expected, [1.0; 3]], 1e-14);
        assert!((next[0][k].scalar().unwrap() - e).abs() < 1e-15);
    }
}

#[test]
fn ball_is_the_integral_or_the_lattice_sum() {
    // ball(omega x) with omega = 1/r is the measure of the horizon.
    let mut b = Builder::new(0);
    let (omega, x) = (b.omega(), b.x());
    let integrand = b.mul(omega, x);
    let ball = b.scalar(ExprKind::Ball(integrand), Home::Constant);
    b.define("measure", ball);
    let (law, r) = (b.0, 1.7_f64);
    let pi = std::f64::consts::PI;
    let exact = [
        2.0 * r,
        2.0 * r,
        pi * r * r,
        pi * r * r,
        4.0 / 3.0 * pi * r.powi(3),
    ];
    for (flavour, exact) in Flavour::ALL.into_iter().zip(exact) {
        let body = cloud(flavour.dim());
        let mut settings = settings(flavour, &[]);
        let measure = |settings: &Settings| {
            let oracle = Oracle::new(&law, &body, settings).unwrap();
            oracle.named(&oracle.state(), "measure").unwrap()[0]
                .scalar()
                .unwrap()
        };
        assert!((measure(&settings) / exact - 1.0).abs() < 4e-15);
        settings.ball = Ball::Lattice(vec![([1.0, 0.0, 0.0], 0.5), ([-1.0, 0.0, 0.0], 0.25)]);
        assert!((measure(&settings) - 0.75).abs() < 1e-15);
    }
}

#[test]
fn settings_and_states_that_do_not_fit_are_errors() {
    let (law, body) = (spring_energy(), cloud(2));
    assert!(Oracle::new(&law, &body, &settings(Flavour::PlaneStress, &[])).is_err());
    let settings = settings(Flavour::PlaneStress, &[1.0]);
    let oracle = Oracle::new(&law, &body, &settings).unwrap();
    let mut state = oracle.state();
    state.u.pop();
    assert!(oracle.force(&state).is_err());
}
