//! Lattice layout: a box of cells, padded but along its fastest axis, chunks of eight cells along it, a stencil as family.
//!
//! Where materials meet, the nodes of each in a block of eight are a chunk, and the bonds to each are a row.
use super::{
    Cells, Family, Filter, Ghosts, INCLUSIVE, Kind, Layout, NONE, Shape, Stencil, partial_volume,
};
use crate::body::{Body, Grid};
use crate::fourier::Axis;
use crate::tape::{length, length_squared};
use crate::traverse::CHUNK;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

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

/// Lays the box out so that chunks waste few lanes and slow steps stay close in memory: chunks along the fastest axis, which
/// begin anew with every row of cells or go on from one row to the next.
pub(crate) fn plan_lattice(body: &Body, grid: &Grid, delta: f64, materials: usize) -> Plan {
    let dim = body.flavour.dim();
    let shape = grid.shape.map(|n| n.max(1) as usize);
    let mut reach = [0; 3];
    for (a, reach) in reach.iter_mut().enumerate().take(dim) {
        *reach = (delta * INCLUSIVE / grid.spacing).floor() as usize;
        debug_assert!(a < dim);
    }
    let laid_out = |fast: usize, anew: bool| {
        let mut rest: Vec<usize> = (0..3).filter(|&a| a != fast).collect();
        rest.sort_by_key(|&a| (a >= dim, shape[a], a));
        let mut plan = Plan {
            dim,
            shape,
            reach,
            order: [fast, rest[0], rest[1]],
            stride: [0; 3],
            before: [0; 3],
            len: 0,
            chunks: 0,
        };
        plan.lay_out(body.periodic[fast].is_some(), anew);
        plan.chunks = count_chunks(body, grid, &plan, materials);
        plan
    };
    let fewest = |a: Plan, b: Plan| if b.chunks < a.chunks { b } else { a };
    let anew = (1..dim).map(|fast| laid_out(fast, true));
    let anew = anew.fold(laid_out(0, true), fewest);
    let on = laid_out(anew.order[0], false);
    fewest(anew, on)
}

/// Chunks that hold a node: eight slots, of one material.
fn count_chunks(body: &Body, grid: &Grid, plan: &Plan, materials: usize) -> usize {
    let mut seen = vec![false; plan.len / CHUNK * materials];
    for (node, cell) in grid.cell.iter().enumerate() {
        let block = plan.slot(cell.map(i64::from)) / CHUNK;
        seen[block * materials + material(body, node)] = true;
    }
    seen.iter().filter(|&&s| s).count()
}

fn material(body: &Body, node: usize) -> usize {
    body.material.get(node).map_or(0, |&m| m as usize)
}

impl Plan {
    /// `anew`: a row of cells begins with a chunk.
    fn lay_out(&mut self, periodic: bool, anew: bool) {
        let [fast, middle, slow] = self.order;
        let (n, h) = (self.shape[fast], self.reach[fast]);
        // Images need room of their own. Where there are none the cells behind the end of a row are those of the next, and
        // no bond leads there: see [`Rows::within`]. A chunk may begin with slots that have no node.
        let row = if periodic { n + 2 * h } else { n };
        let (row, before) = match anew {
            true => (row.next_multiple_of(CHUNK), h.next_multiple_of(CHUNK)),
            false => (row, h + CHUNK),
        };
        self.stride[fast] = 1;
        self.stride[middle] = row;
        self.stride[slow] = row * (self.shape[middle] + 2 * self.reach[middle]);
        self.before = self.reach;
        self.before[fast] = before;
        let rows = (self.shape[middle] + 2 * self.reach[middle])
            * (self.shape[slow] + 2 * self.reach[slow]);
        self.len = (rows * row + before + CHUNK + h).next_multiple_of(CHUNK);
    }

    /// Slot of a cell; images outside the box by no more than the reach have slots too.
    fn slot(&self, cell: [i64; 3]) -> usize {
        let mut s = 0;
        for a in 0..3 {
            s += (cell[a] + self.before[a] as i64) * self.stride[a] as i64;
        }
        s as usize
    }

