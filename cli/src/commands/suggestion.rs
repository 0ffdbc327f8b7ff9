//! Suggestions of options by meaning, for the names that other programs use.

use std::ffi::OsString;

use clap::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::command;

/// Names that other programs give an option, with ours in the order of likelihood.
const MEANINGS: &[(&str, &[&str])] = &[
    ("--fstop", &["--f-number"]),
    ("--f-stop", &["--f-number"]),
    ("--aperture", &["--f-number"]),
    ("--iris", &["--f-number"]),
    ("--focus", &["--focus-distance"]),
    ("--focal-distance", &["--focus-distance"]),
    ("--focal-point", &["--focus-at"]),
    ("--focus-point", &["--focus-at"]),
    ("--focal-plane", &["--focus-distance"]),
    ("--dof", &["--depth-of-field"]),
    ("--coc", &["--show"]),
    ("--preview", &["--show"]),
    ("--overlay", &["--show"]),
    ("--z", &["--depth"]),
    ("--zdepth", &["--depth"]),
    ("--depth-channel", &["--depth"]),
    ("--units", &["--depth-unit"]),
    ("--unit", &["--depth-unit"]),
    ("--depth-units", &["--depth-unit"]),
    ("--math", &["--depth-kind"]),
    ("--mix", &["--amount", "--strength"]),
    ("--opacity", &["--mix"]),
    ("--blend", &["--mix"]),
    ("--intensity", &["--amount"]),
    ("--size", &["--amount"]),
    ("--max-size", &["--maximum-size"]),
    ("--cores", &["--threads"]),
    ("--jobs", &["--threads"]),
    ("--ram", &["--memory"]),
    ("--resume", &["--skip-existing"]),
    ("--no-overwrite", &["--skip-existing"]),
    ("--range", &["--frames"]),
    ("--profile", &["--lens"]),
    ("--input", &["--lens"]),
    ("--colorspace", &["--in-space"]),
    ("--colourspace", &["--in-space"]),
    ("--matte", &["--mask", "--holdout"]),
    ("--clean-plate", &["--background"]),
    ("--samples", &["--quality"]),
];

/// Returns `error` with the option that an unknown one of `command_line` is likely to mean, if its command has one.
pub(crate) fn suggest_by_meaning(mut error: Error, command_line: &[OsString]) -> Error {
    let unknown = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(name)) if error.kind() == ErrorKind::UnknownArgument => name,
        _ => return error,
    };
    let meant = MEANINGS.iter().find(|(name, _)| name == unknown);
    let options = meant.map_or(&[][..], |(_, options)| options);
    let known = known_options(command_line);
    if let Some(option) = options
        .iter()
        .find(|option| known.iter().any(|k| k == *option))
    {
        error.remove(ContextKind::Suggested);
        error.insert(
            ContextKind::SuggestedArg,
            ContextValue::String((*option).to_owned()),
        );
    }
    error
}

/// Returns the long options of the command that `command_line` names.
fn known_options(command_line: &[OsString]) -> Vec<String> {
    let mut found = command();
    for word in command_line.iter().skip(1) {
        let Some(next) = word.to_str().and_then(|word| found.find_subcommand(word)) else {
            break;
        };
        found = next.clone();
    }
    let names = found.get_arguments().filter_map(|arg| arg.get_long());
    names.map(|name| format!("--{name}")).collect()
}
