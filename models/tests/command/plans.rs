//! `pdlang plan`, and what a scene may leave out.

use super::{PLATE, folder, mentions, pdlang, shown, write};

/// The lists of a plan, each entry what it is and why.
fn planned(scene: &str) -> [Vec<String>; 2] {
    let plan: serde_json::Value =
        serde_json::from_str(&pdlang(&["plan", scene, "--json"], 0)).expect("an object");
    assert!(plan["seconds"].as_f64().is_some_and(|s| s > 0.0), "{plan}");
    let steps = &plan["forecast"]["steps"];
    assert!(steps["count"].as_u64().is_some_and(|n| n > 0), "{plan}");
    ["needed", "left_out"].map(|key| {
        let list = plan[key].as_array().expect("a list").iter();
        list.filter_map(|item| Some(item.as_str()?.to_string()))
            .collect()
    })
}

/// Two laws are compiled for small displacements, others run interpreted; what is not linear is refused.
#[test]
fn a_scene_may_ask_for_small_displacements() {
    let dir = folder("linearised");
    let scene = |model: &str| {
        let plate = PLATE.replace("\"lps\"", &format!("{model:?}\nlinearised = true"));
        write(
            dir.join(format!("{model}.toml")),
            &format!("{plate}[time]\nsteps = 5\n"),
        )
    };
    let out = dir.join("out");
    for (model, compiled) in [("lps", true), ("lps_frozen", false)] {
        let scene = scene(model);
        let text = pdlang(&["run", &scene, "--out", &shown(&out)], 0);
        assert!(text.contains(", linearised\n"), "{text}");
        assert_eq!(
            text.contains("include_model!(linearised"),
            !compiled,
            "{text}"
        );
        let summary = std::fs::read_to_string(out.join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
        assert_eq!(summary["linearised"], true);
        assert_eq!(summary["compiled"], compiled);
        let [computed, out] = planned(&scene);
        let kinematics = |i: &String| i.starts_with("general kinematics: the law is linearised");
        assert!(out.iter().any(kinematics), "{computed:#?} {out:#?}");
    }
    let text = pdlang(&["run", &scene("lps_plastic")], 1);
    assert!(
        text.contains("its history `ep` remembers displacements"),
        "{text}"
    );
    let passes = |more: &[&str]| pdlang(&[&["emit", "pmb", "--stage", "passes"], more].concat(), 0);
    assert!(passes(&[]).contains("rsqrt"));
    assert!(!passes(&["--linearised"]).contains("rsqrt"));
}

#[test]
fn a_plan_says_what_is_computed_and_what_not() {
    let dir = folder("planned");
    let time = "[time]\nsteps = 40\n";
    let breaking = write(dir.join("breaking.toml"), &format!("{PLATE}{time}"));
    let whole = PLATE.replace("s0 = 3e-4\n", "") + "pictures = \"ends\"\n" + time;
    let whole = whole.replace(
        "horizon = \"3 dx\"",
        "horizon = \"3 dx\"\ntraversal = \"cloud\"",
    );
    let whole = write(dir.join("whole.toml"), &format!("{whole}sleep = false\n"));
    let has = |list: &[String], start: &str| {
        assert!(
            list.iter().any(|i| i.starts_with(start)),
            "{start}: {list:#?}"
        );
    };
    let [computed, out] = planned(&breaking);
    for start in [
        "motion: ",
        "general kinematics: ",
        "breaking: `",
        "sums over families: ",
        "stable step: at the start, and",
        "values of the other end: ",
        "field files: ",
    ] {
        has(&computed, start);
    }
    for start in [
        "neighbour lists: a neighbour is a step",
        "field rates: the law has no field",
        "history: ",
        "contact: there are no spheres",
        "volume correction: ",
        "surface correction: ",
        "nodes at rest: left out until",
        "strain energy: between the rows",
        "pictures: ",
        "results that nothing else reads: each of",
    ] {
        has(&out, start);
    }
    let [computed, out] = planned(&whole);
    has(&out, "breaking: with these parameters");
    has(&out, "sums over families: ");
    let lists = computed.iter().find(|i| i.starts_with("neighbour lists: "));
    let runs = lists.and_then(|i| i.split_once(" bytes a bond: "));
    let (bytes, runs) = runs.expect("a cloud has lists");
    // Half a byte where rows are runs, four and more where they are lists.
    let bytes: f64 = bytes["neighbour lists: ".len()..]
        .parse()
        .expect("a number");
    assert!((0.5..6.0).contains(&bytes), "{bytes}");
    assert!(
        runs.ends_with(" % of the chunks lead to eight nodes side by side"),
        "{runs}"
    );
    has(&computed, "nodes at rest: the scene");
    has(&computed, "pictures: ");
    assert!(!dir.join("out").exists(), "a plan leaves no files");
    // Three columns of twenty.
    let held = "[[no_fail]]\nregion = { box = { from = [0, 0], to = [\"3 mm\", \"20 mm\"] } }\n";
    let held = write(dir.join("held.toml"), &format!("{PLATE}{held}{time}"));
    let [computed, _] = planned(&held);
    let holds = |i: &String| i.ends_with("; bonds with an end in one of 60 nodes hold");
    assert!(computed.iter().any(holds), "{computed:#?}");
}

/// A plan says where a convolution is faster, and what it does where it is chosen.
#[test]
fn a_plan_knows_convolutions() {
    let dir = folder("convolved");
    let scene = |name: &str, family: &str, material: &str| {
        let text = format!(
            "[body]\nflavour = \"plane_strain\"\nspacing = \"1 mm\"\nthickness = \"1 mm\"\n\
             shape = {{ box = {{ from = [0, 0], to = [\"150 mm\", \"100 mm\"] }} }}\n\
             [family]\nhorizon = \"30 dx\"\n{family}\n\
             [material]\nmodel = \"pmb\"\nlinearised = true\ndensity = 2200\nK = \"14.9 GPa\"\n{material}\n\
             [time]\nsteps = 5\ndt = \"10 ns\"\n"
        );
        write(dir.join(name), &text)
    };
    let told = |path: &str| pdlang(&["plan", path], 0);
    let direct = told(&scene("direct.toml", "", ""));
    mentions(
        &direct,
        &[
            "lattice traversal",
            "  faster     a convolution takes 0.",
            "[family]",
        ],
    );
    let chosen = told(&scene("chosen.toml", "traversal = \"convolution\"", ""));
    mentions(
        &chosen,
        &[
            "convolution traversal",
            "loops over bonds: `force` sums by convolution, 4 transforms of",
            "nodes at rest: a convolution has all nodes at once",
        ],
    );
    assert!(!chosen.contains("faster"), "{chosen}");
    let breaking = told(&scene("breaking.toml", "", "s0 = 0.5"));
    assert!(!breaking.contains("faster"), "{breaking}");
}

/// Heat beside waves: in the time of some hundred steps of the motion it does not leave its node.
#[test]
fn a_field_that_has_no_time_to_change_is_said_so() {
    let dir = folder("still-field");
    let scene = |k: &str, steps: u64| {
        let material = format!(
            "model = \"thermo_pmb\"\ndensity = \"2440 kg/m^3\"\nK = \"43 GPa\"\nalpha = 1e-5\nk = \"{k}\"\ncv = 800\n"
        );
        let body = "[body]\nflavour = \"bar\"\nspacing = \"1 mm\"\ncross_section = \"1 mm^2\"\nshape = { box = { from = [0], to = [\"20 mm\"] } }\n[family]\nhorizon = \"3 dx\"\n[material]\n";
        format!("title = \"Bar\"\n{body}{material}[time]\nsteps = {steps}\n")
    };
    let slow = write(dir.join("slow.toml"), &scene("1 W/(m K)", 100));
    mentions(
        &pdlang(&["plan", &slow], 0),
        &["hardly change in this run", "`heat`"],
    );
    let quick = write(dir.join("quick.toml"), &scene("1e9 W/(m K)", 100));
    let text = pdlang(&["plan", &quick], 0);
    assert!(!text.contains("hardly change"), "{text}");
}
