//! Small lights apart from the plate: the fast way's errors are shares of what is brightest, and a light of
//! ten thousand would put them where all can see. What stands out of its surroundings by far is taken off the
//! plate and scattered exactly, pixel by pixel.

use super::edges::fold_onto;
use super::image::Image;
use super::optics::Optics;
use super::{Plane, cancelled};
use crate::{RenderWindow, Scene};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::KernelRows;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// Side of the squares of the plate in which lights are looked for, px.
const SQUARE: usize = 32;

/// How many times as bright as the mean of its square and as that of the plate the brightest pixel must be for
/// the square to be looked at, and as the median for it to count as light.
const OUTSTANDING: f32 = 16.0;

/// Most pixels of a square that are scattered, in each plane; larger areas go the fast way.
const MOST_PIXELS: usize = 16;

/// How many times its limit the brightest pixel of a square must be. Less is not worth a kernel a pixel.
const WORTH: f32 = 4.0;

/// Squares scattered before they are put on the plate: bounds the memory taken.
const WAVE: usize = 64;

/// Planes with what stands out of them taken off.
pub(super) struct Split<'a> {
    /// For each plane, what is left of it.
    pub(super) rest: Vec<Cow<'a, [f32]>>,
    squares: Vec<Square>,
}

/// The lights of one square.
struct Square {
    /// Row and column of each light, row by row.
    places: Vec<(usize, usize)>,
    /// What is taken off there: one value a plane, light by light.
    excess: Vec<f32>,
}

impl<'a> Split<'a> {
    /// Of planes `width` pixels wide.
    pub(super) fn of(planes: &[Plane<'a>], width: usize) -> Self {
        let height = planes
            .first()
            .map_or(0, |plane| plane.samples.len() / width);
        let bands: Vec<Range<usize>> = (0..height)
            .step_by(SQUARE)
            .map(|row| row..height.min(row + SQUARE))
            .collect();
        let surveys: Vec<Vec<Survey>> = bands
            .par_iter()
            .map(|rows| {
                let of = |plane: &Plane| Survey::of(plane.samples, width, rows);
                planes.iter().map(of).collect()
            })
            .collect();
        let means: Vec<f64> = (0..planes.len())
            .map(|plane| mean(surveys.iter().map(|surveys| &surveys[plane])))
            .collect();
        let squares: Vec<Square> = (&bands, &surveys)
            .into_par_iter()
            .flat_map_iter(|(rows, surveys)| lights_of_band(planes, width, rows, (surveys, &means)))
            .collect();
        let rest = planes
            .iter()
            .enumerate()
            .map(|(index, plane)| without(plane.samples, index, planes.len(), width, &squares))
            .collect();
        Self { rest, squares }
    }

    /// How many pixels were taken off.
    pub(super) fn count(&self) -> usize {
        self.squares.iter().map(|square| square.places.len()).sum()
    }

    /// Scatters what was taken off `planes` and adds it to `out`, a window of the plate.
    ///
    /// # Errors
    /// A lens that cannot be drawn at a light; `progress` said stop.
    pub(super) fn scatter(
        &self,
        (scene, window): (&Scene, RenderWindow),
        optics: &Optics,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
        out: &mut [Vec<f32>],
    ) -> Result<()> {
        for wave in self.squares.chunks(WAVE) {
            let patches = wave
                .par_iter()
                .map_init(KernelRows::default, |kernel, square| {
                    square.scattered(optics, planes, kernel)
                })
                .collect::<Result<Vec<_>>>()?;
            let size = (scene.width, scene.height);
            out.par_iter_mut().enumerate().for_each(|(plane, out)| {
                for patch in &patches {
                    fold_onto(&patch[plane], size, scene.edges, window, out);
                }
            });
            if !progress(1.0) {
                return Err(cancelled());
            }
        }
        Ok(())
    }
}

/// What is left of plane `index` of `count`.
fn without<'a>(
    samples: &'a [f32],
    index: usize,
    count: usize,
    width: usize,
    squares: &[Square],
) -> Cow<'a, [f32]> {
    let mut rest = Cow::Borrowed(samples);
    for square in squares {
        for (&(row, column), excess) in square.places.iter().zip(square.excess.chunks(count)) {
            if excess[index] != 0.0 {
                rest.to_mut()[row * width + column] -= excess[index];
            }
        }
    }
    rest
}

