//! The offsets by which the visible texture about a block resembles itself.

use super::{ABOUT_PX, BLOCK_PX, LOCAL_PX, OFFSET_PX, Surroundings};

/// Standard deviation of the weights of the surroundings of a block, px from the block.
const ABOUT_SIGMA_PX: f32 = 6.0;
/// Number of offsets, of steps of 2 px, whose neighbours of 1 px are tried.
const TRIED: usize = 24;
/// Largest number of offsets that are used, the best of those tried.
pub(super) const USED: usize = 16;
/// T: mean squared difference, in variances, at which the weight of an offset falls to 1/e.
const TEMPERATURE: f32 = 0.5;
/// Cost of the largest offset along an axis, added to its squared difference, in variances: what is close is more alike.
const DISTANCE_COST: f32 = 0.6;
/// Distances at which the variogram is measured, px.
const RINGS_PX: [i32; 3] = [2, 4, 8];
/// Width of the transition from the local mean to continued texture, as a ratio of their errors. Chosen on the truths of
/// docs/background/depth-edges.md, among 0.3 and 0.6.
const RATIO_WIDTH: f32 = 0.6;
/// Mean squared difference of unlike pixels, in variances.
const UNLIKE: f32 = 2.0;
/// Least share of the surroundings that an offset compares.
const LEAST_OVERLAP: f32 = 0.15;
/// Least sum of the weights of visible pixels about a block.
const LEAST_WEIGHT: f32 = 4.0;
/// Least standard deviation of light over its mean.
const LEAST_CONTRAST: f32 = 0.02;
/// Side of the compared window of a block.
const WINDOW_PX: usize = BLOCK_PX + 2 * ABOUT_PX;

/// Returns the weights of the pixels of a block's window.
pub(super) fn window_weights() -> Vec<f32> {
    let beyond = |at: usize| {
        let middle = (WINDOW_PX - 1) as f32 / 2.0;
        ((at as f32 - middle).abs() - BLOCK_PX as f32 / 2.0).max(0.0) / ABOUT_SIGMA_PX
    };
    let weight = |at: usize| {
        let (x, y) = (beyond(at % WINDOW_PX), beyond(at / WINDOW_PX));
        (-0.5 * (x * x + y * y)).exp()
    };
    (0..WINDOW_PX * WINDOW_PX).map(weight).collect()
}

/// Returns every second row of a window, symmetric about its middle. Comparing all gains 0.05 dB.
fn compared_rows() -> impl Iterator<Item = usize> {
    (0..WINDOW_PX).filter(|row| row % 2 == usize::from(*row < WINDOW_PX / 2))
}

/// An offset of the texture of a block.
#[derive(Clone, Copy)]
pub(super) struct Offset {
    pub(super) x: i32,
    pub(super) y: i32,
    /// Mean squared difference, variances.
    difference: f32,
    /// The same with the cost of the distance.
    cost: f32,
    pub(super) weight: f32,
}

impl Offset {
    /// An offset with the mean squared difference of the pixels that it compares, if they are enough.
    fn new(x: i32, y: i32, difference: Option<f32>) -> Self {
        let difference = difference.unwrap_or(f32::INFINITY);
        let distance = (x as f32).hypot(y as f32) / OFFSET_PX as f32;
        Self {
            x,
            y,
            difference,
            cost: difference + DISTANCE_COST * distance,
            weight: 0.0,
        }
    }
}

/// The offsets of a block.
pub(super) struct BlockOffsets {
    /// Those to use, the best first.
    pub(super) best: Vec<Offset>,
    /// Sum of their weights.
    pub(super) weight: f32,
    /// Their mean squared difference, variances.
    difference: f32,
    /// The same of pixels [`RINGS_PX`] apart.
    rings: [f32; RINGS_PX.len()],
}

