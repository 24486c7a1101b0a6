//! Neighbours within the horizon, by a cell list.
use super::INCLUSIVE;
use crate::tape::length_squared;

/// Points sorted into cells no smaller than the horizon.
pub(crate) struct Cells<'a> {
    x: &'a [Vec<f64>; 3],
    dim: usize,
    reach2: f64,
    low: [f64; 3],
    size: f64,
    shape: [usize; 3],
    start: Vec<u32>,
    points: Vec<u32>,
}

impl<'a> Cells<'a> {
    /// `used`: the slots that hold a point.
    pub fn new(x: &'a [Vec<f64>; 3], dim: usize, delta: f64, used: &[u32]) -> Cells<'a> {
        let (low, high) = bounds(x, used);
        // Cells of a sparse cloud grow until there are not many more of them than points.
        let mut size = delta * (1.0 + 1e-6);
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

    /// Neighbours of a slot, ascending. `found` is cleared first.
    pub fn neighbours(&self, p: usize, found: &mut Vec<u32>) {
        found.clear();
        let range = |a: usize| {
            let c = self.axis(p, a);
            c.saturating_sub(1)..(c + 2).min(self.shape[a])
        };
        for k in range(2) {
            for j in range(1) {
                let row = (k * self.shape[1] + j) * self.shape[0];
                let i = range(0);
                let (from, to) = (
                    self.start[row + i.start] as usize,
                    self.start[row + i.end] as usize,
                );
                for &q in &self.points[from..to] {
                    let r2 = length_squared(self.xi(p, q as usize), self.dim);
                    if r2 > 0.0 && r2 <= self.reach2 {
                        found.push(q);
                    }
                }
            }
        }
        found.sort_unstable();
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
