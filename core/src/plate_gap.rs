//! The gap in a plate: where a rendering of the sharp picture through a lens and the photograph differ.

use std::sync::Arc;

use seidel_calibrate::diagnose::PlacedPictures;
use seidel_optics::Progress;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_render::Displacement;

use crate::image::Image;
use crate::lens::Lens;
use crate::plate::{Depth, DepthPass, Plate};
use crate::session::LensSession;
use crate::settings::Settings;

/// Side of a block, px.
pub const PLATE_GAP_BLOCK_PX: usize = 16;
/// Lower bound of the contrast of a block's surroundings, relative to the variance of the whole plate.
const LEAST_CONTRAST: f64 = 1e-3;

/// The gap in a plate, by channel.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateGap {
    /// Columns of blocks.
    pub columns: usize,
    /// Rows of blocks.
    pub rows: usize,
    /// One entry a channel of the lens.
    pub channels: Vec<ChannelPlateGap>,
}

/// The gap in one channel of a plate.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelPlateGap {
    /// Name of the channel.
    pub channel: String,
    /// Gap of each block, row-major: the mean squared difference between photograph and rendering over the variance of the
    /// photograph in the three by three blocks around it. 0 is equal, 1 is as different as a flat picture. NaN where a
    /// picture is unknown.
    pub blocks: Vec<f64>,
    /// The same ratio of the sums over all blocks.
    pub whole: f64,
}

/// Renders the sharp picture of `pair` through `lens` at `distance`, and compares it with the photograph.
///
/// The exposure of the photograph relative to the rendering is fitted over three by three blocks, so falloff of light is no
/// gap. Noise is: it sets the least value.
///
/// # Errors
/// A lens that cannot be rendered at `distance`, a pair without one plane a channel, and cancellation.
pub fn plate_gap(
    lens: &Lens,
    pair: &PlacedPictures,
    distance: ObjectDistance,
    progress: &Progress,
) -> Result<PlateGap> {
    let names = lens.predictor().channel_names();
    if pair.sharp.len() != names.len() || pair.plate.len() != names.len() {
        return Err(Error::new(
            "pictures",
            format!("have not one plane for each of {}", names.join(", ")),
            "give one plane a channel",
        ));
    }
    let (width, height) = (pair.width, pair.height);
    let lit = |v: &f32| if v.is_finite() { *v } else { 0.0 };
    let planes = pair.sharp.iter().map(|p| p.iter().map(lit).collect());
    let image = Image::new(width, height, names.to_vec(), planes.collect())?;
    let displacement = if pair.distorted {
        Displacement::Full
    } else {
        Displacement::Lateral
    };
    let settings = Settings {
        displacement,
        ..Settings::default()
    };
    let session = Arc::new(LensSession::new(lens, &settings)?);
    let depth = pair.vergence.as_ref().map(|vergence| {
        let metres = vergence.iter().map(|v| 1.0 / v);
        Depth::Pass(DepthPass::metres(metres.collect()))
    });
    let depth = depth.unwrap_or(Depth::Distance(distance));
    let plate = session.prepare(Plate::new(image).with_depth(depth))?;
    let rendered = plate.to_image(plate.apply(progress)?)?;
    let channels = names.iter().enumerate().map(|(k, name)| {
        let expected = known(&rendered.colours[k], &pair.sharp[k], pair);
        compare(name, &pair.plate[k], &expected, width)
    });
    Ok(PlateGap {
        columns: width.div_ceil(PLATE_GAP_BLOCK_PX),
        rows: height.div_ceil(PLATE_GAP_BLOCK_PX),
        channels: channels.collect(),
    })
}

/// Compares a rendering with a photograph of the same pixels, as [`plate_gap`] does. Pixels that are not finite are unknown.
///
/// # Errors
/// Pictures of different sizes or numbers of colours.
pub fn picture_gap(photograph: &Image, rendering: &Image) -> Result<PlateGap> {
    let layout = |image: &Image| (image.width(), image.height(), image.colours.len());
    let (width, height, colours) = layout(photograph);
    if layout(rendering) != (width, height, colours) {
        let (w, h, c) = layout(rendering);
        return Err(Error::new(
            "reference",
            format!(
                "is {width} x {height} pixels of {colours} colours, and the rendering {w} x {h} of {c}"
            ),
            "give a reference of the same size and channels",
        ));
    }
    let pairs = photograph.colours.iter().zip(&rendering.colours);
    let channels = pairs.zip(&photograph.names);
    Ok(PlateGap {
        columns: width.div_ceil(PLATE_GAP_BLOCK_PX),
        rows: height.div_ceil(PLATE_GAP_BLOCK_PX),
        channels: channels
            .map(|((observed, rendered), name)| compare(name, observed, rendered, width))
            .collect(),
    })
}

/// Returns a rendering, unknown where the sharp picture is unknown within reach of the blur, as it is outside the frame.
fn known(rendered: &[f32], sharp: &[f32], pair: &PlacedPictures) -> Vec<f32> {
    let (width, height) = (pair.width, pair.height);
    let unknown = UnknownCount::new(sharp, width);
    let value = |(k, value): (usize, &f32)| {
        if unknown.any_within(k % width, k / width, pair.reach_px, height) {
            f32::NAN
        } else {
            *value
        }
    };
    rendered.iter().enumerate().map(value).collect()
}

/// Counts of unknown pixels above and left of each pixel.
struct UnknownCount {
    stride: usize,
    sums: Vec<u32>,
}

