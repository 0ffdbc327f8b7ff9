//! The finished binary: its exports, the C library that it needs, and whether it is stripped.

use std::fmt;
use std::fs;
use std::path::Path;
use std::str::FromStr;

use object::elf::FileHeader64;
use object::read::elf::FileHeader;
use object::{Endianness, File, Object, ObjectSection};

/// The exports of the plugin: the entry points of OpenFX.
const ENTRY_POINTS: [&str; 3] = ["OfxGetNumberOfPlugins", "OfxGetPlugin", "OfxSetHost"];

/// Prefix of the symbol versions of the GNU C library.
const GLIBC: &str = "GLIBC_";

/// A version of the GNU C library, such as 2.28.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct GlibcVersion {
    major: u32,
    minor: u32,
}

impl FromStr for GlibcVersion {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut numbers = text.split('.').map(str::parse);
        match (numbers.next(), numbers.next()) {
            // Some old versions have a third number.
            (Some(Ok(major)), Some(Ok(minor))) => Ok(Self { major, minor }),
            _ => Err(format!("{text}: is not a version; give one such as 2.28")),
        }
    }
}

impl fmt::Display for GlibcVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// The exports, needs and debug information of a binary.
#[derive(Debug, PartialEq)]
pub(crate) struct Binary {
    /// Names of its exports, sorted.
    pub(crate) exports: Vec<String>,
    /// The oldest GNU C library that has all symbols it needs; `None` if it needs none.
    pub(crate) glibc: Option<GlibcVersion>,
    /// Whether it contains debug information or, in ELF files, a symbol table.
    pub(crate) has_symbols: bool,
}

impl Binary {
    /// Reads the library at `path`: ELF, PE or Mach-O.
    ///
    /// # Errors
    /// A file that cannot be read or is none of these.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let failure = |e: String| format!("{}: {e}", path.display());
        let bytes = fs::read(path).map_err(|e| failure(e.to_string()))?;
        Self::parse(&bytes).map_err(|e| failure(e.to_string()))
    }

    fn parse(bytes: &[u8]) -> object::Result<Self> {
        let file = File::parse(bytes)?;
        let mut exports = Vec::new();
        for export in file.exports()? {
            let name = String::from_utf8_lossy(export.name()).into_owned();
            // Mach-O puts an underscore before names of C.
            let name = name.strip_prefix('_').unwrap_or(&name);
            exports.push(name.to_owned());
        }
        exports.sort_unstable();
        let is_debug = |name: &str| name.starts_with(".debug") || name == ".symtab";
        let has_symbols = (file.sections()).any(|section| section.name().is_ok_and(is_debug));
        let is_elf = matches!(file, File::Elf64(_));
        Ok(Self {
            exports,
            glibc: if is_elf { oldest_glibc(bytes)? } else { None },
            has_symbols,
        })
    }

    /// Checks that the plugin exports the entry points and nothing else, and is stripped.
    ///
    /// # Errors
    /// What is wrong.
    pub(crate) fn check_plugin(&self) -> Result<(), String> {
        if self.exports != ENTRY_POINTS {
            return Err(format!(
                "exports {}, not {}",
                self.exports.join(", "),
                ENTRY_POINTS.join(", ")
            ));
        }
        if self.has_symbols {
            return Err("is not stripped; leave CARGO_PROFILE_RELEASE_STRIP unset".to_owned());
        }
        Ok(())
    }

    /// Checks that it runs with the C library `oldest` and later ones.
    ///
    /// # Errors
    /// It needs a newer one.
    pub(crate) fn check_glibc(&self, oldest: GlibcVersion) -> Result<(), String> {
        match self.glibc {
            Some(needed) if needed > oldest => Err(format!("needs glibc {needed}, not {oldest}")),
            _ => Ok(()),
        }
    }
}

/// Returns the newest version of symbols of the GNU C library that an ELF file of 64 bits needs.
fn oldest_glibc(bytes: &[u8]) -> object::Result<Option<GlibcVersion>> {
    let header = FileHeader64::<Endianness>::parse(bytes)?;
    let endian = header.endian()?;
    let sections = header.sections(endian, bytes)?;
    let Some((mut libraries, strings)) = sections.gnu_verneed(endian, bytes)? else {
        return Ok(None);
    };
    let strings = sections.strings(endian, bytes, strings)?;
    let mut newest = None;
    while let Some((_, mut versions)) = libraries.next()? {
        while let Some(version) = versions.next()? {
            let name = String::from_utf8_lossy(version.name(endian, strings)?).into_owned();
            let version = name.strip_prefix(GLIBC).map(str::parse);
            newest = newest.max(version.and_then(Result::ok));
        }
    }
    Ok(newest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn version(text: &str) -> GlibcVersion {
        text.parse().expect("a version")
    }

    #[test]
    fn versions_are_ordered_by_number() {
        assert!(version("2.9") < version("2.28") && version("2.2.5") < version("2.28"));
        assert_eq!(version("2.28").to_string(), "2.28");
        assert!("2".parse::<GlibcVersion>().is_err() && "2.x".parse::<GlibcVersion>().is_err());
    }

    /// The plugin and the C library as cargo built them for the tests of the workspace.
    #[test]
    fn the_plugin_exports_the_entry_points_alone() {
        if !cfg!(target_os = "linux") {
            return;
        }
        let test = std::env::current_exe().expect("this test");
        let folder = test.parent().expect("a folder");
        let plugin = folder.join("libseidel_ofx.so");
        if !plugin.exists() {
            // `cargo test -p xtask` builds no plugin.
            return;
        }
        let plugin = Binary::read(&plugin).expect("an ELF file");
        assert_eq!(plugin.exports, ENTRY_POINTS);
        let glibc = plugin.glibc.expect("it needs a C library");
        assert!(glibc >= version("2.14"), "{glibc}: memcpy alone needs 2.14");
        plugin.check_glibc(version("9.0")).expect("old enough");
        let error = plugin.check_glibc(version("2.5")).expect_err("too new");
        assert!(error.contains("not 2.5"), "{error}");
        assert!(
            Binary::read(&test)
                .expect("this test")
                .check_plugin()
                .is_err()
        );
    }

    #[test]
    fn other_exports_and_symbols_are_refused() {
        let sound = || Binary {
            exports: ENTRY_POINTS.map(str::to_owned).to_vec(),
            glibc: None,
            has_symbols: false,
        };
        assert_eq!(sound().check_plugin(), Ok(()));
        let mut leaking = sound();
        leaking.exports.push("seidel_apply".to_owned());
        let error = leaking.check_plugin().expect_err("it leaks");
        assert!(error.contains("OfxSetHost, seidel_apply, not"), "{error}");
        let unstripped = Binary {
            has_symbols: true,
            ..sound()
        };
        let error = unstripped.check_plugin().expect_err("not stripped");
        assert!(error.contains("stripped"), "{error}");
    }
}