/// Lanes of sums that are kept in registers.
const LANES: usize = 8;

/// The largest value of a square and the sum of its sizes, lane by lane.
#[derive(Clone, Copy, Default)]
struct Tally {
    most: [f32; LANES],
    sum: [f32; LANES],
}

impl Tally {
    #[inline]
    fn take(&mut self, samples: &[f32]) {
        let (blocks, rest) = samples.as_chunks::<LANES>();
        for block in blocks {
            self.block(block);
        }
        if rest.is_empty() {
            return;
        }
        let mut last = [0.0; LANES];
        last[..rest.len()].copy_from_slice(rest);
        self.block(&last);
    }

    #[inline(always)]
    fn block(&mut self, block: &[f32; LANES]) {
        for ((most, sum), v) in self.most.iter_mut().zip(&mut self.sum).zip(block) {
            *most = if *v > *most { *v } else { *most };
            *sum += v.abs();
        }
    }

    fn most(&self) -> f32 {
        self.most.iter().copied().fold(0.0, f32::max)
    }

    fn sum(&self) -> f64 {
        self.sum.iter().map(|sum| f64::from(*sum)).sum()
    }
}

/// What a row of squares of one plane holds.
#[derive(Default)]
struct Survey {
    /// Sum of sizes, and number of pixels, in squares that are not dark.
    light: f64,
    pixels: usize,
    /// Squares with a value that stands out, and the largest.
    striking: Vec<(usize, f32)>,
}

impl Survey {
    fn of(samples: &[f32], width: usize, rows: &Range<usize>) -> Self {
        let mut tallies = vec![Tally::default(); width.div_ceil(SQUARE)];
        for row in samples[rows.start * width..rows.end * width].chunks_exact(width) {
            for (tally, samples) in tallies.iter_mut().zip(row.chunks(SQUARE)) {
                tally.take(samples);
            }
        }
        let mut survey = Self::default();
        for (square, tally) in tallies.iter().enumerate() {
            let (most, sum) = (tally.most(), tally.sum());
            if sum == 0.0 {
                continue;
            }
            let count = columns_of(square, width).len() * rows.len();
            survey.light += sum;
            survey.pixels += count;
            if stands_out(most, sum / count as f64) {
                survey.striking.push((square, most));
            }
        }
        survey
    }
}

fn stands_out(most: f32, mean: f64) -> bool {
    f64::from(most) > f64::from(OUTSTANDING) * mean
}

/// Mean size of the values of a plane where it is not dark.
fn mean<'a>(surveys: impl Iterator<Item = &'a Survey>) -> f64 {
    let sum = |sum: (f64, usize), survey: &Survey| (sum.0 + survey.light, sum.1 + survey.pixels);
    let (light, pixels) = surveys.fold((0.0, 0), sum);
    light / pixels.max(1) as f64
}

/// Plate columns of a square.
fn columns_of(square: usize, width: usize) -> Range<usize> {
    square * SQUARE..width.min((square + 1) * SQUARE)
}

/// What a pixel may hold without being a light, and what stays of one that is.
#[derive(Clone, Copy)]
struct Limit {
    most: f32,
    stays: f32,
}

/// Of a plane without lights.
const NO_LIGHTS: Limit = Limit {
    most: f32::INFINITY,
    stays: 0.0,
};

/// The lights of one row of squares, given what each plane holds there and its mean.
fn lights_of_band(
    planes: &[Plane],
    width: usize,
    rows: &Range<usize>,
    (surveys, means): (&[Survey], &[f64]),
) -> Vec<Square> {
    // One a plane, for squares with lights.
    let mut limits: BTreeMap<usize, Vec<Limit>> = BTreeMap::new();
    let mut values = Vec::new();
    for (index, (plane, survey)) in planes.iter().zip(surveys).enumerate() {
        for &(square, most) in &survey.striking {
            if !stands_out(most, means[index]) {
                continue;
            }
            values.clear();
            for row in rows.clone() {
                values.extend(&plane.samples[row * width..][columns_of(square, width)]);
            }
            if let Some(limit) = limit(&mut values, most) {
                let none = || vec![NO_LIGHTS; planes.len()];
                limits.entry(square).or_insert_with(none)[index] = limit;
            }
        }
    }
    limits
        .iter()
        .map(|(square, limits)| {
            lights_of(planes, width, (columns_of(*square, width), rows), limits)
        })
        .collect()
}

