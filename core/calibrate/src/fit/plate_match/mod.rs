//! The lens of a plate of any content, from its own edges and lights.
//!
//! The scene adds blur of its own to many edges: soft shadows, round corners, depth. What that leaves of the lens is known in
//! three degrees, each with an interval from a bootstrap over the edges:
//!
//! 1. Differences between channels: every channel has the same scene, so its blur cancels.
//! 2. Differences over the field, as the scene's blur does not depend on the distance from the axis.
//! 3. The size of the blur: the lower envelope of the variances, which needs sharp edges (`scene_blur`). Where none stand out
//!    from the others, or the interval is wide, the match is refused.
//!
//! The rays of the lens are then fitted to the profiles of the sharper edges, each with its own estimated blur (`edges`).

mod bootstrap;
mod plate_sample;
mod scene_blur;
#[cfg(test)]
mod tests;

use super::AxisChoice;
use super::edges::{Departures, EdgeFitSettings, find_axis, find_departures, fit_edges};
use crate::stage::Stage;
use bootstrap::{Interval, MatchedMoments};
use plate_sample::PlateSample;
use scene_blur::Softness;
use seidel_optics::Progress;
use seidel_optics::edges::{Edge, EdgeSet};
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::profile::{LensDescription, LensProfile};

/// Settings of [`match_plate`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchSettings {
    /// Position of the optical axis.
    pub axis: AxisChoice,
    /// Index of the channel whose sharp edges give the size of the blur.
    pub reference: usize,
    /// Error that all variances share, px²: interpolated colours, transfer functions. Channels differ by it, too.
    pub shared_error_px2: f64,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// A light of a plate: the variance of its image, mean of all directions, in every channel.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateLight {
    /// Place in the frame.
    pub at: ImagePoint,
    /// Variance without the pixel's area and its standard deviation by channel, px²; `None` where it was not measured.
    pub variances: Vec<Option<[f64; 2]>>,
}

/// A value with half its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Half the width of its 95 % interval.
    pub half_width: f64,
}

/// The blur of a channel of a matched lens. Variances are means over the frame and all directions, without the pixel's area.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchedChannel {
    /// Channel name.
    pub name: String,
    /// Edges and lights that were used.
    pub samples: usize,
    /// Variance less that of the reference channel, px²; zero there.
    pub difference_px2: Estimate,
    /// Variance in the corner less that on the axis, px².
    pub field_px2: Estimate,
    /// Variance, px².
    pub variance_px2: Estimate,
    /// Half the 95 % interval of the second moments over their mean, root mean square over the frame.
    pub relative: f64,
}

/// A lens matched to a plate.
#[derive(Debug, Clone)]
pub struct PlateMatch {
    /// The lens.
    pub lens: LensProfile,
    /// The estimated blur of every channel.
    pub channels: Vec<MatchedChannel>,
    /// Edges and lights of the reference channel.
    pub samples: usize,
    /// Estimated number of sharp ones among them.
    pub sharp: f64,
    /// Mean variance that the scene adds to the others, px².
    pub scene_px2: f64,
    /// True over stated errors of the variances.
    pub noise_scale: f64,
    /// Median chi squared per degree of freedom of the profiles of the sharper edges.
    pub chi2: f64,
    /// As [`EdgeFit::unexplained`](super::edges::EdgeFit::unexplained), of these edges.
    pub unexplained: f64,
    /// Departures of these edges from a lens.
    pub departures: Option<Departures>,
    /// Limits of the result.
    pub warnings: Vec<String>,
}

/// Edges and lights that a match needs in the reference channel.
pub const MIN_SAMPLES: usize = 100;
/// Widest relative interval of the second moments that is not refused.
pub const MAX_RELATIVE: f64 = 0.25;
/// Twice the gain of the log-likelihood by sharp edges below which they may not exist: chance gives it in 1 of 100 plates.
const MIN_SHARP_GAIN: f64 = 6.6;
/// Sharp edges that a match needs.
const MIN_SHARP: f64 = 15.0;
/// Share of sharp edges from which on no softer ones show that the sharp ones are those of the lens.
const ALL_SHARP: f64 = 0.95;
/// Blur of the scene over that of the lens up to which an edge shows the rays of the lens.
const MAX_OWN_BLUR: f64 = 0.6;
/// Standard deviation of the axis, over the frame's width, above which the centre of the frame is taken.
const MAX_AXIS_SIGMA: f64 = 0.03;
/// Difference of the fitted rays from the matched moments, over the interval of these, that is worth a warning.
const MAX_DEPARTURE: f64 = 1.5;

