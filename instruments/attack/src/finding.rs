//! Findings: the ways in which a run can be wrong.

use serde::{Deserialize, Serialize};

/// A kind of finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// A panic that left the library, or that the command ended with.
    Panic,
    /// A process that ended by a signal or an unknown exit status.
    Abort,
    /// More memory than the bound.
    Memory,
    /// A result that differs from its input without a warning, or that is not finite.
    SilentChange,
    /// A run ten seconds slower than on the undamaged input.
    Slow,
    /// A partial output after the end of a run.
    Leftover,
    /// An error message that does not name the file or has control characters.
    Message,
    /// An undamaged input that was refused.
    Refused,
}

impl Kind {
    /// Every kind, in the order of the table.
    pub(crate) const ALL: [Self; 8] = [
        Self::Panic,
        Self::Abort,
        Self::Memory,
        Self::SilentChange,
        Self::Slow,
        Self::Leftover,
        Self::Message,
        Self::Refused,
    ];

    /// Returns the name in tables and logs.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Panic => "panic",
            Self::Abort => "abort",
            Self::Memory => "memory",
            Self::SilentChange => "silent-change",
            Self::Slow => "slow",
            Self::Leftover => "leftover",
            Self::Message => "message",
            Self::Refused => "refused",
        }
    }

    /// Returns the kind of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// Something wrong with a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Finding {
    pub(crate) kind: Kind,
    /// A description on one line.
    pub(crate) text: String,
}

impl Finding {
    /// Creates a finding. Line breaks in the text are escaped.
    pub(crate) fn new(kind: Kind, text: impl AsRef<str>) -> Self {
        let text: String = text.as_ref().chars().take(600).collect();
        Self {
            kind,
            text: text.escape_debug().to_string(),
        }
    }
}
