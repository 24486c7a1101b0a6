//! Scalars, vectors and tensors of the scene's dimension, and their algebra.

use super::Error;
use super::number::Real;
use crate::ir::FLAT;

/// A value of the language. Components beyond the dimension are zero and never read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<T> {
    Scalar(T),
    Vector([T; 3]),
    /// Row, column; symmetric tensors are stored whole.
    Tensor([[T; 3]; 3]),
    Boolean(bool),
}

use Value::{Scalar, Tensor, Vector};

pub(super) fn zero_vector<T: Real>() -> [T; 3] {
    [T::constant(0.0); 3]
}

pub(super) fn zero_tensor<T: Real>() -> [[T; 3]; 3] {
    [zero_vector(); 3]
}

fn mismatch<A>(operation: &str) -> Result<A, Error> {
    Err(Error(format!(
        "the operands of `{operation}` have shapes that do not fit"
    )))
}

impl Value<f64> {
    /// The same value without derivatives.
    pub(super) fn lift<T: Real>(self) -> Value<T> {
        match self {
            Scalar(a) => Scalar(T::constant(a)),
            Vector(a) => Vector(a.map(T::constant)),
            Tensor(a) => Tensor(a.map(|row| row.map(T::constant))),
            Value::Boolean(a) => Value::Boolean(a),
        }
    }
}

impl<T: Real> Value<T> {
    pub fn scalar(self) -> Result<T, Error> {
        match self {
            Scalar(a) => Ok(a),
            _ => mismatch("scalar"),
        }
    }

    pub fn vector(self) -> Result<[T; 3], Error> {
        match self {
            Vector(a) => Ok(a),
            _ => mismatch("vector"),
        }
    }

    pub fn tensor(self) -> Result<[[T; 3]; 3], Error> {
        match self {
            Tensor(a) => Ok(a),
            _ => mismatch("tensor"),
        }
    }

    pub fn boolean(self) -> Result<bool, Error> {
        match self {
            Value::Boolean(a) => Ok(a),
            _ => mismatch("Boolean"),
        }
    }

    /// True when every component is exactly zero.
    pub(super) fn is_zero(self) -> bool {
        match self {
            Scalar(a) => a.value() == 0.0,
            Vector(a) => a.iter().all(|x| x.value() == 0.0),
            Tensor(a) => a.iter().flatten().all(|x| x.value() == 0.0),
            Value::Boolean(_) => false,
        }
    }

    /// Zero of the same shape.
    pub(super) fn zeroed(self) -> Value<T> {
        self.map(|_| T::constant(0.0))
    }

    pub(super) fn map(self, f: impl Fn(T) -> T) -> Value<T> {
        match self {
            Scalar(a) => Scalar(f(a)),
            Vector(a) => Vector(a.map(f)),
            Tensor(a) => Tensor(a.map(|row| row.map(&f))),
            Value::Boolean(a) => Value::Boolean(a),
        }
    }

    fn zip(self, other: Value<T>, name: &str, f: impl Fn(T, T) -> T) -> Result<Value<T>, Error> {
        let rows = |a: [T; 3], b: [T; 3]| std::array::from_fn(|k| f(a[k], b[k]));
        match (self, other) {
            (Scalar(a), Scalar(b)) => Ok(Scalar(f(a, b))),
            (Vector(a), Vector(b)) => Ok(Vector(rows(a, b))),
            (Tensor(a), Tensor(b)) => Ok(Tensor(std::array::from_fn(|k| rows(a[k], b[k])))),
            _ => mismatch(name),
        }
    }

    pub(super) fn add(self, other: Value<T>) -> Result<Value<T>, Error> {
        self.zip(other, "+", |a, b| a + b)
    }

    pub(super) fn sub(self, other: Value<T>) -> Result<Value<T>, Error> {
        self.zip(other, "-", |a, b| a - b)
    }

    pub(super) fn scaled(self, factor: T) -> Value<T> {
        self.map(|a| a * factor)
    }

    /// Scalar times anything, tensor times tensor, tensor times vector.
    pub(super) fn mul(self, other: Value<T>) -> Result<Value<T>, Error> {
        match (self, other) {
            (Scalar(a), b) => Ok(b.scaled(a)),
            (a, Scalar(b)) => Ok(a.scaled(b)),
            (Tensor(a), Tensor(b)) => Ok(Tensor(product(a, b))),
            (Tensor(a), Vector(b)) => Ok(Vector(a.map(|row| inner(row, b)))),
            _ => mismatch("*"),
        }
    }

    pub(super) fn div(self, other: Value<T>) -> Result<Value<T>, Error> {
        let divisor = other.scalar()?;
        Ok(self.map(|a| a / divisor))
    }

    /// Euclidean length of a vector, Frobenius norm of a tensor, magnitude of a scalar.
    pub(super) fn norm(self) -> Result<T, Error> {
        match self {
            Scalar(a) => Ok(a.abs()),
            _ => Ok(self.dot(self)?.sqrt()),
        }
    }

    /// Inner product of two vectors, double contraction of two tensors.
    pub(super) fn dot(self, other: Value<T>) -> Result<T, Error> {
        match (self, other) {
            (Scalar(a), Scalar(b)) => Ok(a * b),
            (Vector(a), Vector(b)) => Ok(inner(a, b)),
            (Tensor(a), Tensor(b)) => Ok(inner(a[0], b[0]) + inner(a[1], b[1]) + inner(a[2], b[2])),
            _ => mismatch("dot"),
        }
    }

    pub(super) fn outer(self, other: Value<T>) -> Result<Value<T>, Error> {
        let (a, b) = (self.vector()?, other.vector()?);
        Ok(Tensor(a.map(|x| b.map(|y| x * y))))
    }

