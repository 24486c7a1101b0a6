//! Bad scenes and the messages they get. `fixtures/scene/<name>.toml` is read and built; what is shown must
//! be `fixtures/scene/<name>.txt`. `UPDATE_EXPECT=1` writes the messages anew: read them before committing.

use std::fs;
use std::path::{Path, PathBuf};

use pdlang_models::language::Pdlang;
use pdlang_runtime::scene::Scene;

fn fixtures() -> Vec<PathBuf> {
    let folder = fs::read_dir("fixtures/scene").expect("tests run in their package's folder");
    let mut paths: Vec<PathBuf> = folder.map(|e| e.expect("an entry").path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    paths
}

fn message(path: &Path) -> String {
    let problems = match Scene::read(path, &Pdlang) {
        Err(problems) => problems,
        Ok(scene) => match scene.simulation() {
            Err(problems) => problems,
            Ok(_) => panic!("{} is accepted", path.display()),
        },
    };
    without_this_machine(&format!("{}\n", problems.render(false)))
}

/// How much memory is available differs from machine to machine.
fn without_this_machine(text: &str) -> String {
    match text.find(" GB are available") {
        None => text.into(),
        Some(end) => {
            let start = text[..end].rfind(' ').map_or(0, |at| at + 1);
            format!("{}..{}", &text[..start], &text[end..])
        }
    }
}

#[test]
fn bad_scenes_get_their_messages() {
    let update = std::env::var_os("UPDATE_EXPECT").is_some();
    let mut wrong = Vec::new();
    for path in fixtures() {
        let expected = path.with_extension("txt");
        let shown = message(&path);
        if update {
            fs::write(&expected, &shown).expect("fixtures can be written");
        } else if fs::read_to_string(&expected).unwrap_or_default() != shown {
            wrong.push(format!("{}:\n{shown}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn there_are_enough_of_them() {
    assert!(fixtures().len() >= 20);
}

/// Every scene that ships is understood.
#[test]
fn shipped_scenes_are_understood() {
    for folder in ["scenes", "../examples"] {
        for entry in fs::read_dir(folder).expect("a folder of scenes") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|e| e == "toml")
                && let Err(problems) = Scene::read(&path, &Pdlang)
            {
                panic!("{problems}");
            }
        }
    }
}
