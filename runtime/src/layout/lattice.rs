//! Lattice layout: a padded box of cells, chunks of eight cells along one axis, a stencil as family.
use super::{Entry, Family, Filter, Ghosts, INCLUSIVE, Layout, NONE, Shape, partial_volume};
use crate::body::{Body, Grid};
use crate::tape::{length, length_squared};
use crate::traverse::CHUNK;
use rayon::prelude::*;

/// The padded box: how cells become slots.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    dim: usize,
    shape: [usize; 3],
    /// Cells that the horizon reaches.
    reach: [usize; 3],
    /// Axes from the fastest to the slowest.
    order: [usize; 3],
    /// Slots from one cell to the next along each axis.
    stride: [usize; 3],
    /// Padding before the first cell of each axis.
    before: [usize; 3],
    pub len: usize,
    pub chunks: usize,
}

/// Lays the box out so that chunks along the fastest axis waste few lanes and slow steps stay close in memory.
pub(crate) fn plan_lattice(body: &Body, grid: &Grid, delta: f64) -> Plan {
    let dim = body.flavour.dim();
    let shape = grid.shape.map(|n| n.max(1) as usize);
    let mut reach = [0; 3];
    for (a, reach) in reach.iter_mut().enumerate().take(dim) {
        *reach = (delta * INCLUSIVE / grid.spacing).floor() as usize;
        debug_assert!(a < dim);
    }
    let counts: Vec<usize> = (0..dim).map(|a| count_chunks(grid, shape, a)).collect();
    let fast = (0..dim).min_by_key(|&a| counts[a]).unwrap_or(0);
    let mut rest: Vec<usize> = (0..3).filter(|&a| a != fast).collect();
    rest.sort_by_key(|&a| (a >= dim, shape[a], a));
    let order = [fast, rest[0], rest[1]];
    let mut plan = Plan {
        dim,
        shape,
        reach,
        order,
        stride: [0; 3],
        before: [0; 3],
        len: 0,
        chunks: counts[fast],
    };
    plan.lay_out(body.periodic[fast].is_some());
    plan
}

/// Chunks that hold a node if `axis` were the fastest.
fn count_chunks(grid: &Grid, shape: [usize; 3], axis: usize) -> usize {
    let per_row = shape[axis].div_ceil(CHUNK);
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut seen = vec![false; per_row * shape[b] * shape[c]];
    for cell in &grid.cell {
        let [p, q, r] = [cell[axis] as usize, cell[b] as usize, cell[c] as usize];
        seen[(r * shape[b] + q) * per_row + p / CHUNK] = true;
    }
    seen.iter().filter(|&&s| s).count()
}

impl Plan {
    fn lay_out(&mut self, periodic: bool) {
        let [fast, middle, slow] = self.order;
        let (n, h) = (self.shape[fast], self.reach[fast]);
        let before = h.next_multiple_of(CHUNK);
        // The padding after a row is the padding before the next; only images need room of their own.
        let row = n
            .next_multiple_of(CHUNK)
            .max(n + if periodic { 2 * h } else { h })
            .next_multiple_of(CHUNK);
        self.stride[fast] = 1;
        self.stride[middle] = row;
        self.stride[slow] = row * (self.shape[middle] + 2 * self.reach[middle]);
        self.before = self.reach;
        self.before[fast] = before;
        let rows = (self.shape[middle] + 2 * self.reach[middle])
            * (self.shape[slow] + 2 * self.reach[slow]);
        self.len = (rows * row + before + CHUNK + h).next_multiple_of(CHUNK);
    }

    /// Slot of a cell; cells outside the box by no more than the reach have slots too.
    fn slot(&self, cell: [i64; 3]) -> usize {
        let mut s = 0;
        for a in 0..3 {
            s += (cell[a] + self.before[a] as i64) * self.stride[a] as i64;
        }
        s as usize
    }

