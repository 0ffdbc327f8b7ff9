//! Load and Unload. Hosts may do both several times over; what is heavy is made when it is needed.

use seidel_c::seidel_shutdown;

use crate::host;
use crate::sys::OfxStatus;
use crate::sys::plugin::{STATUS_ERR_MISSING_HOST_FEATURE, STATUS_OK};

/// Fetches the host's suites.
pub(super) fn load() -> OfxStatus {
    // MLT takes anything but OK for a refusal.
    match host::load() {
        Ok(_) => STATUS_OK,
        Err(_) => STATUS_ERR_MISSING_HOST_FEATURE,
    }
}

/// With the last, lenses, configs and threads end: no code may run in a library that is gone.
pub(super) fn unload() -> OfxStatus {
    if host::unload() {
        crate::lens::forget();
        crate::colour::forget();
        seidel_shutdown();
    }
    STATUS_OK
}
