//! Command lines and scenes that are wrong, and help.

use super::{PLATE, folder, mentions, pdlang, shown, write};

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