impl BlockOffsets {
    /// Returns the share of continued texture in a hidden pixel at a distance from what is visible: none where the local mean is as good.
    pub(super) fn share(&self, distance_px: f32) -> f32 {
        let (mut before, mut of_mean) = ((0.0, 0.0), UNLIKE);
        for (radius, difference) in RINGS_PX.map(|px| px as f32).into_iter().zip(self.rings) {
            if distance_px <= radius || radius == RINGS_PX[RINGS_PX.len() - 1] as f32 {
                let along = ((distance_px - before.0) / (radius - before.0)).min(1.0);
                of_mean = before.1 + along * (difference - before.1);
                break;
            }
            before = (radius, difference);
        }
        let ratio = self.difference / of_mean.clamp(f32::MIN_POSITIVE, UNLIKE);
        ((1.0 - ratio) / RATIO_WIDTH).clamp(0.0, 1.0)
    }
}

/// A row of a block's window.
struct WindowRow {
    /// Its first pixel in the surroundings.
    start: usize,
    /// Weights of its visible pixels.
    weights: [f32; WINDOW_PX],
}

/// The search for the offsets of a block.
pub(super) struct OffsetSearch<'a> {
    local: &'a Surroundings,
    rows: Vec<WindowRow>,
    /// Sum of all weights.
    weight: f32,
}

impl<'a> OffsetSearch<'a> {
    /// The search for a block that starts at `first` of a tile; `None` if too little about it is visible, or without texture.
    pub(super) fn new(local: &'a Surroundings, first: [usize; 2], weights: &[f32]) -> Option<Self> {
        let mut search = Self {
            local,
            rows: Vec::with_capacity(WINDOW_PX / 2),
            weight: 0.0,
        };
        for row in compared_rows() {
            let start = (first[1] + OFFSET_PX + row) * LOCAL_PX + first[0] + OFFSET_PX;
            let own = weights[row * WINDOW_PX..].iter().zip(&local.known[start..]);
            let mut weights = [0.0; WINDOW_PX];
            for (out, (weight, known)) in weights.iter_mut().zip(own) {
                *out = weight * known;
            }
            let sum: f32 = weights.iter().sum();
            if sum > 0.0 {
                search.weight += sum;
                search.rows.push(WindowRow { start, weights });
            }
        }
        let (mean, variance) = search.moments(&local.luminance);
        let has_texture = variance > (LEAST_CONTRAST * mean).powi(2);
        (search.weight > LEAST_WEIGHT && has_texture).then_some(search)
    }

    /// Returns the offsets to use; `None` without any.
    pub(super) fn best(&self) -> Option<BlockOffsets> {
        pulp::Arch::new().dispatch(BestOffsets(self))
    }

    /// Returns the weighted mean and the variance of a plane about the block.
    fn moments(&self, plane: &[f32]) -> (f32, f32) {
        let mean_of = |value: &dyn Fn(f32) -> f32| {
            let of_row = |row: &WindowRow| -> f32 {
                let samples = row.weights.iter().zip(&plane[row.start..]);
                samples
                    .map(|(weight, sample)| weight * value(*sample))
                    .sum()
            };
            self.rows.iter().map(of_row).sum::<f32>() / self.weight
        };
        let mean = mean_of(&|sample| sample);
        (mean, mean_of(&|sample| (sample - mean).powi(2)))
    }

    /// Returns the mean squared difference of a plane and itself moved by an offset; `None` where few pixels are visible in both.
    #[inline(always)]
    fn difference(&self, plane: &[f32], x: i32, y: i32) -> Option<f32> {
        const LANES: usize = 16;
        let moved = y as isize * LOCAL_PX as isize + x as isize;
        let (mut differences, mut compared) = ([0.0_f32; LANES], [0.0_f32; LANES]);
        for row in &self.rows {
            let start = row.start.wrapping_add_signed(moved);
            let own = &plane[row.start..row.start + WINDOW_PX];
            let other = &plane[start..start + WINDOW_PX];
            let known = &self.local.known[start..start + WINDOW_PX];
            for part in (0..WINDOW_PX).step_by(LANES) {
                for lane in 0..LANES {
                    let at = part + lane;
                    let weight = row.weights[at] * known[at];
                    let difference = own[at] - other[at];
                    compared[lane] += weight;
                    differences[lane] += weight * difference * difference;
                }
            }
        }
        let compared: f32 = compared.iter().sum();
        (compared >= LEAST_OVERLAP * self.weight)
            .then(|| differences.iter().sum::<f32>() / compared)
    }

