//! The doorway, seen from a crate that uses it: errors point at the tokens, and a changed file is built again.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Each `ui/*.rs` is a program that must not compile; the `.stderr` beside it is what rustc then prints.
/// `TRYBUILD=overwrite cargo test --test macros` writes them anew.
#[test]
fn errors_of_inline_laws_underline_their_tokens() {
    trybuild::TestCases::new().compile_fail("ui/*.rs");
}

/// A crate outside the workspace that includes `laws/spring.pd` and names its law.
struct Crate(PathBuf);

impl Crate {
    fn new() -> Crate {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("includes-a-law");
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        std::fs::create_dir_all(folder.join("laws")).unwrap();
        std::fs::create_dir_all(folder.join("src")).unwrap();
        let dependency =
            |name: &str, room: &str| format!("{name} = {{ path = {:?} }}\n", root.join(room));
        let manifest = "[package]\nname = \"includes-a-law\"\nedition = \"2024\"\n[workspace]\n[dependencies]\n".to_string()
            + &dependency("pdlang-macros", "macros")
            + &dependency("pdlang-runtime", "runtime");
        std::fs::write(folder.join("Cargo.toml"), manifest).unwrap();
        std::fs::copy(root.join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
        let program = "pdlang_macros::include_model!(\"laws/spring.pd\");\n\
                       pub static NAME: &str = spring::LAW.name;\n";
        std::fs::write(folder.join("src/lib.rs"), program).unwrap();
        Crate(folder)
    }

    fn law(&self, text: &str) {
        std::fs::write(self.0.join("laws/spring.pd"), text).unwrap();
    }

    /// `cargo check`, sharing what the crates under `ui` have already built.
    fn check(&self) -> Output {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../tests/trybuild");
        let mut cargo = Command::new(env!("CARGO"));
        cargo
            .args(["check", "--offline", "--quiet", "--color=never"])
            .current_dir(&self.0);
        cargo
            .env("CARGO_TARGET_DIR", target)
            .env_remove("RUSTFLAGS")
            .output()
            .unwrap()
    }

    /// What rustc says about the law as it stands.
    fn complaint(&self) -> String {
        let output = self.check();
        assert!(!output.status.success(), "a wrong law was accepted");
        String::from_utf8(output.stderr).unwrap()
    }

    fn accepts(&self) {
        let output = self.check();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

const SPRING: &str = "# Test law: a bond is a spring.
model spring \"Spring\"
  cite \"Silling 2000, eq. 63\"
{
  param c : [Pa/m^4] > 0 \"micromodulus\"
  energy W = c/4 * sum(x*s^2)
}
";

#[test]
fn a_changed_law_file_is_built_again_and_its_errors_show_its_lines() {
    let user = Crate::new();
    user.law(SPRING);
    user.accepts();

    user.law(&SPRING.replace("model spring", "model coil"));
    let complaint = user.complaint();
    assert!(complaint.contains("E0433"), "{complaint}");

    user.law(&SPRING.replace("x*s^2", "x*strech^2"));
    let complaint = user.complaint();
    assert!(complaint.contains("laws/spring.pd:6:"), "{complaint}");
    assert!(
        complaint.contains("energy W = c/4 * sum(x*strech^2)"),
        "{complaint}"
    );
    // The module is there all the same, so that nothing else in the program is wrong.
    assert!(!complaint.contains("E0433"), "{complaint}");

    user.law(SPRING);
    user.accepts();

    // A file that the law uses is watched as well.
    let shared = |text: &str| std::fs::write(user.0.join("laws/shared.pd"), text).unwrap();
    shared("fn quarter(a) = a/4\n");
    user.law(&format!(
        "use \"shared.pd\"\n{}",
        SPRING.replace("c/4", "quarter(c)")
    ));
    user.accepts();
    shared("fn quarter(a) = = a/4\n");
    let complaint = user.complaint();
    assert!(complaint.contains("laws/shared.pd:1:17"), "{complaint}");
    shared("fn quarter(a) = a/4\n");
    user.accepts();
}
