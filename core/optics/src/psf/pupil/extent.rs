//! The extent of the rays of a pupil, and the mesh resolution and kernel size that follow from it.

use super::Detail;
use crate::lens::{LocalPupil, PINHOLE_RADIUS, Shadow};
use crate::psf::KernelBounds;

/// Rings per square root of the radius of the extent (px): keeps the polygon of the rim within a fiftieth of a pixel.
const RIM_FINENESS: f64 = 2.7;
/// The same for kernels that are interpolated: within a seventeenth of a pixel.
const INTERPOLATED_RIM_FINENESS: f64 = 1.6;
/// Smallest number of rings, for kernels that are interpolated and for others, and the largest for [`Detail::FULL`] and for other details.
const LEAST_INTERPOLATED_RINGS: usize = 5;
const LEAST_RINGS: usize = 8;
const MOST_RINGS: usize = 1000;
const MOST_FIT_RINGS: usize = 120;
/// Largest number of rings for a picture of the aperture; below it, one for each pixel of the radius.
const PICTURE_RINGS: f64 = 48.0;
/// Share of the light outside a kernel that is dropped, each for diffraction and for a halo; kernels sum to one all
/// the same.
const LEFT_OUT: f64 = 0.005;
/// Share of the light that diffraction carries out of a box of half width r, times r and the smallest half width of the
/// pupil over q.
///
/// A round pupil carries 1 / pi² out of a circle, and 2 sqrt(2) / pi of that out of the square about it. For other
/// pupils it is proportional to the length of the edge over the area.
const DIFFRACTED_SHARE: f64 = 0.0912;
/// Largest distance from the rays to which diffraction and a halo are drawn, px.
const FARTHEST_PX: f64 = 200.0;
/// Largest radius of the rays that is drawn with diffraction, px. Pixels hide its fringes in a larger PSF.
const MOST_RADIUS_PX: f64 = 1024.0;

/// The box about the chief ray that holds the landing points of all rays, px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
    /// Largest second derivative of the landing point by the pupil point, px.
    second_derivative: f64,
    /// Whether the mesh must be fine enough for a picture of the aperture.
    has_picture: bool,
}

impl Extent {
    pub(super) fn of(pupil: &LocalPupil) -> Self {
        const ANGLES: usize = 24;
        let (centre, depth) = pupil.inscribed_circle();
        let first = pupil.landing(centre);
        let mut extent = Self {
            low: first,
            high: first,
            second_derivative: 0.0,
            has_picture: pupil.transmission.picture.is_some(),
        };
        for k in 0..ANGLES {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / ANGLES as f64).sin_cos();
            let reach = if depth > PINHOLE_RADIUS {
                pupil.edge(centre, cos, sin).0
            } else {
                PINHOLE_RADIUS
            };
            let rim = [centre[0] + reach * cos, centre[1] + reach * sin];
            extent.second_derivative = extent
                .second_derivative
                .max(pupil.wavefront.third_derivative_norm(rim));
            for share in [0.3, 0.55, 0.75, 0.9, 1.0] {
                let r = reach * share;
                let p = pupil.landing([centre[0] + r * cos, centre[1] + r * sin]);
                extent.low = [0, 1].map(|axis| extent.low[axis].min(p[axis]));
                extent.high = [0, 1].map(|axis| extent.high[axis].max(p[axis]));
            }
        }
        extent
    }

    /// Returns the box about `centroid` that holds the light of `pupil`.
    ///
    /// Diffraction and a halo may each leave out [`LEFT_OUT`], or more if they extend beyond [`FARTHEST_PX`].
    pub(super) fn kernel_bounds(&self, pupil: &LocalPupil, centroid: [f64; 2]) -> KernelBounds {
        // Rays between those traced, the blur, and the pixel of the outermost ray.
        let margin =
            (pupil.blur_variances_px2()).map(|v| 0.04 * self.radius() + 5.0 * v.sqrt() + 0.5);
        let half_width = half_width(pupil, self);
        let [across, down] = [0, 1].map(|axis| {
            let waves = half_width.map_or(0.0, |half_width| {
                let unit = pupil.wave_px * pupil.squeeze[axis].abs() / half_width;
                (DIFFRACTED_SHARE / LEFT_OUT * unit).min(FARTHEST_PX)
            });
            let stretch = [pupil.sensor.halo.stretch_x, 1.0][axis];
            let halo = stretch * pupil.sensor.halo.radius_holding(LEFT_OUT);
            let halo = halo.min(FARTHEST_PX);
            margin[axis] + waves + halo + pupil.sensor.blur_radius_px()[axis]
        });
        KernelBounds {
            left_px: centroid[0] - self.low[0] + across,
            right_px: self.high[0] - centroid[0] + across,
            up_px: centroid[1] - self.low[1] + down,
            down_px: self.high[1] - centroid[1] + down,
        }
    }

    /// Returns half the larger side, px.
    pub(super) fn radius(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1]) / 2.0
    }

    /// Returns the number of rings of the mesh, from the second derivative of the ray map and the size of the rim.
    pub(super) fn rings(&self, detail: Detail) -> usize {
        let inside = detail.0 * self.second_derivative.sqrt();
        let (rim_fineness, least) = if detail == Detail::INTERPOLATED {
            (INTERPOLATED_RIM_FINENESS, LEAST_INTERPOLATED_RINGS)
        } else {
            (RIM_FINENESS, LEAST_RINGS)
        };
        let mut rim = rim_fineness * self.radius().sqrt();
        if self.has_picture {
            rim = rim.max(self.radius().min(PICTURE_RINGS));
        }
        let most = if detail == Detail::FULL {
            MOST_RINGS
        } else {
            MOST_FIT_RINGS
        };
        (inside.max(rim).ceil() as usize).clamp(least, most)
    }

    /// Returns the number of cells along a pixel's side for rasterisation before the blur: more for a small PSF with
    /// a blur narrow enough to keep detail within a pixel. Without it less than a thousandth of the light of a PSF of some pixels
    /// moves, less than interpolation moves.
    pub(super) fn cells_per_pixel(&self, blur_variance_px2: f64, detail: Detail) -> usize {
        if blur_variance_px2 <= 0.0 || blur_variance_px2 > 4.0 {
            1
        } else if self.radius() < 3.0 {
            4
        } else if self.radius() < 16.0 && detail != Detail::INTERPOLATED {
            2
        } else {
            1
        }
    }
}

/// Returns the smallest half width of the pupil in pupil radii, at least 0.1; `None` if it is drawn by rays.
///
/// An almost closed pupil is drawn by rays as well: the diffraction of a pinhole would have no bounds. So are rays over more than
/// [`MOST_RADIUS_PX`], to which a step of a search may lead: the period that holds them would fill the memory.
pub(super) fn half_width(pupil: &LocalPupil, extent: &Extent) -> Option<f64> {
    let diffracts = pupil.diffracts() && extent.radius() <= MOST_RADIUS_PX;
    let depth = if diffracts {
        pupil.inscribed_circle().1
    } else {
        0.0
    };
    // A ring diffracts by its length of edge over its area, as a circle of its width does.
    let width = match pupil.shadow() {
        Some(Shadow::Ring(disc)) if diffracts => depth - disc.radius,
        _ => depth,
    };
    (depth > PINHOLE_RADIUS).then_some(width.max(0.1))
}
