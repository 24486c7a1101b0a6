//! What scenes ask of the language: expressions, influence functions, laws.

use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_runtime::language::dimension::{LENGTH, NUMBER, VELOCITY};
use pdlang_runtime::language::{Complaint, Constant, Expected, Language, Variable};
use pdlang_runtime::spec::{Op, Tape};

fn variables() -> Vec<Variable> {
    let variable = |name: &str, unit| Variable {
        name: name.into(),
        unit,
    };
    vec![
        variable("x", LENGTH),
        variable("y", LENGTH),
        variable("A", LENGTH),
        variable("n", NUMBER),
    ]
}

fn compile(text: &str, expected: Expected) -> Result<Tape, String> {
    let shown = |c: Vec<Complaint>| {
        c.iter()
            .map(|c| c.message.clone())
            .collect::<Vec<_>>()
            .join("; ")
    };
    Pdlang
        .expression(text, &variables(), expected)
        .map(|c| c.tape)
        .map_err(shown)
}

#[test]
fn quantities_are_converted_and_checked() {
    let length = Expected::Unit(LENGTH);
    assert_eq!(
        compile("0.5 mm", length).expect("a length").ops,
        [Op::Lit(0.5e-3)]
    );
    assert_eq!(compile("0.25", length).expect("in SI").ops, [Op::Lit(0.25)]);
    assert_eq!(
        compile("100 m/s", Expected::Unit(VELOCITY))
            .expect("a speed")
            .ops,
        [Op::Lit(100.0)]
    );
    let wrong = compile("3 s", length).expect_err("a time");
    assert!(
        wrong.contains("expected m") && wrong.contains("found s"),
        "{wrong}"
    );
}

/// `A` is a length here, and an ampere elsewhere.
#[test]
fn a_unit_with_the_name_of_a_variable_is_what_fits() {
    let area = Expected::Unit([4, 0, 0, 0, 0, 0, 0]);
    let vars = |tape: Tape| tape.ops.iter().any(|op| matches!(op, Op::Var(_)));
    assert!(vars(compile("2 mm*A", area).expect("an area")));
    assert!(vars(compile("2 mm*A", Expected::Scalar).expect("an area")));
    let current = Expected::Unit([2, 0, 0, 2, 0, 0, 0]);
    assert!(!vars(
        compile("2 mm*A", current).expect("a length times a current")
    ));
    let wrong = compile("2 mm*A", Expected::Unit(VELOCITY)).expect_err("no speed");
    assert!(wrong.contains("expected m/s"), "{wrong}");
}

#[test]
fn expressions_are_checked_with_units_or_are_plain_numbers() {
    let length = Expected::Unit(LENGTH);
    assert!(compile("A*sin(x/(1 mm))", length).is_ok());
    assert!(
        compile("1e-5*sin(x)", length).is_ok(),
        "no unit appears: all in SI"
    );
    assert!(
        compile("n*x^2", length).is_ok(),
        "no unit appears: all in SI"
    );
    assert!(
        compile("A*x", length).is_err(),
        "A has a unit, so units count"
    );
    assert!(
        compile("1e-5*sin(x/A)", length).is_err(),
        "A has a unit, so units count"
    );
    assert!(compile("x < 3", Expected::Condition).is_ok());
    assert!(compile("x < 3 mm", Expected::Condition).is_ok());
    assert!(compile("x + 1", Expected::Condition).is_err());
}

#[test]
fn influence_functions_come_with_their_values() {
    let (function, values) = Pdlang
        .influence("softened(p = 2, eps = 0.5 mm)", &[])
        .expect("in the prelude");
    assert_eq!(
        (function.name.as_str(), values),
        ("softened", vec![2.0, 0.5e-3])
    );
    assert!(Pdlang.influence("1/x", &[]).is_ok());
    assert!(Pdlang.influence("softened(p = 2)", &[]).is_err());
    assert!(Pdlang.influence("sin(", &[]).is_err());
}

#[test]
fn names_of_the_scene_stand_for_numbers_in_influence_functions() {
    let constant = |name: &str, value, unit| Constant {
        name: name.into(),
        value,
        unit,
    };
    let names = [constant("a", 0.5e-3, LENGTH), constant("n", 2.0, NUMBER)];
    let values = |text: &str| Pdlang.influence(text, &names).map(|(_, values)| values);
    assert_eq!(values("softened(p = n, eps = 2*a)"), Ok(vec![2.0, 1e-3]));
    assert!(values("softened(p = a, eps = a)").is_err(), "p is a number");
    let (function, values) = Pdlang
        .influence("exp(-x/a)", &names)
        .expect("an expression");
    assert!(values.is_empty() && function.body.ops.contains(&Op::Lit(0.5e-3)));
}

#[test]
fn laws_come_from_the_catalogue_or_from_a_file() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let law = |name: &str| Pdlang.law(name, here, 3);
    assert_eq!(law("pmb").expect("in the catalogue").spec.dim, 3);
    assert_eq!(law("laws/lps.pd").expect("a file").spec.law, "lps");
    let error = law("pbm").err().expect("a typing error");
    assert!(error.help.is_some_and(|h| h.contains("pmb")));
    assert!(law("laws/none.pd").is_err());
}

#[test]
fn no_text_panics() {
    let texts = [
        "",
        " ",
        "é",
        "3 é",
        "((((",
        "1/0",
        "x^x^x",
        "0x",
        "1e999 mm",
        "\"",
        "case flavour {",
    ];
    for text in texts {
        for expected in [
            Expected::Scalar,
            Expected::Condition,
            Expected::Unit(LENGTH),
        ] {
            let _ = compile(text, expected);
        }
        let _ = Pdlang.influence(text, &[]);
    }
}
