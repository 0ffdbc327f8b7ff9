//! The lens of a shot: one source for each quantity, with a value for each frame.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::plausibility::Optics;
use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use crate::animation::{Interpolation, interpolate};
use crate::error::{FileError, Result};

/// Largest relative difference of two values that agree. Focal lengths of one lens differ by its breathing and its
/// thickness.
const AGREEMENT: f64 = 0.01;
const FOCAL_AGREEMENT: f64 = 0.05;

/// The statements about a frame of a shot.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotRecord {
    /// Number of the frame in the table of the result.
    pub frame: i64,
    /// The file that states them.
    pub file: PathBuf,
    /// The statements.
    pub record: FrameRecord,
}

/// The use of the statements of a shot.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShotUse {
    /// Metres in a unit of the scene.
    pub metres_per_unit: Option<f64>,
    /// Focal length of the lens profile, where the shot states none.
    pub focal_length_mm: Option<f64>,
}

/// A quantity by frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The quantity.
    pub quantity: Quantity,
    /// Values by frame in the unit of the quantity.
    pub values: BTreeMap<i64, f64>,
    /// The place of the values in the files, in words.
    pub field: String,
    /// The file of the first frame.
    pub file: PathBuf,
}

/// The quantities of a shot, and notes on them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    /// The quantities that files state.
    pub columns: Vec<Column>,
    /// Notes for users.
    pub notes: Vec<String>,
}

impl Column {
    /// Returns whether all frames have the same value.
    pub fn is_constant(&self) -> bool {
        let mut values = self.values.values();
        let first = values.next();
        values.all(|value| Some(value) == first)
    }

    /// Returns the value at a frame, interpolated between frames that have one: distances by their reciprocals.
    pub fn value(&self, frame: i64) -> Option<f64> {
        let interpolation = match self.quantity {
            Quantity::Focus => Interpolation::Reciprocal,
            _ => Interpolation::Linear,
        };
        interpolate(&self.values, frame, interpolation)
    }

    /// Describes value, source and range in a line.
    pub fn line(&self) -> String {
        let name = self.quantity.name();
        let first = self.values.values().next().copied().unwrap_or(f64::NAN);
        let file = self.file.file_name().unwrap_or(self.file.as_os_str());
        let source = format!(
            "{name} {} from {} of {}",
            self.quantity.text(first),
            self.field,
            file.to_string_lossy()
        );
        match self.values.len() {
            0 | 1 => source,
            count => format!(
                "{source} ({})",
                range(self.quantity, self.values.values().copied(), count)
            ),
        }
    }
}

/// Describes the range of values over `count` frames.
pub(super) fn range(
    quantity: Quantity,
    values: impl Iterator<Item = f64> + Clone,
    count: usize,
) -> String {
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(f64::NEG_INFINITY, f64::max);
    match least == most {
        true => format!("constant over {count} frames"),
        false => format!(
            "{} to {} over {count} frames",
            super::number::rounded(least),
            quantity.text(most)
        ),
    }
}

/// Returns the `wanted` quantities that the records state, each from one field.
///
/// # Errors
/// Values that cannot be true, and a quantity that half of the frames or more lack.
pub fn columns(records: &[ShotRecord], wanted: &[Quantity], shot_use: ShotUse) -> Result<Columns> {
    let mut all = Columns::default();
    for &quantity in wanted {
        let preferred = |shot: &ShotRecord| {
            let reading = shot.record.preferred(quantity, shot_use.metres_per_unit);
            reading.map(|reading| reading.field.clone())
        };
        let Some(field) = records.iter().find_map(preferred) else {
            all.notes.extend(scene_note(records, quantity));
            continue;
        };
        let column = column(records, quantity, field, shot_use)?;
        all.notes.extend(column_notes(records, &column, shot_use));
        all.columns.push(column);
    }
    Ok(all)
}

/// Returns a note on a value in scene units that cannot be used.
fn scene_note(records: &[ShotRecord], quantity: Quantity) -> Option<String> {
    let mut readings = records.iter().flat_map(|shot| &shot.record.readings);
    let reading = readings.find(|reading| reading.quantity == quantity)?;
    Some(format!(
        "not used: {} {} of {}; give --depth-unit",
        quantity.name(),
        reading.text,
        reading.field
    ))
}

fn reading_of<'r>(shot: &'r ShotRecord, quantity: Quantity, field: &str) -> Option<&'r Reading> {
    let mut readings = shot.record.readings.iter();
    readings.find(|reading| reading.quantity == quantity && reading.field == field)
}

