//! `pdlang check`, `fmt`, `emit`, `explain`, `models` and `verify`.

use super::{PLATE, bytes, command, folder, mentions, pdlang, shown, write};
use std::path::Path;

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
fn explain_says_how_a_law_is_computed() {
    let says = [
        "lps in 3D",
        "theta: at every force evaluation",
        "breaks where",
        "force_x = ",
        "Kernels are compiled in 1D, 2D, 3D, and for small displacements in 1D, 2D, 3D.",
    ];
    mentions(&pdlang(&["explain", "lps"], 0), &says);
    let plane = ["explain", "heat", "--dim", "2", "--linearised"];
    mentions(
        &pdlang(&plane, 0),
        &[
            "heat in 2D",
            "a bond takes",
            "none of them for small displacements",
        ],
    );
    let refused = ["explain", "lamina", "--dim", "3"];
    mentions(&pdlang(&refused, 1), &["PD092"]);
    mentions(&pdlang(&["explain", "lpz"], 1), &["no law `lpz`"]);
    // The page as data says it too.
    let page = pdlang(&["models", "lps", "--json"], 0);
    let page: serde_json::Value = serde_json::from_str(&page).expect("an object");
    assert_eq!(page["kernels"], says[4]);
}

/// What closes the pipe has read enough.
#[test]
fn a_closed_pipe_is_no_panic() {
    use std::io::Read;
    let mut child = command(&["verify", "pmb", "--json"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command starts");
    drop(child.stdout.take());
    let mut words = String::new();
    let stderr = child.stderr.as_mut().expect("a pipe");
    stderr.read_to_string(&mut words).expect("text");
    assert!(child.wait().expect("it ends").success(), "{words}");
    assert!(!words.contains("panicked"), "{words}");
}

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
