//! What is known of a lens.

use seidel_c::{SeidelLens, SeidelLensInfo, SeidelStatus, seidel_lens_channel, seidel_lens_info};

use crate::ffi;
use crate::host::{Failure, Result};

/// What the plugin asks of a lens.
#[derive(Debug, Clone)]
pub(crate) struct Info {
    /// Names of its channels.
    pub(crate) channels: Vec<String>,
    /// Whether its blur depends on distance.
    pub(crate) knows_depth: bool,
    /// Columns and rows of its frame.
    pub(crate) frame: (f64, f64),
    /// Where its axis meets the frame, from the top left.
    pub(crate) axis: (f64, f64),
    /// Metres, infinity, or NaN where it is not known.
    pub(crate) focus_distance: f64,
}

impl Info {
    /// That of a lens that is held.
    ///
    /// # Errors
    /// What the library says.
    pub(super) fn of(lens: *const SeidelLens) -> Result<Self> {
        let mut info = ffi::zeroed_info();
        // SAFETY: the struct has the size that it says.
        let status = unsafe { seidel_lens_info(lens, &raw mut info) };
        ffi::done(status)?;
        let channels = (0..info.channels).map(|index| name_of(lens, index));
        let SeidelLensInfo {
            knows_depth,
            focus_distance,
            frame_width,
            frame_height,
            axis_x,
            axis_y,
            ..
        } = info;
        Ok(Self {
            channels: channels.collect::<Result<_>>()?,
            knows_depth: knows_depth == 1,
            frame: (f64::from(frame_width), f64::from(frame_height)),
            axis: (axis_x, axis_y),
            focus_distance,
        })
    }
}

fn name_of(lens: *const SeidelLens, index: u32) -> Result<String> {
    let mut needed = 0;
    let null = std::ptr::null_mut();
    // SAFETY: nothing is written but how many bytes there are.
    let status = unsafe { seidel_lens_channel(lens, index, null, 0, &raw mut needed) };
    if status != SeidelStatus::TooSmall {
        ffi::done(status)?;
    }
    let mut bytes = vec![0_u8; needed];
    let (buffer, room) = (bytes.as_mut_ptr().cast(), bytes.len());
    // SAFETY: the buffer is as long as is said.
    let status = unsafe { seidel_lens_channel(lens, index, buffer, room, &raw mut needed) };
    ffi::done(status)?;
    bytes.pop();
    String::from_utf8(bytes)
        .map_err(|_| Failure::failed("a lens channel has a name that is no text"))
}
