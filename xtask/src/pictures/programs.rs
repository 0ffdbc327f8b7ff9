//! The programs whose output the pictures show, and the folders they work in.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The built programs, a working folder, and the folder of the documentation.
pub(super) struct Programs {
    root: PathBuf,
    folder: PathBuf,
    work: PathBuf,
}

impl Programs {
    /// Uses the programs in `folder`, or builds those of the workspace in the release profile.
    pub(super) fn new(root: &Path, folder: Option<PathBuf>) -> Result<Self, String> {
        let folder = match folder {
            Some(folder) => folder,
            None => built(root)?,
        };
        let folder = folder
            .canonicalize()
            .map_err(|why| format!("{}: {why}", folder.display()))?;
        let work = root.join("target").join("pictures");
        std::fs::create_dir_all(&work).map_err(|why| format!("{}: {why}", work.display()))?;
        Ok(Self {
            root: root.to_owned(),
            folder,
            work,
        })
    }

    /// The folder for intermediate files.
    pub(super) fn work(&self) -> &Path {
        &self.work
    }

    /// The demo's files, written once.
    pub(super) fn demo(&self) -> Result<PathBuf, String> {
        let demo = self.work.join("demo");
        if !demo.join("plate.exr").exists() {
            self.seidel("demo demo")?;
        }
        Ok(demo)
    }

    /// Runs `seidel` in the working folder; `line` holds its arguments, none of which may contain a space.
    pub(super) fn seidel(&self, line: &str) -> Result<(), String> {
        let program = self
            .folder
            .join(format!("seidel{}", std::env::consts::EXE_SUFFIX));
        self.command(&program, line.split_whitespace())
    }

    /// Runs the OpenFX test host on the plugin, with `arguments`.
    pub(super) fn host(&self, arguments: &[&str]) -> Result<(), String> {
        let suffix = std::env::consts::EXE_SUFFIX;
        let program = self.folder.join(format!("seidel-ofx-host{suffix}"));
        let library = format!(
            "{}seidel_ofx{}",
            std::env::consts::DLL_PREFIX,
            std::env::consts::DLL_SUFFIX
        );
        let plugin = self.folder.join(library);
        let all = std::iter::once(plugin.as_os_str()).chain(arguments.iter().map(OsStr::new));
        self.command(&program, all)
    }

    /// Runs the ignored tests of `seidel-tests` in `module` that write images, with `variable` set to `value`.
    pub(super) fn ignored_test(
        &self,
        module: &str,
        variable: &str,
        value: &Path,
    ) -> Result<(), String> {
        let mut command = Command::new(cargo());
        command.current_dir(&self.root).env(variable, value);
        // As the tests of the workspace are built, so that nothing is built twice.
        command.args(["test", "--workspace", "--test", "seidel", "--"]);
        command.args([&format!("{module}::write_image"), "--ignored"]);
        finished(command)
    }

    /// Copies `drawn` to `docs/pictures/` under the name `file`.
    pub(super) fn install(&self, drawn: &Path, file: &str) -> Result<(), String> {
        self.install_in("pictures", drawn, file)
    }

    /// Copies `drawn` to a folder of `docs/` under the name `file`.
    pub(super) fn install_in(&self, folder: &str, drawn: &Path, file: &str) -> Result<(), String> {
        let to = self.root.join("docs").join(folder).join(file);
        std::fs::copy(drawn, &to).map_err(|why| format!("{}: {why}", to.display()))?;
        Ok(())
    }

    fn command(
        &self,
        program: &Path,
        arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
    ) -> Result<(), String> {
        let mut command = Command::new(program);
        command.current_dir(&self.work).args(arguments);
        finished(command)
    }
}

fn cargo() -> std::ffi::OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Builds the programs; returns the folder that holds them.
fn built(root: &Path) -> Result<PathBuf, String> {
    let mut command = Command::new(cargo());
    command.current_dir(root).args(["build", "--release"]);
    command.args(["-p", "seidel", "-p", "seidel-ofx", "-p", "seidel-ofx-host"]);
    finished(command)?;
    let target = std::env::var_os("CARGO_TARGET_DIR");
    let target = target.map_or_else(|| root.join("target"), |folder| root.join(folder));
    Ok(target.join("release"))
}

/// Runs `command` to its end.
pub(crate) fn finished(mut command: Command) -> Result<(), String> {
    let shown = format!("{command:?}");
    let status = command.status().map_err(|why| format!("{shown}: {why}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{shown}: {status}"))
    }
}
