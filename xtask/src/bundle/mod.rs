//! The OpenFX bundle: built, laid out as hosts look for it, and installed.

mod icon;
mod install;
mod layout;
mod plist;
mod png;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use layout::{Platform, lay_out};

/// Name of the bundle, and of the binary in it: hosts want them to be the same.
const NAME: &str = "Seidel";

/// What was asked for.
#[derive(Debug, Default, PartialEq)]
struct Choices {
    target: Option<String>,
    install: bool,
    to: Option<PathBuf>,
}

pub(crate) const USAGE: &str = "cargo xtask bundle [--target TRIPLE] [--install [--to FOLDER]]";

fn choices(arguments: impl Iterator<Item = String>) -> Result<Choices, String> {
    let mut chosen = Choices::default();
    let mut arguments = arguments;
    while let Some(argument) = arguments.next() {
        let mut value = || {
            let value = arguments.next();
            value.ok_or_else(|| format!("{argument} needs a value; usage: {USAGE}"))
        };
        match argument.as_str() {
            "--install" => chosen.install = true,
            "--target" => chosen.target = Some(value()?),
            "--to" => chosen.to = Some(value()?.into()),
            other => return Err(format!("{other} is not known; usage: {USAGE}")),
        }
    }
    if chosen.to.is_some() && !chosen.install {
        return Err(format!("--to needs --install; usage: {USAGE}"));
    }
    Ok(chosen)
}

/// Does it; what was done, in words.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let choices = choices(arguments)?;
    let triple = choices.target.clone().unwrap_or_else(host_triple);
    let platform = Platform::of(&triple)?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    build(root, &cargo, choices.target.as_deref())?;
    let target = target_folder(root, &cargo)?;
    let binary = built_in(&target, choices.target.as_deref()).join(platform.library);
    let bundle = lay_out(&target, &binary, &platform)?;
    let mut said = format!("bundle: {}", bundle.display());
    if choices.install {
        let place = install::install(&bundle, choices.to)?;
        said = format!("{said}\n{place}");
    }
    Ok(said)
}

fn host_triple() -> String {
    let system = match std::env::consts::OS {
        "macos" => "apple-darwin",
        "windows" => "pc-windows-msvc",
        _ => "unknown-linux-gnu",
    };
    format!("{}-{system}", std::env::consts::ARCH)
}

fn build(root: &Path, cargo: &OsString, target: Option<&str>) -> Result<(), String> {
    let mut command = Command::new(cargo);
    command.current_dir(root);
    command.args(["build", "--release", "-p", "seidel-ofx"]);
    command.args(target.iter().flat_map(|triple| ["--target", triple]));
    let status = command.status().map_err(|e| format!("cargo: {e}"))?;
    match status.success() {
        true => Ok(()),
        false => Err("the plugin could not be built; see above".to_owned()),
    }
}

/// Where cargo builds, as it says itself.
fn target_folder(root: &Path, cargo: &OsString) -> Result<PathBuf, String> {
    let mut command = Command::new(cargo);
    command.current_dir(root);
    command.args(["metadata", "--format-version", "1", "--no-deps"]);
    let output = command.output().map_err(|e| format!("cargo: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let folder = text
        .split_once("\"target_directory\":\"")
        .and_then(|(_, rest)| rest.split_once('"'))
        .map(|(folder, _)| folder.replace("\\\\", "\\"));
    folder
        .map(PathBuf::from)
        .ok_or_else(|| "cargo metadata did not say where it builds".to_owned())
}

fn built_in(target: &Path, triple: Option<&str>) -> PathBuf {
    triple
        .map_or_else(|| target.to_path_buf(), |triple| target.join(triple))
        .join("release")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_read_and_others_refused() {
        let read = |text: &str| choices(text.split_whitespace().map(str::to_owned));
        let all = read("--install --to a/b --target x86_64-pc-windows-msvc");
        assert_eq!(
            all,
            Ok(Choices {
                target: Some("x86_64-pc-windows-msvc".into()),
                install: true,
                to: Some("a/b".into()),
            })
        );
        for bad in ["--instal", "--to x", "--install --to"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
