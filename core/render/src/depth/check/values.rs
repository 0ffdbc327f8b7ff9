//! What the numbers of a depth pass tell by themselves: their range, their levels, their number.

use super::super::DepthConvention;
use super::{DepthCheck, DepthFinding, DepthProblem, Severity};

/// Share of pixels left out at either end of a range.
const TAIL: f64 = 0.02;
/// Half of a scene is never nearer than this to a lens, nor than its focal length, metres...
const NEAREST_M: f64 = 0.01;
/// ...and hardly a scene has nothing nearer than this.
const FARTHEST_M: f64 = 1e4;
/// A scene may lie this many times farther, or nearer, than a lens was measured.
const BEYOND_LENS: f64 = 20.0;
/// Levels of 8 bits.
const MOST_LEVELS: usize = 256;
/// Fewer may be as many cards.
const LEAST_LEVELS: usize = 40;
/// Steps of less than this share of the distance are as fine as half floats, and harmless.
const FINE_STEP: f64 = 0.001;
/// Steps on surfaces that must be seen.
const LEAST_STEPS: usize = 200;
/// Pixels with a distance below which a pass is empty, as a share.
const LEAST_FILLED: f64 = 0.001;

/// A pass with nothing in it, or the same everywhere.
pub(super) fn constant(check: &DepthCheck) -> Option<DepthFinding> {
    let mut depths = check.vergence.iter().zip(check.samples);
    let filled = check.vergence.iter().filter(|v| **v > 0.0).count();
    let share = filled as f64 / check.vergence.len() as f64;
    if share < LEAST_FILLED {
        return Some(DepthFinding {
            problem: DepthProblem::Empty { share },
            severity: Severity::Warning,
            remedy: "check which channel and frame it is, and what its numbers mean".to_owned(),
        });
    }
    let (first, sample) = depths.find(|(v, _)| **v > 0.0)?;
    let same = depths.all(|(v, _)| *v <= 0.0 || v == first);
    same.then(|| DepthFinding {
        problem: DepthProblem::Constant {
            value: f64::from(*sample),
        },
        severity: Severity::Note,
        remedy: "check which channel it is; --distance gives one distance to a whole plate"
            .to_owned(),
    })
}

/// Numbers from 0 to 1 that are read as metres.
pub(super) fn normalised(check: &DepthCheck) -> Option<DepthFinding> {
    let DepthConvention::Distance { metres_per_unit } = check.convention else {
        return None;
    };
    let (least, largest) = check
        .samples
        .iter()
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| {
            (low.min(*v), high.max(*v))
        });
    // Another unit was chosen by someone who knew the numbers.
    let fills = (0.0..=0.05).contains(&least) && (0.98..=1.0).contains(&largest);
    let filled = check.vergence.iter().filter(|v| **v > 0.0).count() as f64;
    let ends = check.samples.iter().filter(|v| **v == 1.0).count() as f64;
    // A whole background at one metre to the last bit is where far was put.
    let far_fill = (0.0..1.0).contains(&least) && largest == 1.0 && ends > 0.01 * filled;
    (metres_per_unit == 1.0 && (fills || far_fill)).then(|| DepthFinding {
        problem: DepthProblem::Normalised {
            least: f64::from(least),
            largest: f64::from(largest),
        },
        severity: Severity::Warning,
        remedy: "give --depth-kind far-one or far-zero with --near and --far".to_owned(),
    })
}

/// Distances where no scene is, or far from where the lens was measured.
pub(super) fn unit(check: &DepthCheck) -> Option<DepthFinding> {
    let (near_m, middle_m, far_m) = middle_range(check.vergence)?;
    let nearest = check
        .lens
        .focal_length_m
        .unwrap_or(NEAREST_M)
        .max(NEAREST_M);
    if middle_m < nearest || near_m > FARTHEST_M {
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
    let off = near_m > BEYOND_LENS * measured_m.1 || far_m * BEYOND_LENS < measured_m.0;
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

/// A range that cannot be may come of one over the numbers.
fn kind_remedy(convention: DepthConvention) -> &'static str {
    match convention {
        DepthConvention::Distance { .. } => {
            "; --depth-kind inverse, if they are one over distances"
        }
        DepthConvention::Inverse { .. } => "; --depth-kind distance, if they are distances",
        DepthConvention::FarOne { .. } | DepthConvention::FarZero { .. } => "",
    }
}

/// Which unit would put the scene where the lens was measured.
fn unit_remedy(check: &DepthCheck, near_m: f64, far_m: f64) -> String {
    let (DepthConvention::Distance { metres_per_unit }
    | DepthConvention::Inverse { metres_per_unit }) = check.convention
    else {
        return "check --near and --far, which are metres".to_owned();
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
            let (near, far) = (near_m * metres / size, far_m * metres / size);
            format!("--depth-unit {name} would make it {near:.4} m to {far:.4} m")
        }
        _ => "check --depth-unit".to_owned(),
    }
}

