//! Long formulas on several lines, as LaTeX does not break them.

/// Letters that a line of a page holds, by [`width`].
const LINE: f64 = 58.0;

/// A displayed formula.
pub(super) fn display(formula: &str) -> String {
    let pieces = pieces(formula);
    let all: f64 = pieces.iter().map(|p| width(p.text)).sum();
    if pieces.len() < 2 || all <= LINE {
        return format!("\\[ {formula} \\]");
    }
    // Lines begin behind the sign that follows the name, or a little farther in.
    let (mut lines, mut line, mut open, mut long) = (vec![], String::new(), 0, 0.0);
    for (k, piece) in pieces.iter().enumerate() {
        let own = width(piece.text);
        if k > 1 && long + own > LINE {
            lines.push(format!("{line}{}", "\\right.".repeat(open)));
            line = format!("&\\quad {}", "\\left.".repeat(piece.open));
            long = 4.0;
        }
        let mark = if k == 1 { "&" } else { "" };
        line += &format!("{mark}{}", piece.text);
        long += own;
        open = pieces.get(k + 1).map_or(0, |next| next.open);
    }
    lines.push(line);
    format!(
        "\\begin{{align*}} {} \\end{{align*}}",
        lines.join(" \\\\\n ")
    )
}

/// What is not broken, and how many parentheses are open where it begins.
struct Piece<'a> {
    text: &'a str,
    open: usize,
}

/// A formula, cut before its sign of equality and its signs of sums, also those in parentheses.
fn pieces(formula: &str) -> Vec<Piece<'_>> {
    let mut all = vec![];
    let (mut start, mut open_there) = (0, 0);
    let (mut braces, mut open, mut named) = (0_usize, 0_usize, false);
    let mut k = 0;
    while k < formula.len() {
        let rest = &formula[k..];
        let word = token(rest);
        match word {
            "{" => braces += 1,
            "}" => braces = braces.saturating_sub(1),
            // What a formula chooses from stays together.
            "\\begin" => braces += 1,
            "\\end" => braces = braces.saturating_sub(1),
            "\\left" if braces == 0 => open += 1,
            "\\right" if braces == 0 => open = open.saturating_sub(1),
            _ => {}
        }
        let equal = !named && open == 0 && (rest.starts_with("= ") || word == "\\leftarrow");
        let sum = named && (rest.starts_with("+ ") || rest.starts_with("- "));
        // A sign behind a space stands between two terms.
        let between = k > 0 && formula.as_bytes()[k - 1] == b' ';
        if braces == 0 && between && (equal || sum) {
            all.push(Piece {
                text: &formula[start..k],
                open: open_there,
            });
            (start, open_there) = (k, open);
            named |= equal;
        }
        k += word.len();
    }
    all.push(Piece {
        text: &formula[start..],
        open: open_there,
    });
    all
}

/// A command, or a letter.
fn token(text: &str) -> &str {
    let mut letters = text.char_indices();
    let end = match letters.next() {
        Some((_, '\\')) => match text[1..].find(|c: char| !c.is_ascii_alphabetic()) {
            Some(0) => 1 + text[1..].chars().next().map_or(0, char::len_utf8),
            Some(n) => 1 + n,
            None => text.len(),
        },
        _ => letters.next().map_or(text.len(), |(k, _)| k),
    };
    &text[..end]
}

/// Roughly how many letters wide a formula is.
fn width(formula: &str) -> f64 {
    let (mut sum, mut k) = (0.0, 0);
    while k < formula.len() {
        let rest = &formula[k..];
        let word = token(rest);
        k += word.len();
        let small = matches!(word, "^" | "_");
        match word {
            "\\frac" => {
                let above = group(&formula[k..]);
                let below = group(&formula[k + above.len()..]);
                k += above.len() + below.len();
                sum += width(above).max(width(below)) + 0.5;
            }
            "\\begin" => {
                let end = formula[k..].find("\\end{").unwrap_or(formula.len() - k);
                let rows = formula[k..k + end].split("\\\\").map(width);
                sum += rows.fold(0.0, f64::max) + 3.0;
                k += end;
            }
            "\\end" => k += group(&formula[k..]).len(),
            _ if small => {
                let index = group(&formula[k..]);
                k += index.len();
                sum += 0.75 * width(index);
            }
            "{" | "}" | " " | "\\left" | "\\right" | "\\," | "'" => sum += 0.2,
            "+" | "-" | "=" | "\\cdot" | "\\otimes" => sum += 2.4,
            "\\sum" | "\\int" => sum += 2.5,
            "\\mathbf" | "\\mathrm" | "\\mathit" | "\\text" | "\\mathcal" | "\\boldsymbol"
            | "\\dot" | "\\operatorname" | "\\underline" => {}
            _ if word.starts_with('\\') && word.len() > 3 => sum += 1.5,
            _ => sum += 1.0,
        }
    }
    sum
}

/// What stands in the braces at the beginning of a text, with them; else its first letter.
fn group(text: &str) -> &str {
    if !text.starts_with('{') {
        return token(text);
    }
    let mut depth = 0;
    let mut k = 0;
    while k < text.len() {
        let word = token(&text[k..]);
        k += word.len();
        depth += i32::from(word == "{") - i32::from(word == "}");
        if depth == 0 {
            break;
        }
    }
    &text[..k]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_formula_stays_on_its_line() {
        assert_eq!(display("a = b + c"), "\\[ a = b + c \\]");
    }

    /// Parentheses are closed at the end of a line and opened again on the next, out of sight; braces are not broken.
    #[test]
    fn a_long_formula_is_broken_at_its_signs() {
        let long = "\\mathit{abcdefgh}\\,\\mathit{ijklmnop}";
        let formula =
            format!("a = \\left({long} + \\frac{{x + y}}{{z}}\\,{long} - {long}\\right)\\,b");
        let lines = format!(
            "\\begin{{align*}} a &= \\left({long} + \\frac{{x + y}}{{z}}\\,{long} \\right. \\\\\n \
             &\\quad \\left.- {long}\\right)\\,b \\end{{align*}}"
        );
        assert_eq!(display(&formula), lines);
    }

    #[test]
    fn a_fraction_is_as_wide_as_the_longer_of_its_parts() {
        assert_eq!(width("\\frac{abc}{d}"), width("\\frac{abc}{abc}"));
        assert!(width("\\frac{abc}{d}") < width("\\frac{abc}{defgh}"));
    }

    /// Whatever stands in it, nothing of a formula is lost.
    #[test]
    fn formulas_that_are_none_end() {
        for text in [
            "",
            "\\",
            "a = \\",
            "{ + {",
            "é = ω + µ",
            "\\frac",
            "\\begin",
            "a_",
            "= + - ",
        ] {
            let _ = display(text);
            let all: String = pieces(text).iter().map(|p| p.text).collect();
            assert_eq!(all, text);
        }
    }
}
