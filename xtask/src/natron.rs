//! Renders a project through an installed Natron, and compares the result with the command.

use std::path::{Path, PathBuf};
use std::process::Command;

use exr::prelude::read_first_flat_layer_from_file;

use crate::bundle;
use crate::pictures::finished;

const USAGE: &str = "cargo xtask natron [--natron FILE]

Builds the command and the bundle, renders one frame through NatronRenderer and through `seidel apply`, and compares them.
  --natron FILE  the renderer; by default NatronRenderer of PATH. Without one the comparison is skipped";

/// Largest difference, as a share of the peak: Natron may write half floats.
const MAX_DIFFERENCE: f32 = 1e-3;

/// The lens, by its index in the node's menu and by its name for the command.
const LENS: (u32, &str) = (5, "library:modern-50");

/// The distance of the plate, metres.
const DISTANCE_M: f64 = 1.2;

/// Runs `cargo xtask natron`.
///
/// # Errors
/// Wrong arguments, a build or a render that fails, and results that differ.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let arguments: Vec<String> = arguments.collect();
    let natron = match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => on_path("NatronRenderer"),
        ["--natron", file] => Some(PathBuf::from(file)),
        _ => return Err(format!("usage: {USAGE}")),
    };
    let Some(natron) = natron else {
        return Ok("SKIPPED: NatronRenderer is not on PATH; give it by --natron FILE".to_owned());
    };
    let work = root.join("target").join("natron");
    let plugins = work.join("plugins");
    let failed = |why: std::io::Error| format!("{}: {why}", work.display());
    std::fs::create_dir_all(&plugins).map_err(failed)?;
    let to = plugins.display().to_string();
    let install = ["--install", "--to", &to].map(str::to_owned);
    bundle::run(root, install.into_iter())?;
    let seidel = |line: &str| {
        let mut command = Command::new(env!("CARGO"));
        command.current_dir(root);
        command.args(["run", "--release", "--quiet", "-p", "seidel", "--"]);
        command.args(line.split(' '));
        finished(command)
    };
    let folder = "target/natron";
    let plate = work.join("demo").join("plate.exr");
    if !plate.exists() {
        seidel(&format!("demo {folder}/demo --width 240"))?;
    }
    let name = LENS.1;
    seidel(&format!(
        "apply --lens {name} --distance {DISTANCE_M} {folder}/demo/plate.exr -o {folder}/command.exr"
    ))?;
    let script = work.join("project.py");
    let written = work.join("natron.exr");
    std::fs::write(&script, project(&plate, &written)).map_err(failed)?;
    let mut render = Command::new(&natron);
    render.env("OFX_PLUGIN_PATH", &plugins).arg(&script);
    render.args(["-w", "SeidelWriter", "1-1"]);
    finished(render)?;
    let difference = difference(&work.join("command.exr"), &written)?;
    let report = format!("Natron and the command differ by {difference:.2e} of the peak");
    match difference <= MAX_DIFFERENCE {
        true => Ok(report),
        false => Err(report),
    }
}

fn on_path(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let mut files = std::env::split_paths(&path).map(|folder| folder.join(program));
    files.find(|file| file.is_file())
}

/// Returns the script that makes the project: a reader, the node and a writer.
fn project(plate: &Path, written: &Path) -> String {
    format!(
        "plate = app.createReader({:?})
node = app.createNode(\"org.seidel.lensblur\")
node.connectInput(0, plate)
node.getParam(\"lens\").setValue({})
node.getParam(\"distance\").setValue({DISTANCE_M})
writer = app.createWriter({:?})
writer.setScriptName(\"SeidelWriter\")
# The size of the input, not of the project.
writer.getParam(\"formatType\").setValue(0)
writer.connectInput(0, node)
",
        plate.display().to_string(),
        LENS.0,
        written.display().to_string()
    )
}

/// Returns the largest difference of R, G and B between two OpenEXR files, as a share of the first one's peak.
fn difference(expected: &Path, found: &Path) -> Result<f32, String> {
    let (expected, found) = (colours(expected)?, colours(found)?);
    if expected.len() != found.len() {
        return Err("Natron wrote a picture of another size".to_owned());
    }
    let peak = expected.iter().fold(0.0_f32, |peak, v| peak.max(*v));
    let apart = expected.iter().zip(&found).map(|(a, b)| (a - b).abs());
    // NaN counts as a difference.
    let largest = apart.fold(
        0.0_f32,
        |most, v| if v <= most || most.is_nan() { most } else { v },
    );
    Ok(largest / peak)
}

/// Reads R, G and B, one after another.
fn colours(file: &Path) -> Result<Vec<f32>, String> {
    let image = read_first_flat_layer_from_file(file)
        .map_err(|why| format!("{}: {why}", file.display()))?;
    let mut samples = Vec::new();
    for name in ["R", "G", "B"] {
        let channels = &image.layer_data.channel_data.list;
        let channel = channels.iter().find(|channel| channel.name.eq(name));
        let channel = channel.ok_or_else(|| format!("{}: no channel {name}", file.display()))?;
        samples.extend(channel.sample_data.values_as_f32());
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_shares_of_the_peak() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, value: f32| {
            let path = folder.path().join(name);
            exr::prelude::write_rgb_file(&path, 4, 2, |x, _| {
                (0.5, if x == 3 { value } else { 4.0 }, 1.0)
            })
            .expect("written");
            path
        };
        let (a, b, nan) = (write("a", 2.0), write("b", 2.4), write("nan", f32::NAN));
        assert_eq!(difference(&a, &a), Ok(0.0));
        let apart = difference(&a, &b).expect("of one size");
        assert!((apart - 0.1).abs() < 1e-6, "{apart}");
        assert!(difference(&a, &nan).expect("of one size").is_nan());
    }

    #[test]
    fn a_machine_without_natron_says_so() {
        assert_eq!(on_path("no such renderer"), None);
        let text = project(Path::new("/a \"b\"/plate.exr"), Path::new("/c.exr"));
        assert!(
            text.contains(r#"createReader("/a \"b\"/plate.exr")"#),
            "{text}"
        );
    }
}
