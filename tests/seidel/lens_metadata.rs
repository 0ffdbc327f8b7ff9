//! The lens that a shot states: attributes of plates, and tables beside them.

use std::fmt::Write as _;
use std::path::Path;

use exr::prelude::*;

use crate::support::{
    must_refuse, must_refuse_options, read_channel, real_data, seidel_in, succeeds, write_plate,
    write_pupil_lens,
};

pub(crate) const FRAMES: i64 = 24;
const APPLY: &str =
    "apply --lens @lens.json @plate.%04d.exr -o @out.%04d.exr --frames 1001-1024 --lens-scale 1";

/// The focus of a frame, metres: a pull with decimal values.
pub(crate) fn focus(frame: i64) -> f64 {
    1.5 + (frame - 1001) as f64 / 10.0
}

/// Writes a plate with these attributes, and with the time code 10:00:00:FF of its frame if `frame` is given.
pub(crate) fn write_with(path: &Path, frame: Option<i64>, attributes: &[(&str, AttributeValue)]) {
    write_plate(path, 34, 26);
    let mut image = read_first_flat_layer_from_file(path).expect("readable");
    image.attributes.time_code = frame.map(|frame| attribute::TimeCode {
        hours: 10,
        frame: (frame - 1001) as u8,
        ..attribute::TimeCode::default()
    });
    for (name, value) in attributes {
        let own = &mut image.layer_data.attributes;
        match (*name, value) {
            ("focus", AttributeValue::F32(value)) => own.focus = Some(*value),
            ("aperture", AttributeValue::F32(value)) => own.aperture = Some(*value),
            _ => {
                own.other.insert(Text::from(*name), value.clone());
            }
        }
    }
    image.write().to_file(path).expect("writable");
}

/// Writes the plates of the shot, with `focus` and `aperture`.
pub(crate) fn write_shot(folder: &Path) {
    write_frames(folder, |frame| {
        vec![
            ("focus", AttributeValue::F32(focus(frame) as f32)),
            ("aperture", AttributeValue::F32(2.8)),
        ]
    });
}

fn write_frames(folder: &Path, attributes: impl Fn(i64) -> Vec<(&'static str, AttributeValue)>) {
    write_pupil_lens(folder, &["R", "G", "B"]);
    for frame in 1001..1001 + FRAMES {
        let path = folder.join(format!("plate.{frame}.exr"));
        write_with(&path, Some(frame), &attributes(frame));
    }
}

fn blurred(folder: &Path, line: &str) -> (Vec<Vec<f32>>, String) {
    let outcome = succeeds(folder, line);
    let frames = 1001..1001 + FRAMES;
    let planes = frames.map(|frame| read_channel(&folder.join(format!("out.{frame}.exr")), "G"));
    (planes.collect(), outcome.stderr)
}

/// Returns a table of `--animate` with the values of the shot.
fn write_animation(folder: &Path) {
    let mut table = "frame,focus-distance,f-number\n".to_owned();
    for frame in 1001..1001 + FRAMES {
        writeln!(table, "{frame},{},2.8", focus(frame)).expect("a string");
    }
    std::fs::write(folder.join("values.csv"), table).expect("writable");
}

/// Returns OpenTrackIO samples of the shot as a stream, with the fields `timing`.
pub(crate) fn samples(timing: impl Fn(i64) -> String) -> String {
    let sample = |frame: i64| {
        format!(
            r#"{{"protocol": {{"name": "OpenTrackIO", "version": [1, 0, 0]}}, "timing": {{{}}},
                "lens": {{"focusDistance": {}, "fStop": 2.8}}}}"#,
            timing(frame),
            focus(frame)
        )
    };
    (1001..1001 + FRAMES)
        .map(sample)
        .collect::<Vec<_>>()
        .join("\n")
}

pub(crate) fn time_code(frame: i64) -> String {
    format!(
        r#""timecode": {{"hours": 10, "minutes": 0, "seconds": 0, "frames": {}, "frameRate": {{"num": 24, "denom": 1}}}}"#,
        frame - 1001
    )
}

