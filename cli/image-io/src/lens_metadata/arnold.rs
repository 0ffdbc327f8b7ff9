//! Arnold's attributes: neither focus nor f-number is among them.

use super::Quantity;
use super::attributes::{Dialect, Row, Unit};

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
