//! Provenance: the version, command, lens and settings that made a file, and its history, stored in it as texts.

pub(crate) mod header_lines;
mod paths;

use std::ffi::OsString;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::error::Result;
use crate::json::TEXT_LIMIT_BYTES;
use crate::lens_profile::file_or_library;
use crate::metadata::{PROVENANCE_PREFIX, TextAttributes, is_provenance};
use crate::sequence::FramePattern;
use paths::{text_without_folders, without_folders, words_without_folders};

const VERSION: &str = "seidelVersion";
const COMMAND: &str = "seidelCommand";
const SETTINGS: &str = "seidelSettings";
const HISTORY: &str = "seidelBefore";

/// Settings whose values are paths.
const PATH_SETTINGS: [&str; 1] = ["config"];

/// Options that do not change the resulting files, and whether they take a value. They are left out of the provenance,
/// so that the same image makes the same file.
const RUN_OPTIONS: [(&str, bool); 7] = [
    ("--frames", true),
    ("--threads", true),
    ("--memory", true),
    ("--skip-existing", false),
    ("--provenance", true),
    ("--no-provenance", false),
    ("--progress", true),
];

/// Paths in the provenance of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ProvenancePaths {
    /// As on the command line.
    Full,
    /// The names of files alone, so that folders stay private when the file is published. Earlier provenance in the file is
    /// shortened too.
    #[default]
    Names,
}

/// The provenance of the files of a run: its command line and the files it used.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Provenance {
    words: Vec<String>,
    files: TextAttributes,
    paths: ProvenancePaths,
}

impl Provenance {
    /// Creates the provenance of the command line `words`, which begins with the name of the program.
    #[must_use]
    pub fn new(words: &[OsString]) -> Self {
        let mut words = words.iter().skip(1).map(|word| word.to_string_lossy());
        let mut command = vec!["seidel".to_owned()];
        while let Some(word) = words.next() {
            let name = word.split_once('=').map_or(&*word, |(name, _)| name);
            match RUN_OPTIONS.iter().find(|(option, _)| *option == name) {
                None => command.push(word.into_owned()),
                Some((_, takes_value)) if *takes_value && name == word => {
                    words.next();
                }
                Some(_) => {}
            }
        }
        Self {
            words: command,
            files: TextAttributes::new(),
            paths: ProvenancePaths::Full,
        }
    }

    /// Returns the same provenance with its `paths` in another form.
    #[must_use]
    pub fn with_paths(mut self, paths: ProvenancePaths) -> Self {
        if paths == ProvenancePaths::Names {
            self.words = words_without_folders(&self.words);
        }
        self.paths = paths;
        self
    }

