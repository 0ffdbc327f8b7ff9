//! Mixed pixels at depth edges: their light is split between the two sides.
//!
//! Plates are anti-aliased where depth passes are not. A pixel that is three parts foreground and one part background
//! has one depth. Assigned to the foreground as a whole it carries a sharp speck of a blurred background; assigned to
//! the background its light is smeared out and the foreground's edge is ragged.
//!
//! For every pixel at a jump in depth, with F and B the mean light of the near and the far side close by, the closest pixels above all, the
//! coverage of the near side is estimated by regularised least squares over all planes,
//!
//!   a = ((I - B).(F - B) + v a0) / (|F - B|^2 + v),   clamped to 0..1,
//!
//! in which coverage counts in proportion to the brightest light of I, F and B, so that a brighter plate is split alike;
//! v is 16 times the variance of light within the two sides, and the prior a0 is the near side's share of the
//! surrounding 3 x 3 pixels with weights 1 2 1 along both axes. The prior decides where the two sides look alike. The
//! residual of a F + (1 - a) B goes to both sides, so that together they equal the pixel; each stays within bounds set by I,
//! F and B.

use super::background::Background;
use super::cell_pyramid::JUMP;
use super::depth_layers::DepthLayers;
use super::extra_samples::ExtraSamples;
use super::layered_plate::LayeredPlate;
use crate::Plane;
use rayon::prelude::*;

/// Radius within which the two sides are averaged, px.
const RADIUS_PX: usize = 2;
/// One over the variance of the prior: its standard deviation is a quarter.
const PRIOR_PRECISION: f64 = 16.0;
/// Weight of a difference of coverage beside one of light as large as the brightest close by. Chosen on `element` of docs/background/depth-edges.md:
/// with 1 its alpha is 0.1 dB worse, with 4 not better by more.
const COVERAGE_WEIGHT: f64 = 2.0;
/// Brightest part of a pixel over the pixel and the mean light of the two sides.
const BRIGHTER: f32 = 1.5;
/// Least share of a pixel's light that is moved.
const MIN_SHARE: f32 = 0.01;

/// The pixels of a plate at jumps in depth.
pub(super) struct MixedPixels {
    /// Weighted share of the surrounding pixels on the own side: less than one at jumps, one elsewhere.
    purity: Vec<f32>,
}

impl MixedPixels {
    /// Finds the pixels of `input` at jumps.
    pub(super) fn new(input: &LayeredPlate) -> Self {
        Self {
            purity: purity_of_pixels(input),
        }
    }

    /// Returns pixel `index` if it lies at a jump.
    fn edge(&self, input: &LayeredPlate, index: usize) -> Option<EdgePixel> {
        (self.purity[index] < 1.0).then(|| EdgePixel::new(input, index))
    }

    /// Returns the signed corrections of the samples of `input` that move mixed light to its side, row by row. `behind` is what the plate
    /// shows without its foreground, where that is known.
    pub(super) fn corrections(
        &self,
        input: &LayeredPlate,
        behind: Option<&CleanPlate>,
    ) -> Vec<ExtraSamples> {
        let brightest = |plane: &Plane| plane.samples.par_iter().copied().reduce(|| 0.0, f32::max);
        let brightest: Vec<f32> = input.planes.iter().map(brightest).collect();
        let row = |row: usize| {
            let mut out = ExtraSamples::default();
            let mut estimate = CoverageEstimate::new(input.planes.len());
            for column in 0..input.width {
                let index = row * input.width + column;
                let Some(edge) = self.edge(input, index) else {
                    continue;
                };
                let behind = behind.and_then(|clean| clean.behind(input, index, edge));
                if estimate.update(input, &self.purity, index, edge, behind.as_deref()) {
                    estimate.correct(input, index, edge, &brightest, &mut out);
                }
            }
            out
        };
        (0..input.height).into_par_iter().map(row).collect()
    }

    /// Returns the layer coordinate of the side of the jump that most light of pixel `index` comes from; its own away from jumps.
    pub(super) fn coordinate_of_light(&self, input: &LayeredPlate, index: usize) -> f32 {
        let own = input.coordinates[index];
        let Some(edge) = self.edge(input, index) else {
            return own;
        };
        let mut estimate = CoverageEstimate::new(input.planes.len());
        if !estimate.update(input, &self.purity, index, edge, None) {
            return own;
        }
        let (mut of_far, mut all) = (0.0, 0.0);
        let sides = estimate.mean[0].iter().zip(&estimate.mean[1]);
        for (plane, (far, near)) in input.planes[..input.light_count].iter().zip(sides) {
            let light = plane.samples[index];
            let sides = [*far as f32, *near as f32];
            of_far += far_part(light, estimate.coverage, sides, f32::MAX);
            all += light;
        }
        if (of_far > 0.5 * all) == edge.near {
            edge.other
        } else {
            own
        }
    }
}

