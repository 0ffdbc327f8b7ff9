//! Reading of the lens of a shot, from the attributes of its plates or from a table beside them.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use seidel_core::{Knob, KnobUse, Mode};

use super::reader::PlateReader;
use super::run::Run;
use super::shot_lens::{SINGLE, ShotLens};
use super::shot_metadata::LensSource;
use crate::Console;
use crate::commands::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::lens_metadata::{
    Column, FrameRecord, NamedAttribute, Quantity, ShotFrame, ShotRecord, ShotUse, Sidecar,
    columns, identity_note, knowledge, match_frames, of_exr_header, time_code,
};
use seidel_image_io::sequence::FramePattern;

/// A focal length that differs more from that of the profile makes one doubt the profile.
const SAME_FOCAL_LENGTH: f64 = 0.05;

impl PlateReader<'_> {
    /// Returns the option or table that sets a quantity before metadata do.
    fn overriding(&self, quantity: Quantity) -> Option<String> {
        // Both set the scale of the lens.
        let names: &[&str] = match quantity {
            Quantity::FilmBack => &["film-back-mm", "lens-scale"],
            _ => &[quantity.knob()],
        };
        if names.iter().any(|name| self.is_animated(name)) {
            return Some("--animate".to_owned());
        }
        let option = self.args.lens.options.given(names);
        option.map(|name| format!("--{name}"))
    }

    /// Returns whether the lens can follow a quantity.
    fn follows(&self, quantity: Quantity) -> bool {
        let session = self.base_session();
        let knob_use = KnobUse {
            mode: Mode::Apply,
            lens: Some(session.lens()),
            look_lens: None,
            settings: session.settings(),
        };
        Knob::named(quantity.knob()).is_some_and(|knob| (knob.has_effect)(&knob_use))
    }

    /// Returns the quantities that metadata may set.
    fn open_quantities(&self) -> Vec<Quantity> {
        let all = Quantity::ALL.into_iter();
        all.filter(|quantity| self.overriding(*quantity).is_none() && self.follows(*quantity))
            .collect()
    }

    /// Returns a note on the lens settings that the first plate states, where no option asks for them.
    pub(super) fn unused_knowledge(&self, run: &Run) -> Option<String> {
        let first = run.frames().first()?;
        // A plate that cannot be read is reported when it is.
        let record = of_exr_header(&first.input).ok()??;
        let known = knowledge(&record, &self.open_quantities())?;
        let unit = match self.args.depth.unit.given_metres() {
            None if known.contains("scene units") => " (scene units need --depth-unit)",
            _ => "",
        };
        Some(format!(
            "the plate says {known}: --lens-metadata plate uses it{unit}"
        ))
    }

    /// Reads the lens that the shot of `run` states. Adds to `notes`.
    ///
    /// # Errors
    /// Values that cannot be true, and plates and tables that state none.
    pub(super) fn read_shot(
        &self,
        run: &Run,
        notes: &mut Vec<String>,
    ) -> Result<Option<ShotLens>, CommandError> {
        let Some(source) = &self.args.lens.metadata.source else {
            return Ok(None);
        };
        let named = &self.args.lens.metadata.lens_attribute;
        let (records, rule) = match source {
            LensSource::Plate => (plate_records(run.inputs(), named)?, String::new()),
            LensSource::Table(_) if !named.is_empty() => {
                return Err(CommandError::Usage(
                    "--lens-attribute names attributes of plates; give --lens-metadata plate"
                        .to_owned(),
                ));
            }
            LensSource::Table(path) => {
                let start = self.args.lens.metadata.lens_metadata_start;
                table_records(path, run.inputs(), start, notes)?
            }
        };
        self.shot_of(&records, &rule, notes)
    }

    /// Returns the lens that `records` state. Adds to `notes`.
    fn shot_of(
        &self,
        records: &[ShotRecord],
        rule: &str,
        notes: &mut Vec<String>,
    ) -> Result<Option<ShotLens>, CommandError> {
        let measured = self.base_session().lens().profile().camera.focal_length_mm;
        let shot_use = ShotUse {
            metres_per_unit: self.args.depth.unit.given_metres(),
            focal_length_mm: measured,
        };
        notes.extend(self.unused_notes(records));
        let found = columns(records, &self.open_quantities(), shot_use)?;
        let lines = found.columns.iter().map(Column::line);
        notes.extend(lines.map(|line| format!("{line}{rule}")));
        notes.extend(found.notes);
        let Some(first) = records.first() else {
            return Ok(None);
        };
        notes.extend(first.record.notes.iter().cloned());
        let camera = &self.base_session().lens().profile().camera;
        notes.extend(identity_note(&first.record, camera));
        notes.extend(measured.and_then(|measured| scaling_note(&found.columns, measured)));
        let is_overridden = |quantity: &Quantity| {
            self.overriding(*quantity).is_some() && stated(records, *quantity).is_some()
        };
        if found.columns.is_empty() && !Quantity::ALL.iter().any(is_overridden) {
            return Err(nothing_stated(&first.file, notes).into());
        }
        Ok(ShotLens::new(found.columns, rule))
    }

    /// Returns notes on values that something else sets before metadata do, and on those that the lens cannot follow.
    fn unused_notes(&self, records: &[ShotRecord]) -> Vec<String> {
        let note = |quantity| {
            let text = stated(records, quantity)?;
            match self.overriding(quantity) {
                Some(option) => Some(format!("not used: {text}, since {option} comes first")),
                None if self.follows(quantity) => None,
                None => Some(format!(
                    "not used: {text}, which the lens profile cannot follow"
                )),
            }
        };
        Quantity::ALL.into_iter().filter_map(note).collect()
    }

    /// Sets the lens by what the shot of another reader states; for the lens whose blur a plate gets.
    ///
    /// # Errors
    /// Values that the lens cannot follow.
    pub(crate) fn begin_beside(
        &mut self,
        other: &Self,
        console: &mut Console,
    ) -> Result<(), CommandError> {
        self.single = other.single;
        if self.args.lens.metadata.source.is_none() {
            return Ok(());
        }
        let columns = other
            .shot
            .iter()
            .flat_map(|shot| shot.columns.iter().cloned());
        let (used, unused): (Vec<Column>, Vec<Column>) =
            columns.partition(|column| self.follows(column.quantity));
        let mut notes: Vec<String> = (unused.iter())
            .map(|column| {
                let name = column.quantity.name();
                format!("not used for --to: {name}, which its profile cannot follow")
            })
            .collect();
        self.set_shot(ShotLens::new(used, ""), &mut notes)?;
        notes.into_iter().for_each(|note| console.note(note));
        Ok(())
    }
}