/// The limit of a square with these `values`, `most` the largest; nothing if it has no lights.
fn limit(values: &mut [f32], most: f32) -> Option<Limit> {
    let last = MOST_PIXELS.min(values.len().checked_sub(1)?);
    let (_, next, _) = values.select_nth_unstable_by(last, |a, b| b.total_cmp(a));
    let stays = next.max(0.0);
    values.iter_mut().for_each(|v| *v = v.abs());
    let (_, median, _) = values.select_nth_unstable_by(values.len() / 2, f32::total_cmp);
    let limit = stays.max(OUTSTANDING * *median);
    // Divided: the largest values there are must not become infinite.
    (most / WORTH > limit).then_some(Limit { most: limit, stays })
}

/// What is taken off a square.
fn lights_of(
    planes: &[Plane],
    width: usize,
    (columns, rows): (Range<usize>, &Range<usize>),
    limits: &[Limit],
) -> Square {
    let mut square = Square {
        places: Vec::new(),
        excess: Vec::new(),
    };
    for row in rows.clone() {
        for column in columns.clone() {
            let above = planes.iter().zip(limits).map(|(plane, limit)| {
                let light = plane.samples[row * width + column];
                if light > limit.most {
                    light - limit.stays
                } else {
                    0.0
                }
            });
            if above.clone().any(|light| light != 0.0) {
                square.places.push((row, column));
                square.excess.extend(above);
            }
        }
    }
    square
}

impl Square {
    /// The light as it is spread, one image a plane. Every pixel has a kernel of its own, also where the
    /// exact renderer lets neighbours share one.
    fn scattered(
        &self,
        optics: &Optics,
        planes: &[Plane],
        kernel: &mut KernelRows,
    ) -> Result<Vec<Image>> {
        let mut images = vec![Image::default(); planes.len()];
        let mut found = Vec::new();
        for (light, (row, column)) in self.places.iter().enumerate() {
            optics.at((*column as f64 + 0.5, *row as f64 + 0.5), &mut found)?;
            for (channel, source) in found.iter().enumerate() {
                let Some(source) = source else { continue };
                let model = optics.model;
                model.draw_rows(&source.blur, source.shift_px, kernel);
                self.add(light, (channel, planes), kernel, &mut images);
            }
        }
        Ok(images)
    }

    /// Spreads one light of one lens channel.
    fn add(
        &self,
        light: usize,
        (channel, planes): (usize, &[Plane]),
        kernel: &KernelRows,
        images: &mut [Image],
    ) {
        let (row, column) = self.places[light];
        let excess = &self.excess[light * planes.len()..];
        let place = (column as i32, row as i32);
        for ((image, plane), excess) in images.iter_mut().zip(planes).zip(excess) {
            let gain = f64::from(*excess) * plane.weights[channel] / kernel.sum();
            if gain != 0.0 {
                make_room(image, kernel, place);
                add(image, kernel, place, gain as f32);
            }
        }
    }
}

/// Makes `image` hold what `kernel` spreads from `place` (column, row), and some more: the next light is
/// near.
fn make_room(image: &mut Image, kernel: &KernelRows, (column, row): (i32, i32)) {
    const SPARE: i32 = 4;
    let over = |start: i32, size: usize, at: i32, reach: Range<i32>| {
        let (first, end) = (at + reach.start, at + reach.end);
        if size == 0 {
            return first - SPARE..end + SPARE;
        }
        let old = start..start + size as i32;
        let wider = |short: bool| if short { SPARE } else { 0 };
        old.start.min(first) - wider(first < old.start)..old.end.max(end) + wider(end > old.end)
    };
    let columns = over(image.left, image.width, column, kernel.columns());
    let rows = over(image.top, image.height, row, kernel.rows());
    let size = (columns.len(), rows.len());
    if size == (image.width, image.height) {
        return;
    }
    let mut roomy = Image::zeros((columns.start, rows.start), size);
    for (y, line) in image.samples.chunks_exact(image.width.max(1)).enumerate() {
        let start = (image.top - roomy.top) as usize + y;
        let start = start * roomy.width + (image.left - roomy.left) as usize;
        roomy.samples[start..start + line.len()].copy_from_slice(line);
    }
    *image = roomy;
}

