//! Laws that nobody wrote: random, well-typed, through the whole compiler. What the definitions say (oracle), what
//! the tapes say when read plainly, and what the engine computes on every path are the same numbers.

use pdlang_runtime::body::Flavour;
use pdlang_tests::agreement::Question;
use pdlang_tests::chance::law;
use pdlang_tests::{bodies, laws};

const LAWS: u64 = if cfg!(feature = "long") { 400 } else { 40 };

#[test]
fn laws_of_chance_mean_one_thing() {
    let mut worst = 0.0_f64;
    for seed in 0..LAWS {
        let text = law(seed);
        if std::env::var_os("SHOW").is_some() {
            println!("{seed}: {text}");
        }
        let law = laws::parse(&text);
        let flavour = Flavour::ALL[seed as usize % 5];
        for body in [bodies::carved(flavour, seed), bodies::cloud(flavour, seed)] {
            let mut question = Question::deformed(&law, body, 5e-2, seed);
            // What breaks on the way is not compared bond by bond: the path has one state where bonds may break.
            if law.breaks.iter().any(|b| b.after) {
                question.path.drain(..question.path.len() - 1);
            }
            let (mut expected, mut scale) = question.oracle();
            // Odd energies cancel between the two directions of a bond; their rounding does not.
            let (k, step) = (laws::K, question.du.as_flattened());
            let step = step.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
            scale.force = scale.force.max(1e-3 * k / question.horizon);
            scale.energy = scale.energy.max(1e-3 * k);
            scale.tangent = scale
                .tangent
                .max(1e-3 * k * step / question.horizon.powi(2));
            // The tangent holds extremes, which have no derivative where they jump.
            if text.contains("min(") || text.contains("max(x/delta*") {
                expected.tangent.clear();
            }
            let expected_breaks = expected.breaks;
            let mut check = |what: &str, got: &pdlang_tests::agreement::Answer| {
                let difference = got.difference(&expected, &scale);
                let found = difference.worst();
                worst = worst.max(found);
                assert!(found <= 1e-11, "law {seed}, {what}: {difference}\n{text}");
            };
            // The plain reading breaks what breaks; the others are asked first and break then.
            if law.breaks.is_empty() {
                check("plain", &question.plain());
            }
            question.everywhere(|what, engine| {
                let mut answer = question.ask(engine);
                let mut state = question.state(engine);
                engine.forces(&mut state, pdlang_runtime::engine::Breaking::Held);
                answer.breaks += engine.commit(&mut state);
                check(what, &answer);
                assert_eq!(
                    answer.breaks, expected_breaks,
                    "law {seed}, {what}: bonds\n{text}"
                );
            });
        }
    }
    println!("{LAWS} laws, largest difference {worst:.1e}");
}