fn column(
    records: &[ShotRecord],
    quantity: Quantity,
    field: String,
    shot_use: ShotUse,
) -> Result<Column> {
    let mut values = BTreeMap::new();
    let mut missing = None;
    for shot in records {
        let Some(reading) = reading_of(shot, quantity, &field) else {
            missing = missing.or(Some(shot));
            continue;
        };
        let value = shot.record.usable_value(reading, shot_use.metres_per_unit);
        let lens = optics(&shot.record, shot_use);
        // The value of the file is what an error should name, before its origin is moved to the entrance pupil.
        let stated = match reading.unit {
            UnitSource::Scene => value,
            UnitSource::Stated | UnitSource::Defined => reading.value,
        };
        let fault = (lens.check(quantity, stated, reading.unit))
            .or_else(|| lens.check(quantity, value, reading.unit));
        if let Some(fault) = fault {
            let place = match records.len() {
                1 => reading.field.clone(),
                _ => format!("frame {}, {}", shot.frame, reading.field),
            };
            return Err(FileError::new(
                &shot.file,
                place,
                fault.problem,
                fault.remedy,
            ));
        }
        values.insert(shot.frame, value);
    }
    let lacking = records.len() - values.len();
    if let Some(shot) = missing.filter(|_| 2 * lacking >= records.len()) {
        return Err(FileError::new(
            &shot.file,
            format!("frame {}, {field}", shot.frame),
            format!("is missing, as in {lacking} of {} frames", records.len()),
            format!(
                "give the {} for all frames, or a value a frame",
                quantity.name()
            ),
        ));
    }
    let first = records.iter().find(|shot| values.contains_key(&shot.frame));
    Ok(Column {
        quantity,
        values,
        field,
        file: first.map(|shot| shot.file.clone()).unwrap_or_default(),
    })
}

/// Returns the lens of a record, by which its other values are checked.
pub(super) fn optics(record: &FrameRecord, shot_use: ShotUse) -> Optics {
    let value = |quantity| {
        record
            .preferred(quantity, None)
            .map(|reading| reading.value)
    };
    Optics {
        focal_length_mm: value(Quantity::FocalLength)
            .or(shot_use.focal_length_mm)
            .filter(|v| *v > 0.0),
        f_number: value(Quantity::FNumber).filter(|v| *v > 0.0),
    }
}

/// Returns notes on the source of a column: T-numbers, another origin of distances, frames without a value, and sources that
/// disagree.
fn column_notes(records: &[ShotRecord], column: &Column, shot_use: ShotUse) -> Vec<String> {
    let Column {
        quantity, field, ..
    } = column;
    let mut notes = Vec::new();
    let first = records.iter().find_map(|shot| {
        let reading = reading_of(shot, *quantity, field)?;
        Some((shot, reading))
    });
    let Some((shot, reading)) = first else {
        return notes;
    };
    let value = shot.record.usable_value(reading, shot_use.metres_per_unit);
    if reading.is_t_stop {
        notes.push(format!(
            "{field} is a T-number ({}): the lens's f-number is somewhat smaller",
            reading.text
        ));
    }
    if let Some(pupil_mm) = shot.record.entrance_pupil_mm
        && value != reading.value
        && reading.unit != UnitSource::Scene
    {
        notes.push(format!(
            "{} of {field} is from the sensor; from the entrance pupil, {} before it, it is {}",
            reading.text,
            Quantity::FocalLength.text(pupil_mm),
            quantity.text(value)
        ));
    }
    if reading.unit == UnitSource::Stated
        && let Some(fault) =
            optics(&shot.record, shot_use).check(*quantity, value, UnitSource::Defined)
    {
        notes.push(format!(
            "{field} {}; it is used as the file states its unit",
            fault.problem
        ));
    }
    let absent = records.iter().map(|shot| shot.frame);
    let absent = absent.filter(|frame| !column.values.contains_key(frame));
    let absent: Vec<String> = absent.map(|frame| frame.to_string()).collect();
    if !absent.is_empty() {
        notes.push(format!(
            "{field} is missing in frames {}: interpolated",
            absent.join(", ")
        ));
    }
    let agreement = match quantity {
        Quantity::FocalLength => FOCAL_AGREEMENT,
        _ => AGREEMENT,
    };
    let others = shot.record.readings.iter().filter(|other| {
        let is_other = other.quantity == *quantity && other.field != *field;
        let is_usable = other.unit != UnitSource::Scene || shot_use.metres_per_unit.is_some();
        let own = shot.record.usable_value(other, shot_use.metres_per_unit);
        // A T-number is larger than the f-number by the light that the lens absorbs.
        let is_expected =
            other.is_t_stop && !reading.is_t_stop && (1.0..1.3).contains(&(own / value));
        is_other && is_usable && !is_expected && (own / value - 1.0).abs() > agreement
    });
    notes.extend(others.map(|other| {
        format!(
            "{} disagrees: {} {}; not used, since {field} comes first",
            other.field,
            quantity.name(),
            other.text
        )
    }));
    notes
}
