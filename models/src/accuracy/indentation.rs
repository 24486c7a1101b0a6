//! Cracks under a punch on a half-space: section 3B of Wildman and Gazonas.

use std::sync::atomic::{AtomicU32, Ordering};

use pdlang_runtime::observe::quantity;
use pdlang_runtime::simulate::Simulation;

use super::Tolerance::{AtLeast, Factor, Off, Part};
use super::case::Case;
use super::{Along, Measure, Study};

pub const STUDIES: &[Study] = &[
    Study {
        id: "paper-pml-3b-crack",
        about: "The crack under 250 N, in nodes from the notch; lengths in mm. Load over thickness and drag are chosen so that it \
                is the paper's. Cracked is a node with more than 0.35 of its bonds broken: beside a straight crack it is \
                0.43, one farther 0.27.",
        long: true,
        measure: crack,
    },
    Study {
        id: "paper-pml-3b-crack",
        about: "What the layer is for, at 500 N: distance between the crack tips, mm. Reference: an own run of 283 x 142 nodes, \
                with twice as far to its edges. Free edges come back before waves do: drag carries momentum faster.",
        long: true,
        measure: without_layer,
    },
    Study {
        id: "paper-pml-3b-fit",
        about: "Distance between the crack tips against the load, mm, beside the paper's curve 8.49e-3 p^1.16 + 8.15, p in N; a \
                node at either end is 0.99 mm. Nothing is chosen anew. Then least squares fits of the same form, also of the \
                tips by a part of 0.45. A, s and B make up for one another, and s goes by what counts as cracked. The paper's norm of 1.65e-6 is taken for a sum of squares in m^2, here in \
                mm^2: nodes 0.5 mm apart leave about that much.",
        long: true,
        measure: fit,
    },
];

/// Part of the bonds of a node that are broken, between that of nodes beside a straight crack and that of the next ones;
/// and a little more than beside a straight crack.
const CRACKED: [f64; 2] = [0.35, 0.45];
/// Of the notches, in spacings: from the middle, and deep.
const NOTCH: [f64; 2] = [10.5, 2.0];
/// `A p^s + B` of the paper, with loads in N, in mm.
pub const PAPER: Curve = Curve {
    a: 8.49e-3,
    s: 1.16,
    b: 8.15,
};

/// The scene. Its law is no law of the catalogue: it stands in a file of its own for as long as this is in use.
struct Punch {
    case: Case,
    law: std::path::PathBuf,
}

impl Punch {
    fn new() -> Result<Punch, String> {
        // Studies may run beside each other.
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("pdlang-indentation-{}-{number}.pd", std::process::id());
        let law = std::env::temp_dir().join(name);
        let text = include_str!("../../../examples/indentation.pd");
        std::fs::write(&law, text).map_err(|why| format!("{}: {why}", law.display()))?;
        let text = include_str!("../../../examples/paper-pml-3b-crack.toml");
        let case = Case::new("paper-pml-3b-crack", text);
        let case = case.with("\"indentation.pd\"", &format!("'{}'", law.display()))?;
        Ok(Punch { case, law })
    }

    fn loaded(&self, newton: f64) -> Result<Case, String> {
        self.case.with("\"250 N\"", &format!("\"{newton} N\""))
    }
}

impl Drop for Punch {
    fn drop(&mut self) {
        // A file that is left in the folder of such files harms nobody.
        let _ = std::fs::remove_file(&self.law);
    }
}

/// Where the cracked nodes end.
struct Crack {
    /// From the notches outwards and downwards, in nodes.
    across: f64,
    down: f64,
    /// Between the tips, mm.
    apart: f64,
    /// Left tip less right tip, in nodes.
    askew: f64,
}

/// The crack at the end of the run, by either part.
fn cracked(case: &Case) -> Result<[Crack; 2], String> {
    let mut seen = case.at(&[1e-5], |sim| {
        Ok([look(sim, CRACKED[0])?, look(sim, CRACKED[1])?])
    })?;
    seen.pop().ok_or_else(|| "nothing was seen".into())
}

fn look(sim: &mut Simulation, cracked: f64) -> Result<Crack, String> {
    let damage = quantity(sim, "damage").map_err(|e| e.to_string())?.scalar();
    let dx = sim.body.spacing;
    // The crack runs half a spacing inside of the outermost nodes.
    let (mut left, mut right, mut deep) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (x, _) in sim
        .body
        .x
        .iter()
        .zip(&damage)
        .filter(|(_, d)| **d > cracked)
    {
        left = left.max(-x[0] / dx - 0.5);
        right = right.max(x[0] / dx - 0.5);
        // Not those that run down in the middle under large loads.
        if x[0].abs() > 0.5 * NOTCH[0] * dx {
            deep = deep.max(0.5 - x[1] / dx);
        }
    }
    Ok(Crack {
        across: right - NOTCH[0],
        down: deep - NOTCH[1],
        apart: 1e3 * dx * (left + right),
        askew: left - right,
    })
}

fn crack() -> Result<Vec<Measure>, String> {
    let punch = Punch::new()?;
    let [crack, _] = cracked(&punch.loaded(250.0)?)?;
    let spacing = 70.0 / 141.0;
    Ok(vec![
        Measure::new("nodes across", crack.across, 3.0, Off(0.01)),
        Measure::new("nodes down", crack.down, 3.0, Off(0.01)),
        Measure::new(
            "length of the crack",
            spacing * crack.across.hypot(crack.down),
            2.11,
            Part(0.01),
        ),
        Measure::new("left less right, nodes", crack.askew, 0.0, Off(0.01)),
        Measure::new(
            "distance between the tips",
            crack.apart,
            PAPER.at(250.0),
            Off(0.5),
        ),
    ])
}

