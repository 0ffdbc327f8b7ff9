//! The plane of focus of a lens, which a tilt turns.

use seidel_optics::BlurField;
use seidel_optics::field::FieldPoint;

use super::focus_range::{focus_vergence, focus_vergence_at};

/// Places at which the lens is probed on both sides of its axis, half frame widths. Field curvature is alike on both.
const PROBE: f64 = 0.4;

/// The plane of focus: a plane in space has a vergence that is linear over the field.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FocusPlane {
    /// Vergence at which the lens is sharpest on its axis, 1/m.
    pub(crate) on_axis_per_m: f64,
    /// Its change over half a frame width along x and y, 1/m: zero unless the lens is tilted.
    change_per_m: [f64; 2],
}

impl FocusPlane {
    /// Returns the plane of focus of `lens`; `None` where blur does not grow on both sides.
    pub(crate) fn new(lens: &dyn BlurField) -> Option<Self> {
        let on_axis_per_m = focus_vergence(lens)?;
        let at = |x, y| focus_vergence_at(lens, FieldPoint::new(x, y)).unwrap_or(on_axis_per_m);
        let sides = [
            [at(-PROBE, 0.0), at(PROBE, 0.0)],
            [at(0.0, -PROBE), at(0.0, PROBE)],
        ];
        Some(Self {
            on_axis_per_m,
            change_per_m: sides.map(|[before, after]| (after - before) / (2.0 * PROBE)),
        })
    }

    /// Returns the vergence of the plane at a place of the field, 1/m.
    pub(crate) fn vergence_at(&self, at: FieldPoint) -> f64 {
        let [x, y] = self.change_per_m;
        self.on_axis_per_m + x * at.x + y * at.y
    }
}