/// Describes the first value that the records state of a quantity.
fn stated(records: &[ShotRecord], quantity: Quantity) -> Option<String> {
    let readings = |shot: &'_ ShotRecord| shot.record.preferred(quantity, Some(1.0)).cloned();
    let reading = records.iter().find_map(readings)?;
    let (name, text, field) = (quantity.name(), reading.text, reading.field);
    Some(format!("{name} {text} from {field}"))
}

/// Returns a note if the shot's focal length is not that of the profile, `measured_mm`.
fn scaling_note(columns: &[Column], measured_mm: f64) -> Option<String> {
    let is_focal_length = |column: &&Column| column.quantity == Quantity::FocalLength;
    let stated_mm = columns
        .iter()
        .find(is_focal_length)?
        .values
        .values()
        .next()?;
    let differs = (stated_mm / measured_mm - 1.0).abs() > SAME_FOCAL_LENGTH;
    let text = |value| Quantity::FocalLength.text(value);
    differs.then(|| {
        format!(
            "the lens profile is of {}, the shot of {}: the lens is scaled; check that it is the lens of the shot",
            text(measured_mm),
            text(*stated_mm)
        )
    })
}

/// Returns the error about a file without values that can be used, for the reasons in `notes`.
fn nothing_stated(file: &Path, notes: &[String]) -> FileError {
    let reasons = match notes.is_empty() {
        true => String::new(),
        false => format!(" ({})", notes.join("; ")),
    };
    FileError::new(
        file,
        "lens metadata",
        format!("states no focus, f-number, focal length or film back that can be used{reasons}"),
        "leave out --lens-metadata, or give a table of the shot, or the values by their options",
    )
}

