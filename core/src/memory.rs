//! How much memory work on a plate takes.

/// Bytes that blurring `planes` planes of `pixels` pixels takes at most, beside what holds the plate itself.
pub fn apply_bytes(pixels: u64, planes: u64) -> u64 {
    // Of each plane: the light before, what a renderer gathers in double precision, and the light
    // after. Of each pixel: its depth as read and as vergence.
    pixels.saturating_mul(planes.saturating_mul(4 + 8 + 4).saturating_add(4 + 4))
}

/// The same of taking blur off.
pub fn remove_bytes(pixels: u64, planes: u64) -> u64 {
    // Of each plane the light before, on its canvas and without blur; what the removal of
    // one plane holds, which is a few dozen planes more.
    pixels.saturating_mul(planes.saturating_mul(6 * 4).saturating_add(40 * 4))
}