impl UnknownCount {
    fn new(plane: &[f32], width: usize) -> Self {
        let stride = width + 1;
        let mut sums = vec![0; stride * (plane.len() / width + 1)];
        for (y, row) in plane.chunks_exact(width).enumerate() {
            let mut sum = 0;
            for (x, value) in row.iter().enumerate() {
                sum += u32::from(!value.is_finite());
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + sum;
            }
        }
        Self { stride, sums }
    }

    /// Returns whether a pixel within `reach` is unknown, or outside the plane.
    fn any_within(&self, x: usize, y: usize, reach: usize, height: usize) -> bool {
        let (right, bottom) = (x + reach + 1, y + reach + 1);
        if x < reach || y < reach || right >= self.stride || bottom > height {
            return true;
        }
        let (left, top) = (x - reach, y - reach);
        let at = |x: usize, y: usize| self.sums[y * self.stride + x];
        at(right, bottom) + at(left, top) > at(left, bottom) + at(right, top)
    }
}

/// Sums over pixels of photograph and rendering.
#[derive(Debug, Clone, Copy, Default)]
struct BlockSums {
    count: f64,
    observed: f64,
    observed_squared: f64,
    product: f64,
    rendered_squared: f64,
}

impl BlockSums {
    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.observed += other.observed;
        self.observed_squared += other.observed_squared;
        self.product += other.product;
        self.rendered_squared += other.rendered_squared;
    }

    /// Returns the squared difference from the rendering at `exposure`.
    fn difference(&self, exposure: f64) -> f64 {
        let squared = self.observed_squared - 2.0 * exposure * self.product
            + exposure * exposure * self.rendered_squared;
        squared.max(0.0)
    }

    fn variance(&self) -> f64 {
        let mean = self.observed / self.count;
        self.observed_squared / self.count - mean * mean
    }
}

fn compare(name: &str, observed: &[f32], rendered: &[f32], width: usize) -> ChannelPlateGap {
    let side = PLATE_GAP_BLOCK_PX;
    let (columns, rows) = (
        width.div_ceil(side),
        (observed.len() / width).div_ceil(side),
    );
    let mut sums = vec![BlockSums::default(); columns * rows];
    for (k, (o, r)) in observed.iter().zip(rendered).enumerate() {
        let (o, r) = (f64::from(*o), f64::from(*r));
        if o.is_finite() && r.is_finite() {
            sums[k / width / side * columns + k % width / side].add(&BlockSums {
                count: 1.0,
                observed: o,
                observed_squared: o * o,
                product: o * r,
                rendered_squared: r * r,
            });
        }
    }
    let mut all = BlockSums::default();
    sums.iter().for_each(|s| all.add(s));
    let least = (LEAST_CONTRAST * all.variance()).max(f64::MIN_POSITIVE);
    let (mut difference, mut contrast) = (0.0, 0.0);
    let blocks = (0..sums.len())
        .map(|k| {
            let own = &sums[k];
            if own.count < (side * side) as f64 / 2.0 {
                return f64::NAN;
            }
            let (column, row) = (k % columns, k / columns);
            let mut around = BlockSums::default();
            for y in row.saturating_sub(1)..(row + 2).min(rows) {
                for x in column.saturating_sub(1)..(column + 2).min(columns) {
                    around.add(&sums[y * columns + x]);
                }
            }
            let exposure = around.product / around.rendered_squared.max(f64::MIN_POSITIVE);
            let variance = around.variance().max(least);
            difference += own.difference(exposure);
            contrast += own.count * variance;
            own.difference(exposure) / own.count / variance
        })
        .collect();
    ChannelPlateGap {
        channel: name.to_owned(),
        blocks,
        whole: if contrast > 0.0 {
            difference / contrast
        } else {
            f64::NAN
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A texture of `size` px that changes with the pixel.
    fn texture(size: usize) -> Vec<f32> {
        let value = |k: usize| 0.5 + 0.3 * ((k * k) as f32 * 0.37).sin();
        (0..size * size).map(value).collect()
    }

    #[test]
    fn the_gap_is_relative_to_the_local_contrast_and_ignores_exposure() {
        let rendered = texture(96);
        let darker: Vec<f32> = rendered.iter().map(|v| 0.7 * v).collect();
        let same = compare("Y", &darker, &rendered, 96);
        assert!(same.whole < 1e-6, "{}", same.whole);
        assert_eq!(same.blocks.len(), 36);
        // In one block the photograph is flat.
        let mut observed = rendered.clone();
        for (k, value) in observed.iter_mut().enumerate() {
            if (32..48).contains(&(k % 96)) && (48..64).contains(&(k / 96)) {
                *value = 0.5;
            }
        }
        let flat = compare("Y", &observed, &rendered, 96);
        let worst = (0..36).max_by(|a, b| flat.blocks[*a].total_cmp(&flat.blocks[*b]));
        assert_eq!(worst, Some(3 * 6 + 2));
        assert!((0.8..1.3).contains(&flat.blocks[20]), "{}", flat.blocks[20]);
    }

    #[test]
    fn pixels_near_unknown_ones_are_found() {
        let unknown = UnknownCount::new(&[0.0, f32::NAN, 0.0, 0.0, 0.0, 0.0], 3);
        assert!(unknown.any_within(0, 0, 1, 2) && !unknown.any_within(0, 0, 0, 2));
        let known = UnknownCount::new(&[0.0; 12], 4);
        assert!(known.any_within(0, 1, 1, 3) && known.any_within(3, 1, 1, 3));
        assert!(known.any_within(1, 0, 1, 3) && known.any_within(1, 2, 1, 3));
        assert!(!known.any_within(1, 1, 1, 3) && !known.any_within(2, 1, 1, 3));
    }
}
