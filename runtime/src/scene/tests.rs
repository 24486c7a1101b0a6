//! Reading of whole scenes, with a language that knows one law and plain numbers.

use std::path::Path;

use super::{Nodes, Scene};
use crate::body::Flavour;
use crate::carve::Anchor;
use crate::engine::Law;
use crate::language::{
    Compiled, Complaint, Constant, Expected, Exponents, Language, LawError, Variable, dimension,
};
use crate::observe::Schedule;
use crate::shape::Shape;
use crate::simulate::{End, StepRule};
use crate::spec::{InfluenceFn, InfluenceSpec, Number, Op, ParamSpec, Spec, Tape};

/// Numbers in SI, names of variables, and `mm`.
struct Plain;

impl Language for Plain {
    fn expression(
        &self,
        text: &str,
        variables: &[Variable],
        expected: Expected,
    ) -> Result<Compiled, Vec<Complaint>> {
        let unit = if let Expected::Unit(unit) = expected {
            unit
        } else {
            dimension::NUMBER
        };
        let op = if let Some(k) = variables.iter().position(|v| v.name == text) {
            Op::Var(k as u32)
        } else if let Some(mm) = text.strip_suffix(" mm").and_then(|n| n.parse::<f64>().ok()) {
            Op::Lit(mm * 1e-3)
        } else if let Ok(n) = text.parse::<f64>() {
            Op::Lit(n)
        } else {
            let (message, label) = ("not understood".to_string(), "here".to_string());
            return Err(vec![Complaint {
                span: 0..text.len(),
                message,
                label,
                help: None,
            }]);
        };
        Ok(Compiled {
            tape: Tape {
                ops: vec![op],
                outs: vec![0],
            },
            unit,
        })
    }

    fn law(&self, name: &str, _: &Path, dim: usize) -> Result<Law, LawError> {
        match name {
            "spring" => Ok(Law::interpreted(spring(dim))),
            _ => Err(LawError {
                message: "no such law".into(),
                help: None,
                report: None,
            }),
        }
    }

    fn linearised(&self, name: &str, directory: &Path, dim: usize) -> Result<Law, LawError> {
        let mut law = self.law(name, directory, dim)?;
        law.spec.linearised = true;
        Ok(law)
    }

    fn influence(
        &self,
        text: &str,
        _: &[Constant],
    ) -> Result<(InfluenceFn, Vec<f64>), Vec<Complaint>> {
        Ok((constant(text), Vec::new()))
    }

    fn unit_name(&self, unit: Exponents) -> String {
        format!("{unit:?}")
    }
}

fn constant(name: &str) -> InfluenceFn {
    let body = Tape {
        ops: vec![Op::Lit(1.0)],
        outs: vec![0],
    };
    InfluenceFn {
        name: name.into(),
        params: Vec::new(),
        body,
    }
}

fn spring(dim: usize) -> Spec {
    let parameter = |name: &str, default| ParamSpec {
        name: name.into(),
        doc: String::new(),
        unit: String::new(),
        exponents: dimension::NUMBER,
        lower: Some((0.0, false)),
        upper: None,
        default,
        meet: Default::default(),
    };
    Spec {
        law: "spring".into(),
        title: String::new(),
        cites: Vec::new(),
        flavours: Vec::new(),
        dim,
        params: vec![
            parameter("c", None),
            parameter("s0", Some(Number::Infinite)),
        ],
        influences: vec![InfluenceSpec {
            name: "omega".into(),
            default: Some(constant("one")),
        }],
        families: Vec::new(),
        fields: Vec::new(),
        parts: vec![],
        histories: Vec::new(),
        weights: vec![],
        slots: Vec::new(),
        constants: Tape::default(),
        sweeps: Vec::new(),
        force: (0..dim as u32).collect(),
        tangent: Vec::new(),
        energy: None,
        rates: Vec::new(),
        after_step: Vec::new(),
        breaks: true,
        pairwise: true,
        linearised: false,
        named: Vec::new(),
    }
}

fn parse(text: &str) -> Result<Scene, String> {
    Scene::parse(text, Path::new("scene.toml"), &Plain).map_err(|p| p.to_string())
}

const SQUARE: &str = r#"
[let]
side = "10 mm"

[body]
flavour = "plane_stress"
spacing = "1 mm"
thickness = 0.001
anchor = [0, 0]
shape = { difference = [
    { box = { from = [0, 0], to = ["side", "side"] } },
    { disc = { center = [0.005, 0.005], radius = "2 mm" } },
] }

[family]
horizon = "3 dx"
partial_volume = true

[material]
model = "spring"
density = 1000
c = 5

[[crack]]
segment = { from = [0, 0.005], to = [0.002, 0.005] }

[[initial]]
displacement = ["x", "free"]

[time]
until = 0.001
safety = 0.5

[output]
every = 10
pictures = [0.0005]
"#;

