//! Image files: reads OpenEXR; writes OpenEXR and PNG.

use std::path::Path;

use exr::prelude::*;

use crate::picture::{Picture, Rect, Region};

/// An image file.
#[derive(Clone, Debug)]
pub struct ImageFile {
    /// Its samples, with y up from the bottom of the frame.
    pub picture: Picture,
    /// The display window, moved to (0, 0).
    pub frame: Region,
    /// Pixel aspect ratio.
    pub par: f64,
}

/// Channels to read by default: the first of these sets that the file has completely.
const COLOUR_SETS: [&[&str]; 4] = [&["R", "G", "B", "A"], &["R", "G", "B"], &["Y"], &["A"]];

/// Reads the colour of an OpenEXR file, or one channel.
///
/// # Errors
/// If the file cannot be read or lacks the channel.
pub fn read(path: &Path, channel: Option<&str>) -> std::result::Result<ImageFile, String> {
    let error = |problem: String| format!("{}: {problem}", path.display());
    let image = read_all_flat_layers_from_file(path).map_err(|e| error(e.to_string()))?;
    let layer =
        (image.layer_data.first()).ok_or_else(|| error("the file has no layer".to_owned()))?;
    let find = |name: &str| {
        let all = &layer.channel_data.list;
        all.iter()
            .find(|channel| channel.name.eq_case_insensitive(name))
    };
    let sets = match channel {
        Some(channel) => vec![vec![channel]],
        None => COLOUR_SETS.iter().map(|set| set.to_vec()).collect(),
    };
    let planes = (sets.iter())
        .find_map(|set| {
            set.iter()
                .map(|name| find(name))
                .collect::<Option<Vec<_>>>()
        })
        .ok_or_else(|| {
            let all: Vec<_> = (layer.channel_data.list.iter())
                .map(|channel| channel.name.to_string())
                .collect();
            let wanted = channel.map_or("colour".to_owned(), |name| format!("channel {name}"));
            error(format!("no {wanted} (it has {})", all.join(", ")))
        })?;
    let display = image.attributes.display_window;
    let (width, height) = (layer.size.0 as i32, layer.size.1 as i32);
    let left = layer.attributes.layer_position.0 - display.position.0;
    let top = layer.attributes.layer_position.1 - display.position.1;
    let frame_height = display.size.1 as i32;
    let bounds = Rect::new(
        left,
        frame_height - top - height,
        left + width,
        frame_height - top,
    );
    let picture = Picture::from_fn(bounds, planes.len(), |x, y, c| {
        let row = (bounds.y2 - 1 - y) as usize;
        let index = row * layer.size.0 + (x - left) as usize;
        planes[c].sample_data.value_by_flat_index(index).to_f32()
    });
    let par = f64::from(image.attributes.pixel_aspect);
    let frame = Rect::new(0, 0, display.size.0 as i32, frame_height);
    Ok(ImageFile {
        picture,
        frame: Region::from_pixels(&frame, (1.0, 1.0), par),
        par,
    })
}

/// Writes a picture as float OpenEXR or as 8-bit sRGB PNG, depending on the extension.
///
/// # Errors
/// If the extension is unknown, the picture is empty or the file cannot be written.
pub fn write(path: &Path, picture: &Picture) -> std::result::Result<(), String> {
    let error = |problem: String| format!("{}: {problem}", path.display());
    let (width, height) = (picture.bounds.width(), picture.bounds.height());
    if width == 0 || height == 0 {
        return Err(error("the picture has no pixels".to_owned()));
    }
    let sample = |column: usize, row: usize, c: usize| {
        let (x, y) = (column as i32, row as i32);
        let pixel = picture.pixel(picture.bounds.x1 + x, picture.bounds.y2 - 1 - y);
        pixel.get(c).copied().unwrap_or(0.0)
    };
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    match extension.to_ascii_lowercase().as_str() {
        "exr" => {
            let names: &[&str] = match picture.channels {
                1 => &["Y"],
                3 => COLOUR_SETS[1],
                _ => COLOUR_SETS[0],
            };
            let plane = |c: usize| {
                let pixels = 0..width * height;
                FlatSamples::F32(pixels.map(|k| sample(k % width, k / width, c)).collect())
            };
            let channels = (names.iter().enumerate())
                .map(|(c, name)| AnyChannel::new(Text::from(*name), plane(c)))
                .collect();
            let layer = Layer::new(
                (width, height),
                LayerAttributes::named(""),
                Encoding::SMALL_LOSSLESS,
                AnyChannels::sort(channels),
            );
            let written = Image::from_layer(layer).write().to_file(path);
            written.map_err(|e| error(e.to_string()))
        }
        "png" => {
            let encoded = image::RgbImage::from_fn(width as u32, height as u32, |x, y| {
                image::Rgb([0, 1, 2].map(|c| {
                    let c = if picture.channels < 3 { 0 } else { c };
                    encode_srgb(sample(x as usize, y as usize, c))
                }))
            });
            encoded.save(path).map_err(|e| error(e.to_string()))
        }
        _ => Err(error("the extension is neither .exr nor .png".to_owned())),
    }
}

/// Encodes a linear value as 8-bit sRGB (IEC 61966-2-1), clipped; NaN as 0.
fn encode_srgb(linear: f32) -> u8 {
    let linear = if linear.is_nan() {
        0.0
    } else {
        linear.clamp(0.0, 1.0)
    };
    let code = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * code).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_files_round_trip() {
        let folder = std::env::temp_dir().join(format!("ofx-host-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("p.exr");
        let written = Picture::from_fn(Rect::new(3, 2, 8, 6), 4, |x, y, c| {
            (100 * x + 10 * y) as f32 + c as f32
        });
        write(&path, &written).expect("written");
        let all = read(&path, None).expect("read");
        assert_eq!(all.picture.bounds, Rect::new(0, 0, 5, 4));
        assert_eq!(all.picture.samples, written.samples);
        let green = read(&path, Some("G")).expect("read");
        assert_eq!(green.picture.pixel(4, 0), [721.0]);
        let missing = read(&path, Some("Z")).expect_err("missing");
        assert!(
            missing.contains("p.exr") && missing.contains("A, B, G, R"),
            "{missing}"
        );
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn srgb_codes_are_clipped() {
        let codes = [f32::NAN, -1.0, 0.0, 0.18, 1.0, 9.0].map(encode_srgb);
        assert_eq!(codes, [0, 0, 0, 118, 255, 255]);
    }
}
