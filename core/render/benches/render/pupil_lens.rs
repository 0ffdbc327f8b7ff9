//! A ray-traced lens with blur of the same size as the skew-normal one.

use crate::lenses::{CENTRE, STRENGTHS};
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Wavefront};
use seidel_optics::psf::LocalBlur;
use seidel_render::{BlurField, DisplacedBlur};

/// Variance of the blur of each ray, px².
const RAY_VARIANCE_PX2: f64 = 0.1;

/// A defocused third-order lens with field curvature, astigmatism, coma and some spherical aberration.
///
/// In the corners its standard deviation along the meridian is that of the skew-normal lens, in the centre about a sixth
/// of it.
pub(crate) struct PupilLens {
    frame: Frame,
    numbers: [ReducedNumbers; 3],
}

impl PupilLens {
    pub(crate) fn new(frame: Frame, corner_sigma_px: f64) -> Self {
        let corner = frame.corner_radius();
        // Of unit corner size up to a factor that follows from the moments.
        let shape = ReducedNumbers {
            alpha: 2.0 * CENTRE,
            beta: 0.2 * CENTRE,
            gamma: 0.6 / (corner * corner),
            delta: 0.9 / (corner * corner),
            phi: -0.15 / corner,
        };
        let across = FieldPoint::new(corner, 0.0);
        let drawn = blur_of(&shape, across).moments.mu20 - RAY_VARIANCE_PX2;
        let numbers = STRENGTHS.map(|strength| {
            let size = strength * corner_sigma_px / drawn.sqrt();
            ReducedNumbers {
                alpha: size * shape.alpha,
                beta: size * shape.beta,
                gamma: size * shape.gamma,
                delta: size * shape.delta,
                phi: size * shape.phi,
            }
        });
        Self { frame, numbers }
    }
}

fn blur_of(numbers: &ReducedNumbers, at: FieldPoint) -> LocalBlur {
    let pupil = LocalPupil::circular(Wavefront::third_order(numbers, at), RAY_VARIANCE_PX2);
    LocalBlur::from_pupil(pupil, at.meridian())
}

impl BlurField for PupilLens {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, _vergence_per_m: f64) -> DisplacedBlur {
        DisplacedBlur {
            blur: blur_of(&self.numbers[channel], at),
            displacement_px: (0.0, 0.0),
        }
    }
}
