//! The frames of a plate and those of a table, matched by time code, else by number.

use std::collections::{BTreeMap, BTreeSet};

use super::record::FrameRecord;
use super::sidecar::Sidecar;
use super::time_code::TimeCode;
use crate::error::{FileError, Result};

/// A frame of a plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShotFrame {
    /// Number in the file name; `None` for a single picture.
    pub number: Option<i64>,
    /// Time code in the file.
    pub time_code: Option<TimeCode>,
}

/// The frames of a table that belong to those of a plate.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameMatch<'s> {
    /// A record for each frame of the plate.
    pub records: Vec<&'s FrameRecord>,
    /// The rule by which they were matched, in words.
    pub rule: String,
}

const REMEDY: &str = "give the table of this shot, or the frame of its first row (--lens-metadata-start; in a host, Lens Data Start)";

/// Matches `frames` with the records of `sidecar`: by the number of its first row if `start` is given, else by time code,
/// else by frame number, else in order. In order needs a table that counts from 0 or 1 and has as many frames.
///
/// # Errors
/// A table of other frames.
pub fn match_frames<'s>(
    sidecar: &'s Sidecar,
    frames: &[ShotFrame],
    start: Option<i64>,
) -> Result<FrameMatch<'s>> {
    if let Some(start) = start {
        return by_start(sidecar, frames, start);
    }
    if let Some(codes) = distinct_codes(frames)
        && sidecar.records().iter().any(|r| r.time_code.is_some())
    {
        return by_time_code(sidecar, &codes);
    }
    by_number(sidecar, frames)
}

/// Returns the time codes of all frames; `None` if one has none, or two have the same.
fn distinct_codes(frames: &[ShotFrame]) -> Option<Vec<TimeCode>> {
    let codes: Vec<TimeCode> = (frames.iter().map(|f| f.time_code)).collect::<Option<_>>()?;
    let distinct: BTreeSet<TimeCode> = codes.iter().copied().collect();
    (distinct.len() == codes.len()).then_some(codes)
}

fn by_time_code<'s>(sidecar: &'s Sidecar, codes: &[TimeCode]) -> Result<FrameMatch<'s>> {
    let mut known: BTreeMap<TimeCode, &FrameRecord> = BTreeMap::new();
    for record in sidecar.records() {
        if let Some(code) = record.time_code {
            // Of samples within one frame, the first.
            known.entry(code).or_insert(record);
        }
    }
    let range = range_text(known.keys());
    let find = |code: &TimeCode| {
        known.get(code).copied().ok_or_else(|| {
            let problem = format!(
                "holds no frame of time code {code}, which the plate has: it holds {range}"
            );
            FileError::new(sidecar.path(), "time code", problem, REMEDY)
        })
    };
    Ok(FrameMatch {
        records: codes.iter().map(find).collect::<Result<_>>()?,
        rule: "by time code".to_owned(),
    })
}

/// Returns the first and last of values in order.
fn range_text<T: ToString>(mut values: impl DoubleEndedIterator<Item = T>) -> String {
    let ends = [values.next(), values.next_back()];
    let ends = ends.into_iter().flatten().map(|end| end.to_string());
    ends.collect::<Vec<_>>().join(" to ")
}

fn by_start<'s>(sidecar: &'s Sidecar, frames: &[ShotFrame], start: i64) -> Result<FrameMatch<'s>> {
    let records = sidecar.records();
    let first = records.first().and_then(|record| record.number);
    let find = |frame: &ShotFrame| {
        let number = frame.number.unwrap_or(start);
        let offset = number.saturating_sub(start);
        let record = match first {
            Some(first) => {
                let wanted = first.saturating_add(offset);
                records.iter().find(|record| record.number == Some(wanted))
            }
            None => usize::try_from(offset).ok().and_then(|at| records.get(at)),
        };
        record.ok_or_else(|| {
            let problem = format!(
                "holds {} frames, the first for frame {start}; none is for frame {number}",
                records.len()
            );
            FileError::new(sidecar.path(), "frames", problem, REMEDY)
        })
    };
    Ok(FrameMatch {
        records: frames.iter().map(find).collect::<Result<_>>()?,
        rule: format!("by frame number, with the first row at frame {start}"),
    })
}

fn by_number<'s>(sidecar: &'s Sidecar, frames: &[ShotFrame]) -> Result<FrameMatch<'s>> {
    let records = sidecar.records();
    let mut known: BTreeMap<i64, &FrameRecord> = BTreeMap::new();
    for record in records {
        if let Some(number) = record.number {
            known.entry(number).or_insert(record);
        }
    }
    let numbers: Option<Vec<i64>> = frames.iter().map(|frame| frame.number).collect();
    let found = numbers.as_ref().and_then(|numbers| {
        let found = numbers.iter().map(|number| known.get(number).copied());
        found.collect::<Option<Vec<_>>>()
    });
    if let Some(records) = found {
        return Ok(FrameMatch {
            records,
            rule: "by frame number".to_owned(),
        });
    }
    // A counter of the clip says nothing about the numbers of a plate, and a single picture has none.
    let first = known.keys().next();
    let is_comparable = numbers.is_some() && first.is_some_and(|first| ![0, 1].contains(first));
    let fits = records.len() == frames.len() && is_consecutive(numbers.as_deref());
    if fits && !is_comparable {
        return Ok(FrameMatch {
            records: records.iter().collect(),
            rule: "in order, as neither time code nor frame number is common to both".to_owned(),
        });
    }
    let own = match known.is_empty() {
        true => format!("{} frames without numbers", records.len()),
        false => format!("frames {}", range_text(known.keys())),
    };
    let wanted = match &numbers {
        Some(numbers) => format!("frames {}", range_text(numbers.iter())),
        None => "a single picture without time code".to_owned(),
    };
    Err(FileError::new(
        sidecar.path(),
        "frames",
        format!("holds {own}, but the plate is {wanted}"),
        REMEDY,
    ))
}

fn is_consecutive(numbers: Option<&[i64]>) -> bool {
    numbers.is_none_or(|numbers| {
        (numbers.windows(2)).all(|pair| pair[0].checked_add(1) == Some(pair[1]))
    })
}
