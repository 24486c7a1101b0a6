//! The word `linearised` in front of what a macro is given.

use pdlang::assemble::Kinematics;
use proc_macro2::{TokenStream, TokenTree};

/// What the first word asks for, and the tokens behind it.
pub fn taken_off(tokens: TokenStream) -> (Kinematics, TokenStream) {
    let mut rest = tokens.clone().into_iter();
    match rest.next() {
        Some(TokenTree::Ident(word)) if word == "linearised" => {
            (Kinematics::Linearised, rest.collect())
        }
        _ => (Kinematics::General, tokens),
    }
}
