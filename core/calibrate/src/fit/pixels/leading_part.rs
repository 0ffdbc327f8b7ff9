//! The part that describes a lens far better than fifth-order aberrations do, tried before all others.
//!
//! A reduced model of such a lens means little, and may have ended on the wrong side of focus. So these parts start from all its
//! estimates, or from the sizes of tiles.

use super::context::{FitContext, FittedLens, INITIAL_BLUR_PX2, QUICK, subsample};
use super::parameters::{ParameterLayout, Quantity};
use super::part_trial::{SCREENING_TILES, Split, Tried};
use super::parts::Part;
use super::tilt_search;
use seidel_optics::effects;

/// Starts of a part that are fitted in full.
const MAX_SCREENED: usize = 2;
/// Decrease of the mean log misfit of held-out zones, beyond that by fifth order, by which a leading part or another side of focus
/// is recognised.
pub(super) const PLAIN_GAIN: f64 = 1.0;

/// Returns `fit` with the leading part, if there is one: two planes of symmetry, a tilted sensor, or fifth-order aberrations
/// on another side of focus. `estimates` are those of the reduced model.
pub(super) fn find(
    context: &FitContext,
    split: &Split,
    fit: &FittedLens,
    estimates: &[Vec<f64>],
) -> Option<Tried> {
    let round = split.trial(context, fit, Part::of(&effects::HigherOrder))?;
    let search = Search {
        context,
        split,
        fit,
    };
    let candidates = [
        search.two_planes(estimates),
        search.tilted_sensor(),
        search.other_side(estimates),
    ];
    let best = candidates
        .into_iter()
        .flatten()
        .min_by(|a, b| a.missed.total_cmp(&b.missed))?;
    (best.missed < round.missed - PLAIN_GAIN).then_some(best)
}

struct Search<'a> {
    context: &'a FitContext<'a>,
    split: &'a Split<'a>,
    fit: &'a FittedLens,
}

impl Search<'_> {
    /// Returns the `starts` of one layout that describe few tiles best after a short fit, the best first.
    fn screened(&self, layout: &ParameterLayout, starts: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let few = subsample(&self.split.fitted, SCREENING_TILES);
        let settings = Split::settings(self.fit);
        let mut found: Vec<(f64, Vec<f64>)> = (starts.into_iter())
            .map(|start| {
                let point = self
                    .context
                    .descend(layout, &few, &start, settings, QUICK)
                    .point;
                (point.mean_log_misfit(), start)
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.truncate(MAX_SCREENED);
        found.into_iter().map(|(_, start)| start).collect()
    }

    /// Returns the reduced lens with the parameters `theta`.
    fn reduced(&self, theta: &[f64]) -> FittedLens {
        FittedLens {
            layout: self.context.reduced_layout(),
            theta: theta.to_vec(),
            ..self.fit.clone()
        }
    }

    fn two_planes(&self, estimates: &[Vec<f64>]) -> Option<Tried> {
        self.begun_at_estimates(Part::of(&effects::DoublePlane), estimates)
    }

    fn other_side(&self, estimates: &[Vec<f64>]) -> Option<Tried> {
        self.begun_at_estimates(Part::of(&effects::HigherOrder), estimates)
    }

    /// Returns the reduced lens of the best of `estimates` with `part`.
    fn begun_at_estimates(&self, part: Part, estimates: &[Vec<f64>]) -> Option<Tried> {
        let reduced = self.context.reduced_layout();
        let layout = self.context.layout(part.added_to(&reduced.structure));
        let mut starts = estimates.to_vec();
        starts.push(reduced.transfer(&self.fit.layout, &self.fit.theta));
        let extended: Vec<_> = starts
            .iter()
            .map(|theta| layout.transfer(&reduced, theta))
            .collect();
        let screened = self.screened(&layout, extended);
        let tried = (screened.iter())
            .map(|theta| self.reduced(&reduced.transfer(&layout, theta)))
            .filter_map(|start| self.split.trial(self.context, &start, part));
        tried.min_by(|a, b| a.missed.total_cmp(&b.missed))
    }

    /// Returns the reduced lens before a tilted sensor.
    fn tilted_sensor(&self) -> Option<Tried> {
        let context = self.context;
        let part = Part::of(&effects::SensorTilt);
        if !part.is_determined_by(context.tiles.len()) {
            return None;
        }
        let reduced = context.reduced_layout();
        let layout = context.layout(part.added_to(&reduced.structure));
        let which = reduced.structure.effects.len();
        let measured: Vec<_> = (self.split.fitted.iter())
            .map(|tile| &context.measured[tile.measured])
            .collect();
        let starts = tilt_search::tilted(&context.frame, &measured)
            .into_iter()
            .map(|start| {
                let mut theta = vec![0.0; layout.parameters.len()];
                layout.set_constant_in_all(&mut theta, Quantity::Blur, INITIAL_BLUR_PX2);
                for channel in 0..context.channel_names().len() {
                    layout.set_initial(&mut theta, channel, &start.estimate);
                }
                for (k, tilt) in start.tilt.into_iter().enumerate() {
                    layout.set_constant_in_all(&mut theta, Quantity::Effect(which, k), tilt);
                }
                theta
            });
        let screened = self.screened(&layout, starts.collect());
        let settings = Split::settings(self.fit);
        let tried = (screened.iter()).map(|start| {
            self.split
                .fitted_from(context, part, layout.clone(), start, settings)
        });
        tried.min_by(|a, b| a.missed.total_cmp(&b.missed))
    }
}
