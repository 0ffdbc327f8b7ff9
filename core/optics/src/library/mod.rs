//! The lens library: designed lenses that come with the program, each with a sheet that describes it.
//!
//! The files of `core/optics/library` are written by `cargo xtask library` from the designs in `xtask/src/library`. They
//! are ordinary lens profiles, scaled to any plate like others.
//!
//! ```
//! use seidel_optics::library::LibraryLens;
//!
//! let lens = LibraryLens::by_reference("library:swirl-58").expect("a name of the library")?;
//! assert_eq!(lens.profile()?.camera.focal_length_mm, Some(58.0));
//! # Ok::<(), seidel_optics::Error>(())
//! ```

mod sheet;

pub use sheet::{Sensor, Sheet};

use crate::error::{Error, Result};
use crate::profile::LensProfile;

/// The prefix of the name of a library lens where a file could stand.
pub const PREFIX: &str = "library:";

/// The environment variable that names a folder of own profiles, which programs find by name beside the library.
pub const FOLDER_VARIABLE: &str = "SEIDEL_LENSES";

/// A lens of the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LibraryLens {
    /// Name without [`PREFIX`].
    pub name: &'static str,
    /// The lens profile, as JSON.
    pub profile_json: &'static str,
    /// The sheet, as JSON.
    pub sheet_json: &'static str,
}

macro_rules! library {
    ($($name:literal),+ $(,)?) => {
        /// The lenses of the library.
        pub static ALL: &[LibraryLens] = &[$(LibraryLens {
            name: $name,
            profile_json: include_str!(concat!("../../library/", $name, ".json")),
            sheet_json: include_str!(concat!("../../library/", $name, ".sheet.json")),
        }),+];
    };
}

library! {
    "modern-50",
    "soft-portrait-85",
    "swirl-58",
    "wide-zoom-16",
    "anamorphic-75",
    "bubble-100",
    "mirror-500",
    "macro-100",
}

impl LibraryLens {
    /// Returns the lens called `name`, without [`PREFIX`].
    ///
    /// # Errors
    /// An unknown name; the remedy has the nearest one.
    pub fn by_name(name: &str) -> Result<&'static Self> {
        let wanted = name.trim().to_ascii_lowercase();
        ALL.iter().find(|lens| lens.name == wanted).ok_or_else(|| {
            let nearness = |lens: &&LibraryLens| {
                // A part of a name, such as `swirl`, counts as nearly the name.
                let is_part = !wanted.is_empty() && lens.name.contains(&wanted);
                strsim::jaro_winkler(lens.name, &wanted) + f64::from(u8::from(is_part))
            };
            let nearest = (ALL.iter()).max_by(|a, b| nearness(a).total_cmp(&nearness(b)));
            let nearest = nearest.map_or("", |lens| lens.name);
            Error::new(
                format!("{PREFIX}{name}"),
                "is not the name of a lens of the library",
                format!(
                    "the nearest name is {PREFIX}{nearest}; choose it or another lens of the library"
                ),
            )
        })
    }

    /// Returns the lens that `reference` names by [`PREFIX`] and its name; `None` for the path of a file.
    ///
    /// Callers that open files look for a file of that name first.
    pub fn by_reference(reference: &str) -> Option<Result<&'static Self>> {
        reference.strip_prefix(PREFIX).map(Self::by_name)
    }

    /// Returns the lens profile.
    ///
    /// # Errors
    /// A profile of the library that is not valid, which its tests exclude.
    pub fn profile(&self) -> Result<LensProfile> {
        LensProfile::from_json(self.profile_json).map_err(|e| e.within(self.name))
    }

    /// Returns the sheet.
    ///
    /// # Errors
    /// A sheet of the library that is not valid, which its tests exclude.
    pub fn sheet(&self) -> Result<Sheet> {
        Sheet::from_json(self.sheet_json).map_err(|e| e.within(self.name))
    }
}

/// Returns the name of the file in a folder of profiles that `reference` names by [`PREFIX`]; `None` for the path of a file,
/// and for names that lead out of the folder.
pub fn file_name(reference: &str) -> Option<String> {
    let name = reference.strip_prefix(PREFIX)?.trim();
    let is_plain = !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\', ':']);
    is_plain.then(|| format!("{name}.json"))
}

#[cfg(test)]
mod tests;
