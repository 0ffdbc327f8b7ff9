//! Depth that was averaged at edges, by a filter or over the motion of a shutter, divided between both sides again.
//!
//! Between two surfaces such a pass holds distances at which there is nothing. An average says how much of a pixel either side covers: with
//! z the mean of the distances n of the near side and f of the far one, the near side covers (f - z) / (f - n) of it. The pixel gets the depth of the
//! side that covers more of it, and its light is divided by [`AveragedDepth::divide`].

use crate::occlusion::{OtherSides, far_part};
use crate::{Plane, VergencePass};
use rayon::prelude::*;

/// Directions of the lines on which edges are searched for.
const DIRECTIONS: [(i64, i64); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];
/// Least relative step from pixel to pixel on an edge.
const LEAST_STEP: f32 = 0.002;
/// Least ratio of the distances of both sides.
const LEAST_RATIO: f32 = 1.1;
/// The step, as a share of the largest one of an edge, below which the edge ends: tails of a filter.
const TAIL: f32 = 0.05;
/// Pixels beside an edge that must be even, to this share of the edge.
const BESIDE: i64 = 3;
const EVEN: f32 = 0.1;
/// Share of the edge at the middle of an average. A surface at a slant between two walls, linear in the reciprocal of distance, has come less far.
const HALFWAY: [f32; 2] = [0.3, 0.7];
/// Ratio of distances from which both can be distinguished.
const CLEAR_RATIO: f32 = 2.5;
/// Most edges to follow from an average to what covers a pixel alone.
const MOST_ENDS: usize = 8;

/// The quantity that a depth pass is an average of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AveragedQuantity {
    /// Distance.
    Distance,
    /// One over distance.
    Vergence,
}

/// The pixels of a depth pass that are averages of two sides.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragedDepth {
    width: usize,
    pixels: Vec<AveragedPixel>,
    /// Share of each pixel of the plate that the side which covers less of it covers; zero where there is one side.
    share: Vec<f32>,
    /// Vergence of that side.
    vergence: Vec<f32>,
}

/// A pixel that is an average.
#[derive(Debug, Clone, Copy, PartialEq)]
struct AveragedPixel {
    index: usize,
    /// Share that the near side covers.
    coverage: f32,
    /// Pixels of the near and the far side next to the edge.
    near: usize,
    far: usize,
    /// Steps from each of them away from the edge, columns and rows.
    from_near: (i64, i64),
    from_far: (i64, i64),
}

impl AveragedDepth {
    /// Finds averages of up to `most_px` pixels in `vergence`, row-major, `width` pixels wide, and gives their pixels the vergence of the
    /// side that covers more of them. `None` without any.
    pub fn repair(
        vergence: &mut [f32],
        width: usize,
        most_px: f64,
        quantity: AveragedQuantity,
    ) -> Option<Self> {
        let values: Vec<f32> = match quantity {
            AveragedQuantity::Distance => vergence.iter().map(|v| 1.0 / v).collect(),
            AveragedQuantity::Vergence => vergence.to_vec(),
        };
        let lines = DepthLines {
            values: &values,
            quantity,
            size: [width as i64, (vergence.len() / width.max(1)) as i64],
            most_px: most_px.ceil() as i64,
        };
        let pixels = (0..vergence.len()).into_par_iter();
        let mut pixels: Vec<AveragedPixel> =
            pixels.filter_map(|index| lines.pixel(index)).collect();
        lines.follow_ends(&mut pixels);
        if pixels.is_empty() {
            return None;
        }
        let mut share = vec![0.0; vergence.len()];
        let mut other = vergence.to_vec();
        for pixel in &pixels {
            let sides = [vergence[pixel.near], vergence[pixel.far]];
            let is_near = pixel.is_near();
            share[pixel.index] = pixel.coverage.min(1.0 - pixel.coverage);
            other[pixel.index] = sides[usize::from(is_near)];
        }
        let ends = |pixel: &AveragedPixel| {
            let end = if pixel.is_near() {
                pixel.near
            } else {
                pixel.far
            };
            (pixel.index, vergence[end])
        };
        let own: Vec<(usize, f32)> = pixels.iter().map(ends).collect();
        for (index, own) in own {
            vergence[index] = own;
        }
        Some(Self {
            width,
            pixels,
            share,
            vergence: other,
        })
    }

    /// Returns the pass with `left` and `right` columns and `top` and `bottom` rows about it, in which nothing is mixed.
    pub fn padded(&self, [left, top, right, bottom]: [usize; 4]) -> Self {
        let height = self.share.len() / self.width;
        let width = left + self.width + right;
        let place = |index: usize| (index / self.width + top) * width + index % self.width + left;
        let mut share = vec![0.0; width * (top + height + bottom)];
        let mut vergence = share.clone();
        for (index, (s, v)) in self.share.iter().zip(&self.vergence).enumerate() {
            (share[place(index)], vergence[place(index)]) = (*s, *v);
        }
        let pixels = self.pixels.iter().map(|pixel| AveragedPixel {
            index: place(pixel.index),
            near: place(pixel.near),
            far: place(pixel.far),
            ..*pixel
        });
        Self {
            width,
            pixels: pixels.collect(),
            share,
            vergence,
        }
    }

