//! Second moments of all channels of a plate, and their intervals by a bootstrap over its edges and lights.

use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::CentralMoments;
use seidel_optics::numeric::{SplitMix64, dot, median};

use super::plate_sample::{self, PlateSample};
use super::scene_blur::{self, Mixture, Sample, Softness, UNKNOWNS};
use super::{MatchSettings, undetermined};
use crate::fit::edges::variance_row;

/// Half width of a 95 % interval, standard deviations.
pub(super) const NORMAL_95: f64 = 1.96;
/// Number of resamples.
const RESAMPLES: usize = 80;
/// Number of resamples that may leave the moments undetermined.
const MAX_FAILED: usize = 8;
/// Iterations of reweighting of the differences between channels.
const ITERATIONS: usize = 12;
/// Ratio of a residual to its expected size above which a difference loses weight.
const TOLERANCE: f64 = 3.0;
/// Least ratio of true to stated errors: channels may agree better with each other than edges do.
const LEAST_NOISE_SCALE: f64 = 0.1;
/// Median absolute value of the standard normal distribution.
const NORMAL_MEDIAN: f64 = 0.6745;
/// Places along x and y, and directions, at which moments are compared.
const PLACES: [usize; 2] = [9, 6];
const DIRECTIONS: usize = 4;
/// Relative error of the size from edge profiles that the model of the blur does not fit. No plate shows it.
const MODEL_ERROR: f64 = 0.01;

/// Second moments of all channels.
#[derive(Debug, Clone)]
pub(super) struct MatchedMoments {
    /// S1..S5 by channel.
    pub(super) s: Vec<[f64; UNKNOWNS]>,
    /// The scene as the reference channel shows it.
    pub(super) mixture: Mixture,
    /// True over stated errors, from the differences between channels; 1 for a single channel.
    pub(super) noise_scale: f64,
}

impl MatchedMoments {
    /// Estimates the moments; `None` if `samples` do not determine them.
    pub(super) fn of(samples: &[PlateSample], reference: usize) -> Option<Self> {
        let differences = Differences::of(samples, reference)?;
        let own = plate_sample::of_channel(samples, reference);
        let mixture = scene_blur::fit(&own, differences.noise_scale, Softness::Some)?;
        Some(Self::joined(differences, mixture))
    }

    /// Estimates the moments of a resample, from those of all samples.
    fn of_resample(&self, samples: &[PlateSample], reference: usize) -> Option<Self> {
        let differences = Differences::of(samples, reference)?;
        let own = plate_sample::of_channel(samples, reference);
        let mixture = scene_blur::refine(&own, self.mixture.clone(), Softness::Some)?;
        Some(Self::joined(differences, mixture))
    }

    fn joined(differences: Differences, mixture: Mixture) -> Self {
        let each = differences.s.iter();
        Self {
            s: each
                .map(|d| std::array::from_fn(|k| mixture.s[k] + d[k]))
                .collect(),
            mixture,
            noise_scale: differences.noise_scale,
        }
    }
}

/// S1..S5 of every channel less those of the reference.
struct Differences {
    s: Vec<[f64; UNKNOWNS]>,
    /// True over stated errors.
    noise_scale: f64,
}

impl Differences {
    fn of(samples: &[PlateSample], reference: usize) -> Option<Self> {
        let channels = samples.first()?.second.len();
        let mut s = vec![[0.0; UNKNOWNS]; channels];
        let mut scales = Vec::new();
        for channel in (0..channels).filter(|c| *c != reference) {
            let pairs: Vec<Sample> = (samples.iter())
                .filter_map(|sample| {
                    let (a, b) = (sample.second[channel]?, sample.second[reference]?);
                    Some(Sample {
                        row: a.row,
                        value: a.value - b.value,
                        sigma: a.sigma.hypot(b.sigma),
                    })
                })
                .collect();
            let (values, scale) = robust(&pairs)?;
            s[channel] = values;
            scales.push(scale);
        }
        let mean = scales.iter().sum::<f64>() / scales.len().max(1) as f64;
        Some(Self {
            s,
            noise_scale: if scales.is_empty() {
                1.0
            } else {
                mean.max(LEAST_NOISE_SCALE)
            },
        })
    }
}

/// Returns the coefficients by iteratively reweighted least squares, and the scatter of the residuals over the stated errors.
fn robust(pairs: &[Sample]) -> Option<([f64; UNKNOWNS], f64)> {
    let targets: Vec<f64> = pairs.iter().map(|p| p.value).collect();
    let plain: Vec<f64> = pairs.iter().map(|p| p.sigma.powi(-2)).collect();
    let mut s = scene_blur::solve(pairs, &targets, &plain)?;
    let mut scale = 1.0;
    for _ in 0..ITERATIONS {
        let residuals: Vec<f64> = (pairs.iter())
            .map(|p| (p.value - p.lens(&s)).abs() / p.sigma)
            .collect();
        scale = median(&mut residuals.clone()) / NORMAL_MEDIAN;
        let limit = TOLERANCE * scale.max(1e-9);
        let weights: Vec<f64> = (residuals.iter().zip(&plain))
            .map(|(r, w)| w / (1.0 + (r / limit).powi(2)))
            .collect();
        s = scene_blur::solve(pairs, &targets, &weights)?;
    }
    Some((s, scale))
}

