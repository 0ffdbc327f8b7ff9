//! Causes that are not in the effect library, one function for each family.

use std::f64::consts::{PI, TAU};

use super::assembly::{Assembly, GREEN};
use super::change::GlassChange;
use super::errors::lever_at_stop;
use super::figure::{Figure, Ripple};
use super::lens::GlassLens;
use super::pairing::{Sensitivity, pairings};
use super::paraxial::course;
use crate::rng::Rng;

/// Draws a cause of the family `id`.
///
/// # Panics
/// If `id` is not a family of [`super::UNKNOWN`].
pub(super) fn unknown(id: &str, lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    match id {
        "trefoil" => trefoil(lens, rng),
        "ripple" => ripple(lens, rng),
        "air_space" => air_space(lens, rng),
        "glass_index" => glass_index(lens, rng),
        "central_obstruction" | "ghost" | "sharpening" | "bleeding" | "radial_smear" => {
            crate::unknown::unknown(id, rng).into()
        }
        _ => panic!("`{id}` is not on the list of unknown causes of traced lenses"),
    }
}

/// Bends the surface nearest to the stop with three waves about its rim: a lens pinched by its mount.
fn trefoil(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let lever = lever_at_stop(lens);
    let size = lever.slope_per_px / (3.0 * lever.rim_mm * lever.rim_mm);
    let shape = rng.direction().map(|d| d * size);
    let surface = lever.surface;
    GlassChange::new("trefoil", [0.1, 6.0], move |t, _, built| {
        built.bend(
            surface,
            Figure {
                trefoil: shape.map(|s| t * s),
                ..Figure::default()
            },
        );
    })
    .scaled("re", shape[0])
    .scaled("im", shape[1])
    .fixed("surface", surface as f64)
}

/// Leaves straight tool marks on the surface nearest to the stop.
fn ripple(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let lever = lever_at_stop(lens);
    let cycles = rng.between(2.0, 5.0);
    let k = PI * cycles / lever.rim_mm;
    let wave_number = rng.direction().map(|d| k * d);
    let phase = rng.between(0.0, TAU);
    let height = lever.slope_per_px / k;
    let surface = lever.surface;
    GlassChange::new("ripple", [0.1, 4.0], move |t, _, built| {
        built.bend(
            surface,
            Figure {
                ripple: Some(Ripple {
                    height: t * height,
                    wave_number,
                    phase,
                }),
                ..Figure::default()
            },
        );
    })
    .scaled("height_mm", height)
    .fixed("cycles_across", cycles)
    .fixed("surface", surface as f64)
}

/// An error of assembly that changes aberrations of third order, where the library has no term of its own.
#[derive(Debug, Clone, Copy)]
enum Assembling {
    /// The air behind this surface is thicker, mm.
    Space(usize),
    /// The index of the glass behind this surface is larger.
    Index(usize),
}

impl Assembling {
    fn build(self, amount: f64, built: &mut Assembly) {
        match self {
            Self::Space(surface) => {
                let last = built.surfaces.len() - 1;
                built.shift(surface + 1..=last, [0.0, 0.0, amount]);
                built.sensor.centre[2] += amount;
            }
            Self::Index(surface) => {
                for index in &mut built.surfaces[surface].index {
                    *index += amount;
                }
            }
        }
    }
}

/// Makes two air spaces wrong.
fn air_space(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let surfaces = &lens.design.surfaces;
    let spaces: Vec<Assembling> = (0..lens.design.cover() - 1)
        .filter(|&i| surfaces[i].index[GREEN] == 1.0)
        .map(Assembling::Space)
        .collect();
    let most = 0.03 * lens.camera.focal_mm;
    focused_pair("air_space", [0.002 * most, most], &spaces, lens, rng)
}

/// Melts two glasses of wrong index.
fn glass_index(lens: &GlassLens, rng: &mut Rng) -> GlassChange {
    let surfaces = &lens.design.surfaces;
    let glasses: Vec<Assembling> = (0..lens.design.cover())
        .filter(|&i| surfaces[i].index[GREEN] > 1.0)
        .map(Assembling::Index)
        .collect();
    focused_pair("glass_index", [1e-4, 0.04], &glasses, lens, rng)
}

/// Returns the change by two of `errors` that leaves the image size as it was, after the sensor is focused again.
fn focused_pair(
    id: &'static str,
    range: [f64; 2],
    errors: &[Assembling],
    lens: &GlassLens,
    rng: &mut Rng,
) -> GlassChange {
    let size = |built: &Assembly| course(built, GREEN, lens.camera.focus_m).chief;
    let step = 0.1 * range[1];
    let sensitivities: Vec<Sensitivity> = errors
        .iter()
        .map(|error| {
            let mut built = lens.design.clone();
            error.build(step, &mut built);
            built.refocus(lens.camera.focus_m);
            Sensitivity {
                wanted: 1.0,
                unwanted: (size(&built) / size(&lens.design) - 1.0) / step,
            }
        })
        .collect();
    let all = pairings(&sensitivities);
    let pairing = all[rng.below(all.len())];
    let scale = rng.sign() / pairing.largest();
    let amounts = pairing.amounts.map(|a| a * scale);
    let pair = pairing.errors.map(|i| errors[i]);
    let place = |error: Assembling| match error {
        Assembling::Space(surface) | Assembling::Index(surface) => surface as f64,
    };
    GlassChange::new(id, range, move |t, lens, built| {
        for (error, amount) in pair.into_iter().zip(amounts) {
            error.build(t * amount, built);
        }
        built.refocus(lens.camera.focus_m);
    })
    .scaled("first", amounts[0])
    .scaled("second", amounts[1])
    .fixed("behind_first", place(pair[0]))
    .fixed("behind_second", place(pair[1]))
}
