//! The OpenFX plugin in the test host, against the command: the same plate, lens and settings give bit-identical samples.

// Variadic calls to this host are untested there: see `tests/host/src/host/suites/variadic.rs`.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]

use std::path::Path;

use seidel_ofx_host::render_job::{ClipFile, RenderJob};
use seidel_ofx_host::runner::built_plugin;

use crate::host_render::{
    DepthInput, HEIGHT, NAMES, WIDTH, assert_equals_command, in_host, lens_and_plate, try_in_host,
};
use crate::remove_lens_check;
use crate::support::{
    read_channel, succeeds, write_exr, write_moments_lens, write_nearly_equal_lens, write_plate,
    write_pupil_lens,
};

/// Writes an opaque plate whose colours come from `sample`, which takes a channel's shade and a pixel index.
fn write_shades(folder: &Path, sample: impl Fn(f32, usize) -> f32) {
    let plane = |shade| (0..WIDTH * HEIGHT).map(|k| sample(shade, k)).collect();
    let channels: [(&str, Vec<f32>); 4] = [
        ("R", plane(1.0)),
        ("G", plane(0.8)),
        ("B", plane(0.6)),
        ("A", vec![1.0; WIDTH * HEIGHT]),
    ];
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
}

#[test]
fn apply_equals_the_command() {
    let folder = lens_and_plate();
    let folder = folder.path();
    let depth = [("math", "depth"), ("worldScale", "metres")];
    let host = in_host(folder, DepthInput::OfPlate, &depth);
    let line = "apply --lens @lens.json --no-depth-check";
    assert_equals_command(&host, folder, line);
    let more = [
        ("amount", "1.5"),
        ("redScale", "1.2"),
        ("focus", "Focus Distance"),
        ("focusDistance", "2"),
        ("dof", "0.2"),
        ("front", "1.5"),
        ("maxSize", "8"),
        ("edge", "Nearest"),
        ("fillForeground", "off"),
    ];
    let host = in_host(folder, DepthInput::OfPlate, &[&depth[..], &more].concat());
    let line = format!(
        "{line} --amount 1.5 --channel-scale R=1.2 --focus-distance 2 --depth-of-field 0.2 \
         --front-multiplier 1.5 --maximum-size 8 --edges extend --no-fill-foreground"
    );
    assert_equals_command(&host, folder, &line);
    let host = in_host(
        folder,
        DepthInput::None,
        &[("distance", "1.5"), ("edge", "Black")],
    );
    let line = "apply --lens @lens.json --distance 1.5 --edges black";
    assert_equals_command(&host, folder, line);
    // The shot's camera: the film back counts, not Lens Scale.
    let camera = [
        ("focalLength", "35"),
        ("filmBack", "1.1"),
        ("lensScale", "3"),
        ("fStop", "2.8"),
    ];
    let host = in_host(folder, DepthInput::OfPlate, &[&depth[..], &camera].concat());
    let line = "apply --lens @lens.json --no-depth-check --focal-length-mm 35 --film-back-mm 1.1 --f-number 2.8";
    assert_equals_command(&host, folder, line);
}

#[test]
fn messages_count_pixels_as_the_host_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    // Column 7 of the third row from the top.
    let sample = |shade: f32, k: usize| if k == 2 * WIDTH + 7 { f32::NAN } else { shade };
    write_shades(folder, sample);
    let error = try_in_host(folder, DepthInput::None, &[("distance", "2")]).expect_err("a NaN");
    let place = format!("Source: channel R, pixel (x 7, y {}) is NaN", HEIGHT - 3);
    assert!(error.contains(&place), "{error}");
}

/// Set in the process that [`lens_folder_in_the_host`] starts.
const CHILD: &str = "SEIDEL_TEST_LENS_FOLDER";

/// The menu *Lens Folder* lists the profiles in the folder of the environment, and a choice goes to *Lens File*.
#[test]
fn lens_folder_in_the_host() {
    let name = "in_hosts::lens_folder_in_the_host";
    let Some(folder) = std::env::var_os(CHILD) else {
        // The host and its plugin live in this process, whose environment other tests share.
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        write_pupil_lens(folder, &["R", "G", "B"]);
        write_plate(&folder.join("plate.exr"), WIDTH, HEIGHT);
        let lenses = folder.join("lenses");
        std::fs::create_dir(&lenses).expect("a folder");
        std::fs::copy(folder.join("lens.json"), lenses.join("own lens.json")).expect("copied");
        let child = std::process::Command::new(std::env::current_exe().expect("this test"))
            .args(["--exact", name, "--nocapture"])
            .env(CHILD, folder)
            .env("SEIDEL_LENSES", &lenses)
            .output()
            .expect("started");
        let text = String::from_utf8_lossy(&child.stdout).into_owned();
        assert!(child.status.success(), "{text}");
        assert!(text.contains("1 passed"), "{text}");
        return;
    };
    let folder = Path::new(&folder);
    let by_menu = |options: &[(&str, &str)]| {
        let always = [("lens", "Portrait 85 mm f/1.4"), ("profile", "")];
        in_host(folder, DepthInput::None, &[&always[..], options].concat())
    };
    let chosen = by_menu(&[("lensFolder", "own lens"), ("distance", "1.5")]);
    let line = "apply --lens @lens.json --distance 1.5";
    assert_equals_command(&chosen, folder, line);
}

