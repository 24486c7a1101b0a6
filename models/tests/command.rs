//! The `pdlang` command from outside: files, messages, exit codes. It stands here and not in `tests`, because Cargo
//! hands a binary to the tests of its own package only.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A plate with a crack that grows, so that bonds break and the step is found again.
const PLATE: &str = r#"
title = "Plate"
[body]
flavour = "plane_stress"
spacing = "1 mm"
thickness = "1 mm"
shape = { box = { from = [0, 0], to = ["30 mm", "20 mm"] } }
[family]
horizon = "3 dx"
[material]
model = "lps"
density = "2440 kg/m^3"
K = "43 GPa"
G = "30 GPa"
s0 = 3e-4
[[crack]]
segment = { from = ["-1 mm", "10 mm"], to = ["12 mm", "10 mm"] }
[[initial]]
velocity = [0, "(y - 10 mm)/(5 ms)"]
[output]
history = 7
fields = ["displacement", "velocity", "damage"]
every = 40
"#;

/// A folder of its own for a test, empty.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("a folder for the test");
    path
}

fn write(path: PathBuf, text: &str) -> String {
    std::fs::write(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    shown(&path)
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

fn bytes(path: impl AsRef<Path>) -> Vec<u8> {
    let path = path.as_ref();
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pdlang"));
    command.args(arguments);
    command
}

/// Runs the command, which must end with this exit code and without a panic; what it printed.
fn pdlang(arguments: &[&str], code: i32) -> String {
    let output = command(arguments).output().expect("the command starts");
    checked(&output, code, arguments)
}

fn checked(output: &Output, code: i32, arguments: &[&str]) -> String {
    let text = [&output.stdout, &output.stderr].map(|s| String::from_utf8_lossy(s));
    let text = text.concat();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{text}");
    assert!(!text.contains("panicked"), "{arguments:?}\n{text}");
    text
}

fn mentions(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "no `{word}` in:\n{text}");
    }
}

/// The same history, series, last fields and last checkpoint.
fn same_results(one: &Path, two: &Path, step: u64) {
    let last = [
        "history.csv".to_string(),
        "fields.pvd".to_string(),
        format!("fields/fields-{step:09}.vtu"),
        format!("checkpoints/step-{step:09}.ckpt"),
    ];
    for file in last {
        assert!(
            bytes(one.join(&file)) == bytes(two.join(&file)),
            "{file} differs"
        );
    }
}

#[test]
fn a_resumed_run_on_one_thread_has_the_bits_of_a_whole_run_on_two() {
    let dir = folder("resumed");
    let scene = |steps: u64| format!("{PLATE}checkpoint = 50\n[time]\nsteps = {steps}\n");
    let whole = write(dir.join("whole.toml"), &scene(300));
    let part = write(dir.join("part.toml"), &scene(60));
    let (one, two) = (dir.join("one"), dir.join("two"));
    pdlang(&["run", &whole, "--out", &shown(&one), "--threads", "2"], 0);
    // A run that ended early has rows and fields beyond the checkpoint: those are written anew.
    let out = shown(&two);
    pdlang(&["run", &part, "--out", &out, "--threads", "1"], 0);
    let from = shown(&two.join("checkpoints/step-000000050.ckpt"));
    let text = pdlang(
        &[
            "run",
            &whole,
            "--out",
            &out,
            "--threads",
            "1",
            "--resume",
            &from,
        ],
        0,
    );
    mentions(&text, &["done", "broken"]);
    assert!(
        !text.contains(" 0 bonds (0.0000 %)"),
        "nothing broke:\n{text}"
    );
    same_results(&one, &two, 300);
}

#[test]
fn a_run_to_an_end_in_time_ends_there_though_its_step_shrinks() {
    let dir = folder("end");
    let scene = write(
        dir.join("scene.toml"),
        &format!("{PLATE}[time]\nuntil = \"30 us\"\n"),
    );
    let out = dir.join("out");
    pdlang(&["run", &scene, "--out", &shown(&out)], 0);
    let summary: serde_json::Value =
        serde_json::from_slice(&bytes(out.join("summary.json"))).expect("JSON");
    let number = |key: &str| summary[key].as_f64().expect("a number");
    // All steps at the last length would not reach as far.
    assert!(
        number("steps") * number("dt") < 0.999 * number("time"),
        "{summary:#}"
    );
    assert!((number("time") - 30e-6).abs() < 1e-9 * 30e-6, "{summary:#}");
}

