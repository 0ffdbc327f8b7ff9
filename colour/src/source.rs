//! Which config is used.

use std::fmt;
use std::path::PathBuf;

/// The project's own config, made from `luts/curves.toml` by `cargo xtask luts`.
pub const OWN_CONFIG: &str = include_str!("../../luts/config.ocio");

/// What users call it.
const OWN: &str = "seidel";

/// What the names of configs that come with OpenColorIO begin with.
const BUILT_IN: &str = "ocio://";

/// Where a config comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// The project's own: [`OWN_CONFIG`].
    Own,
    /// One that comes with OpenColorIO, by its name such as `studio-config-latest`.
    BuiltIn(String),
    /// A file: `.ocio`, or `.ocioz` with its tables.
    File(PathBuf),
    /// A text in memory, and what to call it.
    Text {
        /// Its name in messages.
        name: String,
        /// The config.
        yaml: String,
    },
}

impl Source {
    /// The config that a user calls `name`: `seidel` for the project's own, `ocio://NAME`, or a path.
    pub fn named(name: &str) -> Self {
        match name.strip_prefix(BUILT_IN) {
            Some(name) => Self::BuiltIn(name.to_owned()),
            None if name == OWN => Self::Own,
            None => Self::File(PathBuf::from(name)),
        }
    }

    /// The config `given`, else the one that `environment` (the variable `OCIO`) names, else the project's own. An empty
    /// variable is as good as none: OpenColorIO would take either for a config without colour.
    pub fn chosen(given: Option<&str>, environment: Option<&str>) -> Self {
        let environment = environment.filter(|name| !name.trim().is_empty());
        given.or(environment).map_or(Self::Own, Self::named)
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Own => f.write_str("Seidel's own config"),
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
    fn what_is_given_goes_before_the_environment_and_that_before_our_own() {
        let file = |name: &str| Source::File(PathBuf::from(name));
        for (given, environment, want) in [
            (Some("a.ocio"), Some("b.ocio"), file("a.ocio")),
            (None, Some("b.ocio"), file("b.ocio")),
            (None, None, Source::Own),
            (None, Some(""), Source::Own),
            (None, Some("  "), Source::Own),
            (Some("seidel"), Some("b.ocio"), Source::Own),
            (Some("ocio://x"), None, Source::BuiltIn("x".to_owned())),
        ] {
            assert_eq!(Source::chosen(given, environment), want);
        }
        assert_eq!(Source::named("ocio://x").to_string(), "ocio://x");
    }
}
