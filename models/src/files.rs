//! The files that a law uses, from the disk.

/// The text of a file, or why there is none; for [`pdlang::files::Files`].
///
/// # Errors
/// When the file cannot be read.
pub fn read(path: &str) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| error.to_string())
}
