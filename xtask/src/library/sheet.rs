//! Sheets of designs.

use seidel_optics::library::{Sensor, Sheet};

use super::designs::Design;

/// The origin of the numbers of every design.
const COMPUTED_FROM: &str = "a design by aberration coefficients (xtask/src/library/designs.rs): defocus by the thin lens law from \
                             focal length, f-number and focus; third-order aberrations and the effects below chosen for the look; \
                             no measured lens";

/// Returns the sheet of `design`.
pub(super) fn sheet(design: &Design) -> Sheet {
    let texts = |list: &[&str]| list.iter().map(|&text| text.to_owned()).collect();
    Sheet {
        name: design.name.to_owned(),
        title: design.title.to_owned(),
        kind: design.kind.to_owned(),
        focal_length_mm: design.focal_mm,
        f_number_range: [design.f_number, design.smallest_aperture],
        focus_distance_m: design.focus_m,
        nearest_m: design.nearest_m,
        squeeze: design.squeeze.unwrap_or(1.0),
        sensor: Sensor {
            width_mm: design.sensor_mm[0],
            height_mm: design.sensor_mm[1],
            width_px: design.frame_px[0],
            height_px: design.frame_px[1],
        },
        computed_from: COMPUTED_FROM.to_owned(),
        shows: texts(design.shows),
        good_for: texts(design.good_for),
        lacks: texts(design.lacks),
    }
}
