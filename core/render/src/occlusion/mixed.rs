//! Pixels at depth edges that show something of both sides: their light is shared out to the two.
//!
//! Plates are anti-aliased where depth passes are not, and a pixel that is three parts foreground and one
//! part background has one depth. Given to the foreground whole it carries a sharp speck of a blurred
//! background; given to the background its light is smeared out, and the foreground's edge is ragged.
//! Of every pixel right at a jump in depth, with F and B the mean light of the near and the far side close
//! by, the near side's coverage is guessed by least squares from all planes at once,
//!
//!   a = ((I - B).(F - B) + v a0) / (|F - B|^2 + v),   clamped to 0..1,
//!
//! where v is 16 times the variance of light within the two sides and a0 is the near side's share of the 3 x 3
//! pixels about, with weights 1 2 1 both ways: what counts where the two look alike. What a F + (1 - a) B
//! lacks to I goes to both sides, so that together they are the pixel.

use super::hidden::{HiddenInput, HiddenRow};
use super::pyramid::JUMP;
use rayon::prelude::*;

/// The two sides are looked at within this many px.
const ABOUT_PX: i64 = 2;
/// One over the variance of coverage about its guess from depth alone: about a quarter off.
const DOUBT: f64 = 16.0;
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
    /// How much of what is about the pixel is on its own side.
    purity: f32,
}

/// What a pixel that is at no jump, or somewhat, counts as an example of its side.
fn example(side: Option<Side>) -> f64 {
    side.map_or(1.0, |side| f64::from(side.purity).powi(8))
}

/// Which pixels lie at a jump; `None` are clean.
fn sides(input: &HiddenInput) -> Vec<Option<Side>> {
    let side = |index: usize| {
        let own = input.places[index];
        let (mut least, mut largest) = (own, own);
        let (mut of_own, mut all) = (0.0, 0.0);
        for neighbour in about(input, (index % input.width, index / input.width), 1) {
            let place = input.places[neighbour];
            least = least.min(place);
            largest = largest.max(place);
            let across = neighbour % input.width != index % input.width;
            let down = neighbour / input.width != index / input.width;
            let weight = [4.0, 2.0, 1.0][usize::from(across) + usize::from(down)];
            all += weight;
            if (place - own).abs() <= JUMP {
                of_own += weight;
            }
        }
        let near = own - least > largest - own;
        let other = if near { least } else { largest };
        ((own - other).abs() > JUMP).then(|| Side {
            near,
            other,
            purity: of_own / all,
        })
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
    /// Variance of light within each, summed over planes.
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
            let of_side = about(input, at, ABOUT_PX)
                .filter(|&other| other != index && (input.places[other] > middle) == near);
            let examples = of_side.map(|other| (other, example(sides[other])));
            if !self.average(input, near, examples) {
                return false;
            }
        }
        let purity = f64::from(side.purity);
        let prior = if side.near { purity } else { 1.0 - purity };
        let spread = DOUBT * (self.spread[0] + self.spread[1]) + f64::MIN_POSITIVE;
        let (mut dot, mut square) = (spread * prior, spread);
        for (plane, (far, near)) in self.mean[0].iter().zip(&self.mean[1]).enumerate() {
            let light = f64::from(input.planes[plane].samples[index]);
            dot += (light - far) * (near - far);
            square += (near - far).powi(2);
        }
        self.coverage = (dot / square).clamp(0.0, 1.0) as f32;
        true
    }

    /// Mean and spread of the light of some pixels, each with its weight; false if there are none.
    fn average(
        &mut self,
        input: &HiddenInput,
        near: bool,
        pixels: impl Iterator<Item = (usize, f64)> + Clone,
    ) -> bool {
        let side = usize::from(near);
        self.spread[side] = 0.0;
        let total: f64 = pixels.clone().map(|(_, weight)| weight).sum();
        if total == 0.0 {
            return false;
        }
        for (mean, plane) in self.mean[side].iter_mut().zip(input.planes) {
            let light = |pixel: usize| f64::from(plane.samples[pixel]);
            let sum: f64 = pixels.clone().map(|(pixel, w)| w * light(pixel)).sum();
            *mean = sum / total;
            let squares = pixels
                .clone()
                .map(|(pixel, w)| w * (light(pixel) - *mean).powi(2));
            self.spread[side] += squares.sum::<f64>() / total;
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
