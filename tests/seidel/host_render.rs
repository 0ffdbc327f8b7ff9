//! Renders of the OpenFX plugin in the test host, compared with the command.

// Variadic calls to this host are untested there: see `tests/host/src/host/suites/variadic.rs`.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]

use std::path::Path;

use seidel_ofx_host::picture::Picture;
use seidel_ofx_host::render_job::{ClipFile, RenderJob};
use seidel_ofx_host::runner::built_plugin;

use crate::support::{read_channel, succeeds, write_plate, write_pupil_lens};

pub(crate) const WIDTH: usize = 90;
pub(crate) const HEIGHT: usize = 64;
pub(crate) const NAMES: [&str; 4] = ["R", "G", "B", "A"];

/// Returns a folder with `lens.json` of R, G and B, and `plate.exr` with depth.
pub(crate) fn lens_and_plate() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write_pupil_lens(folder.path(), &["R", "G", "B"]);
    write_plate(&folder.path().join("plate.exr"), WIDTH, HEIGHT);
    folder
}

/// The input Depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DepthInput {
    /// Nothing.
    None,
    /// Channel Z of the plate.
    OfPlate,
}

/// Renders `plate.exr` of `folder` with `lens.json` in the host.
pub(crate) fn in_host(folder: &Path, depth: DepthInput, knobs: &[(&str, &str)]) -> Picture {
    try_in_host(folder, depth, knobs).expect("rendered")
}

/// Renders as [`in_host`], or returns the plugin's message.
pub(crate) fn try_in_host(
    folder: &Path,
    depth: DepthInput,
    knobs: &[(&str, &str)],
) -> Result<Picture, String> {
    let depth = (depth == DepthInput::OfPlate).then(|| depth_of_plate(folder));
    try_in_host_with(folder, depth.into_iter().collect(), knobs)
}

/// Returns the input Depth of the channel Z of the plate.
pub(crate) fn depth_of_plate(folder: &Path) -> ClipFile {
    ClipFile {
        clip: "Depth".to_owned(),
        file: folder.join("plate.exr"),
        channel: Some("Z".to_owned()),
    }
}

/// Renders frame `time` as [`try_in_host`] with the depth of the plate.
pub(crate) fn try_in_host_at(
    folder: &Path,
    time: f64,
    knobs: &[(&str, &str)],
) -> Result<Picture, String> {
    let job = job(folder, vec![depth_of_plate(folder)], knobs);
    RenderJob { time, ..job }.run()
}

/// Renders as [`try_in_host`], with these inputs beside the source.
pub(crate) fn try_in_host_with(
    folder: &Path,
    inputs: Vec<ClipFile>,
    knobs: &[(&str, &str)],
) -> Result<Picture, String> {
    job(folder, inputs, knobs).run()
}

/// Returns the colour of a `file` of `folder` as the input `clip`.
pub(crate) fn colour_of(folder: &Path, clip: &str, file: &str) -> ClipFile {
    ClipFile {
        clip: clip.to_owned(),
        file: folder.join(file),
        channel: None,
    }
}

/// Returns the job of a render of `plate.exr` with `lens.json`, both of `folder`.
pub(crate) fn job(folder: &Path, inputs: Vec<ClipFile>, knobs: &[(&str, &str)]) -> RenderJob {
    let mut feeds = vec![colour_of(folder, "Source", "plate.exr")];
    feeds.extend(inputs);
    let lens = folder.join("lens.json").display().to_string();
    let always = [("lens", "Lens File"), ("profile", lens.as_str())];
    let settings = always.iter().chain(knobs);
    RenderJob {
        plugin: built_plugin("seidel_ofx").expect("built with the tests"),
        feeds,
        settings: settings
            .map(|(name, words)| ((*name).to_owned(), (*words).to_owned()))
            .collect(),
        ..RenderJob::default()
    }
}

/// Asserts that the command gives bit-identical samples, and that they differ from the plate's.
#[track_caller]
pub(crate) fn assert_equals_command(host: &Picture, folder: &Path, line: &str) {
    succeeds(folder, &format!("{line} @plate.exr -o @out.exr"));
    let mut changed = false;
    let (width, height) = (host.bounds.width(), host.bounds.height());
    for (c, name) in NAMES.iter().enumerate().take(host.channels) {
        let command = read_channel(&folder.join("out.exr"), name);
        let before = read_channel(&folder.join("plate.exr"), name);
        changed |= command != before;
        assert_eq!(command.len(), width * height);
        for (k, wanted) in command.iter().enumerate() {
            let (x, y) = ((k % width) as i32, (height - 1 - k / width) as i32);
            let got = host.pixel(x, y)[c];
            let same = got.to_bits() == wanted.to_bits();
            assert!(same, "{name} of {x}, {y}: {got}, not {wanted}");
        }
    }
    assert!(changed, "something was done");
}