#[test]
fn a_checkpoint_that_does_not_fit_is_refused() {
    let dir = folder("refused");
    let text = format!("{PLATE}checkpoint = \"ends\"\n[time]\nsteps = 4\n");
    let scene = write(dir.join("scene.toml"), &text);
    let other = write(
        dir.join("other.toml"),
        &text.replace("\"43 GPa\"", "\"44 GPa\""),
    );
    let out = shown(&dir.join("out"));
    pdlang(&["run", &scene, "--out", &out], 0);
    let good = dir.join("out/checkpoints/step-000000004.ckpt");
    let whole = bytes(&good);
    let resume = |scene: &str, name: &str, content: &[u8]| {
        let path = dir.join(name);
        std::fs::write(&path, content).expect("a checkpoint");
        let text = pdlang(&["run", scene, "--out", &out, "--resume", &shown(&path)], 1);
        mentions(&text, &["error: ", name, "help: "]);
        text
    };
    mentions(
        &resume(&other, "other.ckpt", &whole),
        &["belongs to another scene", "resume with the scene"],
    );
    for length in [0, 20, 60, whole.len() / 2, whole.len() - 1] {
        let text = resume(&scene, "short.ckpt", &whole[..length]);
        assert!(text.contains("not a checkpoint") || text.contains("damaged"));
    }
    for place in [9, 30, 50, whole.len() / 2, whole.len() - 1] {
        let mut flipped = whole.clone();
        flipped[place] ^= 4;
        let text = resume(&scene, "flipped.ckpt", &flipped);
        assert!(
            text.contains("damaged") || text.contains("format"),
            "{text}"
        );
    }
    resume(&scene, "text.ckpt", text.as_bytes());
    let missing = shown(&dir.join("none.ckpt"));
    mentions(
        &pdlang(&["run", &scene, "--out", &out, "--resume", &missing], 1),
        &["cannot read", "none.ckpt"],
    );
    // What was refused has not touched the results.
    assert_eq!(bytes(&good), whole);
    pdlang(
        &["run", &scene, "--out", &out, "--resume", &shown(&good)],
        0,
    );
}

#[test]
fn an_unstable_run_keeps_what_it_has() {
    let dir = folder("unstable");
    let scene = write(
        dir.join("scene.toml"),
        &format!("{PLATE}checkpoint = 2\npictures = 1\n[time]\ndt = \"1 us\"\nsteps = 500\n")
            .replace("history = 7", "history = 1")
            .replace("every = 40", "every = 1"),
    );
    let out = dir.join("out");
    let text = pdlang(&["run", &scene, "--out", &shown(&out)], 3);
    mentions(
        &text,
        &["stopped at step", "node ", "last checkpoint: ", ".ckpt"],
    );
    let history = String::from_utf8(bytes(out.join("history.csv"))).expect("text");
    assert!(history.lines().count() > 2, "{history}");
    let files = |folder: &str| {
        let entries = std::fs::read_dir(out.join(folder)).expect("a folder of results");
        entries.count()
    };
    assert!(files("fields") > 1 && files("pictures") > 1 && files("checkpoints") > 1);
    mentions(
        &String::from_utf8_lossy(&bytes(out.join("summary.json"))),
        &["stopped at step"],
    );
    mentions(
        &String::from_utf8_lossy(&bytes(out.join("fields.pvd"))),
        &["</VTKFile>"],
    );
}

#[test]
fn a_wrong_command_line_is_two() {
    let lines: [&[&str]; 13] = [
        &[],
        &["fly"],
        &["run"],
        &["run", "a.toml", "b.toml"],
        &["run", "a.toml", "--threads", "0"],
        &["run", "a.toml", "--thread", "2"],
        &["check"],
        &["models", "--yaml"],
        &["bench"],
        &["bench", "kernels", "--size", "0"],
        &["bench", "kernels", "--isa", "mmx"],
        &["bench", "scenes", "--steps", "0"],
        &["bench", "growth", "--nodes", "10"],
    ];
    for line in lines {
        mentions(&pdlang(line, 2), &["--help"]);
    }
}

