//! Damaged and hostile inputs at the command: refused by name, and harmless to the terminal, the machine and other frames.

use std::fs;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image,
    Layer, LayerAttributes, LineOrder, Text, WritableImage, f16,
};

use crate::support::{
    listing, must_refuse, read_channel, real_data, seidel, seidel_in, succeeds,
    write_generated_set, write_moments_lens, write_plate, write_pupil_lens,
};

/// Writes a smooth picture compressed by DWAA, with a text attribute.
fn write_dwaa(path: &Path, comments: &str) {
    let samples = (0..64 * 40).map(|k| f16::from_f32(0.01 * (k % 64) as f32));
    let samples: Vec<f16> = samples.collect();
    let channel = |name: &str| AnyChannel::new(name, FlatSamples::F16(samples.clone()));
    let channels = ["B", "G", "R"].map(channel).into_iter().collect();
    let mut attributes = LayerAttributes::default();
    let text = AttributeValue::Text(Text::from(comments));
    attributes.other.insert(Text::from("slateText"), text);
    let encoding = Encoding {
        compression: Compression::DWAA(None),
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((64, 40), attributes, encoding, AnyChannels::sort(channels));
    let written = Image::from_layer(layer).write().to_file(path);
    written.expect("the folder is writable");
}

#[test]
fn a_damaged_dwa_frame_fails_alone_and_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for frame in 1..=3 {
        write_dwaa(&folder.join(format!("in.{frame}.exr")), "sound");
    }
    let damaged = folder.join("in.2.exr");
    let mut bytes = fs::read(&damaged).expect("readable");
    // Row 0 as 32 bits, the length of the chunk as 32 bits, and version 2 as 64 bits.
    let is_chunk = |w: &[u8]| w[..4] == [0; 4] && w[4] > 0 && w[8..] == [2, 0, 0, 0, 0, 0, 0, 0];
    let chunk = bytes.windows(16).position(is_chunk).expect("a chunk");
    // The number of AC coefficients, the ninth of the counters.
    let count = chunk + 8 + 8 * 8;
    bytes[count..count + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    fs::write(&damaged, bytes).expect("writable");
    let line =
        "lut @in.%d.exr -o @out.%d.exr --in-space ACEScg --out-space ACES2065-1 --frames 1-3";
    let outcome = seidel_in(folder, line);
    assert_eq!(outcome.status, 1, "{}", outcome.stderr);
    let list = "error: 1 of 3 frames failed:\n  frame 2: ";
    assert!(outcome.stderr.contains(list), "{}", outcome.stderr);
    let problem =
        "in.2.exr: is damaged or truncated (total_ac_count of a DWA chunk is 1099511627776";
    assert!(outcome.stderr.contains(problem), "{}", outcome.stderr);
    for (frame, is_written) in [(1, true), (2, false), (3, true)] {
        let path = folder.join(format!("out.{frame}.exr"));
        assert_eq!(path.exists(), is_written, "{frame}");
    }
}

#[test]
fn texts_of_files_cannot_control_the_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_dwaa(&folder.join("a.exr"), "x\u{1b}]0;title\u{7}\u{1b}[2Jy");
    for json in ["", "--json"] {
        let report = succeeds(folder, &format!("info @a.exr {json}")).stdout;
        assert!(
            report.contains(r"x\u001b]0;title\u0007\u001b[2Jy"),
            "{report}"
        );
        let is_control = |c: char| c.is_control() && c != '\n';
        assert!(!report.contains(is_control), "{report:?}");
    }
    let refused = seidel(&["info", "no\u{1b}[2Jfile.exr"]);
    assert_eq!(refused.status, 1);
    let expected = r"no\u001b[2Jfile.exr";
    assert!(refused.stderr.contains(expected), "{}", refused.stderr);
    write_pupil_lens(folder, &["Y"]);
    let path = folder.join("lens.json");
    let lens = fs::read_to_string(&path).expect("readable");
    fs::write(&path, lens.replace("\"alpha\"", "\"al\\tpha\"")).expect("writable");
    let refused = seidel_in(folder, "lens show @lens.json -o @sheet.png");
    assert!(
        refused.stderr.contains(r"al\u0009pha"),
        "{}",
        refused.stderr
    );
    let places = refused.stderr.matches("column").count();
    assert_eq!(places, 1, "the place stands once: {}", refused.stderr);
}

