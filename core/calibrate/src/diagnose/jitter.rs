//! Random errors of ideal positions.
//!
//! Positions from a survey or a detector have errors of some hundredths of a pixel, common to all channels of
//! an observation and independent between observations. They are measurement errors, not a gap. They are
//! estimated from the residuals of the best hypothesis and removed before gaps are compared. Shifts that vary
//! smoothly over the field remain for effects to explain.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::matched_filter;
use super::prediction::TilePredictor;
use super::registration::Registration;
use super::tiles::TileData;
use seidel_optics::effects::ScenePoint;
use seidel_optics::numeric::median;
use seidel_optics::psf::pupil::Detail;

/// Largest standard deviation, along an axis, of stated positions that scatter, px. Larger shifts count as a gap, but for this size.
const MAX_SCATTER_PX: f64 = 0.25;
/// Probability that one of all scattered positions lies further off than is corrected.
const FAR_PROBABILITY: f64 = 0.05;
/// Median of the Rayleigh distribution in units of its scale: of the length of a vector whose components are normally distributed.
const RAYLEIGH_MEDIAN: f64 = 1.177_410_022_515_474_7;
/// Ratio of the mean squares of trend and scatter from which on the trend is one, and not the scatter of few positions.
const TREND_RATIO: f64 = 3.0;
/// Largest correction of a position that was estimated by a centroid, px.
const MAX_CENTROID_ERROR_PX: f64 = 2.0;
/// Step of the finite differences, px.
const DIFFERENCE_STEP_PX: f64 = 0.1;
/// Iterations of estimation and correction.
const ITERATIONS: usize = 4;
/// Largest change of a shift at which they stop, px.
const SETTLED_PX: f64 = 0.01;

/// Tiles that share one shift: those of an observation, or a single one that is placed by its own centroid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Group {
    observation: usize,
    /// The channel of a single tile.
    channel: Option<usize>,
}

impl Group {
    pub(super) fn of(tile: &TileData) -> Self {
        let own = tile.registration.is_own_centroid();
        Self {
            observation: tile.observation,
            channel: own.then_some(tile.of_lens),
        }
    }
}

/// Removes the random shift of every observation of stated position from its tiles, against the prediction of `hypothesis` at `theta`.
/// Returns the standard deviation of the shifts along either axis, px.
pub(super) fn remove(hypothesis: &Hypothesis, theta: &[f64], tiles: &mut [TileData]) -> f64 {
    let stated = |tiles: &[TileData]| {
        let shifts = shifts(hypothesis, theta, tiles);
        let stated = shifts.into_iter().filter(|s| is_stated(s.0, tiles));
        incoherent(stated.collect(), tiles)
    };
    let most = largest_scatter_px(&stated(tiles));
    let moved = shifted(tiles, most, stated);
    let squares: f64 = moved.iter().flat_map(|m| m.1).map(|s| s * s).sum();
    (squares / (2 * moved.len()).max(1) as f64).sqrt()
}

/// Returns the largest shift that belongs to the scatter of `shifts`, px: their lengths follow Rayleigh's law, whose scale their median
/// shows.
fn largest_scatter_px(shifts: &[(Group, [f64; 2])]) -> f64 {
    let mut lengths: Vec<f64> = shifts.iter().map(|(_, [x, y])| x.hypot(*y)).collect();
    if lengths.is_empty() {
        return 0.0;
    }
    let count = lengths.len() as f64;
    let scale = median(&mut lengths) / RAYLEIGH_MEDIAN;
    if scale > MAX_SCATTER_PX {
        return MAX_SCATTER_PX;
    }
    MAX_SCATTER_PX.max(scale * (2.0 * (count / FAR_PROBABILITY).ln()).sqrt())
}

/// Moves every observation that is placed by the centroid of its reference channel, and every tile that is placed by its own, to where
/// `hypothesis` at `theta` agrees best with its pixels. Centroids of PSFs in focus are far off.
pub(super) fn place_by_pixels(hypothesis: &Hypothesis, theta: &[f64], tiles: &mut [TileData]) {
    if tiles
        .iter()
        .all(|t| matches!(t.registration, Registration::Ideal))
    {
        return;
    }
    matched_filter::place(hypothesis, theta, tiles);
    shifted(tiles, MAX_CENTROID_ERROR_PX, |tiles| {
        let shifts = shifts(hypothesis, theta, tiles).into_iter();
        shifts.filter(|s| !is_stated(s.0, tiles)).collect()
    });
}

