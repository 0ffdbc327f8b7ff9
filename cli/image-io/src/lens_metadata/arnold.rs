//! Arnold's attributes: neither focus nor f-number is among them.

use super::attribute_dialect::{Dialect, Row, Unit};
use super::record::Quantity;

pub(super) static DIALECT: Dialect = Dialect {
    rows: &[
        Row {
            name: "CameraFocalLength",
            quantity: Quantity::FocalLength,
            unit: Unit::Millimetres,
        },
        Row {
            name: "CameraFilmApertureHorizontal",
            quantity: Quantity::FilmBack,
            unit: Unit::Millimetres,
        },
    ],
    identity: &[],
    combine: |_, _| {},
};
