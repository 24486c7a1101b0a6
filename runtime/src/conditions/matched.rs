//! Nodes of matching boundaries: every component follows its neighbours inwards, from the interior outwards.

use super::smoothed::Smoothed;
use super::{Balance, Driver};
use crate::body::Body;
use crate::engine::{Engine, State};
use crate::error::{About, InputError};
use crate::matching::{Coefficients, Face, Rule, Steps};
use std::collections::{BTreeMap, HashSet};

/// One component of the nodes of one side.
pub(super) struct Matched {
    pub component: usize,
    /// Slots, each behind those that it follows.
    pub slots: Vec<u32>,
    /// Slots of the neighbours inwards, as many for every node.
    inward: Vec<u32>,
    conditions: Vec<Coefficients>,
    rule: Rule,
    /// The conditions as a step of this length takes them [s].
    steps: Steps,
    dt: f64,
    /// Where a node and its neighbours inwards were at the start of a step, and, where two conditions ask for it, a step
    /// before.
    before: Vec<f64>,
    older: Vec<f64>,
    /// Velocities, which no force changes.
    velocity: Vec<f64>,
}

impl Matched {
    /// Calls `act` with every node and its neighbours inwards, one behind the other.
    fn each(&self, mut act: impl FnMut(usize)) {
        let inward = self.inward.chunks_exact(self.steps.reach);
        for (s, inward) in self.slots.iter().zip(inward) {
            act(*s as usize);
            inward.iter().for_each(|s| act(*s as usize));
        }
    }

    fn remember(&mut self, state: &State, dt: f64) {
        let u = &state.u[self.component];
        let mut before = std::mem::take(&mut self.before);
        before.clear();
        self.each(|s| before.push(u[s]));
        self.before = before;
        if state.step == 0 {
            self.recall(state, dt);
        }
        if dt != self.dt {
            // Where they were a step of this length before.
            let share = if self.dt > 0.0 { dt / self.dt } else { 1.0 };
            for (older, now) in self.older.iter_mut().zip(&self.before) {
                *older = now - (now - *older) * share;
            }
            self.steps = Steps::of(&self.conditions, self.rule, dt);
            self.dt = dt;
        }
    }

    /// Where nodes were a step before, their velocities being those that led from there.
    fn recall(&mut self, state: &State, dt: f64) {
        if self.conditions.len() < 2 {
            return;
        }
        let (u, v) = (&state.u[self.component], &state.v[self.component]);
        let mut older = std::mem::take(&mut self.older);
        older.clear();
        self.each(|s| older.push(u[s] - dt * v[s]));
        self.older = older;
    }

    /// Puts the nodes where their conditions have them, their neighbours inwards having moved. Returns the largest
    /// motion.
    fn follow(&self, state: &mut State, dt: f64) -> f64 {
        let (u, v) = (&mut state.u[self.component], &mut state.v[self.component]);
        let reach = self.steps.reach;
        let mut largest = 0.0_f64;
        for (k, (s, inward)) in (self.slots.iter())
            .zip(self.inward.chunks_exact(reach))
            .enumerate()
        {
            let (s, first) = (*s as usize, k * (reach + 1));
            let own = self.before[first];
            let went = self.steps.went(own, |j, t| match t {
                0 => u[inward[j - 1] as usize],
                1 => self.before[first + j],
                _ => self.older[first + j],
            });
            u[s] = own + went;
            v[s] = went / dt;
            largest = largest.max(went.abs());
        }
        largest
    }
}

/// All nodes of all sides, in the order in which they are stepped, and the strips inside of them.
pub(super) struct Boundaries(pub Vec<Matched>, Vec<Smoothed>);