#[test]
fn a_focus_pull_by_attributes_or_by_opentrackio_equals_a_table_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_shot(folder);
    write_animation(folder);
    let (wanted, _) = blurred(folder, &format!("{APPLY} --animate @values.csv"));
    let (by_plate, notes) = blurred(folder, &format!("{APPLY} --lens-metadata plate"));
    assert!(by_plate == wanted);
    for part in [
        "focus 1.5 m from attribute `focus` of plate.1001.exr (1.5 to 3.8 m over 24 frames)",
        "f-number 2.8 from attribute `aperture` of plate.1001.exr (constant over 24 frames)",
    ] {
        assert!(notes.contains(part), "`{part}` is missing in {notes}");
    }
    let info = succeeds(folder, "info @out.1024.exr").stdout;
    let source = "lens-metadata: focus-distance: attribute `focus`; f-number: attribute `aperture`";
    assert!(info.contains(source), "{info}");
    assert!(info.contains("focus: 3.8 m"), "{info}");
    write_frames(folder, |_| Vec::new());
    std::fs::write(folder.join("track.json"), samples(time_code)).expect("writable");
    let (by_track, notes) = blurred(folder, &format!("{APPLY} --lens-metadata @track.json"));
    assert!(by_track == wanted);
    assert!(
        notes.contains("(OpenTrackIO, matched by time code)"),
        "{notes}"
    );
    let info = succeeds(folder, "info @out.1024.exr").stdout;
    assert!(
        info.contains("seidelLensMetadata: track.json sha256:"),
        "{info}"
    );
    let numbered =
        |first: i64| samples(|frame| format!(r#""sequenceNumber": {}"#, frame - 1001 + first));
    for (first, extra, rule) in [
        (1001, "", "matched by frame number"),
        (0, "", "matched in order"),
        (
            5,
            "--lens-metadata-start 1001",
            "with the first row at frame 1001",
        ),
    ] {
        std::fs::write(folder.join("track.json"), numbered(first)).expect("writable");
        let line = format!("{APPLY} --lens-metadata @track.json {extra}");
        let (by_track, notes) = blurred(folder, &line);
        assert!(by_track == wanted, "{rule}");
        assert!(notes.contains(rule), "{notes}");
    }
    std::fs::write(folder.join("track.json"), numbered(2001)).expect("writable");
    let line = format!("{APPLY} --lens-metadata @track.json");
    must_refuse(
        folder,
        &line,
        &[
            "frames 2001 to 2024",
            "frames 1001 to 1024",
            "--lens-metadata-start",
        ],
    );
}

/// Writes one plate with attributes, and returns the notes of `apply` with the options `extra`.
fn notes(folder: &Path, attributes: &[(&str, AttributeValue)], extra: &str) -> String {
    write_with(&folder.join("plate.exr"), None, attributes);
    let line = "apply --lens @lens.json @plate.exr -o @out.exr --lens-scale 1 --frames-are-none";
    let line = line.replace("--frames-are-none", extra);
    let outcome = seidel_in(folder, &line);
    assert!(outcome.status < 2, "{}", outcome.stderr);
    outcome.stderr
}

fn text(text: &str) -> AttributeValue {
    AttributeValue::Text(Text::from(text))
}

#[test]
fn plates_that_state_their_lens_are_noted_and_options_come_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    let focus = ("focus", AttributeValue::F32(3.2));
    let aperture = ("aperture", AttributeValue::F32(2.8));
    let both = [focus.clone(), aperture];
    let unused = notes(folder, &both, "");
    let line = "the plate says focus 3.2 m, f/2.8: --lens-metadata plate uses it";
    assert!(unused.contains(line), "{unused}");
    let unused = notes(folder, &both, "--f-number 4");
    assert!(unused.contains("says focus 3.2 m: "), "{unused}");
    let unused = notes(folder, &both, "--f-number 4 --focus-distance 2");
    assert!(!unused.contains("the plate says"), "{unused}");
    let used = notes(folder, &both, "--lens-metadata plate --f-number 4");
    assert!(
        used.contains(
            "not used: f-number 2.8 from attribute `aperture`, since --f-number comes first"
        ),
        "{used}"
    );
    let first = read_channel(&folder.join("out.exr"), "G");
    notes(folder, &[], "--focus-distance 3.2 --f-number 4");
    assert!(first == read_channel(&folder.join("out.exr"), "G"));
    // Scene units, a film back called aperture, a target that stands for none, a T-number, an identity.
    let vray = [
        ("cameraTargetDistance", AttributeValue::F32(320.0)),
        ("cameraFNumber", AttributeValue::F32(2.8)),
        ("cameraAperture", AttributeValue::F32(36.0)),
    ];
    let used = notes(folder, &vray, "--lens-metadata plate");
    assert!(
        used.contains(
            "not used: focus 320 scene units of attribute `cameraTargetDistance`; give --depth-unit"
        ),
        "{used}"
    );
    let used = notes(folder, &vray, "--lens-metadata plate --depth-unit cm");
    assert!(
        used.contains("focus 3.2 m from attribute `cameraTargetDistance`"),
        "{used}"
    );
    let used = notes(
        folder,
        &[
            ("tStop", AttributeValue::F32(2.9)),
            ("lensModel", text("M0.8")),
        ],
        "--lens-metadata plate",
    );
    assert!(
        used.contains("f-number 2.9 from attribute `tStop`"),
        "{used}"
    );
    assert!(used.contains("T-number"), "{used}");
    assert!(used.contains("lens of the shot: M0.8"), "{used}");
    let far = notes(
        folder,
        &[("focus", AttributeValue::F32(40.0))],
        "--lens-metadata plate",
    );
    assert!(
        far.contains("focus 40 m from attribute `focus` lies outside of the depth pass"),
        "{far}"
    );
    let pupil = ("entrancePupilOffset", AttributeValue::F32(100.0));
    let used = notes(folder, &[focus, pupil], "--lens-metadata plate");
    assert!(
        used.contains("focus 3.1 m from attribute `focus`"),
        "{used}"
    );
    assert!(
        used.contains("3.2 m of attribute `focus` is from the sensor"),
        "{used}"
    );
}

