//! *Lens Data*: focus, f-number, focal length and film back that the frame on disk, or a table of the shot, states.
//!
//! Hosts hand no metadata to plugins, so that the plugin reads the files itself.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use seidel_core::{KnobUse, Lens, Mode, Settings};
use seidel_image_io::error::FileError;
use seidel_image_io::lens_metadata::{
    Column, Columns, FrameRecord, Quantity, ShotFrame, ShotRecord, ShotUse, Sidecar, columns,
    identity_note, is_table, match_frames, of_exr_header,
};
use seidel_image_io::sequence::FramePattern;

use crate::depth::DepthEncoding;
use crate::file_cache::FileCache;
use crate::host::{Failure, Result};
use crate::knobs::{Knobs, depth, focus, lens, named};

/// A file that states settings of the lens.
enum LensFile {
    /// A table of frames.
    Table(Sidecar),
    /// The attributes of a picture.
    Picture(Box<FrameRecord>),
}

static FILES: FileCache<PathBuf, LensFile> = FileCache::new();

/// Empties the cache of files.
pub(crate) fn clear() {
    FILES.clear();
}

/// The lens that files state at a frame.
pub(crate) struct LensData {
    frame: i64,
    columns: Vec<Column>,
    notes: Vec<String>,
}

impl LensData {
    /// Reads the files that *Lens Data* names, for what the other knobs leave open and the lens `profile` can follow. Returns
    /// `None` if it names none.
    ///
    /// # Errors
    /// Files that cannot be read or do not have the frame, and values that cannot be true.
    pub(crate) fn read(knobs: &Knobs, profile: &Lens) -> Result<Option<Self>> {
        let path = knobs.text(&lens::DATA);
        let path = path.trim();
        if path.is_empty() {
            return Ok(None);
        }
        let records = Files::new(knobs, path)?.records_near(knobs.frame())?;
        if records.iter().all(|shot| shot.record.readings.is_empty()) {
            return Err(Failure::failed(format!(
                "{path}: states no focus, f-number, focal length or film back; leave Lens Data empty, or give another file"
            )));
        }
        let wanted = Quantity::ALL.into_iter();
        let wanted: Vec<Quantity> = wanted
            .filter(|quantity| is_open(knobs, *quantity) && follows(profile, *quantity))
            .collect();
        let shot_use = ShotUse {
            metres_per_unit: metres_per_unit(knobs),
            focal_length_mm: profile.profile().camera.focal_length_mm,
        };
        let Columns { columns, mut notes } =
            columns(&records, &wanted, shot_use).map_err(failure)?;
        let own = records.first().map(|shot| &shot.record);
        notes.extend(own.and_then(|record| identity_note(record, &profile.profile().camera)));
        Ok(Some(Self {
            frame: knobs.frame(),
            columns,
            notes,
        }))
    }

    /// Returns the distance in focus, metres.
    pub(crate) fn focus_m(&self) -> Option<f64> {
        let mut columns = self.columns.iter();
        let column = columns.find(|column| column.quantity == Quantity::Focus)?;
        column.value(self.frame)
    }

    /// Writes the values to `settings`.
    ///
    /// # Errors
    /// A value out of the range of its knob.
    pub(crate) fn put(&self, settings: &mut Settings) -> Result<()> {
        for column in &self.columns {
            let knob = seidel_core::Knob::named(column.quantity.knob());
            if let (Some(knob), Some(value)) = (knob, column.value(self.frame)) {
                knob.put_number(value, settings).map_err(|e| {
                    let (file, field) = (column.file.display(), &column.field);
                    Failure::failed(format!("{file}: {field}: {}; {}", e.problem, e.remedy))
                })?;
            }
        }
        Ok(())
    }

    /// Describes the values with their sources, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let values = self.columns.iter().filter_map(|column| {
            let only = column.value(self.frame)?;
            let column = Column {
                values: BTreeMap::from([(self.frame, only)]),
                ..column.clone()
            };
            Some(column.line())
        });
        values.chain(self.notes.iter().cloned()).collect()
    }
}