/// Shifts observations by what `estimate` returns, at most by `most` px in all, and repeats. Returns the shift of each.
fn shifted(
    tiles: &mut [TileData],
    most: f64,
    estimate: impl Fn(&[TileData]) -> Vec<(Group, [f64; 2])>,
) -> Vec<(Group, [f64; 2])> {
    let mut moved: Vec<(Group, [f64; 2])> = Vec::new();
    for _ in 0..ITERATIONS {
        let shifts = estimate(tiles);
        let largest = shifts.iter().map(|(_, [x, y])| x.hypot(*y));
        let largest = largest.fold(0.0, f64::max);
        for (group, shift) in shifts {
            let total = match moved.iter_mut().find(|m| m.0 == group) {
                Some(total) => total,
                None => {
                    moved.push((group, [0.0; 2]));
                    moved.last_mut().expect("just pushed")
                }
            };
            let wanted = [total.1[0] + shift[0], total.1[1] + shift[1]];
            let far = wanted[0].hypot(wanted[1]);
            let allowed = if far > most { most / far } else { 1.0 };
            let wanted = wanted.map(|w| w * allowed);
            for tile in tiles.iter_mut().filter(|t| Group::of(t) == group) {
                tile.corner.0 -= wanted[0] - total.1[0];
                tile.corner.1 -= wanted[1] - total.1[1];
            }
            total.1 = wanted;
        }
        if largest < SETTLED_PX {
            break;
        }
    }
    moved
}

/// Returns a tile of `group`.
fn tile_of(group: Group, tiles: &[TileData]) -> &TileData {
    let tile = tiles.iter().find(|t| Group::of(t) == group);
    tile.expect("every shift is of a tile")
}

/// Returns whether the position of `group` is stated, not estimated by its centroid.
fn is_stated(group: Group, tiles: &[TileData]) -> bool {
    matches!(tile_of(group, tiles).registration, Registration::Ideal)
}

/// Estimates the shift of each group of tiles against the prediction of `hypothesis` at `theta`, px.
fn shifts(hypothesis: &Hypothesis, theta: &[f64], tiles: &[TileData]) -> Vec<(Group, [f64; 2])> {
    let equations: Vec<ShiftEquations> = tiles
        .par_iter()
        .map_init(
            || (TilePredictor::default(), [const { Vec::new() }; 3]),
            |(predictor, pictures), tile| {
                ShiftEquations::of(hypothesis, theta, tile, predictor, pictures)
            },
        )
        .collect();
    let mut sums: Vec<(Group, ShiftEquations)> = Vec::new();
    for (tile, own) in tiles.iter().zip(&equations) {
        match sums.last_mut() {
            Some((group, sum)) if *group == Group::of(tile) => sum.add(own),
            _ => sums.push((Group::of(tile), *own)),
        }
    }
    sums.iter()
        .filter_map(|(group, s)| Some((*group, s.shift_px()?)))
        .collect()
}

/// Subtracts from the shifts of `stated` positions their smooth trend over the field, which effects may cause, if there is more of one than
/// scatter makes.
fn incoherent(mut stated: Vec<(Group, [f64; 2])>, tiles: &[TileData]) -> Vec<(Group, [f64; 2])> {
    let points: Vec<ScenePoint> = (stated.iter()).map(|s| tile_of(s.0, tiles).point).collect();
    let mut trends = [DVector::zeros(stated.len()), DVector::zeros(stated.len())];
    let (mut of_trend, mut of_scatter) = (0.0, 0.0);
    for (axis, trend) in trends.iter_mut().enumerate() {
        let terms = trend_terms(stated.len());
        let basis = DMatrix::from_fn(stated.len(), terms.len(), |row, column| {
            terms[column](points[row], axis)
        });
        let values = DVector::from_fn(stated.len(), |row, _| stated[row].1[axis]);
        let size = terms.len();
        let normal = basis.transpose() * &basis + DMatrix::identity(size, size) * 1e-9;
        let Some(inverse) = normal.try_inverse() else {
            continue;
        };
        let smooth = &basis * (inverse * basis.transpose() * &values);
        let freedom = stated.len().saturating_sub(size).max(1) as f64;
        of_trend += smooth.norm_squared() / size as f64;
        of_scatter += (values - &smooth).norm_squared() / freedom;
        *trend = smooth;
    }
    if of_trend > TREND_RATIO * of_scatter {
        for (row, (_, shift)) in stated.iter_mut().enumerate() {
            *shift = [0, 1].map(|axis| shift[axis] - trends[axis][row]);
        }
    }
    stated
}

/// A term of the trend of shifts along an axis.
type TrendTerm = fn(ScenePoint, usize) -> f64;

