//! Negative results of non-negative plates, which are errors of the renderer, removed within its stated accuracy.

use rayon::prelude::*;

use seidel_render::{RenderWindow, Scene};

use crate::settings::Quality;

/// Side of the blocks whose mean is the brightness about a pixel, on a grid fixed to the frame, px.
const BLOCK_PX: usize = 32;

impl Quality {
    /// The root-mean-square error that the quality states, as a share of the brightness about a pixel: 45 dB, 60 dB, and
    /// the rounding of sums of single precision.
    fn accuracy(self) -> f32 {
        match self {
            Self::Draft => 5.6e-3,
            Self::Final => 1e-3,
            Self::Exact => 1e-6,
        }
    }
}

/// Sets negative samples of `out`, the `window` of the blurred `plane`, to zero where they are no larger than the accuracy
/// of `quality`. Every PSF is non-negative: a plane without negative light has none after blur. A plane with negative
/// samples keeps its result.
pub(crate) fn remove_undershoot(
    scene: &Scene,
    plane: &[f32],
    out: &mut [f32],
    window: RenderWindow,
    quality: Quality,
) {
    if plane.par_iter().any(|sample| *sample < 0.0) || !out.par_iter().any(|sample| *sample < 0.0) {
        return;
    }
    let brightness = Brightness::new(plane, scene.width, scene.place_in_cell(BLOCK_PX));
    let rows = out.par_chunks_mut(window.width).enumerate();
    rows.for_each(|(row, line)| {
        for (column, sample) in line.iter_mut().enumerate() {
            if *sample < 0.0 {
                let about = brightness.about(window.column + column, window.row + row);
                if *sample >= -quality.accuracy() * about {
                    *sample = 0.0;
                }
            }
        }
    });
}

/// Means of the blocks of a plane.
struct Brightness {
    /// Position of the plane's first pixel in its block.
    before: [usize; 2],
    columns: usize,
    rows: usize,
    means: Vec<f32>,
    /// Brightness of places without light.
    least: f32,
}

/// Brightness of places without light about them, as a share of the brightest block: rounding errors of transforms reach them.
const LEAST_SHARE: f32 = 1e-3;

impl Brightness {
    fn new(plane: &[f32], width: usize, before: [usize; 2]) -> Self {
        let height = plane.len() / width.max(1);
        let [columns, rows] = [width + before[0], height + before[1]].map(|n| n.div_ceil(BLOCK_PX));
        let pixels = |block: usize, before: usize, size: usize| {
            let first = |block: usize| (block * BLOCK_PX).saturating_sub(before).min(size);
            first(block)..first(block + 1)
        };
        let line_of_blocks = |row: usize| {
            let mut means = vec![0.0; columns];
            for row in pixels(row, before[1], height) {
                for (column, mean) in means.iter_mut().enumerate() {
                    let block = &plane[row * width..][pixels(column, before[0], width)];
                    *mean += block.iter().sum::<f32>() / (BLOCK_PX * BLOCK_PX) as f32;
                }
            }
            means
        };
        let lines: Vec<Vec<f32>> = (0..rows).into_par_iter().map(line_of_blocks).collect();
        let means = lines.concat();
        Self {
            before,
            columns,
            rows,
            least: LEAST_SHARE * means.iter().copied().fold(0.0, f32::max),
            means,
        }
    }

    /// Returns the brightest mean of the block of a pixel and those around it.
    fn about(&self, column: usize, row: usize) -> f32 {
        let near = |at: usize, axis: usize, count: usize| {
            let block = (at + self.before[axis]) / BLOCK_PX;
            block.saturating_sub(1)..(block + 2).min(count)
        };
        let mut most = self.least;
        for y in near(row, 1, self.rows) {
            for x in near(column, 0, self.columns) {
                most = most.max(self.means[y * self.columns + x]);
            }
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
    use seidel_optics::psf::Gaussian;
    use seidel_render::{BlurField, DisplacedBlur, Displacement, PlateMap, VergencePass};

    /// A lens of which only the frame counts.
    struct FrameOnly;

    impl BlurField for FrameOnly {
        fn frame(&self) -> Frame {
            Frame::new(64, 64, None).expect("a valid frame")
        }

        fn channel_count(&self) -> usize {
            0
        }

        fn blur_at(&self, _: usize, _: FieldPoint, _: f64) -> DisplacedBlur {
            unreachable!("there are no channels")
        }
    }

    #[test]
    fn only_small_negative_results_of_non_negative_planes_are_removed() {
        let (width, height) = (70, 40);
        let scene = Scene {
            lens: &FrameOnly,
            model: &Gaussian,
            width,
            height,
            map: PlateMap {
                origin: ImagePoint::new(0.0, 0.0),
                scale: 1.0,
            },
            vergence: VergencePass::Constant(0.0),
            edges: seidel_render::Edges::Mirror,
            displacement: Displacement::None,
        };
        let mut plane = vec![0.0_f32; width * height];
        plane[..32 * width].fill(1.0);
        let window = RenderWindow {
            column: 3,
            row: 2,
            width: 60,
            height: 30,
        };
        let mut out = vec![0.5; 60 * 30];
        out[7] = -0.9e-3;
        out[8] = -1.1e-3;
        let removed = |plane: &[f32], quality| {
            let mut out = out.clone();
            remove_undershoot(&scene, plane, &mut out, window, quality);
            (out[7], out[8], out[9])
        };
        assert_eq!(removed(&plane, Quality::Final), (0.0, -1.1e-3, 0.5));
        assert_eq!(removed(&plane, Quality::Draft), (0.0, 0.0, 0.5));
        assert_eq!(removed(&plane, Quality::Exact), (-0.9e-3, -1.1e-3, 0.5));
        plane[width * height - 1] = -1e-9;
        assert_eq!(removed(&plane, Quality::Final), (-0.9e-3, -1.1e-3, 0.5));
    }
}
