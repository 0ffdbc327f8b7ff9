//! Kernels of a lens at single points of a plate, as arrays.

use crate::scatter::sources::{Source, Sources};
use crate::{Plane, Scene, VergencePass};
use seidel_optics::error::{Error, Result};
use seidel_optics::psf::KernelRows;

/// The kernel of one source pixel, of unit sum.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalKernel {
    /// First column, relative to the source pixel.
    pub left: i32,
    /// First row, relative to the source pixel.
    pub top: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Weights, row-major.
    pub weights: Vec<f32>,
}

impl LocalKernel {
    /// Returns the variance along both axes together, px²; 0 for a kernel without light.
    pub fn variance_px2(&self) -> f64 {
        let (mut sum, mut first, mut second) = (0.0, [0.0; 2], 0.0);
        for (k, weight) in self.weights.iter().enumerate() {
            let weight = f64::from(*weight);
            let at = [k % self.width.max(1), k / self.width.max(1)].map(|v| v as f64);
            sum += weight;
            first = [first[0] + weight * at[0], first[1] + weight * at[1]];
            second += weight * (at[0] * at[0] + at[1] * at[1]);
        }
        if sum == 0.0 {
            return 0.0;
        }
        second / sum - (first[0] * first[0] + first[1] * first[1]) / (sum * sum)
    }
}

/// The kernels of a lens at one vergence, for planes with some channel weights.
pub struct LocalKernels<'a> {
    scene: &'a Scene<'a>,
    sources: Sources<'a>,
    weights: &'a [f64],
    vergence_per_m: f64,
}

impl<'a> LocalKernels<'a> {
    /// Prepares the kernels of a plane with these channel `weights`, which sum to one.
    ///
    /// # Errors
    /// An invalid scene or weights, and a vergence that varies.
    pub fn new(scene: &'a Scene<'a>, weights: &'a [f64]) -> Result<Self> {
        let dark = vec![0.0; scene.pixel_count()];
        scene.check(&[Plane {
            samples: &dark,
            weights,
        }])?;
        let VergencePass::Constant(vergence_per_m) = scene.vergence else {
            return Err(Error::new(
                "vergence",
                "varies over the plate",
                "ask for the kernels of one vergence at a time",
            ));
        };
        Ok(Self {
            scene,
            sources: Sources::new(scene),
            weights,
            vergence_per_m,
        })
    }

    /// Returns the object vergence, 1/m.
    pub fn vergence_per_m(&self) -> f64 {
        self.vergence_per_m
    }

    /// Returns the kernel of a source at plate point `at`, px from the plate's outer corner.
    ///
    /// # Errors
    /// A lens that cannot be drawn there.
    pub fn at(&self, at: (f64, f64)) -> Result<LocalKernel> {
        let (weights, mut found) = (self.weights, Vec::new());
        let needed = |k: usize| weights[k] != 0.0;
        self.sources
            .at(at, self.vergence_per_m, needed, &mut found)?;
        Ok(weighted_sum(self.scene, &found, weights))
    }
}

/// Returns the weighted sum of the kernels of one source's channels.
pub(crate) fn weighted_sum(
    scene: &Scene,
    found: &[Option<Source>],
    weights: &[f64],
) -> LocalKernel {
    let drawn: Vec<(KernelRows, f64)> = found
        .iter()
        .zip(weights)
        .filter_map(|(source, weight)| source.as_ref().map(|s| (s, *weight)))
        .map(|(source, weight)| {
            let mut rows = KernelRows::default();
            scene
                .model
                .draw_rows(&source.blur, source.shift_px, &mut rows);
            (rows, weight)
        })
        .collect();
    let ends = |of: &dyn Fn(&KernelRows) -> std::ops::Range<i32>| {
        let ranges = drawn.iter().map(|(rows, _)| of(rows));
        ranges
            .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
            .unwrap_or(0..0)
    };
    let (columns, lines) = (ends(&|rows| rows.columns()), ends(&|rows| rows.rows()));
    let (width, height) = (columns.len(), lines.len());
    let mut kernel = LocalKernel {
        left: columns.start,
        top: lines.start,
        width,
        height,
        weights: vec![0.0; width * height],
    };
    for (rows, weight) in &drawn {
        let gain = (weight / rows.sum()) as f32;
        for span in rows.spans() {
            let (row, column) = (span.row - kernel.top, span.column - kernel.left);
            let start = row as usize * width + column as usize;
            for (out, w) in kernel.weights[start..].iter_mut().zip(span.weights) {
                *out += gain * w;
            }
        }
    }
    kernel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BlurField, DisplacedBlur, Displacement, Edges, PlateMap, VergencePass};
    use crate::{Renderer, Scatter};
    use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
    use seidel_optics::moments::MeridionalMoments;
    use seidel_optics::psf::{Gaussian, LocalBlur};

    /// A lens of two channels, one blurred more and displaced.
    struct TwoChannels(Frame);

    impl BlurField for TwoChannels {
        fn frame(&self) -> Frame {
            self.0
        }

        fn channel_count(&self) -> usize {
            2
        }

        fn blur_at(&self, channel: usize, at: FieldPoint, _vergence_per_m: f64) -> DisplacedBlur {
            let meridian = at.meridian();
            let moments = MeridionalMoments {
                mu20: 1.0 + channel as f64,
                mu02: 2.0,
                mu30: 0.0,
                mu12: 0.0,
            };
            DisplacedBlur {
                blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
                displacement_px: (1.3 * channel as f64, -0.4),
            }
        }
    }

    #[test]
    fn the_kernel_equals_the_exact_render_of_one_pixel() {
        let lens = TwoChannels(Frame::new(60, 50, None).expect("a frame"));
        let scene = Scene {
            lens: &lens,
            model: &Gaussian,
            width: 60,
            height: 50,
            map: PlateMap {
                origin: ImagePoint::new(0.0, 0.0),
                scale: 1.0,
            },
            vergence: VergencePass::Constant(0.0),
            edges: Edges::Black,
            displacement: Displacement::Full,
        };
        let (column, row, weights) = (33, 21, [0.25, 0.75]);
        let mut lit = vec![0.0; 60 * 50];
        lit[row * 60 + column] = 1.0;
        let plane = Plane {
            samples: &lit,
            weights: &weights,
        };
        let picture = Scatter.render(&scene, &[plane], &|_| true);
        let picture = picture.expect("a sound scene").planes.swap_remove(0);
        let at = (column as f64 + 0.5, row as f64 + 0.5);
        let kernel = LocalKernels::new(&scene, &weights)
            .and_then(|kernels| kernels.at(at))
            .expect("a kernel");
        let mut drawn = vec![0.0; 60 * 50];
        for (k, weight) in kernel.weights.iter().enumerate() {
            let x = column as i32 + kernel.left + (k % kernel.width) as i32;
            let y = row as i32 + kernel.top + (k / kernel.width) as i32;
            drawn[y as usize * 60 + x as usize] = *weight;
        }
        let apart = picture.iter().zip(&drawn).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f32::max) < 1e-6);
    }
}