#[test]
fn a_wrong_scene_is_one_with_its_place() {
    let dir = folder("wrong");
    let scene = write(
        dir.join("scene.toml"),
        &format!("{PLATE}[time]\nsteps = 4\n").replace("horizon = ", "horizont = "),
    );
    for name in ["run", "plan"] {
        let place = format!("{scene}:9:1");
        mentions(
            &pdlang(&[name, &scene], 1),
            &["unknown key `horizont`", "did you mean `horizon`?", &place],
        );
    }
    let missing = shown(&dir.join("none.toml"));
    mentions(&pdlang(&["run", &missing], 1), &["cannot read", &missing]);
    mentions(&pdlang(&["models", "pbm"], 1), &["pmb"]);
}

#[test]
fn every_command_has_help() {
    let text = pdlang(&["--help"], 0);
    let list = text
        .split("Commands:\n")
        .nth(1)
        .expect("a list of commands");
    let names: Vec<&str> = list
        .lines()
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(
        ["run", "plan", "check", "models", "bench"]
            .iter()
            .all(|n| names.contains(n)),
        "{text}"
    );
    for name in names {
        mentions(&pdlang(&[name, "--help"], 0), &["Usage: pdlang", name]);
    }
    mentions(&pdlang(&["--version"], 0), &[env!("CARGO_PKG_VERSION")]);
}

#[test]
fn check_accepts_a_law_and_shows_what_is_wrong_with_another() {
    let dir = folder("check");
    let good = shown(&Path::new(env!("CARGO_MANIFEST_DIR")).join("laws/lps.pd"));
    mentions(&pdlang(&["check", &good], 0), &["lps.pd: ok (law lps)"]);
    let text = String::from_utf8(bytes(&good)).expect("text");
    let bad = write(
        dir.join("bad.pd"),
        &text
            .replace("theta", "thetta")
            .replacen("thetta", "theta", 1),
    );
    mentions(
        &pdlang(&["check", "--explain", "PD012"], 0),
        &["PD012: units that differ", "let c = delta + 1 mm"],
    );
    mentions(
        &pdlang(&["check", "--explain", "PD9"], 1),
        &["there is no code `PD9`", "PD105"],
    );
    let text = pdlang(&["check", &good, &bad], 1);
    mentions(
        &text,
        &[
            "lps.pd: ok",
            "`thetta` is not defined",
            "did you mean `theta`?",
            "bad.pd:",
            "1 of 2 files wrong",
        ],
    );
    mentions(
        &pdlang(&["check", &shown(&dir.join("none.pd"))], 1),
        &["cannot read"],
    );
}

