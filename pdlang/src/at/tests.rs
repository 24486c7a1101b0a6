use super::*;
use crate::files::nowhere;

const LAWS: &str = r#"# theta here is in a comment
fn twice(a) = 2*a
model one "theta" cite "a, eq. 1" {
  influence omega = 1/x
  param K : pressure > 0 "bulk modulus"
  node m = sum(omega*x^2)
  node theta = dim/m * sum(omega*x*e)
  energy W = twice(K)*theta^2/2
}
model two "t" cite "a, eq. 1" { param K : pressure "k" energy W = nothing*K }
"#;

fn find(before: &str, name: &str) -> Option<Named> {
    let start = LAWS.find(&format!("{before}{name}")).unwrap() + before.len();
    at(LAWS, "", &mut nowhere, start)
}

fn line(before: &str, name: &str) -> String {
    find(before, name).unwrap().is
}

fn defined(before: &str, name: &str) -> String {
    let span = find(before, name).unwrap().definition.unwrap();
    LAWS[..span.start as usize].lines().count().to_string()
        + &LAWS[span.start as usize..span.end as usize]
}

#[test]
fn a_name_says_home_shape_unit_and_formula() {
    let theta = "node scalar theta [a pure number] = dim/m * sum(omega*x*e)";
    assert_eq!(line("twice(K)*", "theta"), theta);
    assert_eq!(line("node ", "theta"), theta);
    assert_eq!(line("twice(", "K"), "param scalar K [Pa]");
    assert_eq!(find("twice(", "K").unwrap().doc, "bulk modulus");
    assert!(line("sum(omega*x*", "e").starts_with("bond scalar e [m] = "));
}

#[test]
fn definitions_are_found_in_the_text_and_not_in_the_prelude() {
    assert_eq!(defined("twice(K)*", "theta"), "7theta");
    assert_eq!(defined("dim/", "m"), "6m");
    assert_eq!(defined("twice(", "K"), "5K");
    assert_eq!(defined("sum(", "omega"), "4omega");
    assert_eq!(defined("energy W = ", "twice"), "2twice");
    assert_eq!(find("sum(omega*x*", "e").unwrap().definition, None);
}

#[test]
fn nothing_is_said_of_comments_strings_and_what_is_not_known() {
    for (before, name) in [
        ("# ", "theta"),
        ("model one \"", "theta"),
        ("", "#"),
        ("energy W = ", "nothing"),
        ("model ", "one"),
    ] {
        assert_eq!(find(before, name), None, "{before}{name}");
    }
}

/// All but what the error hides: the second law does not know `nothing`.
#[test]
fn a_law_with_errors_says_what_was_understood() {
    let found = find("nothing*", "K").unwrap();
    assert_eq!(found.is, "param scalar K [Pa]");
    assert_eq!((found.doc.as_str(), found.computed.len()), ("k", 0));
    let text = LAWS.replace("node m = ", "node m = ) + ");
    let at = |name: &str| at(&text, "", &mut nowhere, text.rfind(name).unwrap());
    assert_eq!(at("K)*theta").unwrap().is, "param scalar K [Pa]");
    assert_eq!(at("m * sum"), None);
    let omega = at("omega*x^2").unwrap().definition.unwrap().start as usize;
    assert!(text[omega..].starts_with("omega = 1/x"));
    let e = at("e)\n  energy").unwrap();
    assert_eq!(e.is, "bond scalar e [m] = y - x");
    assert_eq!(e.doc, "extension");
}

#[test]
fn what_is_stored_says_when_it_is_computed() {
    let theta = find("twice(K)*", "theta").unwrap().computed;
    assert_eq!(
        theta,
        ["energy theta: at every force evaluation, intact bonds of `horizon`"]
    );
    let m = find("dim/", "m").unwrap().computed;
    assert!(
        m[0].starts_with("m: once, and again where bonds broke"),
        "{m:?}"
    );
    assert!(find("sum(omega*x*", "e").unwrap().computed.is_empty());
}

