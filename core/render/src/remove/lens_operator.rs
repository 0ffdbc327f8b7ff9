//! The lens on a canvas as a linear operator A, with its adjoint and filters that approximate its inverse.
//!
//! Where depth varies, an image has two planes: x, what each pixel of the canvas shows, and y, the surface that is hidden behind
//! it beside depth edges (`hidden_surface`). The canvas is cut into layers j of one vergence each, and
//!
//! ```text
//! A (x, y) = G Σ T_j A_j (c_j x + d_j y)
//! ```
//!
//! The coverages c_j and d_j are the shares of each pixel in layer j: hat functions of the layer coordinate of the surface in front
//! and of the one behind. A_j is the lens at the vergence of the layer. The transmission T_j is the light that passes the surfaces
//! in front of layer j, 1 - Σ A_k c_k over all layers k that are nearer by a depth edge: those of one inclined surface do not hide
//! each other. The normalisation G is diagonal and makes A preserve uniform light.

use super::canvas::Canvas;
use super::depth_layer::{DepthLayer, LayerImage};
use super::gradient::{LinkedPlane, norms};
use super::layer_cut::{Depth, LayerCut};
use super::ramp;
use super::texture::Estimate;
use super::transfer_functions::Purpose;
use crate::{Edges, Scene, VergencePass};
use seidel_fourier::Complex;
use seidel_optics::error::Result;

/// Shares of light from behind a depth edge or hidden by it, from which a pixel begins to count as one of the edge and does so wholly.
const EDGE_LIGHT: [f32; 2] = [0.05, 0.15];

/// The lens on a canvas.
pub(super) struct LensOperator {
    layers: Vec<DepthLayer>,
    /// Columns and rows of the canvas.
    size: (usize, usize),
    /// `None` if all of the canvas is at one vergence.
    depth: Option<Depth>,
}

