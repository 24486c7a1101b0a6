//! The formulas of a law's page, written back as a law, have the force and the tangent that the oracle has from the energy.

use pdlang::emit::derived::definitions;
use pdlang_models::registry::CATALOGUE;
use pdlang_models::relations::{RELATIONS, Relation};
use pdlang_runtime::body::Flavour;
use pdlang_tests::agreement::{Answer, Question};
use pdlang_tests::chance::law;
use pdlang_tests::{bodies, laws};
use std::path::Path;

const LAWS: u64 = if cfg!(feature = "long") { 400 } else { 40 };

/// Laws whose pages have no derived formulas: two have no force, the third writes it itself.
const NONE: [&str; 3] = ["heat", "heat_state", "absorbing"];

/// The text of a law with `lines` in the place of its responses; rates stay.
fn with(text: &str, lines: &[String]) -> String {
    let mut kept: Vec<&str> = Vec::new();
    let mut out = false;
    for line in text.lines().take_while(|line| *line != "}") {
        // In canonical form an item begins two letters deep, and what continues it stands deeper.
        if line.starts_with("  ") && !line.starts_with("   ") && line != "  }" {
            let words = ["energy", "pair", "state", "probe", "known"];
            out = words.iter().any(|w| line[2..].starts_with(w));
        }
        if !out {
            kept.push(line);
        }
    }
    format!("{}\n{}\n}}\n", kept.join("\n"), lines.join("\n"))
}

#[test]
fn formulas_of_pages_are_the_force_and_the_tangent() {
    for entry in CATALOGUE {
        let answered = compared(entry.text, entry.name);
        assert!(
            answered || NONE.contains(&entry.name),
            "{} has no formulas",
            entry.name
        );
    }
}

/// The derivations of laws that were written to mislead them.
#[test]
fn formulas_of_odd_laws_are_the_force_and_the_tangent() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formulas");
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap();
        let answered = compared(&text, &path.display().to_string());
        assert!(answered, "{} has no formulas", path.display());
    }
}

#[test]
fn formulas_of_laws_of_chance_are_the_force_and_the_tangent() {
    let mut answered = 0;
    for seed in 0..LAWS {
        let text = law(seed);
        let text = pdlang::fmt::format(&text).unwrap();
        let what = format!("law {seed}");
        answered += u64::from(compared(&text, &what));
    }
    println!("{answered} of {LAWS} laws have formulas");
    assert!(answered * 3 > LAWS, "hardly a law has formulas");
}

/// Whether a law has formulas; they are what the oracle finds.
fn compared(text: &str, what: &str) -> bool {
    let (Some(force), Some(tangent)) = (definitions(text, false), definitions(text, true)) else {
        return false;
    };
    let law = laws::parse(text);
    let force = laws::parse(&with(text, &force));
    let tangent = laws::parse(&with(text, &tangent));
    for (k, flavour) in laws::flavours(&law).into_iter().enumerate() {
        let body = bodies::carved(flavour, k as u64);
        let question = Question::deformed(&law, body, 5e-2, k as u64);
        let (expected, mut scale) = question.oracle();
        // Where forces cancel, in one dimension for instance, rounding is that of what cancels.
        let step = question
            .du
            .as_flattened()
            .iter()
            .fold(0.0_f64, |m, d| m.max(d.abs()));
        scale.force = scale.force.max(1e-3 * laws::K / question.horizon);
        scale.tangent = scale
            .tangent
            .max(1e-3 * laws::K * step / question.horizon.powi(2));
        let forces = Question {
            law: &force,
            ..question.clone()
        }
        .oracle()
        .0;
        let mut fields = question.fields.clone();
        let along = |a: usize| question.du.iter().map(|du| du[a]).collect();
        fields.push((0..flavour.dim()).map(along).collect());
        let changes = Question {
            law: &tangent,
            fields,
            ..question.clone()
        }
        .oracle()
        .0;
        let found = Answer {
            force: forces.force,
            tangent: changes.force,
            ..Answer::default()
        };
        let gap = found.difference(&expected, &scale);
        println!("{what}, {question}: {gap}");
        assert!(gap.worst() < 1e-11, "{what}, {question}: {gap}\n{text}");
    }
    true
}

/// What a page says of two laws holds of their forces, on a random body in a random state; nothing holds by accident, as
/// another value of a parameter of the case breaks it.
#[test]
fn related_laws_agree_where_pages_say_so() {
    for relation in RELATIONS {
        let (law, other) = (laws::law(relation.law), laws::law(relation.of));
        let mut compared = 0;
        for flavour in laws::flavours(&law) {
            if laws::flavours(&other).contains(&flavour) {
                compared += usize::from(agree(relation, &law, &other, flavour));
            }
        }
        assert!(compared > 0, "{} and {}", relation.law, relation.of);
    }
}

fn agree(
    relation: &Relation,
    law: &pdlang::ir::Law,
    other: &pdlang::ir::Law,
    flavour: Flavour,
) -> bool {
    let of_law = pdlang::ir::Flavour::ALL
        .into_iter()
        .find(|f| f.name() == flavour.name());
    let Some((own, others)) = (relation.case)(of_law.unwrap()) else {
        return false;
    };
    let body = match relation.whole {
        true => bodies::lattice(
            flavour,
            std::array::from_fn(|a| if a < flavour.dim() { 6 } else { 1 }),
            true,
        ),
        false => bodies::carved(flavour, 3),
    };
    let strain = if relation.small { 1e-7 } else { 1e-2 };
    let u = bodies::deformation(&body, strain, 3);
    let ask = |law, params: &[(&str, f64)], influence: Option<&str>| {
        let mut question = Question::at_rest(law, body.clone()).with(params);
        if let Some(text) = influence {
            question.influences = vec![laws::influence(text)];
        }
        question.lattice_constants = relation.whole;
        question.path = vec![u.clone()];
        question
    };
    let mut a = ask(law, own, relation.influences.0);
    let mut b = ask(other, others, relation.influences.1);
    // Temperatures, where both conduct; else fields stay as at rest.
    if law.name.starts_with("heat") {
        let warm: Vec<f64> = (0..body.x.len())
            .map(|k| 300.0 + (k as f64 * 1.7).sin())
            .collect();
        a.fields[0][0].clone_from(&warm);
        b.fields[0][0] = warm;
    }
    let (mut a, _) = a.oracle();
    let (mut b, scale) = b.oracle();
    if law.name == "absorbing" {
        a.rates.clear();
        b.rates.clear();
    }
    if a.rates.len() != b.rates.len() {
        // One of them conducts heat and the other does not.
        (a.rates, b.rates) = (vec![], vec![]);
    }
    (a.energy, b.energy) = (vec![], vec![]);
    let gap = a.difference(&b, &scale);
    println!(
        "{} as {} in {}: {gap}",
        relation.law,
        relation.of,
        flavour.name()
    );
    let bound = if relation.small { 1e-5 } else { 1e-11 };
    assert!(
        gap.worst() < bound,
        "{} as {} in {}: {gap}",
        relation.law,
        relation.of,
        flavour.name()
    );
    true
}