/// The plate without its foreground, and the plate with its small lights.
pub(super) struct CleanPlate<'a> {
    pub(super) background: &'a Background<'a>,
    pub(super) layers: &'a DepthLayers,
    pub(super) with_lights: &'a LayeredPlate<'a>,
}

impl CleanPlate<'_> {
    /// Returns the light behind pixel `index` in each plane, if it is that of the far side of its jump. A pixel that lost a small light
    /// does not show it.
    fn behind(&self, input: &LayeredPlate, index: usize, edge: EdgePixel) -> Option<Vec<f64>> {
        let own = input.coordinates[index];
        let far = if edge.near { edge.other } else { own };
        let clean = self.layers.coordinate(self.background.vergence_at(index));
        let planes = input.planes.iter().zip(self.with_lights.planes);
        let has_light = planes
            .clone()
            .any(|(rest, whole)| rest.samples[index] != whole.samples[index]);
        if has_light || (clean - far).abs() > JUMP {
            return None;
        }
        let planes = self.background.planes.iter();
        Some(planes.map(|plane| f64::from(plane[index])).collect())
    }
}

/// A pixel at a jump in depth.
#[derive(Debug, Clone, Copy)]
struct EdgePixel {
    /// Whether it lies on the near side.
    near: bool,
    /// Layer coordinate of the surface on the other side.
    other: f32,
    /// Weighted share of the surrounding pixels on its own side.
    purity: f32,
}

/// Returns the weight of a pixel of the near or the far side as an example of that side's light, at a squared distance in px².
///
/// The powers were chosen on five truths of docs/background/depth-edges.md. The far side is often seen between thin things, where the closest
/// pixel is rarely pure.
fn example_weight(purity: f32, near: bool, distance_squared: f64) -> f64 {
    let purity = f64::from(purity);
    if near {
        purity.powi(2) / distance_squared.powi(3)
    } else {
        purity.powi(8) / (distance_squared * distance_squared.sqrt())
    }
}

impl EdgePixel {
    /// Pixel `index`, which lies at a jump.
    fn new(input: &LayeredPlate, index: usize) -> Self {
        let own = input.coordinates[index];
        let (mut least, mut largest) = (own, own);
        let (mut of_own, mut all) = (0.0, 0.0);
        for neighbour in input.neighbourhood(index, 1) {
            let coordinate = input.coordinates[neighbour];
            least = least.min(coordinate);
            largest = largest.max(coordinate);
            let across = neighbour % input.width != index % input.width;
            let down = neighbour / input.width != index / input.width;
            let weight = [4.0, 2.0, 1.0][usize::from(across) + usize::from(down)];
            all += weight;
            if (coordinate - own).abs() <= JUMP {
                of_own += weight;
            }
        }
        let near = own - least > largest - own;
        Self {
            near,
            other: if near { least } else { largest },
            purity: of_own / all,
        }
    }
}

/// Returns [`MixedPixels::purity`].
fn purity_of_pixels(input: &LayeredPlate) -> Vec<f32> {
    let (width, height) = (input.width, input.height);
    let mut purity = vec![1.0; width * height];
    let rows = purity.par_chunks_mut(width.max(1)).enumerate();
    rows.for_each_init(RowSpans::default, |spans, (row, out)| {
        spans.measure(input, row);
        for (column, out) in out.iter_mut().enumerate() {
            if spans.about(column) > JUMP {
                *out = EdgePixel::new(input, row * width + column).purity;
            }
        }
    });
    purity
}

/// The least and the largest layer coordinate in each column of the three rows about one.
#[derive(Default)]
struct RowSpans {
    least: Vec<f32>,
    largest: Vec<f32>,
}

impl RowSpans {
    fn measure(&mut self, input: &LayeredPlate, row: usize) {
        let line = |row: usize| &input.coordinates[row * input.width..][..input.width];
        for spans in [&mut self.least, &mut self.largest] {
            spans.clear();
            spans.extend_from_slice(line(row));
        }
        for other in [row.saturating_sub(1), (row + 1).min(input.height - 1)] {
            for (least, value) in self.least.iter_mut().zip(line(other)) {
                *least = if *value < *least { *value } else { *least };
            }
            for (largest, value) in self.largest.iter_mut().zip(line(other)) {
                *largest = if *value > *largest { *value } else { *largest };
            }
        }
    }

    /// Returns the span of the nine coordinates about a column.
    fn about(&self, column: usize) -> f32 {
        let columns = column.saturating_sub(1)..(column + 2).min(self.least.len());
        let least = self.least[columns.clone()].iter();
        let largest = self.largest[columns].iter();
        largest.fold(f32::NEG_INFINITY, |a, b| a.max(*b))
            - least.fold(f32::INFINITY, |a, b| a.min(*b))
    }
}

