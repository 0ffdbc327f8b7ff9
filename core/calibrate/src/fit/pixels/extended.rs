//! The extended model: parts added to the reduced model where they improve held-out zones of the field.
//!
//! Fifth-order aberrations come first. The other parts ([`further_parts`]) are then tried in turn: each is fitted to few tiles,
//! without those of the held-out zones. Of the parts that are worth their parameters, and lower the misfit of the held-out zones
//! nearly as much as the best does, the one with the fewest parameters is added, as long as there is one.

use super::context::{BETWEEN, FitContext, FittedLens};
use super::focus_side::{self, FocusSide};
use super::leading_part::{self, PLAIN_GAIN};
use super::named;
use super::parameters::{ParameterLayout, Quantity};
use super::part_log::{PartLog, PartTrial};
use super::part_trial::{Split, Tried, all_misfit};
use super::parts::{self, Part};
use super::vergence_law::{self, Refit};

use crate::stage::Stage;
use seidel_optics::effects::{self, Effect};
use seidel_optics::error::Result;

/// Decrease of the mean log misfit of held-out zones that the symmetric blur must reach.
const BLUR_WORTH: f64 = 0.01;
/// Increase of the mean log misfit of held-out zones at which a part is not tried again.
const SPOILT: f64 = 0.1;
/// Decrease of the mean log misfit of all tiles that a part must reach.
const MIN_GAIN: f64 = 0.04;
/// Shares of the progress of an extended fit at which its steps end, and the share of the rest that each search for a part
/// takes.
const PLANES_SHARE: f64 = 0.1;
const SIDE_SHARE: f64 = 0.6;
const LAW_SHARE: f64 = 0.2;
const PARTS_SHARE: f64 = 0.8;
const ROUND_SHARE: f64 = 0.6;
/// Decrease of it after which all parts are tried again.
const LARGE_GAIN: f64 = 0.5;
/// Share of the largest gain from which on the part with the fewest parameters is taken.
const NEARLY_BEST: f64 = 0.65;
/// Mean log squared error of a reduced lens, beyond noise, above which leading parts are tried first: 1 % of the energy of a PSF.
const POOR_ERROR: f64 = -4.6;

/// An extended lens.
pub(super) struct Extended {
    pub(super) fit: FittedLens,
    /// Parts that the tiles are too few for, in words.
    pub(super) held_back: Vec<String>,
    /// Parts that were tried after fifth-order aberrations.
    pub(super) tried: Vec<PartTrial>,
}

/// Adds fifth-order aberrations, then every part that improves held-out zones. `estimates` are those of the reduced model,
/// which was fitted first.
pub(super) fn extend(
    context: &FitContext,
    fit: FittedLens,
    estimates: &[Vec<f64>],
    stage: Stage,
) -> Result<Extended> {
    stage.reach(0.0)?;
    let split = Split::new(context);
    let mut log = PartLog::new(context.settings.clock);
    let mut fit = fit;
    if split.model_error(context, &fit) > POOR_ERROR
        && let Some(tried) = leading_part::find(context, &split, &fit, estimates)
    {
        fit = context.refine_between(&tried.layout, tried.theta, fit.metric);
    }
    stage.reach(PLANES_SHARE)?;
    let parts_stage = stage.part(PLANES_SHARE, PARTS_SHARE);
    fit = match FocusSide::of_camera_if_other(context, &fit) {
        None => split.with_parts(context, fit, &mut log, parts_stage)?,
        Some(side) => split.better_side(context, fit, &side, &mut log, parts_stage)?,
    };
    stage.reach(PARTS_SHARE)?;
    fit = split.without_needless_blur(context, fit);
    fit = context.refine_strictly(fit);
    let too_many = further_parts().filter(|part| !part.is_determined_by(context.tiles.len()));
    let held_back = too_many.map(|part| {
        format!(
            "{}: not tried, because the {} parameters need {} tiles, over the whole field, and there are {}",
            named(part.effect.id()),
            part.free(),
            part.least_tiles(),
            context.tiles.len()
        )
    });
    Ok(Extended {
        held_back: held_back.collect(),
        tried: log.into_parts(),
        fit,
    })
}

/// Returns the parts that are tried after fifth-order aberrations.
fn further_parts() -> impl Iterator<Item = Part> {
    parts::all().filter(|part| part.effect.id() != effects::HigherOrder.id())
}

