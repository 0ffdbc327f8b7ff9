//! Pictures in files: OpenEXR in and out, PNG out to look at.

use std::path::Path;

use exr::prelude::*;

use crate::picture::{Picture, Rect, Region};

/// A picture of a file, and the frame it lies in.
#[derive(Clone, Debug)]
pub struct FromFile {
    /// Its samples, y up from the bottom of the frame.
    pub picture: Picture,
    /// The display window, from (0, 0).
    pub frame: Region,
    /// Width of a pixel over its height.
    pub par: f64,
}

/// Channels that are colour, where none is named; the first set that is there as a whole.
const COLOURS: [&[&str]; 4] = [&["R", "G", "B", "A"], &["R", "G", "B"], &["Y"], &["A"]];

/// Reads an OpenEXR file: its colour, or the one channel that is named.
///
/// # Errors
/// Names the file, and what it lacks.
pub fn read(path: &Path, channel: Option<&str>) -> std::result::Result<FromFile, String> {
    let of_file = |why: String| format!("{}: {why}", path.display());
    let image = read_all_flat_layers_from_file(path).map_err(|why| of_file(why.to_string()))?;
    let layer = (image.layer_data.first()).ok_or_else(|| of_file("has no layer".to_owned()))?;
    let named = |name: &str| {
        let all = &layer.channel_data.list;
        all.iter().find(|one| one.name.eq_case_insensitive(name))
    };
    let sets = match channel {
        Some(channel) => vec![vec![channel]],
        None => COLOURS.iter().map(|set| set.to_vec()).collect(),
    };
    let planes = (sets.iter())
        .find_map(|set| {
            set.iter()
                .map(|name| named(name))
                .collect::<Option<Vec<_>>>()
        })
        .ok_or_else(|| {
            let all: Vec<_> = (layer.channel_data.list.iter())
                .map(|one| one.name.to_string())
                .collect();
            let wanted = channel.map_or("colour".to_owned(), |name| format!("channel {name}"));
            of_file(format!("has no {wanted}; it has {}", all.join(", ")))
        })?;
    let display = image.attributes.display_window;
    let (width, height) = (layer.size.0 as i32, layer.size.1 as i32);
    let left = layer.attributes.layer_position.0 - display.position.0;
    let top = layer.attributes.layer_position.1 - display.position.1;
    let high = display.size.1 as i32;
    let bounds = Rect::new(left, high - top - height, left + width, high - top);
    let picture = Picture::made(bounds, planes.len(), |x, y, c| {
        let row = (bounds.y2 - 1 - y) as usize;
        let at = row * layer.size.0 + (x - left) as usize;
        planes[c].sample_data.value_by_flat_index(at).to_f32()
    });
    let par = f64::from(image.attributes.pixel_aspect);
    let frame = Rect::new(0, 0, display.size.0 as i32, high);
    Ok(FromFile {
        picture,
        frame: Region::of(&frame, (1.0, 1.0), par),
        par,
    })
}

/// Writes a picture as float OpenEXR, or as PNG for displays of sRGB, by the name's ending.
///
/// # Errors
/// Names the file.
pub fn write(path: &Path, picture: &Picture) -> std::result::Result<(), String> {
    let of_file = |why: String| format!("{}: {why}", path.display());
    let (width, height) = (picture.bounds.width(), picture.bounds.height());
    if width == 0 || height == 0 {
        return Err(of_file("the picture has no pixels".to_owned()));
    }
    let sample = |column: usize, row: usize, c: usize| {
        let (x, y) = (column as i32, row as i32);
        let pixel = picture.pixel(picture.bounds.x1 + x, picture.bounds.y2 - 1 - y);
        pixel.get(c).copied().unwrap_or(0.0)
    };
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    match ending.to_ascii_lowercase().as_str() {
        "exr" => {
            let names: &[&str] = match picture.channels {
                1 => &["Y"],
                3 => COLOURS[1],
                _ => COLOURS[0],
            };
            let plane = |c: usize| {
                let all = 0..width * height;
                FlatSamples::F32(all.map(|k| sample(k % width, k / width, c)).collect())
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
            written.map_err(|why| of_file(why.to_string()))
        }
        "png" => {
            let shown = image::RgbImage::from_fn(width as u32, height as u32, |x, y| {
                let of = |c: usize| {
                    let c = if picture.channels < 3 { 0 } else { c };
                    on_display(sample(x as usize, y as usize, c))
                };
                image::Rgb([of(0), of(1), of(2)])
            });
            shown.save(path).map_err(|why| of_file(why.to_string()))
        }
        _ => Err(of_file("is neither .exr nor .png".to_owned())),
    }
}

/// Light as a code of sRGB, IEC 61966-2-1.
fn on_display(light: f32) -> u8 {
    let light = if light.is_nan() {
        0.0
    } else {
        light.clamp(0.0, 1.0)
    };
    let code = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * code).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_the_right_way_up() {
        let folder = std::env::temp_dir().join(format!("ofx-host-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("p.exr");
        let made = Picture::made(Rect::new(3, 2, 8, 6), 4, |x, y, c| {
            (100 * x + 10 * y) as f32 + c as f32
        });
        write(&path, &made).expect("written");
        let all = read(&path, None).expect("read");
        assert_eq!(all.picture.bounds, Rect::new(0, 0, 5, 4));
        assert_eq!(all.picture.samples, made.samples);
        let green = read(&path, Some("G")).expect("read");
        assert_eq!(green.picture.pixel(4, 0), [721.0]);
        let missing = read(&path, Some("Z")).expect_err("is not there");
        assert!(
            missing.contains("p.exr") && missing.contains("A, B, G, R"),
            "{missing}"
        );
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn displays_get_codes() {
        let codes = [f32::NAN, -1.0, 0.0, 0.18, 1.0, 9.0].map(on_display);
        assert_eq!(codes, [0, 0, 0, 118, 255, 255]);
    }
}
