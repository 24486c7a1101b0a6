//! The `pdlang` command from outside: files, messages, exit codes. It stands here and not in `tests`, because Cargo
//! hands a binary to the tests of its own package only.

mod bench;
mod laws;
mod lsp;
mod plans;
mod runs;
mod waves;
mod words;

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
