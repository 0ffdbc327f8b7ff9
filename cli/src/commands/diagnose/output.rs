//! The folder that a diagnosis writes: whole or not at all, and known to be writable beforehand.

use std::path::{Path, PathBuf};

use seidel_core::diagnose::Diagnosis;
use seidel_core::observations::ObservationSet;

use super::super::CommandError;
use crate::files::atomic::{refuse_foreign, write_folder_whole, write_whole};
use crate::files::error::FileError;
use crate::files::manifest;
use crate::report::{self, Subject};

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
