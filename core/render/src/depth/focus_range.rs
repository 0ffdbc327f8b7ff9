//! Focus controls: a range in focus, factors of blur in front and behind, and a largest circle of confusion.
//!
//! Together they are a function from vergence to vergence. Kernels remain those of the lens at some distance, with their
//! shape, colour and dependence on the field.

use crate::{BlurField, PlateMap};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::FieldPoint;
use seidel_optics::sharpest_vergence;

/// Largest multiplier of blur in front of or behind the focus plane.
pub const MAX_MULTIPLIER: f64 = 16.0;

/// Largest distance from focus at which the lens is evaluated, 1/m: an object at a hundredth of a millimetre.
const FARTHEST_FROM_FOCUS: f64 = 1e5;
/// Probes along each side of a plate for the size of kernels.
const PROBES: usize = 9;
/// Bisections of an octave of distance from focus: the largest kernel is found to 1 in 10^4.
const HALVINGS: usize = 14;

/// The focus controls of a compositor; the default changes nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FocusControls {
    /// Vergence of the focus plane, 1/m; `None`: where the lens is sharpest ([`focus_vergence`]).
    pub focus_per_m: Option<f64>,
    /// Depth of field, metres: the range around the focus plane, half on each side, that is as sharp as the plane.
    pub depth_of_field_m: f64,
    /// Multiplier of the vergence difference to focus in front of the focus plane.
    pub front: f64,
    /// The same behind the focus plane.
    pub back: f64,
    /// Largest kernel, plate px: two standard deviations along its widest direction, the radius of an even disc.
    pub maximum_px: Option<f64>,
}

impl Default for FocusControls {
    fn default() -> Self {
        Self {
            focus_per_m: None,
            depth_of_field_m: 0.0,
            front: 1.0,
            back: 1.0,
            maximum_px: None,
        }
    }
}

impl FocusControls {
    /// Returns whether the controls change nothing.
    pub fn is_neutral(&self) -> bool {
        let Self { focus_per_m, .. } = *self;
        *self
            == Self {
                focus_per_m,
                ..Self::default()
            }
    }

    /// Checks the focus plane.
    ///
    /// # Errors
    /// A vergence that is not finite.
    fn check(&self) -> Result<()> {
        if let Some(focus) = self.focus_per_m.filter(|v| !v.is_finite()) {
            return Err(Error::new(
                "focus plane",
                format!("is at vergence {focus}"),
                "give one over its distance in metres, 0 for infinity",
            ));
        }
        Ok(())
    }
}

/// The position and size of a plate in the lens's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateExtent {
    /// Position and scale in the lens's frame.
    pub map: PlateMap,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// The range of distances that is as sharp as the focus plane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FocusRange {
    /// Vergence of the focus plane, 1/m.
    focus: f64,
    /// Nearer end of the range, 1/m.
    near: f64,
    /// Farther end of the range, 1/m.
    far: f64,
}

impl FocusRange {
    /// Returns the range of `controls` for `lens`.
    ///
    /// # Errors
    /// A focus plane that is not finite; a lens whose blur does not depend on distance; and a range around a focus plane at infinity.
    pub fn new(lens: &dyn BlurField, controls: &FocusControls) -> Result<Self> {
        controls.check()?;
        let sharpest = focus_vergence(lens).ok_or_else(|| {
            Error::new(
                "focus controls",
                "need a lens with a focus, but the blur of this one does not grow on both sides of any distance",
                "fit it to sets at three or more distances, or leave out depth of field, multipliers, maximum size and blur masks",
            )
        })?;
        let focus = controls.focus_per_m.unwrap_or(sharpest);
        let (near, far) = ends(focus, controls.depth_of_field_m)?;
        Ok(Self { focus, near, far })
    }

    /// Returns the vergence whose difference from the range is `share` times that of `v`, 1/m.
    pub fn nearer_focus(&self, v: f64, share: f64) -> f64 {
        let end = v.clamp(self.far, self.near);
        // A separate case, so that a share of 1 changes no bit.
        if share == 1.0 {
            v
        } else {
            end + share * (v - end)
        }
    }
}

/// [`FocusControls`] resolved for a lens and a plate: a map from object vergence to the vergence to draw.
///
/// Outside the range in focus v maps to f + m u. Here f is the vergence in focus, u the difference of v to the nearer end
/// of the range, and m the multiplier of that side. Inside the range v maps to f. The result is clamped to the two
/// vergences at which the largest kernel of the plate has the maximum size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FocusRemap {
    range: FocusRange,
    front: f64,
    back: f64,
    /// Smallest vergence drawn, 1/m.
    lowest: f64,
    /// Largest vergence drawn, 1/m.
    highest: f64,
    /// Size of the largest kernel in focus, plate px, where it exceeds the maximum size.
    unreachable_maximum_px: Option<f64>,
}

