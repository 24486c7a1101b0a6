//! What is answered, and how far two answers are apart.

/// Answers in the order of the body's nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    pub force: Vec<[f64; 3]>,
    pub energy: Vec<f64>,
    pub tangent: Vec<[f64; 3]>,
    /// Time derivative of each field component, per node, in the order of the fields.
    pub rates: Vec<Vec<f64>>,
    /// Velocities after the step, of a law that replaces them.
    pub velocity: Vec<[f64; 3]>,
    /// Bonds that break when they may.
    pub breaks: usize,
}

/// What differences are measured against.
#[derive(Clone, Debug, Default)]
pub struct Scale {
    /// max_i sum_j |f_ij| V_j [N/m^3].
    pub force: f64,
    /// Largest energy density, tangent component, rate and velocity.
    pub energy: f64,
    pub tangent: f64,
    pub rates: f64,
    pub velocity: f64,
}

/// Largest differences of two answers, relative to a scale.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    pub force: f64,
    pub energy: f64,
    pub tangent: f64,
    pub rates: f64,
    pub velocity: f64,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Difference {
            force,
            energy,
            tangent,
            rates,
            velocity,
        } = self;
        write!(
            f,
            "force {force:.1e}, energy {energy:.1e}, tangent {tangent:.1e}, rates {rates:.1e}, velocity {velocity:.1e}"
        )
    }
}

impl Difference {
    pub fn worst(self) -> f64 {
        let mechanical = [self.force, self.energy, self.tangent];
        mechanical
            .into_iter()
            .chain([self.rates, self.velocity])
            .fold(0.0, f64::max)
    }

    /// The larger of each.
    pub fn max(self, other: Difference) -> Difference {
        Difference {
            force: self.force.max(other.force),
            energy: self.energy.max(other.energy),
            tangent: self.tangent.max(other.tangent),
            rates: self.rates.max(other.rates),
            velocity: self.velocity.max(other.velocity),
        }
    }
}

/// Largest difference over a scale; what one side does not answer is not compared. Anything but a
/// finite number is infinitely wrong.
fn relative(a: &[f64], b: &[f64], scale: f64) -> f64 {
    if a.is_empty() || b.is_empty() {
        return 0.0;
    }
    assert_eq!(a.len(), b.len());
    let gap = |(x, y): (&f64, &f64)| {
        if (x - y).is_finite() {
            (x - y).abs()
        } else {
            f64::INFINITY
        }
    };
    let worst = a.iter().zip(b).map(gap).fold(0.0, f64::max);
    if worst == 0.0 { 0.0 } else { worst / scale }
}

impl Answer {
    pub fn difference(&self, other: &Answer, scale: &Scale) -> Difference {
        let flat = |v: &[[f64; 3]]| v.as_flattened().to_vec();
        Difference {
            force: relative(&flat(&self.force), &flat(&other.force), scale.force),
            energy: relative(&self.energy, &other.energy, scale.energy),
            tangent: relative(&flat(&self.tangent), &flat(&other.tangent), scale.tangent),
            rates: relative(&self.rates.concat(), &other.rates.concat(), scale.rates),
            velocity: relative(
                &flat(&self.velocity),
                &flat(&other.velocity),
                scale.velocity,
            ),
        }
    }
}
