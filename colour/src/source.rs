//! Choice of the OpenColorIO config.

use std::fmt;
use std::path::PathBuf;

/// Seidel's own config, generated from `luts/curves.toml` by `cargo xtask luts`.
pub const EMBEDDED_CONFIG: &str = include_str!("../../luts/config.ocio");

/// The name by which users select [`EMBEDDED_CONFIG`].
const EMBEDDED: &str = "seidel";

/// Prefix of the names of configs that come with OpenColorIO.
const BUILT_IN: &str = "ocio://";

/// The source of a config.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// Seidel's own config: [`EMBEDDED_CONFIG`].
    Embedded,
    /// A config that comes with OpenColorIO, by name without `ocio://`, such as `studio-config-latest`.
    BuiltIn(String),
    /// A file: `.ocio`, or `.ocioz` with its tables.
    File(PathBuf),
    /// A config in memory.
    Text {
        /// Its name in messages.
        name: String,
        /// The config.
        yaml: String,
    },
}

impl Source {
    /// Parses the name of a config: `seidel` for Seidel's own, `ocio://NAME`, or a path.
    pub fn named(name: &str) -> Self {
        match name.strip_prefix(BUILT_IN) {
            Some(name) => Self::BuiltIn(name.to_owned()),
            None if name == EMBEDDED => Self::Embedded,
            None => Self::File(PathBuf::from(name)),
        }
    }

    /// Chooses `given`, else `environment` (the variable `OCIO`), else Seidel's own config.
    ///
    /// A blank variable counts as unset; OpenColorIO would take it for a config without colour management.
    pub fn chosen(given: Option<&str>, environment: Option<&str>) -> Self {
        let environment = environment.filter(|name| !name.trim().is_empty());
        given.or(environment).map_or(Self::Embedded, Self::named)
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Embedded => f.write_str("Seidel's own config"),
            Self::BuiltIn(name) => write!(f, "{BUILT_IN}{name}"),
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Text { name, .. } => f.write_str(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn given_name_precedes_environment_and_default() {
        let file = |name: &str| Source::File(PathBuf::from(name));
        for (given, environment, want) in [
            (Some("a.ocio"), Some("b.ocio"), file("a.ocio")),
            (None, Some("b.ocio"), file("b.ocio")),
            (None, None, Source::Embedded),
            (None, Some(""), Source::Embedded),
            (None, Some("  "), Source::Embedded),
            (Some("seidel"), Some("b.ocio"), Source::Embedded),
            (Some("ocio://x"), None, Source::BuiltIn("x".to_owned())),
        ] {
            assert_eq!(Source::chosen(given, environment), want);
        }
        assert_eq!(Source::named("ocio://x").to_string(), "ocio://x");
    }
}
