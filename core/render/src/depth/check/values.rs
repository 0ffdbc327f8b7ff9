//! Checks of the values of a depth pass: their range, their unit and the number of distinct levels.

use super::super::DepthConvention;
use super::finding::distance_span;
use super::{DepthCheck, DepthFinding, DepthProblem, Severity};
use rayon::prelude::*;
use seidel_optics::numeric::median;

/// Share of pixels ignored at each end of a range.
const TAIL: f64 = 0.02;
/// Least median distance of a scene, metres; the focal length if that is longer.
const NEAREST_M: f64 = 0.01;
/// Largest distance of the nearest object, metres.
const FARTHEST_M: f64 = 1e4;
/// Largest ratio of a scene's distances to those at which the lens was measured, and the reverse.
const BEYOND_LENS: f64 = 20.0;
/// Least distance of the nearest object, metres, from which a scene is unusual for a lens that was measured at infinity: blur is the same
/// in all of it.
const ALL_FAR_M: f64 = 500.0;
/// Number of levels of 8 bits.
const MAX_LEVELS: usize = 256;
/// Least number of levels reported: fewer may be flat cards.
const MIN_LEVELS: usize = 40;
/// Relative step below which levels are as fine as half floats, and harmless.
const FINE_STEP: f64 = 0.001;
/// Least number of steps on surfaces.
const MIN_STEPS: usize = 200;
/// Share of pixels with a distance below which a pass is empty.
const MIN_FILLED: f64 = 0.001;

/// Finds passes that are empty, or constant although the plate is not an element over nothing.
pub(super) fn constant(check: &DepthCheck) -> Option<DepthFinding> {
    let mut depths = check.vergence.iter().zip(check.samples);
    let filled = check.vergence.par_iter().filter(|v| **v > 0.0).count();
    let share = filled as f64 / check.vergence.len() as f64;
    if share < MIN_FILLED {
        return Some(DepthFinding {
            problem: DepthProblem::Empty { share },
            severity: Severity::Warning,
            remedy: "check which channel and frame it is, and what its numbers mean".to_owned(),
        });
    }
    let (first, sample) = depths.find(|(v, _)| **v > 0.0)?;
    let same = depths.all(|(v, _)| *v <= 0.0 || v == first);
    let is_element = (check.alpha).is_some_and(|alpha| alpha.contains(&0.0));
    if same && is_element {
        return None;
    }
    same.then(|| DepthFinding {
        problem: DepthProblem::Constant {
            value: f64::from(*sample),
        },
        severity: Severity::Note,
        remedy: "check which channel it is, or give the whole plate one distance".to_owned(),
    })
}

/// Finds numbers from 0 to 1 that are read as metres.
pub(super) fn normalised(check: &DepthCheck) -> Option<DepthFinding> {
    let DepthConvention::Distance { metres_per_unit } = check.convention else {
        return None;
    };
    let all = || check.samples.par_iter().copied();
    let least = all().reduce(|| f32::INFINITY, f32::min);
    let largest = all().reduce(|| f32::NEG_INFINITY, f32::max);
    let fills = (0.0..=0.05).contains(&least) && (0.98..=1.0).contains(&largest);
    let filled = || check.vergence.par_iter().filter(|v| **v > 0.0).count() as f64;
    let ends = || check.samples.par_iter().filter(|v| **v == 1.0).count() as f64;
    // A background at exactly 1 is the far end of a normalised range.
    let far_fill = (0.0..1.0).contains(&least) && largest == 1.0 && ends() > 0.01 * filled();
    // A user who states another unit than metres knows the numbers.
    (metres_per_unit == 1.0 && (fills || far_fill)).then(|| DepthFinding {
        problem: DepthProblem::Normalised {
            least: f64::from(least),
            largest: f64::from(largest),
        },
        severity: Severity::Warning,
        remedy: "state the depth kind far-one or far-zero, with near and far distances".to_owned(),
    })
}

/// Finds distances that are implausible, or far from those at which the lens was measured.
pub(super) fn unit(check: &DepthCheck) -> Option<DepthFinding> {
    let SceneRange {
        near_m,
        median_m,
        far_m,
    } = scene_range(check.vergence)?;
    let nearest = check
        .lens
        .focal_length_m
        .unwrap_or(NEAREST_M)
        .max(NEAREST_M);
    if median_m < nearest || near_m > FARTHEST_M {
        return Some(DepthFinding {
            problem: DepthProblem::ImplausibleRange { near_m, far_m },
            severity: Severity::Warning,
            remedy: format!(
                "{}{}",
                unit_remedy(check, near_m, far_m),
                kind_remedy(check.convention)
            ),
        });
    }
    let measured_m = check.lens.measured_m?;
    let farthest_m = if measured_m.1.is_finite() {
        BEYOND_LENS * measured_m.1
    } else {
        ALL_FAR_M.max(measured_m.0)
    };
    let off = near_m > farthest_m || far_m * BEYOND_LENS < measured_m.0;
    off.then(|| DepthFinding {
        problem: DepthProblem::OffTheLens {
            near_m,
            far_m,
            measured_m,
        },
        severity: Severity::Note,
        remedy: unit_remedy(check, near_m, far_m),
    })
}

