//! Laws that use other files: from the disk, through the macro, and what is said when a file is not there.

use pdlang::{front, probe};
use pdlang_models::{files, language};
use std::path::Path;

mod compiled {
    pdlang_macros::include_model!("fixtures/use/shared.pd");
}

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/use"))
}

#[test]
fn a_law_of_three_files_is_pmb() {
    let law = language::find("shared.pd", folder()).unwrap_or_else(|e| panic!("{e:?}"));
    let outcomes = probe::run(&law);
    assert!(
        !outcomes.is_empty() && outcomes.iter().all(probe::Outcome::holds),
        "{outcomes:?}"
    );
    assert!(!compiled::shared::LAW.kernels.is_empty());
}

#[test]
fn findings_are_about_the_text_at_hand() {
    let text = "use \"elastic.pd\"\nuse \"none.pd\"\n";
    let path = folder().join("law.pd");
    let checked = front::file_in(text, &path.to_string_lossy(), &mut files::read);
    let [finding] = checked.diagnostics.as_slice() else {
        panic!("{:?}", checked.diagnostics)
    };
    let shown = finding.render(text, "law.pd", false);
    assert!(
        shown.contains("error[PD070]: cannot use `none.pd`") && shown.contains("law.pd:2:5"),
        "{shown}"
    );
}
