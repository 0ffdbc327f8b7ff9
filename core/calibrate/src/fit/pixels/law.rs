//! How freely the numbers of a lens change with object distance.
//!
//! A law that is too free follows the measured distances and errs between them. So its degrees are
//! chosen by distances left out: each inner one in turn is foretold from the others. What the chosen
//! law leaves at the measured distances is then fitted distance by distance, and kept where it makes
//! zones of the field that took no part fit better. The law of conjugate shift bounds the degrees
//! (docs/background/model.md section 5).

use rayon::prelude::*;

use super::descent::Patience;
use super::job::{Fitted, Job, LENIENT, STRICT, spread};
use super::layout::{Freedom, Layout, Quantity, Structure};
use super::tile::{Buffers, Comparison, FitTile, Own};
use crate::fit::holdout;
use seidel_optics::error::Result;
use seidel_optics::psf::pupil::Detail;

/// Degrees of the five numbers besides defocus, the blur, and the effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Degrees {
    numbers: usize,
    effects: usize,
}

/// Laws that are tried without effects, from stiff to free.
pub(super) const REDUCED: [Degrees; 2] = [
    Degrees {
        numbers: 0,
        effects: 0,
    },
    Degrees {
        numbers: 1,
        effects: 0,
    },
];

/// Laws that are tried with effects.
pub(super) const EXTENDED: [Degrees; 3] = [
    Degrees {
        numbers: 0,
        effects: 0,
    },
    Degrees {
        numbers: 1,
        effects: 0,
    },
    Degrees {
        numbers: 1,
        effects: 1,
    },
];

/// Tiles on which laws are tried.
const TRIAL_TILES: usize = 130;
/// A freer law must foretell distances left out this much better, in the mean logarithm of misfits.
const WORTH: f64 = 0.05;
const TRIAL: Patience = Patience {
    steps: 10,
    fall: 5e-3,
};

impl Degrees {
    /// `structure` with these degrees.
    fn of(self, structure: &Structure) -> Structure {
        let mut freed = structure.clone();
        for freedom in &mut freed.freedoms {
            freedom.degree = match freedom.quantity {
                Quantity::Alpha => freedom.degree,
                Quantity::Blur => 0,
                Quantity::Effect(..) if freedom.shared => 0,
                Quantity::Effect(..) => self.effects,
                _ => self.numbers,
            };
        }
        freed
    }
}

/// Refits with the one of `laws` that foretells distances left out best; the stiffest where there are
/// too few distances to leave one out.
pub(super) fn choose(job: &Job, fit: Fitted, laws: &[Degrees]) -> Result<Fitted> {
    let inner = match &job.vergences[..] {
        [_, inner @ .., _] => inner,
        _ => &[],
    };
    let mut best: Option<(f64, Structure)> = None;
    for law in laws {
        // One more distance than the law has coefficients must be left to check it.
        if law.numbers.max(law.effects) + 3 > job.vergences.len() && law.numbers > 0 {
            continue;
        }
        let structure = law.of(&fit.layout.structure);
        if inner.is_empty() {
            best = Some((0.0, structure));
            break;
        }
        let layout = job.layout(structure.clone());
        let missed = foretold(job, &fit, &layout, inner);
        if best
            .as_ref()
            .is_none_or(|(least, _)| missed < least - WORTH)
        {
            best = Some((missed, structure));
        }
    }
    let Some((_, structure)) = best else {
        return Ok(fit);
    };
    if structure.freedoms == fit.layout.structure.freedoms {
        return Ok(fit);
    }
    let layout = job.layout(structure);
    let theta = layout.carry(&fit.layout, &fit.theta);
    Ok(job.refine(&layout, theta, fit.metric))
}

/// Mean logarithm of the misfits at the distances `inner`, each foretold from the others.
fn foretold(job: &Job, fit: &Fitted, layout: &Layout, inner: &[f64]) -> f64 {
    let few = spread(&job.all(), TRIAL_TILES);
    let theta = layout.carry(&fit.layout, &fit.theta);
    let comparison = Comparison {
        metric: fit.metric,
        detail: Detail::COARSE,
        tolerance: LENIENT,
    };
    let (mut sum, mut count) = (0.0, 0);
    for &left_out in inner {
        let (out, kept): (Vec<&FitTile>, Vec<&FitTile>) =
            few.iter().copied().partition(|t| t.vergence == left_out);
        let settled = job.descend(layout, &kept, &theta, comparison, TRIAL);
        for misfit in misfits(job, layout, &settled.state.theta, &out, comparison) {
            sum += misfit.max(1e-12).ln();
            count += 1;
        }
    }
    sum / f64::from(count.max(1))
}