/// Ctrl-C: a checkpoint, the outputs so far and a way to go on.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_to_the_same_bits() {
    use std::io::{BufRead, BufReader, Read};
    use std::process::Stdio;

    let dir = folder("interrupted");
    write(
        dir.join("scene.toml"),
        &format!("{PLATE}checkpoint = \"ends\"\n[time]\nsteps = 6000\n")
            .replace("every = 40", "every = 600"),
    );
    let (one, two) = (dir.join("one"), dir.join("two"));
    // Relative names, so that the message below has no name with a space in it.
    let here = |arguments: &[&str]| {
        let mut command = command(arguments);
        command.current_dir(&dir);
        command
    };
    let complete = |arguments: &[&str]| {
        let output = here(arguments).output().expect("the command starts");
        checked(&output, 0, arguments);
    };
    complete(&["run", "scene.toml", "--out", "one"]);
    let mut child = here(&["run", "scene.toml", "--out", "two"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut stderr = BufReader::new(child.stderr.take().expect("a pipe"));
    // The first word of progress comes after a tenth of the run.
    let mut text = String::new();
    stderr.read_line(&mut text).expect("progress");
    mentions(&text, &["step "]);
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    stderr.read_to_string(&mut text).expect("text");
    assert_eq!(child.wait().expect("an end").code(), Some(130), "{text}");
    mentions(
        &text,
        &["interrupted after step ", "pdlang run ", "--resume "],
    );
    mentions(
        &String::from_utf8_lossy(&bytes(two.join("summary.json"))),
        &["interrupted"],
    );
    let rows = |dir: &Path| {
        String::from_utf8_lossy(&bytes(dir.join("history.csv")))
            .lines()
            .count()
    };
    let (whole, part) = (rows(&one), rows(&two));
    assert!(10 < part && part < whole, "{part} rows of {whole}");

    // The message is a command line; that is what the user pastes.
    let line = text
        .split('`')
        .nth(1)
        .expect("a command between backquotes");
    let arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
    complete(&arguments);
    same_results(&one, &two, 6000);
}

#[test]
fn laws_are_formatted_printed_and_probed() {
    let folder = folder("laws");
    let spring = "model m \"M\" cite \"A, eq. 1\" { param K:pressure \"K\"\nenergy W=K*sum(s^2)/sum0(1)  # W\n}";
    let law = write(folder.join("m.pd"), spring);
    assert!(pdlang(&["fmt", "--check", &law], 1).contains("not in canonical form"));
    pdlang(&["fmt", &law], 0);
    pdlang(&["fmt", "--check", &law], 0);
    assert!(pdlang(&["check", &law], 0).contains("PD103"));
    for (stage, part) in [
        ("ast", "energy W = ((K*sum((s^2)))/sum0(1))"),
        ("ir", "energy = ((K*sum((s^2)))/sum0(1))"),
        ("passes", "sweep"),
        ("rust", "impl Sweep"),
        ("latex", "\\section*{M}"),
        ("markdown", "# M"),
    ] {
        assert!(
            pdlang(&["emit", &law, "--stage", stage], 0).contains(part),
            "{stage}"
        );
    }
    assert!(pdlang(&["emit", "pbm", "--stage", "ir"], 1).contains("there is no law `pbm`"));

    let probe = "probe p in bar where K = 1 Pa, delta = 1 m {
        node a = 0, V = 1 m^3 node b = 1 m, V = 1 m^3, u = 1 m expect W(a) = 2 Pa } }";
    let wrong = write(
        folder.join("wrong.pd"),
        &(spring.trim_end_matches('}').to_string() + probe),
    );
    assert!(pdlang(&["check", &wrong], 1).contains("fails: `W(a)` is 1 Pa"));

    let uses = write(
        folder.join("uses.pd"),
        &format!("use \"shared.pd\" {}", spring.replace("s^2", "square(s)")),
    );
    assert!(pdlang(&["check", &uses], 1).contains("cannot use `shared.pd`"));
    write(folder.join("shared.pd"), "fn square(a) = a^2");
    pdlang(&["check", &uses], 0);
}

/// A law from a file runs at once; the program says once that it is interpreted, and how to compile it.
#[test]
fn a_law_that_is_not_compiled_says_so() {
    let dir = folder("uncompiled");
    let lps = Path::new(env!("CARGO_MANIFEST_DIR")).join("laws/lps.pd");
    std::fs::copy(&lps, dir.join("my.pd")).expect("a copy of the law");
    let scene = |model: &str| {
        let plate = PLATE.replace("\"lps\"", &format!("{model:?}"));
        format!("{plate}[time]\nsteps = 5\n")
    };
    let mine = write(dir.join("mine.toml"), &scene("my.pd"));
    let theirs = write(dir.join("theirs.toml"), &scene("lps"));
    let out = shown(&dir.join("out"));
    for (scene, interpreted) in [(&mine, 1), (&theirs, 0)] {
        for text in [
            pdlang(&["run", scene, "--out", &out], 0),
            pdlang(&["plan", scene], 0),
        ] {
            for words in [", interpreted", "to compile", "include_model!"] {
                assert_eq!(text.matches(words).count(), interpreted, "{words}: {text}");
            }
        }
    }
}

/// Rows of `pdlang bench kernels` on a small cube.
fn kernels(more: &[&str]) -> Vec<serde_json::Value> {
    let line = [
        &[
            "bench",
            "kernels",
            "--size",
            "7",
            "--repeats",
            "2",
            "--json",
        ],
        more,
    ]
    .concat();
    serde_json::from_str(&pdlang(&line, 0)).expect("an array")
}