    fn offset(&self, step: [i64; 3]) -> i64 {
        (0..3).map(|a| step[a] * self.stride[a] as i64).sum()
    }
}

/// Builds the layout and one family per filter.
pub(crate) fn lattice(
    body: &Body,
    grid: &Grid,
    plan: &Plan,
    delta: f64,
    partial: bool,
    filters: &[Option<Filter>],
) -> (Layout, Vec<Family>) {
    let mut occupied = vec![NONE; plan.len];
    let mut slot = Vec::with_capacity(body.x.len());
    for (node, cell) in grid.cell.iter().enumerate() {
        let s = plan.slot(cell.map(i64::from));
        occupied[s] = node as u32;
        slot.push(s as u32);
    }
    let mut layout = Layout {
        dim: plan.dim,
        len: plan.len,
        slot,
        user: occupied.clone(),
        ..Layout::default()
    };
    place_chunks(&mut layout);
    layout.parts = std::iter::once(0..layout.chunks()).collect();
    place_nodes(&mut layout, body, grid, plan, &mut occupied);
    let entries = stencil(plan, grid.spacing, delta, partial, body.volume[0]);
    let families = filters
        .iter()
        .map(|f| family(&layout, &occupied, &entries, *f))
        .collect();
    (layout, families)
}

fn place_chunks(layout: &mut Layout) {
    layout.chunk_of = vec![NONE; layout.len / CHUNK];
    for (block, users) in layout.user.chunks_exact(CHUNK).enumerate() {
        let mut bits = 0u8;
        for (lane, &user) in users.iter().enumerate() {
            bits |= ((user != NONE) as u8) << lane;
        }
        if bits != 0 {
            layout.chunk_of[block] = layout.base.len() as u32;
            layout.base.push((block * CHUNK) as u32);
            layout.nodes.push(bits);
        }
    }
}

/// Positions and volumes of nodes, then the ghosts of periodic directions.
fn place_nodes(layout: &mut Layout, body: &Body, grid: &Grid, plan: &Plan, occupied: &mut [u32]) {
    layout.x = std::array::from_fn(|_| vec![0.0; layout.len]);
    layout.volume = vec![0.0; layout.len];
    for (node, &s) in layout.slot.iter().enumerate() {
        for a in 0..3 {
            layout.x[a][s as usize] = body.x[node][a];
        }
        layout.volume[s as usize] = body.volume[node];
    }
    let (mut to, mut from) = (vec![], vec![]);
    for_each_image(body, grid, plan, |node, image, shift| {
        let s = plan.slot(image);
        occupied[s] = node as u32;
        to.push(s as u32);
        from.push(layout.slot[node]);
        for a in 0..3 {
            layout.x[a][s] = body.x[node][a] + shift[a];
        }
    });
    layout.ghosts = Ghosts::new(to, from, layout.len);
}

/// Every image of every node that lies outside the box by no more than the reach.
fn for_each_image(
    body: &Body,
    grid: &Grid,
    plan: &Plan,
    mut visit: impl FnMut(usize, [i64; 3], [f64; 3]),
) {
    let copies: [i64; 3] = std::array::from_fn(|a| match body.periodic[a] {
        Some(_) if a < plan.dim => plan.reach[a].div_ceil(plan.shape[a]) as i64,
        _ => 0,
    });
    for i in -copies[0]..=copies[0] {
        for j in -copies[1]..=copies[1] {
            for k in -copies[2]..=copies[2] {
                let n = [i, j, k];
                if n == [0; 3] {
                    continue;
                }
                let shift: [f64; 3] =
                    std::array::from_fn(|a| n[a] as f64 * body.periodic[a].unwrap_or(0.0));
                for (node, cell) in grid.cell.iter().enumerate() {
                    let image: [i64; 3] =
                        std::array::from_fn(|a| cell[a] as i64 + n[a] * plan.shape[a] as i64);
                    let near = (0..3).all(|a| {
                        let h = plan.reach[a] as i64;
                        (-h..plan.shape[a] as i64 + h).contains(&image[a])
                    });
                    if near {
                        visit(node, image, shift);
                    }
                }
            }
        }
    }
}

