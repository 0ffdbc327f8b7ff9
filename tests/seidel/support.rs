//! Helpers of the tests: commands run in process, and generated data.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use exr::prelude::*;
use seidel_core::profile::{LensDescription, Provenance, PupilChannel};
use seidel_core::{
    Camera, FieldPoint, Frame, ImagePoint, LensProfile, LocalBlur, ObjectDistance, Observation,
    ObservationSet, Tile,
};
use seidel_optics::lens::{ReducedNumbers, VergenceSeries};
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::psf::{MirroredPair, PsfModel, SampleGrid};

/// The result of a command.
pub(crate) struct Outcome {
    /// Exit status.
    pub(crate) status: u8,
    /// Its output on stdout.
    pub(crate) stdout: String,
    /// Its output on stderr.
    pub(crate) stderr: String,
}

/// Runs `seidel` with `args` in this process.
pub(crate) fn seidel<S: Into<OsString> + Clone>(args: &[S]) -> Outcome {
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    let program = std::iter::once(OsString::from("seidel"));
    let status = seidel::run(
        program.chain(args.iter().cloned().map(Into::into)),
        &mut seidel::Console {
            stdout: &mut stdout,
            stderr: &mut stderr,
            progress: seidel::ProgressOutput::hidden(),
        },
    );
    Outcome {
        status,
        stdout: String::from_utf8_lossy(&stdout).into_owned(),
        stderr: String::from_utf8_lossy(&stderr).into_owned(),
    }
}

/// Runs a command line, split at spaces. `@name` is replaced by the path of `name` in `folder`.
pub(crate) fn seidel_in(folder: &Path, line: &str) -> Outcome {
    let args: Vec<OsString> = line
        .split_whitespace()
        .map(|word| match word.strip_prefix('@') {
            Some(name) => folder.join(name).into_os_string(),
            None => OsString::from(word),
        })
        .collect();
    seidel(&args)
}

/// Runs a command line as [`seidel_in`] and asserts that it succeeds.
pub(crate) fn succeeds(folder: &Path, line: &str) -> Outcome {
    let outcome = seidel_in(folder, line);
    assert_eq!(outcome.status, 0, "{line}: {}", outcome.stderr);
    outcome
}

/// Runs a command line as [`seidel_in`] and asserts that it fails with exit status 1, that its message contains all
/// `parts` and a remedy, and that the folder is unchanged.
pub(crate) fn must_refuse(folder: &Path, line: &str, parts: &[&str]) {
    must_refuse_with(1, folder, line, parts);
}

/// As [`must_refuse`], for a command line that is not valid: the exit status is 2.
pub(crate) fn must_refuse_options(folder: &Path, line: &str, parts: &[&str]) {
    must_refuse_with(2, folder, line, parts);
}

fn must_refuse_with(status: u8, folder: &Path, line: &str, parts: &[&str]) {
    let before = listing(folder);
    let outcome = seidel_in(folder, line);
    assert_eq!(outcome.status, status, "{line}: {}", outcome.stderr);
    for part in parts {
        assert!(
            outcome.stderr.contains(part),
            "{line}: `{part}` is missing in: {}",
            outcome.stderr
        );
    }
    let has_remedy = outcome.stderr.contains(';') || outcome.stderr.contains(": give ");
    assert!(has_remedy, "a remedy: {}", outcome.stderr);
    assert_eq!(listing(folder), before, "{line} changed the folder");
}

/// The path of measured data: below `SEIDEL_DATA`, or below `shared/data` beside the repository. `None` if it does not
/// exist; the test's output then contains a line `SKIPPED`.
pub(crate) fn real_data(part: &str) -> Option<PathBuf> {
    let root = std::env::var_os("SEIDEL_DATA").map_or_else(
        || {
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../../shared")
                .join("data")
        },
        PathBuf::from,
    );
    let path = root.join(part);
    if path.exists() {
        return Some(path);
    }
    // `writeln!` is not captured as `eprintln!` is, so the line appears although the test passes.
    let _ = writeln!(
        std::io::stderr(),
        "SKIPPED: no real data at {} (set SEIDEL_DATA)",
        path.display()
    );
    None
}

