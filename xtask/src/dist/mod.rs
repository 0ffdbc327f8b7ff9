//! `cargo xtask dist`: the release archive of this platform, with notices and checksums.

mod archive;
mod package;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::bundle::{self, Binary, Cargo, GlibcVersion, host_triple, notices};
use crate::header;
use archive::{Entry, Mode};

const USAGE: &str = "usage: cargo xtask dist [--target TRIPLE] [--glibc VERSION] [--to FOLDER]; the options of `bundle`";

/// The packages whose libraries the notices list: the command, the C library and the plugin.
const PACKAGES: [&str; 3] = ["seidel", "seidel-plugin", "seidel-ofx"];

/// Beginning of the notices.
const NOTICES_HEAD: &str = "Seidel is licensed under MIT OR Apache-2.0. Its command, C library and OpenFX plugin contain the following libraries.";

/// Files and folders of the repository that the archive holds, at the same paths.
const TEXTS: [&str; 8] = [
    "README.md",
    "CHANGELOG.md",
    "LICENSE-MIT",
    "LICENSE-APACHE",
    "docs/guide",
    "docs/pictures",
    "plugin/README.md",
    "plugin/examples",
];

/// The folder of the lens library, and its place in the archive.
const LENSES: [&str; 2] = ["core/optics/library", "lenses"];

/// The options of the command line.
#[derive(Debug, Default, PartialEq)]
struct Options {
    target: Option<String>,
    glibc: Option<GlibcVersion>,
    to: Option<PathBuf>,
    help: bool,
}

impl Options {
    fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self::default();
        while let Some(argument) = arguments.next() {
            let mut value = || {
                let value = arguments.next();
                value.ok_or_else(|| format!("{argument} needs a value; {USAGE}"))
            };
            match argument.as_str() {
                "--help" | "-h" => options.help = true,
                "--target" => options.target = Some(value()?),
                "--glibc" => options.glibc = Some(value()?.parse()?),
                "--to" => options.to = Some(value()?.into()),
                other => return Err(format!("unknown argument {other}; {USAGE}")),
            }
        }
        Ok(options)
    }
}

/// Builds everything and writes the archive with its checksum beside it; returns a report.
///
/// # Errors
/// Wrong arguments, a failed build, a dependency without a licence, and files that cannot be read or written.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let options = Options::parse(arguments)?;
    if options.help {
        return Ok(USAGE.to_owned());
    }
    let target = options.target.as_deref();
    let triple = target.map_or_else(host_triple, str::to_owned);
    let cargo = Cargo::new(root);
    let notices = notices::generate(&cargo, &PACKAGES, &triple, NOTICES_HEAD)?;
    let release = cargo.build(&["seidel", "seidel-plugin"], target, options.glibc)?;
    let bundle = bundle::make(root, target, options.glibc)?;
    let output = cargo.target_folder()?;

    let mut entries = vec![Entry::text("THIRD-PARTY-NOTICES.txt", notices)];
    let binaries = binaries(&triple);
    for (from, to) in &binaries {
        if let Some(glibc) = options.glibc {
            let needs = Binary::read(&release.join(from))?;
            needs
                .check_glibc(glibc)
                .map_err(|e| format!("{from}: {e}"))?;
        }
        entries.push(Entry::read(&release.join(from), to, Mode::Program)?);
    }
    entries.push(Entry::read(
        &root.join(header::PATH),
        "include/seidel.h",
        Mode::Text,
    )?);
    let version = version(root)?;
    let (library, _) = &binaries[1];
    let names = package::Names {
        version: &version,
        library,
        import: binaries.get(2).map_or(library, |(import, _)| import),
    };
    entries.extend(package::entries(root, &names)?);
    let name = bundle
        .path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let files = Entry::read_folder(&bundle.path, &name)?.into_iter();
    entries.extend(files.filter(|file| !bundle.kept.iter().any(|other| file.is_about(other))));
    entries.extend(Entry::read_folder(&root.join(LENSES[0]), LENSES[1])?);
    for text in TEXTS {
        let path = root.join(text);
        if path.is_dir() {
            entries.extend(Entry::read_folder(&path, text)?);
        } else {
            entries.push(Entry::read(&path, text, Mode::Text)?);
        }
    }
    // A program of another platform cannot print its manual.
    if triple == host_triple() {
        entries.extend(manual(&release.join(&binaries[0].0), &output)?);
    }

    let name = format!("seidel-{version}-{triple}");
    let folder = options.to.unwrap_or_else(|| output.join("dist"));
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let archive = archive::write(&folder, &name, entries)?;
    Ok(format!(
        "dist: {} ({:.1} MB, {} files)\ndist: sha256 {}",
        archive.path.display(),
        archive.bytes as f64 / 1e6,
        archive.files,
        archive.sha256
    ))
}