/// Matches a lens to the edges and lights of one plate. The standard error of its symmetric blur includes that of the variance.
///
/// # Errors
/// An invalid set; fewer than [`MIN_SAMPLES`] edges and lights; sharp edges that do not stand out, or a relative interval above
/// [`MAX_RELATIVE`]: the message says what is known of the channels; cancellation by `progress`.
pub fn match_plate(
    set: &EdgeSet,
    lights: &[PlateLight],
    settings: &MatchSettings,
    progress: &Progress,
) -> Result<PlateMatch> {
    let whole = Stage::whole(progress, "match");
    whole.reach(0.0)?;
    set.check()?;
    let frame = match settings.axis {
        AxisChoice::At(axis) => set.frame.with_axis(axis)?,
        AxisChoice::AsObserved | AxisChoice::Free => set.frame,
    };
    let mut matched = Matched::new(set, lights, frame, settings)?;
    let mut warnings = Vec::new();
    if settings.axis == AxisChoice::Free {
        match axis(&matched, set, &frame) {
            Some(axis) => {
                matched = Matched::new(set, lights, frame.with_estimated_axis(axis)?, settings)?
            }
            None => warnings.push(
                "the edges do not determine the optical axis: the centre of the frame was taken"
                    .to_owned(),
            ),
        }
    }
    whole.reach(0.1)?;
    let intervals =
        bootstrap::intervals(&matched.samples, &matched.moments, &matched.frame, settings)?;
    let channels = channels(set, &matched, &intervals);
    whole.reach(0.2)?;
    matched.refuse_uncertain(&channels)?;

    let sharper = sharper(&matched, set);
    let axis = AxisChoice::At(matched.frame.axis());
    let rest = whole.part(0.2, 1.0);
    let fitting = |share: f64| rest.reach(share).is_ok();
    let settings = EdgeFitSettings { axis };
    let departures = find_departures(&sharper, &settings)?;
    let fit = fit_edges(&sharper, &settings, &fitting)?;
    warnings.extend(fit.warnings);
    let mut lens = fit.lens;
    let widest = channels.iter().map(|c| c.relative).fold(0.0, f64::max);
    lens.provenance.settings = format!(
        "matched to a plate: {} edges and lights, {:.0} sharp; second moments within {:.0} % (95 %)",
        matched.count,
        matched.sharp(),
        100.0 * widest
    );
    if let LensDescription::Pupil(pupils) = &mut lens.description {
        for (pupil, interval) in pupils.iter_mut().zip(&intervals) {
            let sigma = &mut pupil.blur_variance_px2.sigma[0];
            *sigma = sigma.hypot(interval.variance);
        }
    }
    if matched.sharp() > ALL_SHARP * matched.count as f64 {
        warnings.push(
            "all edges are equally sharp, so nothing tells the lens from a scene or a plate that is soft everywhere: the size of the blur is right only if the edges of the scene are sharp. Differences between channels are known in either case"
                .to_owned(),
        );
    }
    let departure = departure(&lens, &matched);
    if departure > MAX_DEPARTURE * widest {
        warnings.push(format!(
            "the rays of the lens differ from the matched moments by {:.0} %",
            100.0 * departure
        ));
    }
    Ok(PlateMatch {
        lens,
        channels,
        samples: matched.count,
        sharp: matched.sharp(),
        scene_px2: matched.moments.mixture.mean_px2,
        noise_scale: matched.moments.mixture.noise_scale,
        chi2: fit.chi2,
        unexplained: fit.unexplained,
        departures,
        warnings,
    })
}

/// The moments of a plate's lens with the axis at one place.
struct Matched {
    frame: Frame,
    reference: usize,
    samples: Vec<PlateSample>,
    moments: MatchedMoments,
    /// Edges and lights of the reference channel.
    count: usize,
    /// Twice the gain of the log-likelihood by sharp edges.
    sharp_gain: f64,
}

impl Matched {
    fn new(
        set: &EdgeSet,
        lights: &[PlateLight],
        frame: Frame,
        settings: &MatchSettings,
    ) -> Result<Self> {
        let samples = plate_sample::all(set, lights, &frame);
        let reference = settings.reference;
        let in_reference = samples.iter().filter(|s| s.second[reference].is_some());
        let count = in_reference.count();
        if count < MIN_SAMPLES {
            return Err(Error::new(
                "plate",
                format!(
                    "has {count} edges and lights that can be measured in channel {}, a match needs {MIN_SAMPLES}",
                    set.channels[reference]
                ),
                "give a plate with more straight, well-lit edges, or measure the edges of a chart",
            )
            .with_kind(ErrorKind::InsufficientData));
        }
        let moments = MatchedMoments::of(&samples, reference).ok_or_else(undetermined)?;
        let own = plate_sample::of_channel(&samples, reference);
        let none = scene_blur::fit(&own, moments.noise_scale, Softness::All);
        let none = none.ok_or_else(undetermined)?;
        Ok(Self {
            frame,
            reference,
            count,
            sharp_gain: 2.0 * (moments.mixture.log_likelihood - none.log_likelihood),
            samples,
            moments,
        })
    }

    /// Returns the estimated number of sharp edges and lights.
    fn sharp(&self) -> f64 {
        self.moments.mixture.sharp_share * self.count as f64
    }

