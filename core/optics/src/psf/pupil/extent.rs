//! Where the rays of a pupil land, and how fine a mesh and how large a kernel that asks for.

use super::{Detail, wave};
use crate::lens::{LocalPupil, PINHOLE_RADIUS};
use crate::psf::KernelBounds;

/// Rings per root of the extent's radius (px): keeps the rim's polygon within a fiftieth of a pixel.
const RIM_FINENESS: f64 = 2.7;
/// Least number of rings, and the largest that is ever needed by what can be drawn, and by what fits.
const LEAST_RINGS: usize = 8;
const MOST_RINGS: usize = 1000;
const MOST_FIT_RINGS: usize = 120;
/// Share of the light beyond a kernel that is let go, for waves and for a halo; a kernel's sum is one
/// all the same.
const LEFT_OUT: f64 = 0.005;
/// Share of a point's light that waves carry out of a box of half width r, in q over r and the pupil's
/// narrowest half width: a round pupil sends 1 / pi² beyond a circle, times
/// 2 sqrt(2) / pi for the square about it; others send by their edge's length over their area.
const WAVES_BEYOND: f64 = 0.0912;
/// Farthest that waves and a halo are drawn beyond the rays, px.
const FARTHEST_PX: f64 = 200.0;

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
        let (centre, depth) = pupil.inscribed_circle();
        let first = pupil.landing(centre);
        let mut extent = Self {
            low: first,
            high: first,
            bend: 0.0,
        };
        for k in 0..ANGLES {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / ANGLES as f64).sin_cos();
            let reach = if depth > PINHOLE_RADIUS {
                pupil.edge(centre, cos, sin).0
            } else {
                PINHOLE_RADIUS
            };
            let rim = [centre[0] + reach * cos, centre[1] + reach * sin];
            extent.bend = extent.bend.max(pupil.wavefront.third_derivative_norm(rim));
            for share in [0.3, 0.55, 0.75, 0.9, 1.0] {
                let r = reach * share;
                let p = pupil.landing([centre[0] + r * cos, centre[1] + r * sin]);
                extent.low = [0, 1].map(|axis| extent.low[axis].min(p[axis]));
                extent.high = [0, 1].map(|axis| extent.high[axis].max(p[axis]));
            }
        }
        extent
    }

    /// The box about `centroid` that holds all light of `pupil`: but for at most [`LEFT_OUT`] each that
    /// waves and a halo carry beyond, or more where they go farther than [`FARTHEST_PX`].
    pub(super) fn reach(&self, pupil: &LocalPupil, centroid: [f64; 2]) -> KernelBounds {
        // What the extent's few rays missed, the blur, and the pixel of the outermost ray.
        let margin =
            (pupil.blur_variances_px2()).map(|v| 0.04 * self.radius() + 5.0 * v.sqrt() + 0.5);
        let half_width = wave::half_width(pupil);
        let [across, down] = [0, 1].map(|axis| {
            let waves = half_width.map_or(0.0, |half_width| {
                let unit = pupil.wave_px * pupil.squeeze[axis].abs() / half_width;
                (WAVES_BEYOND / LEFT_OUT * unit).min(FARTHEST_PX)
            });
            let stretch = [pupil.sensor.halo.stretch_x, 1.0][axis];
            let halo = stretch * pupil.sensor.halo.radius_holding(LEFT_OUT);
            let halo = halo.min(FARTHEST_PX);
            margin[axis] + waves + halo + pupil.sensor.reach_px()[axis]
        });
        KernelBounds {
            left_px: centroid[0] - self.low[0] + across,
            right_px: self.high[0] - centroid[0] + across,
            up_px: centroid[1] - self.low[1] + down,
            down_px: self.high[1] - centroid[1] + down,
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
