//! The chain of lattice planes that a plane wave along an axis sees: what a plane of nodes does to another one.

use super::coefficients::root_series;
use crate::body::{Body, Grid};
use crate::engine::{Breaking, Engine, Law, Precision, Settings, Traversal};
use crate::error::InputError;
use crate::spec::{Spec, Stage, SweepSpec};
use std::collections::BTreeSet;

/// Shares of the largest number below which a plane does nothing, and two directions are alike: rounding.
const NOTHING: f64 = 1e-12;
const ALIKE: f64 = 1e-9;
/// Bonds of the box that a chain is read from.
const MOST_BONDS: f64 = 1e8;

/// `u''_i = sum of s_l u_{i+l}`, alike in both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// `s_0`, `s_1` and so on [1/s^2]; the last is not zero.
    s: Vec<f64>,
    /// Distance of the planes [m].
    pub spacing: f64,
    /// How many planes far the law looks, be what it finds there zero by chance.
    pub looks: usize,
}

impl Chain {
    /// From `s_{-K}` to `s_K`, which are alike in both directions.
    pub(super) fn new(both: Vec<f64>, spacing: f64) -> Chain {
        let middle = both.len() / 2;
        let looks = middle;
        let largest = both.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut s: Vec<f64> = (0..=middle)
            .map(|l| 0.5 * (both[middle + l] + both[middle - l]))
            .collect();
        while s.len() > 1 && s[s.len() - 1].abs() <= NOTHING * largest {
            s.pop();
        }
        Chain { s, spacing, looks }
    }

    /// Per density, for what was per volume.
    pub(super) fn over(mut self, density: f64) -> Chain {
        self.s.iter_mut().for_each(|s| *s /= density);
        self
    }

    /// How many planes far a plane acts.
    pub fn reach(&self) -> usize {
        self.s.len() - 1
    }

    /// `s_l`
    pub fn pull(&self, l: isize) -> f64 {
        self.s.get(l.unsigned_abs()).copied().unwrap_or(0.0)
    }

    /// Frequency squared of a wave whose phase turns by `phase` from plane to plane [rad^2/s^2].
    pub fn square(&self, phase: f64) -> f64 {
        let term = |(l, s): (usize, &f64)| 4.0 * s * (0.5 * l as f64 * phase).sin().powi(2);
        self.s.iter().enumerate().skip(1).map(term).sum()
    }

    /// A bound of the largest frequency [rad/s].
    pub fn largest(&self) -> f64 {
        let bound: f64 = self.s[1..].iter().map(|s| 4.0 * s.abs()).sum();
        bound.sqrt()
    }

    /// `a_1, a_3, ..` of the wave, as [`root_series`], `n` of them; empty where nothing resists.
    pub fn series(&self, n: usize) -> Vec<f64> {
        let term = |q: usize| {
            let factorial: f64 = (1..=2 * q).map(|k| k as f64).product();
            let moment = self
                .s
                .iter()
                .enumerate()
                .skip(1)
                .map(|(l, s)| 2.0 * s * (l as f64 * self.spacing).powi(2 * q as i32));
            let sign = if q % 2 == 1 { 1.0 } else { -1.0 };
            sign * moment.sum::<f64>() / factorial
        };
        root_series(&(1..=n).map(term).collect::<Vec<f64>>())
    }
}

