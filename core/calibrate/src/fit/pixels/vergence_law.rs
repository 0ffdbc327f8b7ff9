//! Dependence of the parameters on object distance.
//!
//! The degrees of the polynomials in vergence are selected by leave-one-out cross-validation over the inner
//! distances. Residual corrections are then fitted at each distance. They are kept where they lower the
//! misfit of held-out field zones. The law of conjugate shift bounds the degrees (docs/background/model.md
//! section 5).

use rayon::prelude::*;

use super::context::{FitContext, FittedLens, LENIENT_TOLERANCE, STRICT_TOLERANCE, subsample};
use super::parameters::{ModelStructure, ParameterLayout, PolynomialSpec, Quantity};
use super::tile_equations::{Comparison, FitTile, MisfitSettings};
use crate::fit::holdout;
use crate::least_squares::Stop;
use crate::stage::Stage;
use seidel_optics::error::Result;
use seidel_optics::psf::pupil::Detail;

/// Polynomial degrees in vergence, of the numbers other than defocus and blur, and of effect parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PolynomialDegrees {
    numbers: usize,
    effects: usize,
}

/// Candidates without effects, from stiff to flexible.
pub(super) const REDUCED_LAWS: [PolynomialDegrees; 2] = [
    PolynomialDegrees {
        numbers: 0,
        effects: 0,
    },
    PolynomialDegrees {
        numbers: 1,
        effects: 0,
    },
];

/// Candidates with effects.
pub(super) const EXTENDED_LAWS: [PolynomialDegrees; 3] = [
    PolynomialDegrees {
        numbers: 0,
        effects: 0,
    },
    PolynomialDegrees {
        numbers: 1,
        effects: 0,
    },
    PolynomialDegrees {
        numbers: 1,
        effects: 1,
    },
];

/// Tiles on which candidates are compared.
const TRIAL_TILES: usize = 130;
/// Decrease of the mean log misfit that a more flexible law, or a residual correction, must reach.
const WORTH: f64 = 0.05;
/// Stop criteria of a candidate.
const TRIAL: Stop = Stop::at_decrease(10, 5e-3);
/// Stop criteria of a fit to a single distance.
const SINGLE_DISTANCE: Stop = Stop::at_decrease(12, 2e-3);

impl PolynomialDegrees {
    /// Returns `structure` with these degrees.
    fn of(self, structure: &ModelStructure) -> ModelStructure {
        let mut freed = structure.clone();
        for freedom in &mut freed.polynomials {
            let degree = match freedom.quantity {
                Quantity::Alpha => freedom.degree,
                Quantity::Blur => 0,
                Quantity::Effect(..) if freedom.shared => 0,
                Quantity::Effect(..) => self.effects,
                _ => self.numbers,
            };
            freedom.degree = degree.max(freedom.least_degree);
        }
        freed
    }
}

/// Effort of the fit with the chosen law.
#[derive(Debug, Clone, Copy)]
pub(super) enum Refit {
    /// For a model that gains more parts afterwards.
    Short,
    /// For a model that is complete.
    Full,
}

/// Refits with the law of the best cross-validation score; with the stiffest where there are fewer than three
/// distances.
pub(super) fn choose(
    context: &FitContext,
    fit: FittedLens,
    laws: &[PolynomialDegrees],
    refit: Refit,
    stage: Stage,
) -> Result<FittedLens> {
    let inner = match &context.vergences[..] {
        [_, inner @ .., _] => inner,
        _ => &[],
    };
    let mut best: Option<(f64, ModelStructure)> = None;
    for (k, law) in laws.iter().enumerate() {
        let law_stage = stage.part_of(k, laws.len() + 1);
        law_stage.reach(0.0)?;
        // At least one more distance than coefficients is needed.
        if law.numbers.max(law.effects) + 3 > context.vergences.len() && law.numbers > 0 {
            continue;
        }
        let structure = law.of(&fit.layout.structure);
        if inner.is_empty() {
            best = Some((0.0, structure));
            break;
        }
        let layout = context.layout(structure.clone());
        let missed = cross_validation_score(context, &fit, &layout, inner, law_stage)?;
        if best
            .as_ref()
            .is_none_or(|(least, _)| missed < least - WORTH)
        {
            best = Some((missed, structure));
        }
    }
    stage.part_of(laws.len(), laws.len() + 1).reach(0.0)?;
    let Some((_, structure)) = best else {
        return Ok(fit);
    };
    if structure.polynomials == fit.layout.structure.polynomials {
        return Ok(fit);
    }
    let layout = context.layout(structure);
    let theta = layout.transfer(&fit.layout, &fit.theta);
    Ok(match refit {
        Refit::Short => context.refine_between(&layout, theta, fit.metric),
        Refit::Full => context.refine(&layout, theta, fit.metric),
    })
}

/// Returns the mean log misfit at the `inner` distances, each predicted by a fit to the others.
fn cross_validation_score(
    context: &FitContext,
    fit: &FittedLens,
    layout: &ParameterLayout,
    inner: &[f64],
    stage: Stage,
) -> Result<f64> {
    let few = subsample(&context.all(), TRIAL_TILES);
    let theta = layout.transfer(&fit.layout, &fit.theta);
    let misfit_settings = MisfitSettings {
        metric: fit.metric,
        detail: Detail::COARSE,
        tolerance: LENIENT_TOLERANCE,
    };
    let (mut sum, mut count) = (0.0, 0);
    for (k, &left_out) in inner.iter().enumerate() {
        stage.part_of(k, inner.len()).reach(0.0)?;
        let (out, kept): (Vec<&FitTile>, Vec<&FitTile>) =
            few.iter().copied().partition(|t| t.vergence == left_out);
        let found = context.descend(layout, &kept, &theta, misfit_settings, TRIAL);
        for misfit in misfits(context, layout, &found.point.theta, &out, misfit_settings) {
            sum += misfit.max(1e-12).ln();
            count += 1;
        }
    }
    Ok(sum / f64::from(count.max(1)))
}