/// Between the tips at 500 N, in a body of 283 by 142 nodes without a layer, mm.
const LARGE: f64 = 20.3546;
const LAYER: &str =
    "[[absorbing]]                           # 20 mm from the middle and below; its bonds hold
sides = [\"-x\", \"+x\", \"-y\"]
thickness = \"15 mm - dx/2\"              # from the outermost nodes
ramp = \"10 mm\"
rate = \"5e6 [1/s]\"
across = 0                              # the paper's layer damps in one direction only
";
const BODY: &str = "from = [\"-35 mm\", \"-35.25 mm\"], to = [\"35 mm\", 0] } }\n\n[family]";
/// Without damping, bonds hold where the layer was.
const HELD: &str = "[[no_fail]]
region = { difference = [
    { box = { from = [\"-35 mm\", \"-35.25 mm\"], to = [\"35 mm\", 0] } },
    { box = { from = [\"-20 mm\", \"-20.25 mm\"], to = [\"20 mm\", 0] } },
] }
";

fn without_layer() -> Result<Vec<Measure>, String> {
    let punch = Punch::new()?;
    let layer = punch.loaded(500.0)?;
    let free = layer.with(LAYER, HELD)?;
    let inner = "from = [\"-40.5*dx\", \"-41*dx\"], to = [\"40.5*dx\", 0] } }\n\n[family]";
    let cut = layer.with(LAYER, "")?.with(BODY, inner)?;
    let apart = |case: &Case| Ok::<f64, String>(cracked(case)?[0].apart);
    let (layer, free, cut) = (apart(&layer)?, apart(&free)?, apart(&cut)?);
    Ok(vec![
        Measure::new("with the layer", layer, LARGE, Off(0.01)),
        Measure::new("free edges in its place", free, LARGE, AtLeast),
        Measure::new("free edges where it begins", cut, LARGE, AtLeast),
    ])
}

/// `a p^s + b`.
#[derive(Clone, Copy)]
pub struct Curve {
    pub a: f64,
    pub s: f64,
    pub b: f64,
}

impl Curve {
    pub fn at(&self, p: f64) -> f64 {
        self.a * p.powf(self.s) + self.b
    }

    pub fn squares(&self, points: &[(f64, f64)]) -> f64 {
        points.iter().map(|(p, d)| (self.at(*p) - d).powi(2)).sum()
    }

    /// The best one with this exponent: a straight line through p^s.
    fn with_exponent(s: f64, points: &[(f64, f64)]) -> Curve {
        let n = points.len() as f64;
        let mean = |f: &dyn Fn(f64, f64) -> f64| {
            points.iter().map(|(p, d)| f(p.powf(s), *d)).sum::<f64>() / n
        };
        let (q, d) = (mean(&|q, _| q), mean(&|_, d| d));
        let a = mean(&|x, y| (x - q) * (y - d)) / mean(&|x, _| (x - q).powi(2));
        Curve { a, s, b: d - a * q }
    }

    /// The best one of all, by golden sections of the exponent.
    pub fn through(points: &[(f64, f64)]) -> Curve {
        let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
        let left = |s: f64| Curve::with_exponent(s, points).squares(points);
        let (mut low, mut high) = (0.2, 5.0);
        while high - low > 1e-9 {
            let cut = golden * (high - low);
            match left(high - cut) < left(low + cut) {
                true => high = low + cut,
                false => low = high - cut,
            }
        }
        Curve::with_exponent(0.5 * (low + high), points)
    }
}

fn fit() -> Result<Vec<Measure>, String> {
    let punch = Punch::new()?;
    let loads = (140..=500).step_by(20).map(f64::from);
    let measured = |p: f64| Ok((p, cracked(&punch.loaded(p)?)?.map(|crack| crack.apart)));
    let found = loads.map(measured).collect::<Result<Vec<_>, String>>()?;
    let along = |name, line, at| Along {
        axes: ["load, N", "distance between the crack tips, mm"],
        name,
        line,
        at,
    };
    let mut rows = Vec::new();
    for (p, [apart, _]) in &found {
        let row = Measure::new(format!("{p} N"), *apart, PAPER.at(*p), Off(2.0));
        rows.push(row.along(along("from 0.35 of the bonds", false, *p)));
    }
    let names = ["fit, from 0.35", "fit, from 0.45"];
    for (k, name) in names.into_iter().enumerate() {
        let points: Vec<(f64, f64)> = found.iter().map(|(p, apart)| (*p, apart[k])).collect();
        let own = Curve::through(&points);
        for p in [140.0, 200.0, 260.0, 320.0, 380.0, 440.0, 500.0] {
            let row = Measure::new(format!("{name}, {p} N"), own.at(p), PAPER.at(p), Off(1.5));
            rows.push(row.along(along(name, true, p)));
        }
        let row = |what, value, reference, tolerance| {
            Measure::new(format!("{name}, {what}"), value, reference, tolerance)
        };
        rows.extend([
            row("s", own.s, PAPER.s, Part(0.3)),
            row("A", own.a, PAPER.a, Factor(10.0)),
            row("B", own.b, PAPER.b, Part(0.1)),
            row("sum of squares", own.squares(&points), 1.65, Factor(4.0)),
        ]);
    }
    Ok(rows)
}