#[test]
fn looks_equal_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    let lamps = |shade: f32, k: usize| shade * if k.is_multiple_of(517) { 30.0 } else { 0.2 };
    write_shades(folder, lamps);
    let near = [("distance", "1.2"), ("focus", "Focus Distance")];
    let line = "apply --lens @lens.json --distance 1.2 --focus-distance 2";
    let measured = in_host(folder, DepthInput::None, &near);
    assert_equals_command(&measured, folder, line);
    let iris = [
        ("blades", "6"),
        ("roundness", "0.25"),
        ("rotation", "-15"),
        ("squeeze", "1.7"),
        ("obstruction", "0.35"),
    ];
    let iris_options =
        "--blades 6 --roundness 0.25 --rotation -15 --squeeze 1.7 --obstruction 0.35";
    let rest = [
        ("blades", "Round"),
        ("catsEye", "0.8"),
        ("spherical", "-0.7"),
        ("axialColour", "3"),
        ("lateralColour", "-2"),
        ("tilt", "6"),
        ("tiltDirection", "-60"),
        ("bloom", "0.3"),
        ("bloomLevel", "2.5"),
        ("bloomRadius", "4"),
    ];
    let rest_options = "--blades 0 --cats-eye 0.8 --spherical -0.7 --axial-colour 3 \
                        --lateral-colour -2 --tilt 6 --tilt-direction -60 --bloom 0.3 --bloom-level 2.5 --bloom-radius 4";
    for (knobs, options) in [(&iris[..], iris_options), (&rest[..], rest_options)] {
        let host = in_host(folder, DepthInput::None, &[&near[..], knobs].concat());
        assert_equals_command(&host, folder, &format!("{line} {options}"));
        assert_ne!(host.samples, measured.samples, "{options}");
    }
    // Relens: the look is that of the lens whose blur is added.
    write_nearly_equal_lens(folder, "lens.json", "other.json");
    let other = folder.join("other.json").display().to_string();
    let relens = [
        ("mode", "Relens"),
        ("toLens", "Lens File"),
        ("toProfile", other.as_str()),
        ("distance", "1.2"),
        ("noise", "0.002"),
    ];
    let host = in_host(folder, DepthInput::None, &[&relens[..], &iris].concat());
    let line =
        "relens --from @lens.json --to @other.json --distance 1.2 --noise 0.002 --lens-check off";
    assert_equals_command(&host, folder, &format!("{line} {iris_options}"));
    // Remove: the look is that of the lens that took the plate.
    let remove = [("mode", "Remove"), ("distance", "1.2"), ("noise", "0.002")];
    let plain = in_host(folder, DepthInput::None, &remove);
    let same = in_host(folder, DepthInput::None, &[&remove[..], &iris].concat());
    assert_eq!(plain.samples, same.samples);
    write_moments_lens(folder, &["R", "G", "B"]);
    let refused = try_in_host(folder, DepthInput::None, &[&near[..1], &iris].concat());
    let report = refused.expect_err("no pupil");
    for word in [
        "Look: 6 blades",
        "Blades to Tilt Direction",
        "--model reduced",
    ] {
        assert!(report.contains(word), "{report}");
    }
    // Bloom is of the plate, not of the lens.
    let host = in_host(folder, DepthInput::None, &[&near[..1], &rest[7..]].concat());
    let line = "apply --lens @lens.json --distance 1.2";
    let bloom = "--bloom 0.3 --bloom-level 2.5 --bloom-radius 4";
    assert_equals_command(&host, folder, &format!("{line} {bloom}"));
}

