//! Defaults of a show: the file `seidel.toml`, whose keys are options that the command line leaves out.

use std::any::TypeId;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction, Command};
use seidel_image_io::error::FileError;
use seidel_image_io::json::read_text;
use toml::{Table, Value};

/// Name of the file, which is looked for in the working folder and in those above it.
const FILE_NAME: &str = "seidel.toml";

/// The option that names another file, or `none`.
const OPTION: &str = "defaults";

/// Limit of the length of the file, bytes.
const LIMIT_BYTES: u64 = 1 << 20;

/// A command line with the defaults of a file.
#[derive(Debug)]
pub(crate) struct WithDefaults {
    /// Name of the program, command, defaults, and the rest of the command line.
    pub(crate) line: Vec<OsString>,
    /// The file and its options, in words.
    pub(crate) note: String,
}

/// Returns the command line `line` with the defaults of a file, in the working folder `folder` or above it; `None` where there is
/// no such file, or no default in it applies. `has_ocio` states whether the environment names an OpenColorIO config, which
/// comes before that of the file.
///
/// # Errors
/// A file that cannot be read or is not TOML, a key that is no option, and a value that is no text, number or switch.
pub(crate) fn with_defaults(
    commands: &Command,
    line: &[OsString],
    folder: &Path,
    has_ocio: bool,
) -> Result<Option<WithDefaults>, FileError> {
    let name = line.get(1).and_then(|word| word.to_str());
    let command = name.and_then(|name| commands.find_subcommand(name));
    let Some(command) = command.filter(|command| has_defaults(command)) else {
        return Ok(None);
    };
    let named = given_value(line, OPTION);
    let path = match &named {
        Some(path) if path.as_os_str() == "none" => return Ok(None),
        Some(path) => path.clone(),
        None => {
            let mut files = folder.ancestors().map(|folder| folder.join(FILE_NAME));
            match files.find(|file| file.is_file()) {
                Some(path) => path,
                None => return Ok(None),
            }
        }
    };
    let text = read_text(&path, LIMIT_BYTES)?;
    let table: Table = text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| {
            1 + text.as_bytes()[..span.start]
                .iter()
                .filter(|b| **b == b'\n')
                .count()
        });
        let problem = format!("is not TOML: {}", error.message());
        FileError::new(
            &path,
            format!("line {line}"),
            problem,
            "correct the file there",
        )
    })?;
    let file = DefaultsFile {
        path: &path,
        commands,
    };
    let chosen = file.options_of(command, &table)?;
    let given: Vec<&Arg> = (command.get_arguments())
        .filter(|arg| is_given(line, arg))
        .collect();
    let contradict = |a: &Arg, b: &Arg| {
        let conflicts = command.get_arg_conflicts_with(a);
        a == b || conflicts.contains(&b)
    };
    let is_free = |arg: &Arg| {
        let mut rivals = given.iter();
        let is_contradicted = rivals.any(|given| contradict(arg, given) || contradict(given, arg));
        let is_in_environment = has_ocio && arg.get_id() == "ocio";
        !is_contradicted && !is_in_environment
    };
    let chosen = chosen.into_iter().filter(|(arg, _)| is_free(arg));
    let words: Vec<OsString> = chosen.map(|(_, word)| word).collect();
    if words.is_empty() {
        return Ok(None);
    }
    let listed: Vec<_> = words.iter().map(|word| word.to_string_lossy()).collect();
    let note = format!("defaults of {}: {}", path.display(), listed.join(" "));
    let mut whole = line[..2].to_vec();
    if named.is_none() {
        whole.push(option_word(OPTION, path.as_os_str().to_owned()));
    }
    whole.extend(words);
    whole.extend_from_slice(&line[2..]);
    Ok(Some(WithDefaults { line: whole, note }))
}

/// Returns whether a command takes defaults.
fn has_defaults(command: &Command) -> bool {
    command.get_arguments().any(|arg| arg.get_id() == OPTION)
}

fn option_word(name: &str, value: OsString) -> OsString {
    let mut word = OsString::from(format!("--{name}="));
    word.push(value);
    word
}

