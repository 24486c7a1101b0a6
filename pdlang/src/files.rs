//! Files that a text uses. The library reads none: who calls it says what stands in a file.

/// The text of the file at a path, or why there is none. Paths are as [`beside`] forms them.
pub type Files<'f> = dyn FnMut(&str) -> Result<String, String> + 'f;

/// Where there are no files.
///
/// # Errors
/// Always.
pub fn nowhere(_: &str) -> Result<String, String> {
    Err("a text without a file uses no files".into())
}

/// The path of a file that the file at `from` calls `path`: relative to its folder, `.` and `..` resolved.
pub fn beside(from: &str, path: &str) -> String {
    let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
    let absolute = path.starts_with('/') || from.starts_with('/');
    let mut parts: Vec<&str> = Vec::new();
    let whole = if path.starts_with('/') { "" } else { folder };
    for part in whole.split('/').chain(path.split('/')) {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => drop(parts.pop()),
            ".." if absolute => {}
            part => parts.push(part),
        }
    }
    let root = if absolute { "/" } else { "" };
    format!("{root}{}", parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::beside;

    #[test]
    fn paths_start_at_the_folder_of_the_file() {
        for (from, path, found) in [
            ("", "a.pd", "a.pd"),
            ("laws/lps.pd", "a.pd", "laws/a.pd"),
            ("laws/lps.pd", "./b/../a.pd", "laws/a.pd"),
            ("laws/lps.pd", "../a.pd", "a.pd"),
            ("laws/lps.pd", "../../a.pd", "../a.pd"),
            ("/r/laws/lps.pd", "../a.pd", "/r/a.pd"),
            ("/r/lps.pd", "../../a.pd", "/a.pd"),
            ("laws/lps.pd", "/a.pd", "/a.pd"),
        ] {
            assert_eq!(beside(from, path), found, "{path} beside {from}");
        }
    }
}