    pub(super) fn trace(self) -> Result<T, Error> {
        let a = self.tensor()?;
        Ok(a[0][0] + a[1][1] + a[2][2])
    }

    pub(super) fn transpose(self) -> Result<Value<T>, Error> {
        let a = self.tensor()?;
        Ok(Tensor(std::array::from_fn(|i| {
            std::array::from_fn(|k| a[k][i])
        })))
    }

    /// The diagonal tensor of a vector; the vector on the diagonal of a tensor.
    pub(super) fn diagonal(self) -> Result<Value<T>, Error> {
        match self {
            Vector(v) => {
                let mut a = zero_tensor();
                (0..3).for_each(|k| a[k][k] = v[k]);
                Ok(Tensor(a))
            }
            _ => {
                let a = self.tensor()?;
                Ok(Vector(std::array::from_fn(|k| a[k][k])))
            }
        }
    }

    pub(super) fn symmetric_part(self) -> Result<Value<T>, Error> {
        Ok(self.add(self.transpose()?)?.scaled(T::constant(0.5)))
    }

    /// The part without trace, in `dim` dimensions.
    pub(super) fn deviator(self, dim: usize) -> Result<Value<T>, Error> {
        let mean = self.trace()? / T::constant(dim as f64);
        self.sub(identity(dim).scaled(mean))
    }

    pub(super) fn determinant(self, dim: usize) -> Result<T, Error> {
        let a = self.tensor()?;
        Ok(match dim {
            1 => a[0][0],
            2 => a[0][0] * a[1][1] - a[0][1] * a[1][0],
            _ => inner(a[0], cross(a[1], a[2])),
        })
    }

    /// Whether its rows lie in a line or a plane, by the measure of [`FLAT`].
    pub(super) fn is_flat(self, dim: usize) -> Result<bool, Error> {
        let (a, det) = (self.tensor()?, self.determinant(dim)?);
        let largest = (a.iter().flatten()).fold(0.0_f64, |most, c| most.max(c.value().abs()));
        Ok(det.value().abs() <= FLAT * largest.powi(dim as i32))
    }

    /// Inverse by cofactors. A tensor with determinant exactly zero has infinite components.
    pub(super) fn inverse(self, dim: usize) -> Result<Value<T>, Error> {
        let (a, det) = (self.tensor()?, self.determinant(dim)?);
        let mut inverse = zero_tensor();
        match dim {
            1 => inverse[0][0] = T::constant(1.0),
            2 => {
                inverse[0] = [a[1][1], -a[0][1], T::constant(0.0)];
                inverse[1] = [-a[1][0], a[0][0], T::constant(0.0)];
            }
            _ => {
                let columns = [cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])];
                inverse = std::array::from_fn(|i| std::array::from_fn(|k| columns[k][i]));
            }
        }
        Ok(Tensor(inverse).map(|c| c / det))
    }
}

pub(super) fn identity<T: Real>(dim: usize) -> Value<T> {
    let mut a = zero_tensor();
    for (k, row) in a.iter_mut().enumerate().take(dim) {
        row[k] = T::constant(1.0);
    }
    Tensor(a)
}

fn inner<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    std::array::from_fn(|k| {
        let (m, n) = ((k + 1) % 3, (k + 2) % 3);
        a[m] * b[n] - a[n] * b[m]
    })
}

fn product<T: Real>(a: [[T; 3]; 3], b: [[T; 3]; 3]) -> [[T; 3]; 3] {
    let column = |k: usize| [b[0][k], b[1][k], b[2][k]];
    a.map(|row| std::array::from_fn(|k| inner(row, column(k))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [[f64; 3]; 3] = [[2.0, 1.0, 0.5], [0.0, 3.0, -1.0], [1.0, 0.25, 4.0]];

    #[test]
    fn a_tensor_times_its_inverse_is_the_unit_tensor_in_every_dimension() {
        for dim in 1..=3 {
            let mut a = Tensor(A).tensor().unwrap();
            for (i, row) in a.iter_mut().enumerate() {
                for (k, x) in row.iter_mut().enumerate() {
                    if i >= dim || k >= dim {
                        *x = 0.0;
                    }
                }
            }
            let unit = Tensor(a).mul(Tensor(a).inverse(dim).unwrap()).unwrap();
            let error = unit.sub(identity(dim)).unwrap().norm().unwrap();
            assert!(error < 1e-15, "dimension {dim}: {error}");
        }
    }

    #[test]
    fn the_deviator_has_no_trace_and_the_symmetric_part_is_symmetric() {
        let deviator = Tensor(A).deviator(3).unwrap();
        assert!(deviator.trace().unwrap().abs() < 1e-15);
        let symmetric = Tensor(A).symmetric_part().unwrap();
        assert_eq!(symmetric, symmetric.transpose().unwrap());
        // det A by the rule of Sarrus: 24 - 1 + 0 - 1.5 + 0.5 - 0 = 22.
        assert_eq!(Tensor(A).determinant(3).unwrap(), 22.0);
    }

    #[test]
    fn a_diagonal_there_and_back() {
        let diagonal = Tensor(A).diagonal().unwrap();
        assert_eq!(diagonal, Vector([2.0, 3.0, 4.0]));
        let tensor = diagonal.diagonal().unwrap();
        assert_eq!(tensor.diagonal().unwrap(), diagonal);
        assert_eq!(tensor.trace().unwrap(), 9.0);
    }

    #[test]
    fn shapes_that_do_not_fit_are_an_error() {
        assert!(Vector([1.0; 3]).mul(Vector([1.0; 3])).is_err());
        assert!(Scalar(1.0).add(Vector([1.0; 3])).is_err());
        assert!(Value::<f64>::Boolean(true).scalar().is_err());
    }
}