/// Returns the value of the long option `name` on a command line.
fn given_value(line: &[OsString], name: &str) -> Option<PathBuf> {
    let mut words = line.iter().skip(2);
    while let Some(word) = words.next() {
        let long = word.to_str().and_then(|word| word.strip_prefix("--"));
        match long.and_then(|long| long.strip_prefix(name)) {
            Some("") => return words.next().map(PathBuf::from),
            Some(rest) if rest.starts_with('=') => return Some(PathBuf::from(&rest[1..])),
            _ => {}
        }
    }
    None
}

/// Returns whether an option is on a command line.
fn is_given(line: &[OsString], arg: &Arg) -> bool {
    let aliases = arg.get_all_aliases().unwrap_or_default();
    let names: Vec<&str> = arg.get_long().into_iter().chain(aliases).collect();
    let mut words = line.iter().skip(2).filter_map(|word| word.to_str());
    words.any(|word| {
        let long = word.strip_prefix("--");
        let long = long.map(|word| word.split_once('=').map_or(word, |(name, _)| name));
        let is_short = arg.get_short().is_some_and(|short| {
            long.is_none() && word.starts_with('-') && word[1..].starts_with(short)
        });
        is_short || long.is_some_and(|name| names.contains(&name))
    })
}

/// A file of defaults.
struct DefaultsFile<'a> {
    path: &'a Path,
    commands: &'a Command,
}

impl DefaultsFile<'_> {
    /// Returns the options of `command` that `table` gives, those of its own section before the others.
    fn options_of<'c>(
        &self,
        command: &'c Command,
        table: &Table,
    ) -> Result<Vec<(&'c Arg, OsString)>, FileError> {
        let takers: Vec<&Command> = (self.commands.get_subcommands())
            .filter(|command| has_defaults(command))
            .collect();
        let mut options: Vec<(&Arg, OsString)> = Vec::new();
        let mut entries: Vec<_> = table.iter().collect();
        // Sections come last, and replace what is for all commands.
        entries.sort_by_key(|(_, value)| value.is_table());
        for (key, value) in entries {
            let section = takers.iter().find(|command| command.get_name() == key);
            let (Value::Table(own), Some(section)) = (value, section) else {
                if !takers.iter().any(|command| option(command, key).is_some()) {
                    return Err(self.unknown(key, &takers));
                }
                if let Some(arg) = option(command, key) {
                    options.extend(self.word(arg, key, value)?.map(|word| (arg, word)));
                }
                continue;
            };
            for (key, value) in own {
                let place = format!("{}.{key}", section.get_name());
                let Some(arg) = option(section, key) else {
                    return Err(self.unknown(&place, &[section]));
                };
                let word = self.word(arg, &place, value)?;
                if let Some(arg) =
                    option(command, key).filter(|_| section.get_name() == command.get_name())
                {
                    options.retain(|(other, _)| other.get_id() != arg.get_id());
                    options.extend(word.map(|word| (arg, word)));
                }
            }
        }
        Ok(options)
    }

    /// Returns the option of `arg` with the `value` of a key; `None` for a switch that is off.
    fn word(&self, arg: &Arg, key: &str, value: &Value) -> Result<Option<OsString>, FileError> {
        let name = arg.get_long().unwrap_or_default();
        let text = match value {
            Value::Boolean(is_on) if matches!(arg.get_action(), ArgAction::SetTrue) => {
                return Ok(is_on.then(|| format!("--{name}").into()));
            }
            _ if !arg.get_action().takes_values() => {
                let problem = format!("is {}, but the option is a switch", value.type_str());
                return Err(FileError::new(
                    self.path,
                    key,
                    problem,
                    "write true or false",
                ));
            }
            Value::String(text) => text.clone(),
            Value::Integer(number) => number.to_string(),
            Value::Float(number) => number.to_string(),
            other => {
                let problem = format!("is {}", other.type_str());
                return Err(FileError::new(
                    self.path,
                    key,
                    problem,
                    "write a text or a number",
                ));
            }
        };
        let is_path = arg.get_value_parser().type_id() == TypeId::of::<PathBuf>();
        let folder = self
            .path
            .parent()
            .filter(|_| is_path && !text.starts_with("library:"));
        let value =
            folder.map_or_else(|| OsString::from(&text), |folder| folder.join(&text).into());
        Ok(Some(option_word(name, value)))
    }

    /// Returns the error of a key that is no option of `commands`.
    fn unknown(&self, key: &str, commands: &[&Command]) -> FileError {
        let names: Vec<&str> = commands.iter().map(|command| command.get_name()).collect();
        let remedy = format!(
            "use the long options of `seidel {} --help`, without dashes before them",
            names[0]
        );
        FileError::new(
            self.path,
            key,
            format!("is no option of {}", names.join(", ")),
            remedy,
        )
    }
}

