//! OpenEXR's standard attributes: website/StandardAttributes.rst of AcademySoftwareFoundation/openexr, version 3.2 and later.
//! `FNumber` is the name that OpenImageIO gives to `aperture`.

use super::attribute_dialect::{Attributes, Dialect, Row, Unit};
use super::number;
use super::record::{FrameRecord, Quantity, Reading, UnitSource};

const PITCH: &str = "sensorPhotositePitch";
const RECTANGLE: &str = "sensorAcquisitionRectangle";
const PUPIL: &str = "entrancePupilOffset";

/// Attributes that [`combine`] reads, and those that state no setting of the lens.
pub(super) const COMBINED: [&str; 8] = [
    PITCH,
    RECTANGLE,
    PUPIL,
    "sensorOverallDimensions",
    "sensorCenterOffset",
    "lensFirmwareVersion",
    "shutterAngle",
    "cameraCCTSetting",
];

pub(super) static DIALECT: Dialect = Dialect {
    rows: &[
        row("focus", Quantity::Focus, Unit::MetresFromSensor),
        row("aperture", Quantity::FNumber, Unit::FNumber),
        row("FNumber", Quantity::FNumber, Unit::FNumber),
        row("tStop", Quantity::FNumber, Unit::TNumber),
        row(
            "pinholeFocalLength",
            Quantity::FocalLength,
            Unit::Millimetres,
        ),
        row(
            "effectiveFocalLength",
            Quantity::FocalLength,
            Unit::Millimetres,
        ),
        row(
            "nominalFocalLength",
            Quantity::FocalLength,
            Unit::Millimetres,
        ),
    ],
    identity: &[
        ("lensMake", "lens make"),
        ("lensModel", "lens model"),
        ("lensSerialNumber", "lens serial number"),
        ("cameraMake", "camera make"),
        ("cameraModel", "camera model"),
        ("cameraSerialNumber", "camera serial number"),
        ("cameraLabel", "camera label"),
    ],
    combine,
};

const fn row(name: &'static str, quantity: Quantity, unit: Unit) -> Row {
    Row {
        name,
        quantity,
        unit,
    }
}

/// Adds the width of the recorded photosites, and the place of the entrance pupil.
fn combine(attributes: &Attributes, record: &mut FrameRecord) {
    let first = |name| attributes.numbers(name)?.first().copied();
    record.entrance_pupil_mm = (record.entrance_pupil_mm)
        .or_else(|| first(PUPIL))
        .filter(|offset| offset.is_finite());
    // The corners of a box; both are inside.
    let columns = (attributes.numbers(RECTANGLE)).and_then(|corners| match corners[..] {
        [left, _, right, _] => Some(right - left + 1.0),
        _ => None,
    });
    if let (Some(pitch_um), Some(columns)) = (first(PITCH), columns) {
        record.readings.push(Reading {
            quantity: Quantity::FilmBack,
            value: number::decimal(pitch_um * columns / 1000.0),
            unit: UnitSource::Defined,
            is_t_stop: false,
            from_sensor: false,
            field: format!("attributes `{PITCH}` and `{RECTANGLE}`"),
            text: format!("{columns} photosites of {pitch_um} µm"),
        });
    } else if let Some(text) = attributes.text("sensorOverallDimensions") {
        record.notes.push(format!(
            "attribute `sensorOverallDimensions` ({text} mm) is the whole sensor; without `{PITCH}` and `{RECTANGLE}` the recorded width is not known"
        ));
    }
}