#[test]
fn an_answer_says_what_it_is_and_when_it_is_computed() {
    let energy = find("energy ", "W").unwrap();
    assert_eq!(energy.is, "energy scalar W [Pa] = twice(K)*theta^2/2");
    assert!(energy.computed[0].contains("energy"), "{energy:?}");
    let law =
        "model a \"t\" cite \"a, eq. 1\" { field T : temperature \"T\" param k : conductivity \"k\"
        param c : micromodulus \"c\" pair f = c*s # the force of a bond
        rate T = flow(k*dim/ball(x)*(T' - T)/x)/(1 [J/m^3/K]) }";
    let at = |before: &str| {
        let place = law.find(before).unwrap() + before.len();
        at(law, "", &mut nowhere, place).unwrap()
    };
    let pair = at("pair ");
    assert_eq!(pair.is, "pair scalar f [N/m^6] = c*s");
    assert_eq!(pair.doc, "the force of a bond");
    let step = "at every force evaluation";
    assert!(pair.computed[0].contains(step), "{pair:?}");
    let rate = at("rate ");
    assert!(
        rate.is.starts_with("rate scalar T [K/s] = flow("),
        "{rate:?}"
    );
    assert!(rate.computed[0].contains(step), "{rate:?}");
}

#[test]
fn what_is_remembered_says_when_it_is_computed() {
    let law = "model a \"t\" cite \"a, eq. 1\" { param c : micromodulus \"c\"
        weight g = 2*x/delta \"g\" history worst : number = 0 on bond \"worst\"
        pair f = c*(sum(g*s)/sum(x)*x - worst) update worst = max(worst, s) }";
    let text = law.replace(
        "pair f = c*(sum(g*s)/sum(x)*x - worst)",
        "pair f = c*g*(s - worst)",
    );
    let computed = |name: &str| {
        let place = text.find(&format!("{name} ")).unwrap();
        at(&text, "", &mut nowhere, place)
            .unwrap()
            .computed
            .join(";")
    };
    assert!(computed("worst").contains("once per accepted step"));
    assert!(computed("g").contains("once, at rest"));
}

/// Alone in a text, as if someone had just begun to write.
fn alone(text: &str) -> Named {
    at(text, "", &mut nowhere, 1).unwrap_or_else(|| panic!("{text}"))
}

#[test]
fn every_word_of_the_language_says_what_it_is() {
    use crate::words::{ITEMS, TOP, WORDS};
    for word in TOP.iter().chain(&ITEMS).chain(&WORDS) {
        assert!(!alone(&format!("{word} ")).doc.is_empty(), "{word}");
    }
    let forms = names::FORMS.iter().map(|form| form.0);
    for name in forms.chain(names::BUILTINS.iter().map(|builtin| builtin.0)) {
        assert!(!alone(&format!("{name}(")).doc.is_empty(), "{name}");
    }
    for name in names::PRIMITIVES.iter().map(|p| p.name) {
        let found = alone(&format!("{name} "));
        assert!(!found.doc.is_empty() && found.is.contains('['), "{name}");
    }
    let prelude = crate::resolve::library::prelude();
    for name in prelude.functions.keys() {
        let found = alone(&format!("{name}("));
        assert!(found.is.starts_with(&format!("fn {name}(")), "{name}");
        assert!(found.is.contains(") = "), "{name}");
        assert!(name.contains("_of_") || !found.doc.is_empty(), "{name}");
    }
    for definition in prelude.definitions.values() {
        let doc = comment(PRELUDE_TEXT, definition.name.span.start);
        assert!(!doc.is_empty(), "{}", definition.name.text);
    }
    assert!(alone("K_bb(K)").is.ends_with("3d: K }"));
}

#[test]
fn kinds_checks_and_influence_functions_say_what_they_are() {
    let law = "model a \"t\" cite \"a, eq. 1\" { influence omega = softened(p = 2, eps = 1 mm)
        param K : pressure \"K\" node v : vector acceleration = velocity/dt
        energy W = K*sum(omega*s^2)/sum(omega) known zero_energy \"why\" }";
    let find = |name: &str| at(law, "", &mut nowhere, law.find(name).unwrap()).unwrap();
    assert_eq!(find("pressure").is, "pressure [Pa]");
    assert_eq!(find("acceleration").is, "acceleration [m/s^2]");
    assert_eq!(find("velocity").is, "node vector velocity [m/s]");
    assert!(find("zero_energy").doc.starts_with("no displacement"));
    let softened = find("softened");
    assert_eq!(
        softened.is,
        "influence softened(p [a pure number], eps [m])"
    );
    assert!(softened.doc.starts_with("softened power"));
    assert!(find("sum(").doc.contains("intact bonds"));
}

#[test]
fn shapes_flavours_and_meetings_say_what_they_are() {
    let law = "model a \"t\" cite \"a, eq. 1\" for slab, 3d {
        param K : pressure > 0 meets harmonic \"K\" let k = case flavour { 3d: K }
        node v : symmetric = sum(outer(xi, xi)) energy W = K*sum(s^2)/sum(1)
        probe one in bar where K = 1 Pa { expect W = 0 Pa } }";
    let find = |name: &str| at(law, "", &mut nowhere, law.find(name).unwrap()).unwrap();
    for (name, is, doc) in [
        ("slab", "flavour slab", "no strain across"),
        ("3d {", "flavour 3d", "three"),
        ("3d:", "flavour 3d", "three"),
        ("bar", "flavour bar", "no stress across"),
        ("harmonic", "meets harmonic", "two halves"),
        ("symmetric", "symmetric", "the same transposed"),
    ] {
        let found = find(name);
        assert_eq!(found.is, is);
        assert!(found.doc.contains(doc), "{name}: {}", found.doc);
    }
}