    /// Returns the same summed over the planes of light: colours of one luminance differ.
    #[inline(always)]
    fn colour_difference(&self, x: i32, y: i32) -> Option<f32> {
        let mut sum = 0.0;
        for plane in &self.local.light {
            sum += self.difference(plane, x, y)?;
        }
        Some(sum)
    }

    /// Returns the best offsets by luminance: of those of even steps, and of the neighbours of the best.
    #[inline(always)]
    fn best_by_luminance(&self) -> Vec<Offset> {
        const STEPS: usize = OFFSET_PX + 1;
        let luminance = &self.local.luminance;
        let (_, variance) = self.moments(luminance);
        let place = |step: usize| 2 * step as i32 - OFFSET_PX as i32;
        let mut all = Vec::with_capacity(STEPS * STEPS);
        for index in 0..STEPS * STEPS {
            let (x, y) = (place(index % STEPS), place(index / STEPS));
            let difference = self.difference(luminance, x, y);
            all.push(Offset::new(x, y, difference.map(|d| d / variance)));
        }
        all[STEPS * STEPS / 2].cost = f32::INFINITY;
        let is_least = |index: usize| {
            let (x, y) = (index % STEPS, index / STEPS);
            let columns = x.saturating_sub(1)..(x + 2).min(STEPS);
            let mut rows = y.saturating_sub(1)..(y + 2).min(STEPS);
            all[index].cost.is_finite()
                && rows.all(|row| {
                    let line = &all[row * STEPS..][columns.clone()];
                    line.iter().all(|other| other.cost >= all[index].cost)
                })
        };
        let least = (0..all.len()).filter(|index| is_least(*index));
        let mut tried: Vec<Offset> = least.map(|index| all[index]).collect();
        keep_best(&mut tried, TRIED);
        for best in &mut tried {
            let start = *best;
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                let (x, y) = (start.x + dx, start.y + dy);
                let is_within = x.abs().max(y.abs()) <= OFFSET_PX as i32;
                if is_within && (x, y) != (0, 0) && (dx, dy) != (0, 0) {
                    let difference = self.difference(luminance, x, y);
                    let other = Offset::new(x, y, difference.map(|d| d / variance));
                    if other.cost < best.cost {
                        *best = other;
                    }
                }
            }
        }
        tried.sort_by_key(|offset| (offset.y, offset.x));
        tried.dedup_by_key(|offset| (offset.y, offset.x));
        keep_best(&mut tried, USED);
        tried
    }
}

/// [`OffsetSearch::best`] for `pulp::Arch::dispatch`.
struct BestOffsets<'a>(&'a OffsetSearch<'a>);

impl pulp::NullaryFnOnce for BestOffsets<'_> {
    type Output = Option<BlockOffsets>;

    #[inline(always)]
    fn call(self) -> Option<BlockOffsets> {
        let search = self.0;
        let mut variance = 0.0;
        for plane in &search.local.light {
            variance += search.moments(plane).1;
        }
        let mut best = search.best_by_luminance();
        for offset in &mut best {
            let difference = search.colour_difference(offset.x, offset.y);
            *offset = Offset::new(offset.x, offset.y, difference.map(|d| d / variance));
        }
        best.retain(|offset| offset.cost.is_finite());
        keep_best(&mut best, USED);
        let least = best.first()?.cost;
        let (mut weight, mut sum) = (0.0, 0.0);
        for offset in &mut best {
            offset.weight = ((least - offset.cost) / TEMPERATURE).exp();
            weight += offset.weight;
            sum += offset.weight * offset.difference;
        }
        let mut rings = [0.0; RINGS_PX.len()];
        for (ring, radius) in rings.iter_mut().zip(RINGS_PX) {
            let mut count = 0.0;
            for (x, y) in (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))) {
                let difference = search.colour_difference(radius * x, radius * y);
                if let Some(difference) = difference.filter(|_| (x, y) != (0, 0)) {
                    *ring += difference / variance;
                    count += 1.0;
                }
            }
            *ring /= f32::max(count, 1.0);
        }
        Some(BlockOffsets {
            difference: sum / weight,
            rings,
            best,
            weight,
        })
    }
}

/// Keeps the `count` offsets of the least cost, the best first.
fn keep_best(offsets: &mut Vec<Offset>, count: usize) {
    offsets.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    offsets.truncate(count);
}
