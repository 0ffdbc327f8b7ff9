//! Mutations of text: numbers, lines, words and control characters.

use crate::rng::Rng;

/// Numbers that break arithmetic and parsers.
pub(crate) const NUMBERS: [&str; 36] = [
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-320",
    "5e-324",
    "1e-30",
    "1e-9",
    "1e9",
    "1e15",
    "1e20",
    "1e30",
    "3.4e38",
    "3.5e38",
    "1e300",
    "1e308",
    "1.8e308",
    "-1e308",
    "1e999",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "Infinity",
    "2147483647",
    "-2147483648",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "99999999999999999999999999",
    "0x10",
    "1_000",
    "1,5",
];

/// Characters that terminals, parsers and shells treat specially.
const CONTROLS: [&str; 18] = [
    "\0",
    "\u{1b}[2J",
    "\u{1b}]0;x\u{7}",
    "\r",
    "\n",
    "\t",
    "\u{7f}",
    "\u{85}",
    "\u{feff}",
    "\u{202e}",
    "\u{2028}",
    "\"",
    "'",
    "\\",
    "{",
    "[",
    "%s",
    "\u{fffd}",
];

/// Replaces a number.
pub(crate) fn replace_number(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let is_part = |b: u8| b.is_ascii_digit() || b".-+".contains(&b);
    let starts: Vec<usize> = (0..bytes.len())
        .filter(|&k| bytes[k].is_ascii_digit() && (k == 0 || !is_part(bytes[k - 1])))
        .collect();
    if starts.is_empty() {
        return;
    }
    let start = *rng.pick(&starts);
    let rest = &bytes[start..];
    let is_inner = |b: &u8| b.is_ascii_digit() || b".eE".contains(b);
    let length = rest.iter().take_while(|b| is_inner(b)).count();
    let number = rng.pick(&NUMBERS).bytes();
    bytes.splice(start..start + length, number);
}

/// Repeats a line, a few times or many.
pub(crate) fn repeat_line(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let line = line(bytes, rng);
    let copy = bytes[line.clone()].to_vec();
    let count = if rng.once_in(20) {
        2000
    } else {
        1 + rng.below(3)
    };
    let at = line.end;
    bytes.splice(at..at, copy.repeat(count));
}

/// Removes a line.
pub(crate) fn drop_line(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let line = line(bytes, rng);
    bytes.drain(line);
}

/// Moves a line to another place.
pub(crate) fn swap_lines(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let from = line(bytes, rng);
    let moved: Vec<u8> = bytes.drain(from).collect();
    let at = line(bytes, rng).start;
    bytes.splice(at..at, moved);
}

/// Inserts a special character.
pub(crate) fn insert_control(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let at = rng.below(bytes.len() + 1);
    let text = rng.pick(&CONTROLS).bytes();
    bytes.splice(at..at, text);
}

/// Makes a word very long.
pub(crate) fn lengthen(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let at = rng.below(bytes.len() + 1);
    let unit = *rng.pick(&[&b"a"[..], b"9", b" ", b"0", b"\xc3\xa9", b"("]);
    let count = *rng.pick(&[100, 300, 5000, 70_000]);
    bytes.splice(at..at, unit.repeat(count));
}

/// Replaces a word by another word of the text, or by a changed one.
pub(crate) fn rename(bytes: &mut Vec<u8>, rng: &mut Rng, other: &[u8]) {
    let Some(to) = word(other, rng).map(|range| other[range].to_vec()) else {
        return;
    };
    if let Some(range) = word(bytes, rng) {
        bytes.splice(range, to);
    }
}

/// Inserts brackets, up to tens of thousands.
pub(crate) fn nest(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let unit = *rng.pick(&[
        "[",
        "{",
        "(",
        "- ",
        "  ",
        "{a: ",
        "[[",
        "&a [*a, ",
        "!<ColorSpace> {",
    ]);
    let count = *rng.pick(&[1, 3, 60, 200, 20_000]);
    let at = rng.below(bytes.len() + 1);
    bytes.splice(at..at, unit.repeat(count).into_bytes());
}

/// Inserts lines of another seed.
pub(crate) fn splice_lines(bytes: &mut Vec<u8>, rng: &mut Rng, other: &[u8]) {
    let from = line(other, rng);
    let at = line(bytes, rng).start;
    bytes.splice(at..at, other[from].to_vec());
}

/// Picks a line with its line break.
fn line(bytes: &[u8], rng: &mut Rng) -> std::ops::Range<usize> {
    let at = rng.below(bytes.len());
    let before = bytes[..at].iter().rposition(|&b| b == b'\n');
    let start = before.map_or(0, |k| k + 1);
    let after = bytes[start..].iter().position(|&b| b == b'\n');
    start..after.map_or(bytes.len(), |k| start + k + 1)
}

/// Picks a word.
fn word(bytes: &[u8], rng: &mut Rng) -> Option<std::ops::Range<usize>> {
    let is_part = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
    let at = rng.below(bytes.len());
    let start = at + bytes[at..].iter().position(is_part)?;
    let length = bytes[start..].iter().take_while(|b| is_part(b)).count();
    Some(start..start + length)
}
