//! The check that computed samples are finite.

use seidel_optics::error::{Error, Result};

/// Samples that are examined at once, without a branch: the compiler then uses vector instructions.
const BLOCK: usize = 256;

/// Returns the index of the first sample that is NaN or infinite.
pub(crate) fn first_non_finite(samples: &[f32]) -> Option<usize> {
    let is_bad = |block: &[f32]| block.iter().fold(false, |bad, v| bad | !v.is_finite());
    let block = samples.chunks(BLOCK).position(is_bad)?;
    let start = block * BLOCK;
    let within = samples[start..].iter().position(|v| !v.is_finite())?;
    Some(start + within)
}

/// A computed plane, its name, and its place on the plate.
pub(crate) struct ComputedPlane<'a> {
    /// Name of the plane in messages, such as `channel R`.
    pub(crate) name: String,
    pub(crate) samples: &'a [f32],
    pub(crate) width: usize,
    /// Column and row of the first sample, counted from the first pixel of the plate.
    pub(crate) first: [i64; 2],
}

impl ComputedPlane<'_> {
    /// Checks that all samples are finite. Inputs are finite, so that others are an overflow of the computation.
    ///
    /// # Errors
    /// The first sample that is not, by plane and pixel.
    pub(crate) fn check(&self) -> Result<()> {
        let Some(at) = first_non_finite(self.samples) else {
            return Ok(());
        };
        let x = self.first[0] + (at % self.width) as i64;
        let y = self.first[1] + (at / self.width) as i64;
        Err(Error::new(
            format!("{}, pixel ({x}, {y}) of the result", self.name),
            format!(
                "is {}, although all samples of the plate are finite",
                self.samples[at]
            ),
            "the plate holds too much light for 32-bit arithmetic: scale it down, or clip its largest samples",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_non_finite_sample_is_found_in_any_block() {
        let mut samples = vec![f32::MAX; 3 * BLOCK + 7];
        assert_eq!(first_non_finite(&samples), None);
        assert_eq!(first_non_finite(&[]), None);
        for at in [3 * BLOCK + 6, 2 * BLOCK, BLOCK + 1, 0] {
            samples[at] = if at % 2 == 0 {
                f32::NAN
            } else {
                -f32::INFINITY
            };
            assert_eq!(first_non_finite(&samples), Some(at));
        }
    }

    #[test]
    fn the_error_names_plane_and_pixel_of_the_plate() {
        let plane = ComputedPlane {
            name: "channel G".into(),
            samples: &[0.0, 0.0, 0.0, f32::INFINITY],
            width: 2,
            first: [-2, -1],
        };
        let error = plane.check().expect_err("an infinite sample");
        assert_eq!(error.place, "channel G, pixel (-1, 0) of the result");
        assert!(error.problem.starts_with("is inf"), "{error}");
    }
}
