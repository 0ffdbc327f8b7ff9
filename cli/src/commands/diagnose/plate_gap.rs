//! `--plate-gap`: pictures of where a plate and the rendering of its sharp picture differ.

use std::path::Path;

use image::RgbImage;
use rayon::ThreadPool;
use seidel_core::diagnosis::PlacedPictures;
use seidel_core::{Lens, LensProfile, ObjectDistance, PLATE_GAP_BLOCK_PX, PlateGap, plate_gap};

use super::super::CommandError;
use crate::Console;
use crate::pictures::plate_gap::plate_gap_picture;
use seidel_image_io::error::FileError;
use seidel_image_io::formats::exr::{NewChannel, write_channels};
use seidel_image_io::formats::png::write_rgb8;
use seidel_image_io::windows::ImageWindows;

/// The files of the gap in a plate.
pub(super) const FILES: [&str; 2] = ["plate-gap.exr", "plate-gap.png"];

/// The gap in a plate with the given and the corrected lens.
pub(super) struct PlateGapMaps {
    before: PlateGap,
    after: PlateGap,
    size: (usize, usize),
    pub(super) picture: RgbImage,
}

impl PlateGapMaps {
    /// Renders the sharp picture of `pair` through the lens before and `after` its correction.
    pub(super) fn render(
        pair: &PlacedPictures,
        before: &LensProfile,
        after: &LensProfile,
        distance: ObjectDistance,
        pool: &ThreadPool,
        console: &Console,
    ) -> Result<Self, CommandError> {
        let bar = console.progress_bar("rendering");
        let gap = |lens: &LensProfile, from: f64| -> Result<PlateGap, CommandError> {
            let lens = Lens::new(lens.clone())?;
            let progress = |share: f64| bar.show(from + share / 2.0);
            Ok(pool.install(|| plate_gap(&lens, pair, distance, &progress))?)
        };
        let (before, after) = (gap(before, 0.0)?, gap(after, 0.5)?);
        let title = "Squared difference between plate and rendering";
        Ok(Self {
            picture: plate_gap_picture(title, &before, &after),
            size: (pair.width, pair.height),
            before,
            after,
        })
    }

    /// Returns a line with the gap of each channel.
    pub(super) fn summary(&self) -> String {
        let channels = self.before.channels.iter().zip(&self.after.channels);
        let parts: Vec<String> = channels
            .map(|(b, a)| format!("{} {:.4} before, {:.4} after", b.channel, b.whole, a.whole))
            .collect();
        format!(
            "plate gap (squared difference over contrast, noise included): {}",
            parts.join("; ")
        )
    }

    /// Writes the maps to `folder`: channels `before.R`, `after.R` and so on in OpenEXR, each pixel with the gap of its
    /// block, and a picture with labels.
    pub(super) fn write(&self, folder: &Path) -> Result<(), FileError> {
        let (width, height) = self.size;
        let mut planes = Vec::new();
        for (when, gap) in [("before", &self.before), ("after", &self.after)] {
            for channel in &gap.channels {
                let value = |k: usize| {
                    let (x, y) = (k % width, k / width);
                    let block = y / PLATE_GAP_BLOCK_PX * gap.columns + x / PLATE_GAP_BLOCK_PX;
                    let value = channel.blocks[block];
                    // OpenEXR viewers handle NaN badly: unknown blocks are negative.
                    if value.is_finite() {
                        value as f32
                    } else {
                        -1.0
                    }
                };
                let samples: Vec<f32> = (0..width * height).map(value).collect();
                planes.push((format!("{when}.{}", channel.channel), samples));
            }
        }
        let channels: Vec<NewChannel> = planes
            .iter()
            .map(|(name, samples)| NewChannel {
                name,
                samples,
                half: false,
            })
            .collect();
        let windows = ImageWindows::of_size(width, height);
        write_channels(&folder.join(FILES[0]), windows, &channels)?;
        write_rgb8(&folder.join(FILES[1]), &self.picture)?;
        Ok(())
    }
}
