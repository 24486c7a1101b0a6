//! A law in an unbounded body at rest through which a small plane wave `exp(i k.x)` runs.
//!
//! One node stands for all, as in [`super::uniform`]: what is read at the other end of a bond `xi` is the node's own with
//! the phase `k.xi`. Answers are those of the family at hand, of a quadrature over the horizon or of a lattice, exact by
//! dual numbers with complex slopes. The body is one node whose bonds lead to itself, each with its opposite.

use super::evaluate::{Evaluator, Wave};
use super::number::{Complex, Dual, Real};
use super::{Error, Oracle, State, Value};
use crate::ir::FieldId;

/// Of two waves: inside, the one that runs; outside, the conjugate of the one that is tested with.
type Number = Dual<Dual<Complex>>;

/// Row, column.
pub type Matrix = [[Complex; 3]; 3];

impl Oracle<'_> {
    /// Minus the amplitude of the force density over that of the displacement, by component [N/m^4]. Where the family is
    /// that of a continuum (`dense`), `count` is infinite.
    ///
    /// # Errors
    /// When the state does not fit the law, or the body is not a single node.
    pub fn wave_stiffness(&self, state: &State, k: [f64; 3], dense: bool) -> Result<Matrix, Error> {
        let phases = self.phases(k)?;
        let there = |b: usize, x: Number| moved(x, phases[b]);
        let mut matrix = [[Complex::default(); 3]; 3];
        for column in 0..self.dim() {
            // The second slopes of an energy are Hermitian: half of them is enough.
            let tested = if self.has_energy() {
                0..column + 1
            } else {
                0..1
            };
            for row in tested {
                let eta = |phase: &f64| {
                    let run = Complex::of_phase(*phase) - Complex::constant(1.0);
                    std::array::from_fn(|a| {
                        let only = |chosen: usize, z: Complex| match a == chosen {
                            true => z,
                            false => Complex::default(),
                        };
                        let inside = Dual::new(Complex::default(), only(column, run));
                        let outside = Dual::new(only(row, run.conjugate()), Complex::default());
                        Dual::new(inside, outside)
                    })
                };
                let wave = Wave {
                    eta: phases.iter().map(eta).collect(),
                    field: None,
                    dense,
                    there: &there,
                };
                let evaluator = self.passed(state, wave)?;
                let stored = self.density(&evaluator, 0)?.slope.slope;
                matrix[row][column] = matrix[row][column] + stored;
                if row < column {
                    matrix[column][row] = matrix[column][row] + stored.conjugate();
                }
                if row == 0 {
                    let direct = self.direct(&evaluator)?;
                    for (to, f) in matrix.iter_mut().zip(direct) {
                        to[column] = to[column] - f;
                    }
                }
            }
        }
        Ok(matrix)
    }

    /// Minus the amplitude of the rate of a scalar field over that of the field [1/s]; `None` for a field without rate.
    ///
    /// # Errors
    /// When the state does not fit the law, or the body is not a single node.
    pub fn wave_rate(
        &self,
        state: &State,
        field: FieldId,
        k: [f64; 3],
        dense: bool,
    ) -> Result<Option<Complex>, Error> {
        let phases = self.phases(k)?;
        let there = |b: usize, x: Number| moved(x, phases[b]);
        let unit = Dual::new(Complex::default(), Complex::constant(1.0));
        let gain = Dual::new(unit, Dual::constant(0.0));
        let wave = Wave {
            eta: vec![[Number::constant(0.0); 3]; phases.len()],
            field: Some((field, gain)),
            dense,
            there: &there,
        };
        let rate = self.rate_of(&self.passed(state, wave)?, field, 0)?;
        let slope = |value: Value<Number>| value.scalar().map(|x| -x.value.slope);
        rate.map(slope).transpose()
    }

    fn phases(&self, k: [f64; 3]) -> Result<Vec<f64>, Error> {
        if self.body.nodes.len() != 1 {
            return Err(Error(
                "a wave is asked of one node that stands for all".into(),
            ));
        }
        let phase = |xi: &[f64; 3]| (0..3).map(|a| k[a] * xi[a]).sum();
        Ok(self.body.bonds.iter().map(|bond| phase(&bond.xi)).collect())
    }

    fn passed<'o>(
        &'o self,
        state: &'o State,
        wave: Wave<'o, Number>,
    ) -> Result<Evaluator<'o, 'o, Number>, Error> {
        let rest = state.u.iter().map(|u| u.map(Number::constant)).collect();
        Ok(Evaluator::new(self, state, rest)?.waved(wave))
    }

    /// Amplitude of the force density that the law states outright.
    fn direct(&self, evaluator: &Evaluator<Number>) -> Result<[Complex; 3], Error> {
        let mut force = self.node_force(evaluator, 0)?;
        for (b, bond) in self.body.bonds.iter().enumerate() {
            let (f, weight) = (
                self.direct_bond_force(evaluator, b)?,
                Number::constant(bond.weight),
            );
            force = std::array::from_fn(|a| force[a] + f[a] * weight);
        }
        Ok(force.map(|f| f.value.slope))
    }
}

