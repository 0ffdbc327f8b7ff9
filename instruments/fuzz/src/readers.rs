//! Calls of the readers. Each returns a value or an error that names the file and a remedy; a panic is a finding.

use std::ffi::OsStr;
use std::fs;
use std::hint::black_box;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use seidel_colour::{Alphas, Config, Source};
use seidel_image_io::animation::{Animation, Interpolation};
use seidel_image_io::description::Description;
use seidel_image_io::image_channel::ImageChannel;
use seidel_image_io::lens_profile;
use seidel_image_io::observation_set::{self, ReadOptions};
use seidel_image_io::photograph::{self, ColourFilter, PhotographOptions};
use seidel_image_io::plate::{Plate, PlateOptions};
use seidel_image_io::raster::RasterImage;
use seidel_image_io::samples::Encoding;
use seidel_image_io::sequence::{FramePattern, expand_frames, parse_frames};
use seidel_optics::profile::LensProfile;

/// Checks that an error names the file and a remedy.
fn check(error: &dyn std::fmt::Display, path: &Path) {
    let text = error.to_string();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    assert!(
        text.contains(&*name),
        "the error does not name {name}: {text}"
    );
    assert!(text.contains("; "), "the error has no remedy: {text}");
}

pub(crate) fn picture(path: &Path) {
    let is_exr = path.extension() == Some(OsStr::new("exr"));
    let options = PlateOptions {
        encoding: (!is_exr).then_some(Encoding::Srgb),
        ..PlateOptions::default()
    };
    let errors = [
        Plate::open(path, &options).err(),
        ImageChannel::read_depth(path, None).err(),
        Description::read(path).err(),
        RasterImage::open(path).err(),
    ];
    errors.iter().flatten().for_each(|error| check(error, path));
}

pub(crate) fn photograph(path: &Path) {
    let is_raw = path.extension() == Some(OsStr::new("dng"));
    let options = PhotographOptions {
        cfa: (!is_raw).then_some(ColourFilter::None),
        ..PhotographOptions::default()
    };
    match photograph::read(path, &options) {
        Ok(photograph) => {
            let pixels = photograph.width * photograph.height;
            assert!(photograph.planes.iter().all(|p| p.len() == pixels));
        }
        Err(error) => check(&error, path),
    }
}

pub(crate) fn profile(path: &Path) {
    match lens_profile::read(path) {
        Ok(profile) => {
            let json = profile.to_json();
            let back = LensProfile::from_json(&json).map(|back| back.to_json());
            assert_eq!(back.ok(), Some(json), "the profile differs after writing");
        }
        Err(error) => check(&error, path),
    }
}

pub(crate) fn manifest(path: &Path) {
    for skip_bad in [false, true] {
        let set = path.parent().unwrap_or(path);
        match observation_set::read(set, ReadOptions { skip_bad }) {
            Ok(loaded) => drop(black_box(loaded)),
            Err(error) => check(&error, path),
        }
    }
}

pub(crate) fn animation(path: &Path) {
    match Animation::open(path) {
        Ok(table) => {
            let names: Vec<String> = table.names().map(str::to_owned).collect();
            for name in &names {
                for frame in [i64::MIN, -1, 0, 1003, i64::MAX] {
                    black_box(table.value(name, frame, Interpolation::Linear));
                }
            }
        }
        Err(error) => check(&error, path),
    }
}

/// The content of the file as the word of a command line.
fn word(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

pub(crate) fn frames(path: &Path) {
    match parse_frames(&String::from_utf8_lossy(&word(path))) {
        Ok(frames) => assert!((1..=1_000_000).contains(&frames.len())),
        Err(error) => assert!(error.to_string().contains("--frames"), "{error}"),
    }
}

pub(crate) fn pattern(path: &Path) {
    let word = word(path);
    let pattern = Path::new(OsStr::from_bytes(&word));
    let parsed = FramePattern::parse(pattern);
    for frame in [i64::MIN, -1, 0, 1001, i64::MAX] {
        black_box(parsed.path(frame));
    }
    if let Err(error) = expand_frames(&[pattern, pattern], Some("1-3")) {
        assert!(error.to_string().contains("; "), "no remedy: {error}");
    }
}

pub(crate) fn config(path: &Path) {
    match Config::load(&Source::File(path.to_path_buf())) {
        Ok(config) => use_config(&config, path),
        Err(error) => check(&error, path),
    }
}

/// Converts colours from the first spaces of the config.
fn use_config(config: &Config, path: &Path) {
    let target = config
        .scene_linear()
        .map_or_else(|_| String::new(), |s| s.name);
    for space in config.spaces().iter().take(4) {
        match config.processor(&space.name, &target) {
            Ok(processor) => {
                let mut planes = vec![vec![0.1, -3.0, 0.999, 7.0, 0.0]; 3];
                let converted = processor.convert_planes(&mut planes, Alphas::Straight);
                let is_finite = planes.iter().flatten().all(|v| v.is_finite());
                let is_reported = converted.is_ok_and(|report| report.unrepresentable > 0);
                assert!(is_finite || is_reported, "finite colours became {planes:?}");
            }
            Err(error) => check(&error, path),
        }
    }
}

/// Reads a table through a config of its own.
pub(crate) fn table(path: &Path) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let folder = path.parent().unwrap_or(path).display();
    let yaml = format!(
        "ocio_profile_version: 2.1\nsearch_path: \"{folder}\"\nroles:\n  default: ACEScg\n  scene_linear: ACEScg\n\
         file_rules:\n  - !<Rule> {{name: Default, colorspace: default}}\n\
         displays:\n  sRGB:\n    - !<View> {{name: Raw, colorspace: ACEScg}}\n\
         colorspaces:\n  - !<ColorSpace>\n    name: Camera\n    \
         to_scene_reference: !<FileTransform> {{src: {name}}}\n  - !<ColorSpace>\n    name: ACEScg\n"
    );
    let source = Source::Text {
        name: "tables.ocio".to_owned(),
        yaml,
    };
    let config = Config::load(&source).unwrap_or_else(|e| panic!("{e}"));
    if let Err(error) = config.processor("Camera", "ACEScg") {
        check(&error, path);
    }
}