/// Terms of the trend, the most needed first: shift, magnification, distortion; change of magnification with vergence; general
/// quadratic shifts, such as those of tilted elements.
const TREND_TERMS: [TrendTerm; 8] = [
    |_, _| 1.0,
    |p, axis| along(p, axis),
    |p, axis| along(p, axis) * p.at.radius().powi(2),
    |p, axis| along(p, axis) * p.vergence_per_m,
    |p, axis| along(p, 1 - axis),
    |p, axis| along(p, axis).powi(2),
    |p, _| p.at.x * p.at.y,
    |p, axis| along(p, 1 - axis).powi(2),
];
/// Observations needed for each term of the trend.
const OBSERVATIONS_PER_TERM: usize = 3;

/// Returns the field coordinate along `axis`.
fn along(point: ScenePoint, axis: usize) -> f64 {
    [point.at.x, point.at.y][axis]
}

/// Returns the terms of the trend of that many shifts.
fn trend_terms(count: usize) -> &'static [TrendTerm] {
    let most = (count / OBSERVATIONS_PER_TERM).clamp(1, TREND_TERMS.len());
    &TREND_TERMS[..most]
}

/// Normal equations of a tile's shift, relative to its squared norm.
#[derive(Debug, Clone, Copy)]
struct ShiftEquations {
    xx: f64,
    xy: f64,
    yy: f64,
    x: f64,
    y: f64,
}

impl ShiftEquations {
    fn of(
        hypothesis: &Hypothesis,
        theta: &[f64],
        tile: &TileData,
        predictor: &mut TilePredictor,
        pictures: &mut [Vec<f64>; 3],
    ) -> Self {
        let values = hypothesis.values(theta, tile.of_lens);
        let moves = [
            (0.0, 0.0),
            (DIFFERENCE_STEP_PX, 0.0),
            (0.0, DIFFERENCE_STEP_PX),
        ];
        for ((x, y), picture) in moves.into_iter().zip(&mut *pictures) {
            let moved = TileData {
                corner: (tile.corner.0 - x, tile.corner.1 - y),
                ..tile.clone()
            };
            predictor.predict(hypothesis, &values, &moved, Detail::FIT, picture);
        }
        pictures.iter_mut().for_each(|picture| tile.mask(picture));
        let [here, right, below] = pictures;
        let mut sums = Self {
            xx: 0.0,
            xy: 0.0,
            yy: 0.0,
            x: 0.0,
            y: 0.0,
        };
        for (k, (r, p)) in tile.residual(here).iter().zip(&*here).enumerate() {
            let (dx, dy) = (
                (right[k] - p) / DIFFERENCE_STEP_PX,
                (below[k] - p) / DIFFERENCE_STEP_PX,
            );
            sums.xx += dx * dx / tile.norm;
            sums.xy += dx * dy / tile.norm;
            sums.yy += dy * dy / tile.norm;
            sums.x += dx * r / tile.norm;
            sums.y += dy * r / tile.norm;
        }
        sums
    }

    fn add(&mut self, other: &Self) {
        self.xx += other.xx;
        self.xy += other.xy;
        self.yy += other.yy;
        self.x += other.x;
        self.y += other.y;
    }

    /// Returns the least-squares shift, px.
    fn shift_px(&self) -> Option<[f64; 2]> {
        let determinant = self.xx * self.yy - self.xy * self.xy;
        (determinant > 0.0).then(|| {
            let x = (self.yy * self.x - self.xy * self.y) / determinant;
            let y = (self.xx * self.y - self.xy * self.x) / determinant;
            [x, y]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    /// Shifts whose components have the standard deviation `sigma`.
    fn scattered(sigma: f64, seed: u64) -> Vec<(Group, [f64; 2])> {
        let mut random = SplitMix64::new(seed);
        let normal = |random: &mut SplitMix64| {
            let sum: f64 = (0..12).map(|_| random.unit() - 0.5).sum();
            sigma * sum
        };
        let group = |observation| Group {
            observation,
            channel: None,
        };
        let shift = |k| (group(k), [normal(&mut random), normal(&mut random)]);
        (0..30).map(shift).collect()
    }

    #[test]
    fn all_scattered_positions_are_corrected_and_larger_shifts_are_not_scatter() {
        let length = |shift: &(Group, [f64; 2])| shift.1[0].hypot(shift.1[1]);
        let beyond = (0..20).filter(|seed| {
            let shifts = scattered(0.2, *seed);
            let most = largest_scatter_px(&shifts);
            shifts.iter().any(|shift| length(shift) > most)
        });
        assert!(beyond.count() <= 4);
        assert_eq!(largest_scatter_px(&scattered(0.6, 1)), MAX_SCATTER_PX);
        assert_eq!(largest_scatter_px(&scattered(0.01, 1)), MAX_SCATTER_PX);
        assert_eq!(largest_scatter_px(&[]), 0.0);
    }
}