/// Returns whether the knobs leave a quantity to the files.
fn is_open(knobs: &Knobs, quantity: Quantity) -> bool {
    let is_zero = |name| knobs.number(named(name)) == 0.0;
    match quantity {
        Quantity::Focus => knobs.choice(&focus::FOCUS) == focus::AS_MEASURED,
        // Both set the scale of the lens.
        Quantity::FilmBack => is_zero("film-back-mm") && is_zero("lens-scale"),
        Quantity::FNumber | Quantity::FocalLength => is_zero(quantity.knob()),
    }
}

fn follows(profile: &Lens, quantity: Quantity) -> bool {
    let knob_use = KnobUse {
        mode: Mode::Apply,
        lens: Some(profile),
        look_lens: None,
        settings: &Settings::default(),
    };
    let knob = seidel_core::Knob::named(quantity.knob());
    knob.is_some_and(|knob| (knob.has_effect)(&knob_use))
}

/// Returns the metres in a unit of the scene: those of the depth pass, where depth is a distance.
fn metres_per_unit(knobs: &Knobs) -> Option<f64> {
    let is_distance =
        knobs.is_on(&depth::USE_DEPTH) && !depth::is_direct(knobs.choice(&depth::MATH));
    is_distance.then(|| DepthEncoding::new(knobs).metres_per_unit())
}

/// The files of a shot.
struct Files {
    pattern: FramePattern,
    path: PathBuf,
    /// Frame of the first row of a table.
    start: Option<i64>,
    reloads: i32,
}

impl Files {
    fn new(knobs: &Knobs, path: &str) -> Result<Self> {
        let start = knobs.text(&lens::DATA_START);
        let start = Some(start.trim()).filter(|text| !text.is_empty());
        let start = start.map(|text| {
            let label = lens::DATA_START.label.to_string_lossy();
            text.parse::<i64>().map_err(|_| {
                Failure::failed(format!(
                    "{label}: `{text}` is no frame number; give a whole number, or nothing"
                ))
            })
        });
        Ok(Self {
            pattern: FramePattern::parse(path),
            path: path.into(),
            start: start.transpose()?,
            reloads: knobs.hidden(&lens::RELOADS),
        })
    }

    /// Returns the statements about `frame`, and those about its neighbours, which show what it lacks.
    ///
    /// # Errors
    /// A frame whose file cannot be read or that the table does not hold.
    fn records_near(&self, frame: i64) -> Result<Vec<ShotRecord>> {
        let mut records = vec![self.record(frame)?];
        let neighbours = [frame.saturating_sub(1), frame.saturating_add(1)];
        records.extend(
            neighbours
                .iter()
                .filter_map(|frame| self.record(*frame).ok()),
        );
        Ok(records)
    }

    fn record(&self, frame: i64) -> Result<ShotRecord> {
        let is_each = self.pattern.has_frame() && !self.path.is_file();
        let path = match is_each {
            true => self.pattern.path(frame),
            false => self.path.clone(),
        };
        let file = FILES.get(&path, Some(&path), self.reloads, || read(&path))?;
        let record = match &*file {
            LensFile::Picture(record) => record.as_ref().clone(),
            LensFile::Table(table) => {
                let wanted = ShotFrame {
                    number: (!is_each).then_some(frame),
                    time_code: None,
                };
                let start = self.start.filter(|_| !is_each);
                let matched = match_frames(table, &[wanted], start).map_err(failure)?;
                matched
                    .records
                    .first()
                    .copied()
                    .cloned()
                    .unwrap_or_default()
            }
        };
        Ok(ShotRecord {
            frame,
            file: path,
            record,
        })
    }
}

fn read(path: &Path) -> Result<LensFile> {
    if is_table(path) {
        return Ok(LensFile::Table(Sidecar::open(path).map_err(failure)?));
    }
    let record = of_exr_header(path).map_err(failure)?;
    let record = record.ok_or_else(|| {
        Failure::failed(format!(
            "{}: is in a format whose attributes say nothing about the lens; give EXR files, or a table of the shot",
            path.display()
        ))
    })?;
    Ok(LensFile::Picture(Box::new(record)))
}

fn failure(error: FileError) -> Failure {
    Failure::failed(error.to_string())
}
