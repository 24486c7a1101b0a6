//! Cloud layout: any nodes, spatially ordered, neighbour lists in SELL-8 (eight nodes in lanes, one column a row).
use super::search::Cells;
use super::{Family, Filter, Ghosts, INCLUSIVE, Layout, NONE, Shape, partial_volume};
use crate::body::Body;
use crate::tape::{length, length_squared};
use crate::traverse::CHUNK;
use rayon::prelude::*;

/// Builds the layout and one family per filter. `horizons`: of every pair of materials, at `a * count + b`.
pub(crate) fn cloud(
    body: &Body,
    horizons: &[f64],
    partial: bool,
    filters: &[Option<Filter>],
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
        let search = |p: usize, found: &mut Vec<u32>, order: &mut Vec<u64>| {
            cells.neighbours(p, found);
            by_direction(&cells, side, p, found, order);
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
        family(&layout, &search)
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
/// cache, and the eight lanes of a chunk read neighbours that are often next to each other.
struct Curve {
    low: [f64; 3],
    block: f64,
    cell: f64,
}

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
            block: 8.0 * cell,
            cell,
        }
    }

    fn of(&self, x: [f64; 3]) -> (u64, [u64; 3]) {
        let block: [u64; 3] = std::array::from_fn(|a| ((x[a] - self.low[a]) / self.block) as u64);
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

/// Neighbours of a slot, into the first list; the second is room to work.
type Search<'a> = dyn Fn(usize, &mut Vec<u32>, &mut Vec<u64>) + Sync + 'a;

/// The neighbour lists of a block of chunks, then all one behind the other.
fn family(layout: &Layout, search: &Search) -> Family {
    let chunks = layout.chunks();
    let blocks: Vec<(Vec<u32>, Vec<u8>, Vec<u32>)> = (0..chunks.div_ceil(BLOCK))
        .into_par_iter()
        .map_init(Default::default, |room: &mut ([Vec<u32>; CHUNK], _), b| {
            let (found, order) = room;
            let (mut index, mut present, mut rows) = (vec![], vec![], vec![]);
            for c in b * BLOCK..((b + 1) * BLOCK).min(chunks) {
                for (p, found) in (c * CHUNK..).zip(found.iter_mut()) {
                    found.clear();
                    if layout.user[p] != NONE {
                        search(p, found, order);
                    }
                }
                rows.push(append(c * CHUNK, found, &mut index, &mut present));
            }
            (index, present, rows)
        })
        .collect();
    let (mut first, mut last) = (Vec::with_capacity(chunks), Vec::with_capacity(chunks));
    let mut row = 0;
    for rows in blocks.iter().flat_map(|(_, _, rows)| rows) {
        first.push(row);
        row += rows;
        last.push(row);
    }
    let present: Vec<u8> = blocks.iter().flat_map(|b| &b.1).copied().collect();
    // Gigabytes of it in a large body, and new memory: threads share what it costs.
    let mut index = vec![0; row as usize * CHUNK];
    let mut rest = &mut index[..];
    let mut places = Vec::with_capacity(blocks.len());
    for (part, ..) in blocks {
        let place;
        (place, rest) = rest.split_at_mut(part.len());
        places.push((place, part));
    }
    let copy = |(place, part): (&mut [u32], Vec<u32>)| place.copy_from_slice(&part);
    places.into_par_iter().for_each(copy);
    let bonds = present.iter().map(|b: &u8| b.count_ones() as usize).sum();
    Family {
        first,
        last,
        present,
        bonds,
        shape: Shape::List(index),
    }
}

/// Appends the rows of the chunk at `base` and counts them. Padding repeats a real neighbour: loads stay valid and near.
fn append(base: usize, found: &[Vec<u32>], index: &mut Vec<u32>, present: &mut Vec<u8>) -> u32 {
    let rows = found.iter().map(Vec::len).max().unwrap_or(0);
    for row in 0..rows {
        let mut bits = 0;
        for (lane, found) in found.iter().enumerate() {
            let spare = found.last().copied().unwrap_or((base + lane) as u32);
            index.push(found.get(row).copied().unwrap_or(spare));
            bits |= ((row < found.len()) as u8) << lane;
        }
        present.push(bits);
    }
    rows as u32
}
