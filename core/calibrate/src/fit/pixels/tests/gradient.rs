//! The normal equations of a tile against finite differences of its misfit.

use super::super::context::{FitContext, LENIENT_TOLERANCE};
use super::super::metric::Metric;
use super::super::parameters::{ModelStructure, ParameterLayout, PolynomialSpec};
use super::super::tile_equations::{Comparison, FitTile, MisfitSettings, TileParameters};
use super::*;
use seidel_optics::psf::pupil::Detail;

/// Returns the reduced model with stops, an uneven pupil and decentred elements, all free.
fn structure() -> ModelStructure {
    let mut structure = ModelStructure::reduced(1);
    let parts: [&'static dyn Effect; 3] = [
        &effects::Vignetting,
        &effects::Apodisation,
        &effects::Decentre,
    ];
    for (which, effect) in parts.into_iter().enumerate() {
        structure.effects.push(effect);
        for k in 0..effect.parameters().len().min(8) {
            structure.polynomials.push(PolynomialSpec {
                quantity: Quantity::Effect(which, k),
                degree: 0,
                least_degree: 0,
                shared: true,
                fixed: false,
            });
        }
    }
    structure
}

/// Returns parameters at which all parts act.
fn parameters(layout: &ParameterLayout) -> Vec<f64> {
    let mut theta = vec![0.0; layout.parameters.len()];
    layout.set_constant_in_all(&mut theta, Quantity::Alpha, 5.0);
    layout.set_constant_in_all(&mut theta, Quantity::Beta, 0.8);
    layout.set_constant_in_all(&mut theta, Quantity::Phi, 0.7);
    layout.set_constant_in_all(&mut theta, Quantity::Blur, 0.3);
    let parts = [
        vec![1.1, 0.5, 1.2, -0.6],
        vec![0.5, 0.1, 0.2, -0.1],
        vec![0.4, -0.3],
    ];
    for (which, values) in parts.into_iter().enumerate() {
        for (k, value) in values.into_iter().enumerate() {
            layout.set_constant_in_all(&mut theta, Quantity::Effect(which, k), value);
        }
    }
    theta
}

#[test]
fn the_gradient_is_that_of_the_misfit() {
    let set = observed(
        &planted(&mut SplitMix64::new(3)),
        8,
        0.0,
        &mut SplitMix64::new(4),
    );
    with_context(&set, |context| {
        gradient_is_that_of_the_misfit(&set, context)
    });
}

fn gradient_is_that_of_the_misfit(set: &ObservationSet, context: &FitContext) {
    let layout = context.layout(structure());
    let theta = parameters(&layout);
    let misfit_settings = MisfitSettings {
        metric: Metric::NaturalSpectrum,
        detail: Detail::FULL,
        tolerance: LENIENT_TOLERANCE,
    };
    let comparison = &mut Comparison::new(misfit_settings);
    let mut checked = 0;
    for tile in context.tiles.iter().filter(|t| !t.centroid_unknown).take(6) {
        let mut own = context.tile_parameters(&[tile])[0];
        let mut misfit =
            |theta: &[f64], own: &TileParameters| misfit(tile, &layout, theta, own, comparison);
        // At the best flux the misfit changes with the lens alone.
        let trials = [0.9, 1.0, 1.1].map(|f| {
            let flux = own.flux * f;
            misfit(&theta, &TileParameters { flux, ..own })
        });
        let bend = trials[0] - 2.0 * trials[1] + trials[2];
        own.flux *= 1.0 + 0.05 * (trials[0] - trials[2]) / bend;
        let slopes: Vec<f64> = (0..theta.len())
            .map(|k| {
                let mut at = |by: f64| {
                    let mut moved = theta.clone();
                    moved[k] += by;
                    misfit(&moved, &own)
                };
                (at(2e-3) - at(-2e-3)) / 4e-3
            })
            .collect();
        let equations = tile.system(&layout, &theta, &own, comparison).lens;
        let size = slopes.iter().map(|s| s * s).sum::<f64>().sqrt();
        for (k, right) in equations.parameters.iter().zip(equations.right.iter()) {
            let error = (-2.0 * right - slopes[*k]).abs();
            let name = layout.name(*k, &set.channels);
            assert!(
                error < 0.02 * size,
                "{name}: {} against {}, of {size}",
                -2.0 * right,
                slopes[*k]
            );
            checked += 1;
        }
    }
    assert!(checked > 60, "{checked}");
}

fn misfit(
    tile: &FitTile,
    layout: &ParameterLayout,
    theta: &[f64],
    own: &TileParameters,
    comparison: &mut Comparison,
) -> f64 {
    let pupil = layout.pupil(theta, tile.channel, tile.at, tile.vergence);
    tile.misfit(&pupil, own, comparison)
}
