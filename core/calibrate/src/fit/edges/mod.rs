//! Fit of a lens to the profiles of straight edges.
//!
//! 1. S1..S10 of every channel and distance, and the axis, from the moments along the edges' normals (`edge_moments`).
//! 2. Initial estimates with all choices of sign (`starts`), compared by the profiles of a few edges.
//! 3. The best is refined over all edges, distances and channels by Levenberg-Marquardt, with a robust loss per edge
//!    (`edge_problem`). A ray shifts the step by its landing point along the normal (`profile_model`, `rays`).
//! 4. Fifth-order aberrations and vignetting are added where they improve edges of held-out zones.

mod departures;
mod edge_moments;
mod edge_problem;
mod profile_model;
mod rays;
mod starts;
#[cfg(test)]
mod tests;

use nalgebra::DMatrix;

use super::pixels::parameters::{ModelStructure, ParameterLayout, Quantity};
use super::pixels::parts::{self, Part};
use super::{AxisChoice, coverage, holdout};
use crate::fit::axis::AxisEstimate;
use crate::least_squares::Stop;
use crate::stage::Stage;
pub use departures::{Departures, Term};
pub(super) use edge_moments::{find_axis, variance_row};
use edge_problem::{EdgePoint, EdgeProblem};
use profile_model::FitEdge;
use seidel_optics::Progress;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::edges::{Edge, EdgeSet};
use seidel_optics::effects;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::MomentCoefficients;
use seidel_optics::numeric::median;
use seidel_optics::profile::{LensDescription, LensProfile, ProfileEffect, Provenance};

/// Settings of [`fit_edges`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EdgeFitSettings {
    /// Position of the optical axis.
    pub axis: AxisChoice,
}

/// A lens fitted to edges, with its report.
#[derive(Debug, Clone)]
pub struct EdgeFit {
    /// The fitted lens profile.
    pub lens: LensProfile,
    /// S1..S10 by channel and distance, from the moments of the edges alone.
    pub planes: Vec<EdgePlane>,
    /// The estimated optical axis, for [`AxisChoice::Free`].
    pub axis: Option<AxisEstimate>,
    /// Median chi squared per degree of freedom of the profiles.
    pub chi2: f64,
    /// Root mean square of the residuals of the profiles beyond the noise, over the step.
    pub unexplained: f64,
    /// Whether the last minimisation converged.
    pub converged: bool,
    /// Limits of the result.
    pub warnings: Vec<String>,
}

/// S1..S10 of one channel at one object distance, from edges.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgePlane {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Number of edges.
    pub edges: usize,
    /// S1..S10: optical moments in px to their order, field in half frame widths.
    pub s: MomentCoefficients,
    /// Standard errors of S1..S10.
    pub s_sigma: [f64; 10],
}

/// Edges that a channel needs at a distance.
const MIN_EDGES: usize = 12;
/// Variance of the symmetric blur at which fits start, px².
const INITIAL_BLUR_PX2: f64 = 0.25;
/// Edges per channel on which initial estimates are compared, and those refined.
const SCREENING_EDGES: usize = 24;
const TRIAL_EDGES: usize = 48;
const MAX_TRIALS: usize = 8;
/// Edges per channel on which parts are compared.
const PART_EDGES: usize = 120;
const QUICK: Stop = Stop::at_decrease(8, 1e-2);
const BETWEEN: Stop = Stop::at_decrease(12, 1e-3);
const THOROUGH: Stop = Stop::at_decrease(40, 1e-5);

/// Fits a lens to the edges of one camera.
///
/// # Errors
/// An invalid set; known and unknown distances mixed; a channel with too few edges, or with edges that do not determine
/// S1..S10; cancellation by `progress`.
pub fn fit_edges(
    set: &EdgeSet,
    settings: &EdgeFitSettings,
    progress: &Progress,
) -> Result<EdgeFit> {
    let whole = Stage::whole(progress, "fit");
    whole.reach(0.0)?;
    set.check()?;
    let distances = distances(set)?;
    let groups = groups(set, &distances)?;
    let frame = axis_frame(set, settings, &groups)?;
    let planes = planes(set, &frame, &groups)?;
    whole.reach(0.1)?;
    let context = Context::new(set, frame, &distances);
    let mut fit = context.fit_reduced(&planes, settings.axis, whole.part(0.1, 0.4))?;
    fit = context.add_parts(fit, whole.part(0.4, 0.8))?;
    whole.reach(0.8)?;
    let all: Vec<&FitEdge> = context.edges.iter().collect();
    let (fit, point) = context.refined(&fit, &all, THOROUGH);
    whole.reach(1.0)?;
    context.assemble(fit, &point, planes, settings.axis)
}

