//! A kind of table of lens settings.

use std::path::Path;

use super::record::FrameRecord;
use crate::error::Result;

/// A kind of table.
pub(super) struct Dialect {
    /// Name for messages.
    pub(super) name: &'static str,
    /// Returns whether a text that starts so is of this kind.
    pub(super) is_start: fn(&str) -> bool,
    /// Reads the text of a file.
    pub(super) read: fn(&Path, &str) -> Result<Vec<FrameRecord>>,
}