#[test]
fn an_attribute_of_a_studio_is_used_by_its_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    let own = [
        ("studio:focus", AttributeValue::F32(3200.0)),
        ("focus", AttributeValue::F32(7.0)),
    ];
    let named = "--lens-metadata plate --lens-attribute focus=studio:focus:mm";
    let used = notes(folder, &own, named);
    assert!(
        used.contains("focus 3.2 m from attribute `studio:focus` of plate.exr"),
        "{used}"
    );
    assert!(used.contains("attribute `focus` disagrees"), "{used}");
    let first = read_channel(&folder.join("out.exr"), "G");
    notes(folder, &[], "--focus-distance 3.2");
    assert!(first == read_channel(&folder.join("out.exr"), "G"));
    let line = "apply --lens @lens.json @plate.exr -o @none.exr --lens-scale 1";
    write_with(&folder.join("plate.exr"), None, &own);
    let other = format!("{line} --lens-metadata plate --lens-attribute focus=other");
    must_refuse(
        folder,
        &other,
        &["`other`", "does not exist", "seidel info"],
    );
    std::fs::write(folder.join("t.json"), samples(time_code)).expect("writable");
    for (options, word) in [
        (
            "--lens-metadata plate --lens-attribute iris=other",
            "focal-length",
        ),
        (
            "--lens-metadata @t.json --lens-attribute focus=other",
            "--lens-metadata plate",
        ),
    ] {
        must_refuse_options(folder, &format!("{line} {options}"), &[word]);
    }
}

