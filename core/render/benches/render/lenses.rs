//! The lens of the benchmarks: a skew-normal blur of a given size in the corners.

use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{LocalBlur, PHI};
use seidel_render::{BlurField, DisplacedBlur};

/// Relative blur sizes of R, G and B.
pub(crate) const STRENGTHS: [f64; 3] = [0.9, 1.0, 1.15];

/// Ratio of sigma in the centre to that in the corners.
pub(crate) const CENTRE: f64 = 1.0 / 6.0;

/// A zero-mean skew-normal of standard deviation max(0.5, c (S/6 + (S - S/6) rho²)) px along the
/// meridian and max(0.5, c (S/6 + (S/2 - S/6) rho²)) px across, with shape (3, 4, 5) rho and c = 0.9, 1,
/// 1.15 for R, G and B; rho is 1 in the corners and S the corner sigma.
pub(crate) struct SkewNormalLens {
    frame: Frame,
    corner_sigma_px: f64,
}

impl SkewNormalLens {
    pub(crate) fn new(frame: Frame, corner_sigma_px: f64) -> Self {
        Self {
            frame,
            corner_sigma_px,
        }
    }
}

impl BlurField for SkewNormalLens {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, _vergence_per_m: f64) -> DisplacedBlur {
        let rho = at.radius() / self.frame.corner_radius();
        let sigma = |edge: f64| {
            let share = CENTRE + (edge - CENTRE) * rho * rho;
            (STRENGTHS[channel] * self.corner_sigma_px * share).max(0.5)
        };
        let (radial, across) = (sigma(1.0), sigma(0.5));
        let alpha = [3.0, 4.0, 5.0][channel] * rho;
        let delta = alpha / (1.0 + alpha * alpha).sqrt();
        let skew = delta * radial / (1.0 - 2.0 * delta * delta / std::f64::consts::PI).sqrt();
        let meridian = at.meridian();
        let moments = MeridionalMoments {
            mu20: radial * radial,
            mu02: across * across,
            mu30: PHI * skew * skew * skew,
            mu12: 0.0,
        };
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
            displacement_px: (0.0, 0.0),
        }
    }
}
