//! The pixels of all pictures.

use std::fs;
use std::path::Path;

/// Columns and rows of all pictures.
pub(crate) const WIDTH: usize = 24;
pub(crate) const HEIGHT: usize = 16;

/// Returns a sample of a smooth picture with some detail, from 0.02 to 1.
pub(crate) fn sample(x: usize, y: usize, channel: usize) -> f32 {
    let wave = ((x * (channel + 2) + 3 * y) as f32 * 0.37).sin();
    0.51 + 0.49 * wave
}

/// Returns the samples of a channel, row-major.
pub(crate) fn plane(channel: usize) -> Vec<f32> {
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    pixels.map(|(x, y)| sample(x, y, channel)).collect()
}

/// Returns the bytes of a file that was just written.
pub(crate) fn read(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|e| panic!("the attack cannot read {}: {e}", path.display()))
}
