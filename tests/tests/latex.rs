//! Pages in LaTeX are whole: what opens closes, in its order, and no mark of Markdown is left. No LaTeX is needed for it.

use pdlang::emit::Stage;
use pdlang_models::page::page;
use pdlang_models::registry::CATALOGUE;
use rayon::prelude::*;
use std::path::Path;

/// What is wrong with a page, with the place where it was seen.
fn broken(page: &str) -> Option<String> {
    let text = without_listings(page);
    for mark in ["`", "**", "](", "\n#", "\n|", "| ---"] {
        if let Some(at) = text.find(mark) {
            return Some(format!("`{mark}` of Markdown: {}", around(&text, at)));
        }
    }
    let mut open: Vec<String> = vec![];
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        let token = token(rest);
        let (name, length) = match token {
            "\\begin" | "\\end" => named(rest, token),
            _ => (String::new(), token.len()),
        };
        let (opens, closes) = match token {
            "{" | "\\left" | "\\[" | "\\begingroup" => (Some(token.to_string()), None),
            "}" => (None, Some("{".to_string())),
            "\\right" => (None, Some("\\left".into())),
            "\\]" => (None, Some("\\[".into())),
            "\\endgroup" => (None, Some("\\begingroup".into())),
            "\\begin" => (Some(name), None),
            "\\end" => (None, Some(name)),
            "$" if open.last().is_some_and(|last| last == "$") => (None, Some("$".into())),
            "$" => (Some("$".into()), None),
            _ => (None, None),
        };
        if opens.as_deref() == Some("$") && open.iter().any(|o| o == "$" || o == "\\[") {
            return Some(format!("a formula in a formula: {}", around(&text, at)));
        }
        if let Some(wanted) = closes {
            match open.pop() {
                Some(last) if last == wanted => {}
                last => {
                    let last = last.unwrap_or_else(|| "nothing".into());
                    let place = around(&text, at);
                    return Some(format!(
                        "`{token}` closes {wanted}, open is {last}: {place}"
                    ));
                }
            }
        }
        open.extend(opens);
        // Cells and lines end in their environment, and a paragraph outside of formulas.
        let inner = open.last().map_or("", String::as_str);
        let loose = match token {
            "&" => matches!(inner, "" | "{" | "$" | "\\[" | "\\left" | "\\begingroup"),
            "\n" => rest.starts_with("\n\n") && matches!(inner, "$" | "\\[" | "\\left" | "cases"),
            _ => false,
        };
        if loose {
            return Some(format!("`{token}` within {inner}: {}", around(&text, at)));
        }
        at += length;
    }
    (!open.is_empty()).then(|| format!("open at the end: {}", open.join(", ")))
}

/// A command with all of its letters, an escaped letter, or a letter.
fn token(text: &str) -> &str {
    let letters = |c: &char| c.is_ascii_alphabetic();
    let mut chars = text.chars();
    let end = match (chars.next(), chars.clone().take_while(letters).count()) {
        (Some('\\'), 0) => 1 + chars.next().map_or(0, char::len_utf8),
        (Some('\\'), n) => 1 + n,
        (first, _) => first.map_or(0, char::len_utf8),
    };
    &text[..end]
}

/// The name of an environment, and the letters of `\begin{name}`.
fn named(text: &str, token: &str) -> (String, usize) {
    let name = text[token.len()..].strip_prefix('{');
    match name.and_then(|rest| rest.split_once('}')) {
        Some((name, _)) => (name.into(), token.len() + name.len() + 2),
        None => ("an environment without a name".into(), token.len()),
    }
}

/// A page without its comments, and without listings, whose letters stand for themselves.
fn without_listings(page: &str) -> String {
    let mut text = String::new();
    let mut listing = false;
    for line in page.lines() {
        match line {
            "\\begin{verbatim}" => listing = true,
            "\\end{verbatim}" => listing = false,
            _ if listing || line.starts_with('%') => {}
            _ => text += &format!("{line}\n"),
        }
    }
    // A listing that has no end hides nothing.
    if listing { page.into() } else { text }
}

fn around(text: &str, at: usize) -> String {
    let before: Vec<char> = text[..at].chars().rev().take(40).collect();
    let after = text[at..].chars().take(40);
    before.into_iter().rev().chain(after).collect()
}

fn latex(text: &str, path: &str) -> String {
    let made = page(text, path, Stage::Latex, None, Some("waves_of.svg"));
    made.unwrap_or_else(|found| panic!("{path}: {found:?}"))
        .text
}

#[test]
fn pages_are_whole() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formulas");
    let files = std::fs::read_dir(folder).unwrap();
    let mut texts: Vec<(String, String)> = files
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            (
                path.display().to_string(),
                std::fs::read_to_string(path).unwrap(),
            )
        })
        .collect();
    texts.extend(CATALOGUE.iter().map(|e| (e.name.into(), e.text.into())));
    // Some of them take seconds.
    texts.par_iter().for_each(|(path, text)| {
        let page = latex(text, path);
        assert_eq!(broken(&page), None, "{path}");
        assert!(
            page.contains("\\begin{tabular}") && page.contains("\\[ "),
            "{path}"
        );
    });
}

/// One mark less or more in a page is seen.
#[test]
fn a_page_that_is_not_whole_is_noticed() {
    let entry = CATALOGUE.iter().find(|e| e.name == "lps").unwrap();
    let page = latex(entry.text, entry.name);
    for (from, to) in [
        ("\\frac{", "\\frac"),
        ("\\left(", "("),
        ("\\right)", ")"),
        ("\\end{tabular}", ""),
        ("\\begin{tabular}", "\\begin{array}"),
        ("\\end{align*}", "\\end{align}"),
        ("\\end{verbatim}", ""),
        (" \\]", ""),
        ("$K$", "$K"),
        ("$K$", "$K & G$"),
        ("$K$", "$K$$"),
        ("$K$", "`K`"),
        ("$K$", "**K**"),
        ("$K$", "[K](K.md)"),
        ("\\subsection*{Parameters}", "## Parameters"),
        ("\\subsection*{Parameters}", "\\subsection*{Parameters"),
        ("\\endgroup", ""),
        (" \\]", "\n\n\\]"),
    ] {
        let other = page.replacen(from, to, 1);
        assert_ne!(page, other, "{from} is not on the page");
        assert!(broken(&other).is_some(), "{from} as {to} is not noticed");
    }
    // What is escaped opens nothing, and a listing holds anything.
    let fine = "\\{ \\$ \\left\\{ x \\right. \\\\\n\\begin{verbatim}\n{ $ ` **\n\\end{verbatim}\n";
    assert_eq!(broken(fine), None);
}