    /// Refuses moments whose size is not known.
    fn refuse_uncertain(&self, channels: &[MatchedChannel]) -> Result<()> {
        let own = &channels[self.reference];
        let problem = if self.sharp_gain < MIN_SHARP_GAIN || self.sharp() < MIN_SHARP {
            "does not show how large the blur is: no sharp edges stand out from those that the scene itself blurs".to_owned()
        } else if own.relative > MAX_RELATIVE {
            format!(
                "shows the size of the blur within {:.0} % only, a match needs {:.0} %",
                100.0 * own.relative,
                100.0 * MAX_RELATIVE
            )
        } else {
            return Ok(());
        };
        let others = (channels.iter().enumerate()).filter(|(k, _)| *k != self.reference);
        let known: Vec<String> = others
            .map(|(_, c)| {
                let Estimate { value, half_width } = c.difference_px2;
                format!(
                    "{} less {}: {value:.2} +- {half_width:.2} px²",
                    c.name, own.name
                )
            })
            .collect();
        let known = if known.is_empty() {
            String::new()
        } else {
            format!(
                ". Known are the differences of the variances: {}",
                known.join(", ")
            )
        };
        Err(Error::new(
            "plate",
            format!("{problem}{known}"),
            "give a plate with sharp edges in focus, or measure the edges of a chart",
        )
        .with_kind(ErrorKind::InsufficientData))
    }
}

fn undetermined() -> Error {
    Error::new(
        "plate",
        "has edges that do not determine the blur over the frame",
        "give a plate with edges all over the frame, in two orientations or more",
    )
    .with_kind(ErrorKind::InsufficientData)
}

/// Returns the edges of `set` that the scene hardly blurs, without its blur: the variance is taken off, and the profile states
/// it as a spread.
fn sharper(matched: &Matched, set: &EdgeSet) -> EdgeSet {
    let reference = plate_sample::of_channel(&matched.samples, matched.reference);
    let own = scene_blur::blurs(&matched.moments.mixture, &reference);
    let in_reference = matched
        .samples
        .iter()
        .filter(|s| s.second[matched.reference].is_some());
    let mut edges: Vec<Edge> = Vec::new();
    for (sample, own) in in_reference.zip(&own) {
        for edge in sample.edges.iter().map(|k| &set.edges[*k]) {
            if own.mean > MAX_OWN_BLUR * (edge.variance_px2 - own.mean) {
                continue;
            }
            let mut edge = edge.clone();
            edge.variance_px2 -= own.mean;
            edge.variance_sigma = edge.variance_sigma.hypot(own.spread.sqrt());
            for bin in &mut edge.profile {
                bin.spread_px2 += own.mean;
            }
            edges.push(edge);
        }
    }
    EdgeSet {
        edges,
        frame: matched.frame,
        ..set.clone()
    }
}

/// Returns the axis that the sharper edges show; `None` if they do not determine it.
fn axis(matched: &Matched, set: &EdgeSet, frame: &Frame) -> Option<ImagePoint> {
    let edges = sharper(matched, set).edges;
    let channels = 0..set.channels.len();
    let groups = channels.map(|c| edges.iter().filter(|e| e.channel == c).collect());
    let groups: Vec<Vec<&Edge>> = groups.collect();
    let found = find_axis(frame, &groups).ok()?;
    let limit = MAX_AXIS_SIGMA * f64::from(frame.width_px());
    let sure = found.converged && found.sigma_px.0 < limit && found.sigma_px.1 < limit;
    sure.then_some(found.axis)
}

fn channels(set: &EdgeSet, matched: &Matched, intervals: &[Interval]) -> Vec<MatchedChannel> {
    let moments = &matched.moments;
    let grid = bootstrap::Grid::of(&matched.frame);
    let estimate = |value: f64, sigma: f64| Estimate {
        value,
        half_width: bootstrap::NORMAL_95 * sigma,
    };
    let each = set.channels.iter().zip(&moments.s).zip(intervals);
    each.enumerate()
        .map(|(index, ((name, s), interval))| MatchedChannel {
            name: name.clone(),
            samples: matched
                .samples
                .iter()
                .filter(|x| x.second[index].is_some())
                .count(),
            difference_px2: estimate(
                grid.mean(s) - grid.mean(&moments.s[matched.reference]),
                interval.difference,
            ),
            field_px2: estimate(grid.corner_less_axis(s), interval.field),
            variance_px2: estimate(grid.mean(s), interval.variance),
            relative: bootstrap::NORMAL_95 * interval.rms / grid.mean(s).max(f64::MIN_POSITIVE),
        })
        .collect()
}

/// Returns the difference of the second moments of `lens` from the matched ones, root mean square over the frame, over their
/// mean: the largest of all channels.
fn departure(lens: &LensProfile, matched: &Matched) -> f64 {
    let grid = bootstrap::Grid::of(&matched.frame);
    let vergence = |c: &seidel_optics::profile::PupilChannel| c.measured_vergence.0;
    let each = lens.pupil_channels().iter().zip(&matched.moments.s);
    each.map(|(channel, s)| {
        let of_rays = |at| channel.moments_at(at, vergence(channel));
        grid.rms_against(s, of_rays) / grid.mean(s)
    })
    .fold(0.0, f64::max)
}
