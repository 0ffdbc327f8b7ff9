//! Removal from plates that other programs rendered: rows of docs/background/figures.md.

use std::path::{Path, PathBuf};

use crate::support::{read_channel, real_data, succeeds};

/// Columns of the scenes.
pub(crate) const WIDTH: usize = 304;
/// Border that is left out, px.
const BORDER: usize = 24;

/// Returns the PSNR over all colours, of samples limited to 0 to 1, in dB.
pub(crate) fn decibels(one: &Path, other: &Path, width: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for colour in ["R", "G", "B"] {
        let [a, b] = [one, other].map(|path| read_channel(path, colour));
        let height = a.len() / width;
        for k in 0..a.len() {
            let (x, y) = (k % width, k / width);
            if (BORDER..width - BORDER).contains(&x) && (BORDER..height - BORDER).contains(&y) {
                sum += f64::from(a[k].clamp(0.0, 1.0) - b[k].clamp(0.0, 1.0)).powi(2);
                count += 1.0;
            }
        }
    }
    -10.0 * (sum / count).log10()
}

/// A scene of `data/dof`: the picture of a pinhole camera with its depth, and that of a real aperture.
pub(crate) struct Scene {
    pub(crate) lens: PathBuf,
    pub(crate) plate: PathBuf,
    pub(crate) truth: PathBuf,
}

pub(crate) fn scene(name: &str) -> Option<Scene> {
    let folder = real_data("dof")?;
    let file = |part: &str| folder.join(format!("{name}_{part}"));
    Some(Scene {
        lens: file("lens.json"),
        plate: file("plate.exr"),
        truth: file("truth.exr"),
    })
}

/// The depth of field of a path tracer, with the exact lens and the pinhole's depth.
#[test]
fn depth_of_field_of_a_path_tracer_is_removed() {
    for (name, least) in [("character", 22.9), ("floor", 26.5)] {
        let Some(scene) = scene(name) else { return };
        let folder = tempfile::tempdir().expect("a folder");
        let line = format!(
            "remove --lens {} {} -o @sharp.exr --depth {} --no-overscan --no-depth-check",
            scene.lens.display(),
            scene.truth.display(),
            scene.plate.display()
        );
        succeeds(folder.path(), &line);
        let found = decibels(&folder.path().join("sharp.exr"), &scene.plate, WIDTH);
        let before = decibels(&scene.truth, &scene.plate, WIDTH);
        assert!(found > least, "{name}: {found} dB, {before} dB before");
    }
}

/// Discs of 3 and 10 px without noise, at one distance.
#[test]
fn discs_are_removed_from_a_plate_without_noise() {
    let Some(scene) = scene("character") else {
        return;
    };
    let focus_m = 2.5;
    let radius_px_per_vergence = 45.873;
    for (radius_px, least) in [(3.0, 50.0), (10.0, 34.5)] {
        let folder = tempfile::tempdir().expect("a folder");
        let distance = 1.0 / (1.0 / focus_m - radius_px / radius_px_per_vergence);
        let lens = format!("--lens {} --distance {distance}", scene.lens.display());
        succeeds(
            folder.path(),
            &format!(
                "apply {lens} {} -o @blurred.exr --quality exact --expand off",
                scene.plate.display()
            ),
        );
        let line = format!("remove {lens} @blurred.exr -o @sharp.exr --no-overscan");
        let outcome = succeeds(folder.path(), &line);
        assert!(
            !outcome.stderr.contains("of the lens's blur"),
            "{}",
            outcome.stderr
        );
        let found = decibels(&folder.path().join("sharp.exr"), &scene.plate, WIDTH);
        assert!(found > least, "{radius_px} px: {found} dB");
    }
}

/// A bright surface that is clipped in part is no lamp: light of unknown brightness must not take the place of the surface beside it,
/// which then has dark outlines.
#[test]
fn a_surface_that_is_clipped_in_part_gets_no_outlines() {
    let Some(plate) = real_data("plates/motorcycle.exr") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let lens = "--lens library:modern-50 --f-number 2 --focus-distance 2 --distance 2.2";
    let line = format!(
        "apply {lens} {} -o @blurred.exr --expand off",
        plate.display()
    );
    succeeds(folder.path(), &line);
    let line = format!("remove {lens} @blurred.exr -o @sharp.exr --no-overscan");
    let outcome = succeeds(folder.path(), &line);
    assert!(
        !outcome.stderr.contains("of the lens's blur"),
        "{}",
        outcome.stderr
    );
    let [before, found] =
        ["blurred.exr", "sharp.exr"].map(|name| decibels(&folder.path().join(name), &plate, 741));
    assert!(found > before + 5.0, "{before} dB before, {found} dB found");
}
