//! A depth layer of a canvas: the light at nearly one vergence, with the lens at that vergence.

use super::canvas::window_scene;
use super::lens_operator::Accuracy;
use super::ramp;
use super::texture::{Estimate, texture_correction};
use super::transfer_functions::{StopbandPower, TransferFunctions};
use crate::{Operator, Quality, RenderWindow, Scene, VergencePass, kernel_reach};
use seidel_fourier::Complex;
use seidel_optics::error::Result;

/// Differences of kernel size at which kernels count as unlike, and as alike. They are divided by the larger size plus one px.
const UNLIKE_KERNELS: [f32; 2] = [0.6, 0.3];

/// A layer, on the window of the canvas that its light reaches.
///
/// Its methods take planes of the canvas and return planes of the window.
pub(super) struct DepthLayer {
    draft: Operator,
    fine: Operator,
    transfer: TransferFunctions,
    /// Columns of the canvas.
    canvas_width: usize,
    window: RenderWindow,
    /// Share of each pixel of the window that is in this layer; `None` if all of the canvas is in it.
    coverage: Option<Vec<f32>>,
    /// Largest size of its kernels, px.
    size: f32,
    /// Share of the light at each pixel of the window that comes from this layer if all of the canvas is equally bright.
    light_share: Vec<f32>,
}

impl DepthLayer {
    /// Prepares the only layer of the canvas of `scene`, at one vergence, for a plane with these channel `weights`.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn only(scene: &Scene, weights: &[f64]) -> Result<Self> {
        Self::new(scene, weights, RenderWindow::whole(scene), None)
    }

    /// Prepares the layer at `vergence`, 1/m, whose `coverage` of the canvas lies within the window `covered`.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn at_vergence(
        scene: &Scene,
        weights: &[f64],
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
        Self::new(&scene, weights, window, Some(coverage))
    }

    fn new(
        scene: &Scene,
        weights: &[f64],
        window: RenderWindow,
        coverage: Option<&[f32]>,
    ) -> Result<Self> {
        let part = window_scene(scene, window);
        let operator = |quality| Operator::new(&part, &[weights.to_vec()], quality);
        let (draft, (fine, transfer)) = rayon::join(
            || operator(Quality::Draft),
            || {
                rayon::join(
                    || operator(Quality::Final),
                    || TransferFunctions::new(&part, weights),
                )
            },
        );
        Ok(Self {
            draft: draft?,
            fine: fine?,
            transfer: transfer?,
            canvas_width: scene.width,
            window,
            coverage: coverage.map(|coverage| window.cut(scene.width, coverage)),
            size: 0.0,
            light_share: Vec::new(),
        })
    }

    /// Returns whether all of the canvas is in this layer.
    pub(super) fn is_only(&self) -> bool {
        self.coverage.is_none()
    }

    /// Returns the layer with kernels of at most `size` px.
    pub(super) fn of_size(self, size: f32) -> Self {
        Self { size, ..self }
    }

    /// Sets the light shares to `uniform`, the light of a uniform canvas that this layer brings to the pixels of the window, times `gains`
    /// of the pixels of the canvas.
    pub(super) fn set_light_share(&mut self, uniform: Vec<f32>, gains: &[f32]) {
        let shares = uniform.iter().zip(self.cut(gains));
        self.light_share = shares.map(|(light, gain)| light * gain).collect();
    }

    /// Returns how much the kernels of another layer are like these, from 0 to 1.
    pub(super) fn likeness(&self, other: &Self) -> f32 {
        let difference = (self.size - other.size).abs() / (1.0 + self.size.max(other.size));
        ramp(difference, UNLIKE_KERNELS)
    }

    /// Adds `gain` times the light shares to a plane of the canvas.
    pub(super) fn add_light_share_to(&self, canvas: &mut [f32], gain: f32) {
        let shares: Vec<f32> = self.light_share.iter().map(|share| gain * share).collect();
        self.add_to(canvas, &shares);
    }

    /// Blurs the light of `plane` that is in this layer.
    pub(super) fn apply(&self, plane: &[f32], accuracy: Accuracy) -> Result<Vec<f32>> {
        let mut light = self.cut(plane);
        self.weight_by_coverage(&mut light, 1.0);
        let operator = match accuracy {
            Accuracy::Draft => &self.draft,
            Accuracy::Final => &self.fine,
        };
        Ok(operator.apply(&[light])?.swap_remove(0))
    }

    /// Applies the transpose of [`Self::apply`] with draft accuracy.
    pub(super) fn adjoint(&self, plane: &[f32]) -> Result<Vec<f32>> {
        let mut out = self.draft.adjoint(&[self.cut(plane)])?.swap_remove(0);
        self.weight_by_coverage(&mut out, 1.0);
        Ok(out)
    }

    /// Filters `plane` and weights the result by coverage ([`TransferFunctions::filter`]).
    pub(super) fn filter(
        &self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let mut out = (self.transfer).filter(&self.cut(plane), self.coverage.as_deref(), gain);
        self.weight_by_coverage(&mut out, 1.0);
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
        self.weight_by_coverage(&mut out, 1.0);
        out
    }

    /// Filters like [`Self::filter`], with the square root of coverage before and after: symmetric if `gain` is real.
    pub(super) fn filter_symmetrically(
        &self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let mut light = self.cut(plane);
        self.weight_by_coverage(&mut light, 0.5);
        let mut out = (self.transfer).filter(&light, self.coverage.as_deref(), gain);
        self.weight_by_coverage(&mut out, 0.5);
        out
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
        self.weight_by_coverage(&mut out, 1.0);
        out
    }

    /// Returns means over frequencies, weighted by coverage ([`TransferFunctions::mean_over_frequencies`]).
    pub(super) fn mean_over_frequencies(
        &self,
        value: impl Fn(Complex<f32>, f32) -> f32 + Sync,
    ) -> Vec<f32> {
        let mut out = self.transfer.mean_over_frequencies(value);
        self.weight_by_coverage(&mut out, 1.0);
        out
    }

    /// Returns the powers in the stopband of each usable tile ([`TransferFunctions::stopband_powers`]).
    pub(super) fn stopband_powers(
        &self,
        plane: &[f32],
        stopband_power: f32,
        min_frequencies: usize,
    ) -> Vec<StopbandPower> {
        self.transfer.stopband_powers(
            &self.cut(plane),
            self.coverage.as_deref(),
            stopband_power,
            min_frequencies,
        )
    }

    /// Adds a plane of the window to `canvas`.
    pub(super) fn add_to(&self, canvas: &mut [f32], plane: &[f32]) {
        let rows = canvas
            .chunks_exact_mut(self.canvas_width)
            .skip(self.window.row);
        for (out, row) in rows.zip(plane.chunks_exact(self.window.width)) {
            for (out, sample) in out[self.window.column..].iter_mut().zip(row) {
                *out += sample;
            }
        }
    }

    fn cut(&self, plane: &[f32]) -> Vec<f32> {
        self.window.cut(self.canvas_width, plane)
    }

    /// Multiplies a plane of the window by coverage to the power `exponent`.
    fn weight_by_coverage(&self, plane: &mut [f32], exponent: f32) {
        if let Some(coverage) = &self.coverage {
            for (sample, coverage) in plane.iter_mut().zip(coverage) {
                *sample *= if exponent == 1.0 {
                    *coverage
                } else {
                    coverage.powf(exponent)
                };
            }
        }
    }
}