/// Reads the attributes of all plates. Those that cannot be read are reported when they are rendered.
/// The attributes `named` come before all others.
///
/// # Errors
/// Plates of which none can be read, and a named attribute that none has.
fn plate_records(
    inputs: &[(Option<i64>, PathBuf)],
    named: &[NamedAttribute],
) -> Result<Vec<ShotRecord>, FileError> {
    let read = inputs.par_iter().map(|(number, path)| {
        let mut record = of_exr_header(path)?.ok_or_else(|| {
            FileError::new(
                path,
                "lens metadata",
                "is in a format whose attributes say nothing about the lens",
                "give EXR files, or a table of the shot by --lens-metadata FILE",
            )
        })?;
        NamedAttribute::read_all(named, path, &mut record)?;
        Ok(shot_record(*number, path, record))
    });
    let read: Vec<Result<ShotRecord, FileError>> = read.collect();
    let records = keep_read(read)?;
    if let Some(first) = records.first() {
        let all = records.iter().map(|shot| &shot.record);
        NamedAttribute::check_found(named, all, &first.file)?;
    }
    Ok(records)
}

fn shot_record(number: Option<i64>, file: &Path, record: FrameRecord) -> ShotRecord {
    ShotRecord {
        frame: number.unwrap_or(SINGLE),
        file: file.to_owned(),
        record,
    }
}

/// Returns the results without errors; the first error if there is nothing else.
fn keep_read<T>(read: Vec<Result<T, FileError>>) -> Result<Vec<T>, FileError> {
    let (mut kept, mut first) = (Vec::new(), None);
    for result in read {
        match result {
            Ok(value) => kept.push(value),
            Err(error) => first = first.or(Some(error)),
        }
    }
    match first {
        Some(error) if kept.is_empty() => Err(error),
        _ => Ok(kept),
    }
}

/// Reads a table, or one for each frame, for the plates `inputs`. Returns the rule by which frames were matched too. Adds to `notes`.
fn table_records(
    path: &Path,
    inputs: &[(Option<i64>, PathBuf)],
    start: Option<i64>,
    notes: &mut Vec<String>,
) -> Result<(Vec<ShotRecord>, String), FileError> {
    let pattern = FramePattern::parse(path);
    if pattern.has_frame() && !path.is_file() {
        let records = inputs.iter().map(|(number, _)| {
            let file = pattern.path(number.unwrap_or(SINGLE));
            let table = Sidecar::open(&file)?;
            match table.records() {
                [record] => Ok(shot_record(*number, &file, record.clone())),
                records => Err(FileError::new(
                    &file,
                    "samples",
                    format!("holds {} frames, but is the file of one", records.len()),
                    "give a table of all frames, or a file for each",
                )),
            }
        });
        let records = records.collect::<Result<_, _>>()?;
        return Ok((records, "; a file for each frame".to_owned()));
    }
    let table = Sidecar::open(path)?;
    let frames = inputs.par_iter().map(|(number, plate)| ShotFrame {
        number: *number,
        time_code: time_code(plate).unwrap_or_default(),
    });
    let frames: Vec<ShotFrame> = frames.collect();
    let matched = match_frames(&table, &frames, start)?;
    let records = inputs.iter().zip(&matched.records);
    let records =
        records.map(|((number, _), record)| shot_record(*number, path, (*record).clone()));
    let records: Vec<ShotRecord> = records.collect();
    notes.extend(disagreements(&records, inputs));
    let rule = format!(" ({}, matched {})", table.dialect(), matched.rule);
    Ok((records, rule))
}

/// Returns notes on statements of the first plate that disagree with those of the table.
fn disagreements(records: &[ShotRecord], inputs: &[(Option<i64>, PathBuf)]) -> Vec<String> {
    let (Some(shot), Some((_, path))) = (records.first(), inputs.first()) else {
        return Vec::new();
    };
    let Ok(Some(plate)) = of_exr_header(path) else {
        return Vec::new();
    };
    let values = Quantity::ALL.into_iter().filter_map(|quantity| {
        let own = plate.preferred(quantity, None)?;
        let table = shot.record.preferred(quantity, None)?;
        let differs = own.is_t_stop == table.is_t_stop
            && (own.value / table.value - 1.0).abs() > SAME_FOCAL_LENGTH;
        differs.then(|| {
            format!(
                "the plate says {} {} by {}, the table {}: the table is used",
                quantity.name(),
                own.text,
                own.field,
                table.text
            )
        })
    });
    let names = plate.identity.iter().filter_map(|(name, own)| {
        let table = shot.record.identity.get(name)?;
        let differs = !own.eq_ignore_ascii_case(table);
        differs.then(|| format!("the {name} is {own} by the plate, {table} by the table"))
    });
    values.chain(names).collect()
}