/// A look with a name sets the knobs of the look; those that are given beside it come first.
#[test]
fn looks_with_a_name_equal_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_shades(folder, |shade, k| {
        shade * if k.is_multiple_of(517) { 30.0 } else { 0.2 }
    });
    let line = "apply --lens @lens.json --distance 1.2";
    let render = |knobs: &[(&str, &str)]| {
        in_host(
            folder,
            DepthInput::None,
            &[&[("distance", "1.2")], knobs].concat(),
        )
    };
    let swirl = render(&[("lookPreset", "Swirl")]);
    assert_equals_command(&swirl, folder, &format!("{line} --look swirl"));
    let options = "--blades 0 --cats-eye 1 --spherical 0.3";
    assert_equals_command(&swirl, folder, &format!("{line} {options}"));
    // One look takes the place of another, but for what was changed since.
    let host = render(&[
        ("lookPreset", "Swirl"),
        ("lookPreset", "Anamorphic"),
        ("catsEye", "0"),
        ("blades", "6"),
    ]);
    let line = format!("{line} --look anamorphic --cats-eye 0 --blades 6");
    assert_equals_command(&host, folder, &line);
    assert_ne!(host.samples, swirl.samples);
    let host = render(&[("lookPreset", "Swirl"), ("lookPreset", "As Lens")]);
    assert_eq!(host.samples, render(&[]).samples);
}

#[test]
fn pictures_of_the_aperture_equal_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_shades(folder, |shade, k| {
        shade * if k.is_multiple_of(517) { 30.0 } else { 0.2 }
    });
    let half = |shade: f32| {
        let lit = move |k: usize| if k % 30 < 14 { shade } else { 0.0 };
        (0..30 * 20).map(lit).collect::<Vec<f32>>()
    };
    let channels = [
        ("R", half(1.0)),
        ("G", half(0.7)),
        ("B", half(0.4)),
        ("A", half(0.9)),
    ];
    write_exr(&folder.join("aperture.exr"), 30, 20, &channels);
    let render = |feeds: &[(&str, &str)]| {
        let lens = folder.join("lens.json").display().to_string();
        let settings = [
            ("lens", "Lens File"),
            ("profile", lens.as_str()),
            ("distance", "1.2"),
            ("useAperture", "on"),
        ];
        let job = RenderJob {
            plugin: built_plugin("seidel_ofx").expect("built with the tests"),
            feeds: (feeds.iter())
                .map(|(clip, file)| ClipFile {
                    clip: (*clip).to_owned(),
                    file: folder.join(file),
                    channel: None,
                })
                .collect(),
            settings: settings
                .map(|(name, words)| (name.to_owned(), words.to_owned()))
                .to_vec(),
            ..RenderJob::default()
        };
        job.run()
    };
    let source = ("Source", "plate.exr");
    let host = render(&[source, ("Aperture", "aperture.exr")]).expect("rendered");
    let line = "apply --lens @lens.json --distance 1.2";
    let picture = "--aperture-picture @aperture.exr";
    assert_equals_command(&host, folder, &format!("{line} {picture}"));
    let plain = in_host(folder, DepthInput::None, &[("distance", "1.2")]);
    assert_ne!(host.samples, plain.samples);
    let report = render(&[source]).expect_err("no picture");
    assert!(report.contains("Use Aperture"), "{report}");
}

#[test]
fn lenses_of_the_library_equal_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_plate(&folder.join("plate.exr"), WIDTH, HEIGHT);
    for name in ["macro-100", "mirror-500"] {
        let label = format!("Library: {name}");
        let host = in_host(
            folder,
            DepthInput::None,
            &[("lens", &label), ("distance", "3")],
        );
        let line = format!("apply --lens library:{name} --distance 3");
        assert_equals_command(&host, folder, &line);
    }
}

#[test]
fn remove_and_relens_equal_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_nearly_equal_lens(folder, "lens.json", "other.json");
    let sample = |shade: f32, k: usize| {
        let tile = (k % WIDTH / 20 + k / WIDTH / 15) % 2;
        shade * (0.4 + 0.3 * tile as f32 + 0.002 * (k % WIDTH) as f32)
    };
    write_shades(folder, sample);
    let knobs = [("mode", "Remove"), ("distance", "1.6"), ("noise", "0.002")];
    let host = in_host(folder, DepthInput::None, &knobs);
    let common = "--distance 1.6 --noise 0.002 --lens-check off";
    let line = format!("remove --lens @lens.json {common} --no-overscan");
    assert_equals_command(&host, folder, &line);
    let host = in_host(
        folder,
        DepthInput::None,
        &[&knobs[..], &[("onlyChroma", "on")]].concat(),
    );
    let line = "remove --lens @lens.json --distance 1.6 --noise 0.002 --only-chroma";
    assert_equals_command(&host, folder, line);
    let other = folder.join("other.json").display().to_string();
    let knobs = [
        ("mode", "Relens"),
        ("toLens", "Lens File"),
        ("toProfile", other.as_str()),
        ("amount", "0.7"),
        ("distance", "1.6"),
        ("noise", "0.002"),
        ("fromFStop", "2.8"),
        ("toFocusDistance", "2"),
    ];
    let host = in_host(folder, DepthInput::None, &knobs);
    let sides = "--from-f-number 2.8 --to-focus-distance 2";
    let line = format!("relens --from @lens.json --to @other.json --amount 0.7 {common} {sides}");
    assert_equals_command(&host, folder, &line);
}