    /// Returns the name and the texts, of a file and of this run, of the first file such as the lens that differ.
    pub fn differing_file<'t>(
        &'t self,
        texts: &'t [(String, String)],
    ) -> Option<DifferingFile<'t>> {
        self.files.iter().find_map(|(name, now)| {
            let (_, before) = texts.iter().find(|(other, _)| other == name)?;
            // The name of the file may change, its content may not.
            (hash_of(before) != hash_of(now)).then_some(DifferingFile { name, before, now })
        })
    }

    /// Returns how the command line differs that made a file with these `texts`, of frame `frame`; nothing if the texts do not
    /// say.
    pub fn command_change(
        &self,
        frame: Option<i64>,
        texts: &[(String, String)],
    ) -> Option<CommandChange> {
        let (_, text) = texts.iter().find(|(name, _)| name == COMMAND)?;
        let [before, now] = [
            text_without_folders(text),
            text_without_folders(&self.command(frame)),
        ];
        if before == now {
            return Some(CommandChange::None);
        }
        let [before, now] = [options(&before), options(&now)];
        let only = |own: &[String], other: &[String]| {
            let own = own.iter().filter(|option| !other.contains(option));
            own.cloned().collect::<Vec<_>>().join(" ")
        };
        Some(CommandChange::Options {
            before: only(&before, &now),
            now: only(&now, &before),
        })
    }

    /// Returns a text of an earlier provenance, or the value of a setting, with paths in the form of this one.
    fn shortened(&self, text: &str, shorten: impl Fn(&str) -> String) -> String {
        match self.paths {
            ProvenancePaths::Full => text.to_owned(),
            ProvenancePaths::Names => shorten(text),
        }
    }

    /// Returns the command that makes only the frame of that number.
    fn command(&self, frame: Option<i64>) -> String {
        let word = |word: &String| {
            let pattern = FramePattern::parse(word);
            match frame.filter(|_| pattern.has_frame()) {
                Some(frame) => shell_quoted(&pattern.path(frame).to_string_lossy()),
                None => shell_quoted(word),
            }
        };
        self.words.iter().map(word).collect::<Vec<_>>().join(" ")
    }

    /// Adds an input file or a lens of the library: its name and the SHA-256 of its content, under the name `seidelROLE`.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn with_file(mut self, role: &str, path: &Path) -> Result<Self> {
        let hash = Sha256::digest(file_or_library(path, TEXT_LIMIT_BYTES)?);
        let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        let name = path.file_name().unwrap_or(path.as_os_str());
        let name = name.to_string_lossy();
        self.files.push((
            format!("{PROVENANCE_PREFIX}{role}"),
            format!("{name} sha256:{hash}"),
        ));
        Ok(self)
    }

    /// Returns the texts of a file: frame `frame` of the run, made with `settings` from a file with the texts `old`.
    ///
    /// Texts of other programs are kept. The old provenance becomes a line of the history.
    #[must_use]
    pub fn texts(
        &self,
        frame: Option<i64>,
        settings: &[(String, String)],
        old: &[(String, String)],
    ) -> TextAttributes {
        let (own, others): (Vec<_>, Vec<_>) =
            (old.iter().cloned()).partition(|(name, _)| is_provenance(name));
        let find = |wanted: &str| own.iter().find(|(name, _)| name == wanted);
        let mut history: Vec<String> = find(HISTORY)
            .map(|(_, text)| self.shortened(text, text_without_folders))
            .into_iter()
            .collect();
        if let Some((_, command)) = find(COMMAND) {
            let files = own
                .iter()
                .filter(|(name, text)| name != HISTORY && text.contains(" sha256:"));
            let files: String = files.map(|(_, text)| format!(" [{text}]")).collect();
            let command = self.shortened(command, text_without_folders);
            let version = find(VERSION).map_or("?", |(_, text)| text);
            history.push(format!("{version}: {command}{files}"));
        }
        let settings = settings.iter().map(|(name, value)| {
            let is_path = PATH_SETTINGS.contains(&name.as_str());
            let value = if is_path {
                self.shortened(value, without_folders)
            } else {
                value.clone()
            };
            format!("{name}: {value}")
        });
        let settings: Vec<String> = settings.collect();
        let mut all = others;
        all.push((VERSION.to_owned(), env!("CARGO_PKG_VERSION").to_owned()));
        all.push((COMMAND.to_owned(), self.command(frame)));
        all.extend(self.files.iter().cloned());
        if !settings.is_empty() {
            all.push((SETTINGS.to_owned(), settings.join("\n")));
        }
        if !history.is_empty() {
            all.push((HISTORY.to_owned(), history.join("\n")));
        }
        all
    }
}

/// A file whose content is not that of the run that made another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DifferingFile<'t> {
    /// Name of the text, such as `seidelLens`.
    pub name: &'t str,
    /// The file that was used before.
    pub before: &'t str,
    /// The file of this run.
    pub now: &'t str,
}

/// Returns the hash in the text of a file.
fn hash_of(text: &str) -> &str {
    text.rsplit(" sha256:").next().unwrap_or(text)
}

/// Quotes a word for a shell if necessary.
fn shell_quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=,%+@#~".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// The difference between two command lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CommandChange {
    /// None.
    None,
    /// Options and files that only one of them has; both are empty where the order differs.
    Options {
        /// Those of the earlier one.
        before: String,
        /// Those of the later one.
        now: String,
    },
}

