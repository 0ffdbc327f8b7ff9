//! The competitor: overlap-add convolution by Fourier transforms.
//!
//! Hat-shaped windows around the nodes of a square grid sum to one. Each windowed part of the plate is convolved with the
//! kernel at its node, and the results are added: kernels are interpolated linearly between nodes. Transforms are real,
//! of the smallest size 2^a 3^b 5^c that holds the result, and skip rows of zeros. Kernels are cut to a rectangle that
//! holds nearly all of their light.

use crate::transform::{Planner, Space, Transform, good_size};
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::field::ImagePoint;
use seidel_optics::psf::KernelRows;
use seidel_render::{Edges, Plane, Scene, VergencePass};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Nodes per thread whose results are held in memory together.
const NODES_A_THREAD: usize = 4;

/// An overlap-add renderer, for one vergence and without displacement.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OverlapAdd {
    /// Distance between nodes, px.
    pub(crate) spacing: usize,
    /// Largest share of a kernel's light that is cut off; the rest is scaled up.
    pub(crate) left_out: f64,
}

/// A finished render.
pub(crate) struct Rendered {
    pub(crate) planes: Vec<Vec<f32>>,
    /// Part of the time spent on drawing and transforming kernels.
    pub(crate) kernels: Duration,
}

/// A kernel of unit sum, row-major, relative to its source.
struct Kernel {
    left: i32,
    top: i32,
    width: usize,
    height: usize,
    weights: Vec<f32>,
}

/// One plane around one node.
struct Part {
    plane: usize,
    node: (usize, usize),
    kernel: Kernel,
}

/// The light that a part adds to the plate: a rectangle at (left, top).
struct Patch {
    plane: usize,
    left: i32,
    top: i32,
    width: usize,
    light: Vec<f32>,
}

/// Buffers of one thread.
#[derive(Default)]
struct Buffers {
    space: Space,
    light: Vec<Complex<f32>>,
    kernel: Vec<Complex<f32>>,
}

impl OverlapAdd {
    /// Blurs `planes` with the lens of `scene`; the result does not depend on the number of threads.
    pub(crate) fn render(&self, scene: &Scene, planes: &[Plane]) -> Rendered {
        let nodes_along = |size: usize| 0..size.div_ceil(self.spacing) + 1;
        let nodes: Vec<(usize, usize)> = nodes_along(scene.height)
            .flat_map(|y| nodes_along(scene.width).map(move |x| (x, y)))
            .collect();
        let threads = rayon::current_num_threads();
        let mut out = vec![vec![0.0; scene.pixel_count()]; planes.len()];
        let mut planner = Planner::default();
        let mut kernels = Duration::ZERO;
        for wave in nodes.chunks(NODES_A_THREAD * threads) {
            let start = Instant::now();
            let parts = self.parts(scene, planes, wave);
            kernels += start.elapsed();
            let planned: Vec<(&Part, Arc<Transform>)> = parts
                .iter()
                .map(|part| (part, planner.transform(self.transform_size(scene, part))))
                .collect();
            let made: Vec<(Patch, Duration)> = planned
                .par_iter()
                .map_init(Buffers::default, |buffers, (part, transform)| {
                    self.patch(scene, planes, part, transform, buffers)
                })
                .collect();
            let spent: Duration = made.iter().map(|(_, spent)| *spent).sum();
            kernels += spent / threads as u32;
            add(&made, scene, &mut out);
        }
        Rendered {
            planes: out,
            kernels,
        }
    }

    /// Returns the parts of a wave of nodes with their kernels.
    fn parts(&self, scene: &Scene, planes: &[Plane], nodes: &[(usize, usize)]) -> Vec<Part> {
        let all: Vec<_> = nodes
            .iter()
            .flat_map(|node| (0..planes.len()).map(move |plane| (*node, plane)))
            .collect();
        all.into_par_iter()
            .map_init(KernelRows::default, |rows, (node, plane)| Part {
                plane,
                node,
                kernel: self.kernel(scene, &planes[plane], node, rows),
            })
            .collect()
    }

