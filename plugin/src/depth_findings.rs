//! Signs that a depth image has another meaning than the settings say.

use std::ffi::c_char;

use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::plate::{HoldoutUse, Plate, SeidelPlate};
use crate::pointers::copy_text;
use crate::settings::{SeidelSettings, Settings};
use crate::status::SeidelStatus;

/// Copies what speaks against the depth image of a plate to `buffer`, in UTF-8 with a terminating zero: one finding a line, those
/// that are nearly certain first. Such lines begin with `is doubtful: `, those about what is only unusual with `may be intended: `;
/// the words are those of the command. The text is empty if nothing does, or the plate has no depth image. `*needed` gets the size
/// of the whole text in bytes with its zero, 1 if it is empty. seidel_apply renders such plates without a word, so ask once a shot.
/// `settings` may be NULL for the defaults.
///
/// Errors: those of seidel_apply about the plate; SEIDEL_STATUS_TOO_SMALL if `buffer` is NULL or `capacity` is less than `*needed`,
/// in which case the copy is cut.
///
/// # Safety
/// `buffer`: NULL, or `capacity` writable bytes. `needed`: NULL, or a writable place for a number. Other pointers: NULL, or valid
/// until the call returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_depth_findings(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    buffer: *mut c_char,
    capacity: usize,
    needed: *mut usize,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        // SAFETY: as the caller guarantees.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller guarantees.
        let plate = unsafe { Plate::new(plate)? };
        let session = settings.session(&lens)?;
        let prepared = plate.prepare(&session, &settings, HoldoutUse::Ignore)?;
        let findings = prepared.depth_findings()?;
        let lines = findings
            .iter()
            .map(|finding| format!("{}: {finding}", finding.severity));
        let text = lines.collect::<Vec<_>>().join("\n");
        // SAFETY: as the caller guarantees.
        unsafe { copy_text(&text, buffer, capacity, needed) }
    })
}
