//! The vergences of the depth layers that a plate is cut into.
//!
//! Neighbouring layers are so close that the lens draws nearly the same kernels at both. They depend on the lens, its
//! frame and the scale alone, never on the plate's content: all tiles of a frame and all frames of a shot are cut
//! alike. They are placed one by one from vergence zero, nearer and (below zero) farther, each as far from the last
//! as the limits below allow.

use crate::{Displacement, Scene};
use rayon::prelude::*;
use seidel_optics::field::{FieldPoint, ImagePoint};

/// Largest change of kernel size from one layer to the next, as a share of the size.
pub(super) const STEP_SHARE: f64 = 0.16;
/// The same for small kernels, px: a fixed part plus a share of the size, up to a limit.
const SMALL_STEP_PX: f64 = 0.5;
const SMALL_STEP_GROWTH: f64 = 0.35;
const LARGEST_SMALL_STEP_PX: f64 = 1.5;
/// Largest change of a kernel's displacement from one layer to the next, px.
const STEP_SHIFT_PX: f64 = 0.5;
/// Longest step below a vergence of one, 1/m, and as a share of the vergence above: longer ones could jump over a
/// minimum of the blur.
const LONGEST_STEP_PER_M: f64 = 1.0;
/// Shortest step, as a share of the longest: bounds the search where blur is not continuous in vergence.
const SHORTEST_STEP_SHARE: f64 = 1.0 / 4096.0;
/// Factors of the step-size search: after a step that is too long, and for the first try of the next.
const SHRINK: f64 = 0.85;
const GROW: f64 = 1.6;
/// Longest step of a fine spacing, as a share of the vergence, and the vergence below which it is constant.
const FINE_STEP_SHARE: f64 = 0.08;
const FINE_LEAST_PER_M: f64 = 0.05;
/// The places of the frame at which the lens is probed, as shares of its width and height.
const PROBES: [(f64, f64); 7] = [
    (0.5, 0.5),
    (0.0, 0.0),
    (1.0, 0.0),
    (0.0, 1.0),
    (1.0, 1.0),
    (1.0, 0.5),
    (0.5, 1.0),
];
/// Those in corners opposite each other.
const OPPOSITE_CORNERS: [[usize; 2]; 2] = [[1, 4], [2, 3]];
/// Vergence of the nearest layer, 1/m: anything nearer than 1 mm lies on it.
const NEAREST_PER_M: f64 = 1024.0;

/// The criterion for the distance between neighbouring layers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LayerSpacing {
    /// Factor on the largest change of kernels from one layer to the next.
    pub(crate) share: f64,
    /// Whether a step is at most 8 % of the vergence, too: separates near from far where both are equally sharp.
    pub(crate) is_fine: bool,
}

impl LayerSpacing {
    /// That of a render: the change of the blur alone.
    pub(crate) const BY_BLUR: Self = Self {
        share: 1.0,
        is_fine: false,
    };
    /// That of a removal: it inverts kernels, so errors of the kernels between two layers matter more than in a render.
    pub(crate) const BY_HALF_THE_BLUR: Self = Self {
        share: 0.5,
        is_fine: false,
    };
}

/// The vergences of depth layers, from the farthest to the nearest, with the size of the blur at each.
///
/// The *coordinate* of a vergence counts layers from vergence zero. Whole numbers are layers; between two layers the
/// coordinate is linear in vergence.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DepthLayers {
    /// Ascending, 1/m.
    vergences: Vec<f64>,
    /// Largest kernel size anywhere in the frame at each layer, plate px.
    sizes: Vec<f64>,
    /// Index of the layer at vergence zero.
    zero: usize,
}

