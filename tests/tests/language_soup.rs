//! Whatever the text, the language answers with findings: it never panics, never runs out of stack and
//! never runs for long. Texts are made by a generator with a fixed seed, so that a failure repeats.

use pdlang::front;
use pdlang_tests::fuzz::{self, Came, Random};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Texts of a kind; as many as fit into a minute.
const MUTANTS: usize = if cfg!(feature = "long") { 20_000 } else { 400 };

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
    let folders = [
        "../models/laws",
        "fixtures/laws",
        "fixtures/lang/pass",
        "fixtures/lang/fail",
    ];
    texts(&folders, "pd")
}

fn texts(folders: &[&str], extension: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths: Vec<_> = folders
        .iter()
        .flat_map(|folder| fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    paths.sort();
    let read = |path: &PathBuf| fs::read_to_string(path).unwrap();
    paths.iter().map(read).collect()
}

/// Through the whole compiler, and what the laws among them say on every path is one thing.
#[test]
fn mutated_laws_are_refused_or_mean_one_thing() {
    let laws = laws();
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let (mut count, mut sum) = (0, Came::default());
    for _ in 0..MUTANTS {
        let came = fuzz::language(&fuzz::mutant(&mut random, &laws));
        count += usize::from(came.laws > 0);
        sum.compiled += came.compiled;
        sum.compared += came.compared;
    }
    println!("{MUTANTS} texts, {count} with laws, {sum:?}");
    assert!(sum.compared * 50 > MUTANTS, "hardly a law among them");
}

#[test]
fn mutated_scenes_are_refused_or_built() {
    let scenes = texts(&["scenes", "../examples", "fixtures/scene"], "toml");
    let mut random = Random(0x0005_CE9E);
    let mut built = 0;
    for _ in 0..MUTANTS {
        built += usize::from(fuzz::scene(&fuzz::mutant(&mut random, &scenes)));
    }
    println!("{MUTANTS} scenes, {built} built");
    assert!(built > 0, "no scene among them");
}

#[test]
fn token_soup_never_panics() {
    let laws = laws();
    let mut all: Vec<&str> = laws.iter().flat_map(|law| fuzz::pieces(law)).collect();
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

/// Weights of 0: the energy cancels to nothing in one order of operations, and nearly so in another. Found by fuzzing.
#[test]
fn what_cancels_agrees() {
    let solid = pdlang_models::registry::find("solid").expect("a law of the catalogue");
    let text = solid.text.replace("= 1/norm(", "= 0/norm(");
    assert_ne!(text, solid.text);
    assert!(fuzz::language(&text).compared > 0);
}

/// As long as a law may be, or read in ever so many ways: through the whole compiler, the oracle and to the page.
#[test]
fn what_the_limits_let_pass_is_compiled() {
    let chained = |n: usize, link: &dyn Fn(String) -> String| {
        let links = (1..n).map(|k| format!("bond b{k} = {}\n", link(format!("b{}", k - 1))));
        let links: String = links.collect();
        law(&format!(
            "influence omega = 1\nbond b0 = s\n{links}energy W = K*sum(b{}^2)/ball(1)",
            n - 1
        ))
    };
    let texts = [
        chained(190, &|b| format!("{b} + 0.001")),
        chained(40, &|b| format!("0.5*{b} + 0.5*{b}")),
        chained(40, &|b| format!("0.5*{b} + 0.5*{b}'")),
    ];
    for text in texts {
        let came = fuzz::language(&text);
        assert!(came.compared > 0, "{came:?}\n{text}");
    }
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
    // What opens and never closes, few enough for a reader that tries every one of them both ways.
    let open = [
        "{",
        "(",
        "[",
        "sqrt(",
        "sum[f](",
        "(1, ",
        "case flavour { bar: ",
        "m(",
        "\"{",
        "probe p in bar { let a = ",
    ];
    let few = open.iter().flat_map(|open| {
        let open = open.repeat(60);
        ["", "bond b = ", "param L : [", "energy W : "].map(|front| law(&format!("{front}{open}")))
    });
    let monsters = monsters.into_iter().chain(few).collect::<Vec<_>>();
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
