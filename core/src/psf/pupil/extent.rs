//! Where the rays of a pupil land, and how fine a mesh and how large a kernel that asks for.

use super::Detail;
use crate::lens::{LEAST_REACH, LocalPupil};
use crate::psf::Reach;

/// Rings per root of the extent's radius (px): keeps the rim's polygon within a fiftieth of a pixel.
const RIM_FINENESS: f64 = 2.7;
/// Least number of rings, and the largest that is ever needed by what can be drawn, and by what fits.
const LEAST_RINGS: usize = 8;
const MOST_RINGS: usize = 1000;
const MOST_FIT_RINGS: usize = 120;

/// The box about the chief ray in which rays land, px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
    /// Largest second derivative of the landing point by the pupil point, px.
    bend: f64,
}

impl Extent {
    pub(super) fn of(pupil: &LocalPupil) -> Self {
        const ANGLES: usize = 24;
        let (centre, depth) = pupil.inside();
        let first = pupil.landing(centre);
        let mut extent = Self {
            low: first,
            high: first,
            bend: 0.0,
        };
        for k in 0..ANGLES {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / ANGLES as f64).sin_cos();
            let reach = if depth > LEAST_REACH {
                pupil.edge(centre, cos, sin).0
            } else {
                LEAST_REACH
            };
            let rim = [centre[0] + reach * cos, centre[1] + reach * sin];
            extent.bend = extent.bend.max(pupil.wavefront.bend(rim));
            for share in [0.3, 0.55, 0.75, 0.9, 1.0] {
                let r = reach * share;
                let p = pupil.landing([centre[0] + r * cos, centre[1] + r * sin]);
                extent.low = [0, 1].map(|axis| extent.low[axis].min(p[axis]));
                extent.high = [0, 1].map(|axis| extent.high[axis].max(p[axis]));
            }
        }
        extent
    }

    /// The box about `centroid` that holds all light.
    pub(super) fn reach(&self, centroid: [f64; 2], blur_variance_px2: f64) -> Reach {
        // What the extent's few rays missed, the blur, and the pixel of the outermost ray.
        let margin = 0.04 * self.radius() + 5.0 * blur_variance_px2.sqrt() + 0.5;
        Reach {
            left_px: centroid[0] - self.low[0] + margin,
            right_px: self.high[0] - centroid[0] + margin,
            up_px: centroid[1] - self.low[1] + margin,
            down_px: self.high[1] - centroid[1] + margin,
        }
    }

    /// Half the larger side, px.
    pub(super) fn radius(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1]) / 2.0
    }

    /// Rings of the mesh. Within a triangle the map is taken as linear: what matters is how much it
    /// bends, and how round the rim is.
    pub(super) fn rings(&self, detail: Detail) -> usize {
        let inside = detail.0 * self.bend.sqrt();
        let rim = RIM_FINENESS * self.radius().sqrt();
        let most = if detail == Detail::FULL {
            MOST_RINGS
        } else {
            MOST_FIT_RINGS
        };
        (inside.max(rim).ceil() as usize).clamp(LEAST_RINGS, most)
    }

    /// Cells per pixel on which light is spread before it is blurred: more where the picture has
    /// detail within a pixel and there is a blur that would see it.
    pub(super) fn cells_per_pixel(&self, blur_variance_px2: f64) -> usize {
        if blur_variance_px2 <= 0.0 || blur_variance_px2 > 4.0 {
            1
        } else if self.radius() < 3.0 {
            4
        } else if self.radius() < 16.0 {
            2
        } else {
            1
        }
    }
}
