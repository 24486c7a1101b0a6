//! `pdlang run`: runs that stop and go on, and what they leave.

use super::{PLATE, bytes, checked, command, folder, mentions, pdlang, shown, write};
use std::path::Path;
use std::process::Command;

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
