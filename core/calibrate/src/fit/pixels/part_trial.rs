//! Trials of parts: a lens with one more part, fitted to few tiles and compared on held-out zones of the field.

use super::context::{BETWEEN, FitContext, FittedLens, LENIENT_TOLERANCE, subsample};
use super::parameters::{ParameterLayout, Quantity};
use super::parts::Part;
use super::tile_equations::{FitTile, MisfitSettings};
use super::vergence_law;
use crate::fit::holdout;
use crate::least_squares::Stop;
use seidel_optics::psf::pupil::Detail;

/// Tiles per channel on which parts are compared.
const TRIAL_TILES: usize = 60;
/// Starts of a part that are compared by short fits; where there are more, by their misfit alone.
const MAX_STARTS: usize = 6;
/// Tiles and stop criteria of these comparisons.
pub(super) const SCREENING_TILES: usize = 24;
const MISFIT_TILES: usize = 8;
const SCREENING: Stop = Stop::at_decrease(3, 1e-2);

/// Returns the mean log misfit of all tiles fitted.
pub(super) fn all_misfit(context: &FitContext, fit: &FittedLens) -> f64 {
    let settings = Split::settings(fit);
    let all = context.all();
    mean_log(&vergence_law::misfits(
        context,
        &fit.layout,
        &fit.theta,
        &all,
        settings,
    ))
}

/// Returns the mean logarithm of `misfits`.
fn mean_log(misfits: &[f64]) -> f64 {
    misfits.iter().map(|m| m.max(1e-12).ln()).sum::<f64>() / misfits.len().max(1) as f64
}

/// A lens with one more part, fitted to few tiles.
pub(super) struct Tried {
    pub(super) last: Part,
    pub(super) layout: ParameterLayout,
    pub(super) theta: Vec<f64>,
    /// Mean log misfit of held-out zones.
    pub(super) missed: f64,
}

/// The tiles on which parts are fitted and those on which they are compared.
pub(super) struct Split<'a> {
    pub(super) fitted: Vec<&'a FitTile>,
    check: Vec<&'a FitTile>,
}

impl<'a> Split<'a> {
    pub(super) fn new(context: &'a FitContext) -> Self {
        let all = context.all();
        let places: Vec<_> = all.iter().map(|t| t.at).collect();
        let held_out = holdout::held_out_mask(&context.frame, &places);
        let of = |wanted: bool| -> Vec<&FitTile> {
            let pairs = all.iter().zip(&held_out);
            pairs
                .filter(|(_, out)| **out == wanted)
                .map(|(t, _)| *t)
                .collect()
        };
        let count = TRIAL_TILES * context.channel_names().len();
        let (fitted, check) = (of(false), of(true));
        Self {
            // Sets too small for zones are compared on the tiles fitted.
            check: subsample(if check.is_empty() { &fitted } else { &check }, count),
            fitted: subsample(&fitted, count),
        }
    }

    pub(super) fn settings(fit: &FittedLens) -> MisfitSettings {
        MisfitSettings {
            metric: fit.metric,
            detail: Detail::COARSE,
            tolerance: LENIENT_TOLERANCE,
        }
    }

    /// Returns the mean log misfit of held-out zones for `fit`.
    pub(super) fn misfit(&self, context: &FitContext, fit: &FittedLens) -> f64 {
        self.missed(context, &fit.layout, &fit.theta, Self::settings(fit))
    }

    /// Returns the mean log squared error of held-out zones for `fit`, beyond noise, in units of the energy of a PSF.
    pub(super) fn model_error(&self, context: &FitContext, fit: &FittedLens) -> f64 {
        let settings = Self::settings(fit);
        let misfits =
            vergence_law::misfits(context, &fit.layout, &fit.theta, &self.check, settings);
        let tiles = self.check.iter().zip(misfits);
        let errors: Vec<f64> = tiles.map(|(t, m)| t.energy_error(m, settings)).collect();
        mean_log(&errors)
    }

    pub(super) fn missed(
        &self,
        context: &FitContext,
        layout: &ParameterLayout,
        theta: &[f64],
        settings: MisfitSettings,
    ) -> f64 {
        let misfits = vergence_law::misfits(context, layout, theta, &self.check, settings);
        mean_log(&misfits)
    }

    /// Fits `fit` with `part` from the best of its starts; `None` where none lowers the misfit, and where the tiles are too
    /// few for its parameters.
    pub(super) fn trial(
        &self,
        context: &FitContext,
        fit: &FittedLens,
        part: Part,
    ) -> Option<Tried> {
        if !part.is_determined_by(context.tiles.len()) {
            return None;
        }
        let layout = context.layout(part.added_to(&fit.layout.structure));
        let start = layout.transfer(&fit.layout, &fit.theta);
        let which = fit.layout.structure.effects.len();
        let settings = Self::settings(fit);
        let descend = |tiles: &[&FitTile], theta: &[f64], stop| {
            let found = context.descend(&layout, tiles, theta, settings, stop);
            (found.point.mean_log_misfit(), found.point.theta)
        };
        let begin = |values: &Vec<f64>| {
            let mut theta = start.clone();
            for (k, value) in values.iter().enumerate() {
                layout.set_constant_in_all(&mut theta, Quantity::Effect(which, k), *value);
            }
            theta
        };
        let starts: Vec<Vec<f64>> = (part.fit.starts)().iter().map(begin).collect();
        let start = if starts.len() > MAX_STARTS {
            // Where none lowers the misfit before it is fitted, the part is not there. Narrow PSFs do not show stops.
            let wide = self.fitted.iter().filter(|tile| !tile.centroid_unknown);
            let few = subsample(&wide.copied().collect::<Vec<_>>(), MISFIT_TILES);
            let misfit = |layout: &ParameterLayout, theta: &[f64]| {
                mean_log(&vergence_law::misfits(
                    context, layout, theta, &few, settings,
                ))
            };
            let before = misfit(&fit.layout, &fit.theta);
            let screened = starts.iter().map(|theta| (misfit(&layout, theta), theta));
            let (least, best) = screened.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if least >= before {
                return None;
            }
            best.clone()
        } else if starts.len() > 1 {
            let few = subsample(&self.fitted, SCREENING_TILES);
            let screened = starts.iter().map(|theta| descend(&few, theta, SCREENING));
            screened.min_by(|a, b| a.0.total_cmp(&b.0))?.1
        } else {
            starts.into_iter().next()?
        };
        Some(self.fitted_from(context, part, layout, &start, settings))
    }

    /// Fits the lens of `layout`, of which `part` is the last, from `start`.
    pub(super) fn fitted_from(
        &self,
        context: &FitContext,
        part: Part,
        layout: ParameterLayout,
        start: &[f64],
        settings: MisfitSettings,
    ) -> Tried {
        let found = context.descend(&layout, &self.fitted, start, settings, BETWEEN);
        let theta = found.point.theta;
        Tried {
            last: part,
            missed: self.missed(context, &layout, &theta, settings),
            layout,
            theta,
        }
    }
}