    /// Returns the kernel of the exact model at a node.
    fn kernel(
        &self,
        scene: &Scene,
        plane: &Plane,
        node: (usize, usize),
        rows: &mut KernelRows,
    ) -> Kernel {
        let VergencePass::Constant(vergence) = scene.vergence else {
            panic!("overlap-add is for plates of one depth");
        };
        let scale = scene.map.scale;
        let along = |node: usize, origin: f64| origin + (node * self.spacing) as f64 / scale;
        let origin = scene.map.origin;
        let point = ImagePoint::new(along(node.0, origin.x_px), along(node.1, origin.y_px));
        let at = scene.lens.frame().field_point(point);
        let mut mixed: Option<Kernel> = None;
        for (channel, weight) in plane.weights.iter().enumerate() {
            if *weight == 0.0 {
                continue;
            }
            let blur = scene.lens.blur_at(channel, at, vergence).blur;
            scene
                .model
                .draw_rows(&blur.rescaled(scale), (0.0, 0.0), rows);
            let drawn = Kernel::new(rows, *weight);
            mixed = Some(match mixed {
                None => drawn,
                Some(before) => before.plus(&drawn),
            });
        }
        mixed
            .expect("a plane that sees some channel")
            .cut(self.left_out)
    }

    /// Returns the columns or rows of the window of a node along an axis of `size` pixels.
    fn window(&self, node: usize, size: usize) -> Range<usize> {
        let middle = node * self.spacing;
        middle.saturating_sub(self.spacing)..(middle + self.spacing).min(size)
    }

    fn transform_size(&self, scene: &Scene, part: &Part) -> (usize, usize) {
        let columns = self.window(part.node.0, scene.width).len();
        let rows = self.window(part.node.1, scene.height).len();
        (
            good_size(columns + part.kernel.width - 1),
            good_size(rows + part.kernel.height - 1),
        )
    }

    /// Returns the light of a part and the time of its kernel's transform.
    fn patch(
        &self,
        scene: &Scene,
        planes: &[Plane],
        part: &Part,
        transform: &Transform,
        buffers: &mut Buffers,
    ) -> (Patch, Duration) {
        let Buffers {
            space,
            light,
            kernel: spectrum,
        } = buffers;
        let kernel = &part.kernel;
        let start = Instant::now();
        let gain = 1.0 / (transform.width * transform.height) as f32;
        let row_of_kernel = |y: usize, out: &mut [f32]| {
            let weights = &kernel.weights[y * kernel.width..][..kernel.width];
            for (out, weight) in out.iter_mut().zip(weights) {
                *out = gain * weight;
            }
        };
        transform.forward(kernel.height, row_of_kernel, space, spectrum);
        let spent = start.elapsed();
        let (columns, rows) = (
            self.window(part.node.0, scene.width),
            self.window(part.node.1, scene.height),
        );
        let hat = |at: usize, node: usize| {
            let off = at as f32 + 0.5 - (node * self.spacing) as f32;
            1.0 - off.abs() / self.spacing as f32
        };
        let across: Vec<f32> = columns.clone().map(|x| hat(x, part.node.0)).collect();
        let samples = planes[part.plane].samples;
        let row_of_light = |k: usize, out: &mut [f32]| {
            let y = rows.start + k;
            let down = hat(y, part.node.1);
            let row = &samples[y * scene.width..][columns.clone()];
            for ((out, sample), across) in out.iter_mut().zip(row).zip(&across) {
                *out = down * across * sample;
            }
        };
        transform.forward(rows.len(), row_of_light, space, light);
        for (light, kernel) in light.iter_mut().zip(&*spectrum) {
            *light *= kernel;
        }
        let width = columns.len() + kernel.width - 1;
        let size = (width, rows.len() + kernel.height - 1);
        let patch = Patch {
            plane: part.plane,
            left: columns.start as i32 + kernel.left,
            top: rows.start as i32 + kernel.top,
            width,
            light: transform.back(light, size, space),
        };
        (patch, spent)
    }
}

impl Kernel {
    /// Copies a drawn kernel, scaled to a sum of `weight`.
    fn new(drawn: &KernelRows, weight: f64) -> Self {
        let (columns, rows) = (drawn.columns(), drawn.rows());
        let (width, height) = (columns.len(), rows.len());
        let mut weights = vec![0.0; width * height];
        let share = (weight / drawn.sum()) as f32;
        for span in drawn.spans() {
            let (row, column) = (span.row - rows.start, span.column - columns.start);
            let start = row as usize * width + column as usize;
            for (out, weight) in weights[start..].iter_mut().zip(span.weights) {
                *out = share * weight;
            }
        }
        Self {
            left: columns.start,
            top: rows.start,
            width,
            height,
            weights,
        }
    }

