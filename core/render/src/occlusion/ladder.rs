//! The vergences that slices lie at: rungs so close that the lens does nearly the same at neighbours.
//!
//! Rungs depend on the lens, its frame and the scale alone, never on the plate's content, so that all
//! tiles of a frame, and all frames of a shot, are cut alike. They are found one by one from vergence zero on,
//! nearer and (below zero) farther, each as far from the last as it may be.

use crate::{Displacement, Scene};
use seidel_optics::field::{FieldPoint, ImagePoint};

/// A step may change a kernel's size by this share of it.
pub(super) const STEP_SHARE: f64 = 0.16;
/// Steps of small kernels, px: about focus, growing with the size until the largest is reached.
const LEAST_STEP_PX: f64 = 0.5;
const STEP_GROWTH: f64 = 0.35;
const LARGEST_FIXED_STEP_PX: f64 = 1.5;
/// A step may move a displaced kernel by this much, px.
const STEP_SHIFT_PX: f64 = 0.5;
/// Longest step, 1/m, below and above a vergence of one: a minimum between two rungs must be seen.
const LONGEST_STEP_PER_M: f64 = 1.0;
/// Shortest step, as a share of the longest: lenses whose blur jumps are not followed for ever.
const SHORTEST: f64 = 1.0 / 4096.0;
/// A step that is too long is tried again this much shorter; the next is tried this much longer.
const SHORTER: f64 = 0.85;
const LONGER: f64 = 1.6;
/// Where fine steps are asked for, the share of its vergence that a step may have, and what counts for less, 1/m.
const FINE_SHARE: f64 = 0.08;
const FINE_LEAST_PER_M: f64 = 0.05;
/// Steps beyond this vergence, 1 / mm, are not told apart.
const NEAREST_PER_M: f64 = 1024.0;

/// The rungs, from the farthest to the nearest, and how large the blur is at each.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ladder {
    /// Ascending vergences, 1/m.
    rungs: Vec<f64>,
    /// Largest kernel size anywhere in the frame at each rung, plate px.
    sizes: Vec<f64>,
    /// Number of the rung at vergence zero.
    zero: usize,
}

impl Ladder {
    /// Rungs for `scene`'s lens that enclose zero and the vergences `least..=largest`; `fine` ones tell
    /// near from far even where the lens does not.
    pub(crate) fn new(scene: &Scene, (least, largest): (f64, f64), fine: bool) -> Self {
        let probes = Probes::new(scene);
        let mut ladder = Self {
            rungs: vec![0.0],
            sizes: vec![probes.at(0.0).largest_size()],
            zero: 0,
        };
        if least < 0.0 {
            ladder.climb(&probes, -1.0, -least, fine);
            ladder.rungs.reverse();
            ladder.sizes.reverse();
            ladder.zero = ladder.rungs.len() - 1;
        }
        // At least one step, so that every vergence lies between two rungs.
        ladder.climb(&probes, 1.0, largest.max(f64::MIN_POSITIVE), fine);
        ladder
    }

    /// Adds rungs from zero on, towards `sign`, until one lies at or beyond `reach`.
    fn climb(&mut self, probes: &Probes, sign: f64, reach: f64, fine: bool) {
        let mut low = 0.0;
        let mut look = probes.at(0.0);
        let mut step = LONGEST_STEP_PER_M;
        while low < reach && low < NEAREST_PER_M {
            let longest = low.max(LONGEST_STEP_PER_M);
            let longest = match fine {
                true => longest.min(FINE_SHARE * low.max(FINE_LEAST_PER_M)),
                false => longest,
            };
            step = (LONGER * step).min(longest);
            let (high, next) = loop {
                let high = probes.at(sign * (low + step));
                let middle = probes.at(sign * (low + step / 2.0));
                if step <= SHORTEST * longest || !middle.too_far_between(&look, &high) {
                    break (low + step, high);
                }
                step *= SHORTER;
            };
            self.rungs.push(sign * high);
            self.sizes.push(next.largest_size());
            (low, look) = (high, next);
        }
    }

    /// Number of rungs.
    pub(crate) fn len(&self) -> usize {
        self.rungs.len()
    }

    /// Vergence of a rung, 1/m.
    pub(crate) fn vergence(&self, rung: usize) -> f64 {
        self.rungs[rung]
    }

    /// Where `vergence` lies on the ladder: whole numbers are rungs, counted from vergence zero, and
    /// between two of them it is linear in vergence.
    pub(crate) fn place(&self, vergence: f64) -> f32 {
        let above = self.rungs.partition_point(|rung| *rung <= vergence);
        let low = above.clamp(1, self.rungs.len() - 1) - 1;
        let (a, b) = (self.rungs[low], self.rungs[low + 1]);
        let share = ((vergence - a) / (b - a)).clamp(0.0, 1.0);
        ((low as f64 - self.zero as f64) + share) as f32
    }

