//! Checks files of laws: `cargo run -p pdlang --example check -- FILE.pd..`
fn main() {
    for path in std::env::args().skip(1) {
        match std::fs::read_to_string(&path) {
            Ok(text) => show(&path, &text),
            Err(error) => println!("{path}: {error}"),
        }
    }
}

fn show(path: &str, text: &str) {
    let checked = pdlang::front::file(text);
    for finding in &checked.diagnostics {
        println!("{}\n", finding.render(text, path, false));
    }
    for law in &checked.laws {
        println!("{path}: {} ({} definitions)", law.name, law.defs.len());
        for def in &law.defs {
            println!(
                "  {:?} {} : {:?} [{}]",
                def.home,
                def.name,
                def.shape,
                def.unit.describe(&["omega".to_string()])
            );
        }
    }
}