#[test]
fn values_that_cannot_be_true_are_refused_by_file_and_field() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    let float = AttributeValue::F32;
    let focal = ("nominalFocalLength", float(40.0));
    for (attributes, expected) in [
        (
            vec![("focus", float(410.0)), focal.clone()],
            "is 410 m on a lens of 40 mm, where 0.41 m fits",
        ),
        (
            vec![("focus", float(0.03)), focal],
            "nearer than the focal length of 40 mm",
        ),
        (vec![("focus", float(1e18))], "which no lens has"),
        (vec![("focus", float(-2.0))], "not above 0"),
        (vec![("FNumber", text("near"))], "is not a number"),
        (vec![("aperture", float(f32::NAN))], "is not a number"),
        (
            vec![("aperture", float(f32::INFINITY))],
            "which no lens has",
        ),
        (
            vec![("cameraTargetDistance", float(1e18))],
            "states no focus",
        ),
        (vec![], "states no focus"),
    ] {
        let refused = notes(folder, &attributes, "--lens-metadata plate");
        assert!(refused.contains("error: "), "{expected}: {refused}");
        assert!(
            refused.contains("plate.exr") && refused.contains(expected),
            "{expected}: {refused}"
        );
        assert!(!folder.join("out.exr").exists());
    }
    let infinite = notes(
        folder,
        &[("focus", float(f32::INFINITY))],
        "--lens-metadata plate",
    );
    assert!(
        infinite.contains("focus inf from attribute `focus`"),
        "{infinite}"
    );
}

#[test]
fn frames_without_a_value_are_interpolated_if_they_are_few() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_shot(folder);
    write_animation(folder);
    for frame in [1005, 1006] {
        write_with(&folder.join(format!("plate.{frame}.exr")), None, &[]);
    }
    let line = format!("{APPLY} --lens-metadata plate");
    let (_, notes) = blurred(folder, &line);
    assert!(
        notes.contains("attribute `focus` is missing in frames 1005, 1006: interpolated"),
        "{notes}"
    );
    for frame in 1003..=1014 {
        write_with(&folder.join(format!("plate.{frame}.exr")), None, &[]);
    }
    for frame in 1001..=1024 {
        std::fs::remove_file(folder.join(format!("out.{frame}.exr"))).expect("there");
    }
    must_refuse(
        folder,
        &line,
        &[
            "plate.1003.exr",
            "frame 1003, attribute `focus`",
            "12 of 24 frames",
        ],
    );
}

#[test]
fn relens_and_remove_use_metadata_for_both_lenses() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_with(
        &folder.join("plate.exr"),
        None,
        &[("focus", AttributeValue::F32(3.2))],
    );
    let compare = |line: &str| {
        succeeds(folder, &format!("{line} -o @a.exr --lens-metadata plate"));
        succeeds(folder, &format!("{line} -o @b.exr --focus-distance 3.2"));
        let [a, b] = ["a.exr", "b.exr"].map(|name| read_channel(&folder.join(name), "G"));
        assert!(a == b, "{line}");
    };
    compare("remove --lens @lens.json @plate.exr --distance 2 --lens-check off");
    compare(
        "relens --from @lens.json --to library:modern-50 @plate.exr --distance 2 --lens-check off",
    );
}

#[test]
fn the_makers_own_tables_give_their_known_values() {
    let Some(data) = real_data("lens-metadata") else {
        return;
    };
    for (file, values) in [
        (
            "arri/B001C001_180327_R1ZA.mov.csv",
            ["focus: 4.812 m", "focal length: 40 mm", "T-number: 1.782"],
        ),
        (
            "red/A001_C066_0303LZ_001.frames.csv",
            ["focus: 0.41 m", "focal length: 40 mm", "T-number: 5.6"],
        ),
        (
            "sony/D001C005_210716AG.csv",
            [
                "focus: 1.777 m (5.83 ft)",
                "focal length: 32 mm",
                "T-number: 2.2191",
            ],
        ),
        (
            "canon/20221007_TNumber_CanonCameraMetadata_Frames.csv",
            ["focus: 0.5 m", "focal length: 18 mm", "T-number: 4.5"],
        ),
        (
            "blackmagic/metadata.txt",
            ["focus: 0.991 m", "focal length: 50 mm", "T-number: 2.3"],
        ),
        (
            "opentrackio/complete_static_example.json",
            ["focus: 10 m", "f-number: 4", "film back: 36 mm"],
        ),
        (
            "opentrackio/recommended_dynamic_example.json",
            ["focus: 10 m", "focal length: 24.305 mm", "01:02:03:04"],
        ),
    ] {
        let outcome = succeeds(&data, &format!("info @{file}"));
        for value in values {
            assert!(
                outcome.stdout.contains(value),
                "{file}: `{value}` is missing in {}",
                outcome.stdout
            );
        }
    }
}