/// Returns the options of a command line, each with its values.
fn options(command: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for word in command.split(' ') {
        let is_option = word.starts_with('-') && word.parse::<f64>().is_err();
        match all.last_mut() {
            Some(option) if !is_option => *option = format!("{option} {word}"),
            _ => all.push(word.to_owned()),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn provenance(words: &[&str]) -> Provenance {
        let words: Vec<OsString> = words.iter().map(OsString::from).collect();
        Provenance::new(&words)
    }

    fn text<'t>(texts: &'t TextAttributes, name: &str) -> &'t str {
        let found = texts.iter().find(|(own, _)| own == name);
        found.map_or("", |(_, text)| text)
    }

    #[test]
    fn words_are_quoted_for_a_shell() {
        let words = ["/x/seidel", "apply", "a b.exr", "it's", "", "-o=c.exr"];
        let texts = provenance(&words).texts(None, &[], &[]);
        assert_eq!(
            text(&texts, COMMAND),
            r"seidel apply 'a b.exr' 'it'\''s' '' -o=c.exr"
        );
    }

    #[test]
    fn the_command_of_a_frame_does_not_depend_on_the_run() {
        let words = "s apply p.%04d.exr -o o.##.exr --frames 1-9 --threads=2 --skip-existing --memory 1G --amount 1";
        let words: Vec<&str> = words.split(' ').collect();
        let texts = provenance(&words).texts(Some(7), &[], &[]);
        assert_eq!(
            text(&texts, COMMAND),
            "seidel apply p.0007.exr -o o.07.exr --amount 1"
        );
    }

    #[test]
    fn folders_of_paths_are_left_out_everywhere() {
        let words = [
            "s",
            "apply",
            "/show/in.%04d.exr",
            "-o",
            "/show/out.%04d.exr",
        ];
        let settings = [
            ("config".to_owned(), "/show/config.ocio".to_owned()),
            ("working-space".to_owned(), "a/b".to_owned()),
        ];
        let old = [
            (COMMAND.to_owned(), "seidel lut /old/a.exr".to_owned()),
            (HISTORY.to_owned(), "0.1.0: seidel demo /older/x".to_owned()),
        ];
        let full = provenance(&words);
        let texts = full.texts(Some(3), &settings, &old);
        let all = format!("{texts:?}");
        assert!(
            all.contains("/show/in.0003.exr") && all.contains("/older/x"),
            "{all}"
        );
        let names = full.clone().with_paths(ProvenancePaths::Names);
        let texts = names.texts(Some(3), &settings, &old);
        let command = "seidel apply in.0003.exr -o out.0003.exr";
        assert_eq!(text(&texts, COMMAND), command);
        assert_eq!(
            text(&texts, SETTINGS),
            "config: config.ocio\nworking-space: a/b"
        );
        let history = "0.1.0: seidel demo x\n?: seidel lut a.exr";
        assert_eq!(text(&texts, HISTORY), history);
        // Where files lie is no other command.
        assert_eq!(
            full.command_change(Some(3), &texts),
            Some(CommandChange::None)
        );
        let other = provenance(&["s", "remove"]);
        assert!(matches!(
            other.command_change(Some(3), &texts),
            Some(CommandChange::Options { .. })
        ));
        assert_eq!(other.command_change(Some(3), &[]), None);
    }

    #[test]
    fn old_provenance_becomes_history_and_other_texts_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let lens = folder.path().join("l.json");
        std::fs::write(&lens, "abc").expect("writable");
        let one = provenance(&["s", "apply"])
            .with_file("Lens", &lens)
            .expect("readable");
        let hash = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let settings = [("amount".to_owned(), "1".to_owned())];
        let old = [("Title".to_owned(), "T".to_owned())];
        let first = one.texts(None, &settings, &old);
        assert_eq!(text(&first, "Title"), "T");
        assert_eq!(text(&first, "seidelLens"), format!("l.json sha256:{hash}"));
        assert_eq!(text(&first, SETTINGS), "amount: 1");
        assert_eq!(text(&first, HISTORY), "");
        let second = provenance(&["s", "remove"]).texts(None, &[], &first);
        assert_eq!(text(&second, COMMAND), "seidel remove");
        assert_eq!(text(&second, SETTINGS), "");
        let third = provenance(&["s", "relens"]).texts(None, &[], &second);
        let version = env!("CARGO_PKG_VERSION");
        let lines =
            format!("{version}: seidel apply [l.json sha256:{hash}]\n{version}: seidel remove");
        assert_eq!(text(&third, HISTORY), lines);
        assert_eq!(third.iter().filter(|(name, _)| name == COMMAND).count(), 1);
    }
}
