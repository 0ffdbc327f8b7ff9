//! Quantisation of pixels to RGBE: three colours with a common exponent.

/// The largest sample that RGBE represents: 255/256 of 2^127.
pub(crate) const MAX_SAMPLE: f32 = 255.0 / 256.0 * 1.701_411_8e38;

/// Pixels whose samples are all smaller are stored as black.
const MIN_SAMPLE: f32 = f32::MIN_POSITIVE;

/// Quantises a pixel to RGBE: eight bits of the largest sample, the same step for the others, clipped to 0 to
/// [`MAX_SAMPLE`].
pub(crate) fn quantise_pixel(pixel: [f32; 3]) -> [f32; 3] {
    let pixel = pixel.map(|v| if v > 0.0 { v.min(MAX_SAMPLE) } else { 0.0 });
    let max = pixel.iter().copied().fold(0.0, f32::max);
    if max < MIN_SAMPLE {
        return [0.0; 3];
    }
    // Steps of 1/256 of the power of two above the maximum; the next power where the maximum rounds up to it.
    let mut step = f64::from(max).log2().floor().exp2() / 128.0;
    if (f64::from(max) / step).round() > 255.0 && max < MAX_SAMPLE / 2.0 {
        step *= 2.0;
    }
    pixel.map(|v| ((f64::from(v) / step).round().min(255.0) * step) as f32)
}
