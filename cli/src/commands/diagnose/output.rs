//! The output folder of a diagnosis: checked before long work, written whole or not at all.

use std::path::{Path, PathBuf};

use seidel_core::{Diagnosis, ObservationSet};

use super::super::{CommandError, write_text};
use super::plate_gap::PlateGapMaps;
use crate::report::{self, Subject};
use seidel_image_io::atomic::{check_folder_content, write_folder_atomically};
use seidel_image_io::error::FileError;
use seidel_image_io::observation_set as manifest;

const REPORT: &str = "report.json";
const PAGE: &str = "report.html";
const CORRECTED: &str = "corrected.json";

/// Subfolder of PSFs estimated from a picture pair or measured in photographs.
const ESTIMATED: &str = "psf";

/// Subfolder of a set whose books are corrected. A folder that has one is refused: the next diagnosis may have none.
const CORRECTED_SET: &str = "corrected-set";

/// The files that every diagnosis writes.
pub(super) const FILES: [&str; 3] = [REPORT, PAGE, CORRECTED];

/// The entries of a folder that also gets PSFs.
pub(super) const ENTRIES_OF_PAIR: [&str; 4] = [REPORT, PAGE, CORRECTED, ESTIMATED];

/// A folder that may be replaced by the results of a diagnosis.
pub(super) struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Checks that `folder` holds nothing but the `entries` to be written, and not the `lens` that is read.
    ///
    /// # Errors
    /// Foreign files in the folder, and a lens that would be overwritten.
    pub(super) fn check(
        folder: &Path,
        lens: &Path,
        entries: &[&str],
    ) -> Result<Self, CommandError> {
        check_folder_content(folder, entries)?;
        let is_lens = |name: &str| {
            let target = folder.join(name).canonicalize();
            target.is_ok_and(|target| lens.canonicalize().is_ok_and(|lens| lens == target))
        };
        if FILES.into_iter().any(is_lens) {
            return Err(FileError::new(
                lens,
                "",
                "is read by this command and would be overwritten",
                "give another folder to --out",
            )
            .into());
        }
        Ok(Self {
            path: folder.to_path_buf(),
        })
    }

    /// Writes `json` as the report, the HTML page, the corrected lens, and the `estimated` PSFs and the maps of the plate's gap
    /// if any.
    pub(super) fn write(
        &self,
        diagnosis: &Diagnosis,
        subject: &Subject,
        json: &str,
        estimated: Option<&ObservationSet>,
        maps: Option<&PlateGapMaps>,
    ) -> Result<(), CommandError> {
        let corrected = diagnosis.corrected.to_json();
        let page = report::html(diagnosis, subject);
        let files = [(REPORT, json), (PAGE, &page), (CORRECTED, &corrected)];
        write_folder_atomically(&self.path, |at| {
            if let Some(set) = estimated {
                manifest::write(set, &at.join(ESTIMATED))?;
            }
            let found = diagnosis.bookkeeping.as_ref();
            if let Some(found) = found.filter(|found| found.can_be_corrected) {
                manifest::write(&found.corrected, &at.join(CORRECTED_SET))?;
            }
            if let Some(maps) = maps {
                maps.write(at)?;
            }
            files
                .iter()
                .try_for_each(|(name, text)| write_text(&at.join(name), text))
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::lens::lens;
    use crate::demo::observations::measured;
    use crate::report::samples::{diagnosis, subject};
    use seidel_core::{LensProfile, Verdict};
    use seidel_image_io::observation_set::{ReadOptions, read};
    use std::path::Path;

    fn names(folder: &Path) -> Vec<String> {
        let entries = folder.read_dir().expect("there").flatten();
        let mut names: Vec<String> = entries
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn all_files_are_written_and_can_be_read_back() {
        let root = tempfile::tempdir().expect("a folder");
        let out = root.path().join("deep/out");
        let diagnosis = diagnosis(Verdict::Explained);
        let output = OutputFolder::check(&out, Path::new("lens.json"), &FILES).expect("free");
        output
            .write(&diagnosis, &subject(), "{}\n", None, None)
            .expect("writable");
        assert_eq!(
            names(&out),
            ["corrected.json", "report.html", "report.json"]
        );
        let text = seidel_image_io::json::read_text(&out.join(CORRECTED), 1 << 20).expect("there");
        assert_eq!(
            LensProfile::from_json(&text).expect("a lens"),
            diagnosis.corrected
        );
        // A second report in the same folder, now with PSFs.
        let set = measured(&lens(320, 180).expect("a lens")).expect("a set");
        let output = OutputFolder::check(&out, Path::new("lens.json"), &ENTRIES_OF_PAIR)
            .expect("its own files");
        output
            .write(&diagnosis, &subject(), "{}\n", Some(&set), None)
            .expect("writable");
        let back = read(&out.join(ESTIMATED), ReadOptions::default()).expect("a set");
        assert_eq!(back.set.observations.len(), set.observations.len());
        // A later report without PSFs would delete them.
        assert!(OutputFolder::check(&out, Path::new("lens.json"), &FILES).is_err());
        let lens = out.join(CORRECTED);
        assert!(OutputFolder::check(&out, &lens, &ENTRIES_OF_PAIR).is_err());
    }
}
