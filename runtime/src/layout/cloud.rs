//! Cloud layout: any nodes, spatially ordered, neighbour lists in SELL-8 (eight nodes in lanes, one column a row).
use super::search::Cells;
use super::{Family, Filter, Ghosts, INCLUSIVE, Layout, List, NONE, Shape, partial_volume};
use crate::body::Body;
use crate::lane::Isa;
use crate::pages::zeros;
use crate::tape::{length, length_squared};
use crate::traverse::CHUNK;
use rayon::prelude::*;

/// Builds the layout and one family per filter. `horizons`: of every pair of materials, at `a * count + b`. `isa`: what
/// the sweeps run on.
pub(crate) fn cloud(
    body: &Body,
    horizons: &[f64],
    partial: bool,
    filters: &[Option<Filter>],
    isa: Isa,
) -> (Layout, Vec<Family>) {
    let delta = horizons.iter().copied().fold(0.0, f64::max);
    let layout = place(body, delta, horizons.len().isqrt());
    let mut used: Vec<u32> = layout.slot.clone();
    used.sort_unstable();
    used.extend(&layout.ghosts.to);
    let cells = Cells::new(&layout.x, layout.dim, delta, &used);
    let volume = |slot: usize| layout.volume[layout.ghosts.origin(slot)];
    let weight = |xi: [f64; 3], other: usize, pair: usize| {
        let fraction = if partial {
            partial_volume(length(xi, layout.dim), horizons[pair], body.spacing)
        } else {
            1.0
        };
        fraction * volume(other)
    };
    let graded = horizons.iter().any(|h| *h != delta);
    let within = |p: usize, q: u32| {
        let h = horizons[layout.pair(p, q as usize)];
        length_squared(cells.xi(p, q as usize), layout.dim) <= h * h * INCLUSIVE
    };
    let side = side(body, delta);
    let families = filters.iter().map(|filter| {
        let search = |p: usize, found: &mut Vec<u32>| {
            cells.neighbours(p, found);
            if graded {
                found.retain(|&q| within(p, q));
            }
            if let Some(filter) = filter {
                found.retain(|&q| {
                    let (xi, pair) = (cells.xi(p, q as usize), layout.pair(p, q as usize));
                    let ends = [p, q as usize].map(|slot| layout.position(slot));
                    filter(ends, weight(xi, q as usize, pair), pair)
                });
            }
        };
        let order = |p: usize, found: &mut [u32], room: &mut Vec<u64>| {
            by_direction(&cells, side, p, found, room);
        };
        family(&layout, &search, &order, most(isa))
    });
    let families = families.collect();
    (layout, families)
}

/// Material by material in spatial order, each from a chunk of its own on, then ghosts behind the nodes.
fn place(body: &Body, delta: f64, materials: usize) -> Layout {
    let n = body.x.len();
    let mut order: Vec<u32> = (0..n as u32).collect();
    let key = Curve::new(body, delta);
    let material = |node: u32| body.material.get(node as usize).copied().unwrap_or(0);
    order.par_sort_by_cached_key(|&node| (material(node), key.of(body.x[node as usize]), node));
    let (mut slots, mut parts) = (Vec::with_capacity(n), Vec::new());
    let mut padded = 0;
    for m in 0..materials.max(1) {
        let nodes = match materials {
            0 | 1 => n,
            _ => order
                .iter()
                .filter(|&&node| material(node) as usize == m)
                .count(),
        };
        slots.extend(padded as u32..(padded + nodes) as u32);
        let end = (padded + nodes).next_multiple_of(CHUNK);
        parts.push(padded / CHUNK..end / CHUNK);
        padded = end;
    }
    let images = images(body, &order, &slots, delta);
    let len = (padded + images.len()).next_multiple_of(CHUNK);
    let mut layout = Layout {
        dim: body.flavour.dim(),
        len,
        slot: vec![0; n],
        user: vec![NONE; len],
        ..Layout::default()
    };
    // Padding repeats the last node, so that nothing lies far away.
    let last = order[n - 1] as usize;
    layout.x = std::array::from_fn(|a| vec![body.x[last][a]; len]);
    layout.volume = vec![0.0; len];
    layout.parts = parts;
    for (&s, &node) in slots.iter().zip(&order) {
        let s = s as usize;
        layout.slot[node as usize] = s as u32;
        layout.user[s] = node;
        layout.volume[s] = body.volume[node as usize];
        for a in 0..3 {
            layout.x[a][s] = body.x[node as usize][a];
        }
    }
    let (mut to, mut from) = (vec![], vec![]);
    for (k, (s, x)) in images.into_iter().enumerate() {
        to.push((padded + k) as u32);
        from.push(s);
        for a in 0..3 {
            layout.x[a][padded + k] = x[a];
        }
    }
    layout.ghosts = Ghosts::new(to, from, len);
    let chunks = padded / CHUNK;
    layout.base = (0..chunks).map(|c| (c * CHUNK) as u32).collect();
    layout.nodes = (0..chunks)
        .map(|c| {
            let occupied = layout.user[c * CHUNK..(c + 1) * CHUNK].iter();
            let bit = |(k, user): (usize, &u32)| u8::from(*user != NONE) << k;
            occupied.enumerate().map(bit).sum()
        })
        .collect();
    layout.chunk_of = (0..len)
        .map(|s| if s < padded { (s / CHUNK) as u32 } else { NONE })
        .collect();
    layout
}

