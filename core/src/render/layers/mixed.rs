//! Pixels at depth edges that show something of both sides: their light is shared out to the two.
//!
//! Plates are anti-aliased where depth passes are not, and a pixel that is three parts foreground and one
//! part background has one depth. Given to the foreground whole it carries a sharp speck of a blurred
//! background; given to the background its light is smeared out, and the foreground's edge is ragged.
//! Of every pixel right at a jump in depth, with F and B the mean light of clean pixels of the near and
//! the far side close by, the near side's coverage is guessed by least squares from all planes at once,
//!
//!   a = ((I - B).(F - B) + v own) / (|F - B|^2 + v),   clamped to 0..1,
//!
//! where v is how much light varies within the two sides and own is 1 on the near side and 0 on the far
//! one: where the two look alike a pixel stays what its depth says. What a F + (1 - a) B lacks to I goes
//! to both sides, so that together they are the pixel.

use super::hidden::{HiddenInput, HiddenRow};
use super::pyramid::JUMP;
use rayon::prelude::*;

/// Clean pixels are looked for within this many px.
const ABOUT_PX: i64 = 2;
/// Shares less than this are left where they are.
const LEAST_SHARE: f32 = 0.01;

/// What is to be added to the plate's samples, with sign, to put the light where it belongs.
pub(super) fn shared_out(input: &HiddenInput) -> Vec<HiddenRow> {
    let sides = sides(input);
    let row = |row: usize| {
        let mut out = HiddenRow::default();
        let mut pixel = Pixel::new(input.planes.len());
        for column in 0..input.width {
            if let Some(side) = &sides[row * input.width + column]
                && pixel.look(input, &sides, (column, row), *side)
            {
                pixel.share_out(input, (column, row), *side, &mut out);
            }
        }
        out
    };
    (0..input.height).into_par_iter().map(row).collect()
}

/// A pixel right at a jump.
#[derive(Debug, Clone, Copy)]
struct Side {
    near: bool,
    /// Place of the surface on the other side.
    other: f32,
}

/// Which pixels lie at a jump; `None` are clean.
fn sides(input: &HiddenInput) -> Vec<Option<Side>> {
    let side = |index: usize| {
        let own = input.places[index];
        let (mut least, mut largest) = (own, own);
        for neighbour in about(input, (index % input.width, index / input.width), 1) {
            least = least.min(input.places[neighbour]);
            largest = largest.max(input.places[neighbour]);
        }
        let near = own - least > largest - own;
        let other = if near { least } else { largest };
        ((own - other).abs() > JUMP).then_some(Side { near, other })
    };
    (0..input.places.len()).into_par_iter().map(side).collect()
}

/// The pixels of the plate within `reach` of one.
fn about(
    input: &HiddenInput,
    (column, row): (usize, usize),
    reach: i64,
) -> impl Iterator<Item = usize> + Clone {
    let (width, height) = (input.width, input.height);
    let span = |at: usize, size: usize| {
        let reach = reach as usize;
        at.saturating_sub(reach)..(at + reach + 1).min(size)
    };
    let columns = span(column, width);
    span(row, height).flat_map(move |y| columns.clone().map(move |x| y * width + x))
}

/// What is known of a pixel at a jump.
struct Pixel {
    /// Mean light near by of the far and the near side.
    mean: [Vec<f64>; 2],
    /// How much light varies within each, summed over planes.
    spread: [f64; 2],
    /// The near side's coverage.
    coverage: f32,
}

impl Pixel {
    fn new(planes: usize) -> Self {
        Self {
            mean: [vec![0.0; planes], vec![0.0; planes]],
            spread: [0.0; 2],
            coverage: 0.0,
        }
    }

    /// Guesses the coverage of the pixel at `at`; false where one of the sides cannot be seen.
    fn look(
        &mut self,
        input: &HiddenInput,
        sides: &[Option<Side>],
        at: (usize, usize),
        side: Side,
    ) -> bool {
        let index = at.1 * input.width + at.0;
        let middle = (input.places[index] + side.other) / 2.0;
        for near in [false, true] {
            let of_side = |&other: &usize| other != index && (input.places[other] > middle) == near;
            let clean = |other: &usize| of_side(other) && sides[*other].is_none();
            let all = || about(input, at, ABOUT_PX);
            let seen = if all().any(|other| clean(&other)) {
                self.average(input, near, all().filter(clean))
            } else {
                self.average(input, near, all().filter(of_side))
            };
            if !seen {
                return false;
            }
        }
        let own = if side.near { 1.0 } else { 0.0 };
        let spread = self.spread[0] + self.spread[1] + f64::MIN_POSITIVE;
        let (mut dot, mut square) = (spread * own, spread);
        for (plane, (far, near)) in self.mean[0].iter().zip(&self.mean[1]).enumerate() {
            let light = f64::from(input.planes[plane].samples[index]);
            dot += (light - far) * (near - far);
            square += (near - far).powi(2);
        }
        self.coverage = (dot / square).clamp(0.0, 1.0) as f32;
        true
    }

    /// Mean and spread of the light of some pixels; false if there are none.
    fn average(
        &mut self,
        input: &HiddenInput,
        near: bool,
        pixels: impl Iterator<Item = usize> + Clone,
    ) -> bool {
        let side = usize::from(near);
        self.spread[side] = 0.0;
        let count = pixels.clone().count() as f64;
        if count == 0.0 {
            return false;
        }
        for (mean, plane) in self.mean[side].iter_mut().zip(input.planes) {
            let light = || pixels.clone().map(|pixel| f64::from(plane.samples[pixel]));
            *mean = light().sum::<f64>() / count;
            self.spread[side] += light().map(|v| (v - *mean).powi(2)).sum::<f64>() / count;
        }
        true
    }

    /// Moves what belongs to the other side there.
    fn share_out(
        &self,
        input: &HiddenInput,
        (column, row): (usize, usize),
        side: Side,
        out: &mut HiddenRow,
    ) {
        let index = row * input.width + column;
        let a = self.coverage;
        let moved = if side.near { 1.0 - a } else { a };
        if moved < LEAST_SHARE {
            return;
        }
        let own = input.places[index];
        // Behind what is moved to the near side the far side goes on.
        let kept = if side.near { -moved } else { 0.0 };
        for (weight, place) in [(kept, own), (moved, side.other)] {
            out.columns.push(column as u32);
            out.weights.push(weight);
            out.places.push(place);
        }
        let planes = input
            .planes
            .iter()
            .zip(self.mean[0].iter().zip(&self.mean[1]));
        let parts = planes.map(|(plane, (far, near))| {
            let (far, near) = (*far as f32, *near as f32);
            let rest = plane.samples[index] - a * near - (1.0 - a) * far;
            if side.near {
                let light = moved * (far + rest);
                (-light, light)
            } else {
                let light = moved * (near + rest);
                (moved * far - light, light)
            }
        });
        let (mut here, there): (Vec<f32>, Vec<f32>) = parts.unzip();
        here.extend(there);
        out.samples.extend(here);
    }
}
