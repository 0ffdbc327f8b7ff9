//! Highlights: small lights far brighter than their surroundings, scattered exactly.
//!
//! The errors of the fast renderer are relative to the brightest light, so a light of ten thousand would make them
//! visible around it. Pixels that stand out by far are subtracted from the plate and scattered with a kernel each.

use super::edges::add_folded;
use super::highlight_search::{HighlightBlock, HighlightCriterion, SearchArea, find_highlights};
use super::image::{Image, Rect, Size};
use super::lens_probe::LensProbe;
use crate::scatter::Source;
use crate::{Plane, RenderWindow, Scene, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::KernelRows;
use std::borrow::Cow;
use std::ops::Range;

/// Larger areas are left to the fast renderer.
const CRITERION: HighlightCriterion = HighlightCriterion {
    most: 16,
    contrast: 16.0,
    worthwhile: 4.0,
};

/// Blocks scattered before they are added to the plate; bounds the memory taken.
const WAVE: usize = 64;

/// Planes with their highlights subtracted.
pub(super) struct HighlightSplit<'a> {
    /// The rest of each plane.
    pub(super) rest: Vec<Cow<'a, [f32]>>,
    blocks: Vec<HighlightBlock>,
}

impl<'a> HighlightSplit<'a> {
    /// Splits planes that are `width` pixels wide.
    pub(super) fn new(planes: &[Plane<'a>], width: usize) -> Self {
        let blocks = find_highlights(planes, &SearchArea::whole(width), &CRITERION);
        Self::with_blocks(planes, width, blocks)
    }

    /// All light of the planes, without highlights.
    pub(super) fn none(planes: &[Plane<'a>]) -> Self {
        Self::with_blocks(planes, 0, Vec::new())
    }

    fn with_blocks(planes: &[Plane<'a>], width: usize, blocks: Vec<HighlightBlock>) -> Self {
        let rest = planes
            .iter()
            .enumerate()
            .map(|(index, plane)| without(plane.samples, index, planes.len(), width, &blocks))
            .collect();
        Self { rest, blocks }
    }

    /// Returns the number of pixels subtracted.
    pub(super) fn pixel_count(&self) -> usize {
        self.blocks.iter().map(|block| block.pixels.len()).sum()
    }

    /// Scatters the highlights of `planes` and adds them to `out`, a window of the plate.
    ///
    /// # Errors
    /// A lens that cannot be drawn at a highlight, and a cancelled render.
    pub(super) fn scatter(
        &self,
        scene: &Scene,
        window: RenderWindow,
        lens: &LensProbe,
        planes: &[Plane],
        out: &mut [Vec<f32>],
    ) -> Result<()> {
        let size = Size {
            width: scene.width,
            height: scene.height,
        };
        for wave in self.blocks.chunks(WAVE) {
            let patches = wave
                .par_iter()
                .map_init(KernelRows::default, |kernel, block| {
                    block.scattered(lens, planes, kernel)
                })
                .collect::<Result<Vec<_>>>()?;
            out.par_iter_mut().enumerate().for_each(|(plane, out)| {
                for patch in &patches {
                    add_folded(&patch[plane], size, scene.edges, window, out);
                }
            });
            if !(lens.progress)(1.0) {
                return Err(cancelled());
            }
        }
        Ok(())
    }
}

/// Returns the `samples` of plane `index` of `count` without the highlights.
fn without<'a>(
    samples: &'a [f32],
    index: usize,
    count: usize,
    width: usize,
    blocks: &[HighlightBlock],
) -> Cow<'a, [f32]> {
    let mut rest = Cow::Borrowed(samples);
    for block in blocks {
        for (&(row, column), excess) in block.pixels.iter().zip(block.excess.chunks(count)) {
            if excess[index] != 0.0 {
                rest.to_mut()[row * width + column] -= excess[index];
            }
        }
    }
    rest
}

impl HighlightBlock {
    /// Scatters the highlights into one image per plane. Neighbours share a kernel as in the exact renderer.
    fn scattered(
        &self,
        lens: &LensProbe,
        planes: &[Plane],
        kernel: &mut KernelRows,
    ) -> Result<Vec<Image>> {
        let mut images = vec![Image::default(); planes.len()];
        for channel in (0..lens.channel_count()).filter(|channel| lens.is_used(*channel)) {
            let mut rest = self.sources(lens, channel)?;
            while let Some((drawn, first)) = rest.first().cloned() {
                lens.check_cancelled()?;
                lens.model.draw_rows(&first.blur, first.shift_px, kernel);
                rest.retain(|(index, source)| {
                    let shared = *index == drawn
                        || lens.model.can_share_kernel(
                            &first.blur,
                            first.shift_px,
                            &source.blur,
                            source.shift_px,
                        );
                    if shared {
                        self.scatter_pixel(*index, channel, planes, kernel, &mut images);
                    }
                    !shared
                });
            }
        }
        Ok(images)
    }

    /// Returns the index and the source of each highlight pixel in one lens channel.
    fn sources(&self, lens: &LensProbe, channel: usize) -> Result<Vec<(usize, Source)>> {
        let mut sources = Vec::with_capacity(self.pixels.len());
        let mut found = Vec::new();
        for (index, (row, column)) in self.pixels.iter().enumerate() {
            lens.sources_at((*column as f64 + 0.5, *row as f64 + 0.5), &mut found)?;
            sources.extend(found[channel].take().map(|source| (index, source)));
        }
        Ok(sources)
    }

