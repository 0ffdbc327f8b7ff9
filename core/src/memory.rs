//! Memory that work on a plate takes.

/// Returns the most bytes that [`apply`](crate::apply) needs for `planes` planes of `pixels` pixels without occlusion, beyond the plate
/// itself and the kernels that a lens keeps for its next renders, at most 160 MiB.
pub fn apply_bytes(pixels: u64, planes: u64) -> u64 {
    // For each plane: its samples, the renderer's sums in double precision, and the result. For each pixel: its depth as
    // read and as vergence.
    pixels.saturating_mul(planes.saturating_mul(4 + 8 + 4).saturating_add(4 + 4))
}

/// Returns the most bytes that [`apply`](crate::apply) needs where depth varies and near surfaces hide far ones, like [`apply_bytes`].
pub fn layered_apply_bytes(pixels: u64, planes: u64) -> u64 {
    // For each plane: the light and the presence of a slice on its way through the levels of the blur, the plate without cut
    // lights, and the state of the compositor. For each pixel: its place among the slices, and its last one.
    let slices = planes.saturating_mul(2 * (4 + 4 + 6 + 4) + 4 + 16);
    let slices = pixels.saturating_mul(slices.saturating_add(8 + 4));
    apply_bytes(pixels, planes).saturating_add(slices)
}

/// Returns the most bytes that [`remove`](crate::remove) needs for `planes` planes of `pixels` pixels, beyond the plate
/// itself.
pub fn remove_bytes(pixels: u64, planes: u64) -> u64 {
    // For each plane: its samples as read, on the canvas and without blur, and the blur that it keeps with the reasons. The solver
    // works on one plane at a time and holds a few dozen of the same size.
    pixels.saturating_mul(planes.saturating_mul(8 * 4).saturating_add(40 * 4))
}
