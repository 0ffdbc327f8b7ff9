//! The lens on a canvas as a linear operator A, with its adjoint and filters that approximate its inverse.
//!
//! Where depth varies the canvas is cut into layers j of one vergence each, and A x = G Σ A_j c_j x. The coverage c_j is
//! the share of each pixel in layer j: a hat function of the layer coordinate, so that all shares of a pixel sum to
//! one. A_j is the lens at the vergence of the layer. The normalisation G is diagonal and makes A preserve uniform light, as
//! if the light hidden behind a blurred edge were like the light seen there.

use super::canvas::Canvas;
use super::depth_layer::DepthLayer;
use super::gradient::norms;
use super::hole_filling::continue_known;
use super::ramp;
use super::texture::Estimate;
use super::transfer_functions::StopbandPower;
use crate::{DepthLayers, Edges, LayerSpacing, RenderWindow, Scene, VergencePass, snapped};
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::error::Result;

/// Least light of a blurred uniform canvas that is normalised to one. A lower bound would amplify pixels that get hardly
/// any light.
const MIN_UNIFORM_LIGHT: f32 = 0.05;
/// Normalisation errors at depth edges at which a pixel begins to keep its blur and keeps all of it.
pub(super) const KEPT_NORMALISATION_ERROR: [f32; 2] = [0.05, 0.15];
/// Shares of light from kernels like those of a layer between which a sample goes from unknown to known in it.
const OWN_LIGHT: [f32; 2] = [0.5, 0.9];

/// The lens on a canvas.
pub(super) struct LensOperator {
    layers: Vec<DepthLayer>,
    /// Columns and rows of the canvas.
    size: (usize, usize),
    /// The diagonal of G; `None` if all of the canvas is at one vergence.
    normalisation: Option<Vec<f32>>,
}

/// The accuracy of a blur.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Accuracy {
    /// That of the draft renderer. [`LensOperator::adjoint`] is the exact transpose at this accuracy.
    Draft,
    /// That of the final renderer.
    Final,
}