/// Adds `gain` times the kernel's weights about `place` (column, row), for which there is room.
fn add(image: &mut Image, kernel: &KernelRows, (column, row): (i32, i32), gain: f32) {
    for span in kernel.spans() {
        let start = (row + span.row - image.top) as usize * image.width;
        let start = start + (column + span.column - image.left) as usize;
        let out = &mut image.samples[start..start + span.weights.len()];
        for (light, weight) in out.iter_mut().zip(span.weights) {
            *light += gain * weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 150;
    const HEIGHT: usize = 110;

    fn split(samples: &[f32]) -> Split<'_> {
        let weights = &[1.0];
        Split::of(&[Plane { samples, weights }], WIDTH)
    }

    /// Not even: from 0.1 to 0.3.
    fn plate() -> Vec<f32> {
        let value = |k: usize| 0.1 + 0.2 * ((k * 7919) % 101) as f32 / 101.0;
        (0..WIDTH * HEIGHT).map(value).collect()
    }

    /// A plate with a rectangle of `side` at (`column`, `row`).
    fn with_window((column, row): (usize, usize), side: (usize, usize), light: f32) -> Vec<f32> {
        let mut samples = plate();
        for y in row..row + side.1 {
            samples[y * WIDTH + column..][..side.0].fill(light);
        }
        samples
    }

    #[test]
    fn a_plate_without_lights_is_left_alone() {
        // A bright and a dark half, and negatives that stand out.
        let mut samples = plate();
        samples[..WIDTH * 50].iter_mut().for_each(|v| *v *= 300.0);
        samples[WIDTH * 80 + 40] = -1e4;
        let split = split(&samples);
        assert_eq!(split.count(), 0);
        assert!(matches!(split.rest[0], Cow::Borrowed(_)));
    }

    #[test]
    fn lights_are_taken_off_and_nothing_is_lost() {
        for place in [(0, 0), (31, 31), (97, 64), (WIDTH - 2, HEIGHT - 2)] {
            let samples = with_window(place, (2, 2), 1e4);
            let split = split(&samples);
            assert_eq!(split.count(), 4);
            let mut sum = split.rest[0].to_vec();
            let most = sum.iter().copied().fold(0.0, f32::max);
            assert!(most <= 0.3, "{most}");
            for square in &split.squares {
                for ((row, column), excess) in square.places.iter().zip(&square.excess) {
                    sum[row * WIDTH + column] += excess;
                }
            }
            for (sum, sample) in sum.iter().zip(&samples) {
                assert!((sum - sample).abs() <= 1e-6 * sample);
            }
        }
    }

    /// Nor are its corners, of which a few pixels alone may be in a square.
    #[test]
    fn what_is_large_is_not_scattered() {
        for place in [(32, 32), (40, 50), (10, 7), (62, 62)] {
            let samples = with_window(place, (40, 40), 1e3);
            assert_eq!(split(&samples).count(), 0, "{place:?}");
        }
        // Four by four pixels are a light, five by five are not.
        for (side, expected) in [(4, 16), (5, 0)] {
            let samples = with_window((70, 38), (side, side), 1e3);
            assert_eq!(split(&samples).count(), expected);
        }
    }

    #[test]
    fn planes_have_lights_of_their_own() {
        let (dark, lit) = (plate(), with_window((70, 38), (1, 1), 1e3));
        let planes = [&dark, &lit].map(|samples| Plane {
            samples,
            weights: &[1.0],
        });
        let split = Split::of(&planes, WIDTH);
        assert_eq!(split.count(), 1);
        assert_eq!(split.squares[0].excess[0], 0.0);
        assert!(matches!(split.rest[0], Cow::Borrowed(_)));
        assert!(matches!(split.rest[1], Cow::Owned(_)));
    }
}
