//! Waves of laws on lattices and in the continuum, against tables and closed forms that this program did not make.
//!
//! Equation numbers in brackets are those of Seleson and Parks 2011 (influence functions) and of Nicely, Tang and Qian 2018
//! (correspondence), as corrected.

mod against_continuum;
mod lattices;
mod studies;

use pdlang::front;
use pdlang::ir::{Flavour, Law};
use pdlang_models::registry;
use pdlang_models::verify::{Options, Subject};
use pdlang_models::waves::{self, Hermitian, Moving, Stencil, continuum};

/// A law at certain values.
#[derive(Clone)]
struct Case {
    law: &'static str,
    flavour: Flavour,
    params: Vec<(&'static str, f64)>,
    influence: Option<String>,
    /// In spacings.
    reach: f64,
    spacing: f64,
    lattice_constants: bool,
}

fn case(law: &'static str, flavour: Flavour, params: &[(&'static str, f64)], reach: f64) -> Case {
    Case {
        law,
        flavour,
        params: params.to_vec(),
        influence: None,
        reach,
        spacing: 1.0,
        lattice_constants: false,
    }
}

impl Case {
    fn influence(mut self, text: &str) -> Case {
        self.influence = Some(text.into());
        self
    }

    fn spacing(mut self, spacing: f64) -> Case {
        self.spacing = spacing;
        self
    }

    fn ask<A>(&self, question: impl FnOnce(&Subject) -> A) -> A {
        let law = law(self.law);
        let influence = self.influence.as_ref().map(|text| {
            front::influence_call(text, &[]).unwrap_or_else(|e| panic!("{text}: {e:?}"))
        });
        let options = Options {
            params: self
                .params
                .iter()
                .map(|(n, v)| (n.to_string(), *v))
                .collect(),
            influence,
            horizon: self.reach * self.spacing,
            reach: self.reach,
            density: 1.0,
            lattice_constants: self.lattice_constants,
            partial_volume: false,
        };
        let subject = Subject::new(&law, "", &options).expect("a subject");
        question(&subject)
    }

    fn stencil(&self) -> Stencil {
        self.ask(|s| {
            waves::stencil(s, self.flavour).unwrap_or_else(|e| panic!("{}: {e}", self.law))
        })
    }

    /// Of the continuum, along a unit direction.
    fn continuum(&self, n: [f64; 3], k: f64) -> Hermitian {
        self.ask(|s| {
            continuum::matrix(s, self.flavour, Moving::Displacement, n, k).expect("a continuum")
        })
    }
}

fn law(name: &str) -> Law {
    registry::find(name)
        .expect("a law of the catalogue")
        .law()
        .expect("a correct law")
}

/// Frequencies at unit density, ascending.
fn omegas(matrix: &Hermitian) -> Vec<f64> {
    matrix
        .pairs()
        .iter()
        .map(|p| p.value.max(0.0).sqrt())
        .collect()
}

fn along_x(k: f64) -> [f64; 3] {
    [k, 0.0, 0.0]
}

fn close(found: f64, expected: f64, scale: f64, tolerance: f64, what: &str) {
    let error = (found - expected).abs() / scale;
    assert!(
        error <= tolerance,
        "{what}: {found} is not {expected} ({error:.1e})"
    );
}
