//! A depth layer of a canvas: the light at nearly one vergence, with the lens at that vergence.

use super::canvas::window_scene;
use super::texture::{Estimate, texture_correction};
use super::transfer_functions::{Purpose, TransferFunctions};
use crate::{Operator, Quality, RenderWindow, Scene, VergencePass, kernel_reach};
use seidel_fourier::Complex;
use seidel_optics::error::Result;

/// Least mean transmission for which the preconditioner amplifies light.
const MIN_TRANSMISSION: f32 = 0.1;
/// Least transmission for which it amplifies the light of a pixel, as a share of the mean.
const LEAST_PASSED: f32 = 0.5;

/// A layer, on the window of the canvas that its light reaches.
///
/// Its methods take planes of the canvas and return planes of the window.
pub(super) struct DepthLayer {
    operator: Operator,
    transfer: TransferFunctions,
    /// Columns of the canvas.
    canvas_width: usize,
    window: RenderWindow,
    /// Share of each pixel of the window that is in this layer; `None` if all of the canvas is in it.
    coverage: Option<Vec<f32>>,
    /// Share of the surface hidden behind each pixel of the window that is in this layer; `None` if there is none.
    hidden: Option<Vec<f32>>,
    /// Share of the layer's light at each pixel of the window that passes what lies in front; `None` if all of it does.
    transmission: Option<Vec<f32>>,
    /// Share of the light of each pixel of the window that passes what lies in front; empty if all of it does.
    passed: Vec<f32>,
    /// Root mean square of that over the covered and over the hidden pixels.
    mean_passed: [f32; 2],
    /// Kernel size in px, signed and shifted so that it grows towards the camera.
    nearness: f32,
}

/// An image on the window of a layer.
pub(super) struct LayerImage {
    pub(super) front: Vec<f32>,
    /// `None` if no surface of the layer is hidden.
    pub(super) hidden: Option<Vec<f32>>,
}