impl LensOperator {
    /// Prepares the operator on the `canvas` of `scene`, for a plane with these channel `weights`.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn new(scene: &Scene, canvas: &Canvas, weights: &[f64]) -> Result<Self> {
        Self::for_purpose(Purpose::Filter, scene, canvas, weights)
    }

    /// Prepares the operator like [`Self::new`], with transfer functions for another purpose.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub(super) fn for_purpose(
        purpose: Purpose,
        scene: &Scene,
        canvas: &Canvas,
        weights: &[f64],
    ) -> Result<Self> {
        let canvas_scene = Scene {
            edges: Edges::Black,
            ..canvas.scene(scene, None)
        };
        let size = canvas.size();
        let VergencePass::PerPixel(pass) = scene.vergence else {
            return Ok(Self {
                layers: vec![DepthLayer::only(&canvas_scene, weights, purpose)?],
                size,
                depth: None,
            });
        };
        let pass = canvas.extend_by_replication(pass);
        let cut = LayerCut::new(&canvas_scene, &pass);
        let mut layers = cut.layers(&canvas_scene, weights, purpose)?;
        let depth = cut.depth(&mut layers, size)?;
        Ok(Self {
            layers,
            size,
            depth: Some(depth),
        })
    }

    /// Applies A: blurs an image. Behind depth edges, a plane of the canvas is black.
    ///
    /// # Errors
    /// An image that is not of the canvas's size.
    pub(super) fn apply(&self, image: &[f32]) -> Result<Vec<f32>> {
        let count = self.size.0 * self.size.1;
        if self.depth.is_some() && image.len() == count {
            let mut padded = image.to_vec();
            padded.resize(2 * count, 0.0);
            return self.apply(&padded);
        }
        let mut out = self.sum_of_layers(|layer| layer.apply(image))?;
        self.normalise(&mut out);
        Ok(out)
    }

    /// Applies Aᵀ to a plane of the canvas.
    ///
    /// # Errors
    /// A plane that is not of the canvas's size.
    pub(super) fn adjoint(&self, mut plane: Vec<f32>) -> Result<Vec<f32>> {
        self.normalise(&mut plane);
        self.image_of_layers(|layer| layer.adjoint(&plane))
    }

    /// Returns the image that shows `plane`, and behind depth edges its continuation.
    pub(super) fn image(&self, mut plane: Vec<f32>) -> Vec<f32> {
        if let Some(depth) = &self.depth {
            let behind = |k: usize| plane[depth.surface.source(k).unwrap_or(k)];
            let behind: Vec<f32> = (0..plane.len()).map(behind).collect();
            plane.extend(behind);
        }
        plane
    }

    /// Returns 1 for pixels with much light from behind a depth edge, or much that one hides, 0 for those without, and shares between.
    pub(super) fn edge_shares(&self) -> Vec<f32> {
        let light = self.depth.as_ref().map(|depth| &depth.edge_light);
        light.map_or_else(
            || vec![0.0; self.size.0 * self.size.1],
            |light| light.iter().map(|v| ramp(*v, EDGE_LIGHT)).collect(),
        )
    }

    /// Returns whether a pixel of the canvas lies at a depth edge. Its light is a mixture of surfaces, and its depth that of one.
    pub(super) fn is_at_edge(&self, pixel: usize) -> bool {
        let depth = self.depth.as_ref();
        depth.is_some_and(|depth| depth.surface.is_at_edge(pixel))
    }

    /// Returns the surfaces of an image one above the other: those in front, and those behind.
    pub(super) fn stack(&self, image: &[f32]) -> Vec<f32> {
        let mut stacked = image.to_vec();
        if let Some(depth) = &self.depth {
            let (front, hidden) = image.split_at(image.len() / 2);
            let back = depth.surface.back(front, hidden);
            stacked.truncate(front.len());
            stacked.extend(back);
        }
        stacked
    }

    /// Applies the transpose of [`Self::stack`].
    pub(super) fn unstack(&self, mut stacked: Vec<f32>) -> Vec<f32> {
        if let Some(depth) = &self.depth {
            let count = stacked.len() / 2;
            let (front, back) = stacked.split_at_mut(count);
            for k in 0..count {
                if depth.surface.source(k).is_none() {
                    front[k] += std::mem::take(&mut back[k]);
                }
            }
        }
        stacked
    }

    /// Returns a stacked image with the links between its pixels.
    pub(super) fn linked<'a>(&'a self, stacked: &'a [f32]) -> LinkedPlane<'a> {
        LinkedPlane {
            samples: stacked,
            width: self.size.0,
            links: self.depth.as_ref().map(|depth| &depth.links),
        }
    }

    /// Filters `plane` by `gain(h, |D|²)` on local spectra, each pixel by the transfer functions h of its own layer.
    pub(super) fn filter(
        &self,
        plane: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        self.sum_of_layers(|layer| Ok(layer.filter(plane, &gain)))
    }

    /// Returns whether the canvas has depth edges.
    pub(super) fn has_edges(&self) -> bool {
        let depth = self.depth.as_ref();
        depth.is_some_and(|depth| depth.surface.has_hidden())
    }

    /// Returns whether all of the canvas is at one vergence.
    pub(super) fn is_flat(&self) -> bool {
        self.depth.is_none()
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

    /// Filters an image like [`Self::filter`], as a symmetric operator if `gain` is real: a preconditioner. Transfer functions are
    /// those of the light that passes what lies in front.
    pub(super) fn precondition(
        &self,
        image: &[f32],
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        self.image_of_layers(|layer| Ok(layer.filter_symmetrically(image, &gain)))
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
            gradient_norms: &norms(LinkedPlane::plain(image, self.size.0)),
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

    /// Adds up `image_of` each layer like [`Self::sum_of_layers`].
    fn image_of_layers(
        &self,
        image_of: impl Fn(&DepthLayer) -> Result<LayerImage>,
    ) -> Result<Vec<f32>> {
        if let [layer] = self.layers.as_slice()
            && layer.is_only()
        {
            return Ok(image_of(layer)?.front);
        }
        let count = self.size.0 * self.size.1;
        let mut out = vec![0.0; 2 * count];
        for layer in &self.layers {
            let image = image_of(layer)?;
            let (front, hidden) = out.split_at_mut(count);
            layer.add_to(front, &image.front);
            if let Some(light) = &image.hidden {
                layer.add_to(hidden, light);
            }
        }
        Ok(out)
    }

    fn normalise(&self, plane: &mut [f32]) {
        if let Some(depth) = &self.depth {
            for (sample, gain) in plane.iter_mut().zip(&depth.gains) {
                *sample *= gain;
            }
        }
    }
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
            let image = operator.image(vec![0.0; count]).len();
            let (x, y) = (deviates.plane(image), deviates.plane(count));
            let blurred = operator.apply(&x);
            let blurred = blurred.expect("a plane of the canvas");
            let back = operator.adjoint(y.clone()).expect("a plane of the canvas");
            let scale = (dot(&blurred, &blurred) * dot(&y, &y)).sqrt();
            assert!((dot(&blurred, &y) - dot(&x, &back)).abs() < 1e-5 * scale);
        }
    }

    /// A surface in front hides all light from behind, farther from its edge than kernels reach.
    #[test]
    fn what_is_hidden_does_not_shine_through() {
        let lens = lens(2.0);
        let is_near = |k: usize| k % WIDTH < 110;
        let pass: Vec<f32> = (0..WIDTH * HEIGHT)
            .map(|k| if is_near(k) { 0.6 } else { 0.0 })
            .collect();
        let scene = Scene {
            vergence: VergencePass::PerPixel(&pass),
            ..scene(&lens)
        };
        let canvas = Canvas::new(&scene);
        let operator = LensOperator::new(&scene, &canvas, &WEIGHTS).expect("a valid lens");
        let light = |k: usize| if is_near(k) { 0.2 } else { 1.0 };
        let plane: Vec<f32> = (0..WIDTH * HEIGHT).map(light).collect();
        let image = operator.image(canvas.extend_by_replication(&plane));
        let blurred = canvas.crop(&operator.apply(&image).expect("a plane of the canvas"));
        for (k, sample) in blurred.iter().enumerate() {
            assert!(
                k % WIDTH > 85 || (sample - 0.2).abs() < 1e-4,
                "{k}: {sample}"
            );
        }
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
        let uniform = operator.image(vec![0.7; canvas.size().0 * canvas.size().1]);
        let blurred = operator.apply(&uniform);
        let blurred = canvas.crop(&blurred.expect("a plane of the canvas"));
        assert!(blurred.iter().all(|v| (v - 0.7).abs() < 1e-4));
    }
}
