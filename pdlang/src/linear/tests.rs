use crate::assemble::{self, Kinematics};
use crate::emit::{self, Stage as Shown};
use crate::files::nowhere;
use crate::front;
use crate::ir::Law;
use crate::sound;
use crate::spec::{Spec, Stage};
use crate::tape::Op;

fn text(law: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../models/laws");
    std::fs::read_to_string(format!("{folder}/{law}.pd")).expect("the law's file")
}

fn law(text: &str) -> Law {
    let mut checked = front::file(text);
    assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
    checked.laws.remove(0)
}

fn linearised(law: &Law, dim: usize) -> Spec {
    let made = sound::compiled(law, dim, Kinematics::Linearised);
    let (spec, found) = made.expect("the law can be linearised");
    assert_eq!(found, Vec::<String>::new(), "{} in {dim}D", law.name);
    assert!(spec.linearised);
    spec
}

#[test]
fn bonds_need_no_root() {
    for name in ["pmb", "gpmb", "lps", "lps_frozen", "correspondence_svk"] {
        for dim in 1..=3 {
            let spec = linearised(&law(&text(name)), dim);
            for s in spec.sweeps.iter().filter(|s| s.stage == Stage::Step) {
                let ops = s.bond.ops.iter().chain(&s.from_streams.ops);
                let root = |op: &&Op| matches!(op, Op::Ix | Op::Rsqrt(_) | Op::Sqrt(_));
                let found: Vec<&Op> = ops.filter(root).collect();
                assert!(found.is_empty(), "{name} in {dim}D, {}: {found:?}", s.name);
            }
        }
    }
}

#[test]
fn forces_on_bonds_alone_stay_so() {
    for dim in 1..=3 {
        assert!(linearised(&law(&text("pmb")), dim).pairwise, "{dim}");
        assert!(!linearised(&law(&text("lps")), dim).pairwise, "{dim}");
    }
}

#[test]
fn what_is_linear_stays_as_it_is() {
    for name in ["absorbing", "heat", "heat_state"] {
        let law = law(&text(name));
        for dim in 1..=3 {
            let general = assemble::spec(&law, dim, Kinematics::General).expect("it fits");
            let expected = Spec {
                linearised: true,
                ..general
            };
            assert_eq!(linearised(&law, dim), expected, "{name} in {dim}D");
        }
    }
}

fn refusal(text: &str) -> String {
    let request = emit::Request {
        stage: Shown::Passes,
        kinematics: Kinematics::Linearised,
        dim: None,
        link: None,
        more: &[],
    };
    let made = emit::emit_in(text, "m.pd", &mut nowhere, request);
    let shown = made.expect_err("the law cannot be linearised");
    let shown = shown.iter().map(|d| d.render(text, "m.pd", false));
    shown.collect::<Vec<_>>().join("\n\n")
}

/// A law in 1D whose items may read a field.
fn bare(items: &str) -> String {
    format!(
        "model m \"M\" cite \"Nobody, eq. 1\" {{\n  param K : pressure > 0 \"modulus\"\n  field T : number \"field\"\n  {items}\n}}\n"
    )
}

#[test]
fn a_memory_of_displacements_is_refused_where_it_stands() {
    assert_eq!(
        refusal(&text("lps_plastic")),
        "error[PD091]: `lps_plastic` cannot be linearised: its history `ep` remembers displacements
  --> m.pd:13:11
   |
13 |   history ep : length = 0 on bond  \"plastic extension\"
   |           ^^ its update reads what the displacement changes
   |
   = help: a linearised law is the slope of its answers at rest; use the law as it is"
    );
    // One of time alone is none.
    let clock =
        "history t : time = 0 on node \"age\" update t = t + dt energy W = K*sum(x*s^2)/sum(x)";
    linearised(&law(&bare(clock)), 2);
}

#[test]
fn what_is_not_smooth_is_refused_where_it_stands() {
    let all = |items: &str, says: &[&str]| {
        let shown = refusal(&bare(items));
        assert_eq!(shown.matches("error[").count(), 1, "{shown}");
        for words in says {
            assert!(shown.contains(words), "{words}: {shown}");
        }
    };
    let theta = "node theta = sum(x*e)/sum(x^2)";
    all(
        &format!("{theta} node k = 1/max(1, theta) energy W = K*k*theta^2"),
        &[
            "`k` is not smooth at rest",
            " ^^^^^^^^^^^^^ this has no slope where nothing is displaced",
        ],
    );
    all(
        &format!("{theta} energy W = K*abs(theta)"),
        &["its energy is not smooth at rest", "^^^^^^^^^^"],
    );
    all(
        &format!("{theta} energy W = K*select(theta > 0, theta^2, 0)"),
        &[
            "its energy is not smooth at rest",
            "^^^^^^^^^^^^^^^^^^^^^^^^^^^^",
        ],
    );
    all(
        "rate T = max(s)/delta*1 [m/s]",
        &["its rate is not smooth", "^^^^^^"],
    );
    // No slope at 0, though neither a choice nor an extreme.
    all(
        "energy W = K*sum(norm(eta)*x)/sum(x^2)",
        &["its energy is not smooth"],
    );
    all(
        "energy W = K*sum(x*s^2)/sum(x) after step velocity = velocity/2",
        &["it replaces velocities", "^^^^^^^^^^ after every step"],
    );
}

#[test]
fn choices_that_fields_make_are_smooth() {
    for items in [
        "energy W = K*sum(x*s^2)/sum(x)*select(T > 0, 1, 2) + K*abs(T)",
        "energy W = K*sum(x*s^2)/sum(x)*max(T, 1) break when max(s, abs(s) - 1) > 0.1",
    ] {
        linearised(&law(&bare(items)), 2);
    }
}

#[test]
fn what_is_nothing_at_rest_by_value_is_seen_to_be() {
    let rough = refusal(&bare("energy W = K*sum(x*(ln(1 + s)^2)^0.75)/sum(x)"));
    assert!(rough.contains("its energy is not smooth"), "{rough}");
    // The degree of the last is beyond all integers.
    let powers: Vec<String> = (0..8)
        .map(|k| format!("bond b{} = 1 + b{k}^64", k + 1))
        .collect();
    let tower = format!(
        "bond b0 = 1 + eta.x/x {} energy W = K*sum(b8*x)/sum(x)",
        powers.join(" ")
    );
    let beyond = refusal(&bare(&tower));
    assert!(beyond.starts_with("error[PD090]"), "{beyond}");
}

#[test]
fn conditions_keep_what_displacements_change() {
    let energy = "energy W = K*sum(x*s^2)/sum(x)";
    for condition in [
        "1 + s^2 > 1.01",
        "ln(1 + s)^2 > 0.01",
        "(s - 0.1*T)^2 > 0.01",
        "s > 0.1",
        "s > 0",
    ] {
        let spec = linearised(&law(&bare(&format!("{energy} break when {condition}"))), 2);
        let kills = spec.sweeps.iter().find(|s| s.kills).expect("bonds break");
        let moved = |op: &Op| matches!(op, Op::Eta(_));
        assert!(
            kills.bond.ops.iter().any(moved),
            "{condition}: {:?}",
            kills.bond
        );
        let killed = |op: &Op| matches!(op, Op::Kill(_));
        let (kill, _) = kills
            .bond
            .ops
            .iter()
            .enumerate()
            .find(|(_, op)| killed(op))
            .expect("one breaks");
        let before = &kills.bond.ops[..kill];
        assert!(before.iter().any(moved), "{condition}: {before:?}");
    }
}
