//! The lens that a shot states: focus, f-number, focal length and film back by frame.

use seidel_image_io::animation::{Animation, Interpolation};
use seidel_image_io::lens_metadata::{Column, Quantity};

/// Name of the sources among the settings of a result.
pub(crate) const LENS_METADATA: &str = "lens-metadata";

/// Frame of a single picture in the table of a shot.
pub(super) const SINGLE: i64 = 0;

/// The lens that a shot states.
#[derive(Debug, Clone)]
pub(super) struct ShotLens {
    /// Values by frame, as of `--animate`.
    pub(super) table: Animation,
    /// The source of each value, in a line.
    pub(super) sources: String,
    pub(super) columns: Vec<Column>,
}

impl ShotLens {
    pub(super) fn new(columns: Vec<Column>, rule: &str) -> Option<Self> {
        let path = columns.first()?.file.clone();
        let sources = columns.iter();
        let sources = sources.map(|column| format!("{}: {}", column.quantity.knob(), column.field));
        let sources = sources.collect::<Vec<_>>().join("; ");
        let curves = columns.iter().map(|column| {
            let name = column.quantity.knob().to_owned();
            (name, column.values.clone())
        });
        Some(Self {
            table: Animation::from_curves(&path, curves.collect()),
            sources: format!("{sources}{rule}"),
            columns,
        })
    }

    /// Returns a note if the focus of frame `number` lies far outside of the depths of its plate, `range_m`.
    pub(super) fn focus_outside(&self, range_m: (f64, f64), number: Option<i64>) -> Option<String> {
        let name = Quantity::Focus.knob();
        let frame = number.unwrap_or(SINGLE);
        let focus = (self.table).value(name, frame, Interpolation::Reciprocal)?;
        let (near, far) = range_m;
        let is_inside = |value: f64| (near / 2.0..=far * 2.0).contains(&value);
        if is_inside(focus) || focus.is_infinite() {
            return None;
        }
        let column = self
            .columns
            .iter()
            .find(|c| c.quantity == Quantity::Focus)?;
        let units = [
            ("millimetres", 1e-3),
            ("centimetres", 1e-2),
            ("feet", 0.3048),
        ];
        let unit = units
            .into_iter()
            .find(|(_, scale)| is_inside(focus * scale));
        let unit = unit.map_or_else(String::new, |(unit, scale)| {
            let metres = Quantity::Focus.text(focus * scale);
            format!("; {metres} would lie within it, so the file may hold {unit}")
        });
        Some(format!(
            "focus {} from {} lies outside of the depth pass, {near:.4} m to {far:.4} m{unit}",
            Quantity::Focus.text(focus),
            column.field
        ))
    }
}
