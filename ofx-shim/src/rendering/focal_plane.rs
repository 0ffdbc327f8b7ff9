//! The setup view of the focal plane: orange is nearer than the focus, white in focus, blue farther.

use seidel_core::Rectangle;

use super::task::Outcome;
use crate::host::{Effect, Result};
use crate::interleaved::Interleaved;
use crate::plate_image::PlateImage;

/// The range in focus, as vergences in 1/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FocusRange {
    far_per_m: f64,
    near_per_m: f64,
}

/// Half of the smallest range that is shown in focus, as a share of the vergence in focus, so that it can be seen.
const MIN_SHARE: f64 = 0.01;

/// Smallest vergence that this share is taken of, 1/m.
const MIN_VERGENCE_PER_M: f64 = 0.01;

impl FocusRange {
    /// Creates the range of `depth_m` metres about the vergence `focus_per_m`.
    pub(crate) fn new(focus_per_m: f64, depth_m: f64) -> Self {
        let distance = 1.0 / focus_per_m;
        let half = depth_m / 2.0;
        let far = if distance.is_finite() {
            1.0 / (distance + half)
        } else {
            0.0
        };
        let near = if distance - half > 0.0 {
            1.0 / (distance - half)
        } else {
            f64::INFINITY
        };
        let visible = MIN_SHARE * focus_per_m.max(MIN_VERGENCE_PER_M);
        Self {
            far_per_m: far.min(focus_per_m - visible),
            near_per_m: near.max(focus_per_m + visible),
        }
    }

    /// Returns the tint of a vergence: red, green and blue.
    fn tint(&self, vergence_per_m: f64) -> [f32; 3] {
        if vergence_per_m > self.near_per_m {
            [1.0, 0.4, 0.0]
        } else if vergence_per_m < self.far_per_m {
            [0.0, 0.0, 1.0]
        } else {
            [1.0; 3]
        }
    }
}

/// Weight of the tint against the source.
const TINT_WEIGHT: f32 = 0.5;

/// Rows between two questions to the host whether to go on.
const ROWS_PER_QUERY: i32 = 32;

/// Sets `result` in `rectangle` to `source`, tinted by the focus `range` and the vergences in 1/m, which `vergences_per_m` reads for a
/// pixel and those to its right.
///
/// # Errors
/// Not enough memory.
pub(crate) fn tint_by_focus(
    effect: &Effect,
    result: &PlateImage,
    source: &PlateImage,
    rectangle: Rectangle,
    range: FocusRange,
    mut vergences_per_m: impl FnMut((i32, i32), &mut [f64]),
) -> Result<Outcome> {
    let channels = result.channels();
    let mut vergences = vec![0.0; rectangle.width];
    let mut is_aborted = false;
    let tinted = Interleaved::new(rectangle, channels, |first, row| {
        is_aborted |= (first.1 - rectangle.y) % ROWS_PER_QUERY == 0 && effect.is_aborted();
        if is_aborted {
            return;
        }
        source.read_pixels(first, row);
        vergences_per_m(first, &mut vergences);
        for (pixel, vergence) in row.chunks_exact_mut(channels).zip(&vergences) {
            for (sample, tint) in pixel.iter_mut().zip(range.tint(*vergence)) {
                *sample = *sample * (1.0 - TINT_WEIGHT) + tint * TINT_WEIGHT;
            }
        }
    })?;
    if is_aborted {
        return Ok(Outcome::Aborted);
    }
    tinted.write_to(result);
    Ok(Outcome::DONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_is_visible_and_reaches_infinity() {
        let two_metres = FocusRange::new(0.5, 1.0);
        assert_eq!(
            (two_metres.far_per_m, two_metres.near_per_m),
            (1.0 / 2.5, 1.0 / 1.5)
        );
        let thin = FocusRange::new(0.5, 0.0);
        assert!(thin.far_per_m < 0.5 && thin.near_per_m > 0.5);
        assert_eq!(FocusRange::new(0.5, 10.0).near_per_m, f64::INFINITY);
        let infinite = FocusRange::new(0.0, 1.0);
        assert!(infinite.far_per_m < 0.0 && infinite.near_per_m > 0.0);
    }
}
