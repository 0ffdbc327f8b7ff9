//! Photographs as they are measured: counts above black.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::mosaic::Mosaic;

/// A photograph in linear counts above the black level.
#[derive(Debug, Clone, PartialEq)]
pub struct Photograph {
    /// File name, for reports.
    pub name: String,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// One plane for a mosaic, otherwise one for each channel; row-major.
    pub planes: Vec<Vec<f32>>,
    /// Channel names.
    pub channels: Vec<String>,
    /// The colour filter mosaic, if the only plane is that of a raw sensor.
    pub mosaic: Option<Mosaic>,
    /// Counts from which on a pixel is clipped.
    pub white: f32,
    /// Distance of the lights.
    pub distance: ObjectDistance,
    /// Counts per photo-electron, if the file states it.
    pub gain: Option<f64>,
    /// Errors of the samples beyond their noise.
    pub errors: SampleErrors,
    /// Pixels that must not be used (defects, dust), row-major; empty for none.
    pub bad: Vec<bool>,
}

/// Errors of samples that the noise does not show: quantisation, interpolated colours, tone curves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SampleErrors {
    /// Error relative to the signal.
    pub relative: f64,
    /// Error of centroids along each axis, px.
    pub centroid_px: f64,
    /// Error of variances of edges along their normal, px².
    pub variance_px2: f64,
    /// Distance between the values that samples can take, counts.
    pub quantum: f64,
}

impl SampleErrors {
    /// Counts as a sensor gave them.
    pub const COUNTS: Self = Self {
        relative: 0.0,
        centroid_px: 0.0,
        variance_px2: 0.0,
        quantum: 1.0,
    };
    /// Developments with a transfer function: a rough upper estimate. Interpolation of the missing colours of a mosaic adds up
    /// to 0.5 px² of variance to edges.
    pub const DEVELOPED: Self = Self {
        relative: 0.05,
        centroid_px: 0.10,
        variance_px2: 0.4,
        quantum: 1.0,
    };
    /// The same with 8 bits.
    pub const EIGHT_BIT: Self = Self {
        relative: 0.08,
        centroid_px: 0.15,
        variance_px2: 0.5,
        quantum: 1.0,
    };
}

impl Photograph {
    /// Returns the photograph with only the channels called `names`, in their order; all if there are no names.
    ///
    /// # Errors
    /// A name that is no channel of the photograph.
    pub fn restricted_to(mut self, names: &[String]) -> Result<Self> {
        if names.is_empty() {
            return Ok(self);
        }
        let missing = names.iter().find(|name| !self.channels.contains(name));
        if let Some(name) = missing {
            return Err(Error::new(
                format!("channel {name}"),
                "is not in the photograph",
                format!("choose among {}", self.channels.join(", ")),
            ));
        }
        if self.mosaic.is_none() {
            let index = |name: &String| self.channels.iter().position(|c| c == name);
            let indices: Vec<usize> = names.iter().filter_map(index).collect();
            let planes = indices.iter().map(|k| std::mem::take(&mut self.planes[*k]));
            self.planes = planes.collect();
        }
        self.channels = names.to_vec();
        Ok(self)
    }

    /// Checks the number of planes and samples.
    ///
    /// # Errors
    /// Planes or a mask of another size than stated, and no channel.
    pub fn check(&self) -> Result<()> {
        let pixels = self.width * self.height;
        let planes = if self.mosaic.is_some() {
            1
        } else {
            self.channels.len()
        };
        let fits = self.planes.len() == planes && self.planes.iter().all(|p| p.len() == pixels);
        let mask_fits = self.bad.is_empty() || self.bad.len() == pixels;
        if pixels > 0 && fits && mask_fits && !self.channels.is_empty() {
            return Ok(());
        }
        Err(Error::new(
            format!("photograph {}", self.name),
            "has planes of another number or size than stated",
            "give one plane for a mosaic, or one for each channel",
        ))
    }

    /// Returns the plane that holds the pixels of `channel`.
    pub fn plane_of(&self, channel: usize) -> usize {
        if self.mosaic.is_some() { 0 } else { channel }
    }

    /// Returns whether pixel (`x`, `y`) has a sample of `channel`.
    pub fn covers(&self, channel: usize, x: usize, y: usize) -> bool {
        match &self.mosaic {
            Some(mosaic) => mosaic.is_of(&self.channels[channel], x, y),
            None => true,
        }
    }

    /// Returns the share of all pixels that have a sample of `channel`.
    pub fn share_of(&self, channel: usize) -> f64 {
        let share = self.mosaic.map(|m| m.share_of(&self.channels[channel]));
        share.unwrap_or(1.0)
    }

    /// Returns the gain that the file states, or that of a sensor of 30 000 electrons, as most have about.
    pub fn assumed_gain(&self) -> f64 {
        const FULL_WELL: f64 = 30_000.0;
        let white = f64::from(self.white);
        let typical = if white.is_finite() {
            white / FULL_WELL
        } else {
            0.0
        };
        self.gain.unwrap_or(typical)
    }

    /// Returns the channel of every pixel of `plane` in the repeating 2 x 2 block: index 2 * (y % 2) + x % 2. `None` for
    /// colours that are not measured.
    pub fn channel_pattern(&self, plane: usize) -> [Option<usize>; 4] {
        std::array::from_fn(|k| match &self.mosaic {
            Some(_) => (0..self.channels.len()).find(|&c| self.covers(c, k % 2, k / 2)),
            None => Some(plane),
        })
    }

    /// Returns the index of the channel that lights are judged by: green, or the middle one.
    pub fn reference_channel(&self) -> usize {
        let green = self.channels.iter().position(|name| name == "G");
        green.unwrap_or(self.channels.len() / 2)
    }

    /// Returns whether pixel (`x`, `y`) must not be used.
    pub fn is_bad(&self, x: usize, y: usize) -> bool {
        self.bad.get(y * self.width + x).copied().unwrap_or(false)
    }

    /// Returns whether pixel (`x`, `y`) is clipped in any plane.
    pub fn is_clipped(&self, x: usize, y: usize) -> bool {
        let index = y * self.width + x;
        self.planes.iter().any(|plane| plane[index] >= self.white)
    }
}
