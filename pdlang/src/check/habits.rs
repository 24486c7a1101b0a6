//! What people bring along from other languages and from printed pages, and what it is called here.

/// For a token that cannot stand where it does: `line` is its line up to it, `rest` the text from it on.
pub(crate) fn token(line: &str, rest: &str) -> Option<String> {
    let before = line.trim_end();
    let adjacent = before.len() == line.len();
    let word = last_word(before);
    let first = rest.chars().next()?;
    let starts = |text: &str| rest.starts_with(text);
    let says = |text: &str| Some(text.to_string());
    let digit = |text: &str| text.starts_with(|c: char| c.is_ascii_digit());
    let ends_in_digit = before.ends_with(|c: char| c.is_ascii_digit());
    if let Some(remedy) = printed(first) {
        return Some(remedy);
    }
    // What was read as a name, and is none; or begins no definition. A law may call a value `output`: such words are
    // those of another language only where a definition could begin.
    let begun = rest
        .split(|c: char| !(c.is_alphanumeric() || c == '_'))
        .next()
        .unwrap_or_default();
    let at_start = |head: &str| {
        let head = head.trim_end();
        head.is_empty() || head.ends_with(['{', '}', '"', ')', ']'])
    };
    let statements = [
        (word, at_start(&before[..before.len() - word.len()])),
        (begun, at_start(before)),
    ];
    let meant =
        |(word, first): (&str, bool)| keyword(word).or_else(|| statement(word).filter(|_| first));
    if let Some(remedy) = statements.into_iter().find_map(meant) {
        return says(remedy);
    }
    match first {
        '+' if starts("+-") => says(TOLERANCE),
        '*' if adjacent && before.ends_with('*') => says("a power is written `^`: `a^2`"),
        '/' if starts("/*") => says(COMMENTS),
        '*' if adjacent && before.ends_with('/') => says(COMMENTS),
        '%' => says(COMMENTS),
        '-' if adjacent && before.ends_with('-') => says(COMMENTS),
        '!' if starts("!=") => {
            says("there is no test for inequality of numbers: use `<`, `<=`, `>` or `>=`")
        }
        '!' => says("`not` negates a condition; comments begin with `#` or `//`"),
        ';' => says("a definition ends with its line, without `;`"),
        '?' => says("a choice is written `select(condition, a, b)`"),
        '&' => says("both conditions: `and`"),
        '|' if starts("||") => says("either condition: `or`"),
        '|' => says(
            "a length is written `norm(v)`, a magnitude `abs(a)`; `x` and `y` are those of the bond",
        ),
        '=' if before.ends_with('=') || starts("==") => {
            says("there is no test for equality of numbers: use `<`, `<=`, `>` or `>=`")
        }
        '=' if starts("=>") || starts("=<") => says("these are written `>=` and `<=`"),
        '>' if before.ends_with('=') => says("greater or equal is written `>=`"),
        '<' if before.ends_with('=') => says("less or equal is written `<=`"),
        '=' if before.ends_with(['+', '-', '*', '/']) => {
            says("a name has one value: nothing is changed behind its definition")
        }
        '.' if digit(&rest[1..]) => {
            Some(format!("a number begins with a digit: `0{}`", number(rest)))
        }
        ',' if adjacent && ends_in_digit && digit(&rest[1..]) => says("the decimal sign is `.`"),
        _ if first.is_whitespace() && before.ends_with('.') => {
            says("a number ends with a digit: `2.0` or `2`")
        }
        _ if first.is_ascii_digit() && adjacent && !word.is_empty() => {
            Some(format!("a power is written `^`: `{word}^{}`", number(rest)))
        }
        _ if starts("fn ") => says("functions stand outside of models, before them"),
        _ => None,
    }
}

/// Words that name nothing in any language.
fn keyword(word: &str) -> Option<&'static str> {
    Some(match word {
        "if" | "elif" | "else" | "while" => "a choice is written `select(condition, a, b)`",
        "def" | "return" => statement(word)?,
        _ => return None,
    })
}

