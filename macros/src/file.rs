//! `include_model!("a.pd", "b.pd")`: files become items.

use crate::{kinematics, report};
use pdlang::assemble::Kinematics;
use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use std::path::PathBuf;
use syn::punctuated::Punctuated;
use syn::{LitStr, Token};

/// The items of all files, or the error of an argument that is not a path.
pub fn include(paths: TokenStream) -> syn::Result<TokenStream> {
    let (kinematics, paths) = kinematics::taken_off(paths);
    let paths =
        syn::parse::Parser::parse2(Punctuated::<LitStr, Token![,]>::parse_terminated, paths)?;
    Ok(paths
        .iter()
        .map(|path| one(path, kinematics).unwrap_or_else(syn::Error::into_compile_error))
        .collect())
}

fn one(literal: &LitStr, kinematics: Kinematics) -> syn::Result<TokenStream> {
    let path = literal.value();
    let text = read(&path).map_err(|why| syn::Error::new(literal.span(), why))?;
    let mut used = Vec::new();
    let mut files = |path: &str| {
        used.push(path.to_string());
        read(path)
    };
    let items = report::expand(&text, &path, &mut files, kinematics, |diagnostic| {
        let snippet = diagnostic.render(&text, &path, false);
        report::Report {
            message: report::plain(&snippet),
            first: literal.span(),
            last: literal.span(),
        }
    });
    // Naming the file in an `include_bytes!` is what makes cargo build again when it changes.
    let watch = |path: &str| {
        let literal = LitStr::new(path, literal.span());
        quote_spanned!(literal.span()=> const _: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/", #literal));)
    };
    let used: TokenStream = used
        .iter()
        .filter(|path| read(path).is_ok())
        .map(|path| watch(path))
        .collect();
    let watch = watch(&path);
    Ok(quote!(#watch #used #items))
}

fn read(path: &str) -> Result<String, String> {
    let folder = std::env::var_os("CARGO_MANIFEST_DIR")
        .map(PathBuf::from)
        .unwrap_or_default();
    std::fs::read_to_string(folder.join(path)).map_err(|why| {
        format!("cannot read `{path}`: {why}; paths start at the folder of the crate's Cargo.toml")
    })
}
