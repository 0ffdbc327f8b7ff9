//! Names near a name that is none.

use strsim::levenshtein;

/// How many are proposed.
const MOST: usize = 3;

/// Those of `names` that `asked` may have meant, the likeliest first.
pub(crate) fn nearest<'a>(asked: &str, names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = plain(asked);
    let mut scored: Vec<(usize, &str)> = names
        .filter_map(|name| Some((score(&wanted, &plain(name))?, name)))
        .collect();
    scored.sort();
    scored.dedup_by_key(|(_, name)| *name);
    scored
        .into_iter()
        .take(MOST)
        .map(|(_, name)| name)
        .collect()
}

/// Letters and digits alone, small: what people remember of a name.
fn plain(name: &str) -> String {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// How far `name` is from what was asked, where it is near at all: what it contains is nearer than what it resembles.
fn score(wanted: &str, name: &str) -> Option<usize> {
    if wanted.is_empty() || name.is_empty() {
        return None;
    }
    let (long, asked) = (name.chars().count(), wanted.chars().count());
    if name.contains(wanted) || wanted.contains(name) {
        return Some(long.abs_diff(asked) / 4);
    }
    let distance = levenshtein(wanted, name);
    (distance * 2 <= asked.max(long)).then_some(2 + distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_hand_and_memory_are_understood() {
        let names = ["ACEScg", "ACEScct", "ARRI LogC4", "S-Log3 S-Gamut3", "Raw"];
        let near = |asked| nearest(asked, names.into_iter());
        assert_eq!(near("acescgg")[0], "ACEScg");
        assert_eq!(near("logc4"), ["ARRI LogC4"]);
        assert_eq!(near("slog3"), ["S-Log3 S-Gamut3"]);
        assert_eq!(near("ARRI LogC5")[0], "ARRI LogC4");
        assert!(near("zzzzzzzz").is_empty());
        assert!(near("").is_empty());
    }
}
