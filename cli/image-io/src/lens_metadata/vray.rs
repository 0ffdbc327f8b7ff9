//! V-Ray's attributes. `cameraAperture` is the film back, and a target distance of 1e18 stands for none.

use super::attribute_dialect::{Attributes, Dialect, Row, Unit};
use super::record::Quantity;
use super::record::{FrameRecord, UnitSource};

const TARGET: &str = "cameraTargetDistance";

/// Distances from here on stand for no target, scene units.
const NO_TARGET: f64 = 1e17;

pub(super) static DIALECT: Dialect = Dialect {
    rows: &[
        Row {
            name: TARGET,
            quantity: Quantity::Focus,
            unit: Unit::Scene,
        },
        Row {
            name: "cameraFNumber",
            quantity: Quantity::FNumber,
            unit: Unit::FNumber,
        },
        Row {
            name: "cameraFocalLength",
            quantity: Quantity::FocalLength,
            unit: Unit::Millimetres,
        },
        Row {
            name: "cameraAperture",
            quantity: Quantity::FilmBack,
            unit: Unit::Millimetres,
        },
    ],
    identity: &[],
    combine: drop_missing_target,
};

/// Removes a target distance that stands for none.
fn drop_missing_target(attributes: &Attributes, record: &mut FrameRecord) {
    let field = attributes.field(TARGET);
    let count = record.readings.len();
    record.readings.retain(|reading| {
        reading.field != field || reading.unit != UnitSource::Scene || reading.value < NO_TARGET
    });
    if record.readings.len() < count {
        record.notes.push(format!(
            "{field} is 1e18 scene units or more, which stands for no target"
        ));
    }
}
