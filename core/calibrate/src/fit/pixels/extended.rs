//! The extended model: fifth-order aberrations and vignetting added to the reduced model.

use super::context::{FitContext, FittedLens, LENIENT_TOLERANCE, QUICK, subsample};
use super::parameters::{ModelStructure, PolynomialSpec, Quantity};
use super::tile_equations::MisfitSettings;
use super::vergence_law;
use seidel_optics::effects::{self, Effect};
use seidel_optics::error::Result;
use seidel_optics::psf::pupil::Detail;

/// Tiles on which initial stops are compared.
const TRIAL_TILES: usize = 80;
/// Decrease of the mean log misfit that vignetting must reach to be kept.
const WORTH: f64 = 0.02;

/// Initial stops: radius and shift of a front and a rear one. They begin to clip on the axis, half way to the
/// corner, or near it.
const STOP_TRIALS: [[f64; 4]; 4] = [
    [1.0, 0.15, 1.0, -0.15],
    [1.0, 0.5, 1.0, -0.5],
    [1.4, 0.6, 1.4, -0.6],
    [1.8, 0.9, 1.8, -0.9],
];

/// Adds fifth-order aberrations, then vignetting where it lowers the misfit.
pub(super) fn extend(context: &FitContext, fit: FittedLens) -> Result<FittedLens> {
    let fit = vergence_law::choose(
        context,
        with_higher_order(context, fit),
        &vergence_law::EXTENDED_LAWS,
    )?;
    Ok(with_vignetting(context, fit))
}

fn with_higher_order(context: &FitContext, fit: FittedLens) -> FittedLens {
    let mut structure = fit.layout.structure.clone();
    let which = add(&mut structure, &effects::HigherOrder, false);
    // Third-order terms no longer absorb fifth-order ones, so their degrees in vergence are selected again.
    for freedom in &mut structure.polynomials {
        if freedom.quantity != Quantity::Alpha {
            freedom.degree = 0;
        }
    }
    debug_assert_eq!(structure.effects[which].id(), "higher_order");
    let layout = context.layout(structure);
    let theta = layout.transfer(&fit.layout, &fit.theta);
    context.refine(&layout, theta, fit.metric)
}

fn with_vignetting(context: &FitContext, fit: FittedLens) -> FittedLens {
    let mut structure = fit.layout.structure.clone();
    let which = add(&mut structure, &effects::Vignetting, true);
    let layout = context.layout(structure);
    let few = subsample(&context.all(), TRIAL_TILES);
    let misfit_settings = MisfitSettings {
        metric: fit.metric,
        detail: Detail::COARSE,
        tolerance: LENIENT_TOLERANCE,
    };
    let start = layout.transfer(&fit.layout, &fit.theta);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for circles in STOP_TRIALS {
        let mut theta = start.clone();
        for (k, value) in circles.into_iter().enumerate() {
            layout.set_constant_in_all(&mut theta, Quantity::Effect(which, k), value);
        }
        let found = context.descend(&layout, &few, &theta, misfit_settings, QUICK);
        let size = found.point.mean_log_misfit();
        if best.as_ref().is_none_or(|(least, _)| size < *least) {
            best = Some((size, found.point.theta));
        }
    }
    let Some((_, theta)) = best else {
        return fit;
    };
    let clipped = context.refine(&layout, theta, fit.metric);
    let mean_log_misfit = |f: &FittedLens| {
        let all = vergence_law::misfits(
            context,
            &f.layout,
            &f.theta,
            &context.all(),
            misfit_settings,
        );
        all.iter().map(|m| m.max(1e-12).ln()).sum::<f64>() / all.len() as f64
    };
    if mean_log_misfit(&clipped) < mean_log_misfit(&fit) - WORTH {
        clipped
    } else {
        fit
    }
}

/// Adds `effect` with all its parameters free and constant in vergence; returns its index.
fn add(structure: &mut ModelStructure, effect: &'static dyn Effect, shared: bool) -> usize {
    let which = structure.effects.len();
    structure.effects.push(effect);
    for k in 0..effect.parameters().len() {
        structure.polynomials.push(PolynomialSpec {
            quantity: Quantity::Effect(which, k),
            degree: 0,
            shared,
            fixed: false,
        });
    }
    which
}