/// The estimated coverage of a pixel at a jump.
struct CoverageEstimate {
    /// Pixels of a side close by, with their weights.
    examples: Vec<(usize, f64)>,
    /// Mean light of the far and the near side close by, one value per plane.
    mean: [Vec<f64>; 2],
    /// Variance within each side, summed over the planes of light, and over those of coverage.
    spread: [[f64; 2]; 2],
    /// Coverage of the near side, 0 to 1.
    coverage: f32,
    /// Whether the light of the far side is known.
    far_is_known: bool,
}

impl CoverageEstimate {
    fn new(planes: usize) -> Self {
        Self {
            examples: Vec::new(),
            mean: [vec![0.0; planes], vec![0.0; planes]],
            spread: [[0.0; 2]; 2],
            coverage: 0.0,
            far_is_known: false,
        }
    }

    /// Estimates the coverage of pixel `index`, given the light of its far side if it is known; returns false where one of the sides is
    /// not visible.
    fn update(
        &mut self,
        input: &LayeredPlate,
        purity_of: &[f32],
        index: usize,
        edge: EdgePixel,
        behind: Option<&[f64]>,
    ) -> bool {
        let middle = (input.coordinates[index] + edge.other) / 2.0;
        self.far_is_known = behind.is_some();
        if let Some(behind) = behind {
            self.mean[0].copy_from_slice(behind);
            self.spread[0] = [0.0; 2];
        }
        for (side, near) in [false, true].into_iter().enumerate() {
            if self.far_is_known && !near {
                continue;
            }
            let of_side = input
                .neighbourhood(index, RADIUS_PX)
                .filter(|&other| other != index && (input.coordinates[other] > middle) == near);
            let mut examples = std::mem::take(&mut self.examples);
            examples.clear();
            examples.extend(of_side.map(|other| {
                let distance_squared = input.distance_squared(index, other);
                (
                    other,
                    example_weight(purity_of[other], near, distance_squared),
                )
            }));
            let is_visible = self.average(input, side, &examples);
            self.examples = examples;
            if !is_visible {
                return false;
            }
        }
        let purity = f64::from(edge.purity);
        let prior = if edge.near { purity } else { 1.0 - purity };
        let coverage_weight = self.coverage_weight(input, index);
        let [far, near] = self.spread;
        let spread = far[0] + near[0] + coverage_weight * (far[1] + near[1]);
        let spread = PRIOR_PRECISION * spread + f64::MIN_POSITIVE;
        let (mut dot, mut square) = (spread * prior, spread);
        for (plane, (far, near)) in self.mean[0].iter().zip(&self.mean[1]).enumerate() {
            let light = f64::from(input.planes[plane].samples[index]);
            let weight = if plane < input.light_count {
                1.0
            } else {
                coverage_weight
            };
            dot += weight * (light - far) * (near - far);
            square += weight * (near - far).powi(2);
        }
        self.coverage = (dot / square).clamp(0.0, 1.0) as f32;
        true
    }

    /// Returns the weight of coverage beside light, from the brightest light of pixel `index` and its sides.
    fn coverage_weight(&self, input: &LayeredPlate, index: usize) -> f64 {
        let light = input.planes[..input.light_count].iter();
        let of_pixel = light.map(|plane| f64::from(plane.samples[index]));
        let sides = self.mean.iter();
        let of_sides = sides.flat_map(|mean| mean[..input.light_count].iter().copied());
        let brightest = of_pixel
            .chain(of_sides)
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        if brightest > 0.0 {
            (COVERAGE_WEIGHT * brightest).powi(2)
        } else {
            1.0
        }
    }

    /// Computes mean and variance of the light of weighted pixels for `side` (0 far, 1 near); returns false without
    /// any.
    fn average(&mut self, input: &LayeredPlate, side: usize, pixels: &[(usize, f64)]) -> bool {
        self.spread[side] = [0.0; 2];
        let total: f64 = pixels.iter().map(|(_, weight)| weight).sum();
        if total == 0.0 {
            return false;
        }
        let planes = self.mean[side].iter_mut().zip(input.planes).enumerate();
        for (index, (mean, plane)) in planes {
            let light = |pixel: usize| f64::from(plane.samples[pixel]);
            let sum: f64 = pixels.iter().map(|(pixel, w)| w * light(*pixel)).sum();
            *mean = sum / total;
            let squares = pixels
                .iter()
                .map(|(pixel, w)| w * (light(*pixel) - *mean).powi(2));
            let kind = usize::from(index >= input.light_count);
            self.spread[side][kind] += squares.sum::<f64>() / total;
        }
        true
    }

