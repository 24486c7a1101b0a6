//! The constants of a law in a scene, by the names that the law gives them.

use pdlang::ir::{self, Home};
use pdlang::oracle::{self, Ball, Oracle, Settings};
use pdlang_runtime::body::Flavour;
use pdlang_runtime::scene::Scene;

use crate::language;

/// Name and SI value of every constant that the law defines, in its order; empty when one cannot be had.
pub fn of(scene: &Scene) -> Vec<(String, f64)> {
    evaluate(scene).unwrap_or_default()
}

fn evaluate(scene: &Scene) -> Option<Vec<(String, f64)>> {
    let material = &scene.material;
    let law = language::find(&material.model, &scene.directory).ok()?;
    let settings = Settings {
        flavour: flavour(scene.nodes.flavour()),
        params: material.params.clone(),
        influences: influences(&law, scene)?,
        horizon: scene.family.horizon.constant()?,
        ball: ball(scene)?,
        without: material.without.clone(),
    };
    let body = oracle::Body::default();
    let oracle = Oracle::new(&law, &body, &settings).ok()?;
    let state = oracle.state();
    let value = |def: &ir::Def| {
        let found = oracle.named(&state, &def.name).ok()?;
        Some((def.name.clone(), found.into_iter().next()?.scalar().ok()?))
    };
    let constant = |d: &&ir::Def| d.home == Home::Constant && !d.span.prelude;
    Some(law.defs.iter().filter(constant).filter_map(value).collect())
}

fn flavour(flavour: Flavour) -> ir::Flavour {
    match flavour {
        Flavour::Bar => ir::Flavour::Bar,
        Flavour::Slab => ir::Flavour::Slab,
        Flavour::PlaneStress => ir::Flavour::PlaneStress,
        Flavour::PlaneStrain => ir::Flavour::PlaneStrain,
        Flavour::Solid => ir::Flavour::Solid,
    }
}

fn influences(law: &ir::Law, scene: &Scene) -> Option<Vec<(ir::InfluenceFn, Vec<f64>)>> {
    let given = &scene.material.influences;
    law.influences
        .iter()
        .zip(given)
        .map(|(slot, given)| match &given.text {
            Some(text) => language::influence(text, &given.constants).ok(),
            None => slot.default.clone().map(|f| (f, given.values.clone())),
        })
        .collect()
}

fn ball(scene: &Scene) -> Option<Ball> {
    let cross = scene.nodes.cross();
    if !scene.material.lattice_constants {
        return Some(Ball::Integral { cross });
    }
    let (dim, spacing) = (scene.nodes.flavour().dim(), scene.nodes.spacing());
    let weight = spacing.powi(dim as i32) * cross;
    Some(Ball::Lattice(lattice(
        dim,
        spacing,
        scene.family.horizon.constant()?,
        scene.family.partial_volume,
        weight,
    )))
}

/// Bonds of a node of the unbounded lattice, with their weights.
fn lattice(
    dim: usize,
    spacing: f64,
    horizon: f64,
    partial: bool,
    volume: f64,
) -> Vec<([f64; 3], f64)> {
    let reach = |d: usize| {
        if d < dim {
            (horizon / spacing).floor() as i32 + 1
        } else {
            0
        }
    };
    let mut bonds = Vec::new();
    for i in -reach(0)..=reach(0) {
        for j in -reach(1)..=reach(1) {
            for k in -reach(2)..=reach(2) {
                let xi = [i, j, k].map(|c| f64::from(c) * spacing);
                let r = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
                if r > 0.0 && r <= horizon * (1.0 + 1e-9) {
                    let near = horizon - 0.5 * spacing;
                    let part = if partial && r > near {
                        (near + spacing - r) / spacing
                    } else {
                        1.0
                    };
                    bonds.push((xi, volume * part));
                }
            }
        }
    }
    bonds
}
