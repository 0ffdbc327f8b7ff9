//! The signed radius of the blur at each depth layer.

use super::super::depth_layers::DepthLayers;
use crate::Scene;
use seidel_optics::field::ImagePoint;

/// The signed radius of the blur at each layer: negative behind the plane of least blur.
pub(in super::super) struct SignedBlur {
    /// First layer coordinate.
    first: f32,
    radii_px: Vec<f64>,
    /// Short side of the frame, plate px.
    pub(super) frame_side_px: f32,
}

impl SignedBlur {
    /// Measures the blur of the first lens channel in the middle of the frame. The variance at the plane of least blur is
    /// that of aberrations, which move with no surface, and is taken off.
    pub(in super::super) fn new(scene: &Scene, layers: &DepthLayers) -> Self {
        let frame = scene.lens.frame();
        let (width, height) = (f64::from(frame.width_px()), f64::from(frame.height_px()));
        let middle = ImagePoint::new(width / 2.0, height / 2.0);
        let at = frame.field_point(middle);
        let variance = |layer: usize| {
            let lens = scene.lens;
            let moments = lens
                .unclamped_blur_at(0, at, layers.vergence(layer))
                .blur
                .moments;
            (moments.mu20 + moments.mu02) / 2.0 * scene.map.scale.powi(2)
        };
        let variances: Vec<f64> = (0..layers.len()).map(variance).collect();
        let least = variances.iter().copied().fold(f64::INFINITY, f64::min);
        let sharpest = variances.iter().position(|v| *v == least).unwrap_or(0);
        let radius = |(layer, variance): (usize, &f64)| {
            // Two standard deviations are the radius of an even disc.
            let radius = 2.0 * (variance - least).max(0.0).sqrt();
            if layer < sharpest { -radius } else { radius }
        };
        Self {
            first: layers.coordinate_of(0),
            radii_px: variances.iter().enumerate().map(radius).collect(),
            frame_side_px: (width.min(height) * scene.map.scale) as f32,
        }
    }

    /// Returns the radius at a layer coordinate, px.
    pub(super) fn radius_px(&self, coordinate: f32) -> f64 {
        let at = f64::from(coordinate - self.first).clamp(0.0, self.radii_px.len() as f64 - 1.0);
        let low = (at as usize).min(self.radii_px.len().saturating_sub(2));
        let share = at - low as f64;
        let high = self.radii_px[(low + 1).min(self.radii_px.len() - 1)];
        self.radii_px[low] * (1.0 - share) + high * share
    }
}
