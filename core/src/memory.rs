//! Memory that work on a plate takes.

/// Returns the most bytes that [`apply`](crate::apply) needs for `planes` planes of `pixels` pixels, beyond the plate itself.
pub fn apply_bytes(pixels: u64, planes: u64) -> u64 {
    // For each plane: its samples, the renderer's sums in double precision, and the result. For each pixel: its depth as
    // read and as vergence.
    pixels.saturating_mul(planes.saturating_mul(4 + 8 + 4).saturating_add(4 + 4))
}

/// Returns the most bytes that [`remove`](crate::remove) needs for `planes` planes of `pixels` pixels, beyond the plate
/// itself.
pub fn remove_bytes(pixels: u64, planes: u64) -> u64 {
    // For each plane: its samples as read, on the canvas and without blur. The solver works on one plane at a time and holds
    // a few dozen of the same size.
    pixels.saturating_mul(planes.saturating_mul(6 * 4).saturating_add(40 * 4))
}
