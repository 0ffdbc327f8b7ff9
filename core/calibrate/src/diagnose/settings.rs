//! Settings and progress of a diagnosis.

use std::sync::atomic::{AtomicBool, Ordering};

use seidel_optics::error::{Error, Result};

/// Settings of [`super::diagnose`].
#[derive(Debug, Clone)]
pub struct Settings {
    /// Identifiers of the effects to try; all if empty.
    pub library: Vec<String>,
    /// Whether pairs of effects are tried.
    pub pairs: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            library: Vec::new(),
            pairs: true,
        }
    }
}

/// Progress reports and cancellation of a long computation.
pub struct Progress<'a> {
    /// Called with the completed share, 0 to 1.
    pub report: &'a (dyn Fn(f64) + Sync),
    /// Set to cancel.
    pub stop: &'a AtomicBool,
}

impl Progress<'_> {
    /// Reports the completed share.
    ///
    /// # Errors
    /// Cancellation.
    pub(super) fn step(&self, share: f64) -> Result<()> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::cancelled("diagnosis"));
        }
        (self.report)(share);
        Ok(())
    }
}
