//! Columns: neighbouring lines of a kind put their `:`, their `=`, their descriptions and their comments
//! below each other.

use super::lines::{Line, joined};

const DEFINITIONS: [&str; 9] = [
    "let", "node", "bond", "energy", "pair", "state", "force", "rate", "update",
];

/// A line of a column: its kind, and how many bytes at its end are moved.
type Cut = Option<(&'static str, usize)>;

/// The text of the lines.
pub(super) fn align(lines: Vec<Line>) -> String {
    let indented = |line: &Line| format!("{}{}", " ".repeat(line.indent), line.text());
    let mut texts: Vec<String> = lines.iter().map(indented).collect();
    let whole: Vec<bool> = (0..lines.len()).map(|k| is_whole(&lines, k)).collect();
    let items = |cut: fn(&Line) -> Cut| -> Vec<Cut> {
        let of = |(line, whole): (&Line, &bool)| if *whole { cut(line) } else { None };
        lines.iter().zip(&whole).map(of).collect()
    };
    pad(&mut texts, &lines, &items(bounds), 1);
    pad(&mut texts, &lines, &items(value), 1);
    pad(&mut texts, &lines, &items(description), 2);
    for (text, line) in texts.iter_mut().zip(&lines) {
        let comment = line.comment.as_deref().unwrap_or_default();
        text.push_str(if line.tokens.is_empty() { "" } else { " " });
        text.push_str(comment);
    }
    let comments: Vec<Cut> = lines.iter().map(comment).collect();
    pad(&mut texts, &lines, &comments, 2);
    let mut out = String::new();
    for (k, (text, line)) in texts.iter().zip(&lines).enumerate() {
        out.push_str(if line.gap && k > 0 { "\n" } else { "" });
        out.push_str(text.trim_end());
        out.push('\n');
    }
    out
}

fn word(line: &Line) -> &str {
    line.tokens.first().map_or("", |(word, _)| word)
}

/// Whether a line is all of an item.
fn is_whole(lines: &[Line], k: usize) -> bool {
    let next = lines[k + 1..].iter().find(|line| !line.tokens.is_empty());
    lines[k].starts && next.is_none_or(|next| next.starts || next.indent < lines[k].indent)
}

fn bounds(line: &Line) -> Cut {
    (word(line) == "param").then_some(())?;
    Some(("param", tail(line, ":")?))
}

fn value(line: &Line) -> Cut {
    let kind = match (line.indent, word(line)) {
        (4, "expect") => "expect",
        (4, "let") => "let",
        (4, "node") => "node",
        (0 | 2, word) if DEFINITIONS.contains(&word) => "definition",
        _ => return None,
    };
    Some((kind, tail(line, "=")?))
}

/// The text in quotes at the end of an item of a model.
fn description(line: &Line) -> Cut {
    let (last, _) = line.tokens.last()?;
    (line.indent > 0 && last.starts_with('"')).then_some(("", last.len()))
}

fn comment(line: &Line) -> Cut {
    let comment = line.comment.as_ref().filter(|_| !line.tokens.is_empty())?;
    Some(("", comment.len()))
}

/// Length of a line from its first token `sign` outside of brackets on.
fn tail(line: &Line, sign: &str) -> Option<usize> {
    let mut depth = 0_i32;
    for (k, (token, _)) in line.tokens.iter().enumerate() {
        match token.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            token if token == sign && depth == 0 => return Some(joined(&line.tokens[k..]).len()),
            _ => {}
        }
    }
    None
}

/// Brings the ends of neighbouring lines of one kind below each other, `least` blanks behind the longest.
fn pad(texts: &mut [String], lines: &[Line], cuts: &[Cut], least: usize) {
    let mut start = 0;
    for k in 1..=texts.len() {
        let kind = |k: usize| cuts.get(k).copied().flatten().map(|(kind, _)| kind);
        let joins = k < texts.len() && kind(k).is_some() && kind(k) == kind(k - 1) && !lines[k].gap;
        if !joins {
            pad_run(&mut texts[start..k], &cuts[start..k], least);
            start = k;
        }
    }
}

fn pad_run(texts: &mut [String], cuts: &[Cut], least: usize) {
    let parts = |text: &String, cut: &Cut| -> Option<(String, String)> {
        let (_, length) = (*cut)?;
        let (head, tail) = text.split_at_checked(text.len().checked_sub(length)?)?;
        Some((head.trim_end().to_string(), tail.to_string()))
    };
    let parts: Vec<_> = texts.iter().zip(cuts).map(|(t, c)| parts(t, c)).collect();
    let width = |head: &str| head.chars().count();
    let widest = parts
        .iter()
        .flatten()
        .map(|(head, _)| width(head))
        .max()
        .unwrap_or(0);
    for (text, part) in texts.iter_mut().zip(parts) {
        if let Some((head, tail)) = part {
            let pad = " ".repeat(widest - width(&head) + least);
            *text = format!("{head}{pad}{tail}");
        }
    }
}