    /// Scatters highlight `index` as one lens channel spreads it.
    fn scatter_pixel(
        &self,
        index: usize,
        channel: usize,
        planes: &[Plane],
        kernel: &KernelRows,
        images: &mut [Image],
    ) {
        let (row, column) = self.pixels[index];
        let excess = &self.excess[index * planes.len()..];
        let (column, row) = (column as i32, row as i32);
        for ((image, plane), excess) in images.iter_mut().zip(planes).zip(excess) {
            let gain = f64::from(*excess) * plane.weights[channel] / kernel.sum();
            if gain != 0.0 {
                make_room(image, kernel, column, row);
                add(image, kernel, column, row, gain as f32);
            }
        }
    }
}

/// Extends `image` to hold `kernel` around a source pixel, with some spare room for the next highlight near by.
fn make_room(image: &mut Image, kernel: &KernelRows, column: i32, row: i32) {
    const SPARE: i32 = 4;
    let over = |start: i32, size: usize, at: i32, reach: Range<i32>| {
        let (first, end) = (at + reach.start, at + reach.end);
        if size == 0 {
            return first - SPARE..end + SPARE;
        }
        let old = start..start + size as i32;
        let start = if first < old.start {
            first - SPARE
        } else {
            old.start
        };
        start..if end > old.end { end + SPARE } else { old.end }
    };
    let columns = over(image.left, image.width, column, kernel.columns());
    let rows = over(image.top, image.height, row, kernel.rows());
    if (columns.len(), rows.len()) == (image.width, image.height) {
        return;
    }
    let mut roomy = Image::zeros(Rect {
        left: columns.start,
        top: rows.start,
        width: columns.len(),
        height: rows.len(),
    });
    for (y, line) in image.samples.chunks_exact(image.width.max(1)).enumerate() {
        let start = (image.top - roomy.top) as usize + y;
        let start = start * roomy.width + (image.left - roomy.left) as usize;
        roomy.samples[start..start + line.len()].copy_from_slice(line);
    }
    *image = roomy;
}

/// Adds `gain` times the kernel's weights around a source pixel; `image` has room for them.
fn add(image: &mut Image, kernel: &KernelRows, column: i32, row: i32, gain: f32) {
    for span in kernel.spans() {
        let start = (row + span.row - image.top) as usize * image.width;
        let start = start + (column + span.column - image.left) as usize;
        let out = &mut image.samples[start..start + span.weights.len()];
        for (light, weight) in out.iter_mut().zip(span.weights) {
            *light += gain * weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 150;
    const HEIGHT: usize = 110;

    fn split(samples: &[f32]) -> HighlightSplit<'_> {
        let weights = &[1.0];
        HighlightSplit::new(&[Plane { samples, weights }], WIDTH)
    }

    /// Uneven light from 0.1 to 0.3.
    fn plate() -> Vec<f32> {
        let value = |k: usize| 0.1 + 0.2 * ((k * 7919) % 101) as f32 / 101.0;
        (0..WIDTH * HEIGHT).map(value).collect()
    }

    /// Returns a plate with a square of light.
    fn with_light(column: usize, row: usize, side: usize, light: f32) -> Vec<f32> {
        let mut samples = plate();
        for y in row..row + side {
            samples[y * WIDTH + column..][..side].fill(light);
        }
        samples
    }

    #[test]
    fn a_plate_without_highlights_is_borrowed() {
        // A bright and a dark half, and an outstanding negative value.
        let mut samples = plate();
        samples[..WIDTH * 50].iter_mut().for_each(|v| *v *= 300.0);
        samples[WIDTH * 80 + 40] = -1e4;
        let split = split(&samples);
        assert_eq!(split.pixel_count(), 0);
        assert!(matches!(split.rest[0], Cow::Borrowed(_)));
    }

    #[test]
    fn highlights_are_subtracted_and_no_light_is_lost() {
        for (column, row) in [(0, 0), (31, 31), (97, 64), (WIDTH - 2, HEIGHT - 2)] {
            let samples = with_light(column, row, 2, 1e4);
            let split = split(&samples);
            assert_eq!(split.pixel_count(), 4);
            let mut sum = split.rest[0].to_vec();
            let most = sum.iter().copied().fold(0.0, f32::max);
            assert!(most <= 0.3, "{most}");
            for block in &split.blocks {
                for ((row, column), excess) in block.pixels.iter().zip(&block.excess) {
                    sum[row * WIDTH + column] += excess;
                }
            }
            for (sum, sample) in sum.iter().zip(&samples) {
                assert!((sum - sample).abs() <= 1e-6 * sample);
            }
        }
    }

    /// A block may hold only a few pixels of a large light, at its corner.
    #[test]
    fn large_lights_are_not_highlights() {
        for (column, row) in [(32, 32), (40, 50), (10, 7), (62, 62)] {
            let samples = with_light(column, row, 40, 1e3);
            assert_eq!(split(&samples).pixel_count(), 0, "({column}, {row})");
        }
        // Four by four pixels are a highlight, five by five are not.
        for (side, expected) in [(4, 16), (5, 0)] {
            let samples = with_light(70, 38, side, 1e3);
            assert_eq!(split(&samples).pixel_count(), expected);
        }
    }

    #[test]
    fn planes_have_highlights_of_their_own() {
        let (dark, lit) = (plate(), with_light(70, 38, 1, 1e3));
        let planes = [&dark, &lit].map(|samples| Plane {
            samples,
            weights: &[1.0],
        });
        let split = HighlightSplit::new(&planes, WIDTH);
        assert_eq!(split.pixel_count(), 1);
        assert_eq!(split.blocks[0].excess[0], 0.0);
        assert!(matches!(split.rest[0], Cow::Borrowed(_)));
        assert!(matches!(split.rest[1], Cow::Owned(_)));
    }
}
