//! The quick studies of `pdlang bench accuracy` pass, and the report says what they find.

use pdlang_models::accuracy::indentation::{Curve, PAPER};
use pdlang_models::accuracy::{STUDIES, Tolerance, figure};

#[test]
fn quick_studies_pass_and_are_reported() {
    let page = std::fs::read_to_string("../docs/accuracy.md").expect("the report");
    let lines: Vec<Vec<&str>> = page
        .lines()
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    let studies = || STUDIES.iter().copied().flatten();
    assert!(studies().any(|study| study.long) && studies().any(|study| !study.long));
    for study in studies() {
        assert!(
            page.contains(&format!("\n## {}\n", study.id)),
            "{}",
            study.id
        );
        assert!(page.contains(study.about), "{}: {}", study.id, study.about);
    }
    for study in studies().filter(|study| !study.long) {
        let rows = (study.measure)().unwrap_or_else(|why| panic!("{}: {why}", study.id));
        assert!(!rows.is_empty(), "{} measures nothing", study.id);
        for row in rows {
            let what = format!("{}, {}", study.id, row.quantity);
            assert!(
                row.pass(),
                "{what}: {:e} for {:e}",
                row.value,
                row.reference
            );
            let rest = [
                figure(row.reference),
                row.tolerance.to_string(),
                "pass".into(),
            ];
            let reported = lines.iter().find_map(|cells| match cells[..] {
                [_, quantity, value, a, b, c, _] if quantity == row.quantity => {
                    ([a, b, c] == rest.each_ref().map(String::as_str)).then_some(value)
                }
                _ => None,
            });
            let reported = reported.unwrap_or_else(|| panic!("docs/accuracy.md lacks {what}"));
            let reported: f64 = reported.parse().expect("a number");
            // Small differences from a reference are of the processor, others are not.
            let bound = matches!(row.tolerance, Tolerance::AtMost) && row.value < 1e-9;
            let near = (row.value - reported).abs() <= 2e-3 * row.value.abs();
            assert!(
                near || bound,
                "{what}: {:e}, reported {reported:e}",
                row.value
            );
        }
    }
}

#[test]
fn figures_have_four_digits() {
    let of = [
        0.0,
        1.0,
        0.08,
        1.19787,
        12345.6,
        123456.0,
        5.6e-7,
        -0.00123449,
        100.0,
    ];
    let text = [
        "0",
        "1",
        "0.08",
        "1.198",
        "12346",
        "1.235e5",
        "5.6e-7",
        "-0.001234",
        "100",
    ];
    assert_eq!(of.map(figure), text.map(String::from));
}

/// The fit of paper-pml-3b-fit, of points that lie on the paper's own curve.
#[test]
fn the_fit_of_cracks_finds_the_curve_that_made_the_points() {
    let loads = (140..=500).step_by(20).map(f64::from);
    let points: Vec<(f64, f64)> = loads.map(|p| (p, PAPER.at(p))).collect();
    let found = Curve::through(&points);
    assert!((found.s - PAPER.s).abs() < 1e-6 && found.squares(&points) < 1e-12);
    assert!((found.a / PAPER.a - 1.0).abs() < 1e-5 && (found.b / PAPER.b - 1.0).abs() < 1e-5);
    // As its numbers have it, in mm.
    assert!((PAPER.at(140.0) - 10.77).abs() < 0.01 && (PAPER.at(500.0) - 19.62).abs() < 0.01);
}
