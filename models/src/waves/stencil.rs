//! The stencil of a law on its lattice: how much the force density of a node changes as another one moves.
//!
//! Collected once, from the tangent of a single displaced node in a periodic box that is wider than what a law reaches
//! (a horizon for each sum that is read at the other end of a bond: two for a linear peridynamic solid). Everything
//! about small plane waves follows from it by sums of sines and cosines: their dynamical matrix at any wave vector, its
//! derivatives, its Taylor coefficients, and the chain of lattice planes that a wave along an axis sees.

use pdlang::ir::{Flavour, Response, Shape};
use pdlang_runtime::spec::Stage;

use super::hermitian::{Hermitian, Matrix};
use crate::verify::ask::{self, Case};
use crate::verify::{Subject, bodies};

/// Bonds of the box that a stencil is read from.
const MOST_BONDS: f64 = 2e8;
/// What a uniform translation may cost, over the sum of the magnitudes: rounding.
const DRIFT: f64 = 1e-11;

/// What one node does to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Steps of the lattice from the node that moves to the node that feels it.
    pub cell: [i32; 3],
    /// Row: component of what is felt; column: component of what moves. Of displacements the force density over the
    /// displacement [N/m^4], of a field the rate over the field [1/s], in the first row and column.
    pub value: Matrix,
}

/// All blocks that are not zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Stencil {
    /// Dimensions of the lattice.
    pub dim: usize,
    /// Components of what moves: the dimensions for displacements, 1 for a scalar field.
    pub size: usize,
    /// Lattice constant [m].
    pub spacing: f64,
    pub blocks: Vec<Block>,
    /// What a uniform translation costs, the sum of all blocks; nothing where it is rounding.
    rest: Matrix,
}

impl Stencil {
    /// Of the displacements of a law at rest. Fields and histories are held.
    ///
    /// # Errors
    /// Where the law has no force, is too large for the engine, or its box would be.
    pub fn of_motion(subject: &Subject, flavour: Flavour) -> Result<Stencil, String> {
        if !subject.has_force() {
            return Err(format!("`{}` has no force", subject.law.name));
        }
        let (mut case, near) = periodic(subject, flavour, Stage::Tangent)?;
        case.force();
        let dim = flavour.dim();
        let mut blocks = vec![[[0.0; 3]; 3]; case.body.x.len()];
        for b in 0..dim {
            let mut du = vec![[0.0; 3]; case.body.x.len()];
            du[0][b] = 1.0;
            for (block, t) in blocks.iter_mut().zip(case.tangent(&du)) {
                for (row, t) in block.iter_mut().zip(t) {
                    row[b] = t;
                }
            }
        }
        Ok(Stencil::new(
            dim,
            dim,
            subject.spacing(),
            near.cells(&blocks),
        ))
    }

    /// Of a scalar field with a rate, the body at rest: how the rate changes with the field [1/s].
    ///
    /// # Errors
    /// Where there is no such field, or the law or its box is too large.
    pub fn of_field(subject: &Subject, flavour: Flavour, field: &str) -> Result<Stencil, String> {
        let rated = |r: &Response| match r {
            Response::Rate(f, _) => {
                let f = &subject.law.fields[f.index()];
                f.name == field && f.shape == Shape::Scalar
            }
            _ => false,
        };
        if !subject.law.responses.iter().any(rated) {
            let name = &subject.law.name;
            return Err(format!("`{name}` has no rate of a scalar field `{field}`"));
        }
        let (mut case, near) = periodic(subject, flavour, Stage::Step)?;
        let still = case.rate(field);
        case.set_field(field, |node| f64::from(u8::from(node == 0)));
        let moved = case.rate(field);
        let change = |(m, s): (&f64, &f64)| {
            let mut block = [[0.0; 3]; 3];
            block[0][0] = m - s;
            block
        };
        let blocks: Vec<Matrix> = moved.iter().zip(&still).map(change).collect();
        Ok(Stencil::new(
            flavour.dim(),
            1,
            subject.spacing(),
            near.cells(&blocks),
        ))
    }

