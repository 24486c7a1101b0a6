//! The parts of a law's page, and the page in each of its forms.
//!
//! Contract. Whatever a page says, it says in all forms: the forms differ in nothing but their marks.

use super::{broken, symbols};

/// A part of a page. Words have `code` in backquotes, formulas in `$` and links as in Markdown.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    Heading(String),
    Text(String),
    /// Columns, then rows.
    Table(Vec<&'static str>, Vec<Vec<String>>),
    /// What stands before a formula, and the formula.
    Equation(String, String),
    /// Text of the language.
    Code(String),
    /// What it shows, and its file as the page sees it.
    Picture(String, String),
}

/// A dollar that is no mark: a letter of private use, which no text has.
pub(super) const DOLLAR: &str = "\u{E000}";

/// Where a page is read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    Terminal,
    Markdown,
    Latex,
}

/// A page under its title. `link` leads to the text of the law.
pub(super) fn page(form: Form, title: &str, link: Option<&str>, parts: &[Part]) -> String {
    let show = match form {
        Form::Terminal => terminal,
        Form::Markdown => markdown,
        Form::Latex => latex,
    };
    let mut text = match form {
        Form::Terminal => format!("{title}\n"),
        Form::Markdown => format!("# {title}\n"),
        Form::Latex => format!(
            "% \\usepackage{{amsmath,array}}\n\\section*{{{}}}\n\\begingroup\\sloppy\n",
            symbols::prose(title)
        ),
    };
    if let (Form::Markdown, Some(link)) = (form, link) {
        let file = link.rsplit('/').next().unwrap_or(link);
        text += &format!("\nGenerated from [{file}]({link}).\n");
    }
    for part in parts {
        text += &show(part);
    }
    if form == Form::Latex {
        text += "\n\\endgroup\n";
    }
    let dollar = if form == Form::Terminal { "$" } else { "\\$" };
    text.replace(DOLLAR, dollar)
}

fn markdown(part: &Part) -> String {
    match part {
        Part::Heading(heading) => format!("\n## {heading}\n"),
        Part::Text(words) => format!("\n{words}\n"),
        Part::Equation(before, formula) if before.is_empty() => {
            format!("\n```math\n{formula}\n```\n")
        }
        Part::Equation(before, formula) => format!("\n{before}\n\n```math\n{formula}\n```\n"),
        Part::Table(columns, rows) => {
            // A bar ends a cell, but in a formula none is written so.
            let cell = |cell: &String| cell.replace('|', "\\|");
            let row = |cells: &[String]| {
                let cells: Vec<String> = cells.iter().map(cell).collect();
                format!("| {} |\n", cells.join(" | "))
            };
            let head: Vec<String> = columns.iter().map(|c| c.to_string()).collect();
            let rule = vec!["---".to_string(); columns.len()];
            let rows: String = rows.iter().map(|r| row(r)).collect();
            format!("\n{}{}{rows}", row(&head), row(&rule))
        }
        Part::Code(text) => format!("\n```pd\n{text}\n```\n"),
        Part::Picture(what, path) => format!("\n![{what}]({path})\n"),
    }
}

fn latex(part: &Part) -> String {
    match part {
        Part::Heading(heading) => format!("\n\\subsection*{{{}}}\n", symbols::prose(heading)),
        Part::Text(words) => format!("\n{}\n", words_in_latex(words)),
        Part::Equation(before, formula) => {
            format!(
                "\n{}\n{}\n",
                words_in_latex(before),
                broken::display(formula)
            )
        }
        Part::Table(columns, all) => {
            let row = |cells: Vec<String>| {
                let cells: Vec<String> = cells.iter().map(|c| words_in_latex(c)).collect();
                format!("{} \\\\\n", cells.join(" & "))
            };
            let head = row(columns.iter().map(|c| c.to_string()).collect());
            let rows: String = all.iter().map(|r| row(r.clone())).collect();
            let layout = layout(columns, all);
            format!(
                "\n{{\\small\n\\noindent\\begin{{tabular}}{{{layout}}}\n{head}\\hline\n{rows}\\end{{tabular}}}}\n"
            )
        }
        Part::Code(text) => {
            // What would end the text early is a letter apart.
            let text = text.replace("\\end{verbatim}", "\\end {verbatim}");
            let longest = text.lines().map(|l| l.chars().count()).max().unwrap_or(0);
            let size = match longest {
                0..=64 => "normalsize",
                65..=80 => "footnotesize",
                81..=92 => "scriptsize",
                _ => "tiny",
            };
            format!("\n{{\\{size}\n\\begin{{verbatim}}\n{text}\n\\end{{verbatim}}\n}}\n")
        }
        // LaTeX reads no SVG without a package: the file is named.
        Part::Picture(what, path) => {
            let (what, path) = (symbols::prose(what), symbols::prose(path));
            format!("\n{what}: \\texttt{{{path}}}\n")
        }
    }
}

/// Letters of a line of a table in LaTeX, and of the space between two columns.
const TABLE: (usize, usize) = (72, 3);

