//! Detection of depth that was averaged at edges: filtered, or over the motion of a shutter.
//!
//! Between two surfaces such a pass holds a ramp of distances at which there is nothing. Averages are symmetric about the edge: halfway
//! along the ramp the value lies halfway between both sides. A surface seen at a slant is linear in the reciprocal of its distance, and
//! halfway has come less than half as far, the less the farther it reaches.

use super::super::DepthConvention;
use super::{DepthCheck, DepthFinding, DepthProblem, Severity};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// Most lines of pixels read along each axis.
const MOST_LINES: usize = 540;
/// Least relative step from pixel to pixel that begins an edge.
const BEGINS: f32 = 0.01;
/// Least relative step that continues one.
const CONTINUES: f32 = 0.002;
/// Least ratio of the distances of an edge's sides.
const LEAST_RATIO: f32 = 1.22;
/// Least ratio at which an average and a slanted surface can be distinguished.
const CLEAR_RATIO: f32 = 1.6;
/// Widths of ramps, px. Narrower edges are sampled once a pixel, or repaired before rendering.
const WIDTHS: Range<usize> = 3..65;
/// Pixels on either side of an edge that must be even, to this share of the edge.
const BESIDE: usize = 3;
const EVEN: f32 = 0.1;
/// Largest share of an edge in one step of a ramp.
const LARGEST_STEP: f32 = 0.8;
/// Share of the edge at the middle of an average.
const HALFWAY: Range<f32> = 0.42..0.6;
/// Least number of averaged edges, and least share of all edges.
const MIN_EDGES: usize = 60;
const MIN_SHARE: f64 = 0.08;

/// Finds depth averaged at edges.
pub(super) fn averaged(check: &DepthCheck) -> Option<DepthFinding> {
    // In the reciprocal of distance slanted surfaces are symmetric, too.
    if !matches!(check.convention, DepthConvention::Distance { .. }) {
        return None;
    }
    let (width, height) = (check.width, check.height);
    let columns = (0..width).step_by(width.div_ceil(MOST_LINES));
    let rows = (0..height).step_by(height.div_ceil(MOST_LINES));
    let column = |x: usize| check.samples.iter().skip(x).step_by(width).copied();
    let row = |y: usize| check.samples[y * width..][..width].iter().copied();
    let of_columns = columns.collect::<Vec<_>>().into_par_iter().map(column);
    let of_rows = rows.collect::<Vec<_>>().into_par_iter().map(row);
    let (down, across): (Vec<LineEdges>, Vec<LineEdges>) = rayon::join(
        || of_columns.map(LineEdges::of_line).collect(),
        || of_rows.map(LineEdges::of_line).collect(),
    );
    let mut all = LineEdges::default();
    for line in down.into_iter().chain(across) {
        all.count += line.count;
        all.widths.extend(line.widths);
    }
    let share = all.widths.len() as f64 / all.count.max(1) as f64;
    (all.widths.len() >= MIN_EDGES && share >= MIN_SHARE).then(|| {
        let middle = all.widths.len() / 2;
        let (_, width_px, _) = all.widths.select_nth_unstable(middle);
        DepthFinding {
            problem: DepthProblem::Averaged {
                edges: all.count,
                share,
                width_px: *width_px,
            },
            severity: Severity::Warning,
            remedy: format!(
                "render depth without a filter and without motion blur, one sample a pixel, or state the width of the filter, about {} px",
                *width_px + 1
            ),
        }
    })
}

/// LineEdges of depth along lines of pixels.
#[derive(Default)]
struct LineEdges {
    count: usize,
    /// Widths of those that are averages, px.
    widths: Vec<usize>,
}

impl LineEdges {
    fn of_line(samples: impl Iterator<Item = f32>) -> Self {
        let line: Vec<f32> = samples.collect();
        let mut edges = Self::default();
        let mut at = 0;
        while at + 1 < line.len() {
            if relative_step(line[at], line[at + 1]).abs() < BEGINS {
                at += 1;
                continue;
            }
            let end = end_of_edge(&line, at);
            edges.add(&line, at, end);
            at = end;
        }
        edges
    }

    /// Adds what lies between pixels `first` and `last`, if it is an edge.
    fn add(&mut self, line: &[f32], first: usize, last: usize) {
        let (one, other) = (line[first], line[last]);
        let ratio = one.max(other) / one.min(other);
        if !(one.min(other) > 0.0 && ratio.is_finite() && ratio > LEAST_RATIO) {
            return;
        }
        self.count += 1;
        let width = last - first;
        if !WIDTHS.contains(&width) || first < BESIDE || last + BESIDE >= line.len() {
            return;
        }
        let span = (other - one).abs();
        let beside = (line[first - BESIDE] - one)
            .abs()
            .max((line[last + BESIDE] - other).abs());
        let steps = line[first..=last]
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs());
        let largest = steps.fold(0.0, f32::max);
        let middle = 0.5 * (line[(first + last) / 2] + line[(first + last).div_ceil(2)]);
        let come = (middle - one.min(other)) / span;
        let is_average = ratio > CLEAR_RATIO
            && beside < EVEN * span
            && largest < LARGEST_STEP * span
            && HALFWAY.contains(&come);
        if is_average {
            self.widths.push(width);
        }
    }
}