impl DepthLayer {
    /// Prepares the only layer of the canvas of `scene`, at one vergence, for a plane with these channel `weights`.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn only(scene: &Scene, weights: &[f64], purpose: Purpose) -> Result<Self> {
        Self::new(scene, weights, purpose, RenderWindow::whole(scene), None)
    }

    /// Prepares the layer at `vergence`, 1/m, whose `coverage` of the canvas lies within the window `covered`.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn at_vergence(
        scene: &Scene,
        weights: &[f64],
        purpose: Purpose,
        vergence: f64,
        covered: RenderWindow,
        coverage: &[f32],
    ) -> Result<Self> {
        let scene = Scene {
            vergence: VergencePass::Constant(vergence),
            ..*scene
        };
        let reach = kernel_reach(&scene, covered, vergence);
        let column = covered.column.saturating_sub(reach.left_px as usize);
        let row = covered.row.saturating_sub(reach.up_px as usize);
        let right = (covered.column + covered.width + reach.right_px as usize).min(scene.width);
        let bottom = (covered.row + covered.height + reach.down_px as usize).min(scene.height);
        let window = RenderWindow {
            column,
            row,
            width: right - column,
            height: bottom - row,
        };
        Self::new(&scene, weights, purpose, window, Some(coverage))
    }

    fn new(
        scene: &Scene,
        weights: &[f64],
        purpose: Purpose,
        window: RenderWindow,
        coverage: Option<&[f32]>,
    ) -> Result<Self> {
        let part = window_scene(scene, window);
        let purpose = match (coverage, purpose) {
            (Some(_), Purpose::Filter) => Purpose::LayerFilter,
            _ => purpose,
        };
        let (operator, transfer) = rayon::join(
            || Operator::new(&part, &[weights.to_vec()], Quality::Final),
            || TransferFunctions::new(&part, weights, purpose),
        );
        Ok(Self {
            operator: operator?,
            transfer: transfer?,
            canvas_width: scene.width,
            window,
            coverage: coverage.map(|coverage| window.cut(scene.width, coverage)),
            hidden: None,
            transmission: None,
            passed: Vec::new(),
            mean_passed: [1.0; 2],
            nearness: 0.0,
        })
    }

    /// Returns whether all of the canvas is in this layer.
    pub(super) fn is_only(&self) -> bool {
        self.coverage.is_none()
    }

    /// Returns the layer with the share of the `hidden` surfaces that is in it, a plane of the canvas.
    pub(super) fn with_hidden(self, hidden: &[f32], nearness: f32) -> Self {
        let hidden = self.cut(hidden);
        Self {
            hidden: hidden.iter().any(|share| *share > 0.0).then_some(hidden),
            nearness,
            ..self
        }
    }

    pub(super) fn nearness(&self) -> f32 {
        self.nearness
    }

    /// Returns the largest of those `values` of the canvas that there are where the layer covers it.
    pub(super) fn largest_covered(&self, values: &[Option<f32>]) -> Option<f32> {
        let coverage = self.coverage.as_ref()?;
        let rows = coverage.chunks_exact(self.window.width).enumerate();
        let covered = rows.flat_map(|(row, shares)| {
            let first = (self.window.row + row) * self.canvas_width + self.window.column;
            let pixels = values[first..].iter().zip(shares);
            pixels.filter_map(|(value, share)| value.filter(|_| *share > 0.0))
        });
        covered.max_by(f32::total_cmp)
    }

    /// Sets the `transmission` of the surfaces in front of the layer, a plane of the canvas. The `gains` of the operator follow it.
    ///
    /// # Errors
    /// Planes that are not of the canvas's size.
    pub(super) fn set_transmission(&mut self, transmission: &[f32], gains: &[f32]) -> Result<()> {
        let transmission = self.cut(transmission);
        let light = transmission
            .iter()
            .zip(self.cut(gains))
            .map(|(t, gain)| t * gain);
        let passed = self.operator.adjoint(&[light.collect()])?.swap_remove(0);
        let mean = |shares: &Option<Vec<f32>>| {
            let Some(shares) = shares else { return 1.0 };
            let pixels = || shares.iter().zip(&passed);
            let square: f32 = pixels().map(|(share, t)| (share * t).powi(2)).sum();
            let all: f32 = pixels().map(|(share, _)| share * share).sum();
            (square / all.max(f32::MIN_POSITIVE))
                .sqrt()
                .clamp(MIN_TRANSMISSION, 1.0)
        };
        self.mean_passed = [mean(&self.coverage), mean(&self.hidden)];
        self.passed = passed;
        self.transmission = Some(transmission);
        Ok(())
    }

    /// Blurs the light of `image` that is in this layer, and lets it pass what lies in front.
    pub(super) fn apply(&self, image: &[f32]) -> Result<Vec<f32>> {
        let [front, hidden] = self.planes(image);
        let mut light = self.cut(front);
        weight(&mut light, &self.coverage, 1.0);
        if let Some(shares) = &self.hidden {
            for ((light, behind), share) in light.iter_mut().zip(self.cut(hidden)).zip(shares) {
                *light += share * behind;
            }
        }
        let mut out = self.operator.apply(&[light])?.swap_remove(0);
        weight(&mut out, &self.transmission, 1.0);
        Ok(out)
    }

    /// Applies the transpose of [`Self::apply`].
    pub(super) fn adjoint(&self, plane: &[f32]) -> Result<LayerImage> {
        let mut light = self.cut(plane);
        weight(&mut light, &self.transmission, 1.0);
        let light = self.operator.adjoint(&[light])?.swap_remove(0);
        let hidden = self.hidden.is_some().then(|| {
            let mut hidden = light.clone();
            weight(&mut hidden, &self.hidden, 1.0);
            hidden
        });
        let mut front = light;
        weight(&mut front, &self.coverage, 1.0);
        Ok(LayerImage { front, hidden })
    }

    /// Returns the planes of an image: what is seen, and what is hidden.
    fn planes<'a>(&self, image: &'a [f32]) -> [&'a [f32]; 2] {
        if self.is_only() {
            return [image, &[]];
        }
        image.split_at(image.len() / 2).into()
    }

    /// Filters `plane` and weights the result by coverage ([`TransferFunctions::filter`]).
    pub(super) fn filter(
        &self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let mut out = (self.transfer).filter(&self.cut(plane), self.coverage.as_deref(), gain);
        weight(&mut out, &self.coverage, 1.0);
        out
    }

    /// Filters `plane` with the transfer functions of both layers, and weights the result by coverage
    /// ([`TransferFunctions::convert`]).
    pub(super) fn convert(
        &self,
        to: &Self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let (plane, coverage) = (self.cut(plane), self.coverage.as_deref());
        let mut out = (self.transfer).convert(&to.transfer, &plane, coverage, gain);
        weight(&mut out, &self.coverage, 1.0);
        out
    }

    /// Filters an image like [`Self::filter`], with the square root of coverage before and after: symmetric if `gain` is real.
    pub(super) fn filter_symmetrically(
        &self,
        image: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> LayerImage {
        let filter = |plane: &[f32], shares: &Option<Vec<f32>>, mean: f32| {
            let amplify = |plane: &mut [f32]| {
                weight(plane, shares, 0.5);
                for (sample, passed) in plane.iter_mut().zip(&self.passed) {
                    *sample /= passed.clamp(LEAST_PASSED * mean, 1.0);
                }
            };
            let mut light = self.cut(plane);
            amplify(&mut light);
            let gain = |h: Complex<f32>, power: f32| gain(h, power / (mean * mean));
            let mut out = (self.transfer).filter(&light, shares.as_deref(), gain);
            amplify(&mut out);
            out
        };
        let [front, hidden] = self.planes(image);
        let [of_front, of_hidden] = self.mean_passed;
        LayerImage {
            front: filter(front, &self.coverage, of_front),
            hidden: (self.hidden.is_some()).then(|| filter(hidden, &self.hidden, of_hidden)),
        }
    }

    /// Returns the correction of texture for `estimate`, on the canvas ([`texture_correction`]).
    pub(super) fn texture_correction(&self, estimate: &Estimate) -> Vec<f32> {
        let [image, residual, gradient_norms] =
            [estimate.image, estimate.residual, estimate.gradient_norms]
                .map(|plane| self.cut(plane));
        let estimate = Estimate {
            image: &image,
            residual: &residual,
            gradient_norms: &gradient_norms,
            deviation: estimate.deviation,
        };
        let size = (self.window.width, self.window.height);
        let mut out = texture_correction(&self.transfer, size, &estimate, self.coverage.as_deref());
        weight(&mut out, &self.coverage, 1.0);
        out
    }

    /// Returns means over frequencies, weighted by coverage ([`TransferFunctions::mean_over_frequencies`]).
    pub(super) fn mean_over_frequencies(
        &self,
        value: impl Fn(Complex<f32>, f32) -> f32 + Sync,
    ) -> Vec<f32> {
        let mut out = self.transfer.mean_over_frequencies(value);
        weight(&mut out, &self.coverage, 1.0);
        out
    }

    /// Adds a plane of the window to `canvas`.
    pub(super) fn add_to(&self, canvas: &mut [f32], plane: &[f32]) {
        self.add_scaled_to(canvas, plane, 1.0);
    }

    /// Adds `gain` times a plane of the window to `canvas`.
    pub(super) fn add_scaled_to(&self, canvas: &mut [f32], plane: &[f32], gain: f32) {
        let rows = canvas
            .chunks_exact_mut(self.canvas_width)
            .skip(self.window.row);
        for (out, row) in rows.zip(plane.chunks_exact(self.window.width)) {
            for (out, sample) in out[self.window.column..].iter_mut().zip(row) {
                *out += gain * sample;
            }
        }
    }

    /// Returns the window of a plane of the canvas.
    pub(super) fn cut(&self, plane: &[f32]) -> Vec<f32> {
        self.window.cut(self.canvas_width, plane)
    }
}

/// Multiplies a plane by `shares` to the power `exponent`; `None` stands for ones.
fn weight(plane: &mut [f32], shares: &Option<Vec<f32>>, exponent: f32) {
    if let Some(shares) = shares {
        for (sample, share) in plane.iter_mut().zip(shares) {
            *sample *= if exponent == 1.0 {
                *share
            } else {
                share.powf(exponent)
            };
        }
    }
}