/// At the other end of a bond, a phase further.
fn moved(x: Number, phase: f64) -> Number {
    let turn = Complex::of_phase(phase);
    let inside = Dual::new(x.value.value, x.value.slope * turn);
    let outside = Dual::new(x.slope.value * turn.conjugate(), x.slope.slope);
    Dual::new(inside, outside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front;
    use crate::ir::{Flavour, InfluenceFn};
    use crate::oracle::{Ball, Body, Bond, Node, Settings};

    /// The family of a square lattice of spacing 1 with two of them in a horizon.
    fn family() -> Body {
        let steps = || (-2..=2).flat_map(|i: i32| (-2..=2).map(move |j: i32| (i, j)));
        let bonds = steps().filter(|(i, j)| (1..=4).contains(&(i * i + j * j)));
        let bond = |(i, j)| Bond {
            from: 0,
            to: 0,
            xi: [f64::from(i), f64::from(j), 0.0],
            weight: 1.0,
        };
        Body {
            nodes: vec![Node {
                position: [0.0; 3],
                volume: 1.0,
            }],
            bonds: bonds.map(bond).collect(),
        }
    }

    fn asked<A>(text: &str, question: impl Fn(&Oracle, &State) -> A) -> A {
        let checked = front::file(text);
        assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
        let law = &checked.laws[0];
        let constant: InfluenceFn = front::influences()[0].clone();
        let settings = Settings {
            flavour: Flavour::PlaneStrain,
            params: vec![3.0; law.params.len()],
            influences: law
                .influences
                .iter()
                .map(|_| (constant.clone(), vec![]))
                .collect(),
            horizon: 2.0,
            ball: Ball::Integral { cross: 1.0 },
            without: Vec::new(),
        };
        let body = family();
        let oracle = Oracle::new(law, &body, &settings).expect("an oracle");
        question(&oracle, &oracle.state())
    }

    fn stiffness(text: &str, k: [f64; 3]) -> Matrix {
        asked(text, |oracle, state| {
            oracle.wave_stiffness(state, k, false).expect("a stiffness")
        })
    }

    const K: [f64; 3] = [0.7, 1.9, 0.0];

    fn phase(b: &Bond) -> f64 {
        K[0] * b.xi[0] + K[1] * b.xi[1]
    }

    fn close(found: &Matrix, expected: impl Fn(usize, usize) -> f64) {
        for a in 0..2 {
            for b in 0..2 {
                let (found, expected) = (found[a][b], expected(a, b));
                assert!(
                    (found.re - expected).abs() < 1e-12 && found.im.abs() < 1e-12,
                    "{a}{b}: {found:?} is not {expected}"
                );
            }
        }
    }

    /// Springs: an energy, a pair force and a force state are the same, and `M = 3 sum(m m (1 - cos k.xi)/x)`.
    #[test]
    fn springs_have_the_stiffness_of_their_stencil() {
        let expected = |a: usize, b: usize| -> f64 {
            let one = |bond: &Bond| {
                let x = bond.length();
                3.0 * bond.xi[a] * bond.xi[b] / x.powi(3) * (1.0 - phase(bond).cos())
            };
            family().bonds.iter().map(one).sum()
        };
        for response in [
            "energy W = K*sum(x*s^2)/4",
            "pair f = K*s",
            "state T = K*s/2",
            "energy W = K*sum(x*s^2)/8 pair f = K*s/2",
        ] {
            let text =
                format!("model m \"M\" cite \"A, eq. 1\" {{ param K : [N/m^6] \"K\" {response} }}");
            close(&stiffness(&text, K), expected);
        }
    }

    /// `f = sum(T - T')` with `T = 2 K s xi`, `s` the sum of the dilatations of the other ends: with `q = sum(xi sin k.xi)`
    /// the amplitude of `theta` is `i q.u`, and `M = 2 K q q sum(cos k.xi)`.
    #[test]
    fn what_is_read_at_the_other_end_has_its_phase() {
        let sum = |f: &dyn Fn(&Bond) -> f64| family().bonds.iter().map(f).sum::<f64>();
        let q = |a: usize| sum(&|b| b.xi[a] * phase(b).sin());
        let cosines = sum(&|b| phase(b).cos());
        let text = "model m \"M\" cite \"A, eq. 1\" {
            param K : [Pa/m^13] \"K\"
            node theta = sum(dot(xi, eta))
            node beyond = sum(theta')
            state T : vector = 2*K*beyond*xi
        }";
        close(&stiffness(text, K), |a, b| 6.0 * q(a) * q(b) * cosines);
    }

    /// What flows along bonds: `h = (T' - T)/2` gives the rate `sum(T' - T)`.
    #[test]
    fn a_field_decays_by_its_rate() {
        let text = "model m \"M\" cite \"A, eq. 1\" {
            field T : temperature \"T\"
            param a : frequency \"a\"
            bond h = a*(T' - T)/2
            rate T = flow(h)/sum(1)
        }";
        let rate = asked(text, |oracle, state| {
            oracle
                .wave_rate(state, FieldId(0), K, false)
                .expect("a rate")
        });
        let bonds = family().bonds;
        let mean = bonds.iter().map(|b| 1.0 - phase(b).cos()).sum::<f64>() / bonds.len() as f64;
        let rate = rate.expect("the field has one");
        assert!(
            (rate.re - 3.0 * mean).abs() < 1e-12 && rate.im.abs() < 1e-12,
            "{rate:?}"
        );
    }

    /// What is divided by a number of bonds is nothing in a continuum.
    #[test]
    fn a_continuum_has_bonds_without_number() {
        let text = "model m \"M\" cite \"A, eq. 1\" { param K : [N/m^6] \"K\" node n = count(x > 0) state T = K*s/n }";
        let [counted, dense] = [false, true].map(|dense| {
            asked(text, |oracle, state| {
                oracle.wave_stiffness(state, K, dense).expect("a stiffness")[0][0].re
            })
        });
        assert!(counted > 0.0 && dense == 0.0, "{counted}, {dense}");
    }

    #[test]
    fn a_wave_needs_a_single_node() {
        let text = "model m \"M\" cite \"A, eq. 1\" { param K : [N/m^6] \"K\" pair f = K*s }";
        let law = &front::file(text).laws[0];
        let body = Body {
            nodes: vec![family().nodes[0]; 2],
            bonds: Vec::new(),
        };
        let settings = Settings {
            flavour: Flavour::PlaneStrain,
            params: vec![1.0],
            influences: Vec::new(),
            horizon: 2.0,
            ball: Ball::Integral { cross: 1.0 },
            without: Vec::new(),
        };
        let oracle = Oracle::new(law, &body, &settings).expect("an oracle");
        let error = oracle
            .wave_stiffness(&oracle.state(), K, false)
            .expect_err("two");
        assert!(error.0.contains("one node"), "{error}");
    }
}