    fn new(dim: usize, size: usize, spacing: f64, blocks: Vec<Block>) -> Stencil {
        let (mut rest, mut scale) = ([[0.0; 3]; 3], 0.0_f64);
        for block in &blocks {
            for (rest, value) in rest.iter_mut().flatten().zip(block.value.iter().flatten()) {
                *rest += value;
                scale += value.abs();
            }
        }
        for value in rest.iter_mut().flatten() {
            if value.abs() <= DRIFT * scale {
                *value = 0.0;
            }
        }
        Stencil {
            dim,
            size,
            spacing,
            blocks,
            rest,
        }
    }

    /// What a wave `exp(i k.x)` is pulled back with, over its amplitude: `M(k)` of `rho Omega^2 u = M u` [N/m^4], of a
    /// field the rate at which it decays [1/s]. The wave vector is in 1/m.
    ///
    /// `M = sum of -C(r) exp(-i k.r)` over the blocks; equal parts of opposite ones are written by squares of sines, so
    /// that long waves lose no digits.
    pub fn matrix(&self, k: [f64; 3]) -> Hermitian {
        self.split(k).0
    }

    /// What is not Hermitian in `M(k)`, over its largest entry: 0 for a tangent that has a potential.
    pub fn asymmetry(&self, k: [f64; 3]) -> f64 {
        self.split(k).1
    }

    fn split(&self, k: [f64; 3]) -> (Hermitian, f64) {
        let (mut re, mut im) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for (re, rest) in re.iter_mut().flatten().zip(self.rest.iter().flatten()) {
            *re = -rest;
        }
        let halves = self.halves(k);
        for block in &self.blocks {
            // Sine and cosine of half of the phase.
            let (sin, cos) = halves.of(&block.cell);
            let (even, odd) = (2.0 * sin * sin, 2.0 * sin * cos);
            for a in 0..self.size {
                for b in 0..self.size {
                    re[a][b] += block.value[a][b] * even;
                    im[a][b] += block.value[a][b] * odd;
                }
            }
        }
        // Opposite blocks cancel but for their rounding.
        let size = |m: &Matrix| m.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
        if size(&im) <= 1e-13 * self.largest() {
            im = [[0.0; 3]; 3];
        }
        Hermitian::part(self.size, re, im)
    }

    /// Half phases of all steps along every axis, of which those of the blocks are made without a sine each.
    fn halves(&self, k: [f64; 3]) -> Halves {
        let reach = self
            .blocks
            .iter()
            .flat_map(|b| b.cell)
            .map(i32::abs)
            .max()
            .unwrap_or(0);
        let table = |a: usize| {
            let steps = if a < self.dim {
                -reach..=reach
            } else {
                -reach..=-reach
            };
            let half = |c: i32| (0.5 * k[a] * f64::from(c) * self.spacing).sin_cos();
            steps.map(half).collect()
        };
        Halves {
            reach,
            dim: self.dim,
            tables: [0, 1, 2].map(table),
        }
    }

    /// The largest entry of a block.
    fn largest(&self) -> f64 {
        let all = self.blocks.iter().flat_map(|b| b.value.iter().flatten());
        all.fold(0.0, |m, v| m.max(v.abs()))
    }

    /// Derivative of `M` by the component `a` of the wave vector [N/m^3].
    pub fn slope(&self, k: [f64; 3], a: usize) -> Hermitian {
        let (mut re, mut im) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for block in &self.blocks {
            let reach = f64::from(block.cell[a]) * self.spacing;
            let (sin, cos) = self.phase(&block.cell, k).sin_cos();
            for i in 0..self.size {
                for j in 0..self.size {
                    re[i][j] += block.value[i][j] * reach * sin;
                    im[i][j] += block.value[i][j] * reach * cos;
                }
            }
        }
        if im
            .iter()
            .flatten()
            .all(|v| v.abs() <= 1e-13 * self.largest() * self.spacing)
        {
            im = [[0.0; 3]; 3];
        }
        Hermitian::part(self.size, re, im).0
    }