/// Words that begin a statement of another language.
fn statement(word: &str) -> Option<&'static str> {
    Some(match word {
        "do" | "loop" => "there are no loops: `sum(..)` runs over the family",
        "def" | "function" | "lambda" => "a function is written `fn f(a) = ..`, outside of models",
        "return" | "print" | "output" | "import" => {
            "give the value a name with `let`, `node` or `bond`: outputs are chosen by name in the scene"
        }
        _ => return None,
    })
}

const TOLERANCE: &str = "a tolerance is written `within`: `expect q = 0.3 within 0.1`; a number less than zero `(-0.1)`";
const COMMENTS: &str = "a comment begins with `#` or `//` and ends with its line";

/// Letters of printed formulas.
fn printed(letter: char) -> Option<String> {
    let written = match letter {
        '−' | '–' => "-",
        '×' | '⋅' | '∙' => "*",
        '÷' => "/",
        '√' => "sqrt(..)",
        '±' => return Some(TOLERANCE.into()),
        '½' => "1/2",
        '¼' => "1/4",
        '¾' => "3/4",
        '∑' | 'Σ' => "sum(..)",
        '∫' => "ball(..)",
        '∞' => "inf",
        '≤' => "<=",
        '≥' => ">=",
        '′' | '’' => "'",
        '⁰' | '⁴'..='⁹' => return Some(format!("write `^{}`", letter as u32 - '⁰' as u32)),
        '₀'..='₉' => {
            return Some(format!(
                "write the index with the name: `_{}`",
                letter as u32 - '₀' as u32
            ));
        }
        _ => return None,
    };
    Some(format!("write `{written}`"))
}

fn last_word(text: &str) -> &str {
    let start = text.char_indices().rev();
    let start = start
        .take_while(|(_, c)| c.is_alphanumeric() || *c == '_')
        .last();
    let word = start.map_or("", |(at, _)| &text[at..]);
    if word.starts_with(|c: char| c.is_ascii_digit()) {
        return "";
    }
    word
}

fn number(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.');
    &text[..end.unwrap_or(text.len())]
}

/// A function that is called otherwise here.
pub(crate) fn function(name: &str) -> Option<&'static str> {
    Some(match name.to_lowercase().as_str() {
        "log" | "log10" => "the natural logarithm is `ln(a)`",
        "pow" | "power" => "a power is written `a^b`",
        "square" | "sqr" => "a square is written `a^2`",
        "sign" | "sgn" | "heaviside" | "step" => {
            "write `select(a > 0, 1, -1)`, with the values that are meant"
        }
        "pos" | "macaulay" | "ramp" | "positive" => "the positive part is `max(a, 0)`",
        "if" | "where" | "ifelse" | "cond" => "a choice is written `select(condition, a, b)`",
        "integral" | "integrate" => {
            "a sum over the family is `sum(..)`, an integral over a whole one `ball(..)`"
        }
        "grad" | "gradient" | "div" | "laplacian" | "curl" => {
            "there are no derivatives, only sums over the family: a gradient is `sum(omega*outer(eta, xi)) * inverse(sum(omega*outer(xi, xi)))`"
        }
        "inv" => "the inverse of a tensor is `inverse(A)`",
        "trace" => "the trace is `tr(A)`",
        "length" | "magnitude" => "the length of a vector is `norm(v)`",
        "average" | "avg" => "the mean over the family is `mean(..)`",
        "sum_j" | "sumj" => "the sum over the family is `sum(..)`",
        _ => return None,
    })
}

