//! What the numbers of depth passes are, and how far along the axis they say things are.

use crate::{DepthConvention, DepthReading};
use seidel_optics::error::Result;
use seidel_optics::field::ImagePoint;

/// What the numbers of a depth pass are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthMeaning {
    /// How they give a distance.
    pub convention: DepthConvention,
    /// Focal length, widths of a plate pixel, where distances are along the ray.
    pub along_ray: Option<f64>,
}

impl DepthMeaning {
    /// Vergences of the `samples` of a pass `width` px wide whose optical axis is at `axis`, plate pixels, each
    /// `pixel_aspect` times as wide as it is high.
    ///
    /// # Errors
    /// Those of [`DepthConvention::read`] and [`DepthReading::turn_along_axis`].
    pub fn read(
        &self,
        samples: &[f32],
        width: usize,
        (axis, pixel_aspect): (ImagePoint, f64),
    ) -> Result<DepthReading> {
        let mut reading = self.convention.read(samples, width)?;
        if let Some(focal_px) = self.along_ray {
            reading.turn_along_axis(width, axis, focal_px, pixel_aspect)?;
        }
        Ok(reading)
    }
}
