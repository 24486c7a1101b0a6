//! TOML text as a tree that knows where every key and value stands. The only file that names the parser.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::problem::Problem;

/// A value and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    pub span: Range<usize>,
    pub data: Data,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    Text(String),
    /// Finite. The flag says whether it was written as an integer.
    Number(f64, bool),
    Flag(bool),
    List(Vec<Value>),
    /// In the order of the text.
    Table(Vec<Entry>),
    /// Something that has been complained about, or that no scene uses (a date).
    Unusable(&'static str),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub key: String,
    pub key_span: Range<usize>,
    pub value: Value,
}

impl Value {
    /// What a user would call it.
    pub fn kind(&self) -> &'static str {
        match &self.data {
            Data::Text(_) => "a text",
            Data::Number(..) => "a number",
            Data::Flag(_) => "true or false",
            Data::List(_) => "a list",
            Data::Table(_) => "a table",
            Data::Unusable(kind) => kind,
        }
    }
}

/// Parses `text`; whatever could be understood is in the tree even when there are problems.
pub fn parse(text: &str) -> (Vec<Entry>, Vec<Problem>) {
    let (document, errors) = DeTable::parse_recoverable(text);
    let mut problems: Vec<Problem> = errors.iter().map(|e| syntax_problem(text, e)).collect();
    let entries = entries(document.get_ref(), &mut problems);
    (entries, problems)
}

fn syntax_problem(text: &str, error: &toml::de::Error) -> Problem {
    let span = error.span().unwrap_or(text.len()..text.len());
    Problem::new(format!("not valid TOML: {}", error.message())).at(span, "")
}

fn entries(table: &DeTable<'_>, problems: &mut Vec<Problem>) -> Vec<Entry> {
    let mut list: Vec<Entry> = table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            key_span: key.span(),
            value: convert(value, problems),
        })
        .collect();
    list.sort_by_key(|e| e.key_span.start);
    list
}

fn convert(value: &Spanned<DeValue<'_>>, problems: &mut Vec<Problem>) -> Value {
    let span = value.span();
    let data = match value.get_ref() {
        DeValue::String(s) => Data::Text(s.to_string()),
        DeValue::Boolean(b) => Data::Flag(*b),
        DeValue::Integer(i) => integer(i.as_str(), i.radix(), &span, problems),
        DeValue::Float(f) => float(f.as_str(), &span, problems),
        DeValue::Datetime(_) => Data::Unusable("a date"),
        DeValue::Array(a) => Data::List(a.iter().map(|v| convert(v, problems)).collect()),
        DeValue::Table(t) => Data::Table(entries(t, problems)),
    };
    Value { span, data }
}

fn integer(digits: &str, radix: u32, span: &Range<usize>, problems: &mut Vec<Problem>) -> Data {
    let plain = digits.replace('_', "");
    match i64::from_str_radix(&plain, radix) {
        Ok(i) => Data::Number(i as f64, true),
        // Larger than 64 bits is still a fine length or modulus.
        Err(_) if radix == 10 => float(&plain, span, problems),
        Err(_) => complain(span, problems),
    }
}

fn float(digits: &str, span: &Range<usize>, problems: &mut Vec<Problem>) -> Data {
    match digits.replace('_', "").parse::<f64>() {
        Ok(f) if f.is_finite() => Data::Number(f, false),
        _ => complain(span, problems),
    }
}

fn complain(span: &Range<usize>, problems: &mut Vec<Problem>) -> Data {
    problems.push(
        Problem::new("a number in a scene must be finite")
            .at(span.clone(), "not a finite number")
            .help("give a finite number, or leave the key out to take its default"),
    );
    Data::Unusable("not a finite number")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_values_know_their_places() {
        let (entries, problems) = parse("b = 1\na = [\"x\", 2.5]\n");
        assert_eq!(problems, []);
        assert_eq!(entries[0].key, "b");
        assert_eq!(entries[1].key_span, 6..7);
        let Data::List(list) = &entries[1].value.data else {
            panic!("a list")
        };
        assert_eq!(
            list[1],
            Value {
                span: 16..19,
                data: Data::Number(2.5, false)
            }
        );
    }

    #[test]
    fn not_a_number_is_a_problem_with_a_place() {
        let (_, problems) = parse("a = nan\nb = inf\n");
        assert_eq!(problems.len(), 2);
        assert_eq!(problems[0].labels[0].0, 4..7);
    }

    #[test]
    fn broken_text_gives_problems_and_keeps_the_rest() {
        let (entries, problems) = parse("a = \nb = 2\n[c\n");
        assert!(!problems.is_empty());
        assert!(entries.iter().any(|e| e.key == "b"));
    }

    #[test]
    fn no_text_panics() {
        for text in [
            "",
            "\u{0}",
            "[[",
            "a.b.c = {x = [1,",
            "é = 1",
            "a = 99999999999999999999999",
            "a=0xfffffffffffffffffffff",
        ] {
            parse(text);
        }
    }
}
