//! The folder that a diagnosis writes: whole or not at all, and known to be writable beforehand.

use std::path::{Path, PathBuf};

use seidel_core::diagnose::Diagnosis;
use seidel_core::observations::ObservationSet;

use super::super::CommandError;
use crate::report::{self, Subject};
use seidel_image_io::atomic::{refuse_foreign, write_folder_whole, write_whole};
use seidel_image_io::error::FileError;
use seidel_image_io::observation_set as manifest;

const REPORT: &str = "report.json";
const PAGE: &str = "report.html";
const CORRECTED: &str = "corrected.json";

/// Folder of PSFs that were estimated.
const ESTIMATED: &str = "psf";

/// The files of the folder.
pub(super) const NAMES: [&str; 3] = [REPORT, PAGE, CORRECTED];

/// Where results go.
pub(super) struct Output {
    folder: PathBuf,
}

impl Output {
    /// Checks before long work that the folder can be taken, with estimated PSFs where there will be some, and
    /// that `lens` would not be lost.
    pub(super) fn checked(
        folder: &Path,
        lens: &Path,
        estimated: bool,
    ) -> Result<Self, CommandError> {
        let mut names = NAMES.to_vec();
        names.extend(estimated.then_some(ESTIMATED));
        refuse_foreign(folder, &names)?;
        let lost = |name: &str| {
            let target = folder.join(name).canonicalize();
            target.is_ok_and(|target| lens.canonicalize().is_ok_and(|lens| lens == target))
        };
        if NAMES.into_iter().any(lost) {
            return Err(FileError::new(
                lens,
                "",
                "is read by this command and would be overwritten",
                "give another folder to --out",
            )
            .into());
        }
        Ok(Self {
            folder: folder.to_path_buf(),
        })
    }

    /// Writes the report, for programs and for people, the corrected lens, and PSFs that were estimated.
    pub(super) fn write(
        &self,
        found: &Diagnosis,
        subject: &Subject,
        json: &str,
        estimated: Option<&ObservationSet>,
    ) -> Result<(), CommandError> {
        let corrected = found.corrected.to_json();
        let page = report::html(found, subject);
        let files = [(REPORT, json), (PAGE, &page), (CORRECTED, &corrected)];
        write_folder_whole(&self.folder, |at| {
            if let Some(set) = estimated {
                manifest::write(set, &at.join(ESTIMATED))?;
            }
            files.iter().try_for_each(|(name, text)| {
                write_whole(&at.join(name), |out| {
                    std::io::Write::write_all(out, text.as_bytes())
                })
            })
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::lens::lens;
    use crate::demo::observations::measured;
    use crate::report::made::{diagnosis, subject};
    use seidel_core::diagnose::Verdict;
    use seidel_core::profile::LensProfile;
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
    fn all_is_written_and_can_be_read_again() {
        let root = tempfile::tempdir().expect("a folder");
        let out = root.path().join("deep/out");
        let found = diagnosis(Verdict::Explained);
        let output = Output::checked(&out, Path::new("lens.json"), false).expect("free");
        output
            .write(&found, &subject(), "{}\n", None)
            .expect("writable");
        assert_eq!(
            names(&out),
            ["corrected.json", "report.html", "report.json"]
        );
        let text = seidel_image_io::json::read_text(&out.join(CORRECTED), 1 << 20).expect("there");
        assert_eq!(
            LensProfile::from_json(&text).expect("a lens"),
            found.corrected
        );
        // Again into the same folder, now with PSFs.
        let set = measured(&lens(320, 180).expect("a lens")).expect("a set");
        let output = Output::checked(&out, Path::new("lens.json"), true).expect("its own files");
        output
            .write(&found, &subject(), "{}\n", Some(&set))
            .expect("writable");
        let back = read(&out.join(ESTIMATED), ReadOptions::default()).expect("a set");
        assert_eq!(back.set.observations.len(), set.observations.len());
        // A later report without them would lose them.
        assert!(Output::checked(&out, Path::new("lens.json"), false).is_err());
        let lens = out.join(CORRECTED);
        assert!(Output::checked(&out, &lens, true).is_err());
    }
}