/// Returns the last pixel of the edge that begins after pixel `first`.
fn end_of_edge(line: &[f32], first: usize) -> usize {
    let direction = relative_step(line[first], line[first + 1]);
    let last = (first + 1..line.len() - 1).try_fold(first + 1, |last, at| {
        let step = relative_step(line[at], line[at + 1]);
        if step.abs() >= CONTINUES && step * direction > 0.0 {
            ControlFlow::Continue(at + 1)
        } else {
            ControlFlow::Break(last)
        }
    });
    match last {
        ControlFlow::Continue(last) | ControlFlow::Break(last) => last,
    }
}

/// Returns the step from one distance to the next over the lesser of them; infinite beside a pixel without distance.
fn relative_step(one: f32, other: f32) -> f32 {
    let least = one.min(other);
    if least > 0.0 && one.is_finite() && other.is_finite() {
        (other - one) / least
    } else if one == other || (one <= 0.0 && other <= 0.0) {
        0.0
    } else {
        f32::INFINITY.copysign(other - one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CameraPerspective, LensDistances};
    use seidel_optics::field::ImagePoint;

    const SIZE: (usize, usize) = (240, 160);

    /// Returns what the check finds in a pass with this distance at each pixel.
    fn found(distance: impl Fn(f64, f64) -> f64) -> Option<DepthProblem> {
        let (width, height) = SIZE;
        let at = |index: usize| distance((index % width) as f64, (index / width) as f64) as f32;
        let samples: Vec<f32> = (0..width * height).map(at).collect();
        let vergence: Vec<f32> = samples.iter().map(|z| 1.0 / z).collect();
        let check = DepthCheck {
            samples: &samples,
            vergence: &vergence,
            width,
            height,
            convention: DepthConvention::Distance {
                metres_per_unit: 1.0,
            },
            colours: &[],
            alpha: None,
            view: CameraPerspective {
                axis: ImagePoint::new(120.0, 80.0),
                focal_px: None,
                pixel_aspect: 1.0,
            },
            lens: LensDistances::default(),
        };
        averaged(&check).map(|finding| finding.problem)
    }

    /// Returns the distance of a ball 2 m away before a wall.
    fn ball(x: f64, y: f64, wall: f64) -> f64 {
        let from_middle = (x - 100.0).hypot(y - 80.0);
        if from_middle < 50.0 {
            2.5 - 0.5 * (1.0 - (from_middle / 50.0).powi(2)).sqrt()
        } else {
            wall
        }
    }

    #[test]
    fn depth_over_the_motion_of_a_shutter_is_found_with_its_length() {
        for length in [6.0, 16.0, 32.0] {
            let problem = found(|x, y| {
                let moments = (0..64).map(|k| ball(x - length * f64::from(k) / 64.0, y, 9.0));
                moments.sum::<f64>() / 64.0
            });
            let Some(DepthProblem::Averaged { width_px, .. }) = problem else {
                panic!("{length}: {problem:?}");
            };
            assert!(
                (width_px as f64 - length).abs() <= 0.2 * length + 1.0,
                "{width_px} of {length}"
            );
        }
    }

    #[test]
    fn filtered_depth_is_found_and_depth_of_one_sample_is_not() {
        for reach in [2_i32, 4] {
            let problem = found(|x, y| {
                let square = (-reach..=reach).flat_map(|down| {
                    (-reach..=reach)
                        .map(move |right| ball(x + f64::from(right), y + f64::from(down), 20.0))
                });
                square.sum::<f64>() / f64::from((2 * reach + 1_i32).pow(2))
            });
            assert!(
                matches!(problem, Some(DepthProblem::Averaged { .. })),
                "{reach}"
            );
        }
        for wall in [3.5, 9.0, 1e6] {
            assert_eq!(found(|x, y| ball(x, y, wall)), None, "wall at {wall} m");
        }
    }

    #[test]
    fn surfaces_at_a_slant_are_no_average() {
        // Walls from 4 to 7, 14 or 60 m along 10 to 60 px, between walls that face the camera.
        for far in [7.0, 14.0, 60.0] {
            for length in [10.0, 25.0, 60.0] {
                let reciprocal = |x: f64| {
                    let share = ((x - 80.0) / length).clamp(0.0, 1.0);
                    1.0 / 4.0 + share * (1.0 / far - 1.0 / 4.0)
                };
                assert_eq!(
                    found(|x, y| 1.0 / reciprocal(x + 0.1 * y)),
                    None,
                    "{far} m, {length} px"
                );
            }
        }
    }
}