/// Periodic images within reach of the body: (slot of the node, position).
fn images(body: &Body, order: &[u32], slots: &[u32], delta: f64) -> Vec<(u32, [f64; 3])> {
    let dim = body.flavour.dim();
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for x in &body.x {
        for a in 0..3 {
            low[a] = low[a].min(x[a]);
            high[a] = high[a].max(x[a]);
        }
    }
    let reach = delta * INCLUSIVE;
    let copies: [i64; 3] = std::array::from_fn(|a| match body.periodic[a] {
        Some(period) if a < dim => ((high[a] - low[a] + reach) / period).floor() as i64,
        _ => 0,
    });
    let mut images = vec![];
    for i in -copies[0]..=copies[0] {
        for j in -copies[1]..=copies[1] {
            for k in -copies[2]..=copies[2] {
                if [i, j, k] == [0; 3] {
                    continue;
                }
                let shift: [f64; 3] =
                    std::array::from_fn(|a| [i, j, k][a] as f64 * body.periodic[a].unwrap_or(0.0));
                for (&s, &node) in slots.iter().zip(order) {
                    let x: [f64; 3] = std::array::from_fn(|a| body.x[node as usize][a] + shift[a]);
                    if (0..3).all(|a| x[a] >= low[a] - reach && x[a] <= high[a] + reach) {
                        images.push((s, x));
                    }
                }
            }
        }
    }
    images
}

/// About as far as nodes are from each other.
fn side(body: &Body, delta: f64) -> f64 {
    match body.spacing > 0.0 {
        true => body.spacing,
        false => delta / 3.0,
    }
}

/// Neighbours of `p` in the order of where they lie, row by row: the lanes of a chunk, which are nodes in a row, then
/// look the same way, at nodes that are in a row too. On what was a lattice they have equal lengths.
fn by_direction(cells: &Cells, side: f64, p: usize, found: &mut [u32], order: &mut Vec<u64>) {
    let per = 1.0 / side;
    let steps = |x: f64| (x * per + 512.5).clamp(0.0, 1023.0) as u64;
    order.clear();
    order.extend(found.iter().map(|&q| {
        let [x, y, z] = cells.xi(p, q as usize).map(steps);
        ((z << 20 | y << 10 | x) << 32) | u64::from(q)
    }));
    order.sort_unstable();
    for (to, from) in found.iter_mut().zip(order) {
        *to = *from as u32;
    }
}

/// Order of nodes in memory: blocks along a Morton curve, rows along x inside a block. Neighbours share the
/// cache, and the eight lanes of a chunk read neighbours that are next to each other, but at the ends of a row.
struct Curve {
    low: [f64; 3],
    block: [f64; 3],
    cell: f64,
}

/// Cells of a block along each axis.
const CELLS: [f64; 3] = [64.0, 8.0, 8.0];

impl Curve {
    fn new(body: &Body, delta: f64) -> Curve {
        let mut low = [f64::INFINITY; 3];
        for x in &body.x {
            for a in 0..3 {
                low[a] = low[a].min(x[a]);
            }
        }
        let cell = side(body, delta);
        Curve {
            low,
            block: CELLS.map(|n| n * cell),
            cell,
        }
    }

    fn of(&self, x: [f64; 3]) -> (u64, [u64; 3]) {
        let block: [u64; 3] =
            std::array::from_fn(|a| ((x[a] - self.low[a]) / self.block[a]) as u64);
        let cell = |a: usize| ((x[a] - self.low[a]) / self.cell + 0.5) as u64;
        // Along x the position itself decides; positive floats are ordered like their bits.
        (
            morton(block),
            [cell(2), cell(1), (x[0] - self.low[0]).to_bits()],
        )
    }
}