/// Estimates the departures of edges from what any lens makes. `None` where the edges do not determine them.
///
/// # Errors
/// As [`fit_edges`], which takes much longer.
pub fn find_departures(set: &EdgeSet, settings: &EdgeFitSettings) -> Result<Option<Departures>> {
    set.check()?;
    let groups = groups(set, &distances(set)?)?;
    let frame = axis_frame(set, settings, &groups)?;
    Ok(Departures::of(&frame, &groups))
}

/// Returns the frame with the axis of `settings`, estimated from the moments of the edges where it is free.
fn axis_frame(set: &EdgeSet, settings: &EdgeFitSettings, groups: &[Vec<&Edge>]) -> Result<Frame> {
    let frame = match settings.axis {
        AxisChoice::At(axis) => return set.frame.with_axis(axis),
        AxisChoice::AsObserved => return Ok(set.frame),
        AxisChoice::Free => set.frame,
    };
    frame.with_estimated_axis(edge_moments::find_axis(&frame, groups)?.axis)
}

/// Returns the distances of the edges by rising vergence.
fn distances(set: &EdgeSet) -> Result<Vec<ObjectDistance>> {
    let mut distances: Vec<ObjectDistance> = Vec::new();
    for edge in &set.edges {
        if !distances.contains(&edge.distance) {
            distances.push(edge.distance);
        }
    }
    if distances.len() > 1 && distances.contains(&ObjectDistance::Unknown) {
        return Err(Error::new(
            "depth_m",
            "is known for some photographs only",
            "give the distance of every photograph, or of none",
        ));
    }
    let vergence = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(0.0);
    distances.sort_by(|a, b| vergence(a).total_cmp(&vergence(b)));
    Ok(distances)
}

/// Returns the edges of every channel and distance, channel by channel.
fn groups<'a>(set: &'a EdgeSet, distances: &[ObjectDistance]) -> Result<Vec<Vec<&'a Edge>>> {
    let mut groups = Vec::new();
    for (channel, name) in set.channels.iter().enumerate() {
        for distance in distances {
            let of = |e: &&Edge| e.channel == channel && e.distance == *distance;
            let edges: Vec<&Edge> = set.edges.iter().filter(of).collect();
            if edges.len() < MIN_EDGES {
                return Err(Error::new(
                    format!("channel {name} at {distance}"),
                    format!("has {} edges, a fit needs {MIN_EDGES}", edges.len()),
                    "photograph edges all over the frame, in two orientations or more",
                )
                .with_kind(ErrorKind::InsufficientData));
            }
            groups.push(edges);
        }
    }
    Ok(groups)
}

fn planes(set: &EdgeSet, frame: &Frame, groups: &[Vec<&Edge>]) -> Result<Vec<EdgePlane>> {
    let each = groups.iter().map(|edges| {
        let (channel, distance) = (&set.channels[edges[0].channel], edges[0].distance);
        let fit = edge_moments::fit(frame, edges)
            .map_err(|error| error.within(&format!("channel {channel} at {distance}")))?;
        Ok(EdgePlane {
            channel: channel.clone(),
            distance,
            edges: edges.len(),
            s: fit.s,
            s_sigma: fit.sigma,
        })
    });
    each.collect()
}

/// A lens at some stage of the fit.
#[derive(Clone)]
struct FittedLens {
    layout: ParameterLayout,
    theta: Vec<f64>,
    converged: bool,
}

/// Data of a fit.
struct Context<'a> {
    set: &'a EdgeSet,
    frame: Frame,
    edges: Vec<FitEdge>,
    /// Distinct vergences, rising, 1/m.
    vergences: Vec<f64>,
    stop_lever_m: f64,
}

impl<'a> Context<'a> {
    fn new(set: &'a EdgeSet, frame: Frame, distances: &[ObjectDistance]) -> Self {
        let vergence = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(0.0);
        Self {
            set,
            frame,
            edges: set.edges.iter().map(|e| FitEdge::new(e, &frame)).collect(),
            vergences: distances.iter().map(vergence).collect(),
            stop_lever_m: stop_lever_m(set).unwrap_or(0.0),
        }
    }