/// Returns the names of the built programs and libraries in the release folder, and their places in the archive.
fn binaries(triple: &str) -> Vec<(String, String)> {
    let (program, library) = if triple.contains("windows") {
        ("seidel.exe", "seidel_c.dll")
    } else if triple.contains("apple") {
        ("seidel", "libseidel_c.dylib")
    } else {
        ("seidel", "libseidel_c.so")
    };
    let mut binaries = vec![
        (program.to_owned(), format!("bin/{program}")),
        (library.to_owned(), format!("lib/{library}")),
    ];
    // Programs on Windows link by the import library.
    let import = match triple {
        _ if triple.ends_with("windows-msvc") => Some("seidel_c.dll.lib"),
        _ if triple.contains("windows") => Some("libseidel_c.dll.a"),
        _ => None,
    };
    binaries.extend(import.map(|import| (import.to_owned(), format!("lib/{import}"))));
    binaries
}

/// Returns the manual pages that `program` writes.
fn manual(program: &Path, output: &Path) -> Result<Vec<Entry>, String> {
    let folder = output.join("dist-man");
    // Pages of commands that have gone.
    let _ = fs::remove_dir_all(&folder);
    let status = Command::new(program).arg("man").arg(&folder).output();
    let status = status.map_err(|e| format!("{}: {e}", program.display()))?;
    if !status.status.success() {
        return Err(format!(
            "seidel man: {}",
            String::from_utf8_lossy(&status.stderr)
        ));
    }
    Entry::read_folder(&folder, "share/man/man1")
}

/// Returns the version of the project.
fn version(root: &Path) -> Result<String, String> {
    let text =
        fs::read_to_string(root.join("Cargo.toml")).map_err(|e| format!("Cargo.toml: {e}"))?;
    let table: toml::Table = text.parse().map_err(|e| format!("Cargo.toml: {e}"))?;
    let version = table
        .get("workspace")
        .and_then(|w| w.get("package")?.get("version")?.as_str());
    version
        .map(str::to_owned)
        .ok_or_else(|| "Cargo.toml: has no version".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_parsed_and_unknown_ones_refused() {
        let parse = |text: &str| Options::parse(text.split_whitespace().map(str::to_owned));
        let both = Options {
            target: Some("x86_64-pc-windows-msvc".into()),
            to: Some("out".into()),
            ..Options::default()
        };
        assert_eq!(parse("--to out --target x86_64-pc-windows-msvc"), Ok(both));
        assert!(parse("--too out").is_err() && parse("--to").is_err());
    }

    #[test]
    fn everything_that_the_archive_names_exists() {
        let root = crate::workspace::root();
        let templates = package::TEMPLATES.map(|[from, _]| from);
        for text in (TEXTS.into_iter())
            .chain([LENSES[0], header::PATH])
            .chain(templates)
        {
            assert!(root.join(text).exists(), "{text}");
        }
        assert!(
            version(&root)
                .expect("a version")
                .starts_with(|c: char| c.is_ascii_digit())
        );
        assert_eq!(binaries("x86_64-pc-windows-msvc")[1].1, "lib/seidel_c.dll");
    }
}