    fn plus(&self, other: &Self) -> Self {
        let (left, top) = (self.left.min(other.left), self.top.min(other.top));
        let end = |k: &Self| (k.left + k.width as i32, k.top + k.height as i32);
        let (right, bottom) = (end(self).0.max(end(other).0), end(self).1.max(end(other).1));
        let (width, height) = ((right - left) as usize, (bottom - top) as usize);
        let mut weights = vec![0.0; width * height];
        for part in [self, other] {
            let first = (part.top - top) as usize * width + (part.left - left) as usize;
            for (y, row) in part.weights.chunks_exact(part.width).enumerate() {
                for (out, weight) in weights[first + y * width..].iter_mut().zip(row) {
                    *out += weight;
                }
            }
        }
        Self {
            left,
            top,
            width,
            height,
            weights,
        }
    }

    /// Returns the rectangle that holds all but a share `left_out` of the light, scaled to the same sum.
    fn cut(&self, left_out: f64) -> Self {
        let mut across = vec![0.0_f64; self.width];
        let mut down = vec![0.0_f64; self.height];
        for (y, row) in self.weights.chunks_exact(self.width).enumerate() {
            for (across, weight) in across.iter_mut().zip(row) {
                *across += f64::from(*weight);
                down[y] += f64::from(*weight);
            }
        }
        let (columns, rows) = (inner(&across, left_out / 4.0), inner(&down, left_out / 4.0));
        let mut weights: Vec<f32> = rows
            .clone()
            .flat_map(|y| {
                self.weights[y * self.width..][columns.clone()]
                    .iter()
                    .copied()
            })
            .collect();
        let kept: f64 = weights.iter().map(|w| f64::from(*w)).sum();
        let gain = (across.iter().sum::<f64>() / kept) as f32;
        weights.iter_mut().for_each(|w| *w *= gain);
        Self {
            left: self.left + columns.start as i32,
            top: self.top + rows.start as i32,
            width: columns.len(),
            height: rows.len(),
            weights,
        }
    }
}

/// Returns the range left when at most `share` of `sums` is cut off at each end.
fn inner(sums: &[f64], share: f64) -> Range<usize> {
    let most = share * sums.iter().sum::<f64>();
    let ends = |sums: &mut dyn Iterator<Item = &f64>| {
        let mut lost = 0.0;
        sums.take_while(|sum| {
            lost += **sum;
            lost <= most
        })
        .count()
    };
    let first = ends(&mut sums.iter());
    let last = sums.len() - ends(&mut sums.iter().rev());
    first..last.max(first + 1)
}

/// Adds patches to the planes in order.
fn add(patches: &[(Patch, Duration)], scene: &Scene, planes: &mut [Vec<f32>]) {
    let Scene { width, height, .. } = *scene;
    let band = height.div_ceil(4 * rayon::current_num_threads());
    let bands = planes.iter_mut().enumerate().flat_map(|(plane, samples)| {
        let bands = samples.chunks_mut(band * width).enumerate();
        bands.map(move |(k, band_samples)| (plane, k * band, band_samples))
    });
    let bands: Vec<_> = bands.collect();
    bands.into_par_iter().for_each(|(plane, first, samples)| {
        let rows = first..first + samples.len() / width;
        for (patch, _) in patches.iter().filter(|(patch, _)| patch.plane == plane) {
            for (y, light) in patch.light.chunks_exact(patch.width).enumerate() {
                let row = fold(patch.top + y as i32, height, scene.edges);
                let Some(row) = row.filter(|row| rows.contains(row)) else {
                    continue;
                };
                let out = &mut samples[(row - first) * width..][..width];
                add_row(light, patch.left, scene.edges, out);
            }
        }
    });
}

fn add_row(light: &[f32], left: i32, edges: Edges, out: &mut [f32]) {
    let width = out.len();
    let start = ((-left).max(0) as usize).min(light.len());
    let end = ((width as i32 - left).max(0) as usize).clamp(start, light.len());
    if end > start {
        let first = (left + start as i32) as usize;
        for (out, light) in out[first..].iter_mut().zip(&light[start..end]) {
            *out += light;
        }
    }
    for k in (0..start).chain(end..light.len()) {
        if let Some(x) = fold(left + k as i32, width, edges) {
            out[x] += light[k];
        }
    }
}

/// Returns the pixel on which light at `at` lands along an axis of `size` pixels.
fn fold(at: i32, size: usize, edges: Edges) -> Option<usize> {
    let last = 2 * size as i32 - 1;
    match edges {
        Edges::Black => usize::try_from(at).ok().filter(|at| *at < size),
        Edges::Mirror => {
            let at = at.rem_euclid(last + 1);
            Some(at.min(last - at) as usize)
        }
    }
}
