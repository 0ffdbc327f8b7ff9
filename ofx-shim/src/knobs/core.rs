//! Knobs of the core's table, as knobs of the node.

use std::ffi::{CStr, CString};
use std::sync::LazyLock;

use seidel_core::{HostGroup, KnobKind, Number, Unit};

use super::{Kind, Knob};

/// Ends of ranges beyond this are this: infinity is no valid range in Nuke.
const LIMIT: f64 = 1e6;

/// A row of the core's table, and its knob.
struct Row {
    row: &'static seidel_core::Knob,
    group: HostGroup,
    knob: Knob,
}

static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| {
    let rows = seidel_core::Knob::all().filter_map(|row| {
        let host = row.host.as_ref()?;
        Some(Row {
            row,
            group: host.group,
            knob: Knob {
                name: c_str(host.name),
                label: c_str(&label(host.label, row)),
                hint: c_str(&hint(row)),
                kind: kind(row),
            },
        })
    });
    rows.collect()
});

/// Returns the knobs of a group of the core's table, each with its row.
pub(super) fn knobs_of(
    group: HostGroup,
) -> impl Iterator<Item = (&'static seidel_core::Knob, &'static Knob)> {
    let rows = ROWS.iter().filter(move |row| row.group == group);
    rows.map(|row| (row.row, &row.knob))
}

/// Returns all knobs of the core's table, each with its row.
pub(crate) fn table() -> impl Iterator<Item = (&'static seidel_core::Knob, &'static Knob)> {
    ROWS.iter().map(|row| (row.row, &row.knob))
}

/// Returns the knob that the core's table calls `name`.
///
/// # Panics
/// Without such a knob, which a test rules out for the names used here.
pub(crate) fn named(name: &str) -> &'static Knob {
    let found = table().find(|(row, _)| row.name == name);
    found
        .map(|(_, knob)| knob)
        .unwrap_or_else(|| panic!("no knob {name}"))
}

/// Returns `text` for the whole life of the plugin: hosts keep pointers to names.
fn c_str(text: &str) -> &'static CStr {
    let text = CString::new(text).unwrap_or_default();
    Box::leak(text.into_boxed_c_str())
}

/// Returns the label with the unit of a number, if it has one.
fn label(label: &str, row: &seidel_core::Knob) -> String {
    let unit = row.number().and_then(|number| match number.unit {
        Unit::Factor | Unit::FNumber | Unit::SceneLinear | Unit::PlateScale => None,
        Unit::Distance | Unit::Metres => Some("m"),
        Unit::Millimetres => Some("mm"),
        Unit::Micrometres => Some("um"),
        Unit::Degrees => Some("deg"),
        Unit::PlatePixels => Some("px"),
        Unit::PercentOfFrame => Some("%"),
    });
    unit.map_or_else(|| label.to_owned(), |unit| format!("{label} ({unit})"))
}

/// Returns the help of a knob, with those of its options.
fn hint(row: &seidel_core::Knob) -> String {
    let mut sentences = vec![row.summary("if 0")];
    if let KnobKind::Choice(choice) = &row.kind {
        let options = choice.options.iter();
        sentences.extend(options.map(|option| format!("{}: {}", option.label, option.help)));
    }
    let details = Some(row.details).filter(|details| !details.is_empty());
    let sentences = sentences.iter().map(|sentence| format!("{sentence}."));
    let sentences: Vec<_> = sentences.chain(details.map(str::to_owned)).collect();
    sentences.join(" ")
}

fn kind(row: &'static seidel_core::Knob) -> Kind {
    match &row.kind {
        KnobKind::Number(number) => number_kind(number),
        KnobKind::Switch(switch) => Kind::Switch(switch.default),
        KnobKind::Choice(choice) => {
            let labels = choice.options.iter().map(|option| c_str(option.label));
            Kind::Choice {
                default: choice.default as i32,
                options: Vec::leak(labels.collect()),
            }
        }
    }
}

/// Returns a number that is 0 where it is left out.
fn number_kind(number: &Number) -> Kind {
    let least = match number.default {
        None => number.range.0.min(0.0),
        Some(_) => number.range.0,
    };
    Kind::Number {
        default: number.default.unwrap_or(0.0),
        range: (least.max(-LIMIT), number.range.1.min(LIMIT)),
        slider: number.slider,
        digits: i32::from(number.digits),
    }
}
