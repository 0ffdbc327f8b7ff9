//! How well ideal positions are known.
//!
//! Positions of points come from a survey or a detector and are off by some hundredths of a pixel, alike in
//! all channels of an observation and at random from one to the next. That is an error of measurement, not a
//! gap: it is read off what the best hypothesis leaves, and taken off before gaps are compared. What is
//! smooth over the field is left for effects to explain.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::picture::Easel;
use super::search::Candidate;
use super::seen::Seen;
use seidel_optics::psf::pupil::Detail;

/// Farthest that a point is moved, px: more is a gap.
const MOST_PX: f64 = 0.25;
/// How far apart the pictures are of which derivatives are taken, px.
const APART_PX: f64 = 0.1;
/// Rounds of estimating and moving.
const ROUNDS: usize = 2;

/// Moves the tiles of every observation to where the point seems to be, as far as that is at random;
/// returns the standard deviation of these moves along either axis, px.
pub(super) fn take_off(best: &Candidate, tiles: &mut [Seen]) -> f64 {
    let mut moved: Vec<(usize, [f64; 2])> = Vec::new();
    for _ in 0..ROUNDS {
        let shifts = incoherent(shifts(best, tiles), tiles);
        for (observation, shift) in shifts {
            let total = match moved.iter_mut().find(|m| m.0 == observation) {
                Some(total) => total,
                None => {
                    moved.push((observation, [0.0; 2]));
                    moved.last_mut().expect("just pushed")
                }
            };
            let wanted = [total.1[0] + shift[0], total.1[1] + shift[1]];
            let far = wanted[0].hypot(wanted[1]);
            let allowed = if far > MOST_PX { MOST_PX / far } else { 1.0 };
            let wanted = wanted.map(|w| w * allowed);
            for tile in tiles.iter_mut().filter(|t| t.observation == observation) {
                tile.corner.0 -= wanted[0] - total.1[0];
                tile.corner.1 -= wanted[1] - total.1[1];
            }
            total.1 = wanted;
        }
    }
    let squares: f64 = moved.iter().flat_map(|m| m.1).map(|s| s * s).sum();
    (squares / (2 * moved.len()).max(1) as f64).sqrt()
}

/// How far each observation's pictures, all channels together, are off what `best` predicts, px.
fn shifts(best: &Candidate, tiles: &[Seen]) -> Vec<(usize, [f64; 2])> {
    let slopes: Vec<Slopes> = tiles
        .par_iter()
        .map_init(
            || (Easel::default(), [const { Vec::new() }; 3]),
            |(easel, pictures), seen| Slopes::of(best, seen, easel, pictures),
        )
        .collect();
    let mut sums: Vec<(usize, Slopes)> = Vec::new();
    for (seen, own) in tiles.iter().zip(&slopes).filter(|(t, _)| t.placed) {
        match sums.last_mut() {
            Some((observation, sum)) if *observation == seen.observation => sum.add(own),
            _ => sums.push((seen.observation, *own)),
        }
    }
    sums.iter()
        .filter_map(|(observation, s)| Some((*observation, s.shift_px()?)))
        .collect()
}

/// `shifts` less, at each distance, a quadratic of the field position (where there are few, their mean).
fn incoherent(shifts: Vec<(usize, [f64; 2])>, tiles: &[Seen]) -> Vec<(usize, [f64; 2])> {
    let tile_of = |observation: usize| {
        let tile = tiles.iter().find(|t| t.observation == observation);
        tile.expect("every shift is of a tile")
    };
    let mut result = Vec::with_capacity(shifts.len());
    let mut rest = shifts;
    while let Some(distance) = rest.first().map(|s| tile_of(s.0).distance) {
        let (own, others): (Vec<_>, Vec<_>) = rest
            .into_iter()
            .partition(|s| tile_of(s.0).distance == distance);
        rest = others;
        let size = if own.len() >= 18 { 6 } else { 1 };
        let basis = DMatrix::from_fn(own.len(), size, |row, column| {
            let at = tile_of(own[row].0).point.at;
            [1.0, at.x, at.y, at.x * at.x, at.x * at.y, at.y * at.y][column]
        });
        let mut left = own.clone();
        for axis in 0..2 {
            let values = DVector::from_fn(own.len(), |row, _| own[row].1[axis]);
            let normal = basis.transpose() * &basis + DMatrix::identity(size, size) * 1e-9;
            let Some(inverse) = normal.try_inverse() else {
                continue;
            };
            let smooth = &basis * (inverse * basis.transpose() * values);
            for (row, shift) in left.iter_mut().enumerate() {
                shift.1[axis] -= smooth[row];
            }
        }
        result.extend(left);
    }
    result
}

/// Sums over a tile's pixels, over its squared norm, of products of the picture's derivatives by x and y and
/// the residual.
#[derive(Debug, Clone, Copy)]
struct Slopes {
    xx: f64,
    xy: f64,
    yy: f64,
    x: f64,
    y: f64,
}

impl Slopes {
    fn of(best: &Candidate, seen: &Seen, easel: &mut Easel, pictures: &mut [Vec<f64>; 3]) -> Self {
        let values = best.hypothesis.values(&best.theta, seen.of_lens);
        let moves = [(0.0, 0.0), (APART_PX, 0.0), (0.0, APART_PX)];
        for ((x, y), picture) in moves.into_iter().zip(&mut *pictures) {
            let moved = Seen {
                corner: (seen.corner.0 - x, seen.corner.1 - y),
                ..seen.clone()
            };
            easel.predict(&best.hypothesis, &values, &moved, Detail::FIT, picture);
        }
        let [here, right, below] = pictures;
        let mut sums = Self {
            xx: 0.0,
            xy: 0.0,
            yy: 0.0,
            x: 0.0,
            y: 0.0,
        };
        for (k, (o, p)) in seen.light.iter().zip(&*here).enumerate() {
            let (dx, dy, r) = ((right[k] - p) / APART_PX, (below[k] - p) / APART_PX, o - p);
            sums.xx += dx * dx / seen.norm;
            sums.xy += dx * dy / seen.norm;
            sums.yy += dy * dy / seen.norm;
            sums.x += dx * r / seen.norm;
            sums.y += dy * r / seen.norm;
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

    /// The shift that explains the residual best, px.
    fn shift_px(&self) -> Option<[f64; 2]> {
        let determinant = self.xx * self.yy - self.xy * self.xy;
        (determinant > 0.0).then(|| {
            let x = (self.yy * self.x - self.xy * self.y) / determinant;
            let y = (self.xx * self.y - self.xy * self.x) / determinant;
            [x, y]
        })
    }
}