#[test]
fn kernels_are_timed_beside_their_twins() {
    let rows = kernels(&[]);
    let named: Vec<String> = rows
        .iter()
        .map(|row| format!("{} {} {}", row["law"], row["body"], row["traversal"]).replace('"', ""))
        .collect();
    let bodies = ["lattice lattice", "cloud cloud", "jittered cloud"];
    let laws = [
        "pmb",
        "pmb linearised",
        "lps",
        "lps linearised",
        "heat",
        "correspondence_stabilised",
    ];
    let all = laws.map(|law| bodies.map(|body| format!("{law} {body}")));
    assert_eq!(named, all.concat());
    for row in &rows {
        let number = |key: &str| row[key].as_f64();
        for key in ["ns_per_bond", "wall_ns_per_bond", "bytes_per_bond"] {
            assert!(number(key).is_some_and(|n| n > 0.0), "{key} of {row}");
        }
        assert_eq!(
            (&row["dimension"], &row["precision"]),
            (&3.into(), &"f64".into())
        );
        assert_eq!(row["threads"], 1);
        let linearised = row["law"]
            .as_str()
            .is_some_and(|l| l.ends_with("linearised"));
        let twin = row["isa"] == "avx512" && !linearised;
        assert_eq!(
            number("twin_ns_per_bond").is_some_and(|n| n > 0.0),
            twin,
            "{row}"
        );
        assert_eq!(row["twin_ns_per_bond"].is_null(), !twin, "{row}");
    }
    // Twins are for one thread and for one instruction set.
    for more in [["--threads", "2"], ["--isa", "scalar"]] {
        assert!(
            kernels(&more)
                .iter()
                .all(|row| row["twin_ns_per_bond"].is_null())
        );
    }
    let table = pdlang(&["bench", "kernels", "--size", "5", "--repeats", "1"], 0);
    mentions(
        &table,
        &["twin_ns_per_bond", "correspondence_stabilised", "jittered"],
    );
}

#[test]
fn scenes_are_timed_with_and_without_what_they_may_leave_out() {
    let line = [
        "bench",
        "scenes",
        "--size",
        "6",
        "--steps",
        "2",
        "--repeats",
        "1",
    ];
    let rows: Vec<serde_json::Value> =
        serde_json::from_str(&pdlang(&[&line[..], &["--json"]].concat(), 0)).expect("an array");
    let named: Vec<(&str, &str)> = rows
        .iter()
        .filter_map(|row| Some((row["what"].as_str()?, row["law"].as_str()?)))
        .collect();
    let both = [
        "breaking, with masks",
        "neighbour lists",
        "general kinematics",
        "general kinematics of a cloud",
        "nodes at rest",
        "energy at every step",
        "volume correction",
        "contact",
        "interpreter",
        "a second material",
        "eight horizons",
    ];
    let expected: Vec<(&str, &str)> = ["pmb", "lps"]
        .iter()
        .flat_map(|law| both.iter().map(move |what| (*what, *law)))
        .chain([
            ("heat", "thermo_pmb"),
            ("heat", "thermo_lps"),
            ("history", "lps_viscoelastic"),
            ("history", "lps_plastic"),
            ("surface correction", "solid"),
        ])
        .collect();
    assert_eq!(named, expected);
    for row in &rows {
        for key in ["nodes", "with_ns_per_bond", "without_ns_per_bond", "ratio"] {
            let number = row[key].as_f64();
            assert!(number.is_some_and(|n| n > 0.0), "{key} of {row}");
        }
    }
}

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
    has(&computed, "neighbour lists: 4 bytes");
    has(&computed, "nodes at rest: the scene");
    has(&computed, "pictures: ");
    assert!(!dir.join("out").exists(), "a plan leaves no files");
}