impl DepthLayers {
    /// Places layers for `scene`'s lens that enclose zero and the vergences from `lowest` to `highest`, 1/m.
    pub(crate) fn new(scene: &Scene, lowest: f64, highest: f64, spacing: LayerSpacing) -> Self {
        let probes = Probes::new(scene);
        let mut layers = Self {
            vergences: vec![0.0],
            sizes: vec![probes.at(0.0).largest_size()],
            zero: 0,
        };
        if lowest < 0.0 {
            layers.extend(&probes, -1.0, -lowest, spacing);
            layers.vergences.reverse();
            layers.sizes.reverse();
            layers.zero = layers.vergences.len() - 1;
        }
        // At least one step, so that every vergence lies between two layers.
        layers.extend(&probes, 1.0, highest.max(f64::MIN_POSITIVE), spacing);
        layers
    }

    /// Adds layers from zero towards `sign` until one lies at or beyond `end`, an absolute vergence.
    fn extend(&mut self, probes: &Probes, sign: f64, end: f64, spacing: LayerSpacing) {
        let mut low = 0.0;
        let mut low_kernels = probes.at(0.0);
        let mut step = LONGEST_STEP_PER_M;
        while low < end && low < NEAREST_PER_M {
            let longest = low.max(LONGEST_STEP_PER_M);
            let longest = if spacing.is_fine {
                longest.min(FINE_STEP_SHARE * low.max(FINE_LEAST_PER_M))
            } else {
                longest
            };
            step = (GROW * step).min(longest);
            let (high, high_kernels) = loop {
                let high = probes.at(sign * (low + step));
                let middle = probes.at(sign * (low + step / 2.0));
                let shortest = step <= SHORTEST_STEP_SHARE * longest;
                if shortest || !middle.differ_too_much(&low_kernels, &high, spacing.share) {
                    break (low + step, high);
                }
                step *= SHRINK;
            };
            self.vergences.push(sign * high);
            self.sizes.push(high_kernels.largest_size());
            (low, low_kernels) = (high, high_kernels);
        }
    }

    /// Returns the number of layers, at least two.
    pub(crate) fn len(&self) -> usize {
        self.vergences.len()
    }

    /// Returns the vergence of layer `index`, 1/m.
    pub(crate) fn vergence(&self, index: usize) -> f64 {
        self.vergences[index]
    }

    /// Returns the layer coordinate of `vergence`, clamped to the layers.
    pub(crate) fn coordinate(&self, vergence: f64) -> f32 {
        let above = self.vergences.partition_point(|layer| *layer <= vergence);
        let low = above.clamp(1, self.vergences.len() - 1) - 1;
        let (a, b) = (self.vergences[low], self.vergences[low + 1]);
        let share = ((vergence - a) / (b - a)).clamp(0.0, 1.0);
        ((low as f64 - self.zero as f64) + share) as f32
    }

    /// Returns the coordinate of layer `index`.
    pub(crate) fn coordinate_of(&self, index: usize) -> f32 {
        index as f32 - self.zero as f32
    }

    /// Returns the indices of the two layers around a coordinate, the farther first.
    pub(crate) fn around(&self, coordinate: f32) -> (usize, usize) {
        // The cast truncates towards zero, which here rounds down.
        let index = (coordinate + self.zero as f32) as usize;
        let low = index.min(self.vergences.len() - 2);
        (low, low + 1)
    }

    /// Returns the largest kernel size at a coordinate, plate px: two standard deviations, the radius of an even disc.
    pub(crate) fn size(&self, coordinate: f32) -> f32 {
        let (low, high) = self.around(coordinate);
        let share = (coordinate - self.coordinate_of(low)).clamp(0.0, 1.0);
        self.sizes[low] as f32 * (1.0 - share) + self.sizes[high] as f32 * share
    }
}

/// Kernels of all probes at one vergence: size along x, size along y, displacement along x and y, plate px.
struct Kernels(Vec<[f64; 4]>);

impl Kernels {
    fn largest_size(&self) -> f64 {
        let sizes = self.0.iter().map(|kernel| kernel[0].max(kernel[1]));
        sizes.fold(0.0, f64::max)
    }

