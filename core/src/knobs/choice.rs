//! A knob that is one of several words.

use crate::settings::Settings;

/// A knob that is one of several words. Numbers of options are stored by projects and programs: new ones go to the end.
#[derive(Debug)]
pub struct Choice {
    /// The options.
    pub options: &'static [ChoiceOption],
    /// Index of the default.
    pub default: usize,
    /// Reads the index of the option from settings.
    pub get: fn(&Settings) -> usize,
    /// Writes the option to settings.
    pub set: fn(&mut Settings, usize),
}

/// An option of a choice.
#[derive(Debug)]
pub struct ChoiceOption {
    /// The word in the command and in Python.
    pub word: &'static str,
    /// The label in an OpenFX host.
    pub label: &'static str,
    /// One sentence without a full stop.
    pub help: &'static str,
}

impl Choice {
    /// Returns the index of the option called `word`.
    pub fn index_of(&self, word: &str) -> Option<usize> {
        self.options.iter().position(|option| option.word == word)
    }

    /// Returns the words of the options, separated by commas.
    pub fn words(&self) -> String {
        let words: Vec<_> = self.options.iter().map(|option| option.word).collect();
        words.join(", ")
    }
}

/// Returns the index of `value` in `values`, or 0.
pub(super) fn index_in<T: PartialEq>(values: &[T], value: &T) -> usize {
    values.iter().position(|other| other == value).unwrap_or(0)
}
