//! The coefficients of a condition that a wave fulfils as it leaves, and how a node is stepped by it.

/// How boundary nodes are stepped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// By the mean of a step's two ends: stable at any step, of second order.
    #[default]
    Trapezoidal,
    /// By what is known first: adds a reflection that vanishes with the step only. A control.
    Explicit,
}

/// `sum c_j u'_j = sum b_j u_j` over a node (`j = 0`) and its neighbours inwards, to the order `N`.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// `c_0 = 1` to `c_N`; the same from both ends.
    pub c: Vec<f64>,
    /// `b_0` to `b_N` [1/s]; turned in sign from both ends.
    pub b: Vec<f64>,
}

/// Coefficients `a_1, a_3, ..` of `Omega = a_1 k - a_3 k^3 + a_5 k^5 - ..` of a scalar wave, in `i Omega = a_1 (ik) + a_3
/// (ik)^3 + ..`, from those of `Omega^2 = p_1 k^2 + p_2 k^4 + ..`. `a_1` is the speed [m/s]; empty where there is none.
pub fn root_series(p: &[f64]) -> Vec<f64> {
    let Some(first) = p.first().filter(|p| **p > 0.0) else {
        return Vec::new();
    };
    // (i Omega)^2 in powers of (ik)^2 has the signs of p turned at every second one.
    let signed = |m: usize| if m.is_multiple_of(2) { p[m] } else { -p[m] };
    let mut a = vec![first.sqrt()];
    for m in 1..p.len() {
        let products: f64 = (1..m).map(|r| a[r] * a[m - r]).sum();
        a.push((signed(m) - products) / (2.0 * a[0]));
    }
    a
}

impl Coefficients {
    /// Those of the order `n` for a wave of the series [`root_series`], of which as many as the order are read, on planes
    /// `spacing` apart. `None` where there is no wave, or the equations are singular.
    ///
    /// About the middle of its nodes the condition reads `Omega C(k) = B(k)` with `C = sum c_j cos(d_j k)` and `B = - sum
    /// b_j sin(d_j k)`, `d_j = N/2 - j`: all even orders hold by symmetry, and the first `N` odd ones are the equations.
    pub fn of(series: &[f64], n: usize, spacing: f64) -> Option<Coefficients> {
        if n == 0 || series.len() < n {
            return None;
        }
        // In 1/s, the phase from plane to plane standing for the wave number.
        let scaled = |m: usize| series[m] / spacing.powi(2 * m as i32 + 1);
        let a: Vec<f64> = (0..n).map(|m| scaled(m) / scaled(0)).collect();
        let shift = |j: usize| 0.5 * n as f64 - j as f64;
        // A node and the one that mirrors it.
        let twins = |j: usize| if 2 * j == n { 1.0 } else { 2.0 };
        let (halves, free) = (n.div_ceil(2), n / 2);
        let moving = |j: usize, p: usize| {
            let term = |m: usize| a[m] * power(shift(j), 2 * (p - m));
            twins(j) * (0..=p).map(term).sum::<f64>()
        };
        let still = |j: usize, p: usize| 2.0 * power(shift(j), 2 * p + 1);
        let row = |p: usize| {
            let c = (1..=free).map(|j| moving(j, p));
            let b = (0..halves).map(|j| still(j, p));
            c.chain(b).chain([-moving(0, p)]).collect()
        };
        let found = solve((0..n).map(row).collect())?;
        let c = |j: usize| match j.min(n - j) {
            0 => 1.0,
            k => found[k - 1],
        };
        let b = |j: usize| match (2 * j).cmp(&n) {
            std::cmp::Ordering::Less => found[free + j] * scaled(0),
            std::cmp::Ordering::Equal => 0.0,
            std::cmp::Ordering::Greater => -found[free + n - j] * scaled(0),
        };
        Some(Coefficients {
            c: (0..=n).map(c).collect(),
            b: (0..=n).map(b).collect(),
        })
    }

    pub fn order(&self) -> usize {
        self.c.len() - 1
    }

    /// Amplitude of what comes back, over that of a wave of the frequency `omega` [rad/s] whose phase turns by `phase`
    /// from plane to plane.
    pub fn reflection(&self, phase: f64, omega: f64) -> f64 {
        let n = self.order() as f64;
        let (mut c, mut b) = (0.0, 0.0);
        for (j, (cj, bj)) in self.c.iter().zip(&self.b).enumerate() {
            let (sin, cos) = ((0.5 * n - j as f64) * phase).sin_cos();
            c += cj * cos;
            b -= bj * sin;
        }
        ((omega * c - b) / (omega * c + b)).abs()
    }
}

/// Conditions one behind the other, as a step of time takes them: weights of a node and its neighbours inwards at the
/// end of the step, at its start, and a step before for every further condition.
///
/// A condition is an operator on steps of space and time; what fulfils any of two is nothing to their product.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    /// By neighbour, then by time; all over that of the node itself at the end of the step.
    weights: Vec<f64>,
    /// Neighbours inwards.
    pub reach: usize,
    /// Times: one more than conditions.
    pub times: usize,
}