/// The chain along `axis` of the displacements along `component`, of a law at rest: from the tangent of one plane that
/// moves in a periodic box, wider than what the law reaches. Per volume: [N/m^4].
pub(super) fn of_law(
    body: &Body,
    law: &Law,
    settings: &Settings,
    material: usize,
    axis: usize,
    component: usize,
) -> Result<Chain, InputError> {
    let dim = body.flavour.dim();
    let horizon = settings.met_horizon(material, material);
    let partial = if settings.partial_volume { 0.5 } else { 0.0 };
    let cells = (horizon / body.spacing + partial + 1e-9).floor();
    let sides: [u32; 3] = std::array::from_fn(|a| match a {
        a if a == axis => 2 * (f64::from(law.spec.rings(Stage::Tangent)) * cells) as u32 + 1,
        a if a < dim => 2 * cells as u32 + 1,
        _ => 1,
    });
    let nodes: f64 = sides.iter().map(|s| f64::from(*s)).product();
    let family = [2.0, 3.2, 4.2][dim - 1] * (horizon / body.spacing).powi(dim as i32);
    if nodes * family > MOST_BONDS {
        return Err(InputError::new(
            format!("the horizon is {cells} spacings, too many to match its waves"),
            "a horizon of a few spacings is usual",
        ));
    }
    let mut settings = settings.clone();
    settings.precision = Precision::Double;
    settings.materials = vec![settings.materials[material].clone()];
    settings.horizon = vec![horizon];
    settings.traversal = Traversal::Auto;
    let small = periodic(body, sides);
    let engine = Engine::new(&small, law.clone(), settings);
    let mut engine = engine.map_err(|e| InputError::new(e.to_string(), ""))?;
    let mut state = engine.state();
    let settled = engine.settle(&mut state);
    settled.map_err(|s| InputError::new(format!("the field `{}` has no place", s.field), ""))?;
    engine.forces(&mut state, Breaking::Held);
    let mut du = vec![vec![0.0; engine.len()]; dim];
    let plane = |node: usize| small.grid.as_ref().map_or(0, |g| g.cell[node][axis]);
    for node in (0..small.x.len()).filter(|n| plane(*n) == 0) {
        du[component][engine.slot(node)] = 1.0;
    }
    let felt: Vec<Vec<f64>> = engine.tangent(&state, &du).to_vec();
    if felt.len() < dim {
        return Err(InputError::new(
            format!("`{}` has no tangent to find its waves by", law.spec.law),
            "use an absorbing layer",
        ));
    }
    let line = |a: usize| along(&small, axis, |node| felt[a][engine.slot(node)]);
    let own = line(component);
    let largest = own.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let unlike = own
        .iter()
        .zip(own.iter().rev())
        .any(|(a, b)| (a - b).abs() > ALIKE * largest);
    let mixed = (0..dim)
        .filter(|a| *a != component)
        .any(|a| line(a).iter().any(|v| v.abs() > ALIKE * largest));
    if unlike || mixed {
        let names = ["x", "y", "z"];
        return Err(InputError::new(
            format!(
                "waves of `{}` along {} mix the directions of displacement, which a matching boundary does not",
                law.spec.law, names[axis]
            ),
            "turn the body so that a side is a symmetry of the material, or use an absorbing layer",
        ));
    }
    Ok(Chain::new(own, body.spacing))
}

/// Values along a row of nodes, from half of the box before the plane that moves to half of it behind.
fn along(body: &Body, axis: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let Some(grid) = &body.grid else {
        return Vec::new();
    };
    let side = grid.shape[axis];
    let mut values = vec![0.0; side as usize];
    for (node, cell) in grid.cell.iter().enumerate() {
        if (0..3).all(|a| a == axis || cell[a] == 0) {
            values[((cell[axis] + side / 2) % side) as usize] = value(node);
        }
    }
    values
}

/// A periodic box of the lattice of a body.
fn periodic(body: &Body, shape: [u32; 3]) -> Body {
    let dx = body.spacing;
    let dim = body.flavour.dim();
    let [a, b, c] = shape;
    let cell: Vec<[u32; 3]> = (0..c)
        .flat_map(move |z| (0..b).flat_map(move |y| (0..a).map(move |x| [x, y, z])))
        .collect();
    let volume = dx.powi(dim as i32) * body.cross;
    Body {
        flavour: body.flavour,
        x: cell.iter().map(|c| c.map(|c| dx * f64::from(c))).collect(),
        volume: vec![volume; cell.len()],
        material: Vec::new(),
        regions: Vec::new(),
        horizon: Vec::new(),
        cross: body.cross,
        grid: Some(Grid {
            origin: [0.0; 3],
            spacing: dx,
            shape,
            cell,
        }),
        spacing: dx,
        periodic: std::array::from_fn(|a| (a < dim).then(|| dx * f64::from(shape[a]))),
    }
}

impl Spec {
    /// The slots that the sweeps of a stage read, and those that these come from.
    pub(super) fn read_by(&self, stage: Stage) -> BTreeSet<u32> {
        let reads = |s: &SweepSpec| s.own.iter().chain(&s.nbr).copied().collect::<Vec<u32>>();
        let asked = self.sweeps.iter().filter(|s| s.stage == stage);
        let mut open: Vec<u32> = asked.flat_map(reads).collect();
        let mut read = BTreeSet::new();
        while let Some(slot) = open.pop() {
            if read.insert(slot) {
                let writers = self.sweeps.iter().filter(|s| s.out.contains(&slot));
                open.extend(writers.flat_map(reads));
            }
        }
        read
    }

    /// How many horizons the sweeps of a stage look far: one more wherever bonds read what such a sweep has written.
    pub fn rings(&self, stage: Stage) -> u32 {
        let mut far = vec![0_u32; self.slots.len()];
        let mut most = 1;
        for sweep in self.sweeps.iter().filter(|s| s.stage == stage) {
            let farthest =
                |slots: &[u32]| slots.iter().map(|s| far[*s as usize]).max().unwrap_or(0);
            let mut own = farthest(&sweep.own);
            if !sweep.bond.ops.is_empty() {
                own = own.max(1 + farthest(&sweep.nbr));
            }
            most = most.max(own);
            for slot in &sweep.out {
                far[*slot as usize] = own;
            }
        }
        most
    }
}