/// Misfits of tiles that took no part, their light and centroid as measured.
pub(super) fn misfits(
    job: &Job,
    layout: &Layout,
    theta: &[f64],
    tiles: &[&FitTile],
    comparison: Comparison,
) -> Vec<f64> {
    let own: Vec<Own> = job.state(tiles, theta).own;
    tiles
        .par_iter()
        .zip(own)
        .map_init(Buffers::default, |buffers, (tile, own)| {
            let pupil = layout.pupil(theta, tile.channel, tile.at, tile.vergence);
            tile.misfit(&pupil, &own, comparison, buffers)
        })
        .collect()
}

/// What the law leaves of one quantity in one channel at one distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Remainder {
    pub(super) quantity: Quantity,
    pub(super) channel: usize,
    pub(super) vergence: f64,
    pub(super) value: f64,
}

/// Fits every channel and distance apart from where the law leaves it, and returns what that adds:
/// only where it makes zones of the field that took no part fit better.
pub(super) fn remainders(job: &Job, fit: &Fitted) -> Vec<Remainder> {
    if job.vergences.len() < 2 {
        return Vec::new();
    }
    let all = job.all();
    let places: Vec<_> = all.iter().map(|t| t.at).collect();
    let back = holdout::held_out(&job.frame, &places);
    let mut found = Vec::new();
    for (channel, vergence) in groups(job) {
        let of = |wanted: &dyn Fn(bool) -> bool| -> Vec<&FitTile> {
            let pairs = all.iter().zip(&back);
            pairs
                .filter(|(t, _)| t.channel == channel && t.vergence == vergence)
                .filter(|(_, back)| wanted(**back))
                .map(|(t, _)| *t)
                .collect()
        };
        let (layout, theta) = alone(job, fit, vergence);
        let comparison = fit.comparison(STRICT);
        let apart = |tiles: &[&FitTile]| job.descend(&layout, tiles, &theta, comparison, APART);
        let check = of(&|back| back);
        let typical = |theta: &[f64]| {
            let all = misfits(job, &layout, theta, &check, comparison);
            all.iter().map(|m| m.max(1e-12).ln()).sum::<f64>() / all.len().max(1) as f64
        };
        let kept = apart(&of(&|back| !back));
        let helps = typical(&kept.state.theta) < typical(&theta) - WORTH;
        let settled = helps.then(|| apart(&of(&|_| true)));
        for freedom in layout.structure.freedoms.iter().filter(|f| !f.held) {
            let value = |theta: &[f64]| layout.value(theta, freedom.quantity, channel, vergence);
            let new = settled.as_ref().and_then(|s| value(&s.state.theta));
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
    // Distances that need nothing hold those that do to themselves; if none does there is nothing.
    if found.iter().all(|r| r.value == 0.0) {
        found.clear();
    }
    found
}

const APART: Patience = Patience {
    steps: 12,
    fall: 2e-3,
};

/// Channels and vergences of which there are tiles.
fn groups(job: &Job) -> Vec<(usize, f64)> {
    let channels = job.channel_names().len();
    (0..channels)
        .flat_map(|channel| job.vergences.iter().map(move |v| (channel, *v)))
        .filter(|(channel, v)| {
            let mut tiles = job.tiles.iter();
            tiles.any(|t| t.channel == *channel && t.vergence == *v)
        })
        .collect()
}

/// A lens for the distance of `vergence` alone, with the law's values there; what channels share stays.
fn alone(job: &Job, fit: &Fitted, vergence: f64) -> (Layout, Vec<f64>) {
    let mut structure = fit.layout.structure.clone();
    structure.axis = false;
    structure.freedoms = structure
        .freedoms
        .iter()
        .map(|freedom| Freedom {
            degree: 0,
            held: freedom.shared,
            ..*freedom
        })
        .collect();
    let layout = job.layout(structure);
    let mut theta = vec![0.0; layout.slots.len()];
    for (channel, _) in job.channel_names().iter().enumerate() {
        for freedom in &fit.layout.structure.freedoms {
            let value = fit
                .layout
                .value(&fit.theta, freedom.quantity, channel, vergence);
            if let Some(value) = value {
                layout.put(&mut theta, freedom.quantity, channel, value);
            }
        }
    }
    (layout, theta)
}