/// Nearest, middle and farthest distance, metres, without the tails and without a background fill.
fn middle_range(vergence: &[f32]) -> Option<(f64, f64, f64)> {
    let mut seen: Vec<f32> = vergence.iter().copied().filter(|v| *v > 0.0).collect();
    seen.sort_by(f32::total_cmp);
    let farthest = *seen.first()?;
    let fill = seen.partition_point(|v| *v <= farthest);
    let scene = &seen[if fill * 100 > seen.len() && fill < seen.len() {
        fill
    } else {
        0
    }..];
    let tail = (TAIL * scene.len() as f64) as usize;
    let metres = |v: f32| 1.0 / f64::from(v);
    let last = scene.len() - 1;
    Some((
        metres(scene[last - tail]),
        metres(scene[last / 2]),
        metres(scene[tail]),
    ))
}

/// A pass of 8 bits stretched to floats.
pub(super) fn quantised(check: &DepthCheck) -> Option<DepthFinding> {
    let levels = levels(check.samples)?;
    let even =
        |f: &dyn Fn(f32) -> f64| evenly_spaced(&levels.iter().map(|v| f(*v)).collect::<Vec<_>>());
    // Half floats are spaced evenly over an octave: a narrow range of them has few levels of its own.
    if middle_step(&levels) < FINE_STEP
        || levels.len() < LEAST_LEVELS
        || !(even(&|v| f64::from(v)) || even(&|v| 1.0 / f64::from(v)))
    {
        return None;
    }
    let (steps, lone) = steps(check, &levels);
    (steps >= LEAST_STEPS && 2 * lone > steps).then(|| DepthFinding {
        problem: DepthProblem::Quantised {
            levels: levels.len(),
        },
        severity: Severity::Warning,
        remedy: "write depth as 32-bit or 16-bit floats".to_owned(),
    })
}

/// The different numbers in a pass, rising; `None` if there are more than 8 bits hold.
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
            if levels.len() > MOST_LEVELS {
                return None;
            }
            levels.insert(place, sample);
        }
    }
    // One beyond, for a background fill of its own.
    Some(levels)
}

/// Middle of the steps from level to level, as shares of the levels.
fn middle_step(levels: &[f32]) -> f64 {
    let steps = levels.windows(2).map(|pair| {
        let [low, high] = [pair[0], pair[1]].map(f64::from);
        (high - low) / low.abs().max(high.abs())
    });
    let mut steps: Vec<f64> = steps.collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// Whether nearly all gaps are whole multiples of one.
fn evenly_spaced(levels: &[f64]) -> bool {
    let gaps = levels.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let gaps: Vec<f64> = gaps.filter(|gap| gap.is_finite()).collect();
    let mut sorted = gaps.clone();
    sorted.sort_by(f64::total_cmp);
    // The smallest but for the odd one out.
    let Some(&unit) = sorted.get(sorted.len() / 20) else {
        return false;
    };
    let whole = |gap: &&f64| {
        let count = **gap / unit;
        count < 1e3 && (count - count.round()).abs() < 0.05 && count > 0.5
    };
    let fit = gaps.iter().filter(whole).count();
    // An end of the range may be cut off between levels, a fill lie anywhere.
    fit + 3 >= gaps.len()
}

/// Steps from one level to the next, and those of them with flats of at least two pixels on both
/// sides: a smooth surface in float never has those, one of 8 bits has little else.
fn steps(check: &DepthCheck, levels: &[f32]) -> (usize, usize) {
    let place = |v: f32| levels.partition_point(|level| *level < v);
    let (mut steps, mut lone) = (0, 0);
    let mut look = |run: [f32; 4]| {
        if run[1] == run[2] || !run.iter().all(|v| v.is_finite()) {
            return;
        }
        if place(run[1]).abs_diff(place(run[2])) == 1 {
            steps += 1;
            lone += usize::from(run[0] == run[1] && run[2] == run[3]);
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
    (steps, lone)
}
