//! Redshift's attributes. `rs/camera/aperture` is the film back; `rs/camera/FStop` is that of the photographic exposure.

use super::attribute_dialect::{Dialect, Row, Unit};
use super::record::Quantity;

pub(super) static DIALECT: Dialect = Dialect {
    rows: &[
        Row {
            name: "rs/camera/DOFFocusDistance",
            quantity: Quantity::Focus,
            unit: Unit::Scene,
        },
        Row {
            name: "rs/camera/FStop",
            quantity: Quantity::FNumber,
            unit: Unit::FNumber,
        },
        Row {
            name: "rs/camera/aperture",
            quantity: Quantity::FilmBack,
            unit: Unit::Millimetres,
        },
    ],
    identity: &[],
    combine: |_, _| {},
};
