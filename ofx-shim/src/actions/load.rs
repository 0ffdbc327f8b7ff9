//! Load and Unload. Hosts may call both several times. What takes time is done at the first use.

use crate::host;
use crate::rendering::forget_results;
use crate::sys::OfxStatus;
use crate::sys::plugin::{STATUS_ERR_MISSING_HOST_FEATURE, STATUS_OK};
use crate::{colour, lens, lens_data, threads};

/// Fetches the host's suites.
pub(super) fn load() -> OfxStatus {
    // MLT takes anything but OK for a refusal.
    match host::load() {
        Ok(_) => STATUS_OK,
        Err(_) => STATUS_ERR_MISSING_HOST_FEATURE,
    }
}

/// Drops results, lenses and configs and ends all threads with the last Unload, since no code may run in an unloaded library.
pub(super) fn unload() -> OfxStatus {
    if host::unload() {
        forget_results();
        lens::clear();
        lens_data::clear();
        colour::clear();
        threads::end();
    }
    STATUS_OK
}

/// Drops results, and lenses, configs and threads that no render uses.
pub(super) fn purge_caches() {
    forget_results();
    lens::clear();
    lens_data::clear();
    colour::clear();
    threads::end_if_idle();
}
