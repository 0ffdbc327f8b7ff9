//! Effects added to a lens of five numbers.

use super::job::{Fitted, Job, LENIENT, QUICK, spread};
use super::law;
use super::layout::{Freedom, Quantity, Structure};
use super::tile::Comparison;
use seidel_optics::effects::{self, Effect};
use seidel_optics::error::Result;
use seidel_optics::psf::pupil::Detail;

/// Tiles on which circles are tried.
const TRIAL_TILES: usize = 80;
/// A circle must lower the mean logarithm of misfits by this much.
const WORTH: f64 = 0.02;

/// Circles that are tried: radius and shift of a front and a rear one. They begin to clip on the
/// axis, or half way to the corner, or near it.
const CIRCLES: [[f64; 4]; 4] = [
    [1.0, 0.15, 1.0, -0.15],
    [1.0, 0.5, 1.0, -0.5],
    [1.4, 0.6, 1.4, -0.6],
    [1.8, 0.9, 1.8, -0.9],
];

/// Adds fifth-order aberrations, then vignetting where it lowers misfits.
pub(super) fn extend(job: &Job, fit: Fitted) -> Result<Fitted> {
    let fit = law::choose(job, with_higher_order(job, fit), &law::EXTENDED)?;
    Ok(with_vignetting(job, fit))
}

fn with_higher_order(job: &Job, fit: Fitted) -> Fitted {
    let mut structure = fit.layout.structure.clone();
    let which = add(&mut structure, &effects::HigherOrder, false);
    // The law of the five numbers is chosen anew: what they stood in for is now there.
    for freedom in &mut structure.freedoms {
        if freedom.quantity != Quantity::Alpha {
            freedom.degree = 0;
        }
    }
    debug_assert_eq!(structure.effects[which].id(), "higher_order");
    let layout = job.layout(structure);
    let theta = layout.carry(&fit.layout, &fit.theta);
    job.refine(&layout, theta, fit.metric)
}

fn with_vignetting(job: &Job, fit: Fitted) -> Fitted {
    let mut structure = fit.layout.structure.clone();
    let which = add(&mut structure, &effects::Vignetting, true);
    let layout = job.layout(structure);
    let few = spread(&job.all(), TRIAL_TILES);
    let comparison = Comparison {
        metric: fit.metric,
        detail: Detail::COARSE,
        tolerance: LENIENT,
    };
    let start = layout.carry(&fit.layout, &fit.theta);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for circles in CIRCLES {
        let mut theta = start.clone();
        for (k, value) in circles.into_iter().enumerate() {
            layout.set(&mut theta, Quantity::Effect(which, k), value);
        }
        let settled = job.descend(&layout, &few, &theta, comparison, QUICK);
        let size = settled.typical();
        if best.as_ref().is_none_or(|(least, _)| size < *least) {
            best = Some((size, settled.state.theta));
        }
    }
    let Some((_, theta)) = best else {
        return fit;
    };
    let clipped = job.refine(&layout, theta, fit.metric);
    let typical = |f: &Fitted| {
        let all = law::misfits(job, &f.layout, &f.theta, &job.all(), comparison);
        all.iter().map(|m| m.max(1e-12).ln()).sum::<f64>() / all.len() as f64
    };
    if typical(&clipped) < typical(&fit) - WORTH {
        clipped
    } else {
        fit
    }
}

/// Adds `effect` with all its parameters free and constant; returns its place.
fn add(structure: &mut Structure, effect: &'static dyn Effect, shared: bool) -> usize {
    let which = structure.effects.len();
    structure.effects.push(effect);
    for k in 0..effect.parameters().len() {
        structure.freedoms.push(Freedom {
            quantity: Quantity::Effect(which, k),
            degree: 0,
            shared,
            held: false,
        });
    }
    which
}
