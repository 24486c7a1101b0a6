//! Strips inside of matching boundaries, in which neighbours exchange velocity.

use super::{Balance, Driver};
use crate::body::Body;
use crate::engine::{Bond, Engine, State};
use crate::matching::{Face, Strip};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// One component of the nodes of all strips.
pub(super) struct Smoothed {
    component: usize,
    /// Share of a difference that two neighbours exchange at most in a step.
    most: f64,
    /// Those that are free to change, in the order of memory.
    slots: Vec<u32>,
    /// Where the neighbours of a slot begin among all, and behind the last one where they end.
    first: Vec<u32>,
    neighbours: Vec<Neighbour>,
    /// Bonds to the neighbours; empty where none is broken and none can break.
    bonds: Vec<Option<Bond>>,
    next: Vec<f64>,
    /// Energy that the nodes of a task lose [J].
    lost: Vec<f64>,
}

/// A neighbour on the lattice.
#[derive(Clone, Copy)]
struct Neighbour {
    slot: u32,
    /// Share of the difference of velocities that goes over [1/s].
    rate: f64,
}

/// Nodes per task.
const TASK: usize = 2048;

/// Nodes of the strips and of their boundaries by cell.
struct Cells<'a> {
    body: &'a Body,
    /// User number, and rate of the exchange [1/s].
    nodes: HashMap<[u32; 3], (u32, f64)>,
}

impl Cells<'_> {
    fn new<'a>(faces: &[Face], body: &'a Body) -> Cells<'a> {
        let mut nodes = HashMap::new();
        for (node, cell) in body.grid.iter().flat_map(|g| g.cell.iter().enumerate()) {
            let rate = faces.iter().map(|f| f.exchange(*cell)).fold(0.0, f64::max);
            if rate > 0.0 {
                nodes.insert(*cell, (node as u32, rate));
            }
        }
        Cells { body, nodes }
    }

    /// The next node along an axis, upwards or downwards, if it is one of them.
    fn next(&self, cell: [u32; 3], axis: usize, up: bool) -> Option<(u32, f64)> {
        let along = self.body.grid.as_ref()?.shape[axis];
        let around = self.body.periodic[axis].is_some();
        let mut at = cell;
        at[axis] = match up {
            true if around && cell[axis] + 1 == along => 0,
            true => cell[axis] + 1,
            false if around && cell[axis] == 0 => along - 1,
            false => cell[axis].checked_sub(1)?,
        };
        self.nodes.get(&at).copied().filter(|_| at != cell)
    }
}

impl Smoothed {
    /// One for every component; none where no boundary has a strip.
    pub fn of(
        faces: &[Face],
        body: &Body,
        engine: &Engine,
        state: &State,
        driven: &[&[Driver]],
    ) -> Vec<Smoothed> {
        let cells = Cells::new(faces, body);
        if cells.nodes.is_empty() {
            return vec![];
        }
        let mut nodes: Vec<([u32; 3], u32, f64)> = (cells.nodes.iter())
            .map(|(cell, (node, rate))| (*cell, *node, *rate))
            .collect();
        nodes.sort_unstable_by_key(|(_, node, _)| engine.slot(*node as usize));
        let moved = |node: u32| faces.iter().any(|f| f.holds(node as usize, body));
        nodes.retain(|(_, node, _)| !moved(*node));
        let of = |component: usize| {
            let held: HashSet<u32> = (driven.iter().copied().flatten())
                .filter(|d| d.component == component)
                .flat_map(|d| d.nodes.iter().copied())
                .collect();
            let mut one = Smoothed {
                component,
                most: Strip::most(body.flavour.dim()),
                slots: vec![],
                first: vec![0],
                neighbours: vec![],
                bonds: vec![],
                next: vec![],
                lost: vec![],
            };
            for (cell, node, rate) in nodes.iter().filter(|(_, node, _)| !held.contains(node)) {
                let slot = engine.slot(*node as usize);
                let ways = (0..body.flavour.dim()).flat_map(|axis| [(axis, false), (axis, true)]);
                for (other, its) in ways.filter_map(|(axis, up)| cells.next(*cell, axis, up)) {
                    let other = engine.slot(other as usize);
                    one.neighbours.push(Neighbour {
                        slot: other as u32,
                        rate: 0.5 * (rate + its),
                    });
                    // Both ends ask the same bond: what one gives the other takes.
                    let (from, to) = (slot.min(other), slot.max(other));
                    one.bonds.push(engine.bond(from, to));
                }
                one.slots.push(slot as u32);
                one.first.push(one.neighbours.len() as u32);
            }
            let broken = |bond: &Option<Bond>| bond.is_some_and(|b| !state.families[0].holds(b));
            if !engine.can_break() && !one.bonds.iter().any(broken) {
                one.bonds = vec![];
            }
            one.next = vec![0.0; one.slots.len()];
            one.lost = vec![0.0; one.slots.len().div_ceil(TASK)];
            one
        };
        (0..body.flavour.dim()).map(of).collect()
    }

    /// Exchanges velocities over a step and returns the energy that this takes [J]. Nothing goes across a broken bond.
    ///
    /// Every node reads what all had before: the order of the tasks changes no bit.
    pub fn exchange(&mut self, state: &mut State, balance: &Balance) -> f64 {
        let (dt, most) = (balance.dt, self.most);
        let (first, neighbours, bonds) = (&self.first, &self.neighbours, &self.bonds);
        let (v, family) = (&mut state.v[self.component], &state.families[0]);
        let before = &*v;
        let holds = |k: &usize| match bonds.get(*k) {
            Some(Some(bond)) => family.holds(*bond),
            _ => true,
        };
        let after = |node: usize, own: f64| {
            let around = first[node] as usize..first[node + 1] as usize;
            around.filter(holds).fold(own, |sum, k| {
                let Neighbour { slot, rate } = neighbours[k];
                sum + (rate * dt).min(most) * (before[slot as usize] - own)
            })
        };
        let tasks = self.next.par_chunks_mut(TASK).zip(&mut self.lost);
        let tasks = tasks.zip(self.slots.par_chunks(TASK)).enumerate();
        tasks.for_each(|(task, ((next, lost), slots))| {
            *lost = 0.0;
            for (k, (next, slot)) in next.iter_mut().zip(slots).enumerate() {
                let slot = *slot as usize;
                let own = before[slot];
                *next = after(task * TASK + k, own);
                let mass = balance.density.at(slot) * balance.volume[slot];
                *lost += 0.5 * mass * (own - *next) * (own + *next);
            }
        });
        for (slot, next) in self.slots.iter().zip(&self.next) {
            v[*slot as usize] = *next;
        }
        self.lost.iter().sum()
    }
}
