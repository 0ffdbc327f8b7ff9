//! Frame sequences: path patterns such as `plate.%04d.exr` or `plate.####.exr`, and frame lists.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use crate::error::{FileError, Result};

/// Limit of the frames of a run; more are certainly a mistake.
const MAX_FRAMES: usize = 1_000_000;

/// A path that may contain frame numbers. It need not be Unicode.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FramePattern {
    path: PathBuf,
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Piece {
    Text(OsString),
    /// The frame number, padded with zeros to this many characters.
    Frame(usize),
}

impl FramePattern {
    /// Parses a path. `%d`, `%4d`, `%04d`, and runs of `#` in the name of the file, stand for the frame number, `%%` for a
    /// percent sign. In the names of folders `#` is a letter.
    pub fn parse(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref().to_path_buf();
        let mut pieces = Vec::new();
        push_pieces(path.as_os_str(), &mut pieces);
        Self { path, pieces }
    }

    /// Returns whether the path contains the frame number.
    pub fn has_frame(&self) -> bool {
        self.pieces.iter().any(|p| matches!(p, Piece::Frame(_)))
    }

    /// Returns the path of a frame.
    pub fn path(&self, frame: i64) -> PathBuf {
        let mut path = OsString::new();
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => path.push(text),
                Piece::Frame(width) => {
                    let width = *width;
                    path.push(format!("{frame:0width$}"));
                }
            }
        }
        path.into()
    }

    /// Returns the files that exist for the pattern, in the order of their numbers. A number in the name of a folder finds
    /// nothing.
    pub fn existing(&self) -> Vec<PathBuf> {
        let paths = self.existing_frames().into_iter();
        paths.map(|number| self.path(number)).collect()
    }

    /// Returns the numbers of the files that exist for the pattern, in their order.
    pub fn existing_frames(&self) -> Vec<i64> {
        let folder = match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let numbers = entries.filter_map(|entry| {
            let name = entry.file_name();
            let digits = self.number_text(&name.to_string_lossy())?;
            digits.parse().ok()
        });
        let mut numbers: Vec<i64> = numbers.collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.retain(|number| self.path(*number).is_file());
        numbers
    }

    /// Returns the text at the place of the only frame number in a file name that begins and ends as the pattern.
    fn number_text(&self, name: &str) -> Option<String> {
        let own = self.path.file_name()?.to_str()?;
        let mut pieces = Vec::new();
        push_pieces_of_text(own, 0, &mut pieces);
        let [Piece::Text(start), Piece::Frame(_), Piece::Text(end)] = &pieces[..] else {
            return None;
        };
        let rest = name.strip_prefix(start.to_str()?)?;
        rest.strip_suffix(end.to_str()?).map(str::to_owned)
    }
}

/// Adds the pieces of a path that need not be Unicode.
#[cfg(unix)]
fn push_pieces(path: &OsStr, pieces: &mut Vec<Piece>) {
    use std::os::unix::ffi::OsStrExt;
    let bytes = path.as_bytes();
    let mut name = bytes
        .iter()
        .rposition(|b| *b == b'/')
        .map_or(0, |at| at + 1);
    for chunk in bytes.utf8_chunks() {
        push_pieces_of_text(chunk.valid(), name, pieces);
        name = name.saturating_sub(chunk.valid().len() + chunk.invalid().len());
        pieces.push(Piece::Text(OsStr::from_bytes(chunk.invalid()).to_owned()));
    }
}

/// Adds the pieces of a path. One that is not Unicode has no frame number.
#[cfg(not(unix))]
fn push_pieces(path: &OsStr, pieces: &mut Vec<Piece>) {
    match path.to_str() {
        Some(text) => {
            let name = text.rfind(std::path::is_separator).map_or(0, |at| at + 1);
            push_pieces_of_text(text, name, pieces);
        }
        None => pieces.push(Piece::Text(path.to_owned())),
    }
}

/// Adds the pieces of `path`, in which the name of the file begins at the byte `name`.
fn push_pieces_of_text(path: &str, name: usize, pieces: &mut Vec<Piece>) {
    let mut text = String::new();
    let mut rest = path;
    while let Some(first) = rest.chars().next() {
        let (length, width) = if let Some(escaped) = rest.strip_prefix("%%") {
            text.push('%');
            rest = escaped;
            continue;
        } else if first == '#' && path.len() - rest.len() >= name {
            let run = rest.len() - rest.trim_start_matches('#').len();
            (run, Some(run))
        } else {
            parse_percent(rest).map_or((first.len_utf8(), None), |(l, w)| (l, Some(w)))
        };
        match width {
            Some(width) => {
                pieces.push(Piece::Text(std::mem::take(&mut text).into()));
                pieces.push(Piece::Frame(width));
            }
            None => text.push(first),
        }
        rest = &rest[length..];
    }
    pieces.push(Piece::Text(text.into()));
}

