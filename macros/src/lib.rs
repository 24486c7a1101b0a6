//! The doorway from Rust to the language.
