//! Misprints, planted in laws of the catalogue one by one.

use pdlang::front;
use pdlang_models::registry;
use pdlang_models::verify::{Level, Options, verify};

use super::summary;

/// A misprint: what of which law becomes what, and who finds it where.
struct Planted {
    law: &'static str,
    edits: &'static [(&'static str, &'static str)],
    check: &'static str,
    /// The definition that is named; of a text that is refused, its code.
    place: &'static str,
}

const fn planted(
    law: &'static str,
    edits: &'static [(&'static str, &'static str)],
    check: &'static str,
    place: &'static str,
) -> Planted {
    Planted {
        law,
        edits,
        check,
        place,
    }
}

/// Numbers such as E10 and E-PML1 are those of the errata of the papers and the book that the laws cite.
const PLANTED: [Planted; 42] = [
    // 9 for 15: another dimension's factor of the deviatoric energy.
    planted(
        "lps",
        &[("dim*(dim+2)*G", "dim*dim*G")],
        "constants",
        "energy W",
    ),
    planted(
        "lps",
        &[("sum(omega * ed^2)", "sum(ed^2)")],
        "text",
        "PD012",
    ),
    planted(
        "lps",
        &[("dim/m * sum(omega * x * e)", "dim/m * sum(x * e)")],
        "text",
        "PD012",
    ),
    planted(
        "lps",
        &[("dim/m * sum", "3/m * sum")],
        "constants",
        "node theta",
    ),
    planted(
        "lps",
        &[("theta*x/dim", "theta*x/3")],
        "constants",
        "bond ed",
    ),
    planted("lps", &[("theta^2/2", "theta^2")], "constants", "energy W"),
    planted("lps", &[("/2 + dim", "/2 - dim")], "constants", "energy W"),
    planted("lps", &[("/2 + dim", "/2 - dim")], "step", "energy W"),
    // Small strain where the law claims objectivity.
    planted(
        "lps",
        &[("sum(omega * x * e)", "sum(omega * dot(xi, eta))")],
        "objectivity",
        "node theta",
    ),
    planted(
        "lps",
        &[("e - theta*x/dim", "dot(xi, eta)/x - theta*x/dim")],
        "objectivity",
        "bond ed",
    ),
    planted(
        "lps",
        &[("K_d(K, G)*theta", "K*theta")],
        "constants",
        "energy W",
    ),
    // Another dimension's constant.
    planted(
        "pmb",
        &[("2*dim^2*K_bb(K)", "18*K_bb(K)")],
        "constants",
        "let c",
    ),
    planted(
        "pmb",
        &[("K_bb(K) / ball(x)", "K_bb(K) / (pi*delta^4)")],
        "constants",
        "let c",
    ),
    planted(
        "pmb",
        &[("2*dim^2*K_bb(K)", "2*dim^2*K")],
        "constants",
        "let c",
    ),
    planted("pmb", &[("c/4 * sum", "c/2 * sum")], "constants", "let c"),
    // E-IF4: the Poisson ratio of plane stress in plane strain.
    planted("gpmb", &[("K_bb(K)", "3*K/4")], "constants", "let cg"),
    // E-PML1: the stretch has the length of eta where that of xi belongs.
    planted(
        "pmb",
        &[("x * s^2", "x * ((y - x)/norm(eta))^2")],
        "limits",
        "energy W",
    ),
    // An energy that jumps.
    planted(
        "pmb",
        &[("sum(x * s^2)", "sum(select(s > 0.003, 2, 1)*x*s^2)")],
        "gradient",
        "energy W",
    ),
    // A pair force that is not the same from both ends.
    planted(
        "pmb",
        &[(
            "energy W = c/4 * sum(x * s^2)",
            "node q = sum(1)/sum0(1) pair f = q*c*s",
        )],
        "text",
        "PD042",
    ),
    planted(
        "lps_frozen",
        &[("sum0(omega * x^2)", "sum(omega * x^2)")],
        "release",
        "node m",
    ),
    // Of an undeclared mode without energy.
    planted(
        "correspondence",
        &[("known zero_energy", "known lattice_constants")],
        "zero_energy",
        "node H",
    ),
    planted(
        "correspondence_stabilised",
        &[(" + Gs*C_bb(E, nu)*V/sum(omega) * z", "")],
        "zero_energy",
        "node H",
    ),
    // E-NMBC1: the stabilisation with the printed unit.
    planted(
        "correspondence_stabilised",
        &[("*V/sum(omega)", "/sum(omega)")],
        "text",
        "PD012",
    ),
    // E3: the transpose of the first Piola-Kirchhoff stress.
    planted(
        "correspondence_svk",
        &[(
            "(I + H)*hooke(E, nu, Eg)",
            "hooke(E, nu, Eg)*(I + transpose(H))",
        )],
        "angular_momentum",
        "state T",
    ),
    planted(
        "correspondence_svk",
        &[(
            "(I + H)*hooke(E, nu, Eg)",
            "hooke(E, nu, Eg)*(I + transpose(H))",
        )],
        "objectivity",
        "state T",
    ),
    // E-PML3: the neighbour's stress with the shape tensor of the node.
    planted(
        "absorbing",
        &[(
            "flow(omega * sigma*diag(g))",
            "sum(omega * (sigma + sigma')*diag(g))",
        )],
        "linear_momentum",
        "node T",
    ),
    planted("heat", &[("(T' - T)", "(T - T')")], "dissipation", "rate T"),
    planted(
        "heat",
        &[("2*dim*k/ball", "dim*k/ball")],
        "constants",
        "rate T",
    ),
    // Heat that is made where two materials meet.
    planted(
        "heat",
        &[(
            "(sum(2*dim*k/ball(omega*x^2) * omega*(T' - T))",
            "(2*dim*k/ball(omega*x^2)*sum(omega*(T' - T))",
        )],
        "conservation",
        "rate T",
    ),
    planted(
        "thermo_lps",
        &[("sum(kappa*omega*(T' - T))", "kappa*sum(omega*(T' - T))")],
        "conservation",
        "let kappa",
    ),
    // The other end without its prime.
    planted(
        "heat_state",
        &[("Gs*dim/m*(T' - T", "Gs*dim/m*(T - T")],
        "constants",
        "bond h",
    ),
    // E10: 1/m for the inverse shape tensor.
    planted(
        "heat_state",
        &[("dot(grad, Kinv*xi)", "dot(grad, xi)/m")],
        "constants",
        "bond h",
    ),
    // E2: thermal strain with 3 for dim, and without.
    planted(
        "solid",
        &[("dim*al*T  # dilatation", "3*al*T")],
        "constants",
        "node theta",
    ),
    planted(
        "solid",
        &[(" + dim*al*T  # dilatation", "")],
        "constants",
        "node theta",
    ),
    // E4: the b-term is missing.
    planted(
        "solid",
        &[(" + cb*sum(Gb*x*(s - al*T)^2)", "")],
        "constants",
        "energy W",
    ),
    // E14: the mean of two ends without its parenthesis.
    planted(
        "solid",
        &[(
            "bond Sm : vector = (S + S')/2",
            "bond Sm : vector = S + S'/2",
        )],
        "constants",
        "bond Sm",
    ),
    // E18: the cosine of the turn of a bond in the dilatation.
    planted(
        "solid",
        &[("cd*sum(Gd*(s", "cd*sum(dot(M, xi)/x*Gd*(s")],
        "objectivity",
        "node theta",
    ),
    // E11: the sign of the thermal modulus; a lost factor.
    planted(
        "thermo_pmb",
        &[("- T0*c*a/2*edot", "+ T0*c*a/2*edot")],
        "coupling",
        "rate T",
    ),
    planted(
        "thermo_lps",
        &[("T0*beta*dim/m", "T0*beta/m")],
        "coupling",
        "rate T",
    ),
    // E6: a broken bond keeps the part of its force that comes from the dilatations of its ends.
    planted(
        "lps_frozen",
        &[(
            "energy W ",
            "bond q = dim*(K_d(K, G) - (dim+2)/dim*G)*theta/m * omega*x bond r = dim*(dim+2)*G/m * omega*e \
             force f = sum0((q + q')*M) + sum((r + r')*M) node W ",
        )],
        "symmetry",
        "bond q",
    ),
    // E-NMBC4: the factor of the influence function outside of the sum, where the stabilisation lacks it.
    planted(
        "correspondence_stabilised",
        &[(
            "omega * (sigma*Kinv*xi + Gs*C_bb(E, nu)*V/sum(omega) * z)",
            "omega*sigma*Kinv*xi + Gs*C_bb(E, nu)*V/sum(omega) * z",
        )],
        "text",
        "PD012",
    ),
    // E7: an influence factor that is missing in one sum.
    planted("lamina", &[("sum(x*s^2)\n", "sum(s^2)\n")], "text", "PD012"),
];

