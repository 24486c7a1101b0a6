//! The canonical form of a text: one item per line, two blanks per level, what belongs together in columns.
//!
//! Contract. Only white space between tokens changes, so that the text means what it meant; every comment is
//! kept, at the end of its line or above what follows. Formatting a formatted text changes nothing. Lines are
//! broken inside of an item, and blanks stand around `*`, `/`, `+` and `-`, where the author wants them.

mod columns;
mod lines;
mod pieces;

use crate::diag::Diagnostic;
use crate::parse;

/// The canonical form of a text.
///
/// # Errors
/// The findings of a text that cannot be read.
pub fn format(text: &str) -> Result<String, Vec<Diagnostic>> {
    let mut report = Vec::new();
    parse::file(text, false, &mut report);
    if !report.is_empty() {
        return Err(report);
    }
    let pieces = pieces::of(text, &parse::tokens(text));
    Ok(columns::align(lines::of(&pieces)))
}

#[cfg(test)]
mod tests;