impl LensOperator {
    /// Prepares the operator on the `canvas` of `scene`, for a plane with these channel `weights`.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn new(scene: &Scene, canvas: &Canvas, weights: &[f64]) -> Result<Self> {
        let canvas_scene = Scene {
            edges: Edges::Black,
            ..canvas.scene(scene, None)
        };
        let size = canvas.size();
        let VergencePass::PerPixel(pass) = scene.vergence else {
            return Ok(Self {
                layers: vec![DepthLayer::only(&canvas_scene, weights)?],
                size,
                normalisation: None,
            });
        };
        let pass = canvas.extend_by_replication(pass);
        let mut operator = Self {
            layers: depth_layers(&canvas_scene, &pass, weights)?,
            size,
            normalisation: None,
        };
        let ones = vec![1.0; size.0 * size.1];
        let layers = operator.layers.iter();
        let blurred: Vec<Vec<f32>> = layers
            .map(|layer| layer.apply(&ones, Accuracy::Final))
            .collect::<Result<_>>()?;
        let mut uniform = vec![0.0; size.0 * size.1];
        for (layer, light) in operator.layers.iter().zip(&blurred) {
            layer.add_to(&mut uniform, light);
        }
        let gains = uniform
            .iter()
            .map(|light| light.max(MIN_UNIFORM_LIGHT).recip());
        let gains: Vec<f32> = gains.collect();
        for (layer, light) in operator.layers.iter_mut().zip(blurred) {
            layer.set_light_share(light, &gains);
        }
        operator.normalisation = Some(gains);
        Ok(operator)
    }

    /// Applies A: blurs `plane`.
    ///
    /// # Errors
    /// A plane that is not of the canvas's size.
    pub(super) fn apply(&self, plane: &[f32], accuracy: Accuracy) -> Result<Vec<f32>> {
        let mut out = self.sum_of_layers(|layer| layer.apply(plane, accuracy))?;
        self.normalise(&mut out);
        Ok(out)
    }

    /// Applies Aᵀ, with draft accuracy.
    ///
    /// # Errors
    /// A plane that is not of the canvas's size.
    pub(super) fn adjoint(&self, mut plane: Vec<f32>) -> Result<Vec<f32>> {
        self.normalise(&mut plane);
        self.sum_of_layers(|layer| layer.adjoint(&plane))
    }

    /// Returns the relative error of each pixel of a blurred uniform canvas without normalisation. It is large at depth
    /// edges, where occlusion makes A wrong. `None` if all of the canvas is at one vergence.
    pub(super) fn normalisation_error(&self) -> Option<Vec<f32>> {
        let gains = self.normalisation.as_ref()?.iter();
        Some(gains.map(|gain| (gain.recip() - 1.0).abs()).collect())
    }

    /// Filters `plane` by `gain(h, |D|²)` on local spectra, each pixel by the transfer functions h of its own layer.
    pub(super) fn filter(
        &self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        self.sum_of_layers(|layer| Ok(layer.filter(plane, &gain)))
    }

    /// Filters `plane` like [`Self::filter`], each layer by itself: samples that are not `known`, and those with light of other kernels, are
    /// replaced by a smooth continuation. Where kernels differ, what one layer shows would ring in the other.
    pub(super) fn filter_by_layer(
        &self,
        plane: &[f32],
        known: &[bool],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        if self.is_flat() {
            return self.filter(plane, gain);
        }
        self.sum_of_layers(|layer| {
            let mut shares = vec![0.0; plane.len()];
            for other in &self.layers {
                let likeness = layer.likeness(other);
                if likeness > 0.0 {
                    other.add_light_share_to(&mut shares, likeness);
                }
            }
            for (share, known) in shares.iter_mut().zip(known) {
                *share = if *known { ramp(*share, OWN_LIGHT) } else { 0.0 };
            }
            let continued = continue_known(plane, self.size.0, &shares);
            Ok(layer.filter(&continued, &gain))
        })
    }

    /// Returns whether all of the canvas is at one vergence.
    pub(super) fn is_flat(&self) -> bool {
        self.normalisation.is_none()
    }

    /// Filters `plane` like [`Self::filter`], by `gain(h, r, |D|²)` with the transfer functions r of another operator on
    /// the same canvas.
    pub(super) fn convert(
        &self,
        to: &Self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        if let ([layer], [to]) = (self.layers.as_slice(), to.layers.as_slice())
            && layer.is_only()
        {
            return Ok(layer.convert(to, plane, &gain));
        }
        let mut out = vec![0.0; self.size.0 * self.size.1];
        for (layer, to) in self.layers.iter().zip(&to.layers) {
            layer.add_to(&mut out, &layer.convert(to, plane, &gain));
        }
        Ok(out)
    }

    /// Filters like [`Self::filter`], as a symmetric operator if `gain` is real: a preconditioner.
    pub(super) fn precondition(
        &self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        self.sum_of_layers(|layer| Ok(layer.filter_symmetrically(plane, &gain)))
    }

    /// Returns the correction of texture for an `image` with this `residual`, whose noise has the standard deviation
    /// `deviation` ([`texture_correction`](super::texture::texture_correction)).
    pub(super) fn texture_correction(
        &self,
        image: &[f32],
        residual: &[f32],
        deviation: f64,
    ) -> Result<Vec<f32>> {
        let estimate = Estimate {
            image,
            residual,
            gradient_norms: &norms(image, self.size.0),
            deviation: deviation as f32,
        };
        self.sum_of_layers(|layer| Ok(layer.texture_correction(&estimate)))
    }

    /// Returns the mean of `value(h, |D|²)` over all frequencies at each pixel of the canvas.
    pub(super) fn mean_over_frequencies(
        &self,
        value: impl Fn(Complex<f32>, f32) -> f32 + Sync,
    ) -> Result<Vec<f32>> {
        self.sum_of_layers(|layer| Ok(layer.mean_over_frequencies(&value)))
    }

    /// Returns the powers of `plane`, a plane of the canvas, in the stopband of each usable tile
    /// ([`TransferFunctions::stopband_powers`](super::transfer_functions::TransferFunctions::stopband_powers)).
    pub(super) fn stopband_powers(
        &self,
        plane: &[f32],
        stopband_power: f32,
        min_frequencies: usize,
    ) -> Vec<StopbandPower> {
        let layers = self.layers.iter();
        layers
            .flat_map(|layer| layer.stopband_powers(plane, stopband_power, min_frequencies))
            .collect()
    }

    /// Adds up `plane_of` each layer, in order, so that the sum does not depend on the number of threads.
    fn sum_of_layers(
        &self,
        plane_of: impl Fn(&DepthLayer) -> Result<Vec<f32>>,
    ) -> Result<Vec<f32>> {
        if let [layer] = self.layers.as_slice()
            && layer.is_only()
        {
            return plane_of(layer);
        }
        let mut out = vec![0.0; self.size.0 * self.size.1];
        for layer in &self.layers {
            layer.add_to(&mut out, &plane_of(layer)?);
        }
        Ok(out)
    }

    fn normalise(&self, plane: &mut [f32]) {
        if let Some(gains) = &self.normalisation {
            for (sample, gain) in plane.iter_mut().zip(gains) {
                *sample *= gain;
            }
        }
    }
}

