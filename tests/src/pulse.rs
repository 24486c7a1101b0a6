//! The one-dimensional pulse of the influence-function paper (Seleson and Parks 2011, section 4.1.3).
//!
//! Bar of 4001 nodes on [0, 1000], spacing 0.25, horizon 5, K = rho = 1, uniaxial strain with G = 3K/5,
//! softened influence function with eps = 1, velocity Verlet with dt = 0.1 from rest. The reference
//! displacements come from the exact solution of the time-discrete lattice.

pub const NODES: usize = 4001;
pub const DX: f64 = 0.25;
pub const DELTA: f64 = 5.0;
pub const EPS: f64 = 1.0;
pub const DT: f64 = 0.1;
/// Bond-based laws fix G = 3K/5; the axial modulus K + 4G/3 is then 9K/5.
pub const AXIAL_MODULUS: f64 = 9.0 / 5.0;

pub fn position(node: usize) -> f64 {
    DX * node as f64
}

/// The initial displacement: two smoothsteps of order ten that rise on [490, 500] and fall on [500, 510].
pub fn initial(x: f64) -> f64 {
    if x <= 490.0 || x >= 510.0 {
        return 0.0;
    }
    smoothstep(if x <= 500.0 {
        (x - 490.0) / 10.0
    } else {
        (510.0 - x) / 10.0
    })
}

/// sum_{k=11}^{21} C(21, k) t^k (1-t)^(21-k), from the end where its terms are small.
pub fn smoothstep(t: f64) -> f64 {
    if t > 0.5 {
        return 1.0 - smoothstep(1.0 - t);
    }
    let mut binomial = 1.0;
    let mut sum = 0.0;
    for k in 1..=21 {
        binomial *= f64::from(22 - k) / f64::from(k);
        if k >= 11 {
            sum += binomial * t.powi(k) * (1.0 - t).powi(21 - k);
        }
    }
    sum
}

/// gamma_p = (9K/5) / integral_0^delta r (r + eps)^-p dr, by the closed form (p other than 1 and 2).
pub fn gamma(p: f64) -> f64 {
    let power = |n: f64| ((DELTA + EPS).powf(n - p) - EPS.powf(n - p)) / (n - p);
    AXIAL_MODULUS / (power(2.0) - EPS * power(1.0))
}

/// A reference displacement.
pub struct Probe {
    pub x: f64,
    pub step: usize,
    /// Displacement for p = 0, 5, 20.
    pub u: [f64; 3],
}

const fn probe(x: f64, step: usize, u: [f64; 3]) -> Probe {
    Probe { x, step, u }
}

pub const EXPONENTS: [f64; 3] = [0.0, 5.0, 20.0];

/// Time-discrete solution by Fourier synthesis on 8192 nodes: u^ = g^ cos(n phi), cos phi = 1 - Omega^2 dt^2/2.
pub const PROBES: [Probe; 10] = [
    probe(
        540.0,
        500,
        [-0.051330060657, -0.006616357780, 0.112945244167],
    ),
    probe(565.0, 500, [0.462743581109, 0.597879431230, 0.0]),
    probe(630.0, 1000, [0.370555312336, 0.557437983898, 0.0]),
    probe(500.0, 2000, [0.033313892842, 5.070e-12, 5.166e-12]),
    probe(540.0, 2000, [-0.026418287572, 3.5675e-11, -6.586e-12]),
    probe(
        600.0,
        2000,
        [0.012229886891, 0.000000419996, -0.000000043357],
    ),
    probe(
        630.0,
        2000,
        [0.000770231391, -0.000007953616, 0.004517585391],
    ),
    probe(700.0, 2000, [0.021534661920, -0.005169471795, 0.0]),
    probe(765.0, 2000, [0.303180274663, 0.192159249562, 0.0]),
    probe(768.0, 2000, [0.324458680828, 0.077942249087, 0.0]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smoothstep_has_its_stated_values() {
        // S(1/4) = 0.00642271, S(0.3) = 0.02638994 to eight decimals, S(1/2) = 1/2.
        assert!((smoothstep(0.25) - 0.00642271).abs() < 5e-9);
        assert!((smoothstep(0.3) - 0.02638994).abs() < 5e-9);
        assert_eq!(initial(500.0), 1.0);
        assert!((initial(495.0) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_plain_loop_reproduces_the_probes() {
        for (column, p) in EXPONENTS.into_iter().enumerate() {
            let reach = (DELTA / DX) as usize;
            let stiffness: Vec<f64> = (1..=reach)
                .map(|j| gamma(p) / (j as f64 * DX) * (j as f64 * DX + EPS).powf(-p) * DX)
                .collect();
            let mut u: Vec<f64> = (0..NODES).map(|i| initial(position(i))).collect();
            let mut v = vec![0.0; NODES];
            let force = |u: &[f64], i: usize| -> f64 {
                let pull = |j: usize, c: f64| {
                    let left = if i >= j { u[i - j] - u[i] } else { 0.0 };
                    let right = if i + j < NODES { u[i + j] - u[i] } else { 0.0 };
                    c * (left + right)
                };
                stiffness
                    .iter()
                    .enumerate()
                    .map(|(k, c)| pull(k + 1, *c))
                    .sum()
            };
            let mut f: Vec<f64> = (0..NODES).map(|i| force(&u, i)).collect();
            for step in 1..=2000 {
                for i in 0..NODES {
                    v[i] += 0.5 * DT * f[i];
                    u[i] += DT * v[i];
                }
                f = (0..NODES).map(|i| force(&u, i)).collect();
                for i in 0..NODES {
                    v[i] += 0.5 * DT * f[i];
                }
                for probe in PROBES.iter().filter(|probe| probe.step == step) {
                    let got = u[(probe.x / DX) as usize];
                    assert!(
                        (got - probe.u[column]).abs() < 5e-12,
                        "p = {p}, x = {}: {got}",
                        probe.x
                    );
                }
            }
        }
    }
}
