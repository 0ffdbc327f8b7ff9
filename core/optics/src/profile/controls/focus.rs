//! A lens focused at another distance: its sensor moves, and each plane of symmetry stays in focus.

use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::{Error, ErrorKind, Result};
use crate::field::{FieldPoint, Frame};
use crate::lens::VergenceSeries;
use crate::profile::PupilChannel;
use crate::sharpest_plane::{nearby_sharpest_vergence, sharpest_vergence};

/// Distance from the stated focus, in offsets of the sharpest plane from it, beyond which a focus distance is that of the
/// sharpest plane.
const OFFSET_REACH: f64 = 4.0;
/// Corrections of the focus after the first, each of which leaves a small share of the error.
const CORRECTIONS: usize = 3;
/// Error of the focus that needs no correction, 1/m.
const FOCUS_TOLERANCE: f64 = 1e-7;

/// Returns the vergence at which the lens is sharpest on its axis, 1/m; `None` if its defocus does not depend on vergence.
pub(super) fn sharpest(channels: &[PupilChannel]) -> Option<f64> {
    let depends = channels.iter().all(PupilChannel::depends_on_vergence);
    depends.then(|| sharpest_vergence(|v| variance(channels, v)))?
}

/// Returns the sum over channels of the variance of the blur on the axis, px².
fn variance(channels: &[PupilChannel], v: f64) -> f64 {
    let axis = FieldPoint::new(0.0, 0.0);
    let all = channels.iter().map(|c| c.moments_at(axis, v).trace());
    all.sum()
}

/// Focuses a lens at `distance`.
///
/// The focus distance that `camera` states leaves the lens as it is. It may be a little off the sharpest plane: this offset
/// shrinks to nothing for distances farther from the stated one, so that a pull of focus has no step.
pub(super) fn set(
    channels: &mut [PupilChannel],
    distance: ObjectDistance,
    camera: &Camera,
    focused: &FocusedCamera,
) -> Result<()> {
    let wanted = known_vergence(distance)?;
    let stated = camera.focus_distance.vergence_per_m();
    if stated == Some(wanted) {
        return Ok(());
    }
    let old = sharpest(channels).ok_or_else(unfocusable)?;
    let offset = stated.map_or(0.0, |stated| {
        let (offset, away) = (old - stated, (wanted - stated).abs());
        offset * (1.0 - away / (OFFSET_REACH * offset.abs())).max(0.0)
    });
    shift(channels, old, wanted + offset, focused)
}

/// Returns the vergence of a focus distance.
fn known_vergence(distance: ObjectDistance) -> Result<f64> {
    distance.vergence_per_m().ok_or_else(|| {
        Error::new(
            "focus distance",
            "is unknown",
            "give metres from the entrance pupil, or infinity",
        )
    })
}

fn unfocusable() -> Error {
    Error::new(
        "focus distance",
        "cannot be set: the lens was measured at one object distance, so the change of defocus is unknown",
        "fit the lens to two or more object distances",
    )
    .with_kind(ErrorKind::Unsupported)
}

/// Moves the sharpest plane of the axis from vergence `old` to `new`, 1/m.
///
/// Every channel and every plane of symmetry has there the defocus that it had, in the scale of the new image distance.
/// Aberrations stay functions of the object's distance, but for the coma of [`FocusedCamera::sine_condition_coma`].
pub(super) fn shift(
    channels: &mut [PupilChannel],
    old: f64,
    new: f64,
    camera: &FocusedCamera,
) -> Result<()> {
    let ratio = match camera.focal_length_m {
        Some(f_m) => image_distance_ratio(f_m, old, new)?,
        None => 1.0,
    };
    let coma = |v| camera.sine_condition_coma(v).unwrap_or(0.0);
    let less_coma = coma(old) - coma(new);
    let measured = channels.to_vec();
    // Aberrations may vary with vergence, and the sharpest plane with them.
    let mut aim = new;
    for _ in 0..=CORRECTIONS {
        for (channel, measured) in channels.iter_mut().zip(&measured) {
            let moved = |series: &VergenceSeries| {
                let at = |v| series.linear_beyond(measured.measured_vergence, v);
                ratio * (at(aim) - at(old))
            };
            let shifts: Vec<f64> = measured.defocus_series().map(moved).collect();
            *channel = measured.clone();
            channel.set_image_distance(ratio);
            for (series, by) in channel.defocus_series_mut().zip(shifts) {
                series.coefficients[0] -= by;
            }
            channel.phi.coefficients[0] -= less_coma;
        }
        let error = nearby_sharpest_vergence(|v| variance(channels, v), new) - new;
        if error.abs() < FOCUS_TOLERANCE {
            break;
        }
        aim -= error;
    }
    Ok(())
}

/// The numbers of a camera that the law of focus uses.
pub(super) struct FocusedCamera {
    focal_length_m: Option<f64>,
    f_number: Option<f64>,
    half_width_px: f64,
}

impl FocusedCamera {
    pub(super) fn new(camera: &Camera, frame: Frame) -> Self {
        Self {
            focal_length_m: camera.focal_length_mm.map(|f_mm| f_mm * 1e-3),
            f_number: camera.f_number,
            half_width_px: frame.half_width_px(),
        }
    }

    /// Returns the coma of a sensor at the focus of vergence `v`, px as [`PupilChannel::phi`]: w q² / 4, with half the frame width w
    /// and the slope q of the rim ray on the axis.
    ///
    /// Behind a lens without coma, rays of even spacing in the pupil have sines of even spacing (Abbe's sine condition). The
    /// sensor meets their tangents: beside a chief ray of slope t they differ from evenness by (t·q) q + q² t / 2 to third
    /// order. So a sensor that moves by ds gains the coma ds q² t / 2, where q and t fall with the image distance.
    fn sine_condition_coma(&self, v: f64) -> Option<f64> {
        let slope = (1.0 - self.focal_length_m? * v) / (2.0 * self.f_number?);
        Some(self.half_width_px * slope * slope / 4.0)
    }
}

/// Returns Z2 of a thin lens focused at vergence `new` over that at vergence `old`.
fn image_distance_ratio(f_m: f64, old: f64, new: f64) -> Result<f64> {
    let reach = 1.0 - f_m * new;
    if reach <= 0.0 {
        return Err(Error::new(
            "focus distance",
            format!("is {} m, within the focal length of {f_m} m", 1.0 / new),
            "focus farther away",
        ));
    }
    let measured = 1.0 - f_m * old;
    if measured <= 0.0 {
        return Err(Error::new(
            "camera.focal_length_mm",
            format!(
                "is {} although the lens was found to focus at {} m",
                f_m * 1e3,
                1.0 / old
            ),
            "correct it in the lens profile",
        ));
    }
    Ok(measured / reach)
}