    fn layout(&self, structure: ModelStructure) -> ParameterLayout {
        ParameterLayout::new(
            structure,
            self.set.channels.len(),
            self.range(),
            self.stop_lever_m,
        )
    }

    /// Returns the range of vergences, 1/m.
    fn range(&self) -> (f64, f64) {
        let end = |v: Option<&f64>| v.copied().unwrap_or(0.0);
        (end(self.vergences.first()), end(self.vergences.last()))
    }

    /// Fits five reduced numbers and a blur per channel.
    fn fit_reduced(
        &self,
        planes: &[EdgePlane],
        axis: AxisChoice,
        stage: Stage,
    ) -> Result<FittedLens> {
        let layout = self.layout(ModelStructure::reduced(usize::from(
            self.vergences.len() > 1,
        )));
        let mut theta = vec![0.0; layout.parameters.len()];
        layout.set_constant_in_all(&mut theta, Quantity::Blur, INITIAL_BLUR_PX2);
        let channels = self.set.channels.len();
        for (channel, name) in self.set.channels.iter().enumerate() {
            let part = stage.part(0.0, 0.7).part_of(channel, channels);
            part.reach(0.0)?;
            let of_channel: Vec<(f64, MomentCoefficients)> = (planes.iter())
                .filter(|plane| plane.channel == *name)
                .map(|plane| (plane.distance.vergence_per_m().unwrap_or(0.0), plane.s))
                .collect();
            let own: Vec<&FitEdge> = self.edges.iter().filter(|e| e.channel == channel).collect();
            let few = subsample(&own, SCREENING_EDGES);
            let screening = EdgeProblem {
                layout: &layout,
                edges: &few,
            };
            let mut ranked: Vec<(f64, Vec<f64>)> = starts::estimates(&of_channel, INITIAL_BLUR_PX2)
                .iter()
                .map(|start| {
                    let mut trial = theta.clone();
                    layout.set_initial(&mut trial, channel, start);
                    let point = screening.at(trial);
                    (mean_log(&point.misfits), point.theta)
                })
                .collect();
            ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
            let more = subsample(&own, TRIAL_EDGES);
            let problem = EdgeProblem {
                layout: &layout,
                edges: &more,
            };
            let refined = ranked.into_iter().take(MAX_TRIALS).map(|(_, trial)| {
                let found = problem.minimise(&trial, QUICK).point;
                (mean_log(&found.misfits), found.theta)
            });
            let best = refined.min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, best)) = best {
                layout.copy_channel(&mut theta, &best, channel);
            }
        }
        layout.normalise_signs(&mut theta);
        stage.reach(0.7)?;
        let mut structure = layout.structure.clone();
        structure.axis = axis == AxisChoice::Free;
        let free = self.layout(structure);
        let start = FittedLens {
            theta: free.transfer(&layout, &theta),
            layout: free,
            converged: false,
        };
        let all = self.per_channel(PART_EDGES);
        Ok(self.refined(&start, &all, BETWEEN).0)
    }

    /// Adds every part that improves edges of held-out zones, the best first.
    fn add_parts(&self, mut fit: FittedLens, stage: Stage) -> Result<FittedLens> {
        let edges = self.per_channel(PART_EDGES);
        let places: Vec<FieldPoint> = edges.iter().map(|e| e.at).collect();
        let held_out = holdout::held_out_mask(&self.frame, &places);
        let of = |wanted: bool| -> Vec<&FitEdge> {
            let pairs = edges.iter().zip(&held_out);
            pairs
                .filter(|(_, out)| **out == wanted)
                .map(|(e, _)| *e)
                .collect()
        };
        let (fitted, check) = (of(false), of(true));
        if check.is_empty() {
            return Ok(fit);
        }
        let mut open: Vec<Part> = parts::all().filter(|part| part.fit.from_edges).collect();
        let rounds = open.len();
        for round in 0..rounds {
            let plain = self.refined(&fit, &fitted, BETWEEN).0;
            let before = self.point(&plain, &check);
            let mut best: Option<(f64, usize, FittedLens)> = None;
            for (k, part) in open.iter().enumerate() {
                stage
                    .part_of(round, rounds)
                    .part_of(k, open.len())
                    .reach(0.0)?;
                if edges.len() < part.least_tiles() {
                    continue;
                }
                let Some(tried) = self.with_part(&plain, part, &fitted) else {
                    continue;
                };
                let after = self.point(&tried, &check);
                let problem = EdgeProblem {
                    layout: &tried.layout,
                    edges: &check,
                };
                let gain = problem.mean_cost(&before, &before) - problem.mean_cost(&after, &before);
                if gain > best.as_ref().map_or(MIN_GAIN, |b| b.0) {
                    best = Some((gain, k, tried));
                }
            }
            let Some((_, k, tried)) = best else {
                break;
            };
            open.remove(k);
            fit = self.refined(&tried, &edges, BETWEEN).0;
        }
        Ok(fit)
    }

    /// Fits `fit` with one more part, from the best of its starts.
    fn with_part(&self, fit: &FittedLens, part: &Part, edges: &[&FitEdge]) -> Option<FittedLens> {
        let layout = self.layout(part.added_to(&fit.layout.structure));
        let start = layout.transfer(&fit.layout, &fit.theta);
        let which = fit.layout.structure.effects.len();
        let few = subsample(edges, TRIAL_EDGES * self.set.channels.len());
        let starts = (part.fit.starts)();
        let screened = starts.iter().map(|values| {
            let mut theta = start.clone();
            for (k, value) in values.iter().enumerate() {
                layout.set_constant_in_all(&mut theta, Quantity::Effect(which, k), *value);
            }
            let begin = FittedLens {
                layout: layout.clone(),
                theta,
                converged: false,
            };
            if starts.len() == 1 {
                return (0.0, begin);
            }
            let (found, point) = self.refined(&begin, &few, QUICK);
            (mean_log(&point.misfits), found)
        });
        let (_, best) = screened.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(self.refined(&best, edges, BETWEEN).0)
    }

    fn point(&self, fit: &FittedLens, edges: &[&FitEdge]) -> EdgePoint {
        let problem = EdgeProblem {
            layout: &fit.layout,
            edges,
        };
        problem.at(fit.theta.clone())
    }

    fn refined(&self, fit: &FittedLens, edges: &[&FitEdge], stop: Stop) -> (FittedLens, EdgePoint) {
        let problem = EdgeProblem {
            layout: &fit.layout,
            edges,
        };
        let found = problem.minimise(&fit.theta, stop);
        let refined = FittedLens {
            layout: fit.layout.clone(),
            theta: found.point.theta.clone(),
            converged: found.converged,
        };
        (refined, found.point)
    }

    /// Returns at most `count` edges of every channel and distance, spread over all.
    fn per_channel(&self, count: usize) -> Vec<&FitEdge> {
        let channels = 0..self.set.channels.len();
        let groups = channels.flat_map(|c| self.vergences.iter().map(move |v| (c, *v)));
        groups
            .flat_map(|(channel, vergence)| {
                let of = |e: &&FitEdge| e.channel == channel && e.vergence == vergence;
                let own: Vec<&FitEdge> = self.edges.iter().filter(of).collect();
                subsample(&own, count)
            })
            .collect()
    }

    fn assemble(
        &self,
        fit: FittedLens,
        point: &EdgePoint,
        planes: Vec<EdgePlane>,
        axis: AxisChoice,
    ) -> Result<EdgeFit> {
        let all: Vec<&FitEdge> = self.edges.iter().collect();
        let problem = EdgeProblem {
            layout: &fit.layout,
            edges: &all,
        };
        let chi2 = median(&mut point.misfits.clone());
        let mut beyond: Vec<f64> = (all.iter().zip(&point.misfits))
            .map(|(edge, misfit)| (misfit - 1.0).max(0.0).sqrt() * edge.noise())
            .collect();
        let (normal, _) = problem.total(point);
        let covariance = widened(
            inverse(&normal) * chi2.max(1.0),
            &problem.jackknife(point, &inverse),
        );
        let unit = self.frame.half_width_px();
        let [x, y] = fit.layout.axis(&fit.theta);
        let frame =
            (self.frame).with_estimated_axis(self.frame.image_point(FieldPoint::new(x, y)))?;
        let count = fit.theta.len();
        let sigma = |k: usize| covariance[(k, k)].max(0.0).sqrt() * unit;
        let axis = (axis == AxisChoice::Free).then(|| AxisEstimate {
            axis: frame.axis(),
            sigma_px: (sigma(count - 2), sigma(count - 1)),
            converged: fit.converged,
        });
        let channels = (self.set.channels.iter().enumerate()).map(|(index, name)| {
            let mut channel = (fit.layout).channel(&fit.theta, &covariance, index, name);
            let order = |carried: &ProfileEffect| effects::acting_position(carried.effect);
            channel.effects.sort_by_key(order);
            channel.measured_vergence = self.range();
            channel
        });
        let lens = LensProfile {
            frame,
            pixel_pitch_um: self.set.pixel_pitch_um,
            camera: self.set.camera.clone(),
            description: LensDescription::Pupil(channels.collect()),
            held_out: None,
            provenance: Provenance {
                program: concat!("seidel ", env!("CARGO_PKG_VERSION")).to_owned(),
                sources: Vec::new(),
                settings: format!("edges, {}", Provenance::NONE_HELD_OUT),
                ..Provenance::default()
            },
        };
        let mut warnings = Vec::new();
        if !fit.converged {
            warnings.push(
                "the fit did not converge within the maximum number of iterations".to_owned(),
            );
        }
        let places: Vec<ImagePoint> = self.set.edges.iter().map(|e| e.mid).collect();
        warnings.extend(coverage::bare_sides(&self.frame, &places, "edge"));
        Ok(EdgeFit {
            lens,
            planes,
            axis,
            chi2,
            unexplained: median(&mut beyond),
            converged: fit.converged,
            warnings,
        })
    }
}

