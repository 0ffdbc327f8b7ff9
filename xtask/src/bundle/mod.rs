//! The OpenFX bundle: built, laid out as hosts expect it, and installed.

mod binary;
mod icon;
mod install;
mod layout;
pub(crate) mod notices;
mod plist;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) use binary::{Binary, GlibcVersion};
use layout::{Contents, Platform};

/// Name of the bundle and of the binary in it. OpenFX requires them to be equal.
const NAME: &str = "Seidel";

/// The package of the plugin.
const PACKAGE: &str = "seidel-ofx";

/// Beginning of the notices of the bundle.
const NOTICES_HEAD: &str = "Seidel is licensed under MIT OR Apache-2.0. Its OpenFX plugin contains the following libraries.";

/// Identifier of the plugin, which is also the name of its icon.
const IDENTIFIER: &str = "org.seidel.lensblur";

const USAGE: &str = "usage: cargo xtask bundle [OPTIONS]
  --target TRIPLE   build for another platform whose target and linker are installed; may be repeated. The default is this platform
  --all             build for every target that rustup has installed and OpenFX has a folder for
  --glibc VERSION   build for Linux with this C library or a newer one, such as 2.28, by cargo-zigbuild
  --install         copy the bundle to where hosts look for plugins, and say which do
  --to FOLDER       with --install: copy it to this folder

The bundle lies in cargo's target folder. It keeps the platforms that were built before for the same version.";

/// Files with the project's own licences.
const LICENCES: [&str; 2] = ["LICENSE-MIT", "LICENSE-APACHE"];

/// The options of the command line.
#[derive(Debug, Default, PartialEq)]
struct Options {
    targets: Vec<String>,
    all: bool,
    glibc: Option<GlibcVersion>,
    install: bool,
    to: Option<PathBuf>,
    help: bool,
}

impl Options {
    fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self::default();
        while let Some(argument) = arguments.next() {
            let mut value = || {
                let value = arguments.next();
                value.ok_or_else(|| format!("{argument} needs a value\n{USAGE}"))
            };
            match argument.as_str() {
                "--help" | "-h" => options.help = true,
                "--all" => options.all = true,
                "--install" => options.install = true,
                "--target" => options.targets.push(value()?),
                "--glibc" => options.glibc = Some(value()?.parse()?),
                "--to" => options.to = Some(value()?.into()),
                other => return Err(format!("unknown argument {other}\n{USAGE}")),
            }
        }
        if options.to.is_some() && !options.install {
            return Err(format!("--to needs --install\n{USAGE}"));
        }
        if options.all && !options.targets.is_empty() {
            return Err(format!("give --all or --target, not both\n{USAGE}"));
        }
        Ok(options)
    }
}

/// Builds the bundle and, if asked to, installs it; returns a report.
///
/// # Errors
/// Wrong arguments, a failed build, a binary that exports or needs too much, a dependency without a licence, and folders that
/// cannot be written.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let options = Options::parse(arguments)?;
    if options.help {
        return Ok(USAGE.to_owned());
    }
    let mut targets: Vec<Option<String>> = options.targets.into_iter().map(Some).collect();
    if options.all {
        targets = installed_targets()?.into_iter().map(Some).collect();
    } else if targets.is_empty() {
        targets.push(None);
    }
    let mut report = String::new();
    let mut bundle = PathBuf::new();
    for target in targets {
        let made = make(root, target.as_deref(), options.glibc)?;
        report.push_str(&made.report);
        bundle = made.path;
    }
    report.push_str(&format!("bundle: {}", bundle.display()));
    if options.install {
        report.push('\n');
        report.push_str(&install::install(&bundle, options.to)?);
    }
    Ok(report)
}

/// Returns the targets that rustup has installed and OpenFX has a folder for.
fn installed_targets() -> Result<Vec<String>, String> {
    let listed = Command::new("rustup")
        .args(["target", "list", "--installed"])
        .output()
        .map_err(|e| format!("rustup: {e}; name each platform with --target"))?;
    let text = String::from_utf8_lossy(&listed.stdout).into_owned();
    Ok(text
        .lines()
        .map(str::to_owned)
        .filter(|triple| Platform::from_triple(triple).is_ok())
        .collect())
}

/// A bundle with the binary of one more platform.
pub(crate) struct MadeBundle {
    /// Its folder.
    pub(crate) path: PathBuf,
    /// Folders of the platforms that were built before.
    pub(crate) kept: Vec<&'static str>,
    /// The platforms that were built and kept, one line each.
    report: String,
}

