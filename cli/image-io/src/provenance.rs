//! What made a file, kept in it as texts: version, command, lens and settings, and what was done to it before.

use std::ffi::OsString;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::error::Result;
use crate::json::{TEXT_LIMIT_BYTES, read_bytes};
use crate::sequence::FramePattern;

/// Texts of a file, each with its name.
pub type Texts = Vec<(String, String)>;

/// What all names begin with.
pub const PREFIX: &str = "seidel";
const VERSION: &str = "seidelVersion";
const COMMAND: &str = "seidelCommand";
const SETTINGS: &str = "seidelSettings";
const BEFORE: &str = "seidelBefore";

/// Options that say how a run goes and not what comes of it, and whether they take a value: files are the same for all of
/// them, and so is what is said in files.
const OF_THE_RUN: [(&str, bool); 4] = [
    ("--frames", true),
    ("--threads", true),
    ("--memory", true),
    ("--overwrite", false),
];

/// What makes the files of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Provenance {
    words: Vec<String>,
    files: Texts,
}

impl Provenance {
    /// That of the command line `words`, the program's name first.
    #[must_use]
    pub fn new(words: &[OsString]) -> Self {
        let mut words = words.iter().skip(1).map(|word| word.to_string_lossy());
        let mut kept = vec!["seidel".to_owned()];
        while let Some(word) = words.next() {
            let name = word.split_once('=').map_or(&*word, |(name, _)| name);
            match OF_THE_RUN.iter().find(|(own, _)| *own == name) {
                None => kept.push(word.into_owned()),
                Some((_, takes)) if *takes && name == word => {
                    words.next();
                }
                Some(_) => {}
            }
        }
        Self {
            words: kept,
            files: Texts::new(),
        }
    }

    /// The command that makes the frame of that number alone.
    fn command(&self, frame: Option<i64>) -> String {
        let word = |word: &String| {
            let pattern = FramePattern::parse(word);
            match frame.filter(|_| pattern.has_frame()) {
                Some(frame) => quoted(&pattern.path(frame).to_string_lossy()),
                None => quoted(word),
            }
        };
        self.words.iter().map(word).collect::<Vec<_>>().join(" ")
    }

    /// With a file that was used: its name and the SHA-256 of its bytes, as `seidelROLE`.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn with_file(mut self, role: &str, path: &Path) -> Result<Self> {
        let hash = Sha256::digest(read_bytes(path, TEXT_LIMIT_BYTES)?);
        let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        let name = path.file_name().unwrap_or(path.as_os_str());
        let name = name.to_string_lossy();
        self.files
            .push((format!("{PREFIX}{role}"), format!("{name} sha256:{hash}")));
        Ok(self)
    }

    /// The texts of a file, the frame `frame` of a run, made with `settings`, which had the texts `old`: those of others
    /// stay, and what was done before becomes a line each.
    #[must_use]
    pub fn texts(
        &self,
        frame: Option<i64>,
        settings: &[(String, String)],
        old: &[(String, String)],
    ) -> Texts {
        let (own, others): (Vec<_>, Vec<_>) =
            (old.iter().cloned()).partition(|(name, _)| is_ours(name));
        let find = |wanted: &str| own.iter().find(|(name, _)| name == wanted);
        let mut before: Vec<String> = find(BEFORE)
            .map(|(_, text)| text.clone())
            .into_iter()
            .collect();
        if let Some((_, command)) = find(COMMAND) {
            let files = own
                .iter()
                .filter(|(name, text)| name != BEFORE && text.contains(" sha256:"));
            let files: String = files.map(|(_, text)| format!(" [{text}]")).collect();
            let version = find(VERSION).map_or("?", |(_, text)| text);
            before.push(format!("{version}: {command}{files}"));
        }
        let settings = settings
            .iter()
            .map(|(name, value)| format!("{name}: {value}"));
        let settings: Vec<String> = settings.collect();
        let mut all = others;
        all.push((VERSION.to_owned(), env!("CARGO_PKG_VERSION").to_owned()));
        all.push((COMMAND.to_owned(), self.command(frame)));
        all.extend(self.files.iter().cloned());
        if !settings.is_empty() {
            all.push((SETTINGS.to_owned(), settings.join("\n")));
        }
        if !before.is_empty() {
            all.push((BEFORE.to_owned(), before.join("\n")));
        }
        all
    }
}

/// Whether a text of that name is part of a file's provenance.
#[must_use]
pub fn is_ours(name: &str) -> bool {
    name.starts_with(PREFIX)
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=,%+@#~".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(words: &[&str]) -> Provenance {
        let words: Vec<OsString> = words.iter().map(OsString::from).collect();
        Provenance::new(&words)
    }

    fn text<'t>(texts: &'t Texts, name: &str) -> &'t str {
        let found = texts.iter().find(|(own, _)| own == name);
        found.map_or("", |(_, text)| text)
    }

    #[test]
    fn words_are_such_that_a_shell_gives_them_back() {
        let words = ["/x/seidel", "apply", "a b.exr", "it's", "", "-o=c.exr"];
        let texts = of(&words).texts(None, &[], &[]);
        assert_eq!(
            text(&texts, COMMAND),
            r"seidel apply 'a b.exr' 'it'\''s' '' -o=c.exr"
        );
    }

    #[test]
    fn frames_are_told_alone_whatever_run_they_were_of() {
        let words = "s apply p.%04d.exr -o o.##.exr --frames 1-9 --threads=2 --overwrite --memory 1G --amount 1";
        let words: Vec<&str> = words.split(' ').collect();
        let texts = of(&words).texts(Some(7), &[], &[]);
        assert_eq!(
            text(&texts, COMMAND),
            "seidel apply p.0007.exr -o o.07.exr --amount 1"
        );
    }

    #[test]
    fn what_was_before_becomes_a_line_and_texts_of_others_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let lens = folder.path().join("l.json");
        std::fs::write(&lens, "abc").expect("writable");
        let one = of(&["s", "apply"])
            .with_file("Lens", &lens)
            .expect("readable");
        let hash = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let settings = [("amount".to_owned(), "1".to_owned())];
        let old = [("Title".to_owned(), "T".to_owned())];
        let first = one.texts(None, &settings, &old);
        assert_eq!(text(&first, "Title"), "T");
        assert_eq!(text(&first, "seidelLens"), format!("l.json sha256:{hash}"));
        assert_eq!(text(&first, SETTINGS), "amount: 1");
        assert_eq!(text(&first, BEFORE), "");
        let second = of(&["s", "remove"]).texts(None, &[], &first);
        assert_eq!(text(&second, COMMAND), "seidel remove");
        assert_eq!(text(&second, SETTINGS), "");
        let third = of(&["s", "relens"]).texts(None, &[], &second);
        let version = env!("CARGO_PKG_VERSION");
        let lines =
            format!("{version}: seidel apply [l.json sha256:{hash}]\n{version}: seidel remove");
        assert_eq!(text(&third, BEFORE), lines);
        assert_eq!(third.iter().filter(|(name, _)| name == COMMAND).count(), 1);
    }
}
