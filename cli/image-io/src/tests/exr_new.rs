//! New EXR files.

use std::fs;

use exr::prelude::*;

use crate::formats::exr::{NewChannel, write_channels};
use crate::windows::ImageWindows;

#[test]
fn new_files_have_ordered_scan_lines_and_the_same_bytes_each_time() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = |name: &str| folder.path().join(name);
    let (width, height) = (150, 90);
    let samples: Vec<f32> = (0..width * height)
        .map(|k| (k * 7919 % 1009) as f32 * 0.01)
        .collect();
    let channels = ["R", "Z"].map(|name| NewChannel {
        name,
        samples: &samples,
        half: name == "R",
    });
    let windows = ImageWindows::of_size(width, height);
    for name in ["a.exr", "b.exr"] {
        write_channels(&path(name), windows, &channels).expect("writes");
    }
    let bytes = |name: &str| fs::read(path(name)).expect("a file");
    assert_eq!(bytes("a.exr"), bytes("b.exr"));
    let image = read_all_flat_layers_from_file(path("a.exr")).expect("reads");
    let layer = &image.layer_data[0];
    assert_eq!(layer.encoding, Encoding::SMALL_LOSSLESS);
    let depth = &layer.channel_data.list[1];
    assert_eq!(depth.name.to_string(), "Z");
    assert_eq!(depth.sample_data, FlatSamples::F32(samples));
}