/// All cell steps within the horizon. The thinnest axis varies slowest, so that the entries of a chunk near a
/// surface across it are neighbours in the list and can be left out at either end.
fn stencil(plan: &Plan, spacing: f64, delta: f64, partial: bool, volume: f64) -> Vec<Entry> {
    let mut axes: Vec<usize> = (0..plan.dim).collect();
    axes.sort_by_key(|&a| (plan.shape[a], usize::MAX - plan.stride[a]));
    let mut steps = vec![];
    let h: [i64; 3] = plan.reach.map(|r| r as i64);
    for i in -h[0]..=h[0] {
        for j in -h[1]..=h[1] {
            for k in -h[2]..=h[2] {
                let step = [i, j, k];
                let xi = step.map(|c| c as f64 * spacing);
                let r2 = length_squared(xi, plan.dim);
                if r2 > 0.0 && r2 <= delta * delta * INCLUSIVE {
                    steps.push((step, xi));
                }
            }
        }
    }
    steps.sort_by_key(|(step, _)| axes.iter().map(|&a| step[a]).collect::<Vec<_>>());
    let entry = |&(step, xi): &([i64; 3], [f64; 3])| {
        let fraction = if partial {
            partial_volume(length(xi, plan.dim), delta, spacing)
        } else {
            1.0
        };
        Entry {
            offset: plan.offset(step),
            xi,
            weight: fraction * volume,
            opposite: None,
        }
    };
    steps.iter().map(entry).collect()
}

/// The bonds that exist: both ends are nodes or images of nodes.
fn family(layout: &Layout, occupied: &[u32], all: &[Entry], filter: Option<Filter>) -> Family {
    let keep = |e: &&Entry| filter.is_none_or(|f| f([[0.0; 3], e.xi], e.weight, 0));
    let mut entries: Vec<Entry> = all.iter().filter(keep).cloned().collect();
    let offsets: Vec<[f64; 3]> = entries.iter().map(|e| e.xi).collect();
    for e in &mut entries {
        e.opposite = offsets
            .iter()
            .position(|xi| (0..3).all(|a| xi[a] == -e.xi[a]))
            .map(|k| k as u32);
    }
    let each = entries.len();
    let mut present = vec![0u8; layout.chunks() * each];
    let (first, last): (Vec<u32>, Vec<u32>) = present
        .par_chunks_mut(each.max(1))
        .enumerate()
        .map(|(chunk, rows)| {
            fill_rows(
                rows,
                &entries,
                occupied,
                layout.base[chunk] as i64,
                layout.nodes[chunk],
            );
            let start = (chunk * each) as u32;
            let first = rows.iter().position(|&b| b != 0).unwrap_or(0) as u32;
            let last = rows
                .iter()
                .rposition(|&b| b != 0)
                .map_or(first, |k| k as u32 + 1);
            (start + first, start + last)
        })
        .unzip();
    let (first, last) = if each == 0 {
        (vec![0; layout.chunks()], vec![0; layout.chunks()])
    } else {
        (first, last)
    };
    let bonds = present.iter().map(|b| b.count_ones() as usize).sum();
    Family {
        first,
        last,
        present,
        bonds,
        shape: Shape::Stencil(entries),
    }
}

fn fill_rows(rows: &mut [u8], entries: &[Entry], occupied: &[u32], base: i64, nodes: u8) {
    for (bits, entry) in rows.iter_mut().zip(entries) {
        for lane in 0..CHUNK {
            let there = occupied[(base + lane as i64 + entry.offset) as usize] != NONE;
            *bits |= ((nodes >> lane & 1 == 1 && there) as u8) << lane;
        }
    }
}
