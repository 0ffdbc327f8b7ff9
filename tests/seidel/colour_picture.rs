//! The image of docs/guide/colour.md: a log plate blurred correctly, and blurred as if its codes were light.

use std::path::{Path, PathBuf};

use seidel::pictures::comparison::{Crop, View, comparison};
use seidel::pictures::display::{DisplayTransform, LinearRgb};
use seidel_image_io::formats::png::write_rgb8;

use crate::support::{read_channel, succeeds};

const OWN: &str = "--ocio seidel";
const WIDTH: usize = 720;

fn planes(file: &Path) -> [Vec<f32>; 3] {
    ["R", "G", "B"].map(|name| read_channel(file, name))
}

#[test]
#[ignore = "writes the picture that SEIDEL_COLOUR_PICTURE names"]
fn write_image_for_the_docs() {
    let picture = std::env::var_os("SEIDEL_COLOUR_PICTURE").map(PathBuf::from);
    let picture = picture.expect("SEIDEL_COLOUR_PICTURE names a .png");
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let lens = "--lens @demo/lens.json";
    for line in [
        format!("demo @demo --width {WIDTH}"),
        format!("lut @demo/plate.exr -o @log.exr {OWN} --in-space lin_rec709 --out-space logc4"),
        format!("apply @log.exr -o @right.exr {lens} {OWN} --in-space logc4"),
        format!("apply @log.exr -o @wrong.exr {lens}"),
        format!("lut @right.exr -o @right-light.exr {OWN} --in-space logc4 --out-space lin_rec709"),
        format!("lut @wrong.exr -o @wrong-light.exr {OWN} --in-space logc4 --out-space lin_rec709"),
    ] {
        succeeds(folder, &line);
    }
    let light = ["right-light.exr", "wrong-light.exr"].map(|file| planes(&folder.join(file)));
    let labels = ["--in-space logc4", "codes taken for light"];
    let views: Vec<View> = labels
        .iter()
        .zip(&light)
        .map(|(label, [r, g, b])| View {
            label,
            plate: LinearRgb {
                width: WIDTH,
                height: WIDTH * 9 / 16,
                planes: [r, g, b],
            },
        })
        .collect();
    let part = WIDTH as u32 / 4;
    let crop = Crop {
        left: WIDTH as u32 - part,
        top: 0,
        width: part,
    };
    let drawn = comparison(&views, crop, &DisplayTransform::default(), 480);
    write_rgb8(&picture, &drawn.expect("drawn")).expect("writable");
}