/// Defocus of the generated lens in `channel` at `vergence`. It stays large enough for the moments to be measurable on
/// a pixel grid.
pub(crate) fn true_alpha(channel: usize, vergence: f64) -> f64 {
    3.5 + 5.0 * vergence + 0.3 * channel as f64
}

/// Reduced numbers of the generated lens with a given defocus.
pub(crate) fn true_numbers(alpha: f64) -> ReducedNumbers {
    ReducedNumbers {
        alpha,
        beta: 0.4,
        gamma: 0.8,
        delta: -0.7,
        phi: 0.3,
    }
}

/// Observations of the lens of [`true_numbers`] on a 300 x 200 frame, at 6 x 4 places and each of `distances`. Defocus
/// differs by channel.
pub(crate) fn generated_set(channels: &[&str], distances: &[ObjectDistance]) -> ObservationSet {
    let frame = Frame::new(300, 200, None).expect("a valid frame");
    let mut observations = Vec::new();
    for &distance in distances {
        let vergence = distance.vergence_per_m().unwrap_or(0.3);
        for place in 0..24 {
            let ideal = ImagePoint::new(
                20.0 + 51.7 * f64::from(place % 6),
                18.0 + 54.3 * f64::from(place / 6),
            );
            let at = frame.field_point(ideal);
            let centre = ImagePoint::new(ideal.x_px.round() + 0.5, ideal.y_px.round() + 0.5);
            let tiles = (0..channels.len())
                .map(|channel| generated_tile(&frame, at, centre, vergence, channel))
                .collect();
            let file = format!("psf/{:04}.exr", observations.len());
            observations.push(Observation {
                ideal: Some(ideal),
                ..Observation::new(file, centre, distance, tiles)
            });
        }
    }
    let channels = channels.iter().map(|&c| c.to_owned()).collect();
    ObservationSet {
        axis_stated: true,
        pixel_pitch_um: Some(6.0),
        ..ObservationSet::new(frame, channels, observations)
    }
}

/// Side of generated tiles, px.
pub(crate) const TILE: usize = 45;

fn generated_tile(
    frame: &Frame,
    at: FieldPoint,
    centre: ImagePoint,
    vergence: f64,
    channel: usize,
) -> Tile {
    let size = TILE;
    // Lateral chromatic aberration of 0.3 px between channels at the edge of the field.
    let stretch = 1.0 + 0.002 * channel as f64;
    let centroid = frame.image_point(FieldPoint::new(at.x * stretch, at.y * stretch));
    let half = size as f64 / 2.0;
    let window = SampleGrid::for_tile(
        size,
        size,
        centroid.x_px - centre.x_px + half,
        centroid.y_px - centre.y_px + half,
    );
    let blur = LocalBlur::from_moments(
        true_numbers(true_alpha(channel, vergence))
            .coefficients()
            .moments(at)
            .with_added_variance(PIXEL_VARIANCE_PX2),
        at.meridian(),
    );
    let mut samples = vec![0.0; window.len()];
    MirroredPair.sample(&blur, &window, &mut samples);
    Tile::new(size, size, samples.iter().map(|&v| v as f32).collect()).expect("finite")
}

/// Writes a [`generated_set`] at 1.2 m, 2.5 m and infinity into `folder`/`name`.
pub(crate) fn write_generated_set(folder: &Path, name: &str, channels: &[&str]) {
    let distances = [
        ObjectDistance::Metres(1.2),
        ObjectDistance::Metres(2.5),
        ObjectDistance::Infinity,
    ];
    let set = generated_set(channels, &distances);
    seidel_image_io::observation_set::write(&set, &folder.join(name))
        .expect("the folder is writable");
}

/// Fits `folder`/`lens.json` by moments to a [`generated_set`].
pub(crate) fn write_moments_lens(folder: &Path, channels: &[&str]) {
    write_generated_set(folder, "set", channels);
    succeeds(folder, "fit @set -o @lens.json --model moments");
}