    /// Vergence of the side that covers less of each pixel.
    pub fn other_vergence(&self) -> VergencePass<'_> {
        VergencePass::PerPixel(&self.vergence)
    }

    /// Returns the other sides of pixels with the light of `planes`, at `vergence`; `None` without a vergence of each pixel.
    pub fn other_sides<'a>(
        &'a self,
        planes: &'a [&'a [f32]],
        vergence: VergencePass<'a>,
    ) -> Option<OtherSides<'a>> {
        let VergencePass::PerPixel(vergence) = vergence else {
            return None;
        };
        Some(OtherSides {
            planes,
            share: &self.share,
            vergence,
        })
    }

    /// Divides the light of `planes` between both sides.
    ///
    /// The light of a side is that of the pixels beside the edge. What the mixture of both leaves of a pixel goes to both.
    pub fn divide(&self, planes: &[Plane]) -> DividedLight {
        let divided = planes
            .par_iter()
            .map(|plane| self.divide_plane(plane.samples));
        let (own, other) = divided.unzip();
        DividedLight { own, other }
    }

    fn divide_plane(&self, samples: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let limit = samples.iter().copied().fold(0.0, f32::max);
        let mut own = samples.to_vec();
        let mut other = vec![0.0; samples.len()];
        for pixel in &self.pixels {
            let near = self.mean_beside(samples, pixel.near, pixel.from_near);
            let far = self.mean_beside(samples, pixel.far, pixel.from_far);
            let (light, a) = (samples[pixel.index], pixel.coverage);
            let of_far = far_part(light, a, [far, near], limit);
            (own[pixel.index], other[pixel.index]) = if pixel.is_near() {
                ((light - of_far) / a, of_far)
            } else {
                (of_far / (1.0 - a), light - of_far)
            };
        }
        (own, other)
    }

    /// Returns the mean of the samples from pixel `end` of an edge away from it.
    fn mean_beside(&self, samples: &[f32], end: usize, step: (i64, i64)) -> f32 {
        let (width, height) = (self.width as i64, (samples.len() / self.width) as i64);
        let (column, row) = (end as i64 % width, end as i64 / width);
        let at = |k: i64| {
            let x = (column + k * step.0).clamp(0, width - 1);
            let y = (row + k * step.1).clamp(0, height - 1);
            samples[(y * width + x) as usize]
        };
        (1..=BESIDE).map(at).sum::<f32>() / BESIDE as f32
    }
}

impl AveragedPixel {
    /// Whether the near side covers more of it.
    fn is_near(&self) -> bool {
        self.coverage >= 0.5
    }
}

/// Planes of a plate whose pixels have one side each, and the light of their other sides.
pub struct DividedLight {
    /// Samples of each plane, as if the side that covers more of a pixel covered all of it.
    pub own: Vec<Vec<f32>>,
    /// Light of the other side, multiplied by its share of the pixel.
    pub other: Vec<Vec<f32>>,
}

impl DividedLight {
    /// Returns the light of the other side in each plane.
    pub fn others(&self) -> Vec<&[f32]> {
        self.other.iter().map(Vec::as_slice).collect()
    }

    /// Returns `planes` with the samples of the sides that cover more of their pixels.
    pub fn own_sides<'a>(&'a self, planes: &[Plane<'a>]) -> Vec<Plane<'a>> {
        let own = self.own.iter().zip(planes);
        own.map(|(samples, plane)| Plane { samples, ..*plane })
            .collect()
    }
}

/// The lines of a depth pass.
struct DepthLines<'a> {
    values: &'a [f32],
    quantity: AveragedQuantity,
    size: [i64; 2],
    /// Longest edge, px.
    most_px: i64,
}

/// An edge along a line through a pixel.
struct LineEdge {
    /// Pixels from this one to the ends before and after it.
    before: i64,
    after: i64,
    /// Difference of its ends.
    span: f32,
}