/// Builds the plugin for `target`, or for this platform, with the C library `glibc` or that of this system, and lays out the bundle.
///
/// # Errors
/// A failed build, a binary that exports or needs too much, a dependency without a licence, and folders that cannot be written.
pub(crate) fn make(
    root: &Path,
    target: Option<&str>,
    glibc: Option<GlibcVersion>,
) -> Result<MadeBundle, String> {
    let triple = target.map_or_else(host_triple, str::to_owned);
    let platform = Platform::from_triple(&triple)?;
    let cargo = Cargo::new(root);
    let notices = notices::generate(&cargo, &[PACKAGE], &triple, NOTICES_HEAD)?;
    let output = cargo.target_folder()?;
    let library = cargo
        .build(&[PACKAGE], target, glibc)?
        .join(platform.library);
    let binary = Binary::read(&library)?;
    let fault = |problem: String| format!("{}: {problem}", library.display());
    binary.check_plugin().map_err(fault)?;
    if let Some(glibc) = glibc {
        binary.check_glibc(glibc).map_err(fault)?;
    }
    let licences = LICENCES.map(|name| {
        let text = std::fs::read_to_string(root.join(name));
        text.map(|text| (name, text))
            .map_err(|e| format!("{name}: {e}"))
    });
    let licences = licences.into_iter().collect::<Result<Vec<_>, _>>()?;
    let contents = Contents {
        binary: &library,
        notices: &notices,
        licences: &licences,
    };
    let bundle = layout::write(&output, &platform, &contents)?;
    let needed = binary.glibc.map_or_else(String::new, |glibc| {
        format!(", needs glibc {glibc} or newer")
    });
    let mut report = format!("built: {}{needed}\n", platform.folder);
    for kept in &bundle.kept {
        report.push_str(&format!("kept: {kept}, built before\n"));
    }
    Ok(MadeBundle {
        path: bundle.path,
        kept: bundle.kept,
        report,
    })
}

pub(crate) fn host_triple() -> String {
    let system = match std::env::consts::OS {
        "macos" => "apple-darwin",
        "windows" => "pc-windows-msvc",
        _ => "unknown-linux-gnu",
    };
    format!("{}-{system}", std::env::consts::ARCH)
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

    /// Builds `packages` with optimisation for `target`, or for this platform; returns the folder of the results. With `glibc`, for
    /// Linux with this C library, by cargo-zigbuild.
    ///
    /// # Errors
    /// A failed build.
    pub(crate) fn build(
        &self,
        packages: &[&str],
        target: Option<&str>,
        glibc: Option<GlibcVersion>,
    ) -> Result<PathBuf, String> {
        let triple = target.map_or_else(host_triple, str::to_owned);
        let glibc = glibc.filter(|_| triple.contains("linux-gnu"));
        let (build, target) = match glibc {
            Some(glibc) => ("zigbuild", Some(format!("{triple}.{glibc}"))),
            None => ("build", target.map(str::to_owned)),
        };
        let mut command = self.command(&[build, "--profile", "dist", "--locked"]);
        command.args(packages.iter().flat_map(|package| ["-p", package]));
        command.args(target.iter().flat_map(|triple| ["--target", triple]));
        let status = command.status().map_err(|e| format!("cargo: {e}"))?;
        if !status.success() {
            let advice = if glibc.is_some() {
                ". --glibc needs cargo-zigbuild: `pip install cargo-zigbuild`"
            } else {
                ""
            };
            return Err(format!(
                "{} could not be built for {triple}; see the messages above{advice}",
                packages.join(", ")
            ));
        }
        let folder = self.target_folder()?;
        let folder = match target {
            Some(_) => folder.join(triple),
            None => folder,
        };
        Ok(folder.join("dist"))
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
        let all = parse("--install --to a/b --target x86_64-pc-windows-gnu --glibc 2.28");
        assert_eq!(
            all,
            Ok(Options {
                targets: vec!["x86_64-pc-windows-gnu".into()],
                glibc: Some("2.28".parse().expect("a version")),
                install: true,
                to: Some("a/b".into()),
                ..Options::default()
            })
        );
        let targets = parse("--target a --target b").map(|options| options.targets);
        assert_eq!(targets, Ok(vec!["a".to_owned(), "b".to_owned()]));
        for wrong in [
            "--instal",
            "--to x",
            "--install --to",
            "--all --target a",
            "--glibc new",
        ] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn help_is_no_failure_and_lists_all_options() {
        for help in ["--help", "-h"] {
            let text = run(Path::new("."), [help.to_owned()].into_iter()).expect("help");
            for option in ["--target", "--all", "--glibc", "--install", "--to"] {
                assert!(text.contains(option), "{option}");
            }
        }
    }
}
