//! Names near a name that is none.

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
fn plain(name: &str) -> Vec<char> {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// How far `name` is from what was asked, where it is near at all: what it contains is nearer than what it resembles.
fn score(wanted: &[char], name: &[char]) -> Option<usize> {
    if wanted.is_empty() || name.is_empty() {
        return None;
    }
    let contains = |long: &[char], short: &[char]| long.windows(short.len()).any(|w| w == short);
    if contains(name, wanted) || contains(wanted, name) {
        return Some(name.len().abs_diff(wanted.len()) / 4);
    }
    let distance = distance(wanted, name);
    (distance * 2 <= wanted.len().max(name.len())).then_some(2 + distance)
}

/// Letters to change, add or leave out.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let above = row[j + 1];
            let change = corner + usize::from(x != y);
            row[j + 1] = change.min(above + 1).min(row[j] + 1);
            corner = above;
        }
    }
    row[b.len()]
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

    #[test]
    fn distances_are_those_of_levenshtein() {
        let of = |a: &str, b: &str| {
            let chars = |t: &str| t.chars().collect::<Vec<_>>();
            distance(&chars(a), &chars(b))
        };
        assert_eq!(of("kitten", "sitting"), 3);
        assert_eq!(of("", "abc"), 3);
        assert_eq!(of("abc", "abc"), 0);
    }
}