impl DepthLines<'_> {
    /// Moves ends that are averages themselves, on an edge across this one, to the ends of theirs: where something in motion is narrower than its
    /// way, no pixel of a line along the motion shows it alone.
    fn follow_ends(&self, pixels: &mut [AveragedPixel]) {
        let all = pixels.to_vec();
        let found = |index: usize| {
            let place = all.binary_search_by_key(&index, |pixel| pixel.index);
            place.ok().map(|place| all[place])
        };
        pixels.par_iter_mut().for_each(|pixel| {
            for _ in 0..MOST_ENDS {
                let Some(end) = found(pixel.near) else {
                    break;
                };
                if !self.is_nearer(self.values[end.near], self.values[pixel.near]) {
                    break;
                }
                (pixel.near, pixel.from_near) = (end.near, end.from_near);
            }
            for _ in 0..MOST_ENDS {
                let Some(end) = found(pixel.far) else {
                    break;
                };
                if !self.is_nearer(self.values[pixel.far], self.values[end.far]) {
                    break;
                }
                (pixel.far, pixel.from_far) = (end.far, end.from_far);
            }
            pixel.coverage = self.coverage(pixel.index, pixel.near, pixel.far);
        });
    }

    /// Returns the share of pixel `index` that the surface of pixel `near` covers before that of pixel `far`.
    fn coverage(&self, index: usize, near: usize, far: usize) -> f32 {
        let [z, n, f] = [index, near, far].map(|index| self.values[index]);
        ((f - z) / (f - n)).clamp(0.0, 1.0)
    }

    /// Returns pixel `index`, if it is an average on an edge. Of several edges through it the one with the largest difference counts.
    fn pixel(&self, index: usize) -> Option<AveragedPixel> {
        let at = [index as i64 % self.size[0], index as i64 / self.size[0]];
        let edges = DIRECTIONS.iter().filter_map(|step| {
            let edge = self.edge(at, *step)?;
            Some((*step, edge))
        });
        let ((right, down), edge) = edges.max_by(|(_, a), (_, b)| a.span.total_cmp(&b.span))?;
        let place = |k: i64| ((at[1] + k * down) * self.size[0] + at[0] + k * right) as usize;
        let (before, after) = (place(-edge.before), place(edge.after));
        let is_near_before = self.is_nearer(self.values[before], self.values[after]);
        let (near, far, sign) = if is_near_before {
            (before, after, -1)
        } else {
            (after, before, 1)
        };
        Some(AveragedPixel {
            index,
            coverage: self.coverage(index, near, far),
            near,
            far,
            from_near: (sign * right, sign * down),
            from_far: (-sign * right, -sign * down),
        })
    }

    fn is_nearer(&self, one: f32, other: f32) -> bool {
        match self.quantity {
            AveragedQuantity::Distance => one < other,
            AveragedQuantity::Vergence => one > other,
        }
    }

    /// Returns the value `k` steps from a pixel; `None` beyond the plate and where there is no distance.
    fn value(&self, at: [i64; 2], (right, down): (i64, i64), k: i64) -> Option<f32> {
        let (x, y) = (at[0] + k * right, at[1] + k * down);
        let is_inside = (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y);
        let value = is_inside.then(|| self.values[(y * self.size[0] + x) as usize])?;
        (value.is_finite() && value > 0.0).then_some(value)
    }

    /// Returns the edge through a pixel along one direction, if it is an average that the pixel is within.
    fn edge(&self, at: [i64; 2], step: (i64, i64)) -> Option<LineEdge> {
        let value = |k: i64| self.value(at, step, k);
        let rise = value(1)? - value(-1)?;
        if rise.abs() < LEAST_STEP * value(0)? {
            return None;
        }
        // How much one step goes on in the direction of the edge; `None` where it does not.
        let progress = |from: i64, to: i64| {
            let change = (value(to)? - value(from)?) * rise.signum();
            (change > 0.0).then_some(change)
        };
        let after = |k: i64| progress(k, k + 1);
        let before = |k: i64| progress(-k - 1, -k);
        let run = |change: &dyn Fn(i64) -> Option<f32>| -> Vec<f32> {
            (0..=self.most_px).map_while(change).collect()
        };
        let (before, after) = (run(&before), run(&after));
        let largest = before.iter().chain(&after).copied().fold(0.0, f32::max);
        let length = |run: &[f32]| {
            let tail = run.iter().position(|change| *change < TAIL * largest);
            tail.unwrap_or(run.len()) as i64
        };
        let (before, after) = (length(&before), length(&after));
        let length = before + after;
        if before == 0 || after == 0 || length < 2 || length > self.most_px + 1 {
            return None;
        }
        let (one, other) = (value(-before)?, value(after)?);
        let ratio = one.max(other) / one.min(other);
        let span = (other - one).abs();
        let beside = |k: i64, side: f32| value(k).map_or(0.0, |v| (v - side).abs());
        let uneven = beside(-before - BESIDE, one).max(beside(after + BESIDE, other));
        let middle = (after - before) as f64 / 2.0;
        let middle = 0.5 * (value(middle.floor() as i64)? + value(middle.ceil() as i64)?);
        let come = (middle - one) / (other - one);
        let is_average = ratio > LEAST_RATIO
            && uneven < EVEN * span
            && (ratio < CLEAR_RATIO || (HALFWAY[0]..HALFWAY[1]).contains(&come));
        is_average.then_some(LineEdge {
            before,
            after,
            span,
        })
    }
}