#[test]
fn the_lens_check_equals_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let channels = ["R", "G", "B"];
    write_moments_lens(folder, &channels);
    remove_lens_check::write_plate(folder, "plate.exr", &channels, 0.7);
    let knobs = [("mode", "Remove"), ("lensScale", "1"), ("distance", "1.6")];
    let pressed = [&knobs[..], &[("checkLens", "")]].concat();
    let line = "remove --lens @lens.json --lens-scale 1 --distance 1.6 --no-overscan";
    assert_equals_command(&in_host(folder, DepthInput::None, &pressed), folder, line);
    let off = format!("{line} --lens-check off");
    assert_equals_command(&in_host(folder, DepthInput::None, &knobs), folder, &off);
}

/// Writes a plate of ARRI LogC4 codes, with highlights.
fn write_log_plate(folder: &Path) {
    let table = seidel_colour::curves::CurveTable::embedded().expect("in order");
    let curve = &table.curves["logc4"].transfer;
    let sample = |shade: f32, k: usize| {
        let lamp = if k.is_multiple_of(97) { 40.0 } else { 0.0 };
        curve.encode(f64::from(shade) * (0.18 + lamp + 0.002 * (k % WIDTH) as f64)) as f32
    };
    write_shades(folder, sample);
}

#[test]
fn log_plates_are_blurred_as_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_log_plate(folder);
    let host = in_host(
        folder,
        DepthInput::None,
        &[("distance", "1.5"), ("sourceCodes", "ARRI LogC4")],
    );
    let line = "apply --lens @lens.json --distance 1.5 @plate.exr -o";
    succeeds(folder, &format!("{line} @taken-for-light.exr"));
    let spaces = "--in-space logc4 --working-space lin_arri_wide_gamut_4";
    succeeds(folder, &format!("{line} @out.exr {spaces}"));
    let (mut apart, mut else_apart) = (0.0_f32, 0.0_f32);
    for (c, name) in NAMES.iter().enumerate() {
        let command = read_channel(&folder.join("out.exr"), name);
        let wrong = read_channel(&folder.join("taken-for-light.exr"), name);
        for (k, wanted) in command.iter().enumerate() {
            let (x, y) = ((k % WIDTH) as i32, (HEIGHT - 1 - k / WIDTH) as i32);
            let got = host.pixel(x, y)[c];
            apart = apart.max((got - wanted).abs());
            else_apart = else_apart.max((got - wrong[k]).abs());
        }
    }
    assert!(apart < 2e-6, "{apart}");
    assert!(else_apart > 0.05, "it matters: {else_apart}");
}

