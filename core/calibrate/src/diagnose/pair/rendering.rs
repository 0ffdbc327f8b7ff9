//! The sharp picture through the lens by the fast renderer.
//!
//! Its kernels are approximate: on fine texture it leaves about a thousandth of the contrast. Plates that it made are
//! compared with its own rendering, so that this error is no gap.

use super::PairImage;
use super::lens_view::{LensView, Positions};
use seidel_optics::Progress;
use seidel_optics::error::Result;
use seidel_optics::field::ImagePoint;
use seidel_optics::predict::Predictor;
use seidel_render::{
    Displacement, Edges, Gather, Plane, PlateMap, Quality, Renderer, Scene, VergencePass,
};

/// Renders `sharp` through the lens. Unknown pixels are dark: values within reach of them mean nothing.
///
/// # Errors
/// A lens that cannot be rendered, and cancellation.
pub(super) fn rendered(
    view: &LensView<'_>,
    lens: &Predictor,
    sharp: &PairImage<'_>,
    depth: Option<&[f32]>,
    progress: &Progress<'_>,
) -> Result<Vec<Vec<f32>>> {
    let known = |v: &f32| if v.is_finite() { *v } else { 0.0 };
    let known = |plane: &Vec<f32>| plane.iter().map(known).collect();
    let all: Vec<Vec<f32>> = sharp.planes.iter().map(known).collect();
    let scene = Scene {
        lens,
        model: lens.default_model(),
        width: sharp.width,
        height: sharp.height,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence: depth.map_or(
            VergencePass::Constant(view.vergence),
            VergencePass::PerPixel,
        ),
        edges: Edges::Mirror,
        displacement: match view.positions {
            Positions::Lens => Displacement::Full,
            Positions::Undistorted => Displacement::Lateral,
        },
    };
    let count = sharp.planes.len();
    let weights: Vec<Vec<f64>> = (0..count)
        .map(|own| (0..count).map(|k| f64::from(u8::from(k == own))).collect())
        .collect();
    let planes: Vec<Plane> = all
        .iter()
        .zip(&weights)
        .map(|(samples, weights)| Plane { samples, weights })
        .collect();
    let renderer = Gather {
        quality: Quality::Final,
        kernels: None,
    };
    let result = renderer.render(&scene, &planes, progress)?;
    Ok(result.planes)
}