    /// Taylor coefficients of `M` along a unit direction: `M(k n) = p_1 k^2 + p_2 k^4 + ..`, from `p_1` [N/m^2] on, by
    /// sums over the lattice. Exact; odd powers, of chiral laws, are not among them.
    pub fn taylor(&self, n: [f64; 3], terms: usize) -> Vec<Matrix> {
        let term = |q: usize| {
            let mut p = [[0.0; 3]; 3];
            let factorial: f64 = (1..=2 * q).map(|k| k as f64).product();
            let sign = if q % 2 == 1 { 1.0 } else { -1.0 };
            for block in &self.blocks {
                let reach = self.phase(&block.cell, n).powi(2 * q as i32);
                for (p, value) in p.iter_mut().flatten().zip(block.value.iter().flatten()) {
                    *p += sign * value * reach / factorial;
                }
            }
            p
        };
        (1..=terms).map(term).collect()
    }

    /// The blocks summed over the lattice planes across an axis: the chain that a wave along it sees. From the most
    /// negative step to the most positive one; [N/m^4], or [1/s].
    pub fn planes(&self, axis: usize) -> Vec<(i32, Matrix)> {
        let reach = self
            .blocks
            .iter()
            .map(|b| b.cell[axis].abs())
            .max()
            .unwrap_or(0);
        let mut planes: Vec<(i32, Matrix)> = (-reach..=reach).map(|s| (s, [[0.0; 3]; 3])).collect();
        for block in &self.blocks {
            let plane = &mut planes[(block.cell[axis] + reach) as usize].1;
            for (sum, value) in plane.iter_mut().flatten().zip(block.value.iter().flatten()) {
                *sum += value;
            }
        }
        planes
    }

    fn phase(&self, cell: &[i32; 3], k: [f64; 3]) -> f64 {
        let along: f64 = (0..3).map(|a| k[a] * f64::from(cell[a])).sum();
        along * self.spacing
    }
}

/// Sines and cosines by axis and step.
struct Halves {
    reach: i32,
    dim: usize,
    tables: [Vec<(f64, f64)>; 3],
}

impl Halves {
    fn of(&self, cell: &[i32; 3]) -> (f64, f64) {
        let mut sum = (0.0, 1.0);
        for a in 0..self.dim {
            let (sin, cos) = self.tables[a][(cell[a] + self.reach) as usize];
            sum = (sum.0 * cos + sum.1 * sin, sum.1 * cos - sum.0 * sin);
        }
        sum
    }
}

/// Where the nodes of a periodic box are, seen from the first one.
struct Near {
    side: i32,
    dim: usize,
}

impl Near {
    /// The blocks that are not zero, by the node that feels them.
    fn cells(&self, blocks: &[Matrix]) -> Vec<Block> {
        let side = self.side as usize;
        let step = |k: usize, a: usize| {
            let along = if a < self.dim {
                (k / side.pow(a as u32) % side) as i32
            } else {
                0
            };
            if along > self.side / 2 {
                along - self.side
            } else {
                along
            }
        };
        let block = |(k, value): (usize, &Matrix)| Block {
            cell: std::array::from_fn(|a| step(k, a)),
            value: *value,
        };
        let felt = |b: &Block| b.value.iter().flatten().any(|v| *v != 0.0);
        blocks.iter().enumerate().map(block).filter(felt).collect()
    }
}

/// A law in a periodic box that is wider than what it reaches.
fn periodic(subject: &Subject, flavour: Flavour, stage: Stage) -> Result<(Case, Near), String> {
    let dim = flavour.dim();
    let spec = subject.compiled(flavour)?.spec;
    let reach = (subject.reach + 1e-9).floor();
    let side = 2.0 * f64::from(spec.rings(stage)) * reach + 1.0;
    let ball = [2.0, 3.2, 4.2][dim - 1] * subject.reach.powi(dim as i32);
    let bonds = side.powi(dim as i32) * ball;
    if bonds > MOST_BONDS {
        return Err(format!(
            "a horizon of {} spacings is too large for a stencil in {dim} dimensions: a box of {bonds:.0e} bonds",
            subject.reach
        ));
    }
    let side = side as u32;
    let shape = std::array::from_fn(|a| if a < dim { side } else { 1 });
    let body = bodies::lattice(ask::runtime_flavour(flavour), shape, true);
    let case = Case::new(subject, flavour, ask::sized(subject, body))?;
    let near = Near {
        side: side as i32,
        dim,
    };
    Ok((case, near))
}
