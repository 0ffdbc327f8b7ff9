//! The folder that a diagnosis writes: whole or not at all, and known to be writable beforehand.

use std::path::{Path, PathBuf};

use seidel_core::diagnose::Diagnosis;

use super::super::CommandError;
use crate::files::atomic::{refuse_foreign, write_folder_whole, write_whole};
use crate::files::error::FileError;
use crate::report::{self, Subject};

const REPORT: &str = "report.json";
const PAGE: &str = "report.html";
const CORRECTED: &str = "corrected.json";

/// The files of the folder.
pub(super) const NAMES: [&str; 3] = [REPORT, PAGE, CORRECTED];

/// Where results go.
pub(super) struct Output {
    folder: PathBuf,
}

impl Output {
    /// Checks before long work that the folder can be taken and that `lens` would not be lost.
    pub(super) fn checked(folder: &Path, lens: &Path) -> Result<Self, CommandError> {
        refuse_foreign(folder, &NAMES)?;
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

    /// Writes the report, for programs and for people, and the corrected lens.
    pub(super) fn write(
        &self,
        found: &Diagnosis,
        subject: &Subject,
        json: &str,
    ) -> Result<(), CommandError> {
        let corrected = found.corrected.to_json();
        let page = report::html(found, subject);
        let files = [(REPORT, json), (PAGE, &page), (CORRECTED, &corrected)];
        write_folder_whole(&self.folder, |at| {
            files.iter().try_for_each(|(name, text)| {
                write_whole(&at.join(name), |out| {
                    std::io::Write::write_all(out, text.as_bytes())
                })
            })
        })?;
        Ok(())
    }
}
