//! Strips inside of matching boundaries, in which neighbours exchange velocity.

use super::{Balance, Driver};
use crate::body::Body;
use crate::engine::{Engine, State};
use crate::matching::{Face, Strip};
use std::collections::{HashMap, HashSet};

/// One component of the nodes of all strips.
pub(super) struct Smoothed {
    component: usize,
    pairs: Vec<Pair>,
    /// Those that are free to change.
    slots: Vec<u32>,
    strip: Strip,
    went: Vec<f64>,
}

/// Two neighbours on the lattice.
struct Pair {
    slots: [u32; 2],
    /// What either takes of the difference, over the most; nothing where its motion is prescribed.
    shares: [f64; 2],
}

impl Smoothed {
    pub fn of(faces: &[Face], body: &Body, engine: &Engine, driven: &[&[Driver]]) -> Vec<Smoothed> {
        let (Some(grid), Some(strip)) = (
            &body.grid,
            faces.iter().map(|f| f.strip).max_by_key(|s| s.planes),
        ) else {
            return vec![];
        };
        let mut shares: HashMap<[u32; 3], (u32, f64)> = HashMap::new();
        for (node, cell) in grid.cell.iter().enumerate() {
            let share = faces.iter().map(|f| f.share(*cell)).fold(0.0, f64::max);
            if share > 0.0 {
                shares.insert(*cell, (node as u32, share));
            }
        }
        if shares.is_empty() {
            return vec![];
        }
        let next = |cell: &[u32; 3], axis: usize| {
            let mut at = *cell;
            at[axis] += 1;
            if body.periodic[axis].is_some() && at[axis] == grid.shape[axis] {
                at[axis] = 0;
            }
            shares.get(&at).filter(|_| at != *cell)
        };
        let layer: HashSet<u32> = (shares.values().map(|(node, _)| *node))
            .filter(|node| faces.iter().any(|f| f.holds(*node as usize, body)))
            .collect();
        // In the order of the nodes: sums over pairs have the same bits in every run.
        let mut strips: Vec<(&[u32; 3], &(u32, f64))> = shares.iter().collect();
        strips.sort_unstable_by_key(|(_, (node, _))| *node);
        let slot = |node: u32| engine.slot(node as usize) as u32;
        let of = |component: usize| {
            let drivers = driven.iter().copied().flatten();
            let held: HashSet<u32> = drivers
                .filter(|d| d.component == component)
                .flat_map(|d| d.nodes.iter().copied())
                .collect();
            let free = |node: u32| !layer.contains(&node) && !held.contains(&node);
            let mut pairs = vec![];
            for (cell, (a, share_a)) in &strips {
                for axis in 0..body.flavour.dim() {
                    let Some((b, share_b)) = next(cell, axis) else {
                        continue;
                    };
                    let share = 0.5 * (share_a + share_b);
                    let shares = [*a, *b].map(|node| if free(node) { share } else { 0.0 });
                    if shares != [0.0; 2] {
                        let slots = [slot(*a), slot(*b)];
                        pairs.push(Pair { slots, shares });
                    }
                }
            }
            let slots = strips.iter().map(|(_, (node, _))| *node);
            Smoothed {
                component,
                pairs,
                slots: slots.filter(|node| free(*node)).map(slot).collect(),
                strip,
                went: vec![],
            }
        };
        (0..body.flavour.dim()).map(of).collect()
    }

    /// Exchanges velocities over a step and returns the energy that this takes [J].
    pub fn exchange(&mut self, state: &mut State, balance: &Balance) -> f64 {
        let before = balance.kinetic(state, self.component, &self.slots);
        let most = self.strip.exchanged(balance.dt);
        let v = &mut state.v[self.component];
        self.went.clear();
        let difference = |p: &Pair| v[p.slots[1] as usize] - v[p.slots[0] as usize];
        self.went
            .extend(self.pairs.iter().map(|p| most * difference(p)));
        for (pair, went) in self.pairs.iter().zip(&self.went) {
            v[pair.slots[0] as usize] += pair.shares[0] * went;
            v[pair.slots[1] as usize] -= pair.shares[1] * went;
        }
        before - balance.kinetic(state, self.component, &self.slots)
    }
}