/// Returns the remedy for an implausible range that comes from reciprocal values.
fn kind_remedy(convention: DepthConvention) -> &'static str {
    match convention {
        DepthConvention::Distance { .. } => {
            "; state the depth kind inverse if they are one over distances"
        }
        DepthConvention::Inverse { .. } => "; state the depth kind distance if they are distances",
        DepthConvention::FarOne { .. } | DepthConvention::FarZero { .. } => "",
    }
}

/// Returns the remedy that proposes the unit closest to the distances at which the lens was measured.
fn unit_remedy(check: &DepthCheck, near_m: f64, far_m: f64) -> String {
    let (DepthConvention::Distance { metres_per_unit }
    | DepthConvention::Inverse { metres_per_unit }) = check.convention
    else {
        return "check the near and far distances, which are metres".to_owned();
    };
    let (low, high) = check.lens.measured_m.unwrap_or((0.5, 50.0));
    let wanted = (low * high.min(100.0 * low)).sqrt();
    let middle = (near_m * far_m).sqrt();
    let units = [
        ("mm", 0.001),
        ("cm", 0.01),
        ("in", 0.0254),
        ("ft", 0.3048),
        ("m", 1.0),
        ("km", 1000.0),
    ];
    let size = metres_per_unit.abs();
    let miss = |unit: f64| (middle * unit / size / wanted).ln().abs();
    let best = units
        .into_iter()
        .reduce(|a, b| if miss(b.1) < miss(a.1) { b } else { a });
    match best {
        Some((name, metres)) if (metres / size - 1.0).abs() > 1e-9 => {
            let made = distance_span(near_m * metres / size, far_m * metres / size);
            format!("the depth unit {name} would make it {made}")
        }
        _ => "check the depth unit".to_owned(),
    }
}

/// The distances of a scene, without tails and constant background.
struct SceneRange {
    near_m: f64,
    median_m: f64,
    far_m: f64,
}

/// Returns the distances of a scene; `None` if no pixel has one.
fn scene_range(vergence: &[f32]) -> Option<SceneRange> {
    let filled = || vergence.par_iter().copied().filter(|v| *v > 0.0);
    let farthest = filled().reduce(|| f32::INFINITY, f32::min);
    let mut scene: Vec<f32> = filled().filter(|v| *v > farthest).collect();
    // A value that many pixels share is that of a constant background.
    let fill = filled().count() - scene.len();
    if fill * 100 <= scene.len() + fill || scene.is_empty() {
        scene.extend(std::iter::repeat_n(farthest, fill));
    }
    let last = scene.len().checked_sub(1)?;
    let tail = (TAIL * scene.len() as f64) as usize;
    let mut metres =
        |rank: usize| 1.0 / f64::from(*scene.select_nth_unstable_by(rank, f32::total_cmp).1);
    Some(SceneRange {
        near_m: metres(last - tail),
        median_m: metres(last / 2),
        far_m: metres(tail),
    })
}

/// Finds passes of 8 bits stored as floats.
pub(super) fn quantised(check: &DepthCheck) -> Option<DepthFinding> {
    let levels = levels(check.samples)?;
    let even =
        |f: &dyn Fn(f32) -> f64| evenly_spaced(&levels.iter().map(|v| f(*v)).collect::<Vec<_>>());
    // Half floats are evenly spaced over an octave: a narrow range of them has few levels, too.
    if median_step(&levels) < FINE_STEP
        || levels.len() < MIN_LEVELS
        || !(even(&|v| f64::from(v)) || even(&|v| 1.0 / f64::from(v)))
    {
        return None;
    }
    let steps = count_steps(check, &levels);
    (steps.all >= MIN_STEPS && 2 * steps.between_flats > steps.all).then(|| DepthFinding {
        problem: DepthProblem::Quantised {
            levels: levels.len(),
        },
        severity: Severity::Warning,
        remedy: "write depth as 32-bit or 16-bit floats".to_owned(),
    })
}