#[test]
fn an_empty_file_name_is_refused_with_its_option() {
    for option in ["--depth", "--holdout", "--background"] {
        let line = [
            "apply", "--lens", "l.json", "a.exr", "-o", "b.exr", option, "",
        ];
        let refused = seidel(&line);
        assert_eq!(refused.status, 2, "{}", refused.stderr);
        assert!(refused.stderr.contains(option), "{}", refused.stderr);
    }
}

#[test]
fn a_blur_too_large_to_draw_is_refused_by_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_generated_set(folder, "set", &["Y"]);
    write_pupil_lens(folder, &["Y"]);
    write_plate(&folder.join("plate.exr"), 30, 20);
    let lens = fs::read_to_string(folder.join("lens.json")).expect("readable");
    let mut lens: serde_json::Value = serde_json::from_str(&lens).expect("JSON");
    lens["channels"][0]["blur_variance_px2"]["coefficients"] = serde_json::json!([5.6e8]);
    fs::write(folder.join("lens.json"), lens.to_string()).expect("writable");
    for line in [
        "psf --lens @lens.json --like @set --out @out",
        "eval --lens @lens.json @set",
        "diagnose --lens @lens.json @set --out @out",
        "lens show @lens.json -o @sheet.png",
        "apply --lens @lens.json --distance 2 @plate.exr -o @out.exr",
        "remove --lens @lens.json --distance 2 @plate.exr -o @out.exr",
    ] {
        let parts = ["lens.json: channels[0] (Y): blur_variance_px2", "10000 px²"];
        must_refuse(folder, line, &parts);
    }
}

#[test]
fn rays_beyond_any_frame_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    let lens = fs::read_to_string(folder.join("lens.json")).expect("readable");
    let mut lens: serde_json::Value = serde_json::from_str(&lens).expect("JSON");
    lens["channels"][0]["delta"]["coefficients"] = serde_json::json!([1e300]);
    fs::write(folder.join("lens.json"), lens.to_string()).expect("writable");
    let parts = [
        "lens.json: channels[0] (Y): delta: coefficients",
        "100000 px",
    ];
    must_refuse(folder, "lens show @lens.json -o @sheet.png", &parts);
}

#[test]
fn positions_far_beyond_the_frame_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_generated_set(folder, "set", &["Y"]);
    write_pupil_lens(folder, &["Y"]);
    let path = folder.join("set/manifest.json");
    let manifest = fs::read_to_string(&path).expect("readable");
    let mut manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    manifest["observations"][1]["x"] = serde_json::json!(1e300);
    fs::write(&path, manifest.to_string()).expect("writable");
    for line in ["eval --lens @lens.json @set", "fit @set -o @out.json"] {
        must_refuse(folder, line, &["x, y", "up to 10 million"]);
    }
}

/// Pipes that nobody writes to would be waited for, and `/dev/zero` has no end.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_as_inputs() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    write_plate(&folder.join("plate.exr"), 30, 20);
    let made = std::process::Command::new("mkfifo")
        .arg(folder.join("pipe"))
        .status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo");
    std::os::unix::fs::symlink("/dev/zero", folder.join("zero")).expect("linked");
    for name in ["pipe", "zero"] {
        for line in [
            "apply --lens @NAME --distance 2 @plate.exr -o @out.exr",
            "apply --lens @lens.json --distance 2 @NAME -o @out.exr",
            "apply --lens @lens.json --depth @NAME @plate.exr -o @out.exr",
            "lut @plate.exr -o @out.exr --ocio @NAME --in-space Camera --out-space ACEScg",
            "info @NAME",
        ] {
            let parts = [name, "is a pipe or a device, not a file"];
            must_refuse(folder, &line.replace("NAME", name), &parts);
        }
    }
}

#[test]
fn threads_without_bound_are_refused() {
    for command in ["apply", "remove", "relens", "lut", "diagnose"] {
        let refused = seidel(&[command, "--threads", "5000"]);
        assert_eq!(refused.status, 2, "{command}");
        let limit = "from 1 to 1024";
        assert!(refused.stderr.contains(limit), "{}", refused.stderr);
    }
}