#[test]
fn a_scene_is_understood() {
    let scene = parse(SQUARE).expect("a good scene");
    let Nodes::Carved(carve) = &scene.nodes else {
        panic!("a lattice")
    };
    assert_eq!((carve.flavour, carve.spacing), (Flavour::PlaneStress, 1e-3));
    assert_eq!(carve.anchor, Anchor::Node([0.0; 3]));
    let Shape::Difference(base, cuts) = &carve.shape else {
        panic!("a difference")
    };
    assert_eq!(
        **base,
        Shape::Box {
            from: [0.0, 0.0, f64::NEG_INFINITY],
            to: [0.01, 0.01, f64::INFINITY]
        }
    );
    assert_eq!(
        cuts[0],
        Shape::Sphere {
            center: [0.005, 0.005, 0.0],
            radius: 0.002
        }
    );
    assert_eq!(scene.family.horizon.constant(), Some(3e-3));
    assert_eq!(scene.material.params, [5.0, f64::INFINITY]);
    assert_eq!(scene.material.influences[0].function.name, "one");
    assert_eq!(
        (scene.end, scene.step),
        (End::Time(1e-3), StepRule::Stable { safety: 0.5 })
    );
    assert_eq!(scene.outputs.fields, Schedule::Steps(10));
    assert_eq!(scene.outputs.pictures, Schedule::Times(vec![0.0005]));
    assert_eq!(scene.outputs.views.len(), 1);
    let displacement = &scene.initial[0].value;
    assert_eq!(displacement[0].as_ref().expect("x").tape.ops, [Op::Var(0)]);
    assert_eq!(displacement[1], None);
    assert!(!scene.node_table);
}

#[test]
fn independent_problems_are_told_at_once() {
    let text = SQUARE
        .replace("thickness = 0.001", "thicknes = 0.001")
        .replace("horizon = \"3 dx\"", "horizon = \"0.5 dx\"")
        .replace("c = 5", "c = -5")
        .replace("safety = 0.5", "safety = 2");
    let shown = parse(&text).err().expect("a bad scene");
    assert_eq!(shown.matches("error: ").count(), 4, "{shown}");
    assert!(shown.contains("scene.toml:8:1"), "{shown}");
    assert!(shown.contains("did you mean `thickness`?"), "{shown}");
}

/// It is near to both of the keys that are missing, and can be one of them.
#[test]
fn a_misspelt_key_is_blamed_once() {
    let text = SQUARE
        .replace("spacing = \"1 mm\"\n", "")
        .replace("thickness = 0.001", "spackness = 0.001");
    let shown = parse(&text).err().expect("a bad scene");
    assert_eq!(
        shown.matches("unknown key `spackness`").count(),
        1,
        "{shown}"
    );
    let missing = ["[body] has no `spacing`", "[body] has no `thickness`"];
    let told = missing.iter().filter(|m| shown.contains(**m)).count();
    assert_eq!(told, 1, "{shown}");
}

#[test]
fn a_part_may_have_its_own_horizon() {
    let part = "[[material.part]]\nregion = { box = { from = [0, 0], to = [1, 1] } }\nhorizon = \"2 dx\"\n[time]";
    let scene = parse(&SQUARE.replace("[time]", part)).expect("a good scene");
    assert_eq!(scene.settings().horizon, [3e-3, 2e-3]);
    let scene = parse(&SQUARE.replace("[time]", &part.replace("horizon", "c"))).err();
    assert!(scene.is_some(), "a parameter is no length");
}

#[test]
fn a_box_can_be_taken_away_in_the_plane() {
    let disc = "{ disc = { center = [0.005, 0.005], radius = \"2 mm\" } }";
    let block = "{ box = { from = [0.0035, 0.0035], to = [0.0065, 0.0065] } }";
    assert!(SQUARE.contains(disc));
    let scene = parse(&SQUARE.replace(disc, block)).expect("a good scene");
    let setup = scene.setup().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(setup.body.x.len(), 11 * 11 - 3 * 3);
}

#[test]
fn zero_steps_ask_for_the_table_of_nodes() {
    let scene = parse(&SQUARE.replace("until = 0.001\nsafety = 0.5", "steps = 0")).expect("good");
    assert_eq!(scene.end, End::Steps(0));
    assert!(scene.node_table);
}

#[test]
fn no_prefix_of_a_scene_panics() {
    for end in (0..SQUARE.len()).filter(|&n| SQUARE.is_char_boundary(n)) {
        let _ = parse(&SQUARE[..end]);
    }
}

#[test]
fn no_wrong_type_panics() {
    for word in [
        "1",
        "-1.5",
        "\"é\"",
        "true",
        "[]",
        "{}",
        "[[1]]",
        "1979-05-27",
        "{ box = 1 }",
    ] {
        for line in SQUARE.lines().filter(|l| l.contains(" = ")) {
            let (key, _) = line.split_once(" = ").expect("a key");
            let _ = parse(&SQUARE.replace(line, &format!("{key} = {word}")));
        }
    }
}