/// Returns the distinct numbers in a pass, ascending; `None` if there are more than 8 bits hold.
fn levels(samples: &[f32]) -> Option<Vec<f32>> {
    let mut levels: Vec<f32> = Vec::new();
    let mut last = f32::NAN;
    for &sample in samples {
        // Negative zero is zero.
        let sample = sample + 0.0;
        if sample == last || !sample.is_finite() {
            continue;
        }
        last = sample;
        if let Err(place) = levels.binary_search_by(|v| v.total_cmp(&sample)) {
            if levels.len() > MAX_LEVELS {
                return None;
            }
            levels.insert(place, sample);
        }
    }
    // One more than 256 is allowed: a constant background.
    Some(levels)
}

/// Returns the median relative step from level to level.
fn median_step(levels: &[f32]) -> f64 {
    let steps = levels.windows(2).map(|pair| {
        let [low, high] = [pair[0], pair[1]].map(f64::from);
        (high - low) / low.abs().max(high.abs())
    });
    let mut steps: Vec<f64> = steps.collect();
    median(&mut steps)
}

/// Returns whether nearly all gaps are whole multiples of the smallest.
fn evenly_spaced(levels: &[f64]) -> bool {
    let gaps = levels.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let gaps: Vec<f64> = gaps.filter(|gap| gap.is_finite()).collect();
    let mut sorted = gaps.clone();
    sorted.sort_by(f64::total_cmp);
    // The smallest gap, without outliers.
    let Some(&unit) = sorted.get(sorted.len() / 20) else {
        return false;
    };
    let whole = |gap: &&f64| {
        let count = **gap / unit;
        count < 1e3 && (count - count.round()).abs() < 0.05 && count > 0.5
    };
    let fit = gaps.iter().filter(whole).count();
    // Ends of the range may be clipped between levels, and a background lie anywhere.
    fit + 3 >= gaps.len()
}

/// Numbers of steps from one level to the next.
struct Steps {
    all: usize,
    /// Those between flats of at least two pixels: smooth surfaces in float have none, those in 8 bits little else.
    between_flats: usize,
}

/// Counts the steps between neighbouring levels along rows and columns.
fn count_steps(check: &DepthCheck, levels: &[f32]) -> Steps {
    let place = |v: f32| levels.partition_point(|level| *level < v);
    let mut steps = Steps {
        all: 0,
        between_flats: 0,
    };
    let mut look = |run: [f32; 4]| {
        if run[1] == run[2] || !run.iter().all(|v| v.is_finite()) {
            return;
        }
        if place(run[1]).abs_diff(place(run[2])) == 1 {
            steps.all += 1;
            steps.between_flats += usize::from(run[0] == run[1] && run[2] == run[3]);
        }
    };
    for row in 0..check.height {
        for column in 0..check.width {
            if column + 3 < check.width {
                look(std::array::from_fn(|k| check.sample(column + k, row)));
            }
            if row + 3 < check.height {
                look(std::array::from_fn(|k| check.sample(column, row + k)));
            }
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CameraPerspective, LensDistances};
    use seidel_optics::field::ImagePoint;

    /// Returns whether distances from `near_m` to twice that are found to be off a lens measured from 1.2 m to `measured_to_m`.
    fn is_off(near_m: f32, measured_to_m: f64) -> bool {
        let samples: Vec<f32> = (0..100).map(|k| near_m * (1.0 + k as f32 / 99.0)).collect();
        let vergence: Vec<f32> = samples.iter().map(|z| 1.0 / z).collect();
        let finding = unit(&DepthCheck {
            samples: &samples,
            vergence: &vergence,
            width: 10,
            height: 10,
            convention: DepthConvention::Distance {
                metres_per_unit: 1.0,
            },
            colours: &[],
            alpha: None,
            view: CameraPerspective {
                axis: ImagePoint::new(5.0, 5.0),
                focal_px: None,
                pixel_aspect: 1.0,
            },
            lens: LensDistances {
                measured_m: Some((1.2, measured_to_m)),
                focal_length_m: Some(0.05),
            },
        });
        finding.is_some_and(|finding| finding.remedy.contains("depth unit"))
    }

    #[test]
    fn millimetres_are_noticed_for_lenses_measured_at_infinity_too() {
        // Two to four metres, and a hundred: in millimetres, and as they are.
        for measured_to_m in [4.0, f64::INFINITY] {
            assert!(is_off(2000.0, measured_to_m), "{measured_to_m}");
            assert!(!is_off(2.0, measured_to_m), "{measured_to_m}");
        }
        assert!(!is_off(100.0, f64::INFINITY));
    }
}