#[cfg(unix)]
#[test]
fn names_need_not_be_unicode() {
    use std::ffi::{OsStr, OsString};
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    let at = |name: &[u8]| folder.join(OsStr::from_bytes(name)).into_os_string();
    for frame in [b"caf\xe9.1.exr", b"caf\xe9.2.exr"] {
        write_plate(Path::new(&at(frame)), 30, 20);
    }
    let words = |input: &[u8], output: &[u8], more: &str| -> Vec<OsString> {
        let mut words: Vec<OsString> = ["apply", "-o"].map(OsString::from).into();
        words.extend([at(output), at(input), "--lens".into(), at(b"lens.json")]);
        words.extend(more.split_whitespace().map(OsString::from));
        words
    };
    let one = seidel(&words(b"caf\xe9.1.exr", b"\xff.exr", ""));
    assert_eq!(one.status, 0, "{}", one.stderr);
    let all = seidel(&words(b"caf\xe9.%d.exr", b"\xff.%02d.exr", "--frames 1-2"));
    assert_eq!(all.status, 0, "{}", all.stderr);
    let rendered = |name: &[u8]| read_channel(Path::new(&at(name)), "G");
    assert_eq!(rendered(b"\xff.exr"), rendered(b"\xff.01.exr"));
    assert!(listing(folder).contains(&at(b"\xff.02.exr").into()));
}

#[test]
fn provenance_holds_names_of_files_unless_paths_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    write_plate(&folder.join("plate.exr"), 30, 20);
    let bytes = |name: &str| fs::read(folder.join(name)).expect("written");
    let path = folder.to_string_lossy().into_owned();
    let holds = |name: &str, text: &str| {
        let bytes = bytes(name);
        bytes.windows(text.len()).any(|w| w == text.as_bytes())
    };
    let apply = "apply --lens @lens.json";
    succeeds(folder, &format!("{apply} @plate.exr -o @names.exr"));
    assert!(!holds("names.exr", &path));
    let command = "seidel apply --lens lens.json plate.exr -o names.exr";
    assert!(holds("names.exr", command));
    succeeds(
        folder,
        &format!("{apply} @plate.exr -o @full.exr --provenance full"),
    );
    assert!(holds("full.exr", &path) && holds("full.exr", "plate.exr"));
    // Earlier provenance is shortened too.
    succeeds(folder, &format!("{apply} @full.exr -o @again.exr"));
    assert!(!holds("again.exr", &path));
    assert!(holds(
        "again.exr",
        "seidel apply --lens lens.json plate.exr -o full.exr"
    ));
    succeeds(
        folder,
        &format!("{apply} @plate.exr -o @none.exr --provenance none"),
    );
    succeeds(
        folder,
        &format!("{apply} @plate.exr -o @same.exr --no-provenance"),
    );
    assert!(!holds("none.exr", "seidel"));
    assert_eq!(bytes("none.exr"), bytes("same.exr"));
}

/// Files that once broke a command: each is refused by name, or has a finite result.
#[test]
fn files_that_broke_a_command_are_refused_or_rendered() {
    let Some(data) = real_data("bad") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for entry in fs::read_dir(data).expect("a folder").flatten() {
        if entry.path().is_file() {
            fs::write(
                folder.join(entry.file_name()),
                fs::read(entry.path()).expect("readable"),
            )
            .expect("writable");
        }
    }
    write_generated_set(folder, "set", &["R", "G", "B"]);
    for line in [
        "remove --lens @mom.json --distance 2.2 --lens-scale 0.3 @remove_nan.exr",
        "apply --lens @mom.json --distance 2.2 --lens-scale 0.3 @fltmax.exr",
        "apply --lens @mom.json --distance 2.2 --lens-scale 0.3 @overflow_nonfinite_fuzz.exr",
    ] {
        succeeds(folder, &format!("{line} -o @out.exr"));
        for channel in ["R", "G", "B"] {
            let samples = read_channel(&folder.join("out.exr"), channel);
            assert!(samples.iter().all(|v| v.is_finite()), "{line}: {channel}");
        }
    }
    for (line, parts) in [
        (
            "lut @dwa_alloc_abort.exr -o @no.exr --in-space ACEScg --out-space ACES2065-1",
            ["dwa_alloc_abort.exr: is damaged", "total_ac_count"],
        ),
        (
            "psf --lens @lens_huge_blur.json --like @set --out @no",
            [
                "lens_huge_blur.json: channels[0] (R): blur_variance_px2",
                "10000 px²",
            ],
        ),
        (
            "psf --lens @lens_alloc_abort.json --like @set --out @no",
            [
                "lens_alloc_abort.json: channels[0] (R): blur_variance_px2",
                "10000 px²",
            ],
        ),
        (
            "lut --list --ocio @alias_bomb.ocio",
            ["alias_bomb.ocio: line 7", "1000000 values"],
        ),
    ] {
        must_refuse(folder, line, &parts);
    }
    let info = succeeds(folder, "info @escape.exr").stdout;
    assert!(
        info.contains(r"\u001b[2J9.9") && !info.contains('\u{1b}'),
        "{info}"
    );
}