/// Interleaves the low 21 bits of three numbers.
fn morton(c: [u64; 3]) -> u64 {
    let mut m = 0;
    for bit in 0..21 {
        for (a, v) in c.iter().enumerate() {
            m |= (v >> bit & 1) << (3 * bit + a);
        }
    }
    m
}

/// Chunks that one task looks at.
const BLOCK: usize = 256;

/// Neighbours of a slot, into the list; then some of them by direction, with room to work.
type Search<'a> = dyn Fn(usize, &mut Vec<u32>) + Sync + 'a;
type Order<'a> = dyn Fn(usize, &mut [u32], &mut Vec<u64>) + Sync + 'a;

/// Rows of some chunks, one behind the other.
#[derive(Default)]
struct Rows {
    index: Vec<u32>,
    present: Vec<u8>,
    /// Per chunk: rows, and slots.
    counts: Vec<[u32; 2]>,
}

/// The neighbour lists of a block of chunks, then all one behind the other.
fn family(layout: &Layout, search: &Search, order: &Order, most: f64) -> Family {
    let chunks = layout.chunks();
    // Lanes without a bond look at slots too: at those of nodes, padding and ghosts.
    let slots = chunks * CHUNK + layout.ghosts.to.len();
    let blocks: Vec<Rows> = (0..chunks.div_ceil(BLOCK))
        .into_par_iter()
        .map_init(Default::default, |room: &mut ([Vec<u32>; CHUNK], _), b| {
            let (found, room) = room;
            let mut rows = Rows::default();
            for c in b * BLOCK..((b + 1) * BLOCK).min(chunks) {
                for (p, found) in (c * CHUNK..).zip(found.iter_mut()) {
                    found.clear();
                    if layout.user[p] != NONE {
                        search(p, found);
                        found.sort_unstable();
                    }
                }
                let before = [rows.present.len(), rows.index.len()];
                if !rows.add_runs(found, slots, most) {
                    for (p, found) in (c * CHUNK..).zip(found.iter_mut()) {
                        order(p, found, room);
                    }
                    rows.add_lists(c * CHUNK, found);
                }
                let after = [rows.present.len(), rows.index.len()];
                rows.counts
                    .push([0, 1].map(|k| (after[k] - before[k]) as u32));
            }
            rows
        })
        .collect();
    let (mut first, mut last) = (Vec::with_capacity(chunks), Vec::with_capacity(chunks));
    let mut list = List {
        at: vec![0],
        ..List::default()
    };
    let (mut row, mut at) = (0, 0);
    for &[rows, slots] in blocks.iter().flat_map(|b| &b.counts) {
        first.push(row);
        row += rows;
        last.push(row);
        at += slots;
        list.at.push(at);
    }
    let present: Vec<u8> = blocks.iter().flat_map(|b| &b.present).copied().collect();
    // Gigabytes of it in a large body, and new memory: threads share what it costs.
    list.index = zeros(at as usize);
    let mut rest = &mut list.index[..];
    let mut places = Vec::with_capacity(blocks.len());
    for part in blocks {
        let place;
        (place, rest) = rest.split_at_mut(part.index.len());
        places.push((place, part.index));
    }
    let copy = |(place, part): (&mut [u32], Vec<u32>)| place.copy_from_slice(&part);
    places.into_par_iter().for_each(copy);
    let bonds = present.iter().map(|b: &u8| b.count_ones() as usize).sum();
    Family {
        first,
        last,
        present: present.into(),
        bonds,
        shape: Shape::List(list),
    }
}

/// Most rows of runs for a row of lists: rows of lists take longer, those of runs have more empty lanes. In the same chunk
/// they would read the numbers of a node from two places. Without vectors an empty lane takes as long as a bond.
fn most(isa: Isa) -> f64 {
    match isa {
        Isa::Scalar => 1.0,
        _ => 1.6,
    }
}

