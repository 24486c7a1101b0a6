//! Precracks, no-fail zones, damage.
use super::{Bond, Engine, State};
use crate::layout::{Family, Met};
use crate::traverse::CHUNK;
use rayon::prelude::*;
use std::sync::Arc;

impl Engine {
    /// Breaks every bond for which `crosses` holds, given the reference positions [m] of its two ends.
    ///
    /// Both directions of a bond get the same answer. A bond across a periodic boundary is shown from both sides.
    pub fn cut(&self, s: &mut State, crosses: &dyn Fn([f64; 3], [f64; 3]) -> bool) {
        for (family, state) in self.families.iter().zip(&mut s.families) {
            let intact = Arc::make_mut(&mut state.intact);
            for chunk in 0..self.layout.chunks() {
                family.for_each(&self.layout, chunk, |m| {
                    if self.is_crossed(m, crosses) {
                        intact[m.row] &= !m.bit();
                    }
                });
            }
            state.touch();
        }
    }

    fn is_crossed(&self, m: Met, crosses: &dyn Fn([f64; 3], [f64; 3]) -> bool) -> bool {
        let far = self.layout.ghosts.origin(m.other);
        let (a, b) = (self.layout.position(m.node), self.layout.position(m.other));
        // The order of the ends does not depend on the direction of the bond.
        let ordered = |a, b| {
            if self.layout.user[m.node] <= self.layout.user[far] {
                crosses(a, b)
            } else {
                crosses(b, a)
            }
        };
        if far == m.other {
            return ordered(a, b);
        }
        let home = self.layout.position(far);
        let image = std::array::from_fn(|k| a[k] + (home[k] - b[k]));
        ordered(a, b) || ordered(image, home)
    }

    /// The bond of the whole horizon from one slot to another, if there is one.
    pub fn bond(&self, from: usize, to: usize) -> Option<Bond> {
        let (family, (chunk, lane)) = (&self.families[0], self.layout.place(from));
        let mut rows = family.rows(chunk).filter(|row| {
            family.present[*row] >> lane & 1 == 1 && {
                let other = family.other(&self.layout, chunk, *row, lane);
                self.layout.ghosts.origin(other) == to
            }
        });
        rows.next().map(|row| Bond {
            row: row as u32,
            bit: 1 << lane,
        })
    }

    /// Bonds with an end where `nodes` (user order) holds never break.
    pub fn no_fail(&mut self, nodes: &[bool]) {
        let held = |slot: usize| {
            let user = self.layout.user[self.layout.ghosts.origin(slot)];
            nodes.get(user as usize).copied().unwrap_or(false)
        };
        let plane = |family: &Family| {
            let mut armed = vec![0u8; family.present.len()];
            for chunk in 0..self.layout.chunks() {
                family.for_each(&self.layout, chunk, |m| {
                    if !held(m.node) && !held(m.other) {
                        armed[m.row] |= m.bit();
                    }
                });
            }
            armed
        };
        let planes: Vec<Vec<u8>> = self.families.iter().map(plane).collect();
        for (bonds, armed) in self.bonds.iter_mut().zip(planes) {
            bonds.armed = armed;
        }
        self.sleep.forget();
    }

    /// 1 - (volume behind intact bonds) / (volume of the reference family), of the whole horizon; user order.
    /// Whole neighbour volumes, without partial-volume factors; 0 for a node without neighbours.
    pub fn damage(&self, s: &State) -> Vec<f64> {
        let (family, intact) = (&self.families[0], &s.families[0].intact);
        let mut volume = self.layout.volume.clone();
        self.layout.ghosts.refresh(&mut volume);
        let mut by_slot = vec![0.0; self.layout.chunks() * CHUNK];
        by_slot
            .par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(chunk, damage)| {
                let rows = family.rows(chunk);
                if family.present[rows.clone()] == intact[rows] {
                    return;
                }
                let mut sums = [(0.0, 0.0); CHUNK];
                family.for_each(&self.layout, chunk, |m| {
                    let (v, (all, whole)) = (volume[m.other], &mut sums[m.lane]);
                    *all += v;
                    if intact[m.row] & m.bit() != 0 {
                        *whole += v;
                    }
                });
                for (d, (all, whole)) in damage.iter_mut().zip(sums) {
                    *d = if all > 0.0 { 1.0 - whole / all } else { 0.0 };
                }
            });
        let at = |&slot: &u32| {
            let (chunk, lane) = self.layout.place(slot as usize);
            by_slot[chunk * CHUNK + lane]
        };
        self.layout.slot.iter().map(at).collect()
    }

    /// Directed bonds of the whole horizon that are intact.
    pub fn intact_bonds(&self, s: &State) -> usize {
        s.families[0]
            .intact
            .iter()
            .map(|b| b.count_ones() as usize)
            .sum()
    }
}