impl Steps {
    pub fn of(conditions: &[Coefficients], rule: Rule, dt: f64) -> Steps {
        let mut all = Steps {
            weights: vec![1.0],
            reach: 0,
            times: 1,
        };
        for condition in conditions {
            all = all.times(condition, rule, dt);
        }
        let own = all.weights[0];
        all.weights.iter_mut().for_each(|w| *w /= own);
        all
    }

    fn times(&self, condition: &Coefficients, rule: Rule, dt: f64) -> Steps {
        let (reach, times) = (self.reach + condition.order(), self.times + 1);
        let mut weights = vec![0.0; (reach + 1) * times];
        for (j, (c, b)) in condition.c.iter().zip(&condition.b).enumerate() {
            let [end, start] = match rule {
                Rule::Trapezoidal => [c - 0.5 * dt * b, -c - 0.5 * dt * b],
                Rule::Explicit if j == 0 => [*c, -c - dt * b],
                Rule::Explicit => [c - dt * b, -c],
            };
            for (k, w) in self.weights.iter().enumerate() {
                let (i, t) = (k / self.times, k % self.times);
                let at = (i + j) * times + t;
                weights[at] += end * w;
                weights[at + 1] += start * w;
            }
        }
        Steps {
            weights,
            reach,
            times,
        }
    }

    /// How far a node goes in a step from `own`; `at(j, t)` is where its neighbour `j` is or was at the time `t`, 0 being
    /// the end of the step and 1 its start.
    ///
    /// Written in differences: a body that is carried along stays whole to the last bit.
    #[inline]
    pub fn went(&self, own: f64, at: impl Fn(usize, usize) -> f64) -> f64 {
        let others = self.weights.iter().enumerate().skip(2);
        -others
            .map(|(k, w)| w * (at(k / self.times, k % self.times) - own))
            .sum::<f64>()
    }
}

/// `x^n / n!`
fn power(x: f64, n: usize) -> f64 {
    (1..=n).fold(1.0, |p, k| p * x / k as f64)
}