/// Columns as wide as what they hold; where that is too much for a line, each gets its share and breaks its words.
fn layout(columns: &[&str], rows: &[Vec<String>]) -> String {
    let longest = |(k, head): (usize, &&str)| {
        let words = |text: &str| text.split(' ').map(str::len).max().unwrap_or(0);
        let cells = rows.iter().filter_map(|row| row.get(k));
        let most = cells.clone().map(|c| c.chars().count()).max().unwrap_or(0);
        let word = cells.map(|c| words(c)).max().unwrap_or(0);
        (most.max(head.len()), word.max(words(head)))
    };
    let widths: Vec<(usize, usize)> = columns.iter().enumerate().map(longest).collect();
    let all: usize = widths.iter().map(|(most, _)| most + TABLE.1).sum();
    if all <= TABLE.0 {
        return "l".repeat(columns.len());
    }
    // Every column has room for its longest word, the rest is shared.
    let need = |(most, word): &(usize, usize)| (*word).min(24) as f64 + (*most as f64).sqrt();
    let needed: f64 = widths.iter().map(need).sum();
    let room = 1.0 - 0.04 * columns.len() as f64;
    let column = |w| {
        format!(
            ">{{\\raggedright\\arraybackslash}}p{{{:.3}\\linewidth}}",
            room * need(w) / needed
        )
    };
    widths.iter().map(column).collect()
}

/// `code` becomes typewriter; formulas stay, and so do the words of links.
fn words_in_latex(words: &str) -> String {
    let words = unlinked(words);
    let code = |(k, part): (usize, &str)| match k % 2 {
        0 => formulas_kept(part),
        _ => format!("\\texttt{{{}}}", symbols::prose(part)),
    };
    words.split('`').enumerate().map(code).collect()
}

fn formulas_kept(words: &str) -> String {
    let part = |(k, part): (usize, &str)| match k % 2 {
        0 => symbols::prose(part),
        _ => format!("${part}$"),
    };
    words.split('$').enumerate().map(part).collect()
}

/// `[words](path)` is `words`.
fn unlinked(words: &str) -> String {
    let mut text = String::new();
    let mut rest = words;
    while let Some((before, after)) = rest.split_once("](") {
        let (Some((head, shown)), Some((_, behind))) =
            (before.rsplit_once('['), after.split_once(')'))
        else {
            break;
        };
        text += head;
        text += shown;
        rest = behind;
    }
    text + rest
}

/// Letters of a line in a terminal.
const WIDTH: usize = 100;

fn terminal(part: &Part) -> String {
    let bare = |words: &str| unlinked(words).replace(['$', '`'], "");
    match part {
        Part::Heading(heading) => format!("\n{heading}\n"),
        Part::Text(words) => format!("\n{}", wrapped(&bare(words), 2)),
        Part::Equation(before, formula) if before.is_empty() => {
            format!("\n{}", wrapped(formula, 4))
        }
        Part::Equation(before, formula) => {
            format!("\n{}{}", wrapped(&bare(before), 2), wrapped(formula, 4))
        }
        Part::Table(columns, rows) => {
            let head: Vec<String> = columns.iter().map(|c| c.to_string()).collect();
            let rows = rows.iter().map(|row| row.iter().map(|c| bare(c)).collect());
            let all: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
            let length = |cell: &String| cell.chars().count();
            let widths: Vec<usize> = (0..columns.len())
                .map(|k| {
                    all.iter()
                        .filter_map(|row| row.get(k))
                        .map(length)
                        .max()
                        .unwrap_or(0)
                })
                .collect();
            let mut text = String::from("\n");
            for row in &all {
                let cells: Vec<String> = row
                    .iter()
                    .zip(&widths)
                    .map(|(cell, w)| format!("{cell:<w$}"))
                    .collect();
                text += &format!("  {}\n", cells.join("  ").trim_end());
            }
            text
        }
        Part::Code(text) => {
            let line = |l: &str| format!("  {l}").trim_end().to_string() + "\n";
            format!("\n{}", text.lines().map(line).collect::<String>())
        }
        Part::Picture(what, path) => format!("\n{}", wrapped(&format!("{what}: {path}"), 2)),
    }
}

/// Words on lines of the terminal; what is long goes on below, deeper.
fn wrapped(words: &str, indent: usize) -> String {
    let mut text = String::new();
    let mut line = " ".repeat(indent);
    let mut started = false;
    for word in words.split_whitespace() {
        if started && line.chars().count() + 1 + word.chars().count() > WIDTH {
            text += &format!("{line}\n");
            line = " ".repeat(indent + if indent > 2 { 4 } else { 0 });
            started = false;
        }
        if started {
            line.push(' ');
        }
        line += word;
        started = true;
    }
    text + &line + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_its_words_where_there_are_no_links() {
        let part = Part::Text("[`lps`](lps.md) at $\\nu$ of 100 %".into());
        assert_eq!(latex(&part), "\n\\texttt{lps} at $\\nu$ of 100 \\%\n");
        assert_eq!(terminal(&part), "\n  lps at \\nu of 100 %\n");
        assert_eq!(unlinked("a [b] (c)"), "a [b] (c)");
    }
}
