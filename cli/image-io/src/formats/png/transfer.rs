//! The transfer function that a PNG file states (PNG, third edition, section 4.3): by cICP, else iCCP, else sRGB, else gAMA.

use super::chunks::{Chunk, ICC_PROFILE};
use super::icc_curve;
use crate::samples::Encoding;

/// The value of gAMA that stands for sRGB, and for a linear file.
const SRGB_GAMMA: u32 = 45_455;
const LINEAR_GAMMA: u32 = 100_000;
/// The largest difference of equal values of gAMA: half a percent.
const GAMMA_TOLERANCE: u32 = 500;

/// The transfer function that a file states.
pub(super) struct StatedTransfer {
    /// The chunk that states it.
    pub(super) chunk: &'static str,
    /// `None` if it is not known.
    pub(super) encoding: Option<Encoding>,
}

/// Returns the transfer function that `chunks` and the decompressed `profile` state.
pub(super) fn stated(chunks: &[Chunk], profile: Option<&[u8]>) -> Option<StatedTransfer> {
    let data = |name: &[u8; 4]| {
        let own = chunks.iter().find(|chunk| chunk.name() == *name);
        own.map(Chunk::data)
    };
    let transfer = |chunk, encoding| Some(StatedTransfer { chunk, encoding });
    match data(b"cICP") {
        // Unspecified.
        None | Some([_, 2, ..]) => {}
        Some(&[_, transfer_function, 0, 1]) => {
            return transfer("cICP", of_code_point(transfer_function));
        }
        // Narrow range, or Y, Cb and Cr.
        Some(_) => return transfer("cICP", None),
    }
    if let Some(profile) = profile {
        return transfer("iCCP, an ICC profile", icc_curve::encoding(profile));
    }
    if data(&ICC_PROFILE).is_some() {
        return transfer("iCCP, an ICC profile", None);
    }
    if data(b"sRGB").is_some() {
        return transfer("sRGB", Some(Encoding::Srgb));
    }
    let gamma = u32::from_be_bytes(data(b"gAMA")?.try_into().ok()?);
    transfer("gAMA", of_gamma(gamma))
}

/// Returns the encoding of a transfer characteristic of ITU-T H.273.
fn of_code_point(transfer: u8) -> Option<Encoding> {
    match transfer {
        1 | 6 | 14 | 15 => Some(Encoding::Rec709),
        4 => Encoding::of_power(2.2),
        5 => Encoding::of_power(2.8),
        8 => Some(Encoding::Linear),
        13 => Some(Encoding::Srgb),
        16 => Some(Encoding::Pq),
        18 => Some(Encoding::Hlg),
        _ => None,
    }
}

fn of_gamma(value: u32) -> Option<Encoding> {
    match value {
        _ if value.abs_diff(SRGB_GAMMA) <= GAMMA_TOLERANCE => Some(Encoding::Srgb),
        _ if value.abs_diff(LINEAR_GAMMA) <= GAMMA_TOLERANCE => Some(Encoding::Linear),
        0 => None,
        _ => Encoding::of_power(f64::from(LINEAR_GAMMA) / f64::from(value)),
    }
}