/// Solves a few equations, each with its right side at the end.
fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    // Equations of high orders have small numbers.
    for row in &mut rows {
        let largest = row[..n].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        row.iter_mut().for_each(|v| *v /= largest);
    }
    for k in 0..n {
        let best = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs()))?;
        rows.swap(k, best);
        let pivot = rows[k].clone();
        if pivot[k].is_nan() || pivot[k].abs() <= 1e-10 {
            return None;
        }
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k] / pivot[k];
            row.iter_mut()
                .zip(&pivot)
                .for_each(|(v, p)| *v -= factor * p);
        }
    }
    Some((0..n).map(|k| rows[k][n] / rows[k][k]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: &[f64], b: &[f64], within: f64) {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= within * b.abs().max(1.0), "{a} {b}");
        }
    }

    /// The chain of springs: `c = 1, 6, 1` and so on.
    #[test]
    fn coefficients_of_a_chain_of_springs() {
        // 2 sin(k/2) times the root of 2.
        let a = [
            2f64.sqrt(),
            2f64.sqrt() / 24.0,
            2f64.sqrt() / 1920.0,
            2f64.sqrt() / 322_560.0,
        ];
        let tables: [(&[f64], &[f64]); 4] = [
            (&[1.0, 1.0], &[-2.828_427_12]),
            (&[1.0, 6.0, 1.0], &[-5.656_854_25, 0.0]),
            (&[1.0, 15.0, 15.0, 1.0], &[-8.485_281_37, -19.798_989_87]),
            (
                &[1.0, 28.0, 70.0, 28.0, 1.0],
                &[-11.313_708_5, -67.882_250_99, 0.0],
            ),
        ];
        for (n, (c, b)) in tables.iter().enumerate() {
            let found = Coefficients::of(&a, n + 1, 1.0).unwrap();
            close(&found.c, c, 1e-9);
            close(&found.b[..b.len()], b, 5e-9);
        }
    }

    /// The closed forms I1 to I9 of the paper's appendix (the last term of I9 as 4 a1^3 D^6).
    #[test]
    fn coefficients_are_the_closed_forms() {
        let (a1, a3, a5, a7) = (1.3_f64, 0.31, 0.07, 0.011);
        for d in [1.0_f64, 0.6] {
            let q = 25200.0 * (a5 * a5 - a3 * a7)
                + 4200.0 * (-a3 * a5 + a1 * a7) * d * d
                + 35.0 * (3.0 * a3 * a3 + 8.0 * a1 * a5) * d.powi(4)
                + 5.0 * a1 * a3 * d.powi(6)
                - 2.0 * a1 * a1 * d.powi(8);
            let i1 = 4.0 * (a1 * d * d + 3.0 * a3) / (a1 * d * d - 6.0 * a3);
            let i2 = -3.0 * a1 * a1 * d / (a1 * d * d - 6.0 * a3);
            let i3 = 3.0 * (3.0 * a1 * d.powi(4) + 40.0 * (a3 * d * d + a5))
                / (a1 * d.powi(4) - 120.0 * a5);
            let i4 = (720.0 * (a3 * a3 - a1 * a5)
                + 120.0 * a1 * a3 * d * d
                + 11.0 * a1 * a1 * d.powi(4))
                / (360.0 * a5 * d - 3.0 * a1 * d.powi(5));
            let i5 = 3.0
                * (-240.0 * a3 * a3
                    + 240.0 * a1 * a5
                    + 40.0 * a1 * a3 * d * d
                    + 3.0 * a1 * a1 * d.powi(4))
                / (d * (120.0 * a5 - a1 * d.powi(4)));
            let i6 = 8.0
                * (12600.0 * (-a5 * a5 + a3 * a7)
                    + 1050.0 * (-a3 * a5 + a1 * a7) * d * d
                    + 35.0 * (21.0 * a3 * a3 - 19.0 * a1 * a5) * d.powi(4)
                    - 55.0 * a1 * a3 * d.powi(6)
                    - 4.0 * a1 * a1 * d.powi(8))
                / q;
            let i7 = 6.0
                * (25200.0 * (a5 * a5 - a3 * a7)
                    + 4200.0 * (a3 * a5 - a1 * a7) * d * d
                    + 315.0 * (7.0 * a3 * a3 - 8.0 * a1 * a5) * d.powi(4)
                    - 205.0 * a1 * a3 * d.powi(6)
                    - 12.0 * a1 * a1 * d.powi(8))
                / q;
            let cubic = a3.powi(3) - 2.0 * a1 * a3 * a5 + a1 * a1 * a7;
            let tail = 63.0 * a1 * a1 * a3 * d.powi(4);
            let i8 = 5.0 * d * (-7560.0 * cubic + tail + 5.0 * a1.powi(3) * d.powi(6)) / (3.0 * q);
            let i9 = 40.0
                * d
                * (1890.0 * cubic
                    + 945.0 * a1 * (-a3 * a3 + a1 * a5) * d * d
                    + tail
                    + 4.0 * a1.powi(3) * d.powi(6))
                / (3.0 * q);
            let a = [a1, a3, a5, a7];
            let found = |n| Coefficients::of(&a, n, d).unwrap();
            close(&found(1).b, &[-2.0 * a1 / d, 2.0 * a1 / d], 1e-12);
            close(&found(2).c, &[1.0, i1, 1.0], 1e-9);
            close(&found(2).b, &[i2, 0.0, -i2], 1e-9);
            close(&found(3).c, &[1.0, i3, i3, 1.0], 1e-9);
            close(&found(3).b, &[i4, i5, -i5, -i4], 1e-9);
            close(&found(4).c, &[1.0, i6, i7, i6, 1.0], 1e-7);
            close(&found(4).b, &[i8, i9, 0.0, -i9, -i8], 1e-7);
        }
    }

    #[test]
    fn a_singular_order_has_none() {
        assert_eq!(Coefficients::of(&[6.0, 1.0], 2, 1.0), None);
        assert_eq!(Coefficients::of(&[], 1, 1.0), None);
        assert!(root_series(&[0.0, 1.0]).is_empty());
    }

    #[test]
    fn a_body_that_is_carried_along_stays_whole() {
        let one = Coefficients::of(&[1.3, 0.2, 0.1], 3, 0.7).unwrap();
        let two = Coefficients::of(&[0.6, 0.1], 1, 0.7).unwrap();
        for conditions in [vec![one.clone()], vec![two, one]] {
            for rule in [Rule::Trapezoidal, Rule::Explicit] {
                let steps = Steps::of(&conditions, rule, 0.1);
                assert_eq!(steps.went(0.3, |_, _| 0.3), 0.0);
            }
        }
    }

    /// A wave `(x + c t)^2` fulfils a condition of its speed to rounding, and a product of two conditions where it
    /// fulfils either.
    #[test]
    fn waves_of_their_speed_leave_unseen() {
        let dt = 0.1;
        let of = |speed: f64| Coefficients::of(&[speed], 1, 1.0).unwrap();
        let wave =
            |speed: f64| move |j: usize, t: usize| (j as f64 - speed * dt * t as f64).powi(2);
        for (conditions, speed) in [
            (vec![of(2.0)], 2.0),
            (vec![of(2.0), of(3.0)], 2.0),
            (vec![of(2.0), of(3.0)], 3.0),
        ] {
            let steps = Steps::of(&conditions, Rule::Trapezoidal, dt);
            let off = |speed: f64| {
                let own = wave(speed)(0, 1);
                (own + steps.went(own, wave(speed)) - wave(speed)(0, 0)).abs()
            };
            assert!(off(speed) < 1e-14);
            assert!(off(1.0) > 1e-3, "{}", off(1.0));
        }
    }
}