/// Returns the long option called `name`.
fn option<'c>(command: &'c Command, name: &str) -> Option<&'c Arg> {
    let mut options = command.get_arguments();
    options.find(|arg| arg.get_long() == Some(name) && name != OPTION)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use seidel_image_io::atomic::write_atomically;

    use super::*;

    /// Returns the words between command and plate of `line` in a folder with such a file, or the error.
    fn expanded(text: &str, line: &str, has_ocio: bool) -> Result<Vec<String>, String> {
        let show = tempfile::tempdir().expect("a folder");
        let shot = show.path().join("shot");
        std::fs::create_dir(&shot).expect("a folder");
        let path = show.path().join(FILE_NAME);
        write_atomically(&path, |out| out.write_all(text.as_bytes())).expect("written");
        let line: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let found = with_defaults(&crate::commands::command(), &line, &shot, has_ocio);
        let found = found.map_err(|error| error.to_string())?;
        let line = found.map_or(line, |found| found.line);
        let folder = format!("{}/", show.path().display());
        let words = line[2..]
            .iter()
            .map(|word| word.to_string_lossy().replace(&folder, ""));
        Ok(words.collect())
    }

    #[test]
    fn the_command_line_comes_before_the_file_and_the_command_before_all() {
        let text = "film-back-mm = 24.9\nlens = \"lenses/a.json\"\ndepth-unit = \"cm\"\nocio = \"show.ocio\"\n\
            [apply]\nfilm-back-mm = 20\nno-blur-inside = true\nlens = \"library:modern-50\"\n[remove]\nstrength = 0.5\n";
        let words = expanded(text, "seidel apply p.exr -o b.exr --depth-unit=m", true);
        let mut words = words.expect("valid");
        assert_eq!(words.remove(0), "--defaults=seidel.toml");
        let rest = words.split_off(3);
        words.sort();
        let wanted = [
            "--film-back-mm=20",
            "--lens=library:modern-50",
            "--no-blur-inside",
        ];
        assert_eq!(words, wanted);
        assert_eq!(rest, ["p.exr", "-o", "b.exr", "--depth-unit=m"]);
        let words = expanded(text, "seidel remove p.exr -o b.exr", false).expect("valid");
        for word in [
            "--lens=lenses/a.json",
            "--ocio=show.ocio",
            "--strength=0.5",
            "--film-back-mm=24.9",
        ] {
            assert!(words.iter().any(|w| w == word), "{word}: {words:?}");
        }
    }

    #[test]
    fn an_option_that_the_command_line_contradicts_is_left_out() {
        let line = "seidel apply p.exr -o b.exr --focus-distance 2";
        let words = expanded("focus-at = \"3,4\"\n", line, false).expect("valid");
        assert!(
            !words.iter().any(|word| word.contains("focus-at")),
            "{words:?}"
        );
        for line in ["seidel apply p.exr --defaults none", "seidel info p.exr"] {
            let words = expanded("f-number = 2\n", line, false).expect("valid");
            assert!(!words.iter().any(|word| word.contains("f-number")));
        }
    }

    #[test]
    fn errors_name_file_key_and_remedy() {
        for (text, parts) in [
            ("f-numbr = 2", ["f-numbr", "is no option", "--help"]),
            (
                "[remove]\nbloom = 1",
                ["remove.bloom", "is no option of remove", "--help"],
            ),
            ("[aply]\nbloom = 1", ["aply", "is no option", "--help"]),
            ("lens = [1]", ["lens", "is array", "text or a number"]),
            (
                "no-blur-inside = 3",
                ["no-blur-inside", "switch", "true or false"],
            ),
            ("a = 1\nb =", ["line 2", "is not TOML", "correct"]),
        ] {
            let error = expanded(text, "seidel apply p.exr", false).expect_err(text);
            let has_all = parts.iter().all(|part| error.contains(part));
            assert!(has_all && error.contains(FILE_NAME), "{error}");
        }
    }
}