/// Standard deviations of the estimates of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    pub(super) difference: f64,
    pub(super) field: f64,
    pub(super) variance: f64,
    /// Root mean square of the second moments' deviations over the frame.
    pub(super) rms: f64,
}

/// Returns the standard deviations of every channel's figures over resamples.
///
/// # Errors
/// Samples that do not determine the moments in too many resamples.
pub(super) fn intervals(
    samples: &[PlateSample],
    moments: &MatchedMoments,
    frame: &Frame,
    settings: &MatchSettings,
) -> Result<Vec<Interval>> {
    let grid = Grid::of(frame);
    let mut random = SplitMix64::new(settings.seed);
    let mut found = Vec::new();
    for _ in 0..RESAMPLES {
        let drawn = (0..samples.len()).map(|_| samples[random.below(samples.len())].clone());
        let drawn: Vec<PlateSample> = drawn.collect();
        found.extend(moments.of_resample(&drawn, settings.reference));
    }
    if found.len() + MAX_FAILED < RESAMPLES {
        return Err(undetermined());
    }
    let sigma = |of: &dyn Fn(&MatchedMoments) -> f64| {
        let values: Vec<f64> = found.iter().map(of).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
    };
    let reference = settings.reference;
    Ok((0..moments.s.len())
        .map(|c| {
            let shared = settings.shared_error_px2;
            let model = (MODEL_ERROR * grid.mean(&moments.s[c])).hypot(shared);
            let squares = found
                .iter()
                .map(|m| grid.rms(&m.s[c], &moments.s[c]).powi(2));
            let square = squares.sum::<f64>() / found.len() as f64;
            Interval {
                difference: if c == reference {
                    0.0
                } else {
                    sigma(&|m| grid.mean(&m.s[c]) - grid.mean(&m.s[reference])).hypot(shared)
                },
                field: sigma(&|m| grid.corner_less_axis(&m.s[c])),
                variance: sigma(&|m| grid.mean(&m.s[c])).hypot(model),
                rms: square.sqrt().hypot(model),
            }
        })
        .collect())
}

/// Places of the frame at which moments are compared.
pub(super) struct Grid {
    places: Vec<FieldPoint>,
    corner: f64,
}

impl Grid {
    pub(super) fn of(frame: &Frame) -> Self {
        let [columns, rows] = PLACES;
        let part =
            |k: usize, count: usize, size: u32| (k as f64 + 0.5) / count as f64 * f64::from(size);
        let places = (0..columns * rows).map(|k| {
            frame.field_point(ImagePoint::new(
                part(k % columns, columns, frame.width_px()),
                part(k / columns, rows, frame.height_px()),
            ))
        });
        let (x, y) = (f64::from(frame.width_px()), f64::from(frame.height_px()));
        Self {
            places: places.collect(),
            corner: x.hypot(y) / x,
        }
    }

    /// Returns the mean variance of all places and directions.
    pub(super) fn mean(&self, s: &[f64; UNKNOWNS]) -> f64 {
        let each = self
            .places
            .iter()
            .map(|at| dot(&plate_sample::all_directions(*at), s));
        each.sum::<f64>() / self.places.len() as f64
    }

    /// Returns the variance in the corner of a centred frame less that on the axis, mean of all directions.
    pub(super) fn corner_less_axis(&self, s: &[f64; UNKNOWNS]) -> f64 {
        let at = |r: f64| dot(&plate_sample::all_directions(FieldPoint::new(r, 0.0)), s);
        at(self.corner) - at(0.0)
    }

    /// Returns the difference of second moments, root mean square over places and directions.
    pub(super) fn rms(&self, a: &[f64; UNKNOWNS], b: &[f64; UNKNOWNS]) -> f64 {
        self.root_mean_square(|at, normal| {
            let row = variance_row(at, normal);
            dot(&row, a) - dot(&row, b)
        })
    }

    /// As [`Self::rms`], against `moments` at a place.
    pub(super) fn rms_against(
        &self,
        s: &[f64; UNKNOWNS],
        moments: impl Fn(FieldPoint) -> CentralMoments,
    ) -> f64 {
        self.root_mean_square(|at, [x, y]| {
            let m = moments(at);
            let along = m.mu20 * x * x + 2.0 * m.mu11 * x * y + m.mu02 * y * y;
            along - dot(&variance_row(at, [x, y]), s)
        })
    }

    fn root_mean_square(&self, difference: impl Fn(FieldPoint, [f64; 2]) -> f64) -> f64 {
        let mut square = 0.0;
        for at in &self.places {
            for k in 0..DIRECTIONS {
                let (sin, cos) = (k as f64 / DIRECTIONS as f64 * std::f64::consts::PI).sin_cos();
                square += difference(*at, [cos, sin]).powi(2);
            }
        }
        (square / (self.places.len() * DIRECTIONS) as f64).sqrt()
    }
}