    /// The place of a rung.
    pub(crate) fn place_of(&self, rung: usize) -> f32 {
        rung as f32 - self.zero as f32
    }

    /// The two rungs about `place`, the farther first.
    pub(crate) fn about(&self, place: f32) -> (usize, usize) {
        // Rounds down without a call: casts cut off towards zero.
        let index = (place + self.zero as f32) as usize;
        let low = index.min(self.rungs.len() - 2);
        (low, low + 1)
    }

    /// Largest size of kernels at `place`, plate px: the radius of a disc, two standard deviations of
    /// others.
    pub(crate) fn size(&self, place: f32) -> f32 {
        let (low, high) = self.about(place);
        let share = (place - self.place_of(low)).clamp(0.0, 1.0);
        self.sizes[low] as f32 * (1.0 - share) + self.sizes[high] as f32 * share
    }
}

/// What the lens does at all probes: sizes along x and y and displacement (x, y), plate px.
struct Look(Vec<[f64; 4]>);

impl Look {
    fn largest_size(&self) -> f64 {
        let sizes = self.0.iter().map(|look| look[0].max(look[1]));
        sizes.fold(0.0, f64::max)
    }

    /// Whether kernels change too much from `low` by this one to `high` for a step.
    fn too_far_between(&self, low: &Self, high: &Self) -> bool {
        let triples = self.0.iter().zip(&low.0).zip(&high.0);
        triples.into_iter().any(|((middle, low), high)| {
            // Twice the larger half, so that a minimum in the middle is seen.
            let step = |k: usize| 2.0 * (middle[k] - low[k]).abs().max((middle[k] - high[k]).abs());
            let sizes = (0..2).any(|k| step(k) > largest_step(middle[k].min(low[k]).min(high[k])));
            sizes || (2..4).any(|k| step(k) > STEP_SHIFT_PX)
        })
    }
}

/// By how much kernels of `size` px may differ from one rung to the next.
fn largest_step(size: f64) -> f64 {
    (LEAST_STEP_PX + STEP_GROWTH * size)
        .min(LARGEST_FIXED_STEP_PX)
        .max(STEP_SHARE * size)
}

/// Where in the frame, and in which channels, the lens is asked.
struct Probes<'a> {
    scene: &'a Scene<'a>,
    fields: Vec<FieldPoint>,
}

impl<'a> Probes<'a> {
    fn new(scene: &'a Scene<'a>) -> Self {
        let frame = scene.lens.frame();
        let (w, h) = (f64::from(frame.width_px()), f64::from(frame.height_px()));
        let shares = [
            (0.5, 0.5),
            (0.0, 0.0),
            (1.0, 0.0),
            (0.0, 1.0),
            (1.0, 1.0),
            (1.0, 0.5),
            (0.5, 1.0),
        ];
        let fields = shares
            .iter()
            .map(|(x, y)| frame.field_point(ImagePoint::new(x * w, y * h)))
            .collect();
        Self { scene, fields }
    }

    fn at(&self, vergence: f64) -> Look {
        let Scene {
            lens,
            map,
            displacement,
            ..
        } = *self.scene;
        let channels = lens.channel_count();
        let mut looks = Vec::with_capacity(channels * self.fields.len());
        for &field in &self.fields {
            let placed = (0..channels).map(|channel| lens.blur_at(channel, field, vergence));
            let from = looks.len();
            looks.extend(placed.map(|placed| {
                let moments = placed.blur.moments;
                let size = |variance: f64| 2.0 * variance.max(0.0).sqrt() * map.scale;
                let (x, y) = placed.displacement_px;
                let shift = [x * map.scale, y * map.scale];
                [size(moments.mu20), size(moments.mu02), shift[0], shift[1]]
            }));
            displaced_as(displacement, &mut looks[from..]);
        }
        Look(looks)
    }
}

/// Leaves of the displacements of one field point's channels what is drawn.
fn displaced_as(displacement: Displacement, looks: &mut [[f64; 4]]) {
    for k in 2..4 {
        let mean = looks.iter().map(|look| look[k]).sum::<f64>() / looks.len() as f64;
        for look in &mut *looks {
            match displacement {
                Displacement::None => look[k] = 0.0,
                Displacement::Lateral => look[k] -= mean,
                Displacement::Full => {}
            }
        }
    }
}
