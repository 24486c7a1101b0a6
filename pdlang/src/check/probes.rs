//! PD060: a probe that does not fit its law.

use crate::ast::Name;
use crate::check::{shape_name, suggest};
use crate::diag::Diagnostic;
use crate::ir::{Flavour, Shape};
use crate::span::Span;

const CODE: &str = "PD060";

fn error(message: String) -> Diagnostic {
    Diagnostic::error(CODE, message)
}

fn listed(names: &[impl AsRef<str>]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{}`", n.as_ref())).collect();
    quoted.join(", ")
}

fn unknown(what: &str, name: &Name, known: &[String]) -> Diagnostic {
    let finding = error(format!("there is no {what} `{}`", name.text))
        .at(name.span, format!("unknown {what}"));
    // As scenes call it.
    let other = (name.text == "cross_section" && known.iter().any(|k| k == "area"))
        .then(|| "did you mean `area`?".to_string());
    match other.or_else(|| suggest::question(&name.text, known)) {
        Some(question) => finding.help(question),
        None if known.is_empty() => finding,
        None => finding.help(format!("here, there is {}", listed(known))),
    }
}

pub(crate) fn unknown_setting(name: &Name, known: &[String]) -> Diagnostic {
    unknown("setting", name, known)
}

pub(crate) fn unknown_node(name: &Name, known: &[String]) -> Diagnostic {
    unknown("node", name, known)
}

/// `known` are the definitions of the law, its energy and `force`, or its fields.
pub(crate) fn unknown_quantity(name: &Name, known: &[String]) -> Diagnostic {
    unknown("quantity", name, known)
}

pub(crate) fn missing(probe: &Name, missing: &[&str]) -> Diagnostic {
    error(format!(
        "the probe `{}` does not set {}",
        probe.text,
        listed(missing)
    ))
    .at(probe.span, "")
    .help("set them behind the flavour: `where K = 1 GPa, delta = 3 mm`")
}

pub(crate) fn outside(name: &Name, value: Span) -> Diagnostic {
    error(format!("`{}` is outside of its bounds", name.text)).at(value, "the law forbids this")
}

pub(crate) fn not_one(weight: &Name, value: Span) -> Diagnostic {
    error(format!("the weight `{}` is computed, or 1", weight.text)).at(value, "not 1")
}

pub(crate) fn not_positive(name: &Name, value: Span) -> Diagnostic {
    error(format!("`{}` must be positive", name.text)).at(value, "not a positive number")
}

pub(crate) fn no_volume(node: &Name) -> Diagnostic {
    error(format!("the node `{}` has no volume", node.text))
        .at(node.span, "")
        .help("give it one: `V = 1 mm^3`")
}

pub(crate) fn no_body(probe: &Name) -> Diagnostic {
    error(format!("the probe `{}` has no nodes", probe.text))
        .at(probe.span, "")
        .help("`node a = (0, 0, 0), V = 1 mm^3`, or `lattice 1 mm, H = ..` for a homogeneous deformation")
}

pub(crate) fn two_bodies(place: Span) -> Diagnostic {
    error("a probe has nodes or one lattice".into())
        .at(place, "this is not all there is")
        .help("write two probes")
}

pub(crate) fn too_large(probe: &Name, most: usize) -> Diagnostic {
    error(format!("a probe has at most {most} nodes")).at(probe.span, "more than that")
}

pub(crate) fn coincide(a: &Name, b: &Name) -> Diagnostic {
    error("two nodes are at the same place".into())
        .at(b.span, "the second one")
        .at(a.span, "the first one")
}

pub(crate) fn reach(spacing: Span, most: f64) -> Diagnostic {
    error(format!(
        "the horizon is between one and {most} spacings of the lattice of a probe"
    ))
    .at(spacing, "does not fit `delta`")
}

pub(crate) fn no_bond(a: &Name, b: &Name) -> Diagnostic {
    error(format!(
        "there is no bond from `{}` to `{}`",
        a.text, b.text
    ))
    .at(b.span, "farther away than `delta`, or the same node")
}

pub(crate) fn place(name: &Name, home: &str, example: &str) -> Diagnostic {
    error(format!("`{}` lives {home}", name.text))
        .at(name.span, "")
        .help(format!("`expect {}{example} = ..`", name.text))
}

/// On a lattice there is one node, and none of its bonds has a name.
pub(crate) fn bonds_without_names(name: &Name) -> Diagnostic {
    error(format!("`{}` lives on a bond, and the bonds of a lattice have no names", name.text))
        .at(name.span, "which bond?")
        .help(format!(
            "expect what the law sums over them, or give the probe two nodes: `node a = .., V = .. node b = .., V = .. expect {}(a, b) = ..`",
            name.text
        ))
}

pub(crate) fn nothing_expected(probe: &Name) -> Diagnostic {
    error(format!("the probe `{}` expects nothing", probe.text))
        .at(probe.span, "")
        .help("`expect force(a) = (.., ..)`, with the value in closed form")
}

pub(crate) fn components(place: Span, shape: Shape, flavour: Flavour) -> Diagnostic {
    let dim = flavour.dim();
    let form = match (shape, dim) {
        (Shape::Scalar | Shape::Boolean, _) | (_, 1) => "one value",
        (Shape::Vector, 2) => "`(.., ..)`",
        (Shape::Vector, _) => "`(.., .., ..)`",
        (_, 2) => "`((.., ..), (.., ..))`",
        _ => "three rows `((.., .., ..), .., ..)`",
    };
    let what = shape_name(shape);
    error(format!("wrong components: {what} in {dim}D is {form}")).at(place, "")
}

pub(crate) fn not_a_scalar(place: Span) -> Diagnostic {
    error("a probe consists of scalars".into()).at(place, "not a scalar")
}

pub(crate) fn tolerance(place: Span) -> Diagnostic {
    error("this is no tolerance".into())
        .at(place, "neither a number nor in the unit of the quantity")
        .help("`within 1e-9` is relative; with the unit of the quantity it is absolute")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    const TWO: &str = "node a = (0, 0), V = 1 mm^3 node b = (1 mm, 0), V = 1 mm^3";
    const SET: &str = "K = 1 GPa, delta = 2 mm";

    fn wrong(set: &str, lines: &str, code: &str, token: &str) {
        refuse(
            &format!("probe p in plane_strain where {set} {{ {lines} }}"),
            code,
            token,
        );
    }

    #[test]
    fn settings_are_known_complete_and_in_bounds() {
        let lines = &format!("{TWO} expect W(a) = 0");
        wrong("K = 1 GPa, delta = 2 mm, Q = 1", lines, "PD060", "Q");
        wrong(
            "K = 1 GPa, delta = 2 mm, area = 1 mm^2",
            lines,
            "PD060",
            "area",
        );
        wrong("K = 1 GPa", lines, "PD060", "p");
        wrong("K = -1 GPa, delta = 2 mm", lines, "PD060", "-1 GPa");
        wrong("K = 1 GPa, delta = -2 mm", lines, "PD060", "-2 mm");
        wrong("K = 1 GPa, K = 1 GPa, delta = 2 mm", lines, "PD003", "K");
        wrong("K = 1 mm, delta = 2 mm", lines, "PD034", "1 mm");
        wrong("K = 1 GPa, delta = c", lines, "PD002", "c");
        wrong(
            "K = 1 GPa, delta = (1 mm, 2 mm)",
            lines,
            "PD060",
            "(1 mm, 2 mm)",
        );
        refuse("probe p in 4d { node a = 0 }", "PD010", "4d");
    }

    #[test]
    fn bodies_are_nodes_or_a_lattice() {
        wrong(SET, "expect W = 0", "PD060", "p");
        wrong(
            SET,
            &format!("{TWO} lattice 1 mm expect W = 0"),
            "PD060",
            "lattice",
        );
        wrong(SET, "node a = (0, 0) expect W(a) = 0", "PD060", "a");
        wrong(
            SET,
            "node a = (0, 0, 0), V = 1 mm^3 expect W(a) = 0",
            "PD060",
            "(0, 0, 0)",
        );
        wrong(
            SET,
            "node a = (0, 0), V = 1 mm^3, w = 1 expect W(a) = 0",
            "PD060",
            "w",
        );
        wrong(
            SET,
            &format!("{TWO} node c = (0, 0), V = 1 mm^3 expect W(a) = 0"),
            "PD060",
            "c",
        );
        wrong(
            SET,
            &format!("{TWO} break (a, c) expect W(a) = 0"),
            "PD060",
            "c",
        );
        wrong(
            "K = 1 GPa, delta = 0.5 mm",
            &format!("{TWO} break (a, b) expect W(a) = 0"),
            "PD060",
            "b",
        );
        wrong(SET, "lattice 1 um expect W = 0", "PD060", "1 um");
        wrong(
            SET,
            "lattice 1 mm, H = (1, 2) expect W = 0",
            "PD060",
            "(1, 2)",
        );
    }

    #[test]
    fn expectations_name_a_quantity_at_its_place() {
        let expect = |what: &str| format!("{TWO} {what}");
        wrong(SET, &expect(""), "PD060", "p");
        wrong(SET, &expect("expect Q(a) = 1"), "PD060", "Q");
        wrong(SET, &expect("expect W = 1 Pa"), "PD060", "W");
        wrong(SET, &expect("expect W(c) = 1 Pa"), "PD060", "c");
        wrong(SET, &expect("expect W(a) = 1"), "PD034", "1");
        wrong(SET, &expect("expect s(a) = 1"), "PD060", "s");
        wrong(SET, &expect("expect rate T(a) = 1"), "PD060", "T");
        wrong(SET, &expect("expect force(a) = 1"), "PD060", "1");
        wrong(SET, &expect("expect W(a) = sum(1)"), "PD002", "sum");
        wrong(
            SET,
            &expect("expect W(a) = 1 Pa within 1 mm"),
            "PD060",
            "1 mm",
        );
        wrong(SET, &expect("expect W(a) = 1 Pa within -1"), "PD060", "-1");
    }

    fn findings(set: &str, lines: &str) -> Vec<(&'static str, String)> {
        let text = format!("probe p in plane_strain where {set} {{ {lines} }}");
        crate::check::tests::found(&crate::check::tests::law(&text))
    }

    #[test]
    fn every_error_of_a_probe_is_told_once() {
        let found = findings(
            "K = -1 GPa, delta = -2 mm",
            "node a = (0, 0, 0), V = 1 mm^3, w = 1
             node b = (1 mm, 0), V = 0
             expect Q(a) = 1  expect s(a, c) = 0  expect W(a) = 1",
        );
        let tokens: Vec<&str> = found.iter().map(|(_, token)| token.as_str()).collect();
        assert_eq!(
            tokens,
            ["-1 GPa", "-2 mm", "(0, 0, 0)", "w", "0", "Q", "c", "1"]
        );
        // What only follows from another error is not told.
        let found = findings("K = 1 mm, delta = 2 mm", &format!("{TWO} expect W(a) = K"));
        assert_eq!(found, [("PD034", "1 mm".to_string())]);
    }

    #[test]
    fn one_number_may_stand_for_all_components() {
        let probe = |dim, lines: &str| {
            format!("probe p in {dim} where K = 1 GPa, delta = 2 mm {{ {lines} }}")
        };
        for dim in ["slab", "plane_strain", "3d"] {
            accept(&probe(
                dim,
                "lattice 1 mm, H = 0.01*I expect force = 0 within 1",
            ));
            accept(&probe(
                dim,
                "lattice 1 mm, H = -I/100 expect force = 0 within 1",
            ));
        }
        let text = probe("3d", "lattice 1 mm, H = 0.01 expect force = 0 within 1");
        refuse(&text, "PD060", "0.01");
        let text = probe("3d", "lattice 1 mm, H = 0 expect force = I within 1");
        refuse(&text, "PD060", "I");
    }

    #[test]
    fn a_bond_of_a_lattice_is_answered_with_two_nodes() {
        let text =
            "probe p in 3d where K = 1 GPa, delta = 2 mm { lattice 1 mm expect s(a, b) = 0 }";
        let found = crate::front::file(&crate::check::tests::law(text)).diagnostics;
        let errors: Vec<_> = found.iter().filter(|d| d.is_error()).collect();
        let help = errors[0].help.clone().unwrap_or_default();
        assert!(help.contains("two nodes"), "{help}");
        assert_eq!(errors.len(), 1, "{errors:?}");
    }

    #[test]
    fn a_probe_may_use_functions_and_names_of_its_own() {
        accept(
            "probe p in bar where K = 1 GPa, delta = 2 mm, area = 1 mm^2 {
               let t = 1e-3
               node a = 0, V = 1 mm^3
               node b = 1 mm, V = 1 mm^3, u = t*(1 mm)
               expect s(a, b) = t within 1e-10
               expect W(a) = K*t^2*(1 mm^3)/(4 mm^3) within 1e-10
               expect force(a) = max(K, K_bb(K))*t/(1 mm) within 1
             }",
        );
    }
}