impl Rows {
    /// Rows that lead to slots side by side, from ascending lists: nodes in a row look at nodes in a row, in a body that was
    /// a lattice all of them, in a jittered one those well within the horizon. False, and nothing added, if there are too
    /// many.
    fn add_runs(&mut self, found: &[Vec<u32>; CHUNK], slots: usize, most: f64) -> bool {
        let rows = found.iter().map(Vec::len).max().unwrap_or(0);
        let most = (rows as f64 * most) as usize;
        let before = (self.index.len(), self.present.len());
        // Where lane 0 would look if it looked the same way as the next bond of a lane.
        let start = |lane: usize, at: usize| match found[lane].get(at) {
            Some(q) => i64::from(*q) - lane as i64,
            None => i64::MAX,
        };
        let mut at = [0; CHUNK];
        let mut next: [i64; CHUNK] = std::array::from_fn(|lane| start(lane, 0));
        loop {
            let least = next.iter().copied().fold(i64::MAX, i64::min);
            if least == i64::MAX {
                return true;
            }
            let inside = least >= 0 && least as usize + CHUNK <= slots;
            if !inside || self.present.len() - before.1 == most {
                self.index.truncate(before.0);
                self.present.truncate(before.1);
                return false;
            }
            let mut lanes = 0u8;
            for lane in 0..CHUNK {
                if next[lane] == least {
                    lanes |= 1 << lane;
                    at[lane] += 1;
                    next[lane] = start(lane, at[lane]);
                }
            }
            self.index.push(least as u32);
            self.present.push(lanes);
        }
    }

    /// Rows of the lists of the chunk at `base`. Padding repeats a real neighbour: loads stay valid and near.
    fn add_lists(&mut self, base: usize, found: &[Vec<u32>; CHUNK]) {
        let rows = found.iter().map(Vec::len).max().unwrap_or(0);
        for row in 0..rows {
            let mut bits = 0;
            for (lane, found) in found.iter().enumerate() {
                let spare = found.last().copied().unwrap_or((base + lane) as u32);
                self.index.push(found.get(row).copied().unwrap_or(spare));
                bits |= ((row < found.len()) as u8) << lane;
            }
            self.present.push(bits);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Flavour;
    use crate::layout::tests::cells;
    use std::collections::BTreeSet;

    const HORIZON: f64 = 3.015;

    /// Sixteen nodes along each edge, each moved by up to `amplitude` in every direction.
    fn body(flavour: Flavour, amplitude: f64) -> Body {
        let n = 16u32;
        let dim = flavour.dim();
        let mut chance = 1u32;
        let mut moved = |cell: f64| {
            chance = chance.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            cell + amplitude * (f64::from(chance) / f64::from(u32::MAX) * 2.0 - 1.0)
        };
        let mut body = cells(
            flavour,
            std::array::from_fn(|a| if a < dim { n } else { 1 }),
        );
        for x in body.x.iter_mut().flat_map(|x| &mut x[..dim]) {
            *x = moved(*x);
        }
        body.grid = None;
        body
    }

    /// The part of the chunks that have runs, and rows by those that bonds would fill.
    fn shares(body: &Body, isa: Isa) -> (f64, f64) {
        let (layout, families) = cloud(body, &[HORIZON], false, &[None], isa);
        let family = &families[0];
        let mut found = BTreeSet::new();
        for chunk in 0..layout.chunks() {
            family.for_each(&layout, chunk, |m| {
                found.insert((layout.user[m.node], layout.user[m.other]));
            });
        }
        let mut expected = BTreeSet::new();
        for (i, p) in (0..).zip(&body.x) {
            for (j, q) in (0..).zip(&body.x) {
                let square: f64 = p.iter().zip(q).map(|(p, q)| (q - p).powi(2)).sum();
                if i != j && square <= HORIZON * HORIZON {
                    expected.insert((i, j));
                }
            }
        }
        assert!(found == expected);
        assert_eq!(family.bonds, expected.len());
        let rows = family.present.len() * CHUNK;
        (family.lists().1, rows as f64 / family.bonds as f64)
    }

    #[test]
    fn bodies_that_are_nearly_lattices_have_runs() {
        let (vectors, none) = (Isa::Avx512, Isa::Scalar);
        for (flavour, amplitude, isa, runs, rows) in [
            (Flavour::Bar, 0.0, vectors, 0.0..0.1, 1.3),
            (Flavour::PlaneStress, 0.0, vectors, 0.7..1.1, 1.3),
            (Flavour::PlaneStress, 0.2, vectors, 0.7..1.1, 1.6),
            (Flavour::Solid, 0.0, vectors, 0.9..1.1, 1.5),
            (Flavour::Solid, 0.0, none, 0.9..1.1, 1.3),
            (Flavour::Solid, 0.2, vectors, 0.9..1.1, 1.8),
            (Flavour::Solid, 0.2, none, 0.0..0.1, 1.3),
            (Flavour::Solid, 5.0, vectors, 0.0..0.1, 1.8),
        ] {
            let (of_runs, of_rows) = shares(&body(flavour, amplitude), isa);
            assert!(
                runs.contains(&of_runs) && of_rows < rows,
                "{flavour:?} {amplitude} {isa:?}: {of_runs} {of_rows}"
            );
        }
    }
}