/// Writes `folder`/`lens.json`: the lens of [`generated_set`] as a `pupil` profile, focused at infinity at f/2.
pub(crate) fn write_pupil_lens(folder: &Path, channels: &[&str]) {
    let constant = VergenceSeries::constant;
    let numbers = true_numbers(0.0);
    let of_channel = |(index, name): (usize, &&str)| PupilChannel {
        name: (*name).to_owned(),
        alpha: VergenceSeries::new(vec![
            true_alpha(index, 0.0),
            true_alpha(index, 1.0) - true_alpha(index, 0.0),
        ]),
        beta: constant(numbers.beta),
        gamma: constant(numbers.gamma),
        delta: constant(numbers.delta),
        phi: constant(numbers.phi),
        blur_variance_px2: constant(0.05),
        effects: Vec::new(),
        magnification: constant(0.002 * index as f64),
        distortion: constant(0.0),
        measured_vergence: (0.0, 1.0 / 1.2),
        stop_lever_m: 0.0,
        added: Vec::new(),
        picture: None,
        wavelength_px: 0.0,
    };
    let lens = LensProfile {
        frame: Frame::new(300, 200, None).expect("a valid frame"),
        pixel_pitch_um: Some(6.0),
        camera: Camera {
            focal_length_mm: Some(50.0),
            f_number: Some(2.0),
            ..Camera::default()
        },
        description: LensDescription::Pupil(channels.iter().enumerate().map(of_channel).collect()),
        held_out: None,
        provenance: Provenance::default(),
    };
    std::fs::write(folder.join("lens.json"), lens.to_json()).expect("the folder is writable");
}

/// Writes `folder`/`to`: the lens of `folder`/`from`, one number of its first channel changed by a millionth.
pub(crate) fn write_nearly_equal_lens(folder: &Path, from: &str, to: &str) {
    fn change(value: &mut serde_json::Value) -> bool {
        match value {
            serde_json::Value::Array(values) => values.iter_mut().any(change),
            serde_json::Value::Object(values) => values.values_mut().any(change),
            _ => match value.as_f64().filter(|number| *number != 0.0) {
                Some(number) => {
                    *value = serde_json::json!(number * 1.000_001);
                    true
                }
                None => false,
            },
        }
    }
    let text = std::fs::read_to_string(folder.join(from)).expect("a lens");
    let mut lens: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert!(change(&mut lens["channels"]), "a number");
    std::fs::write(folder.join(to), lens.to_string()).expect("the folder is writable");
}

/// Writes an EXR file of 32-bit float channels.
pub(crate) fn write_exr(path: &Path, width: usize, height: usize, channels: &[(&str, Vec<f32>)]) {
    let list = channels
        .iter()
        .map(|(name, samples)| AnyChannel::new(*name, FlatSamples::F32(samples.clone())))
        .collect();
    let layer = Layer::new(
        (width, height),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list),
    );
    Image::from_layer(layer)
        .write()
        .to_file(path)
        .expect("the folder is writable");
}

/// Returns the samples of one channel of an EXR file.
pub(crate) fn read_channel(path: &Path, name: &str) -> Vec<f32> {
    let plate = seidel_image_io::formats::exr::ExrImage::open(path).expect("readable");
    let id = plate
        .channels()
        .into_iter()
        .find(|c| c.name == name)
        .unwrap_or_else(|| panic!("{} has no channel {name}", path.display()))
        .id;
    plate.samples(id)
}

/// Writes an R, G, B, A and Z plate with point lights, an edge, and a plane from 1 m to 5 m.
pub(crate) fn write_plate(path: &Path, width: usize, height: usize) {
    let pixel = |f: &dyn Fn(usize, usize) -> f32| -> Vec<f32> {
        (0..width * height)
            .map(|i| f(i % width, i / width))
            .collect()
    };
    let colour = |shade: f32| {
        pixel(&move |x, y| {
            let light = if x % 17 == 3 && y % 13 == 5 {
                40.0
            } else {
                0.0
            };
            let edge = if x > width / 2 { 0.6 } else { 0.1 };
            shade * (light + edge)
        })
    };
    write_exr(
        path,
        width,
        height,
        &[
            ("R", colour(1.0)),
            ("G", colour(0.8)),
            ("B", colour(0.5)),
            ("A", pixel(&|x, _| if x > width / 4 { 1.0 } else { 0.5 })),
            (
                "Z",
                pixel(&|_, y| 1.0 / (1.0 - 0.8 * y as f32 / height as f32)),
            ),
        ],
    );
}

/// Every file below `folder`, sorted.
pub(crate) fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("readable").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
