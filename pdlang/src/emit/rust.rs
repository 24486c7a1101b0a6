//! Generated Rust as a page.
//!
//! Contract. The same tokens that a macro expands to, laid out a statement per line; only the law as data is
//! shortened, which `passes` prints. It knows the generated code, not all of Rust: `<` opens generics.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// Longest body in braces that stays on its line.
const SHORT: usize = 60;
/// Longest literal that is printed whole.
const LITERAL: usize = 120;

pub(super) fn page(tokens: TokenStream) -> String {
    let mut page = Page::default();
    page.block(tokens, 0);
    page.out
}

#[derive(Default)]
struct Page {
    out: String,
    line: String,
}

impl Page {
    fn end(&mut self, depth: usize) {
        if !self.line.trim().is_empty() {
            self.out.push_str(&"    ".repeat(depth));
            self.out.push_str(self.line.trim());
            self.out.push('\n');
        }
        self.line.clear();
    }

    /// Items or statements, or what a comma ends.
    fn block(&mut self, tokens: TokenStream, depth: usize) {
        let trees: Vec<TokenTree> = tokens.into_iter().collect();
        let listed = !trees.iter().any(|t| is(t, ';')) && trees.iter().any(|t| is(t, ','));
        let mut k = 0;
        while k < trees.len() {
            let (tree, next) = (&trees[k], trees.get(k + 1));
            k += 1;
            match (tree, next) {
                (TokenTree::Punct(p), Some(TokenTree::Group(g))) if p.as_char() == '#' => {
                    let remark = remark(g.stream());
                    if remark.is_some() && self.out.ends_with("}\n") {
                        self.out.push('\n');
                    }
                    self.line = remark.unwrap_or_else(|| format!("#[{}]", flat(g.stream())));
                    self.end(depth);
                    k += 1;
                }
                (TokenTree::Group(g), _) if g.delimiter() == Delimiter::Brace => {
                    let inside = flat(g.stream());
                    if inside.len() <= SHORT && !inside.contains(';') {
                        push(&mut self.line, &braced(&inside));
                    } else {
                        push(&mut self.line, "{");
                        self.end(depth);
                        self.block(g.stream(), depth + 1);
                        self.line.push('}');
                    }
                    let goes_on = next.is_some_and(|t| is(t, ';') || is(t, ','));
                    if !goes_on {
                        self.end(depth);
                    }
                }
                _ => {
                    push_tree(&mut self.line, tree);
                    if is(tree, ';') || listed && is(tree, ',') {
                        self.end(depth);
                    }
                }
            }
        }
        self.end(depth);
    }
}

fn is(tree: &TokenTree, sign: char) -> bool {
    matches!(tree, TokenTree::Punct(p) if p.as_char() == sign)
}

/// `doc = "text"` as a comment.
fn remark(attribute: TokenStream) -> Option<String> {
    let mut trees = attribute.into_iter();
    match (trees.next()?, trees.next()?, trees.next()?) {
        (TokenTree::Ident(word), TokenTree::Punct(_), TokenTree::Literal(text))
            if word == "doc" =>
        {
            let text = text.to_string();
            let text = text.strip_prefix('"')?.strip_suffix('"')?.to_string();
            Some(
                format!("/// {}", text.trim())
                    .replace("\\'", "'")
                    .replace("\\\"", "\""),
            )
        }
        _ => None,
    }
}

fn braced(inside: &str) -> String {
    match inside.is_empty() {
        true => "{}".into(),
        false => format!("{{ {inside} }}"),
    }
}

/// Tokens on one line.
fn flat(tokens: TokenStream) -> String {
    let mut line = String::new();
    for tree in tokens {
        push_tree(&mut line, &tree);
    }
    line.trim().into()
}

fn push_tree(line: &mut String, tree: &TokenTree) {
    match tree {
        TokenTree::Group(g) => {
            let inside = flat(g.stream());
            match g.delimiter() {
                Delimiter::Parenthesis => push(line, &format!("({inside})")),
                Delimiter::Bracket => push(line, &format!("[{inside}]")),
                Delimiter::Brace => push(line, &braced(&inside)),
                Delimiter::None => push(line, &inside),
            }
        }
        TokenTree::Punct(p) => match (p.as_char(), p.spacing()) {
            (',' | ';', _) => {
                line.truncate(line.trim_end().len());
                line.push(p.as_char());
                line.push(' ');
            }
            (':', Spacing::Alone) if !line.ends_with(':') => line.push_str(": "),
            // The first half of `->` or `=>`.
            ('-' | '=', Spacing::Joint) => {
                line.truncate(line.trim_end().len());
                line.push(' ');
                line.push(p.as_char());
            }
            ('>', _) if line.ends_with(" -") || line.ends_with(" =") => line.push_str("> "),
            ('=' | '+', _) => {
                line.truncate(line.trim_end().len());
                line.push_str(&format!(" {} ", p.as_char()));
            }
            ('&', _) => push(line, "&"),
            (':' | '<' | '>' | '.' | '!' | '-' | '#', _) | (_, _) => line.push(p.as_char()),
        },
        TokenTree::Literal(text) => push(line, &shortened(&text.to_string())),
        TokenTree::Ident(word) if word == "use" => push(line, "use "),
        TokenTree::Ident(word) => push(line, &word.to_string()),
    }
}

/// A word, with a space before it where one is needed.
fn push(line: &mut String, word: &str) {
    let last = line.chars().next_back();
    let opens = |c: char| c.is_alphanumeric() || matches!(c, '_' | '{' | '&' | '[');
    let apart = match last {
        Some(c) if c.is_alphanumeric() || c == '_' => {
            word.starts_with(|c: char| c.is_alphanumeric() || c == '_' || c == '{')
                || line.ends_with("mut")
        }
        Some('>' | ')' | ']' | '}') => word.starts_with(|c| opens(c) && c != '['),
        _ => false,
    };
    if apart {
        line.push(' ');
    }
    line.push_str(word);
}

fn shortened(literal: &str) -> String {
    match literal.len() > LITERAL {
        true => format!("\"the law as data, {} bytes of JSON\"", literal.len()),
        false => literal.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statement_per_line() {
        let code = quote::quote! {
            use ::a::{B, C};
            fn g() { [] }
            #[doc = " Its use."]
            #[inline(always)]
            pub fn f<L: Lane>(&self, x: &mut [L; 2]) -> [L; 1] {
                let a = L::add(x[0], b.c(1));
                match k { 0 => a, _ => L::splat(-0.5), }
            }
            pub const K: ::a::B = ::a::B { dim: 3, sweeps: &[(0, ::a::f!(rare G, 3))], rest: "xxxxxxxxxxxxxxxxxxx" };
        };
        let expected = "\
use ::a::{ B, C };
fn g() { [] }

/// Its use.
#[inline(always)]
pub fn f<L: Lane>(&self, x: &mut [L; 2]) -> [L; 1] {
    let a = L::add(x[0], b.c(1));
    match k { 0 => a, _ => L::splat(-0.5), }
}
pub const K: ::a::B = ::a::B {
    dim: 3,
    sweeps: &[(0, ::a::f!(rare G, 3))],
    rest: \"xxxxxxxxxxxxxxxxxxx\"
};
";
        assert_eq!(page(code), expected);
    }
}
