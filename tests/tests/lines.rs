//! How long laws are: lines that say something, without title, papers, what is known, braces, comments, probes and blank lines.

use pdlang_models::registry::CATALOGUE;

fn lines(text: &str) -> usize {
    let (mut count, mut depth_of_probe) = (0, 0_i32);
    for line in text.lines() {
        let said = line.split('#').next().unwrap_or_default().trim();
        if depth_of_probe > 0 || said.starts_with("probe ") {
            depth_of_probe += said.matches('{').count() as i32 - said.matches('}').count() as i32;
            continue;
        }
        let metadata = ["model ", "cite ", "for ", "known "]
            .iter()
            .any(|word| said.starts_with(word));
        count += usize::from(!said.is_empty() && !metadata && said != "{" && said != "}");
    }
    count
}

#[test]
fn laws_are_short() {
    let found: Vec<(&str, usize)> = CATALOGUE.iter().map(|e| (e.name, lines(e.text))).collect();
    println!("{found:?}");
    for (name, most) in [
        ("pmb", 12),
        ("lps", 20),
        ("correspondence", 25),
        ("heat", 10),
    ] {
        let (_, n) = found
            .iter()
            .find(|(law, _)| *law == name)
            .expect("a law of the catalogue");
        assert!(*n <= most, "`{name}` has {n} lines, {most} are enough");
    }
    // What docs/language.md says of the shortest and the longest.
    let page = include_str!("../../docs/language.md");
    for (name, n) in &found {
        let said = format!("`{name}` {n}");
        assert!(page.contains(&said), "docs/language.md does not say {said}");
    }
}