/// Returns the misfits of tiles that did not take part, with flux and centroid as measured, or as estimated where the
/// pixels do not tell the centroid.
pub(super) fn misfits(
    context: &FitContext,
    layout: &ParameterLayout,
    theta: &[f64],
    tiles: &[&FitTile],
    misfit_settings: MisfitSettings,
) -> Vec<f64> {
    tiles
        .par_iter()
        .zip(context.tile_parameters(tiles))
        .map_init(
            || Comparison::new(misfit_settings),
            |comparison, (tile, own)| {
                let pupil = layout.pupil(theta, tile.channel, tile.at, tile.vergence);
                let own = tile.registered(&pupil, own, comparison);
                tile.misfit(&pupil, &own, comparison)
            },
        )
        .collect()
}

/// Residual correction of one quantity in one channel at one distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Remainder {
    pub(super) quantity: Quantity,
    pub(super) channel: usize,
    pub(super) vergence: f64,
    pub(super) value: f64,
}

/// Fits a residual correction per channel and distance. A correction is zero unless it lowers the misfit of
/// held-out field zones.
pub(super) fn remainders(
    context: &FitContext,
    fit: &FittedLens,
    stage: Stage,
) -> Result<Vec<Remainder>> {
    if context.vergences.len() < 2 {
        return Ok(Vec::new());
    }
    let all = context.all();
    let places: Vec<_> = all.iter().map(|t| t.at).collect();
    let back = holdout::held_out_mask(&context.frame, &places);
    let mut found = Vec::new();
    let groups = groups(context);
    for (k, (channel, vergence)) in groups.iter().copied().enumerate() {
        stage.part_of(k, groups.len()).reach(0.0)?;
        let of = |wanted: &dyn Fn(bool) -> bool| -> Vec<&FitTile> {
            let pairs = all.iter().zip(&back);
            pairs
                .filter(|(t, _)| t.channel == channel && t.vergence == vergence)
                .filter(|(_, back)| wanted(**back))
                .map(|(t, _)| *t)
                .collect()
        };
        let (layout, theta) = single_distance_layout(context, fit, vergence);
        let misfit_settings = fit.misfit_settings(STRICT_TOLERANCE);
        let apart = |tiles: &[&FitTile]| {
            context.descend(&layout, tiles, &theta, misfit_settings, SINGLE_DISTANCE)
        };
        let check = of(&|back| back);
        let mean_log_misfit = |theta: &[f64]| {
            let all = misfits(context, &layout, theta, &check, misfit_settings);
            all.iter().map(|m| m.max(1e-12).ln()).sum::<f64>() / all.len().max(1) as f64
        };
        let kept = apart(&of(&|back| !back));
        let helps = mean_log_misfit(&kept.point.theta) < mean_log_misfit(&theta) - WORTH;
        let settled = helps.then(|| apart(&of(&|_| true)));
        for freedom in layout.structure.polynomials.iter().filter(|f| !f.fixed) {
            let value = |theta: &[f64]| layout.value(theta, freedom.quantity, channel, vergence);
            let new = settled.as_ref().and_then(|s| value(&s.point.theta));
            if let Some(law) = value(&theta) {
                found.push(Remainder {
                    quantity: freedom.quantity,
                    channel,
                    vergence,
                    value: new.map_or(0.0, |new| new - law),
                });
            }
        }
    }
    // A zero correction keeps others local to their distance; corrections that are all zero are not stored.
    if found.iter().all(|r| r.value == 0.0) {
        found.clear();
    }
    Ok(found)
}

/// Returns the channels and vergences with tiles.
fn groups(context: &FitContext) -> Vec<(usize, f64)> {
    let channels = context.channel_names().len();
    (0..channels)
        .flat_map(|channel| context.vergences.iter().map(move |v| (channel, *v)))
        .filter(|(channel, v)| {
            let mut tiles = context.tiles.iter();
            tiles.any(|t| t.channel == *channel && t.vergence == *v)
        })
        .collect()
}

/// Returns a layout for the distance of `vergence`, with the law's values there. Parameters shared between
/// channels are fixed.
fn single_distance_layout(
    context: &FitContext,
    fit: &FittedLens,
    vergence: f64,
) -> (ParameterLayout, Vec<f64>) {
    let mut structure = fit.layout.structure.clone();
    structure.axis = false;
    structure.polynomials = structure
        .polynomials
        .iter()
        .map(|freedom| PolynomialSpec {
            degree: 0,
            least_degree: 0,
            fixed: freedom.shared,
            ..*freedom
        })
        .collect();
    let layout = context.layout(structure);
    let mut theta = vec![0.0; layout.parameters.len()];
    for (channel, _) in context.channel_names().iter().enumerate() {
        for freedom in &fit.layout.structure.polynomials {
            let value = fit
                .layout
                .value(&fit.theta, freedom.quantity, channel, vergence);
            if let Some(value) = value {
                layout.set_constant(&mut theta, freedom.quantity, channel, value);
            }
        }
    }
    (layout, theta)
}
