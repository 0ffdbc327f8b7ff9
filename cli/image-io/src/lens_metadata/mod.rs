//! Settings of lens and camera that files state: attributes of plates, and tables that tracking systems and cameras write.
//!
//! A dialect is one file: a list of attributes with its row in `attributes::DIALECTS`, or a reader of a table with its row in
//! `sidecar::DIALECTS`. Everything else works on [`FrameRecord`]s, in which lengths are metres or millimetres.

mod arnold;
mod arri;
mod attribute_dialect;
mod attributes;
mod blackmagic;
mod canon;
mod csv_table;
mod identity;
mod matching;
mod named_attribute;
mod number;
mod openexr;
mod opentrackio;
mod plausibility;
mod record;
mod red;
mod redshift;
mod shot;
mod sidecar;
mod sony;
mod summary;
mod table_dialect;
mod time_code;
mod vray;

pub(crate) use attributes::of_parts;
pub use attributes::{of_exr_header, of_plate, time_code};
pub use identity::identity_note;
pub use matching::{FrameMatch, ShotFrame, match_frames};
pub use named_attribute::NamedAttribute;
pub use plausibility::{Implausible, Optics};
pub use record::{FrameRecord, Quantity, Reading, UnitSource};
pub use shot::{Column, Columns, ShotRecord, ShotUse, columns};
pub use sidecar::{Sidecar, is_table};
pub use summary::{knowledge, lines, range_lines};
pub use time_code::TimeCode;

#[cfg(test)]
mod tests;
