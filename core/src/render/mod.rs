//! Putting a lens's blur on plates.
//!
//! Composition is a scatter: O(x) = sum over source pixels x' of I(x') P_x'(x - x'), the PSF being
//! that of the *source* pixel (docs/background/model.md 5c). Each source spreads its light with a unit-sum kernel,
//! so energy is kept.

mod adjusted;
mod depth_check;
mod depth_convention;
mod extended;
mod focus_range;
#[cfg(test)]
mod focus_range_tests;
mod gather;
mod layers;
mod local_kernel;
mod methods;
mod non_square;
#[cfg(test)]
mod non_square_tests;
mod reach;
mod scatter;
#[cfg(test)]
mod scatter_pupil_tests;
#[cfg(test)]
mod scatter_tests;
mod scene;
mod sheet;
mod sources;
mod spot;
#[cfg(test)]
mod spot_tests;
mod spots;
#[cfg(test)]
mod spots_tests;

pub use adjusted::{Adjusted, MOST_AMOUNT};
pub use depth_check::{DepthCheck, DepthProblem, Finding, LensReach, Severity, View};
pub use depth_convention::{DepthConvention, DepthReading};
pub use extended::Extended;
pub use focus_range::{FocusControls, FocusRange, MOST_MULTIPLIER, PlateExtent, focus_vergence};
pub use gather::{Gather, Operator, Quality};
pub(crate) use layers::Ladder;
pub use layers::{HIDDEN_REACH_PX, Holdout, Layered, Occlusion};
pub use local_kernel::{LocalKernel, LocalKernels};
pub use methods::{LevelMethods, Methods, Noted};
pub use non_square::{MOST_PIXEL_ASPECT, NonSquare};
pub(crate) use reach::{reach, reach_of_pass};
pub use scatter::Scatter;
pub use scene::{Displacement, Plane, Renderer, Scene, Window, stopped};
pub use spot::at_pixels;
pub use spots::{Spots, psnr_at, spread_pixels};

use crate::field::{FieldPoint, Frame, ImagePoint};
use crate::psf::LocalBlur;
use crate::sensor::Tone;

/// A lens as a renderer sees it: what it does to a point of light anywhere in field and depth.
pub trait BlurField: Sync {
    /// The lens's own full frame, in whose pixels blur and displacement are given.
    fn frame(&self) -> Frame;

    /// Number of colour channels.
    fn channel_count(&self) -> usize;

    /// Blur and displacement of `channel` at `at`, for an object at vergence `vergence_per_m` (1 /
    /// distance, 0 at infinity).
    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> PlacedBlur;

    /// How the sensor's pixel values of `channel` follow from light: the same everywhere. Renderers
    /// leave it to [`develop`].
    fn tone(&self, _channel: usize) -> Tone {
        Tone::default()
    }
}

/// Turns a rendered plane of light, in which white is one, into what the sensor behind `lens` records:
/// by the tone of each lens channel, weighed by the plane's channel `weights`. Coverage is not light:
/// alpha planes stay as they are.
pub fn develop(lens: &dyn BlurField, weights: &[f64], plane: &mut [f32]) {
    let shares = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
    let tones: Vec<_> = shares.map(|(k, w)| (lens.tone(k), *w)).collect();
    if tones.iter().all(|(tone, _)| tone.is_linear()) {
        return;
    }
    for sample in plane {
        let light = f64::from(*sample);
        *sample = tones
            .iter()
            .map(|(tone, w)| w * tone.of(light))
            .sum::<f64>() as f32;
    }
}

/// The blur of a point and where its centroid lands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedBlur {
    /// Moments in pixels of the lens's frame, without any pixel's area.
    pub blur: LocalBlur,
    /// Centroid less ideal position, pixels of the lens's frame (x, y).
    pub displacement_px: (f64, f64),
}

/// Where the pixels of a plate lie in the lens's frame. Plates whose pixels are not square are seen through a
/// [`NonSquare`] lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateMap {
    /// Lens-frame position of the plate's top-left outer corner.
    pub origin: ImagePoint,
    /// Plate pixels that make up one lens-frame pixel.
    pub scale: f64,
}

impl PlateMap {
    /// The map of a plate that begins (`columns`, `rows`) pixels further on, or before where these are negative.
    pub fn moved(&self, columns: f64, rows: f64) -> Self {
        Self {
            origin: ImagePoint::new(
                self.origin.x_px + columns / self.scale,
                self.origin.y_px + rows / self.scale,
            ),
            scale: self.scale,
        }
    }

    /// Lens-frame position of the centre of plate pixel (`column`, `row`).
    pub fn frame_point(&self, column: usize, row: usize) -> ImagePoint {
        ImagePoint::new(
            self.origin.x_px + (column as f64 + 0.5) / self.scale,
            self.origin.y_px + (row as f64 + 0.5) / self.scale,
        )
    }
}

/// Object vergence (1 / distance in metres) of every plate pixel.
#[derive(Debug, Clone, Copy)]
pub enum VergencePass<'a> {
    /// The whole plate at one vergence.
    Constant(f64),
    /// One value a pixel, row-major, finite.
    PerPixel(&'a [f32]),
}

/// What lies beyond the plate's edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Edges {
    /// The mirrored plate seen through the mirrored lens: light that would leave is folded back at
    /// the edge, so the plate keeps all its light.
    #[default]
    Mirror,
    /// Nothing: light that leaves is lost.
    Black,
}
