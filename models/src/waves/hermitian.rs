//! Eigenvalues and eigenvectors of Hermitian matrices of up to three rows, by Jacobi's rotations.

use pdlang::oracle::Complex;

/// An entry over the largest one that is none.
const ROUNDING: f64 = 1e-14;

/// Row, column.
pub type Matrix = [[f64; 3]; 3];

/// A matrix with its imaginary part; rows and columns from `size` on are not looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hermitian {
    pub size: usize,
    pub re: Matrix,
    pub im: Matrix,
}

/// An eigenvalue and its unit eigenvector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    pub value: f64,
    pub vector: [Complex; 3],
}

impl Pair {
    /// Square of the magnitude of the projection on another vector.
    pub fn overlap(&self, other: &[Complex; 3]) -> f64 {
        let zero = Complex { re: 0.0, im: 0.0 };
        let product = (0..3).fold(zero, |sum, a| sum + self.vector[a].conjugate() * other[a]);
        product.re * product.re + product.im * product.im
    }

    /// `v . M v` of a matrix, which is real.
    pub fn expectation(&self, m: &Hermitian) -> f64 {
        let mut sum = 0.0;
        for i in 0..m.size {
            for j in 0..m.size {
                let entry = Complex {
                    re: m.re[i][j],
                    im: m.im[i][j],
                };
                sum += (self.vector[i].conjugate() * entry * self.vector[j]).re;
            }
        }
        sum
    }
}

impl Hermitian {
    /// The Hermitian part of any matrix, and the largest entry of what is left over that of the matrix.
    pub fn part(size: usize, re: Matrix, im: Matrix) -> (Hermitian, f64) {
        let mut part = Hermitian {
            size,
            ..Hermitian::default()
        };
        let (mut rest, mut scale) = (0.0_f64, 0.0_f64);
        for i in 0..size {
            for j in 0..size {
                part.re[i][j] = 0.5 * (re[i][j] + re[j][i]);
                part.im[i][j] = 0.5 * (im[i][j] - im[j][i]);
                let left = (re[i][j] - part.re[i][j]).abs();
                rest = rest.max(left.max((im[i][j] - part.im[i][j]).abs()));
                scale = scale.max(re[i][j].abs().max(im[i][j].abs()));
            }
        }
        (part, if scale > 0.0 { rest / scale } else { 0.0 })
    }

    /// The matrix without entries that are rounding, which would turn vectors of equal values at random.
    fn rounded(mut self) -> Hermitian {
        let all = self.re.iter().chain(&self.im).flatten();
        let scale = all.fold(0.0_f64, |m, v| m.max(v.abs()));
        let tiny = |v: &&mut f64| v.abs() <= ROUNDING * scale;
        let entries = self.re.iter_mut().chain(&mut self.im).flatten();
        entries.filter(tiny).for_each(|v| *v = 0.0);
        self
    }

    /// Ascending.
    pub fn pairs(&self) -> Vec<Pair> {
        self.rounded().jacobi()
    }

    fn jacobi(&self) -> Vec<Pair> {
        let n = self.size;
        let real = self.im.iter().flatten().all(|v| *v == 0.0);
        let mut pairs: Vec<Pair> = if real {
            let (values, vectors) = jacobi(self.re);
            let pair = |k: usize| Pair {
                value: values[k],
                vector: std::array::from_fn(|a| Complex {
                    re: vectors[a][k],
                    im: 0.0,
                }),
            };
            (0..n).map(pair).collect()
        } else {
            // [re, -im; im, re] has every value twice.
            let entry = |i: usize, j: usize| match (i / 3, j / 3) {
                (0, 1) => -self.im[i][j - 3],
                (1, 0) => self.im[i - 3][j],
                _ => self.re[i % 3][j % 3],
            };
            let whole: [[f64; 6]; 6] =
                std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
            let (values, vectors) = jacobi(whole);
            let pair = |k: usize| Pair {
                value: values[k],
                vector: std::array::from_fn(|a| Complex {
                    re: vectors[a][k],
                    im: vectors[a + 3][k],
                }),
            };
            let mut all: Vec<Pair> = (0..6).filter(|k| k % 3 < n).map(pair).collect();
            all.sort_by(|a, b| a.value.total_cmp(&b.value));
            independent(&all, n)
        };
        pairs.sort_by(|a, b| a.value.total_cmp(&b.value));
        pairs
    }
}

/// Of vectors that come twice, up to a factor `i`, one each: what the ones before leave of it is the longest.
fn independent(all: &[Pair], count: usize) -> Vec<Pair> {
    let mut kept: Vec<Pair> = Vec::new();
    for pair in all {
        let mut vector = pair.vector;
        for other in &kept {
            let zero = Complex { re: 0.0, im: 0.0 };
            let along = (0..3).fold(zero, |sum, a| sum + other.vector[a].conjugate() * vector[a]);
            vector = std::array::from_fn(|a| vector[a] - other.vector[a] * along);
        }
        let length = vector
            .iter()
            .map(|z| z.re * z.re + z.im * z.im)
            .sum::<f64>()
            .sqrt();
        if length > 0.5 && kept.len() < count {
            let scale = Complex {
                re: 1.0 / length,
                im: 0.0,
            };
            kept.push(Pair {
                value: pair.value,
                vector: vector.map(|z| z * scale),
            });
        }
    }
    kept
}

/// Values, and vectors as columns, of a symmetric matrix.
fn jacobi<const N: usize>(mut m: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut vectors: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..30 {
        for p in 0..N {
            for q in p + 1..N {
                if m[p][q] == 0.0 {
                    continue;
                }
                // The smaller of the two angles, so that what is diagonal already keeps its order.
                let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let (cos, sin) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
                for row in m.iter_mut().chain(&mut vectors) {
                    (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
                }
                for j in 0..N {
                    (m[p][j], m[q][j]) =
                        (cos * m[p][j] - sin * m[q][j], sin * m[p][j] + cos * m[q][j]);
                }
                (m[p][q], m[q][p]) = (0.0, 0.0);
            }
        }
    }
    (std::array::from_fn(|k| m[k][k]), vectors)
}