    /// The box without its padding, from the fastest axis to the slowest; but an axis of one cell comes before the
    /// last, along which work is shared out.
    pub fn cells(&self, body: &Body, grid: &Grid) -> Cells {
        let mut order = self.order;
        if self.shape[order[2]] == 1 {
            order.swap(1, 2);
        }
        Cells {
            axes: order.map(|a| Axis {
                cells: self.shape[a],
                reach: self.reach[a],
                periodic: a < self.dim && body.periodic[a].is_some(),
            }),
            stride: order.map(|a| self.stride[a]),
            first: self.slot([0; 3]),
            direction: order,
            spacing: grid.spacing,
        }
    }

    fn offset(&self, step: [i64; 3]) -> i64 {
        (0..3).map(|a| step[a] * self.stride[a] as i64).sum()
    }
}

/// Builds the layout and one family per filter. `horizons`: of every pair of materials, at `a * count + b`.
pub(crate) fn lattice(
    body: &Body,
    grid: &Grid,
    plan: &Plan,
    horizons: &[f64],
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
    let materials = horizons.len().isqrt();
    place_chunks(&mut layout, body, materials);
    place_nodes(&mut layout, body, grid, plan, &mut occupied);
    let delta = horizons.iter().copied().fold(0.0, f64::max);
    let steps = steps(plan, grid.spacing, delta);
    let families = filters.iter().map(|filter| {
        let kind = |step: usize, pair: usize| {
            let (step, xi) = steps[step];
            let r = length(xi, plan.dim);
            if length_squared(xi, plan.dim) > horizons[pair] * horizons[pair] * INCLUSIVE {
                return None;
            }
            let fraction = match partial {
                true => partial_volume(r, horizons[pair], grid.spacing),
                false => 1.0,
            };
            let weight = fraction * body.volume[0];
            let kept = filter.is_none_or(|keep| keep([[0.0; 3], xi], weight, pair));
            kept.then(|| Kind {
                offset: plan.offset(step),
                xi,
                weight,
                pair: pair as u32,
                opposite: None,
            })
        };
        let kinds: Vec<Option<Kind>> = (0..steps.len() * horizons.len())
            .map(|k| kind(k / horizons.len(), k % horizons.len()))
            .collect();
        let fast = plan.order[0];
        let rows = Rows {
            steps: &steps,
            fast,
            ends: body.periodic[fast].is_none().then_some(grid),
            layout: &layout,
            body,
            occupied: &occupied,
            materials,
            kinds: &kinds,
        };
        rows.family()
    });
    let families = families.collect();
    (layout, families)
}

