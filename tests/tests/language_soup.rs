//! Whatever the text, the language answers with findings: it never panics, never runs out of stack and
//! never runs for long. Texts are made by a generator with a fixed seed, so that a failure repeats.

use pdlang::front;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// xorshift64*, Vigna 2016: enough to make nonsense.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() >> 33) as usize) % n.max(1)
    }

    fn pick<T: Clone>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())].clone()
    }
}

/// Reads a text and renders all that is said about it.
fn survive(text: &str) {
    let checked = front::file(text);
    for finding in &checked.diagnostics {
        assert!(
            !finding.labels.iter().any(|(span, _)| span.prelude),
            "points into the prelude: {finding:?}\n{text}"
        );
        assert!(!finding.render(text, "soup.pd", false).is_empty());
    }
    let errors = checked.has_errors();
    assert!(
        errors || !checked.laws.is_empty() || !text.starts_with("model"),
        "neither law nor error:\n{text}"
    );
}

fn laws() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = [
        "../models/laws",
        "fixtures/laws",
        "fixtures/lang/pass",
        "fixtures/lang/fail",
    ];
    let paths = folders
        .iter()
        .flat_map(|folder| fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|extension| extension == "pd"))
        .collect();
    paths.sort();
    paths
        .iter()
        .map(|path| fs::read_to_string(path).unwrap())
        .collect()
}

/// Splits where a token could end; a text is the concatenation of its pieces.
fn pieces(text: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut start = 0;
    let mut last = None;
    for (at, letter) in text.char_indices() {
        let class = if letter.is_alphanumeric() || letter == '_' {
            0
        } else {
            1 + letter as u32
        };
        if last.is_some_and(|last| last != class) {
            pieces.push(&text[start..at]);
            start = at;
        }
        last = Some(class);
    }
    pieces.push(&text[start..]);
    pieces
}

#[test]
fn mutated_laws_never_panic() {
    let laws = laws();
    let all: Vec<&str> = laws.iter().flat_map(|law| pieces(law)).collect();
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for _ in 0..1500 {
        let law = random.pick(&laws);
        let mut text = pieces(&law);
        for _ in 0..1 + random.below(4) {
            let at = random.below(text.len());
            match random.below(4) {
                0 => drop(text.remove(at)),
                1 => text.insert(at, random.pick(&all)),
                2 => text[at] = random.pick(&all),
                _ => {
                    let other = random.below(text.len());
                    text.swap(at, other);
                }
            }
            if text.is_empty() {
                break;
            }
        }
        survive(&text.concat());
    }
}

#[test]
fn token_soup_never_panics() {
    let laws = laws();
    let mut all: Vec<&str> = laws.iter().flat_map(|law| pieces(law)).collect();
    all.extend([
        "'",
        "²",
        "ω",
        "\"",
        "{",
        "}",
        "((",
        "]",
        "\u{0}",
        "é",
        "1e400",
        "1e-400",
        "99999999999999999999",
        "-",
        "^",
        "=",
        "𝛚",
        "\r",
        "¶",
    ]);
    let mut random = Random(7);
    for _ in 0..1000 {
        let soup: Vec<&str> = (0..random.below(60)).map(|_| random.pick(&all)).collect();
        let soup = soup.join(if random.below(2) == 0 { " " } else { "" });
        survive(&soup);
        survive(&format!(
            "model m \"Soup\" cite \"Nobody, eq. 1\" {{ param K : pressure \"modulus\" {soup} }}"
        ));
        let formula = format!(
            "model m \"Soup\" cite \"Nobody, eq. 1\" {{ influence omega = 1/x bond b = {soup} energy W = sum(b) }}"
        );
        survive(&formula);
        let _ = front::expression(&soup, &[("x", pdlang::units::Unit::length())], None);
        let _ = front::influence_call(&soup, &[]);
        let _ = pdlang::units::parse(&soup);
        let _ = pdlang::quantity::parse(&soup);
    }
}

#[test]
fn cut_laws_never_panic() {
    for law in laws() {
        for end in (0..law.len())
            .step_by(7)
            .filter(|end| law.is_char_boundary(*end))
        {
            survive(&law[..end]);
        }
    }
}

fn law(items: &str) -> String {
    format!(
        "model m \"Deep\" cite \"Nobody, eq. 1\" {{ param K : pressure \"modulus\"\n{items}\n}}"
    )
}

/// Texts that would exhaust the stack, the memory or the patience of a careless compiler.
#[test]
fn monsters_end_in_a_finding_and_soon() {
    let many = 20_000;
    let doubling: String = (1..60)
        .map(|k| format!("fn f{k}(a) = f{0}(a) + f{0}(a)\n", k - 1))
        .collect();
    let shared: String = (1..200)
        .map(|k| format!("bond b{k} = b{0} + b{0}\n", k - 1))
        .collect();
    let chain: String = (1..many / 10)
        .map(|k| format!("bond b{k} = b{} + 1\n", k - 1))
        .collect();
    let nested: String = (1..200)
        .map(|k| format!("fn f{k}(a) = f{}(a) + 1\n", k - 1))
        .collect();
    let squares: String = (1..60)
        .map(|k| format!("let l{k} = l{0}*l{0}\n", k - 1))
        .collect();
    let monsters = [
        law(&format!(
            "bond b = {}1{}",
            "(".repeat(many),
            ")".repeat(many)
        )),
        law(&format!("bond b = {}", "(".repeat(many))),
        law(&format!("bond b = {}1", "-".repeat(many))),
        law(&format!("break when {} s > 1", "not ".repeat(many))),
        law(&format!("bond b = 1{}", " + 1".repeat(many))),
        law(&format!("bond b = 2{}", "^2".repeat(many))),
        law(&format!("bond b = s{}", "'".repeat(many))),
        law(&format!("bond b = xi{}", ".x".repeat(many))),
        law(&format!(
            "bond b = {}1{}",
            "case flavour { bar: ".repeat(many / 10),
            "}".repeat(many / 10)
        )),
        law(&format!(
            "bond b = {}x{}",
            "sqrt(".repeat(many / 10),
            ")".repeat(many / 10)
        )),
        law(&format!(
            "param L : [{}m{}] \"nested unit\"",
            "(".repeat(many),
            ")".repeat(many)
        )),
        law(&format!("param L : [{}] \"long unit\"", "m ".repeat(many))),
        law(&"{".repeat(many)),
        "model ".repeat(many),
        format!("fn f0(a) = a + a\n{doubling}{}", law("bond b = f59(x)")),
        law(&format!(
            "bond b0 = x\n{shared}energy W = sum(b199)*K/ball(b199)"
        )),
        law(&format!(
            "bond b0 = s\n{chain}energy W = K*sum(b1999)/ball(1)"
        )),
        format!("fn f0(a) = a\n{nested}{}", law("bond b = f199(x)")),
        law(&format!("let l0 = 2 m\n{squares}bond b = l59")),
        law("bond b = x^100000 + (1 m)^-20000*1 m^30000"),
    ];
    for (k, monster) in monsters.iter().enumerate() {
        let start = Instant::now();
        survive(monster);
        assert!(
            start.elapsed() < Duration::from_secs(5),
            "monster {k} took {:?}",
            start.elapsed()
        );
    }
}