impl Boundaries {
    /// Finds the nodes. Where the motion is prescribed, that holds.
    ///
    /// # Errors
    /// A side that is not a whole plane of the lattice, as far in as its condition reaches.
    pub fn new(
        faces: &[Face],
        body: &Body,
        engine: &Engine,
        state: &State,
        driven: &[&[Driver]],
    ) -> Result<Boundaries, InputError> {
        let mut list = Vec::new();
        for (k, face) in faces.iter().enumerate() {
            let planes = planes(face, body)?;
            for (component, waves) in face.components.iter().enumerate() {
                let ends = |d: &&Driver| d.until.is_finite() && d.component == component;
                let mut ending = driven.iter().copied().flatten().filter(ends);
                let reaches = |n: &u32| face.holds(*n as usize, body);
                if ending.any(|d| d.nodes.iter().any(reaches)) {
                    let side = face.side.name();
                    return Err(InputError::new(
                        format!(
                            "a condition that ends reaches the matching boundary of the side {side}"
                        ),
                        "keep its region away from these planes of nodes, or leave out `until`",
                    )
                    .about(About::Matching(face.side)));
                }
                let held: HashSet<u32> = driven
                    .iter()
                    .copied()
                    .flatten()
                    .filter(|d| d.component == component)
                    .flat_map(|d| d.nodes.iter().copied())
                    .collect();
                let mut matched = Matched {
                    component,
                    slots: Vec::new(),
                    inward: Vec::new(),
                    conditions: waves.conditions.clone(),
                    rule: face.rule,
                    steps: Steps::of(&waves.conditions, face.rule, 0.0),
                    dt: 0.0,
                    before: Vec::new(),
                    older: Vec::new(),
                    velocity: Vec::new(),
                };
                // From the interior outwards.
                for layer in (0..face.layers).rev() {
                    for column in &planes {
                        let node = column[layer];
                        // A corner belongs to the side of the last direction.
                        let later = faces[k..].iter().filter(|f| f.side.axis > face.side.axis);
                        if held.contains(&node)
                            || later.into_iter().any(|f| f.holds(node as usize, body))
                        {
                            continue;
                        }
                        let slot = |node: &u32| engine.slot(*node as usize) as u32;
                        matched.slots.push(slot(&node));
                        let inwards = &column[layer + 1..][..waves.deep()];
                        matched.inward.extend(inwards.iter().map(slot));
                    }
                }
                list.push(matched);
            }
        }
        let strips = Smoothed::of(faces, body, engine, state, driven);
        Ok(Boundaries(list, strips))
    }

    pub fn before_drift(&mut self, state: &State, dt: f64) {
        for matched in &mut self.0 {
            matched.remember(state, dt);
        }
    }

    /// The velocities of the last step, for a step whose parts see the nodes on their way.
    pub fn steer(&self, state: &mut State) {
        for matched in &self.0 {
            let v = &mut state.v[matched.component];
            for (s, v_s) in matched.slots.iter().zip(&matched.velocity) {
                v[*s as usize] = *v_s;
            }
        }
    }

    pub fn after_drift(&self, state: &mut State, dt: f64) -> f64 {
        let moved = self.0.iter().map(|m| m.follow(state, dt));
        moved.fold(0.0, f64::max)
    }

    /// Before the kick that completes a step of `dt`: velocities are still those of its middle.
    pub fn before_kick(&mut self, state: &State, dt: f64) {
        self.0.iter_mut().for_each(|m| m.recall(state, dt));
        self.hold(state);
    }

    /// Damps short waves inside of the boundaries, at the end of a step. Returns the energy that they lose [J].
    pub fn smooth(&mut self, state: &mut State, balance: &Balance) -> f64 {
        let strips = self.1.iter_mut();
        strips.map(|strip| strip.exchange(state, balance)).sum()
    }

    /// Velocities that no kick is to change.
    pub fn hold(&mut self, state: &State) {
        for matched in &mut self.0 {
            let v = &state.v[matched.component];
            matched.velocity.clear();
            let slots = matched.slots.iter();
            matched.velocity.extend(slots.map(|s| v[*s as usize]));
        }
    }
}

/// The nodes of a face by columns, from the outermost one inwards as far as its condition reads.
fn planes(face: &Face, body: &Body) -> Result<Vec<Vec<u32>>, InputError> {
    let Some(grid) = &body.grid else {
        return Ok(Vec::new());
    };
    let deep = face.layers + face.deep();
    let mut columns: BTreeMap<[u32; 3], Vec<Option<u32>>> = BTreeMap::new();
    for (node, cell) in grid.cell.iter().enumerate() {
        let depth = cell[face.side.axis].abs_diff(face.end) as usize;
        if depth < deep {
            let mut at = *cell;
            at[face.side.axis] = 0;
            columns.entry(at).or_insert_with(|| vec![None; deep])[depth] = Some(node as u32);
        }
    }
    let mut found = Vec::with_capacity(columns.len());
    for column in columns.into_values() {
        let whole: Option<Vec<u32>> = column.iter().copied().collect();
        let Some(whole) = whole else {
            let (Some(node), Some(gap)) = (
                column.iter().flatten().next(),
                column.iter().position(Option::is_none),
            ) else {
                continue;
            };
            let x = body.x[*node as usize]
                .map(|x| format!("{x:.4e}"))
                .join(", ");
            return Err(InputError::new(
                format!(
                    "the side {} is no plane of the lattice: the row of node {node} at ({x}) m has no node {gap} spacings \
                     inside of it",
                    face.side.name()
                ),
                format!(
                    "a matching boundary takes a flat side without holes, {deep} planes of nodes deep"
                ),
            )
            .about(About::Matching(face.side)));
        };
        found.push(whole);
    }
    Ok(found)
}