/// Material by material, so that a chunk has one.
fn place_chunks(layout: &mut Layout, body: &Body, materials: usize) {
    layout.chunk_of = vec![NONE; layout.len];
    let mut blocks: Vec<Vec<(usize, u8)>> = vec![vec![]; materials];
    for (block, users) in layout.user.chunks_exact(CHUNK).enumerate() {
        for (lane, &user) in users.iter().enumerate().filter(|u| *u.1 != NONE) {
            let of_material = &mut blocks[material(body, user as usize)];
            match of_material.last_mut() {
                Some((b, bits)) if *b == block => *bits |= 1 << lane,
                _ => of_material.push((block, 1 << lane)),
            }
        }
    }
    for of_material in blocks {
        let from = layout.base.len();
        for (block, bits) in of_material {
            for lane in (0..CHUNK).filter(|lane| bits >> lane & 1 == 1) {
                layout.chunk_of[block * CHUNK + lane] = layout.base.len() as u32;
            }
            layout.base.push((block * CHUNK) as u32);
            layout.nodes.push(bits);
        }
        layout.parts.push(from..layout.base.len());
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

/// All cell steps within the horizon, with their bond vectors. The thinnest axis varies slowest.
fn steps(plan: &Plan, spacing: f64, delta: f64) -> Vec<([i64; 3], [f64; 3])> {
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
    steps
}

/// Chunks that one task looks at.
const BLOCK: usize = 4096;

/// The bonds that exist: both ends are nodes or images of nodes.
struct Rows<'a> {
    steps: &'a [([i64; 3], [f64; 3])],
    /// The fastest axis, and the grid where rows of cells end along it: the slot behind the last cell is that of another row.
    fast: usize,
    ends: Option<&'a Grid>,
    layout: &'a Layout,
    body: &'a Body,
    occupied: &'a [u32],
    materials: usize,
    /// At `step * pairs + pair`.
    kinds: &'a [Option<Kind>],
}

/// Rows of the chunks of a block; patterns hold positions in [`Rows::kinds`].
#[derive(Default)]
struct Found {
    present: Vec<u8>,
    /// Per chunk: which pattern.
    pattern: Vec<u32>,
    patterns: Vec<Vec<u32>>,
}

impl Rows<'_> {
    fn family(&self) -> Family {
        let chunks = self.layout.chunks();
        let blocks: Vec<Found> = (0..chunks.div_ceil(BLOCK))
            .into_par_iter()
            .map(|b| self.block(b * BLOCK..((b + 1) * BLOCK).min(chunks)))
            .collect();
        let mut stencil = Stencil::default();
        let (mut present, mut first, mut last) = (Vec::<u8>::new(), vec![], vec![]);
        let mut known: HashMap<&[u32], u32> = HashMap::new();
        for block in &blocks {
            for &k in &block.pattern {
                let pattern = &block.patterns[k as usize];
                let rows = last.last().copied().unwrap_or(0);
                first.push(rows);
                last.push(rows + pattern.len() as u32);
                let fresh = stencil.patterns.len() as u32;
                let at = *known.entry(pattern).or_insert(fresh);
                if at == fresh {
                    stencil.patterns.extend(pattern);
                }
                stencil.pattern.push(at);
            }
            present.extend(&block.present);
        }
        self.number(&mut stencil);
        let bonds = present.iter().map(|b| b.count_ones() as usize).sum();
        Family {
            first,
            last,
            present: present.into(),
            bonds,
            shape: Shape::Stencil(stencil),
        }
    }

    fn block(&self, chunks: std::ops::Range<usize>) -> Found {
        let mut found = Found::default();
        let mut known: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut pattern = vec![];
        for chunk in chunks {
            self.rows(chunk, &mut pattern, &mut found.present);
            let k = match known.get(&pattern) {
                Some(&k) => k,
                None => {
                    let k = known.len() as u32;
                    known.insert(pattern.clone(), k);
                    found.patterns.push(pattern.clone());
                    k
                }
            };
            found.pattern.push(k);
        }
        found
    }

    /// Every step to nodes of every material is a row.
    fn rows(&self, chunk: usize, pattern: &mut Vec<u32>, present: &mut Vec<u8>) {
        pattern.clear();
        let (base, nodes) = (self.layout.base[chunk] as i64, self.layout.nodes[chunk]);
        let pairs = self.materials * self.materials;
        let own = self.layout.parts.partition_point(|part| part.end <= chunk);
        let mut to_material = vec![0u8; self.materials];
        for step in 0..self.kinds.len() / pairs {
            let kinds = &self.kinds[step * pairs + own * self.materials..][..self.materials];
            let Some(kind) = kinds.iter().flatten().next() else {
                continue;
            };
            let within = self.within(base as usize, nodes, self.steps[step].0[self.fast]);
            for lane in (0..CHUNK).filter(|lane| within >> lane & 1 == 1) {
                let other = self.occupied[(base + lane as i64 + kind.offset) as usize];
                if other != NONE {
                    to_material[material(self.body, other as usize)] |= 1 << lane;
                }
            }
            for (m, bits) in to_material.iter_mut().enumerate() {
                let bits = std::mem::take(bits);
                if bits != 0 && kinds[m].is_some() {
                    pattern.push((step * pairs + own * self.materials + m) as u32);
                    present.push(bits);
                }
            }
        }
    }

    /// The nodes of a chunk from which a step along the fastest axis stays in their row of cells.
    fn within(&self, base: usize, nodes: u8, step: i64) -> u8 {
        let Some(grid) = self.ends else { return nodes };
        let end = i64::from(grid.shape[self.fast]);
        let stays = |lane: &usize| {
            let node = self.layout.user[base + lane] as usize;
            (0..end).contains(&(i64::from(grid.cell[node][self.fast]) + step))
        };
        let nodes = (0..CHUNK).filter(|lane| nodes >> lane & 1 == 1);
        nodes.filter(stays).map(|lane| 1 << lane).sum()
    }

    /// Keeps the kinds that occur, and says which are opposite.
    fn number(&self, stencil: &mut Stencil) {
        let used: BTreeSet<u32> = stencil.patterns.iter().copied().collect();
        let used: Vec<u32> = used.into_iter().collect();
        let place = |k: u32| used.binary_search(&k).map_or(NONE, |place| place as u32);
        stencil.patterns.iter_mut().for_each(|k| *k = place(*k));
        let pairs = self.materials * self.materials;
        let steps = self.kinds.len() / pairs.max(1);
        for &k in &used {
            // The list of steps is symmetric: the opposite of the first is the last.
            let (step, pair) = (k as usize / pairs, k as usize % pairs);
            let back = pair % self.materials * self.materials + pair / self.materials;
            let opposite = place(((steps - 1 - step) * pairs + back) as u32);
            if let Some(kind) = &self.kinds[k as usize] {
                stencil.kinds.push(Kind {
                    opposite: (opposite != NONE).then_some(opposite),
                    ..kind.clone()
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Flavour;
    use crate::layout::tests::cells;

    const HORIZON: f64 = 3.015;

    fn body(flavour: Flavour, shape: [u32; 3], periodic: [bool; 3]) -> Body {
        let period = |a: usize| periodic[a].then(|| f64::from(shape[a]));
        Body {
            periodic: [0, 1, 2].map(period),
            ..cells(flavour, shape)
        }
    }

    /// From which node to which, with the bond vector, in the order of all.
    fn bonds(body: &Body) -> (Vec<(u32, u32, [i64; 3])>, usize) {
        let grid = body.grid.as_ref().expect("a grid");
        let plan = plan_lattice(body, grid, HORIZON, 1);
        let (layout, families) = lattice(body, grid, &plan, &[HORIZON], false, &[None]);
        let mut found = vec![];
        for chunk in 0..layout.chunks() {
            families[0].for_each(&layout, chunk, |m| {
                let xi = [0, 1, 2].map(|a| layout.x[a][m.other] - layout.x[a][m.node]);
                let other = layout.user[layout.ghosts.origin(m.other)];
                found.push((layout.user[m.node], other, xi.map(|c| c.round() as i64)));
            });
        }
        found.sort_unstable();
        assert_eq!(found.len(), families[0].bonds);
        (found, layout.chunks())
    }

    fn expected(body: &Body) -> Vec<(u32, u32, [i64; 3])> {
        let copies = |a: usize| {
            if body.periodic[a].is_some() {
                -4..=4
            } else {
                0..=0
            }
        };
        let mut expected = vec![];
        for (i, p) in (0..).zip(&body.x) {
            for (j, q) in (0..).zip(&body.x) {
                for k in copies(0).flat_map(|x| copies(1).map(move |y| [x, y])) {
                    let shift = |a: usize| match k.get(a) {
                        Some(n) => f64::from(*n) * body.periodic[a].unwrap_or(0.0),
                        None => 0.0,
                    };
                    let xi = [0, 1, 2].map(|a| q[a] + shift(a) - p[a]);
                    let square = length_squared(xi, 3);
                    if square > 0.0 && square <= HORIZON * HORIZON {
                        expected.push((i, j, xi.map(|c| c as i64)));
                    }
                }
            }
        }
        expected.sort_unstable();
        expected
    }

    #[test]
    fn no_bond_leads_from_the_end_of_a_row_to_the_next() {
        for (flavour, shape) in [
            (Flavour::Bar, [9, 1, 1]),
            (Flavour::PlaneStress, [2, 5, 1]),
            (Flavour::PlaneStress, [13, 7, 1]),
            (Flavour::PlaneStress, [16, 7, 1]),
            (Flavour::Solid, [10, 5, 4]),
            (Flavour::Solid, [3, 9, 10]),
        ] {
            for periodic in [[false; 3], [true, false, false], [false, true, false]] {
                if !periodic[1] || flavour.dim() > 1 {
                    let body = body(flavour, shape, periodic);
                    let (found, _) = bonds(&body);
                    assert_eq!(found, expected(&body), "{shape:?} {periodic:?}");
                }
            }
        }
    }

    #[test]
    fn chunks_go_on_from_row_to_row_where_that_saves_some() {
        for (shape, chunks) in [([50, 5, 1], 32), ([48, 5, 1], 30), ([2, 80, 1], 20)] {
            let (_, found) = bonds(&body(Flavour::PlaneStress, shape, [false; 3]));
            assert!((chunks..=chunks + 1).contains(&found), "{shape:?}: {found}");
        }
    }
}
