//! Scaling of very bright plates, so that the arithmetic on them cannot overflow.

/// Largest magnitude of a sample that is rendered as it is. Renderers add and square samples in single precision, which
/// ends at 2^128; a removal raises them to about the fifth power. No photograph comes near this value.
const LARGEST_PEAK: f64 = (1_u64 << 20) as f64;

/// A power of two that brings light to magnitudes whose arithmetic does not overflow.
///
/// Multiplication by it is exact, and all methods are linear or scale with the light, so results differ only where samples
/// become so small that they lose digits: 2^100 times below the brightest sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LightScale(f64);

impl LightScale {
    /// Returns the scale for light up to `peak`, or `None` if it is rendered as it is.
    pub(crate) fn for_peak(peak: f64) -> Option<Self> {
        (peak > LARGEST_PEAK).then(|| Self((LARGEST_PEAK / peak).log2().floor().exp2()))
    }

    /// The factor by which light is multiplied before it is rendered.
    pub(crate) fn factor(self) -> f64 {
        self.0
    }

    /// Multiplies `samples` by the scale.
    pub(crate) fn reduce(self, samples: &mut [f32]) {
        multiply(samples, self.0);
    }

    /// Divides `samples` by the scale.
    pub(crate) fn restore(self, samples: &mut [f32]) {
        multiply(samples, 1.0 / self.0);
    }
}

/// Multiplies in double precision, because factors may lie beyond single precision.
fn multiply(samples: &mut [f32], factor: f64) {
    for sample in samples {
        *sample = (f64::from(*sample) * factor) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_is_exact_in_both_directions() {
        assert_eq!(LightScale::for_peak(0.0), None);
        assert_eq!(LightScale::for_peak(LARGEST_PEAK), None);
        for peak in [1.1e6_f32, 1e15, 3.3e30, f32::MAX] {
            let scale = LightScale::for_peak(f64::from(peak)).expect("bright");
            let samples = [peak, -peak / 3.0, 1.0, 0.1];
            let mut scaled = samples;
            scale.reduce(&mut scaled);
            assert!(f64::from(scaled[0]) <= LARGEST_PEAK, "{scaled:?}");
            assert!(f64::from(scaled[0]) > LARGEST_PEAK / 4.0, "{scaled:?}");
            scale.restore(&mut scaled);
            assert_eq!(scaled, samples);
        }
    }
}