    /// Returns whether kernels change by more than a `share` of one step from `low` through these to `high`.
    fn differ_too_much(&self, low: &Self, high: &Self, share: f64) -> bool {
        let is_tilted = Self::move_apart(low, high);
        let triples = self.0.iter().zip(&low.0).zip(&high.0);
        triples.into_iter().any(|((middle, low), high)| {
            // Twice the larger half, so that a minimum in the middle is noticed.
            let step = |k: usize| {
                2.0 * (middle[k] - low[k]).abs().max((middle[k] - high[k]).abs()) / share
            };
            let sizes = (0..2).any(|k| {
                let least = middle[k].min(low[k]).min(high[k]);
                step(k) > largest_step(if is_tilted { 0.0 } else { least })
            });
            sizes || (2..4).any(|k| step(k) > STEP_SHIFT_PX)
        })
    }

    /// Returns whether blur grows in one corner of the frame and shrinks in the opposite one from `low` to `high`: the plane of
    /// focus is tilted then, and the picture is sharp somewhere between them.
    fn move_apart(low: &Self, high: &Self) -> bool {
        let channels = low.0.len() / PROBES.len();
        let growth = |probe: usize, channel: usize| {
            let index = probe * channels + channel;
            high.0[index][0] - low.0[index][0]
        };
        OPPOSITE_CORNERS
            .iter()
            .any(|[a, b]| (0..channels).any(|c| growth(*a, c) * growth(*b, c) < 0.0))
    }
}

/// Returns the largest allowed change of kernels of `size` px from one layer to the next.
fn largest_step(size: f64) -> f64 {
    (SMALL_STEP_PX + SMALL_STEP_GROWTH * size)
        .min(LARGEST_SMALL_STEP_PX)
        .max(STEP_SHARE * size)
}

/// The field points at which the lens is probed, in all channels.
struct Probes<'a> {
    scene: &'a Scene<'a>,
    fields: Vec<FieldPoint>,
}

impl<'a> Probes<'a> {
    fn new(scene: &'a Scene<'a>) -> Self {
        let frame = scene.lens.frame();
        let (w, h) = (f64::from(frame.width_px()), f64::from(frame.height_px()));
        let fields = PROBES
            .iter()
            .map(|(x, y)| frame.field_point(ImagePoint::new(x * w, y * h)))
            .collect();
        Self { scene, fields }
    }

    fn at(&self, vergence: f64) -> Kernels {
        let Scene {
            lens,
            map,
            displacement,
            ..
        } = *self.scene;
        let channels = lens.channel_count();
        let kernel = |index: usize| {
            let field = self.fields[index / channels];
            let placed = lens.unclamped_blur_at(index % channels, field, vergence);
            let moments = placed.blur.moments;
            let size = |variance: f64| 2.0 * variance.max(0.0).sqrt() * map.scale;
            let (x, y) = placed.displacement_px;
            let shift = [x * map.scale, y * map.scale];
            [size(moments.mu20), size(moments.mu02), shift[0], shift[1]]
        };
        let count = channels * self.fields.len();
        let mut kernels: Vec<[f64; 4]> = (0..count).into_par_iter().map(kernel).collect();
        for of_field in kernels.chunks_exact_mut(channels.max(1)) {
            keep_displacement(displacement, of_field);
        }
        Kernels(kernels)
    }
}

/// Reduces the displacements of one field point's channels to what the scene keeps of them.
fn keep_displacement(displacement: Displacement, kernels: &mut [[f64; 4]]) {
    for k in 2..4 {
        let mean = kernels.iter().map(|kernel| kernel[k]).sum::<f64>() / kernels.len() as f64;
        for kernel in &mut *kernels {
            match displacement {
                Displacement::None => kernel[k] = 0.0,
                Displacement::Lateral => kernel[k] -= mean,
                Displacement::Full => {}
            }
        }
    }
}
