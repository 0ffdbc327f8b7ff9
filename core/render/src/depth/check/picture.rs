//! Detection of a picture in place of depth, and of the depth of another picture: of the other eye or another frame, mirrored or turned.
//!
//! Objects end where their depth ends, so that edges of depth lie on edges of the picture. The rank of a pixel is the share of pixels with a
//! smaller gradient of log luminance: the mean rank over the edges of depth is near 1/2 by chance, and highest in the right place. A right
//! pass is nowhere else better, however blurred the picture; the search is a template match over the symmetries of the frame and
//! small shifts.

use std::fmt;

use rayon::prelude::*;

use super::{DepthCheck, DepthFinding, DepthProblem, Severity};

/// Least relative step of vergence at an edge.
const STEP: f32 = 0.1;
/// Largest shift tried, px.
const REACH: i32 = 32;
/// Distance of edges from the border, px: a shifted edge and its gradient lie within the picture.
const BORDER: usize = REACH as usize + 2;
/// Shifts that may be those of filters and of half-pixel conventions, px.
const TOLERATED: i32 = 2;
/// Most edge pixels compared.
const MAX_EDGES: usize = 4096;
/// Least number of edge pixels.
const MIN_EDGES: usize = 300;
/// Least mean rank of a place that is better than the stated one.
const MIN_RANK: f64 = 0.70;
/// Least difference to the mean rank in the stated place.
const MIN_LEAD: f64 = 0.12;
/// Share of the mean luminance that is added to all: noise of dark pixels is no edge.
const FLOOR: f32 = 0.1;

/// The place of a depth pass in which its edges lie on those of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DepthPlace {
    /// Left and right exchanged.
    Mirrored,
    /// Top and bottom exchanged.
    UpsideDown,
    /// Turned by 180 degrees.
    Turned,
    /// Moved to the right and down by pixels.
    Shifted {
        /// Columns to the right.
        right: i32,
        /// Rows down.
        down: i32,
    },
}

impl fmt::Display for DepthPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Mirrored => f.write_str("mirrored left to right"),
            Self::UpsideDown => f.write_str("upside down"),
            Self::Turned => f.write_str("turned by 180 degrees"),
            Self::Shifted { right, down } => {
                let side = if right < 0 { "left" } else { "right" };
                let end = if down < 0 { "up" } else { "down" };
                let (columns, rows) = (right.abs(), down.abs());
                match (columns, rows) {
                    (columns, 0) => write!(f, "moved {columns} px to the {side}"),
                    (0, rows) => write!(f, "moved {rows} px {end}"),
                    _ => write!(f, "moved {columns} px to the {side} and {rows} px {end}"),
                }
            }
        }
    }
}

impl DepthPlace {
    /// Returns the pixel of a picture `(width, height)` to which the place moves pixel `(x, y)`.
    fn move_pixel(self, (x, y): (usize, usize), (width, height): (usize, usize)) -> (usize, usize) {
        match self {
            Self::Mirrored => (width - 1 - x, y),
            Self::UpsideDown => (x, height - 1 - y),
            Self::Turned => (width - 1 - x, height - 1 - y),
            Self::Shifted { right, down } => (
                x.wrapping_add_signed(right as isize),
                y.wrapping_add_signed(down as isize),
            ),
        }
    }
}

/// Finds a pass that is a colour of the plate, as where an input of depth gets the plate and no channel is chosen.
pub(super) fn colour(check: &DepthCheck) -> Option<DepthFinding> {
    let mut colours = check.colours.iter();
    let is_equal = colours.any(|plane| plane.as_slice() == check.samples);
    is_equal.then(|| DepthFinding {
        problem: DepthProblem::Colour,
        severity: Severity::Warning,
        remedy: "name the channel that holds depth".to_owned(),
    })
}

/// Finds a pass whose edges lie on those of the picture in another place only.
pub(super) fn misplaced(check: &DepthCheck) -> Option<DepthFinding> {
    if check.colours.is_empty() || check.width <= 2 * BORDER || check.height <= 2 * BORDER {
        return None;
    }
    let edges = depth_edges(check);
    if edges.len() < MIN_EDGES {
        return None;
    }
    let ranks = gradient_ranks(check);
    let size = (check.width, check.height);
    let mean_rank = |place: DepthPlace| {
        let ranks = edges.iter().map(|edge| {
            let (x, y) = place.move_pixel(*edge, size);
            u64::from(ranks[y * check.width + x])
        });
        ranks.sum::<u64>() as f64 / (f64::from(u8::MAX) * edges.len() as f64)
    };
    let stated = mean_rank(DepthPlace::Shifted { right: 0, down: 0 });
    let shifts = (-REACH..=REACH).flat_map(|down| {
        let row = (-REACH..=REACH).map(move |right| (right, down));
        row.filter(|(right, down)| right.abs().max(down.abs()) > TOLERATED)
    });
    let mut places = vec![
        DepthPlace::Mirrored,
        DepthPlace::UpsideDown,
        DepthPlace::Turned,
    ];
    places.extend(shifts.map(|(right, down)| DepthPlace::Shifted { right, down }));
    let ranked: Vec<f64> = places.par_iter().map(|place| mean_rank(*place)).collect();
    let (place, best) = places
        .into_iter()
        .zip(ranked)
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (best >= MIN_RANK && best - stated >= MIN_LEAD).then(|| DepthFinding {
        problem: DepthProblem::Misplaced {
            place,
            edges: edges.len(),
            stated,
            best,
        },
        severity: Severity::Warning,
        remedy: "give the depth pass of this picture: of the same eye, frame and camera, the same way up"
            .to_owned(),
    })
}

