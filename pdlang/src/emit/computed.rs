//! The part of a law's page that says how it is computed and what that costs at a bond.

use super::render::Part;
use crate::assemble::{self, Kinematics};
use crate::explain::{Work, removes, works};
use crate::ir::Law;

pub(super) fn parts(law: &Law) -> Vec<Part> {
    let Some(dim) = law.flavours.iter().map(|f| f.dim()).max() else {
        return vec![];
    };
    let Ok(spec) = assemble::spec(law, dim, Kinematics::General) else {
        return vec![];
    };
    let works = works(&spec);
    let words = format!(
        "In {dim}D, per directed bond; a fused multiplication and addition is two flops. On a lattice two bits are kept of a bond, \
         whether it is there and intact; a cloud keeps the number of the neighbour too, together 4.25 bytes, and 8 for each of the values \
         named here, which sweeps share. What a bond remembers it remembers in both. `pdlang explain {}` shows the formulas.",
        law.name
    );
    let mut parts = vec![
        Part::Heading("How it is computed".into()),
        Part::Text(words),
        Part::Table(
            vec![
                "sweep",
                "runs",
                "flops",
                "divisions, roots, functions",
                "read at the other end",
                "stored",
                "kept",
            ],
            works.iter().map(row).collect(),
        ),
        Part::Table(
            vec!["in a scene", "takes away"],
            removes(&spec)
                .iter()
                .map(|(what, taken)| vec![what.to_string(), taken.to_string()])
                .collect(),
        ),
    ];
    let linear = assemble::spec(law, dim, Kinematics::Linearised);
    if let Some(spec) = linear.ok().filter(|spec| spec.linearised) {
        let flops = |works: &[Work]| {
            let each = works.iter().filter(|w| w.when.contains("force"));
            each.map(|w| w.flops).sum::<usize>()
        };
        parts.push(Part::Text(format!(
            "For small displacements (`linearised = true`) a force evaluation takes {} flops at a bond in the place of {}.",
            flops(&self::works(&spec)),
            flops(&works)
        )));
    }
    parts
}

fn row(w: &Work) -> Vec<String> {
    let breaks = if w.breaks { ", breaks bonds" } else { "" };
    let kept = w.kept.iter().map(|k| format!("`{k}`"));
    let remembered = w.remembered.iter().map(|k| format!("remembers `{k}`"));
    let kept: Vec<String> = kept.chain(remembered).collect();
    vec![
        format!("`{}`", w.name),
        format!("{}{breaks}", w.when),
        w.flops.to_string(),
        format!("{}, {}, {}", w.divisions, w.roots, w.functions),
        w.far.to_string(),
        w.stored.to_string(),
        kept.join(", "),
    ]
}
