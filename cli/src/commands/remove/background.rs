//! Options about the background: the plate without its foreground, and its depth.

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

use crate::commands::plates::BackgroundSource;

/// Options about the background.
#[derive(Debug, Args)]
#[command(next_help_heading = "Depth")]
pub(super) struct BackgroundArgs {
    /// The plate without its foreground (a clean plate), through the same lens, or a frame pattern: blur is removed from the
    /// edges of the foreground too, which keep theirs otherwise
    ///
    /// Its depth is its own Z channel or --background-depth, with the meaning of the plate's.
    #[arg(long, value_name = "FILE", conflicts_with = "only_chroma", value_parser = NonEmptyStringValueParser::new())]
    background: Option<String>,
    /// Depth pass of the background, or a frame pattern
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "background", value_parser = NonEmptyStringValueParser::new())]
    background_depth: Option<String>,
}

impl BackgroundArgs {
    /// Returns the files of the background.
    pub(super) fn source(&self) -> BackgroundSource {
        BackgroundSource::new(self.background.as_deref(), self.background_depth.as_deref())
    }
}