/// Decrease of the mean loss of a degree of freedom of held-out edges that a part must reach.
const MIN_GAIN: f64 = 0.01;

fn mean_log(misfits: &[f64]) -> f64 {
    misfits.iter().map(|m| m.max(1e-12).ln()).sum::<f64>() / misfits.len().max(1) as f64
}

/// Returns about `count` of `edges`, evenly spaced in the list.
fn subsample<'t>(edges: &[&'t FitEdge], count: usize) -> Vec<&'t FitEdge> {
    let step = (edges.len() as f64 / count as f64).max(1.0);
    (0..)
        .map(|k| (k as f64 * step) as usize)
        .take_while(|k| *k < edges.len())
        .map(|k| edges[k])
        .collect()
}

/// Returns `covariance` with standard errors of at least those of `other`, and its correlations.
fn widened(mut covariance: DMatrix<f64>, other: &DMatrix<f64>) -> DMatrix<f64> {
    for k in 0..covariance.nrows() {
        let ratio = other[(k, k)] / covariance[(k, k)];
        if ratio.is_finite() && ratio > 1.0 {
            covariance.row_mut(k).scale_mut(ratio.sqrt());
            covariance.column_mut(k).scale_mut(ratio.sqrt());
        }
    }
    covariance
}

/// Returns the inverse of a normal matrix on the parameters that the data depend on; zero for the others.
fn inverse(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let count = normal.nrows();
    let used: Vec<usize> = (0..count).filter(|&k| normal[(k, k)] > 0.0).collect();
    let scale: Vec<f64> = used.iter().map(|&k| normal[(k, k)].sqrt()).collect();
    let scaled = DMatrix::from_fn(used.len(), used.len(), |a, b| {
        normal[(used[a], used[b])] / (scale[a] * scale[b])
    });
    let inverse = scaled
        .pseudo_inverse(1e-10)
        .unwrap_or_else(|_| DMatrix::zeros(used.len(), used.len()));
    let mut full = DMatrix::zeros(count, count);
    for (a, &row) in used.iter().enumerate() {
        for (b, &column) in used.iter().enumerate() {
            full[(row, column)] = inverse[(a, b)] / (scale[a] * scale[b]);
        }
    }
    full
}

/// Returns [`seidel_optics::effects::ScenePoint::stop_lever_m`] for a thin lens with the pupil in its plane.
fn stop_lever_m(set: &EdgeSet) -> Option<f64> {
    let f_m = set.camera.focal_length_mm? * 1e-3;
    let radius_m = f_m / (2.0 * set.camera.f_number?);
    let half_width_m = set.frame.half_width_px() * set.pixel_pitch_um? * 1e-6;
    Some(radius_m * f_m / half_width_m)
}
