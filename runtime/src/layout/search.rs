//! Neighbours within the horizon, by a cell list.
use super::INCLUSIVE;
use crate::tape::length_squared;

/// Points sorted into cells, [`ACROSS`] of which are no shorter than the horizon.
pub(crate) struct Cells<'a> {
    x: &'a [Vec<f64>; 3],
    dim: usize,
    reach2: f64,
    low: [f64; 3],
    size: f64,
    shape: [usize; 3],
    start: Vec<u32>,
    points: Vec<u32>,
    /// Positions of the points, side by side as they are looked at.
    sorted: [Vec<f64>; 3],
}

/// Cells across a horizon: more of them enclose the ball more tightly, and hold fewer points each.
const ACROSS: usize = 2;

impl<'a> Cells<'a> {
    /// `used`: the slots that hold a point.
    pub fn new(x: &'a [Vec<f64>; 3], dim: usize, delta: f64, used: &[u32]) -> Cells<'a> {
        let (low, high) = bounds(x, used);
        // Cells of a sparse cloud grow until there are not many more of them than points.
        let mut size = delta / ACROSS as f64 * (1.0 + 1e-6);
        let mut shape = shape_of(low, high, size, dim);
        while shape.iter().map(|&n| n as f64).product::<f64>() > 4.0 * used.len() as f64 + 64.0 {
            size *= 1.5;
            shape = shape_of(low, high, size, dim);
        }
        let mut cells = Cells {
            x,
            dim,
            reach2: delta * delta * INCLUSIVE,
            low,
            size,
            shape,
            start: vec![],
            points: vec![],
            sorted: [vec![], vec![], vec![]],
        };
        cells.sort(used);
        cells
    }

    /// Counting sort, so that points of a cell keep the order of their slots.
    fn sort(&mut self, used: &[u32]) {
        self.start = vec![0; self.shape.iter().product::<usize>() + 1];
        for &p in used {
            let c = self.cell(p as usize);
            self.start[c + 1] += 1;
        }
        for c in 1..self.start.len() {
            self.start[c] += self.start[c - 1];
        }
        let mut next = self.start.clone();
        self.points = vec![0; used.len()];
        for &p in used {
            let c = self.cell(p as usize);
            self.points[next[c] as usize] = p;
            next[c] += 1;
        }
        for (sorted, x) in self.sorted.iter_mut().zip(self.x).take(self.dim) {
            *sorted = self.points.iter().map(|&p| x[p as usize]).collect();
        }
    }

    fn axis(&self, p: usize, a: usize) -> usize {
        (((self.x[a][p] - self.low[a]) / self.size) as usize).min(self.shape[a] - 1)
    }

    fn cell(&self, p: usize) -> usize {
        (self.axis(p, 2) * self.shape[1] + self.axis(p, 1)) * self.shape[0] + self.axis(p, 0)
    }

    /// Reference bond vector from one slot to another.
    pub fn xi(&self, from: usize, to: usize) -> [f64; 3] {
        std::array::from_fn(|a| {
            if a < self.dim {
                self.x[a][to] - self.x[a][from]
            } else {
                0.0
            }
        })
    }

    /// Neighbours of a slot, in no order. `found` is cleared first.
    pub fn neighbours(&self, p: usize, found: &mut Vec<u32>) {
        found.clear();
        match self.dim {
            1 => self.find::<1>(p, found),
            2 => self.find::<2>(p, found),
            _ => self.find::<3>(p, found),
        }
    }

    fn find<const D: usize>(&self, p: usize, found: &mut Vec<u32>) {
        let here: [f64; D] = std::array::from_fn(|a| self.x[a][p]);
        let range = |a: usize| {
            let c = self.axis(p, a);
            c.saturating_sub(ACROSS)..(c + ACROSS + 1).min(self.shape[a])
        };
        let along = range(0);
        for k in range(2) {
            for j in range(1) {
                let row = (k * self.shape[1] + j) * self.shape[0];
                let points =
                    self.start[row + along.start] as usize..self.start[row + along.end] as usize;
                let at: [&[f64]; D] = std::array::from_fn(|a| &self.sorted[a][points.clone()]);
                // Every point is written, and kept if it is near: no branch to guess.
                let (mut n, from) = (0, found.len());
                found.resize(from + points.len(), 0);
                let kept = &mut found[from..];
                for (i, &q) in self.points[points].iter().enumerate() {
                    let mut xi = [0.0; 3];
                    for a in 0..D {
                        xi[a] = at[a][i] - here[a];
                    }
                    let r2 = length_squared(xi, D);
                    kept[n] = q;
                    n += usize::from((r2 > 0.0) & (r2 <= self.reach2));
                }
                found.truncate(from + n);
            }
        }
    }
}

fn bounds(x: &[Vec<f64>; 3], used: &[u32]) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &p in used {
        for a in 0..3 {
            low[a] = low[a].min(x[a][p as usize]);
            high[a] = high[a].max(x[a][p as usize]);
        }
    }
    (low, high)
}

fn shape_of(low: [f64; 3], high: [f64; 3], size: f64, dim: usize) -> [usize; 3] {
    std::array::from_fn(|a| {
        if a < dim {
            ((high[a] - low[a]) / size) as usize + 1
        } else {
            1
        }
    })
}
