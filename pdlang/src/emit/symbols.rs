//! Names, numbers and units as LaTeX.

use crate::ast::UnitExpr;

const GREEK: [&str; 22] = [
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa",
    "lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega",
];

/// A name of the language: Greek letters, the part behind the first underscore and final digits as index.
pub(super) fn name(text: &str, bold: bool) -> String {
    let (head, index) = match text.split_once('_') {
        Some((head, index)) if !head.is_empty() => (head, index),
        _ => {
            let head = text.trim_end_matches(|c: char| c.is_ascii_digit());
            match head.is_empty() {
                true => (text, ""),
                false => (head, &text[head.len()..]),
            }
        }
    };
    let capital = head.chars().next().is_some_and(char::is_uppercase);
    let lower = head.to_lowercase();
    let head = match GREEK.contains(&lower.as_str()) {
        // Capital Greek letters that look like Latin ones have no command.
        true if capital => match lower.as_str() {
            "gamma" | "delta" | "theta" | "lambda" | "xi" | "pi" | "sigma" | "phi" | "psi"
            | "omega" => {
                format!("\\{head}")
            }
            _ => format!("\\mathrm{{{head}}}"),
        },
        true => format!("\\{head}"),
        false if head.chars().count() == 1 => head.to_string(),
        false => format!("\\mathit{{{}}}", head.replace('_', "\\_")),
    };
    let head = match (bold, head.starts_with("\\mathit")) {
        (false, _) => head,
        (true, true) => head.replace("\\mathit", "\\mathbf"),
        (true, false) if head.starts_with('\\') => format!("\\boldsymbol{{{head}}}"),
        (true, false) => format!("\\mathbf{{{head}}}"),
    };
    match index.chars().count() {
        0 => head,
        1 if index != "_" => format!("{head}_{index}"),
        _ if index.chars().all(|c| c.is_ascii_digit()) => format!("{head}_{{{index}}}"),
        _ if GREEK.contains(&index) => format!("{head}_\\{index}"),
        _ => format!("{head}_{{\\mathrm{{{}}}}}", index.replace('_', "\\_")),
    }
}

/// A number: powers of ten instead of long rows of digits.
pub(super) fn number(value: f64) -> String {
    if value.is_infinite() {
        return if value > 0.0 { "\\infty" } else { "-\\infty" }.into();
    }
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        return value.to_string();
    }
    let text = format!("{value:e}");
    match text.split_once('e') {
        Some(("1", power)) => format!("10^{{{power}}}"),
        Some((digits, power)) => format!("{digits} \\times 10^{{{power}}}"),
        None => text,
    }
}

/// A unit as it was written, in upright letters: `kg/m^3`.
pub(super) fn unit(unit: &UnitExpr) -> String {
    let one = |(name, power): &(crate::ast::Name, f64)| {
        let name = name
            .text
            .replace(['µ', 'μ'], "\\mu ")
            .replace('°', "^\\circ ")
            .replace('%', "\\%");
        match power.abs() {
            1.0 => format!("\\mathrm{{{name}}}"),
            n => format!("\\mathrm{{{name}}}^{{{n}}}"),
        }
    };
    let part = |sign: f64| -> Vec<String> {
        let factors = unit.factors.iter().filter(|(_, power)| power * sign > 0.0);
        factors.map(one).collect()
    };
    let (above, below) = (part(1.0), part(-1.0));
    let above = if above.is_empty() {
        "1".into()
    } else {
        above.join("\\,")
    };
    match below.len() {
        0 => above,
        1 => format!("{above}/{}", below[0]),
        _ => format!("{above}/({})", below.join("\\,")),
    }
}

/// Text outside of mathematics.
pub(super) fn prose(text: &str) -> String {
    let mut out = String::new();
    for letter in text.chars() {
        match letter {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', letter]),
            '\\' => out.push_str("\\textbackslash{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '|' => out.push_str("\\textbar{}"),
            _ => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_field() {
        for (text, latex) in [
            ("K", "K"),
            ("s0", "s_0"),
            ("omega_g", "\\omega_g"),
            ("K_bb", "K_{\\mathrm{bb}}"),
            ("theta", "\\theta"),
            ("cg", "\\mathit{cg}"),
            ("ed", "\\mathit{ed}"),
            ("Gamma", "\\Gamma"),
            ("_x", "\\mathit{\\_x}"),
            ("a__", "a_{\\mathrm{\\_}}"),
        ] {
            assert_eq!(name(text, false), latex);
        }
        assert_eq!(name("xi", true), "\\boldsymbol{\\xi}");
        assert_eq!(name("Kinv", true), "\\mathbf{Kinv}");
        assert_eq!(name("F", true), "\\mathbf{F}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(0.25), "0.25");
        assert_eq!(number(1e-6), "10^{-6}");
        assert_eq!(number(2.5e9), "2.5 \\times 10^{9}");
    }
}
