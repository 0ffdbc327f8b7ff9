//! Where the optical axis meets the plate.

use super::place::Place;

/// The axis, plate pixels: the lens's frame lies centre on centre with the format.
pub(super) fn axis(place: &Place) -> (f64, f64) {
    let (info, settings) = (&place.lens.info, place.setup.settings());
    let aspect = settings.pixel_aspect;
    let (width, height) = (
        f64::from(place.format.width),
        f64::from(place.format.height),
    );
    let scale = match settings.lens_scale.is_nan() {
        true => width * aspect / info.frame.0,
        false => settings.lens_scale,
    };
    (
        width / 2.0 + (info.axis.0 - info.frame.0 / 2.0) * scale / aspect + settings.axis_offset_x,
        height / 2.0 + (info.axis.1 - info.frame.1 / 2.0) * scale + settings.axis_offset_y,
    )
}