/// Returns pixels at steps of vergence, column and row, spread over the pass.
fn depth_edges(check: &DepthCheck) -> Vec<(usize, usize)> {
    let is_step = |a: f32, b: f32| (a - b).abs() > STEP * a.max(b).max(f32::MIN_POSITIVE);
    let in_row = |y: usize| {
        let at = |x: usize, y: usize| check.vergence[y * check.width + x];
        let is_edge = move |x: &usize| {
            let own = at(*x, y);
            let beside = [at(*x - 1, y), at(*x + 1, y), at(*x, y - 1), at(*x, y + 1)];
            beside.into_iter().any(|other| is_step(own, other))
        };
        let columns = BORDER..check.width - BORDER;
        columns
            .filter(is_edge)
            .map(move |x| (x, y))
            .collect::<Vec<_>>()
    };
    let rows = BORDER..check.height - BORDER;
    let all: Vec<(usize, usize)> = rows.into_par_iter().flat_map_iter(in_row).collect();
    let stride = (all.len() / MAX_EDGES).max(1);
    all.into_iter().step_by(stride).collect()
}

/// Returns the share of pixels with a smaller gradient of log luminance, 255 for all, for each pixel.
fn gradient_ranks(check: &DepthCheck) -> Vec<u8> {
    let (width, height) = (check.width, check.height);
    let share = 1.0 / check.colours.len() as f32;
    let sum = |index: usize| check.colours.iter().map(|plane| plane[index]).sum::<f32>();
    let luminance = |index: usize| (share * sum(index)).clamp(0.0, f32::MAX);
    let total: f64 = (0..width * height)
        .into_par_iter()
        .map(|index| f64::from(luminance(index)))
        .sum();
    let floor = FLOOR * (total / (width * height) as f64) as f32 + f32::MIN_POSITIVE;
    let logs: Vec<f32> = (0..width * height)
        .into_par_iter()
        .map(|index| (luminance(index) + floor).ln())
        .collect();
    let mut gradients = vec![0.0_f32; width * height];
    gradients
        .par_chunks_exact_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, gradient) in row.iter_mut().enumerate() {
                let own = logs[y * width + x];
                let step = |x: usize, y: usize| (logs[y * width + x] - own).abs();
                let along = step(x.saturating_sub(1), y).max(step((x + 1).min(width - 1), y));
                let across = step(x, y.saturating_sub(1)).max(step(x, (y + 1).min(height - 1)));
                *gradient = along.max(across);
            }
        });
    let limits = quantiles(&gradients);
    let rank = |gradient: &f32| limits.partition_point(|limit| limit < gradient) as u8;
    gradients.par_iter().map(rank).collect()
}

