pdlang_macros::include_model!("laws/nowhere.pd");

fn main() {}
