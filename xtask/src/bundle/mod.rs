//! The OpenFX bundle: built, laid out as hosts expect it, and installed.

mod icon;
mod install;
mod layout;
pub(crate) mod notices;
mod plist;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use layout::{Contents, Platform};

/// Name of the bundle and of the binary in it. OpenFX requires them to be equal.
const NAME: &str = "Seidel";

/// The package of the plugin.
const PACKAGE: &str = "seidel-ofx";

/// Beginning of the notices of the bundle.
const NOTICES_HEAD: &str = "Seidel is licensed under MIT OR Apache-2.0. Its OpenFX plugin contains the following libraries.";

/// Identifier of the plugin, which is also the name of its icon.
const IDENTIFIER: &str = "org.seidel.lensblur";

const USAGE: &str = "cargo xtask bundle [--target TRIPLE] [--install [--to FOLDER]]";

/// The options of the command line.
#[derive(Debug, Default, PartialEq)]
struct Options {
    target: Option<String>,
    install: bool,
    to: Option<PathBuf>,
}

impl Options {
    fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self::default();
        while let Some(argument) = arguments.next() {
            let mut value = || {
                let value = arguments.next();
                value.ok_or_else(|| format!("{argument} needs a value; usage: {USAGE}"))
            };
            match argument.as_str() {
                "--install" => options.install = true,
                "--target" => options.target = Some(value()?),
                "--to" => options.to = Some(value()?.into()),
                other => return Err(format!("unknown argument {other}; usage: {USAGE}")),
            }
        }
        if options.to.is_some() && !options.install {
            return Err(format!("--to needs --install; usage: {USAGE}"));
        }
        Ok(options)
    }
}

/// Builds the bundle and, if asked to, installs it; returns a report.
///
/// # Errors
/// Wrong arguments, a failed build, a dependency without a licence, and folders that cannot be written.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let options = Options::parse(arguments)?;
    let bundle = make(root, options.target.as_deref())?;
    let mut report = format!("bundle: {}", bundle.display());
    if options.install {
        report.push('\n');
        report.push_str(&install::install(&bundle, options.to)?);
    }
    Ok(report)
}

/// Builds the plugin for `target`, or for this platform, and lays out the bundle; returns its folder.
///
/// # Errors
/// A failed build, a dependency without a licence, and folders that cannot be written.
pub(crate) fn make(root: &Path, target: Option<&str>) -> Result<PathBuf, String> {
    let triple = target.map_or_else(host_triple, str::to_owned);
    let platform = Platform::from_triple(&triple)?;
    let cargo = Cargo::new(root);
    let notices = notices::generate(&cargo, &[PACKAGE], &triple, NOTICES_HEAD)?;
    cargo.build(&[PACKAGE], target)?;
    let output = cargo.target_folder()?;
    let binary = release_folder(&output, target).join(platform.library);
    let contents = Contents {
        binary: &binary,
        notices: &notices,
    };
    layout::write(&output, &platform, &contents)
}

pub(crate) fn host_triple() -> String {
    let system = match std::env::consts::OS {
        "macos" => "apple-darwin",
        "windows" => "pc-windows-msvc",
        _ => "unknown-linux-gnu",
    };
    format!("{}-{system}", std::env::consts::ARCH)
}

pub(crate) fn release_folder(target_folder: &Path, triple: Option<&str>) -> PathBuf {
    let folder = triple.map_or_else(
        || target_folder.to_path_buf(),
        |triple| target_folder.join(triple),
    );
    folder.join("release")
}

/// The cargo that runs this task.
pub(crate) struct Cargo<'a> {
    program: OsString,
    root: &'a Path,
}

impl<'a> Cargo<'a> {
    pub(crate) fn new(root: &'a Path) -> Self {
        let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        Self { program, root }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.current_dir(self.root).args(arguments);
        command
    }

    /// Returns the output of a command.
    fn output(&self, arguments: &[&str]) -> Result<String, String> {
        let output = self.command(arguments).output();
        let output = output.map_err(|e| format!("cargo: {e}"))?;
        if output.status.success() {
            Ok(String::from_utf8_lossy(&output.stdout).into_owned())
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into_owned())
        }
    }

    /// Builds `packages` with optimisation.
    pub(crate) fn build(&self, packages: &[&str], target: Option<&str>) -> Result<(), String> {
        let mut command = self.command(&["build", "--release", "--locked"]);
        command.args(packages.iter().flat_map(|package| ["-p", package]));
        command.args(target.iter().flat_map(|triple| ["--target", triple]));
        let status = command.status().map_err(|e| format!("cargo: {e}"))?;
        if status.success() {
            Ok(())
        } else {
            Err(format!(
                "{} could not be built; see the messages above",
                packages.join(", ")
            ))
        }
    }

    /// The folder that cargo builds in.
    pub(crate) fn target_folder(&self) -> Result<PathBuf, String> {
        let text = self.output(&["metadata", "--format-version", "1", "--no-deps"])?;
        let metadata: serde_json::Value =
            serde_json::from_str(&text).map_err(|e| format!("cargo metadata: {e}"))?;
        let folder = metadata["target_directory"].as_str();
        folder
            .map(PathBuf::from)
            .ok_or_else(|| "cargo metadata: has no target_directory".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_parsed_and_unknown_ones_refused() {
        let parse = |text: &str| Options::parse(text.split_whitespace().map(str::to_owned));
        let all = parse("--install --to a/b --target x86_64-pc-windows-msvc");
        assert_eq!(
            all,
            Ok(Options {
                target: Some("x86_64-pc-windows-msvc".into()),
                install: true,
                to: Some("a/b".into()),
            })
        );
        for wrong in ["--instal", "--to x", "--install --to"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