/// Returns 255 limits between equal shares of `values`, from a sample of them.
fn quantiles(values: &[f32]) -> Vec<f32> {
    const SAMPLE: usize = 1 << 16;
    let stride = (values.len() / SAMPLE).max(1);
    let mut sample: Vec<f32> = values.iter().copied().step_by(stride).collect();
    sample.sort_unstable_by(f32::total_cmp);
    let last = sample.len() - 1;
    (0..255).map(|k| sample[(2 * k + 1) * last / 510]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CameraPerspective, DepthConvention, LensDistances};
    use seidel_optics::field::ImagePoint;
    use seidel_optics::numeric::SplitMix64;

    const SIZE: (usize, usize) = (320, 240);

    /// A picture of discs at several depths before a wall, with the vergence of each pixel.
    struct Scene {
        colour: Vec<f32>,
        vergence: Vec<f32>,
    }

    impl Scene {
        /// Draws discs with `texture` on all surfaces, a share of their luminance.
        fn new(seed: u64, texture: f64) -> Self {
            let mut random = SplitMix64::new(seed);
            let (width, height) = SIZE;
            let mut colour = vec![0.3_f32; width * height];
            let mut vergence = vec![0.1_f32; width * height];
            for disc in 0..14 {
                let (x, y) = (random.unit() * width as f64, random.unit() * height as f64);
                let (radius, albedo) = (12.0 + 25.0 * random.unit(), 0.05 + random.unit());
                for index in 0..width * height {
                    let (column, row) = ((index % width) as f64, (index / width) as f64);
                    if (column - x).hypot(row - y) < radius {
                        colour[index] = albedo as f32;
                        vergence[index] = 0.2 + 0.1 * disc as f32;
                    }
                }
            }
            for value in &mut colour {
                *value *= (1.0 + texture * (random.unit() - 0.5)) as f32;
            }
            Self { colour, vergence }
        }

        /// Averages the picture over squares of `2 reach + 1` pixels.
        fn blurred(&self, reach: usize) -> Vec<f32> {
            let (width, height) = SIZE;
            let mean = |index: usize| {
                let (x, y) = (index % width, index / width);
                let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
                let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
                let count = (columns.len() * rows.len()) as f32;
                let sums = rows.map(|row| {
                    self.colour[row * width..][columns.clone()]
                        .iter()
                        .sum::<f32>()
                });
                sums.sum::<f32>() / count
            };
            (0..width * height).map(mean).collect()
        }

        /// Returns the vergence of the pixel that `place` moves to each one.
        fn moved(&self, place: DepthPlace) -> Vec<f32> {
            let (width, height) = SIZE;
            let at = |index: usize| {
                let (x, y) = place.move_pixel((index % width, index / width), SIZE);
                self.vergence[y.min(height - 1) * width + x.min(width - 1)]
            };
            (0..width * height).map(at).collect()
        }
    }

    fn check<'a>(
        colours: &'a [Vec<f32>],
        samples: &'a [f32],
        vergence: &'a [f32],
    ) -> DepthCheck<'a> {
        DepthCheck {
            samples,
            vergence,
            width: SIZE.0,
            height: SIZE.1,
            convention: DepthConvention::Distance {
                metres_per_unit: 1.0,
            },
            colours,
            alpha: None,
            view: CameraPerspective {
                axis: ImagePoint::new(160.0, 120.0),
                focal_px: None,
                pixel_aspect: 1.0,
            },
            lens: LensDistances::default(),
        }
    }

    fn found(colours: &[Vec<f32>], vergence: &[f32]) -> Option<DepthPlace> {
        let samples: Vec<f32> = vergence.iter().map(|v| 1.0 / v).collect();
        match misplaced(&check(colours, &samples, vergence))?.problem {
            DepthProblem::Misplaced { place, .. } => Some(place),
            _ => None,
        }
    }

    #[test]
    fn a_colour_of_the_plate_is_no_depth() {
        let scene = Scene::new(1, 0.3);
        let vergence: Vec<f32> = scene.colour.iter().map(|z| 1.0 / z).collect();
        let colours = [scene.blurred(2), scene.colour.clone()];
        let problems = |colours: &[Vec<f32>]| {
            let findings = check(colours, &scene.colour, &vergence).findings();
            let findings = findings.expect("valid").into_iter();
            findings.map(|found| found.problem).collect::<Vec<_>>()
        };
        assert_eq!(problems(&colours), [DepthProblem::Colour]);
        assert!(!problems(&colours[..1]).contains(&DepthProblem::Colour));
    }

    const WRONG: [DepthPlace; 5] = [
        DepthPlace::Mirrored,
        DepthPlace::UpsideDown,
        DepthPlace::Turned,
        DepthPlace::Shifted { right: 9, down: 0 },
        DepthPlace::Shifted { right: -7, down: 5 },
    ];

    #[test]
    fn depth_in_another_place_is_named_with_it() {
        for seed in 0..4 {
            let scene = Scene::new(seed, 0.1);
            let colours = [scene.colour.clone()];
            for place in WRONG {
                assert_eq!(found(&colours, &scene.moved(place)), Some(place), "{seed}");
            }
        }
    }

    #[test]
    fn right_depth_is_right_however_blurred_or_noisy_the_picture() {
        for seed in 0..3 {
            for texture in [0.0, 0.3, 2.0] {
                let scene = Scene::new(seed, texture);
                for reach in [0, 2, 8, 20] {
                    let colours = [scene.blurred(reach)];
                    let right = found(&colours, &scene.vergence);
                    assert_eq!(right, None, "{seed}, texture {texture}, blur {reach}");
                }
            }
            // A picture that shows nothing of the discs says nothing about their depth.
            let other = Scene::new(100 + seed, 2.0);
            let flat = vec![vec![0.3; SIZE.0 * SIZE.1]];
            assert_eq!(found(&flat, &other.vergence), None);
        }
    }
}
