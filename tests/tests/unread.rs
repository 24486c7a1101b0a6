//! Named quantities that nobody asks for are left out, and nothing else changes by a bit.

use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_models::registry::CATALOGUE;
use pdlang_runtime::observe::{inventory, quantity};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::agreement::Question;
use pdlang_tests::{bodies, laws};

#[test]
fn answers_keep_their_bits() {
    let mut seen = Vec::new();
    for entry in CATALOGUE {
        let law = laws::law(entry.name);
        for flavour in laws::flavours(&law) {
            let q = Question::deformed(&law, bodies::carved(flavour, 1), 1e-2, 3);
            let other = Question::deformed(&law, bodies::carved(flavour, 1), 1e-2, 4);
            q.everywhere(|form, engine| {
                let expected = q.ask(engine);
                let names: Vec<String> = engine.spec().named.iter().map(|n| n.0.clone()).collect();
                let values = |engine: &pdlang_runtime::engine::Engine| -> Vec<_> {
                    names.iter().map(|n| engine.named(n)).collect()
                };
                let all = values(engine);
                assert!(all.iter().all(Option::is_some), "{form}");
                // All but the last name, then none.
                let last = names.last().cloned().unwrap_or_default();
                engine.keep_named(&|name| name != last);
                // What is no longer written must not pass for what was asked before.
                other.ask(engine);
                assert_eq!(q.ask(engine), expected, "{form}");
                for ((name, before), after) in names.iter().zip(&all).zip(values(engine)) {
                    match engine.left_out().any(|n| n == name) {
                        true => assert!(*name == last && after.is_none(), "{form}: {name}"),
                        false => assert_eq!(*before, after, "{form}: {name}"),
                    }
                }
                let left: Vec<String> = engine.left_out().map(str::to_string).collect();
                engine.keep_named(&|_| false);
                assert_eq!(q.ask(engine), expected, "{form}");
                // What was left out stays out.
                engine.keep_named(&|_| true);
                assert_eq!(q.ask(engine), expected, "{form}");
                let stays = |name: &String| engine.left_out().any(|n| n == name);
                assert!(left.iter().all(stays), "{form}");
                seen.extend(engine.left_out().map(|n| format!("{} {n}", law.name)));
            });
        }
    }
    for name in ["H", "sigma"] {
        assert!(seen.contains(&format!("correspondence_stabilised {name}")));
    }
}

fn scene(output: &str) -> Simulation {
    let text = format!(
        r#"
[body]
flavour = "plane_strain"
spacing = "1 mm"
thickness = "1 mm"
shape = {{ box = {{ from = [0, 0], to = ["12 mm", "9 mm"] }} }}
[family]
horizon = "3.015 dx"
[material]
model = "correspondence_stabilised"
density = "2200 kg/m^3"
E = "70 GPa"
nu = 0.22
[[initial]]
velocity = ["1 [m/s]*exp(-(x/(3 [mm]))^2)", 0]
[time]
steps = 20
[output]
{output}
"#
    );
    let scene = Scene::parse(&text, Path::new("block.toml"), &Pdlang);
    let scene = scene.unwrap_or_else(|e| panic!("{}", e.render(false)));
    scene
        .simulation()
        .unwrap_or_else(|e| panic!("{}", e.render(false)))
}

#[test]
fn what_a_scene_shows_is_kept() {
    let output = "every = 10\nfields = [\"sigma\", \"velocity\"]";
    let mut all = scene(output);
    all.run(&mut ()).expect("a run");
    let mut some = scene(output);
    some.keep_outputs();
    some.run(&mut ()).expect("a run");
    assert_eq!(all.state, some.state);
    assert_eq!(
        quantity(&mut all, "sigma.xy").expect("a quantity"),
        quantity(&mut some, "sigma.xy").expect("a quantity")
    );
    let why = quantity(&mut some, "H").expect_err("left out").to_string();
    assert!(why.contains("`H` was left out"), "{why}");
    let listed = inventory(&some);
    let item = listed.iter().find(|i| i.why.contains("`H`"));
    assert!(item.is_some_and(|i| !i.needed), "{listed:#?}");
    // Nothing is shown: all goes.
    let mut none = scene("");
    none.keep_outputs();
    none.run(&mut ()).expect("a run");
    assert_eq!(all.state, none.state);
    assert!(quantity(&mut none, "sigma").is_err());
}