/// A value that is called otherwise here.
pub(crate) fn value(name: &str) -> Option<&'static str> {
    Some(match name {
        "damage" | "phi" => "damage is `1 - sum(1)/sum0(1)`",
        "u" => "the relative displacement of a bond is `eta`",
        "horizon" => "the horizon is `delta`",
        "thickness" | "area" | "cross_section" => {
            "a law does not see it: volumes, and with them `sum` and `ball`, contain it"
        }
        "stretch" => "the stretch of a bond is `s`",
        "volume" | "V_j" | "Vj" | "dV" => {
            "`sum` multiplies by the volume of the other node by itself"
        }
        "true" | "false" => "a condition is a comparison, such as `s > s0`",
        _ => return None,
    })
}

/// A unit that the language does not have.
pub(crate) fn unit(name: &str) -> Option<&'static str> {
    Some(match name {
        "h" | "hr" | "hour" | "hours" => "an hour is `3600 s`",
        "min" | "minute" | "minutes" => "a minute is `60 s`",
        "d" | "day" | "days" => "a day is `86400 s`",
        "sec" | "second" | "seconds" => "seconds are `s`",
        "degC" | "°C" | "celsius" => "temperatures are in `K`: 20 °C is `293.15 K`",
        "psi" => "a psi is `6894.757 Pa`",
        "ksi" => "a ksi is `6.894757 MPa`",
        "bar" => "a bar is `1e5 Pa`",
        "in" | "inch" => "an inch is `25.4 mm`",
        "ft" => "a foot is `0.3048 m`",
        "percent" => "write `%`",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use crate::check::tests::law;

    fn help(text: &str) -> String {
        let checked = crate::front::file(&law(text));
        let first = checked.diagnostics.first().expect("a finding");
        first.help.clone().unwrap_or_default()
    }

    /// A name is a name, whatever other languages call so.
    #[test]
    fn a_value_may_have_a_name_of_another_language() {
        for name in ["output", "function", "loop", "lambda"] {
            let text = format!("let {name} = 2\n let b = {name} 3*K");
            assert!(!help(&text).contains("outputs are chosen"), "{name}");
            assert!(!help(&text).contains("outside of models"), "{name}");
            assert!(!help(&text).contains("no loops"), "{name}");
        }
        assert!(help("print K").contains("outputs are chosen"));
        assert!(help("loop K").contains("no loops"));
    }

    #[test]
    fn every_habit_is_answered() {
        for (text, remedy) in [
            ("let a = 2**3", "`^`"),
            ("let a = 0.3 +- 0.1", "`within`"),
            ("let a = 0.3 ± 0.1", "`within`"),
            ("let a = 2;", "without `;`"),
            ("let a = 0,5", "decimal sign"),
            ("let a = .5*K", "`0.5`"),
            ("let a = 2.\nlet b = 1", "`2.0` or `2`"),
            ("let a = 1.e5*K", "`1.0e5`"),
            ("let a = if K > 0 then 1", "select("),
            ("let a = K > 0 ? 1 : 2", "select("),
            ("break when s > 0 && s > 1", "`and`"),
            ("break when s == 0", "equality"),
            ("break when s => 0", "`>=`"),
            ("break when !(s > 0)", "`not`"),
            ("% half of it\nlet a = 2", "`#`"),
            ("/* a */ let a = 2", "`#`"),
            ("let a = 2 × 3", "`*`"),
            ("let a = √2", "sqrt"),
            ("let a = K⁴", "`^4`"),
            ("fn f(a) = a^2", "outside of models"),
            ("def f(a) = a^2", "outside of models"),
            ("let a = 1 [N/mm2]", "`mm^2`"),
            ("let a = |K|", "abs"),
            ("let a = log(2)", "ln"),
            ("let a = pow(2, 3)", "a^b"),
            ("bond b = s*damage", "sum0"),
            ("bond b = s*phi", "sum0"),
            ("bond b = s/horizon", "delta"),
            ("let a = 3 h", "3600"),
            ("let a = 3 mpa", "`MPa` or `mPa`"),
            ("let in = 2", "word of the language"),
        ] {
            let found = help(text);
            assert!(found.contains(remedy), "{text}: {found}");
        }
    }
}
