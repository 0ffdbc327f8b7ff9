//! The C ABI of Seidel as Rust calls it: structs to fill in, statuses turned into failures.

use seidel_c::{
    SeidelFindings, SeidelLensInfo, SeidelRect, SeidelSettings, SeidelStatus, seidel_last_error,
    seidel_settings_init,
};

use crate::host::{Failure, Result};
use crate::sys::plugin::{STATUS_ERR_MEMORY, STATUS_FAILED};

/// What was said of the last call on this thread.
fn last_error() -> String {
    let mut bytes = vec![0_u8; 4096];
    let (buffer, room) = (bytes.as_mut_ptr().cast(), bytes.len());
    // SAFETY: the buffer is as long as is said.
    let length = unsafe { seidel_last_error(buffer, room) };
    bytes.truncate(length.saturating_sub(1).min(room - 1));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A failure where a call did not go well.
///
/// # Errors
/// What the library says.
pub(crate) fn done(status: SeidelStatus) -> Result<()> {
    match status {
        SeidelStatus::Ok => Ok(()),
        SeidelStatus::Memory => Err(Failure::new(STATUS_ERR_MEMORY, last_error())),
        _ => Err(Failure::new(STATUS_FAILED, last_error())),
    }
}

/// Settings as they are unless something is set.
///
/// # Errors
/// What the library says.
pub(crate) fn settings() -> Result<SeidelSettings> {
    // SAFETY: numbers and raw pointers, for which all bytes zero is a value.
    let mut settings: SeidelSettings = unsafe { std::mem::zeroed() };
    settings.size = size_of::<SeidelSettings>() as u64;
    // SAFETY: the struct has the size that it says.
    done(unsafe { seidel_settings_init(&raw mut settings) })?;
    Ok(settings)
}

/// What is known of a lens, to be filled in.
pub(crate) fn zeroed_info() -> SeidelLensInfo {
    // SAFETY: numbers, for which all bytes zero is a value.
    let mut info: SeidelLensInfo = unsafe { std::mem::zeroed() };
    info.size = size_of::<SeidelLensInfo>() as u64;
    info
}

/// What taking blur off tells, to be filled in.
pub(crate) fn findings() -> SeidelFindings {
    SeidelFindings {
        size: size_of::<SeidelFindings>() as u64,
        confidence: std::ptr::null(),
        noise_gain: std::ptr::null(),
        found: SeidelRect {
            left: 0,
            top: 0,
            width: 0,
            height: 0,
        },
        noise: [0.0; 3],
        misfit: [0.0; 3],
        clip_level: [0.0; 3],
        clipped: [0; 3],
    }
}
