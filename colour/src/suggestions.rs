//! Suggestions for misspelt names.

use strsim::levenshtein;

/// The most names that are suggested.
const MAX_SUGGESTIONS: usize = 3;

/// Returns those of `names` that resemble `misspelt`, best match first.
pub(crate) fn suggestions<'a>(
    misspelt: &str,
    names: impl Iterator<Item = &'a str>,
) -> Vec<&'a str> {
    let wanted = normalized(misspelt);
    let mut scored: Vec<(usize, &str)> = names
        .filter_map(|name| Some((score(&wanted, &normalized(name))?, name)))
        .collect();
    scored.sort();
    scored.dedup_by_key(|(_, name)| *name);
    scored
        .into_iter()
        .take(MAX_SUGGESTIONS)
        .map(|(_, name)| name)
        .collect()
}

/// Keeps letters and digits only, in lower case.
fn normalized(name: &str) -> String {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// Returns a distance between normalized names, or nothing if they differ too much. Names of which one contains the
/// other score better than any with edits.
fn score(wanted: &str, name: &str) -> Option<usize> {
    if wanted.is_empty() || name.is_empty() {
        return None;
    }
    let (name_length, wanted_length) = (name.chars().count(), wanted.chars().count());
    if name.contains(wanted) || wanted.contains(name) {
        return Some(name_length.abs_diff(wanted_length) / 4);
    }
    let distance = levenshtein(wanted, name);
    (distance * 2 <= wanted_length.max(name_length)).then_some(2 + distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typos_and_partial_names_find_the_right_name() {
        let names = ["ACEScg", "ACEScct", "ARRI LogC4", "S-Log3 S-Gamut3", "Raw"];
        let suggest = |misspelt| suggestions(misspelt, names.into_iter());
        assert_eq!(suggest("acescgg")[0], "ACEScg");
        assert_eq!(suggest("logc4"), ["ARRI LogC4"]);
        assert_eq!(suggest("slog3"), ["S-Log3 S-Gamut3"]);
        assert_eq!(suggest("ARRI LogC5")[0], "ARRI LogC4");
        assert!(suggest("zzzzzzzz").is_empty());
        assert!(suggest("").is_empty());
    }
}