/// Cuts the canvas of `scene` into layers by `pass`, the vergence of each of its pixels. Layers without a pixel are left
/// out.
fn depth_layers(scene: &Scene, pass: &[f32], weights: &[f64]) -> Result<Vec<DepthLayer>> {
    let ends = |(low, high): (f32, f32), v: &f32| (low.min(*v), high.max(*v));
    let (lowest, highest) = pass.iter().fold((f32::INFINITY, f32::NEG_INFINITY), ends);
    let (lowest, highest) = (f64::from(lowest), f64::from(highest));
    let layers = DepthLayers::new(scene, lowest, highest, LayerSpacing::BY_HALF_THE_BLUR);
    let coordinates: Vec<f32> = pass
        .par_iter()
        .map(|vergence| layers.coordinate(f64::from(*vergence)))
        .collect();
    let coordinates = snapped(&coordinates, scene.width, scene.height);
    let layer = |index: usize| {
        let hat = |at: &f32| (1.0 - (at - layers.coordinate_of(index)).abs()).max(0.0);
        let coverage: Vec<f32> = coordinates.iter().map(hat).collect();
        let covered = covered_window(&coverage, scene.width)?;
        let size = layers.size(layers.coordinate_of(index));
        let vergence = layers.vergence(index);
        let layer = DepthLayer::at_vergence(scene, weights, vergence, covered, &coverage);
        Some(layer.map(|layer| layer.of_size(size)))
    };
    (0..layers.len())
        .into_par_iter()
        .filter_map(layer)
        .collect()
}