#[test]
fn opencolorio_configs_equal_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_log_plate(folder);
    let config = folder.join("show.ocio");
    std::fs::write(&config, seidel_colour::EMBEDDED_CONFIG).expect("writable");
    let config = config.display().to_string();
    let common = [("distance", "1.5"), ("sourceCodes", "By OpenColorIO")];
    let line = "apply --lens @lens.json --distance 1.5";
    for (knobs, options) in [
        (
            &[("ocioConfig", "seidel"), ("sourceSpace", "logc4")][..],
            "--ocio seidel --in-space logc4",
        ),
        (
            &[
                ("ocioConfig", config.as_str()),
                ("sourceSpace", "ARRI LogC4"),
                ("workingSpace", "lin_arri_wide_gamut_4"),
            ],
            "--ocio @show.ocio --in-space logc4 --working-space lin_arri_wide_gamut_4",
        ),
        (
            &[
                ("ocioConfig", "ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1"),
                ("sourceSpace", "ACEScct"),
            ],
            "--ocio ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1 --in-space ACEScct",
        ),
    ] {
        let host = in_host(folder, DepthInput::None, &[&common[..], knobs].concat());
        assert_equals_command(&host, folder, &format!("{line} {options}"));
    }
    let removing = [
        ("mode", "Remove"),
        ("noise", "0.002"),
        ("ocioConfig", "seidel"),
        ("sourceSpace", "logc4"),
    ];
    let host = in_host(folder, DepthInput::None, &[&common[..], &removing].concat());
    let line =
        "remove --lens @lens.json --distance 1.5 --noise 0.002 --lens-check off --no-overscan";
    let line = format!("{line} --ocio seidel --in-space logc4");
    assert_equals_command(&host, folder, &line);
    let channels = ["R", "G", "B", "A"].map(|name| {
        let mut plane = read_channel(&folder.join("plate.exr"), name);
        plane[1234] = if name == "G" { f32::NAN } else { 0.5 };
        (name, plane)
    });
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
    let broken = [("ocioConfig", "seidel"), ("sourceSpace", "logc4")];
    let scrubbed = [&common[..], &broken, &[("scrub", "on")]].concat();
    let line = "apply --lens @lens.json --distance 1.5 --ocio seidel --in-space logc4 --scrub";
    assert_equals_command(&in_host(folder, DepthInput::None, &scrubbed), folder, line);
    for (knobs, words) in [
        (&broken[..], &["1 sample", "`ARRI LogC4`", "Scrub"][..]),
        (
            &[("ocioConfig", "seidel")],
            &["Source Space", "none is given"],
        ),
        (
            &[("ocioConfig", "seidel"), ("sourceSpace", "logc5")],
            &["logc5", "`logc4`"],
        ),
        (
            &[("ocioConfig", "no such.ocio"), ("sourceSpace", "logc4")],
            &["no such.ocio"],
        ),
    ] {
        let report = try_in_host(folder, DepthInput::None, &[&common[..], knobs].concat());
        let report = report.expect_err("refused");
        for word in words {
            assert!(report.contains(word), "{report}");
        }
    }
}

/// The region of an element over nothing grows by the reach of the blur, and shows what the command writes about it.
#[test]
fn an_element_grows_as_with_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    let disc = |k: usize| {
        let (x, y) = ((k % WIDTH) as f32 + 0.5, (k / WIDTH) as f32 + 0.5);
        let distance = (x - WIDTH as f32 / 2.0).hypot(y - HEIGHT as f32 / 2.0);
        (31.0 - distance).clamp(0.0, 1.0)
    };
    let plane = |shade: f32| (0..WIDTH * HEIGHT).map(|k| shade * disc(k)).collect();
    let channels: [(&str, Vec<f32>); 4] = [
        ("R", plane(1.0)),
        ("G", plane(0.8)),
        ("B", plane(0.6)),
        ("A", plane(1.0)),
    ];
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
    let knobs = [
        ("distance", "1"),
        ("quality", "Exact"),
        ("bloom", "0.4"),
        ("bloomLevel", "0.1"),
        ("bloomRadius", "0.5"),
    ];
    // The source fills the project, so nothing grows by itself.
    let own = in_host(folder, DepthInput::None, &knobs);
    assert_eq!((own.bounds.width(), own.bounds.height()), (WIDTH, HEIGHT));
    let grown = in_host(
        folder,
        DepthInput::None,
        &[&knobs[..], &[("expand", "On")]].concat(),
    );
    let (left, below) = (grown.bounds.x1, grown.bounds.y1);
    assert!(left < 0 && below < 0, "{:?}", grown.bounds);
    let line = "apply --lens @lens.json --distance 1 --quality exact --expand on --bloom 0.4 \
                --bloom-level 0.1 --bloom-radius 0.5";
    succeeds(folder, &format!("{line} @plate.exr -o @out.exr"));
    let image = exr::prelude::read_first_flat_layer_from_file(folder.join("out.exr"));
    let layer = image.expect("an EXR").layer_data;
    let (corner, size) = (layer.attributes.layer_position, layer.size);
    assert!(size.0 > WIDTH || size.1 > HEIGHT, "{size:?}");
    let mut outside = 0.0_f32;
    for (c, name) in NAMES.iter().enumerate() {
        let command = read_channel(&folder.join("out.exr"), name);
        for (k, wanted) in command.iter().enumerate() {
            let x = corner.0 + (k % size.0) as i32;
            let y = corner.1 + (k / size.0) as i32;
            let got = grown.pixel(x, HEIGHT as i32 - 1 - y)[c];
            assert!(
                (got - wanted).abs() < 1e-5,
                "{name} ({x}, {y}): {got}, not {wanted}"
            );
            if y < 0 || y >= HEIGHT as i32 {
                outside = outside.max(got);
            }
        }
    }
    assert!(outside > 0.01, "light beyond the plate: {outside}");
}
