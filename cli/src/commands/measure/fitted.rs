//! The lens fitted to a measured set.

use seidel_calibrate::diagnose::{MistakeInSet, mistakes_between};
use seidel_calibrate::fit::{self, coverage};
use seidel_calibrate::score::pixel_residuals;
use seidel_core::{
    AxisChoice, Fit, FitSettings, LensProfile, Model, ObjectDistance, ObservationSet,
};
use seidel_measure::photon_transfer::{self, Residual};
use serde_json::{Value, json};

use super::camera;
use super::common::CommonArgs;
use crate::Console;
use crate::commands::{CommandError, mistake_note, short_name};

/// Electrons at the clipping level of a typical sensor, from which a first fit takes its weights.
const TYPICAL_FULL_WELL: f64 = 30_000.0;
/// Observations from which on the extended model is fitted.
const MIN_EXTENDED: usize = 24;

/// Share of the first fit, which selects the model, in the time of both.
const FIRST_SHARE: f64 = 0.85;

/// The noise of the pixels of a set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PixelNoise {
    /// That of light as well as of the dark: `white` is the clipping level in counts, infinite if unknown.
    Photons { white: f64 },
    /// As the observations state it.
    Stated,
}

/// Fits a lens to `set` in two steps. The first selects the model and holds a fifth of the lights out, for the score; where the set
/// states no gain, its residuals give one by photon transfer. The second fits that model to all lights, with the gain as the weight of
/// pixels. The gain is not kept, because the residuals hold errors of the model as well as noise.
///
/// The first `added` observations are those of the set that the measured ones were added to. Where the lens does not describe all, a mistake in the
/// books of either is looked for.
pub(super) fn fit_lens(
    args: &CommonArgs,
    set: &mut ObservationSet,
    added: usize,
    noise: PixelNoise,
    console: &Console,
) -> Result<Fit, CommandError> {
    args.put_camera(set)?;
    let model = if set.observations.len() >= MIN_EXTENDED {
        Model::Extended
    } else {
        Model::Auto
    };
    let settings = FitSettings {
        model,
        axis: args.axis.unwrap_or(AxisChoice::Free),
        ..FitSettings::default()
    };
    let stated: Vec<Option<f64>> = set.observations.iter().map(|o| o.gain).collect();
    if let PixelNoise::Photons { white } = noise
        && white.is_finite()
    {
        for observation in &mut set.observations {
            observation.gain = observation.gain.or(Some(white / TYPICAL_FULL_WELL));
        }
    }
    let bar = console.progress_bar("fitting");
    let begin = |share: f64| bar.show(share * FIRST_SHARE);
    let first = fit::fit(std::slice::from_ref(set), &settings, &begin)?;
    let gain = if noise == PixelNoise::Stated || stated.iter().all(Option::is_some) {
        None
    } else {
        estimated_gain(first.lens(), set)?
    };
    for (observation, stated) in set.observations.iter_mut().zip(&stated) {
        observation.gain = stated.or(gain);
    }
    let rest = |share: f64| bar.show(FIRST_SHARE + share * (1.0 - FIRST_SHARE));
    let mut fit = fit::refit(std::slice::from_ref(set), &first, &settings, &rest)?;
    for (observation, stated) in set.observations.iter_mut().zip(stated) {
        observation.gain = stated;
    }
    fit.lens_mut().held_out = first.lens().held_out.clone().map(|mut held_out| {
        held_out.rule += "; scored by a fit without them, before all were fitted";
        held_out
    });
    fit.lens_mut().provenance.sources = args.photographs.iter().map(|p| short_name(p)).collect();
    if let Some(distance) = only_distance(set.observations.iter().map(|o| o.distance))
        && let Some(remark) = camera::extend_one_distance(fit.lens_mut(), distance)
    {
        let warnings = fit.warnings_mut();
        warnings.retain(|warning| !warning.contains(coverage::ONE_DISTANCE));
        warnings.push(remark);
    }
    if let Some(path) = &args.also {
        let [mut other, mut own] = [set.clone(), set.clone()];
        other.observations.truncate(added);
        own.observations.drain(..added);
        for MistakeInSet { set, found } in mistakes_between(&[other, own], fit.lens()) {
            let of = [path, &args.out][set].display();
            let text = mistake_note(&found);
            fit.warnings_mut().push(format!("{of}: {text}"));
        }
    }
    Ok(fit)
}

/// Returns the distance that all of `distances` are; `None` for several.
pub(super) fn only_distance(
    mut distances: impl Iterator<Item = ObjectDistance>,
) -> Option<ObjectDistance> {
    let first = distances.next()?;
    distances.all(|other| other == first).then_some(first)
}

/// Returns the gain that the residuals of `lens` show; `None` if they do not determine it.
fn estimated_gain(lens: &LensProfile, set: &ObservationSet) -> Result<Option<f64>, CommandError> {
    let residuals: Vec<Residual> = (pixel_residuals(lens, set)?.into_iter())
        .map(|r| Residual {
            signal: r.signal,
            peak: r.peak,
            square: r.residual * r.residual,
            dark_variance: r.sigma * r.sigma,
        })
        .collect();
    let gain = photon_transfer::estimate(&residuals);
    Ok(gain.map(|gain| gain.counts_per_electron))
}

/// Prints the figures of the lens.
pub(super) fn print_report(fit: &Fit, console: &mut Console) {
    let lens = fit.lens();
    let axis = lens.frame.axis();
    console.print(format!(
        "optical axis ({:.1}, {:.1}) px",
        axis.x_px, axis.y_px
    ));
    if let Some(held_out) = &lens.held_out {
        console.print(format!(
            "lens: {:.1} dB forward-blur SNR on {} held-out tiles",
            held_out.snr_db, held_out.tiles
        ));
    }
    for warning in fit.warnings() {
        console.note(warning);
    }
}

/// Returns the figures of the lens as JSON.
pub(super) fn report_json(lens: &LensProfile) -> Value {
    let axis = lens.frame.axis();
    let held_out = lens.held_out.as_ref();
    json!({
        "axis": [axis.x_px, axis.y_px],
        "held_out": held_out.map(|h| json!({"tiles": h.tiles, "snr_db": h.snr_db})),
    })
}