/// Returns the smallest window with all pixels whose coverage is above zero, if there are any.
fn covered_window(coverage: &[f32], width: usize) -> Option<RenderWindow> {
    let (mut left, mut right, mut top, mut bottom) = (usize::MAX, 0, usize::MAX, 0);
    for (y, row) in coverage.chunks_exact(width).enumerate() {
        let Some(first) = row.iter().position(|share| *share > 0.0) else {
            continue;
        };
        let last = row.iter().rposition(|share| *share > 0.0).unwrap_or(first);
        (left, right) = (left.min(first), right.max(last + 1));
        (top, bottom) = (top.min(y), y + 1);
    }
    (left < right).then(|| RenderWindow {
        column: left,
        row: top,
        width: right - left,
        height: bottom - top,
    })
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{HEIGHT, NormalDeviates, WEIGHTS, WIDTH, discs, lens, scene};
    use super::*;

    fn dot(a: &[f32], b: &[f32]) -> f64 {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    }

    #[test]
    fn a_filter_of_unit_gain_returns_the_plane() {
        let lens = lens(1.0);
        let scene = scene(&lens);
        let canvas = Canvas::new(&scene);
        let operator = LensOperator::new(&scene, &canvas, &WEIGHTS).expect("a valid lens");
        let plane = canvas.extend_by_mirroring(&discs(WIDTH, HEIGHT));
        let same = operator.filter(&plane, |_, _| 1.0.into());
        let same = same.expect("a plane of the canvas");
        let differences = plane.iter().zip(&same).map(|(a, b)| (a - b).abs());
        assert!(differences.fold(0.0, f32::max) < 1e-5);
        let ones = operator.mean_over_frequencies(|_, _| 1.0);
        let ones = ones.expect("a plane of the canvas");
        assert!(ones.iter().all(|v| (v - 1.0).abs() < 1e-5));
    }

    /// With one layer and with several.
    #[test]
    fn adjoint_matches_inner_products() {
        let lens = lens(1.0);
        let pass: Vec<f32> = (0..WIDTH * HEIGHT)
            .map(|k| {
                if k % WIDTH < 60 {
                    1.0
                } else {
                    0.004 * (k / WIDTH) as f32
                }
            })
            .collect();
        let flat = scene(&lens);
        let deep = Scene {
            vergence: VergencePass::PerPixel(&pass),
            ..scene(&lens)
        };
        let mut deviates = NormalDeviates(3);
        for scene in [flat, deep] {
            let canvas = Canvas::new(&scene);
            let operator = LensOperator::new(&scene, &canvas, &WEIGHTS).expect("a valid lens");
            let count = canvas.size().0 * canvas.size().1;
            let (x, y) = (deviates.plane(count), deviates.plane(count));
            let blurred = operator.apply(&x, Accuracy::Draft);
            let blurred = blurred.expect("a plane of the canvas");
            let back = operator.adjoint(y.clone()).expect("a plane of the canvas");
            let scale = (dot(&blurred, &blurred) * dot(&y, &y)).sqrt();
            assert!((dot(&blurred, &y) - dot(&x, &back)).abs() < 1e-5 * scale);
        }
    }

    /// A bright texture among the near pixels, which are blurred more, and an even area among the far ones.
    #[test]
    fn a_layer_is_filtered_without_the_light_of_other_kernels() {
        let lens = lens(1.0);
        let pass: Vec<f32> = (0..WIDTH * HEIGHT)
            .map(|k| if k % WIDTH < 60 { 4.0 } else { 0.0 })
            .collect();
        let scene = Scene {
            vergence: VergencePass::PerPixel(&pass),
            ..scene(&lens)
        };
        let canvas = Canvas::new(&scene);
        let operator = LensOperator::new(&scene, &canvas, &WEIGHTS).expect("a valid lens");
        let plate: Vec<f32> = (0..WIDTH * HEIGHT)
            .map(|k| {
                if k % WIDTH < 56 {
                    4.0 * (k % 3) as f32
                } else {
                    0.5
                }
            })
            .collect();
        let plane = canvas.extend_by_mirroring(&plate);
        let known = vec![true; plane.len()];
        let gain = |h: Complex<f32>, _| h.conj() / (h.norm_sqr() + 1e-3);
        let error = |filtered: Result<Vec<f32>>| {
            let filtered = canvas.crop(&filtered.expect("a plane of the canvas"));
            let even = (0..WIDTH * HEIGHT).filter(|k| (61..WIDTH - 16).contains(&(k % WIDTH)));
            even.map(|k| (filtered[k] - 0.5).abs()).fold(0.0, f32::max)
        };
        let at_once = error(operator.filter(&plane, gain));
        let by_layer = error(operator.filter_by_layer(&plane, &known, gain));
        assert!(at_once > 0.1, "{at_once}, {by_layer}");
        assert!(by_layer < 0.1 * at_once, "{at_once}, {by_layer}");
    }

    #[test]
    fn uniform_light_is_preserved_at_a_depth_edge() {
        let lens = lens(1.0);
        let pass: Vec<f32> = (0..WIDTH * HEIGHT)
            .map(|k| if k % WIDTH < 60 { 1.0 } else { 0.0 })
            .collect();
        let scene = Scene {
            vergence: VergencePass::PerPixel(&pass),
            ..scene(&lens)
        };
        let canvas = Canvas::new(&scene);
        let operator = LensOperator::new(&scene, &canvas, &WEIGHTS).expect("a valid lens");
        let uniform = vec![0.7; canvas.size().0 * canvas.size().1];
        let blurred = operator.apply(&uniform, Accuracy::Final);
        let blurred = canvas.crop(&blurred.expect("a plane of the canvas"));
        assert!(blurred.iter().all(|v| (v - 0.7).abs() < 1e-4));
    }
}
