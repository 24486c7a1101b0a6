//! "Did you mean": the known word nearest to an unknown one.

/// The nearest candidate, if one is near enough to be meant.
pub(crate) fn nearest<S: AsRef<str>>(
    word: &str,
    candidates: impl IntoIterator<Item = S>,
) -> Option<String> {
    // A word of two letters is close to every other one: only its case may differ.
    let limit = match word.chars().count() {
        0..=2 => 0,
        letters => (letters / 3).max(1),
    };
    let mut best: Option<(usize, String)> = None;
    for candidate in candidates {
        let candidate = candidate.as_ref();
        let distance = distance(word, candidate);
        if candidate != word
            && distance <= limit
            && best.as_ref().is_none_or(|(least, _)| distance < *least)
        {
            best = Some((distance, candidate.to_string()));
        }
    }
    best.map(|(_, name)| name)
}

/// Letters to change; a difference in case counts as none.
fn distance(a: &str, b: &str) -> usize {
    strsim::damerau_levenshtein(&a.to_lowercase(), &b.to_lowercase())
}

/// "did you mean `stretch`?", if there is something to mean.
pub(crate) fn question<S: AsRef<str>>(
    word: &str,
    candidates: impl IntoIterator<Item = S>,
) -> Option<String> {
    nearest(word, candidates).map(|name| format!("did you mean `{name}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_was_meant() {
        assert_eq!(nearest("thetta", ["theta", "m", "e"]), Some("theta".into()));
        assert_eq!(nearest("GPA", ["Pa", "GPa"]), Some("GPa".into()));
        assert_eq!(nearest("volume", ["theta", "m", "e"]), None);
        assert_eq!(nearest("q", ["Q", "theta"]), Some("Q".into()));
    }
}
