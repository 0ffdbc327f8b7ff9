//! Time codes: the key that joins the frames of a table and those of a plate.

use std::fmt;

use serde::{Serialize, Serializer};

/// An SMPTE time code, without its flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TimeCode {
    /// Hours, minutes, seconds, frames.
    digits: [u16; 4],
}

impl TimeCode {
    /// Creates a time code; `None` for digits out of range.
    pub(super) fn new(digits: [u16; 4]) -> Option<Self> {
        let [hours, minutes, seconds, _] = digits;
        (hours < 24 && minutes < 60 && seconds < 60).then_some(Self { digits })
    }

    /// Parses `hh:mm:ss:ff`; the separators of drop-frame codes, and words after the code, are accepted.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let code = text.split_whitespace().next()?;
        let mut digits = code
            .split([':', ';', '.', ','])
            .map(|part| part.parse().ok());
        let mut next = || digits.next().flatten();
        let code = [next()?, next()?, next()?, next()?];
        digits.next().is_none().then(|| Self::new(code)).flatten()
    }
}

impl fmt::Display for TimeCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [hours, minutes, seconds, frames] = self.digits;
        write!(f, "{hours:02}:{minutes:02}:{seconds:02}:{frames:02}")
    }
}

impl Serialize for TimeCode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