/// Returns the length and field width of a `%d`, `%4d` or `%04d` at the start of `rest`.
fn parse_percent(rest: &str) -> Option<(usize, usize)> {
    let digits = rest.strip_prefix('%')?;
    let count = digits.len()
        - digits
            .trim_start_matches(|c: char| c.is_ascii_digit())
            .len();
    // More digits would make absurdly long names.
    if count > 2 || !digits[count..].starts_with('d') {
        return None;
    }
    let width = if count == 0 {
        0
    } else {
        digits[..count].parse().ok()?
    };
    Some((count + 2, width))
}

/// Parses a frame list: `1001-1100`, `1001-1100x2` (every second), `1,5,9`, and combinations by comma. Repeated frames
/// are dropped.
///
/// # Errors
/// Anything else, a descending range, and more than a million frames.
pub fn parse_frames(list: &str) -> Result<Vec<i64>> {
    let refuse = |problem: String| {
        FileError::new(
            "--frames",
            "",
            problem,
            "write it like 1001-1100, 1001-1100x2 or 1,5,9",
        )
    };
    let mut frames = Vec::new();
    for item in list.split(',').map(str::trim) {
        let unreadable = || refuse(format!("`{item}` in `{list}` is not a frame or range"));
        let (range, step) = match item.split_once('x') {
            Some((range, step)) => (range, step.parse::<u32>().map_err(|_| unreadable())?),
            None => (item, 1),
        };
        let step = usize::try_from(step).map_err(|_| unreadable())?;
        if step == 0 {
            return Err(refuse(format!("`{item}` has a step of 0")));
        }
        // Skips the minus sign of a negative first frame.
        let dash = range.char_indices().skip(1).find(|(_, c)| *c == '-');
        let (first, last) = match dash {
            Some((at, _)) => (&range[..at], &range[at + 1..]),
            None if item.contains('x') => return Err(unreadable()),
            None => (range, range),
        };
        let first: i64 = first.parse().map_err(|_| unreadable())?;
        let last: i64 = last.parse().map_err(|_| unreadable())?;
        if last < first {
            return Err(refuse(format!("`{item}` is descending")));
        }
        let left = MAX_FRAMES - frames.len();
        let count = frames.len();
        frames.extend((first..=last).step_by(step).take(left + 1));
        if frames.len() - count > left {
            return Err(refuse(format!(
                "`{list}` names more than {MAX_FRAMES} frames"
            )));
        }
    }
    let mut seen = std::collections::HashSet::new();
    frames.retain(|frame| seen.insert(*frame));
    Ok(frames)
}

/// Returns the frame number in the name of `file`, the last digits before its extension, as in `plate.1001.exr`.
pub fn number_in_name(file: &Path) -> Option<i64> {
    let stem = file.file_stem()?.to_str()?;
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit());
    stem[start.map_or(0, |at| {
        at + stem[at..].chars().next().map_or(1, char::len_utf8)
    })..end]
        .parse()
        .ok()
}

/// Returns the frames missing between the first and the last of `frames`, as a list; `None` if none is.
pub fn gaps(frames: &[i64]) -> Option<String> {
    let gaps = frames.windows(2).filter(|pair| pair[1] - pair[0] > 1);
    let words: Vec<_> = gaps
        .map(|pair| match (pair[0] + 1, pair[1] - 1) {
            (first, last) if first == last => first.to_string(),
            (first, last) => format!("{first}-{last}"),
        })
        .collect();
    (!words.is_empty()).then(|| words.join(","))
}

/// Returns the frame numbers of a run over `patterns`: input first, output second, then others such as a depth pass. `None` is a
/// single image, whose paths are not patterns.
///
/// Input and output must both contain the frame number, or neither; the others may be the same file for every frame.
/// Without `frames`, all frames of the input on disk are taken, and an input that exists is not treated as a pattern.
///
/// # Errors
/// A pattern without files, frames without a pattern, a single output of a sequence, and an invalid frame list.
pub fn expand_frames(patterns: &[&Path], frames: Option<&str>) -> Result<Vec<Option<i64>>> {
    let parsed: Vec<FramePattern> = patterns.iter().map(FramePattern::parse).collect();
    let Some(list) = frames else {
        let input_is_file = patterns.first().is_some_and(|p| p.is_file());
        let Some(input) = parsed.first().filter(|p| !input_is_file && p.has_frame()) else {
            return match parsed.iter().find(|p| !input_is_file && p.has_frame()) {
                Some(pattern) => Err(FileError::new(
                    &pattern.path,
                    "",
                    "contains a frame pattern, but the plate is a single file",
                    "give IN a frame pattern as well, such as plate.%04d.exr",
                )),
                None => Ok(vec![None]),
            };
        };
        let found = input.existing_frames();
        if found.is_empty() {
            return Err(FileError::new(
                &input.path,
                "",
                "has no frame on disk",
                "check folder and name, or give the frames by --frames, such as --frames 1001-1100",
            ));
        }
        return check_patterns(&parsed, "the frames on disk were taken").map(|()| numbered(found));
    };
    let frames = parse_frames(list)?;
    check_patterns(&parsed, &format!("--frames {list} was given"))?;
    Ok(numbered(frames))
}