fn edited(planted: &Planted) -> String {
    let mut text = registry::find(planted.law)
        .expect("a law of the catalogue")
        .text
        .to_string();
    for (from, to) in planted.edits {
        assert!(text.contains(from), "{}: no `{from}`", planted.law);
        text = text.replacen(from, to, 1);
    }
    text
}

/// The line in which two texts first differ.
fn first_difference(text: &str, other: &str) -> usize {
    let pairs = text.lines().zip(other.lines());
    1 + pairs.take_while(|(a, b)| a == b).count()
}

#[test]
fn planted_mistakes_are_found_by_the_right_check_at_the_right_line() {
    let mut missed = String::new();
    for planted in &PLANTED {
        let text = edited(planted);
        let checked = front::file(&text);
        let what = format!("{} {:?}", planted.law, planted.edits[0]);
        if planted.check == "text" {
            let errors: Vec<_> = checked
                .diagnostics
                .iter()
                .filter(|d| d.is_error())
                .collect();
            let found = errors.iter().any(|d| d.code == planted.place);
            if !found {
                missed += &format!("{what}: {errors:?}\n");
            } else {
                println!("{what}: {} {}", planted.place, errors[0].message);
            }
            continue;
        }
        if checked.has_errors() {
            missed += &format!("{what}: refused: {:?}\n", checked.diagnostics);
            continue;
        }
        let verdicts = verify(&checked.laws[0], &text, &Options::default()).expect("usual values");
        let found = verdicts.iter().find(|v| {
            let named = v.place.as_ref().is_some_and(|p| p.name == planted.place);
            v.check == planted.check && v.level == Level::Fail && named
        });
        match found {
            Some(verdict) => println!("{what}: {} {}", verdict.check, verdict.sentence),
            None => {
                missed += &format!(
                    "{what} not by {} at {}:\n{}",
                    planted.check,
                    planted.place,
                    summary(&verdicts)
                )
            }
        }
    }
    assert!(missed.is_empty(), "{missed}");
}

/// The named definition is the edited one, where an edit is of the definition that is named.
#[test]
fn a_sentence_leads_to_the_line() {
    for planted in PLANTED
        .iter()
        .filter(|p| p.check == "constants" && p.law == "lps")
    {
        let text = edited(planted);
        let original = registry::find(planted.law).expect("a law").text;
        let checked = front::file(&text);
        let verdicts = verify(&checked.laws[0], &text, &Options::default()).expect("usual values");
        let line = first_difference(original, &text);
        let found = verdicts
            .iter()
            .filter(|v| v.check == "constants" && v.level == Level::Fail);
        for verdict in found {
            let place = verdict.place.as_ref().expect("a place");
            assert_eq!(
                place.line, line,
                "{:?}: {}",
                planted.edits, verdict.sentence
            );
            if planted.edits[0].1 == "/2 - dim" {
                let says = "term 2 of `energy W` (line 13) times -1 ";
                assert!(verdict.sentence.contains(says), "{}", verdict.sentence);
            }
        }
    }
}
