//! Options about the background: the plate without its foreground, and its depth.

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

use crate::commands::plates::BackgroundSource;

/// Options about the background.
#[derive(Debug, Args)]
#[command(next_help_heading = "Depth")]
pub(super) struct BackgroundArgs {
    /// The plate without its foreground (a clean plate), or a frame pattern: shown where the blur of the foreground uncovers
    /// it, instead of an estimate
    ///
    /// Its depth is its own Z channel or --background-depth, with the meaning of the plate's.
    #[arg(long, value_name = "FILE", conflicts_with = "no_fill_foreground", value_parser = NonEmptyStringValueParser::new())]
    background: Option<String>,
    /// Depth pass of the background, or a frame pattern
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "background", value_parser = NonEmptyStringValueParser::new())]
    background_depth: Option<String>,
}

impl BackgroundArgs {
    /// Returns whether a background is given.
    pub(super) fn is_used(&self) -> bool {
        self.background.is_some()
    }

    /// Returns the files of the background.
    pub(super) fn source(&self) -> BackgroundSource {
        BackgroundSource::new(self.background.as_deref(), self.background_depth.as_deref())
    }
}
