//! What a diagnosis may be told.

use std::sync::atomic::{AtomicBool, Ordering};

use seidel_optics::error::{Error, Result};

/// Settings of [`super::diagnose`].
#[derive(Debug, Clone)]
pub struct Settings {
    /// Effects to try, by identifier; all if empty.
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

/// What a long diagnosis tells and asks while it works.
pub struct Progress<'a> {
    /// Called with the share done, 0 to 1.
    pub report: &'a (dyn Fn(f64) + Sync),
    /// Set to stop.
    pub stop: &'a AtomicBool,
}

impl Progress<'_> {
    /// Tells the share done.
    ///
    /// # Errors
    /// A stop on request.
    pub(super) fn step(&self, share: f64) -> Result<()> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::cancelled("diagnosis"));
        }
        (self.report)(share);
        Ok(())
    }
}