#[test]
fn growth_is_timed_and_drawn() {
    let plot = shown(&folder("growth").join("growth.svg"));
    let line = "bench growth --nodes 1000 --seconds 0 --json --plot";
    let words: Vec<&str> = line.split(' ').chain([plot.as_str()]).collect();
    let rows: Vec<serde_json::Value> = serde_json::from_str(&pdlang(&words, 0)).expect("an array");
    for row in &rows {
        for key in ["nodes", "bonds", "ns_per_bond", "to_median"] {
            assert!(row[key].as_f64().is_some_and(|n| n > 0.0), "{key} of {row}");
        }
    }
    let cube = |row: &&serde_json::Value| {
        row["law"] == "lps" && row["case"] == "cube" && row["nodes"] == 1000
    };
    let horizons: Vec<f64> = rows
        .iter()
        .filter(cube)
        .filter_map(|row| row["horizon_dx"].as_f64())
        .collect();
    assert_eq!(horizons, [3.015, 1.5, 2.0, 3.015, 4.0, 5.0, 6.0, 8.0]);
    let bonds = |case: &str| {
        let row = rows.iter().find(|row| row["case"] == case);
        row.and_then(|row| row["bonds"].as_u64())
    };
    assert!(bonds("ball") > bonds("rod") && bonds("rod") > bonds("sheet"));
    mentions(
        &String::from_utf8_lossy(&bytes(&plot)),
        &["<svg", "ns per directed bond", "lps, jittered"],
    );
    let wrong = ["bench", "growth", "--seconds", "nan"];
    mentions(&pdlang(&wrong, 1), &["--seconds"]);
}

/// The law that a stranger wrote: 9 for 15 in three dimensions.
const WRONG: &str = r#"
model wrong "Linear peridynamic solid with a misprint"
  cite "Silling et al. 2007, J. Elasticity 88, eq. 104"
{
  influence omega = 1/x
  param K : pressure > 0  "bulk modulus"
  param G : pressure > 0  "shear modulus"
  node m     = sum(omega*x^2)
  node theta = dim/m*sum(omega*x*e)
  bond ed    = e - theta*x/dim
  energy W   = K_d(K, G)*theta^2/2 + dim^2*G/(2*m)*sum(omega*ed^2)
}"#;

#[test]
fn verify_passes_the_catalogue_and_says_what_is_wrong_with_a_file() {
    let line = ["verify", "pmb", "--param", "K = 3 GPa", "--horizon", "2 mm"];
    mentions(
        &pdlang(&line, 0),
        &["pmb: ", " 0 fail", "linear_momentum    pass"],
    );

    let file = write(folder("verify").join("wrong.pd"), WRONG);
    let says = ["term 2 of `energy W` (line 11) times 5/3", "error: wrong: "];
    mentions(&pdlang(&["verify", &file], 1), &says);

    let json = command(&["verify", &file, "--json"])
        .output()
        .expect("the command starts");
    assert_eq!(json.status.code(), Some(1));
    let page: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    let verdicts = page[0]["verdicts"].as_array().expect("verdicts");
    let of = |v: &&serde_json::Value| {
        v["check"] == "constants" && v["flavour"] == "3d" && v["quantity"] == "G"
    };
    let shear = verdicts.iter().find(of).expect("a shear modulus");
    assert_eq!(
        (shear["level"].as_str(), shear["line"].as_u64()),
        (Some("fail"), Some(11))
    );
    let ratio = shear["measured"].as_f64().unwrap() / shear["expected"].as_f64().unwrap();
    assert!((ratio - 0.6).abs() < 1e-9, "{ratio}");
}

#[test]
fn verify_refuses_what_does_not_fit_the_law() {
    for (arguments, says) in [
        (&["verify", "nothing"][..], "there is no law `nothing`"),
        (&["verify", "pmb", "--param", "Q=1"], "has no parameter `Q`"),
        (&["verify", "pmb", "--param", "K"], "sets nothing"),
        (
            &["verify", "pmb", "--param", "K=-1"],
            "outside of the bounds",
        ),
        (&["verify", "pmb", "--param", "K=big"], "is no number"),
        (&["verify", "pmb", "--horizon", "0"], "a length above 0"),
        (&["verify", "gpmb", "--influence", "nope"], "nope"),
    ] {
        mentions(&pdlang(arguments, 1), &[says]);
    }
}