#[test]
fn what_has_the_name_of_a_value_and_is_none_says_nothing() {
    let text = "model a \"t\" cite \"a, eq. 1\" {
  param K : pressure \"K\" node m = sum(x) node l = K*sum(s)
  influence omega = gaussian(l = 1 mm)
  energy W = K*sum(s^2)*(1 m)*2 [K/m^3] + )
  probe p in bar where K = 2 Pa { node l = (0), V = 1 mm^3 expect m(l) = 0 }
}
fn f(K) = 2*K
";
    let find = |before: &str| {
        at(
            text,
            "",
            &mut nowhere,
            text.find(before).unwrap() + before.len(),
        )
    };
    for other in [
        "(1 ",
        "2 [",
        "2 [K/",
        "gaussian(",
        "expect m(",
        "fn f(",
        "2*",
    ] {
        assert_eq!(find(other), None, "{other}");
    }
    for name in ["W = ", "where ", "node l = "] {
        assert_eq!(find(name).unwrap().is, "param scalar K [Pa]");
    }
    assert!(find("expect ").unwrap().is.starts_with("node scalar m ["));
}

#[test]
fn comments_beside_and_above_are_read() {
    let text = "# one\n// two\nfn f(a) = a \n\nfn g(a) = \"#\" # three\nmodel m { node θ = sum(x) // four\n }";
    let find = |name: &str| at(text, "", &mut nowhere, text.find(name).unwrap()).unwrap();
    assert_eq!(find("f(a").doc, "one two");
    assert_eq!(find("f(a").is, "fn f(a) = a");
    assert_eq!(find("θ").doc, "four");
    assert_eq!(
        find("θ").definition.unwrap().start as usize,
        text.find('θ').unwrap()
    );
}

/// While a law is written it is wrong: whatever is missing, nothing panics, and most names are known.
#[test]
fn a_law_that_lacks_a_word_says_most() {
    let law = include_str!("../../../models/laws/lps.pd");
    let law = &law[..law.find("  known").unwrap_or(law.len())];
    let (mut asked, mut answered) = (0, 0);
    for token in parse::tokens(law) {
        let rest = &law[token.end..];
        let text = format!("{}{rest}}}", &law[..token.start]);
        for name in ["theta^2", "omega * ed", "m) * sum", "K_d("] {
            asked += 1;
            let place = text.rfind(name).unwrap_or(0);
            answered += usize::from(at(&text, "", &mut nowhere, place).is_some());
        }
    }
    assert!(
        asked > 400 && answered * 10 > asked * 8,
        "{answered} of {asked}"
    );
}

#[test]
fn every_place_of_any_text_has_an_answer_or_none() {
    let text = "model ω \"t\" { node θ = sum(x) fn ( } \u{1F600}";
    for offset in 0..text.len() + 3 {
        let _ = at(text, "", &mut nowhere, offset);
    }
}