fn numbered(frames: Vec<i64>) -> Vec<Option<i64>> {
    frames.into_iter().map(Some).collect()
}

/// Checks that input and output of a sequence have a place for the frame number; `reason` says why they need one.
fn check_patterns(patterns: &[FramePattern], reason: &str) -> Result<()> {
    for pattern in patterns.iter().take(2) {
        if !pattern.has_frame() {
            return Err(FileError::new(
                &pattern.path,
                "",
                format!("contains no frame pattern, but {reason}"),
                "put %04d or #### where the frame number goes, or leave out --frames",
            ));
        }
    }
    Ok(())
}
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_expand_to_paths() {
        for (pattern, frame, path) in [
            ("plate.%04d.exr", 7, "plate.0007.exr"),
            ("plate.%d.exr", 7, "plate.7.exr"),
            ("plate.####.exr", 1001, "plate.1001.exr"),
            ("p.###.exr", 12345, "p.12345.exr"),
            ("a%%b.%03d.exr", 5, "a%b.005.exr"),
            ("sh%02d/p.#.exr", 3, "sh03/p.3.exr"),
            ("é.%04d.exr", -7, "é.-007.exr"),
            ("100%.exr", 1, "100%.exr"),
            ("%s.%.exr", 1, "%s.%.exr"),
            ("shot#3/p.%04d.exr", 3, "shot#3/p.0003.exr"),
            ("a#/b##/p.###.exr", 3, "a#/b##/p.003.exr"),
        ] {
            assert_eq!(FramePattern::parse(pattern).path(frame), Path::new(path));
        }
        assert!(!FramePattern::parse("100%.exr").has_frame());
    }

    #[cfg(unix)]
    #[test]
    fn patterns_need_not_be_unicode() {
        use std::os::unix::ffi::OsStrExt;
        let os = |bytes: &'static [u8]| OsStr::from_bytes(bytes);
        let pattern = FramePattern::parse(os(b"caf\xe9/\xff.%04d.exr"));
        assert!(pattern.has_frame());
        assert_eq!(pattern.path(7).as_os_str(), os(b"caf\xe9/\xff.0007.exr"));
        let plain = FramePattern::parse(os(b"\xe9%%.exr"));
        assert!(!plain.has_frame());
        assert_eq!(plain.path(7).as_os_str(), os(b"\xe9%.exr"));
    }

    #[test]
    fn frame_lists_are_parsed() {
        assert_eq!(parse_frames("3").expect("one"), [3]);
        assert_eq!(parse_frames("1-7x3").expect("step"), [1, 4, 7]);
        assert_eq!(parse_frames("1,5, 4-6").expect("mixed"), [1, 5, 4, 6]);
        assert_eq!(parse_frames("-2-1").expect("negative"), [-2, -1, 0, 1]);
        assert_eq!(parse_frames("-3--1").expect("negative"), [-3, -2, -1]);
        for bad in [
            "",
            "a",
            "1-",
            "-",
            "5-1",
            "1-5x0",
            "1-5x",
            "1x2",
            "1,,2",
            "0-9999999999",
            "1-2-3",
            "9223372036854775808",
            "1-5x-1",
            "1é-3",
        ] {
            let error = parse_frames(bad).expect_err(bad);
            assert!(error.to_string().contains("1001-1100"), "{error}");
        }
        assert!(parse_frames("9223372036854775806-9223372036854775807").is_ok());
    }

    #[test]
    fn patterns_need_frames_and_frames_need_patterns() {
        let expand = |patterns: &[&str], frames: Option<&str>| {
            let patterns: Vec<&Path> = patterns.iter().map(Path::new).collect();
            expand_frames(&patterns, frames)
        };
        let steps = expand(&["in.%04d.exr", "out.%04d.exr", "z.exr"], Some("1-2")).expect("two");
        assert_eq!(steps, [Some(1), Some(2)]);
        assert_eq!(expand(&["a.exr", "b.exr"], None).expect("single"), [None]);
        let error = expand(&["in.%04d.exr", "out.%04d.exr"], None).expect_err("no frames");
        assert!(error.to_string().contains("--frames"), "{error}");
        let error = expand(&["in.%04d.exr", "out.exr"], Some("1-2")).expect_err("no pattern");
        assert!(error.to_string().contains("out.exr"), "{error}");
        assert!(expand(&["in.exr", "out.exr"], Some("1-2")).is_err());
    }

    proptest::proptest! {
        #[test]
        fn no_text_panics(pattern in ".{0,40}", list in "[0-9x,\\- a]{0,24}") {
            let _ = FramePattern::parse(&pattern).path(1001);
            let _ = parse_frames(&list);
        }
    }
}
