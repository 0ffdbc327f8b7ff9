//! The node in the test host as Natron: messages, references, the guess of Depth Math, channels, the panel.

// As for `host_render`.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]

use std::path::Path;

use seidel_ofx_host::panel::Row;
use seidel_ofx_host::picture::Picture;
use seidel_ofx_host::render_job::RenderJob;

use crate::depth_check::write_room;
use crate::host_render::{
    DepthInput, HEIGHT, NAMES, WIDTH, assert_equals_command, colour_of, depth_of_plate, in_host,
    job, lens_and_plate,
};
use crate::support::{write_exr, write_pupil_lens};

/// Renders `plate.exr` of `folder` in the host as Natron.
fn in_natron(folder: &Path, depth: DepthInput, knobs: &[(&str, &str)]) -> Result<Picture, String> {
    let depth = (depth == DepthInput::OfPlate).then(|| depth_of_plate(folder));
    let job = job(folder, depth.into_iter().collect(), knobs);
    of_natron(job).run()
}

fn of_natron(job: RenderJob) -> RenderJob {
    RenderJob {
        host: "natron".to_owned(),
        ..job
    }
}

#[test]
fn messages_are_printed_without_arguments() {
    let folder = lens_and_plate();
    let folder = folder.path();
    let knobs = [("profile", "/nowhere/100%s of a lens.json")];
    let error = in_natron(folder, DepthInput::None, &knobs).expect_err("no such file");
    assert!(
        error.contains("/nowhere/100%s of a lens.json: could not be read"),
        "{error}"
    );
}

#[test]
fn references_survive_saving() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let plane = |shade: f32| (0..WIDTH * HEIGHT).map(move |k| shade + (k % 7) as f32 / 30.0);
    let channels = NAMES.map(|name| (name, plane(0.3).collect::<Vec<_>>()));
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
    let knobs = [
        ("profile", "library:macro-100"),
        ("distance", "3"),
        ("sourceCodes", "By OpenColorIO"),
        ("ocioConfig", "seidel"),
        ("sourceSpace", "logc4"),
    ];
    let host = in_natron(folder, DepthInput::None, &knobs).expect("rendered");
    let line = "apply --lens library:macro-100 --distance 3 --ocio seidel --in-space logc4";
    assert_equals_command(&host, folder, line);
}

/// The guess is made at the next change, since the clip has no images while it is being connected.
#[test]
fn reciprocals_of_distances_are_recognised_after_the_connection() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_room(&folder.join("plate.exr"), &["R", "G", "B"], &|z, _| 1.0 / z);
    let line = "apply --lens @lens.json --depth-kind inverse";
    let host = in_natron(folder, DepthInput::OfPlate, &[]).expect("rendered");
    assert_equals_command(&host, folder, line);
    assert_equals_command(&in_host(folder, DepthInput::OfPlate, &[]), folder, line);
    // What the user chose stays.
    let knobs = [("math", "depth")];
    let host = in_natron(folder, DepthInput::OfPlate, &knobs).expect("rendered");
    assert_equals_command(&host, folder, "apply --lens @lens.json --no-depth-check");
}

#[test]
fn a_source_of_few_channels_renders_beside_inputs_of_more() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    let plane = |shade: f32| {
        (0..WIDTH * HEIGHT)
            .map(|k| shade + (k % 7) as f32)
            .collect()
    };
    let colours: Vec<(&str, Vec<f32>)> = ["R", "G", "B"].map(|name| (name, plane(0.5))).into();
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &colours);
    let four: Vec<_> = (colours.into_iter()).chain([("A", plane(0.0))]).collect();
    write_exr(&folder.join("four.exr"), WIDTH, HEIGHT, &four);
    for clip in ["Depth", "Aperture", "Reference", "Holdout"] {
        let input = colour_of(folder, clip, "four.exr");
        let knobs = [
            ("distance", "1.5"),
            ("useDepth", "off"),
            ("useHoldout", "off"),
        ];
        let host = of_natron(job(folder, vec![input], &knobs))
            .run()
            .expect(clip);
        assert_eq!(host.channels, 3, "{clip}");
        assert_equals_command(&host, folder, "apply --lens @lens.json --distance 1.5");
    }
}

fn panel(host: &str) -> Vec<Row> {
    let job = RenderJob {
        host: host.to_owned(),
        ..job(Path::new("."), Vec::new(), &[])
    };
    job.panel().expect("a panel")
}

#[test]
fn the_panel_follows_the_work() {
    for host in ["complete", "natron"] {
        let rows = panel(host);
        let groups = rows.iter().filter(|row| row.name.ends_with("Group"));
        let groups: Vec<_> = groups
            .map(|row| (row.label.as_str(), row.details.as_str()))
            .collect();
        let order = [
            ("Lens", ""),
            ("Lens Details", "closed"),
            ("Depth", ""),
            ("Focus", ""),
            ("Look", "closed"),
            ("Output", ""),
            ("Render", "closed"),
            ("Remove", "closed"),
            ("Relens", "closed"),
            ("Colour", "closed"),
        ];
        assert_eq!(groups, order, "{host}");
        assert_eq!(rows[0].label, "Lens", "{host}");
        let has = |name: &str| rows.iter().any(|row| row.name == name);
        // Natron has no draw suite, and no folder of lenses is named.
        assert_eq!(has("showLens"), host == "complete");
        assert!(has("lookPreset"));
        if std::env::var_os("SEIDEL_LENSES").is_none() {
            assert!(!has("lensFolder"));
        }
    }
}

/// A default at an end of the slider is nothing or everything; any other has room to both sides.
#[test]
fn sliders_have_room_on_both_sides_of_defaults() {
    for row in panel("complete") {
        let Some((range, default)) = row.details.split_once(", default ") else {
            continue;
        };
        let (low, high) = range.split_once(" to ").expect("a range");
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let (low, high, default) = (number(low), number(high), number(default));
        let share = (default - low) / (high - low);
        let is_at_end = share <= 0.0 || share >= 1.0;
        assert!(is_at_end || (0.1..0.9).contains(&share), "{row:?}");
    }
}