    /// Returns the share of the pixel that belongs to the other side.
    fn moved(&self, edge: EdgePixel) -> f32 {
        if edge.near {
            1.0 - self.coverage
        } else {
            self.coverage
        }
    }

    /// Adds the corrections that move the other side's part of pixel `index` to that side.
    /// A side is at most as bright as the `brightest` sample of its plane.
    fn correct(
        &self,
        input: &LayeredPlate,
        index: usize,
        edge: EdgePixel,
        brightest: &[f32],
        out: &mut ExtraSamples,
    ) {
        let column = index % input.width;
        let a = self.coverage;
        let moved = self.moved(edge);
        if moved < MIN_SHARE {
            return;
        }
        let own = input.coordinates[index];
        // The far side continues behind light that is moved to the near side.
        let kept = if edge.near { -moved } else { 0.0 };
        // A known far side is whole behind the near one already.
        let there = if edge.near && self.far_is_known {
            0.0
        } else {
            moved
        };
        for (weight, coordinate) in [(kept, own), (there, edge.other)] {
            out.columns.push(column as u32);
            out.weights.push(weight);
            out.coordinates.push(coordinate);
        }
        let planes = input
            .planes
            .iter()
            .zip(self.mean[0].iter().zip(&self.mean[1]));
        let parts = planes.zip(brightest).map(|((plane, (far, near)), limit)| {
            let (far, near) = (*far as f32, *near as f32);
            let light = plane.samples[index];
            let of_far = if self.far_is_known {
                known_far_part(light, a, [far, near], *limit)
            } else {
                far_part(light, a, [far, near], *limit)
            };
            if edge.near {
                (-of_far, if self.far_is_known { 0.0 } else { of_far })
            } else {
                let of_near = light - of_far;
                (moved * far - of_near, of_near)
            }
        });
        let (mut here, there): (Vec<f32>, Vec<f32>) = parts.unzip();
        here.extend(there);
        out.samples.extend(here);
    }
}

/// Returns the part of `light` that belongs to the far side, for coverage `a` of the near side: 1 - a times the light of the far
/// side, with the residual on both sides.
///
/// The light of either side, each part over its share, is at least the least of `light`, `far`, `near` and black, and at most
/// [`BRIGHTER`] times the brightest of them, and `limit`. The mean of a side that holds a lamp says nothing about its other pixels, and
/// without bounds their residual would be a large negative light.
pub(crate) fn far_part(light: f32, a: f32, [far, near]: [f32; 2], limit: f32) -> f32 {
    let least = light.min(far).min(near).min(0.0);
    let most = (BRIGHTER * light.max(far).max(near)).min(limit);
    let rest = light - a * near - (1.0 - a) * far;
    let part = (1.0 - a) * (far + rest);
    // Bounds by the far side itself, then by what they leave to the near side. They meet at the latest where all are alike.
    let part = part.max((1.0 - a) * least).min((1.0 - a) * most);
    part.max(light - a * most).min(light - a * least)
}

/// Returns the same where `far` is the light of the far side in this pixel: 1 - a of it, or as much as leaves the near side within its
/// bounds.
fn known_far_part(light: f32, a: f32, [far, near]: [f32; 2], limit: f32) -> f32 {
    let least = light.min(far).min(near).min(0.0);
    let most = (BRIGHTER * light.max(far).max(near)).min(limit);
    ((1.0 - a) * far)
        .max(light - a * most)
        .min(light - a * least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_of_a_mixed_pixel_stay_within_the_range_around_it() {
        for (light, a, far, near) in [
            (0.3, 0.3, 0.0, 1.0),
            (0.1, 0.5, 0.1, 2e4),
            (0.1, 0.5, 2e4, 0.1),
            (1e5, 0.4, 0.2, 0.1),
            (0.9, 0.5, 0.0, 1.0),
        ] {
            let of_far = far_part(light, a, [far, near], f32::MAX);
            let sides = [of_far / (1.0 - a), (light - of_far) / a];
            let least = light.min(far).min(near).min(0.0) - 1e-6;
            let most = 1.000_001 * BRIGHTER * light.max(far).max(near);
            for side in sides {
                assert!(
                    (least..=most).contains(&side),
                    "{light} {a} {far} {near}: {side}"
                );
            }
        }
        // A pixel that is a mix of both sides is split into them.
        assert!((far_part(0.44, 0.3, [0.2, 1.0], 1.0) - 0.7 * 0.2).abs() < 1e-6);
        // Coverage stays below one.
        let of_far = far_part(0.95, 0.5, [0.4, 0.9], 1.0);
        assert!((0.95 - of_far) / 0.5 <= 1.000_001);
    }
}