impl FocusRemap {
    /// Resolves `controls` for `lens` on `plate`.
    ///
    /// # Errors
    /// A focus plane that is not finite; a lens whose blur does not depend on distance; and a range around a focus plane at infinity.
    pub fn new(lens: &dyn BlurField, plate: PlateExtent, controls: &FocusControls) -> Result<Self> {
        controls.check()?;
        let mut remap = Self {
            range: FocusRange::default(),
            front: controls.front,
            back: controls.back,
            lowest: f64::NEG_INFINITY,
            highest: f64::INFINITY,
            unreachable_maximum_px: None,
        };
        if controls.is_neutral() {
            return Ok(remap);
        }
        remap.range = FocusRange::new(lens, controls)?;
        if let Some(size) = controls.maximum_px {
            let focus = remap.range.focus;
            let kernels = KernelProbes::new(lens, plate);
            let in_focus = kernels.largest(focus);
            remap.unreachable_maximum_px = (in_focus > size).then_some(in_focus);
            let size = size.max(in_focus);
            remap.highest = kernels.farthest(focus, 1.0, size);
            remap.lowest = kernels.farthest(focus, -1.0, size);
        }
        Ok(remap)
    }

    /// The size of the largest kernel in focus, plate px, where the maximum size is smaller: then everything is drawn as in
    /// focus, and still exceeds the maximum.
    pub fn unreachable_maximum_px(&self) -> Option<f64> {
        self.unreachable_maximum_px
    }

    /// Returns the vergence to draw for an object at vergence `v`, 1/m.
    pub fn vergence(&self, v: f64) -> f64 {
        let FocusRange { focus, near, far } = self.range;
        let (end, factor) = if v > near {
            (near, self.front)
        } else if v < far {
            (far, self.back)
        } else {
            return focus;
        };
        // A separate formula without a multiplier, so that neutral values change no bit.
        let moved = if factor == 1.0 {
            v - (end - focus)
        } else {
            focus + factor * (v - end)
        };
        moved.clamp(self.lowest, self.highest)
    }
}

/// Returns the nearer and the farther end of a range of `range_m` metres around `focus`, in 1/m as `focus` is.
fn ends(focus: f64, range_m: f64) -> Result<(f64, f64)> {
    if range_m == 0.0 {
        return Ok((focus, focus));
    }
    if focus <= 1e-9 {
        return Err(Error::new(
            "depth of field",
            format!("is {range_m} m about a focus plane that is at infinity"),
            "focus the lens at a finite distance, or give a back multiplier below 1",
        ));
    }
    let (middle, half) = (1.0 / focus, range_m / 2.0);
    let near = if half < middle {
        1.0 / (middle - half)
    } else {
        f64::INFINITY
    };
    Ok((near, 1.0 / (middle + half)))
}

/// Returns the vergence at which `lens` is sharpest on its axis, 1/m; `None` where blur does not grow on both sides.
///
/// It minimises the mean variance of all channels, which is close to a parabola in vergence.
pub fn focus_vergence(lens: &dyn BlurField) -> Option<f64> {
    focus_vergence_at(lens, FieldPoint::new(0.0, 0.0))
}

/// Returns the vergence at which `lens` is sharpest at a place of the field, like [`focus_vergence`].
pub(super) fn focus_vergence_at(lens: &dyn BlurField, at: FieldPoint) -> Option<f64> {
    let variance = |v: f64| {
        let of = |k| lens.blur_at(k, at, v).blur.moments.trace();
        (0..lens.channel_count()).map(of).sum::<f64>()
    };
    sharpest_vergence(variance)
}

/// The kernels of a plate, probed on a grid.
struct KernelProbes<'a> {
    lens: &'a dyn BlurField,
    places: Vec<FieldPoint>,
    scale: f64,
}

impl<'a> KernelProbes<'a> {
    fn new(lens: &'a dyn BlurField, plate: PlateExtent) -> Self {
        let frame = lens.frame();
        let along = |size: usize, k: usize| (size - 1) as f64 * k as f64 / (PROBES - 1) as f64;
        let places = (0..PROBES * PROBES).map(|k| {
            let column = along(plate.width.max(1), k % PROBES).round() as usize;
            let row = along(plate.height.max(1), k / PROBES).round() as usize;
            frame.field_point(plate.map.frame_point(column, row))
        });
        Self {
            lens,
            places: places.collect(),
            scale: plate.map.scale,
        }
    }

    /// Returns the size of the largest kernel at vergence `v`: two standard deviations, plate px.
    fn largest(&self, v: f64) -> f64 {
        let variance = |at: &FieldPoint, channel: usize| {
            let m = self.lens.blur_at(channel, *at, v).blur.moments;
            let (mean, half) = ((m.mu20 + m.mu02) / 2.0, (m.mu20 - m.mu02) / 2.0);
            mean + (half * half + m.mu11 * m.mu11).sqrt()
        };
        let channels = || 0..self.lens.channel_count();
        let all = (self.places.iter()).flat_map(|at| channels().map(move |k| variance(at, k)));
        2.0 * all.fold(0.0, f64::max).sqrt() * self.scale
    }

    /// Returns the vergence farthest from `focus` on the side of `sign` at which no kernel exceeds `size`, which is at least
    /// that of the kernels in focus.
    fn farthest(&self, focus: f64, sign: f64, size: f64) -> f64 {
        let (mut within, mut beyond) = (0.0, 1e-3);
        while self.largest(focus + sign * beyond) <= size {
            if beyond > FARTHEST_FROM_FOCUS {
                return sign * f64::INFINITY;
            }
            (within, beyond) = (beyond, 2.0 * beyond);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (within + beyond);
            if self.largest(focus + sign * middle) <= size {
                within = middle;
            } else {
                beyond = middle;
            }
        }
        focus + sign * within
    }
}

#[cfg(test)]
mod tests;