fn with_higher_order(context: &FitContext, fit: FittedLens) -> FittedLens {
    let mut structure = fit.layout.structure.clone();
    // Third-order terms no longer absorb fifth-order ones, so their degrees in vergence are selected again.
    for freedom in &mut structure.polynomials {
        freedom.degree = freedom.least_degree;
    }
    let part = Part::of(&effects::HigherOrder);
    if !part.is_in(&structure) {
        structure = part.added_to(&structure);
    }
    let layout = context.layout(structure);
    let theta = layout.transfer(&fit.layout, &fit.theta);
    context.refine_between(&layout, theta, fit.metric)
}

impl Split<'_> {
    /// Adds fifth-order aberrations, then every other part that is worth its parameters.
    fn with_parts(
        &self,
        context: &FitContext,
        fit: FittedLens,
        log: &mut PartLog,
        stage: Stage,
    ) -> Result<FittedLens> {
        let fit = vergence_law::choose(
            context,
            with_higher_order(context, fit),
            &vergence_law::EXTENDED_LAWS,
            Refit::Short,
            stage.part(0.0, LAW_SHARE),
        )?;
        self.add_parts(context, fit, log, stage.part(LAW_SHARE, 1.0))
    }

    /// Returns `fit` with all its parts, or the lens on the side of focus that the camera's data tell, whichever describes held-out
    /// zones better.
    fn better_side(
        &self,
        context: &FitContext,
        fit: FittedLens,
        side: &FocusSide,
        log: &mut PartLog,
        stage: Stage,
    ) -> Result<FittedLens> {
        let ours = with_higher_order(context, fit);
        let held = with_higher_order(context, side.held());
        let [before, held_before] = [&ours, &held].map(|fit| self.misfit(context, fit));
        if held_before > before + PLAIN_GAIN {
            return self.with_parts(context, ours, log, stage);
        }
        let held = self.with_parts(context, held, log, stage.part(0.0, SIDE_SHARE))?;
        let free = focus_side::freed(context, held);
        let theirs = self.add_parts(context, free, log, stage.part(SIDE_SHARE, SIDE_SHARE))?;
        let missed = self.misfit(context, &theirs);
        if missed < before - PLAIN_GAIN {
            return Ok(theirs);
        }
        let ours = self.with_parts(context, ours, log, stage.part(SIDE_SHARE, 1.0))?;
        let is_theirs = focus_side::is_as_good(missed, self.misfit(context, &ours));
        Ok(if is_theirs { theirs } else { ours })
    }

    /// Adds the best part, until none is worth its parameters.
    fn add_parts(
        &self,
        context: &FitContext,
        mut fit: FittedLens,
        log: &mut PartLog,
        stage: Stage,
    ) -> Result<FittedLens> {
        // The number of parts to come is unknown: each takes a share of what is left.
        let mut done = 0.0;
        let mut next = || {
            let from = done;
            done += ROUND_SHARE * (1.0 - done);
            stage.part(from, done)
        };
        let mut open: Vec<Part> = further_parts().collect();
        let mut begun: Vec<&str> = Vec::new();
        loop {
            let worthy = self.worthy(context, &fit, &mut open, log, next())?;
            let Some(Added { last, lens, gain }) = self.added(context, &fit, worthy, &mut open)
            else {
                let Some(better) = self.begun_again(context, &fit, &mut begun, log) else {
                    break;
                };
                fit = better;
                open = further_parts().collect();
                continue;
            };
            if gain > LARGE_GAIN {
                // The part may have hidden what others describe.
                open = further_parts().collect();
            }
            fit = lens;
            if !last.fit.shared {
                let laws = &vergence_law::EXTENDED_LAWS;
                fit = vergence_law::choose(context, fit, laws, Refit::Short, next())?;
            }
        }
        Ok(fit)
    }

    /// Returns `fit` with one of its parts fitted again from all its starts, if that describes the tiles better. A part with a parameter at
    /// the end of its range may have ended in a local minimum before the others were there. Each is begun again once: `begun` holds
    /// those that were.
    pub(super) fn begun_again(
        &self,
        context: &FitContext,
        fit: &FittedLens,
        begun: &mut Vec<&'static str>,
        log: &mut PartLog,
    ) -> Option<FittedLens> {
        let before = all_misfit(context, fit);
        for which in 0..fit.layout.structure.effects.len() {
            let part = Part::of(fit.layout.structure.effects[which]);
            let id = part.effect.id();
            if !fit.is_at_end_of_range(which) || begun.contains(&id) {
                continue;
            }
            begun.push(id);
            let rest = fit.without(context, which);
            let held_out = self.misfit(context, fit);
            let Some(tried) = log.timed(part, held_out, || self.trial(context, &rest, part)) else {
                continue;
            };
            let again = context.refine_between(&tried.layout, tried.theta, fit.metric);
            if all_misfit(context, &again) < before - MIN_GAIN {
                return Some(again);
            }
        }
        None
    }

    /// Returns `fit` with the symmetric blur held at zero, if it then describes held-out zones as well as before.
    ///
    /// A narrow blur hardly shows in wide discs. If it is not real, it spoils distances in focus that were not measured.
    fn without_needless_blur(&self, context: &FitContext, fit: FittedLens) -> FittedLens {
        let settings = Self::settings(&fit);
        let missed = |layout: &ParameterLayout, theta: &[f64]| {
            let found = context.descend(layout, &self.fitted, theta, settings, BETWEEN);
            self.missed(context, layout, &found.point.theta, settings)
        };
        let mut structure = fit.layout.structure.clone();
        for freedom in &mut structure.polynomials {
            freedom.fixed |= freedom.quantity == Quantity::Blur;
        }
        let layout = context.layout(structure);
        let mut theta = fit.theta.clone();
        layout.set_constant_in_all(&mut theta, Quantity::Blur, 0.0);
        if missed(&layout, &theta) > missed(&fit.layout, &fit.theta) + BLUR_WORTH {
            return fit;
        }
        context.refine_between(&layout, theta, fit.metric)
    }

    /// Returns `fit` with each part among `open` that improves held-out zones by more than it must. Parts that are in the lens, and those
    /// that spoil held-out zones, leave `open`.
    fn worthy(
        &self,
        context: &FitContext,
        fit: &FittedLens,
        open: &mut Vec<Part>,
        log: &mut PartLog,
        stage: Stage,
    ) -> Result<Vec<Worthy>> {
        // Fitted like the parts, without the held-out zones.
        let settings = Self::settings(fit);
        let plain = context.descend(&fit.layout, &self.fitted, &fit.theta, settings, BETWEEN);
        let before = self.missed(context, &fit.layout, &plain.point.theta, settings);
        let mut worthy: Vec<Worthy> = Vec::new();
        let tried_parts = std::mem::take(open);
        for (k, part) in tried_parts.iter().copied().enumerate() {
            stage.part_of(k, tried_parts.len()).reach(0.0)?;
            if part.is_in(&fit.layout.structure) || part.is_contained_in(&fit.layout.structure) {
                continue;
            }
            let trial = || self.trial(context, fit, part);
            let Some(tried) = log.timed(part, before, trial) else {
                open.push(part);
                continue;
            };
            let gain = before - tried.missed;
            if gain >= -SPOILT {
                open.push(part);
            }
            if gain > part.fit.worth {
                worthy.push(Worthy { tried, gain });
            }
        }
        Ok(worthy)
    }

    /// Adds to `fit` the part among `worthy` that has the fewest parameters of those that gain most, or nearly so, if it gains over all
    /// tiles too; otherwise the next. Parts whose gain was one of the few tiles alone leave `open`.
    fn added(
        &self,
        context: &FitContext,
        fit: &FittedLens,
        mut worthy: Vec<Worthy>,
        open: &mut Vec<Part>,
    ) -> Option<Added> {
        let channels = context.channel_names().len();
        while !worthy.is_empty() {
            // A part with many parameters may imitate one with few.
            let most = worthy.iter().map(|w| w.gain).fold(0.0, f64::max);
            let best = (0..worthy.len())
                .filter(|k| worthy[*k].gain >= NEARLY_BEST * most)
                .min_by_key(|k| worthy[*k].tried.last.parameters(channels))?;
            let Tried {
                last,
                layout,
                theta,
                ..
            } = worthy.remove(best).tried;
            let lens = context.refine_between(&layout, theta, fit.metric);
            let gain = all_misfit(context, fit) - all_misfit(context, &lens);
            if gain >= MIN_GAIN.min(last.fit.worth) {
                return Some(Added { last, lens, gain });
            }
            open.retain(|part| part.effect.id() != last.effect.id());
        }
        None
    }
}

/// A part that improves held-out zones, with the decrease of their mean log misfit.
struct Worthy {
    tried: Tried,
    gain: f64,
}

/// A lens with one part more, and the decrease of the mean log misfit of all tiles.
struct Added {
    last: Part,
    lens: FittedLens,
    gain: f64,
}
