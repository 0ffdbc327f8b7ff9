//! Melts of wrong dispersion: two glasses in the proportion at which only axial or only lateral colour results.

use super::assembly::{Assembly, GREEN};
use super::change::GlassChange;
use super::lens::GlassLens;
use super::pairing::{Pairing, Sensitivity, pairings};
use super::paraxial::course;
use crate::rng::Rng;

const RED: usize = 0;
const BLUE: usize = 2;
/// Largest relative change of the dispersion of a glass.
const LARGEST: f64 = 0.6;
/// Number of the most effective pairs of glasses to choose from.
const CHOICE: usize = 3;
/// Relative change of dispersion for differences.
const STEP: f64 = 1e-3;

/// The colour errors of a lens between red and blue, px.
#[derive(Debug, Clone, Copy)]
struct ColourErrors {
    /// Difference of defocus at the rim.
    axial: f64,
    /// Difference of image height at h = 1.
    lateral: f64,
}

fn colour_errors(lens: &GlassLens, built: &Assembly) -> ColourErrors {
    let [red, blue] = [RED, BLUE].map(|channel| course(built, channel, lens.camera.focus_m));
    let pitch = built.sensor.pitch_mm;
    // Slope of the chief ray at h = 1 in the scene.
    let slope = lens.camera.frame.half_width_px() * pitch / built.view.chief_mm;
    ColourErrors {
        axial: (red.defocus - blue.defocus) / pitch,
        lateral: (red.chief - blue.chief) * slope / pitch,
    }
}

/// Returns the surfaces in front of each glass of the lens.
fn glasses(lens: &GlassLens) -> Vec<usize> {
    let of_glass = |i: &usize| lens.design.surfaces[*i].index[GREEN] > 1.0;
    (0..lens.design.cover()).filter(of_glass).collect()
}

/// Returns the colour errors of a unit of relative dispersion of each glass.
fn sensitivities(lens: &GlassLens, glasses: &[usize]) -> Vec<ColourErrors> {
    let bare = colour_errors(lens, &lens.design);
    let of_glass = |&glass: &usize| {
        let mut built = lens.design.clone();
        built.disperse(glass, 1.0 + STEP);
        let errors = colour_errors(lens, &built);
        ColourErrors {
            axial: (errors.axial - bare.axial) / STEP,
            lateral: (errors.lateral - bare.lateral) / STEP,
        }
    };
    glasses.iter().map(of_glass).collect()
}

/// Changes the dispersion of two glasses so that axial colour results.
pub(super) fn axial_colour(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let pure = |e: &ColourErrors| Sensitivity {
        wanted: e.axial,
        unwanted: e.lateral,
    };
    melts("axial_colour", [0.05, 5.0], lens, pure, rng)
}

/// Changes the dispersion of two glasses so that lateral colour results.
pub(super) fn lateral_colour(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let pure = |e: &ColourErrors| Sensitivity {
        wanted: e.lateral,
        unwanted: e.axial,
    };
    melts("lateral_colour", [0.05, 4.0], lens, pure, rng)
}

fn melts(
    id: &'static str,
    range: [f64; 2],
    lens: &GlassLens,
    pure: impl Fn(&ColourErrors) -> Sensitivity,
    rng: &mut Rng,
) -> GlassChange {
    let glasses = glasses(lens);
    let errors: Vec<Sensitivity> = sensitivities(lens, &glasses).iter().map(pure).collect();
    let all = pairings(&errors);
    let Pairing { errors, amounts } = all[rng.below(CHOICE.min(all.len()))];
    let sign = rng.sign();
    let pair = errors.map(|i| glasses[i]);
    let amounts = amounts.map(|a| sign * a);
    let most = LARGEST / amounts[0].abs().max(amounts[1].abs());
    let range = [range[0].min(0.5 * most), range[1].min(most)];
    GlassChange::new(id, range, move |t, _, built| {
        for (glass, amount) in pair.into_iter().zip(amounts) {
            built.disperse(glass, 1.0 + t * amount);
        }
    })
    .scaled("red_less_blue_px", sign)
    .scaled("dispersion_first", amounts[0])
    .scaled("dispersion_second", amounts[1])
    .fixed("glass_first", pair[0] as f64)
    .fixed("glass_second", pair[1] as f64)
}
