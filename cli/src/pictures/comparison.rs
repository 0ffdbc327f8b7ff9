//! Plates side by side, each with an enlarged crop below it.

use image::RgbImage;
use seidel_core::{Error, Result};

use super::canvas::{Area, Canvas, TextSize};
use super::display::{DisplayTransform, LinearRgb};

const BACKGROUND: [u8; 3] = [18, 20, 25];
const TEXT: [u8; 3] = [226, 230, 236];
const QUIET_TEXT: [u8; 3] = [146, 154, 168];
const MARK: [u8; 3] = [255, 255, 255];
const GAP_PX: u32 = 16;
const CAPTION_PX: u32 = 30;

/// A labelled plate.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The label above it.
    pub label: &'a str,
    /// The plate.
    pub plate: LinearRgb<'a>,
}

/// A part of a plate with the aspect of the plate, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crop {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// Number of columns.
    pub width: u32,
}

/// Draws the plates of `views` side by side, each `view_width_px` wide with its `crop` below it, enlarged by an
/// integer.
///
/// # Errors
/// No view, plates of different or invalid sizes, and a crop outside them.
pub fn comparison(
    views: &[View<'_>],
    crop: Crop,
    transform: &DisplayTransform,
    view_width_px: u32,
) -> Result<RgbImage> {
    let Some(first) = views.first() else {
        return Err(Error::new("comparison", "has no view", "give at least one"));
    };
    let (width, height) = first.plate.checked_size()?;
    let part = crop_area(crop, width, height)?;
    let view_width = view_width_px.max(64);
    let view_height = (view_width * height).div_ceil(width).max(1);
    let times = (view_width / part.width).max(1);
    let columns = views.len() as u32;
    let mut canvas = Canvas::new(
        columns * (view_width + GAP_PX) + GAP_PX,
        view_height + part.height * times + 2 * CAPTION_PX + 2 * GAP_PX,
        BACKGROUND,
    );
    for (column, view) in (0..).zip(views) {
        if view.plate.checked_size()? != (width, height) {
            return Err(Error::new(
                view.label,
                "differs in size from the first plate",
                "compare plates of one size",
            ));
        }
        let left = GAP_PX + column * (view_width + GAP_PX);
        canvas.text(left, 10, view_width, TextSize::Medium, TEXT, view.label);
        let area = Area {
            left,
            top: CAPTION_PX,
            width: view_width,
            height: view_height,
        };
        draw_resized(&mut canvas, area, &view.plate, transform);
        let scale = f64::from(view_width) / f64::from(width);
        let on_view = |v: u32| (f64::from(v) * scale).round() as u32;
        canvas.outline(
            Area {
                left: left + on_view(part.left),
                top: CAPTION_PX + on_view(part.top),
                width: on_view(part.width).clamp(2, view_width),
                height: on_view(part.height).clamp(2, view_height),
            },
            MARK,
        );
        let below = CAPTION_PX + view_height + GAP_PX / 2;
        let label = format!("{} x{times}", view.label);
        canvas.text(
            left,
            below + 4,
            view_width,
            TextSize::Medium,
            QUIET_TEXT,
            &label,
        );
        draw_enlarged(
            &mut canvas,
            left,
            below + CAPTION_PX,
            part,
            times,
            &view.plate,
            transform,
        );
    }
    Ok(canvas.image)
}

/// Returns the area of a crop of a plate of `plate_width` x `plate_height` px.
fn crop_area(crop: Crop, plate_width: u32, plate_height: u32) -> Result<Area> {
    let height = u64::from(crop.width) * u64::from(plate_height) / u64::from(plate_width);
    let height = height.max(1);
    let right = u64::from(crop.left) + u64::from(crop.width);
    let bottom = u64::from(crop.top) + height;
    if crop.width == 0 || right > u64::from(plate_width) || bottom > u64::from(plate_height) {
        return Err(Error::new(
            "crop",
            format!("{crop:?} is not inside {plate_width} x {plate_height} pixels"),
            "choose a part of the plate",
        ));
    }
    Ok(Area {
        left: crop.left,
        top: crop.top,
        width: crop.width,
        height: height as u32,
    })
}

/// Draws the plate resized to `area`: each pixel is the mean of the display codes that it covers.
fn draw_resized(
    canvas: &mut Canvas,
    area: Area,
    plate: &LinearRgb<'_>,
    transform: &DisplayTransform,
) {
    let span = |k: u32, to: u32, from: usize| {
        let first = k as usize * from / to as usize;
        let end = ((k as usize + 1) * from).div_ceil(to as usize);
        first..end.clamp(first + 1, from)
    };
    for y in 0..area.height {
        for x in 0..area.width {
            let mut sum = [0_u32; 3];
            let mut count = 0;
            for row in span(y, area.height, plate.height) {
                for column in span(x, area.width, plate.width) {
                    let index = row * plate.width + column;
                    // The mean of codes, as a mean of light would spread highlights over their neighbours.
                    let codes = transform.codes(plate.planes.map(|p| p[index]));
                    for (s, code) in sum.iter_mut().zip(codes) {
                        *s += u32::from(code);
                    }
                    count += 1;
                }
            }
            let mean = sum.map(|s| ((s + count / 2) / count) as u8);
            canvas.set(i64::from(area.left + x), i64::from(area.top + y), mean);
        }
    }
}

/// Draws `part` of the plate with its pixels enlarged `times` times.
fn draw_enlarged(
    canvas: &mut Canvas,
    left: u32,
    top: u32,
    part: Area,
    times: u32,
    plate: &LinearRgb<'_>,
    transform: &DisplayTransform,
) {
    for y in 0..part.height {
        for x in 0..part.width {
            let index = (part.top + y) as usize * plate.width + (part.left + x) as usize;
            let codes = transform.codes(plate.planes.map(|p| p[index]));
            let pixel = Area {
                left: left + x * times,
                top: top + y * times,
                width: times,
                height: times,
            };
            canvas.fill(pixel, codes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_drawn_side_by_side_above_their_crops() {
        let dark = vec![0.02_f32; 64 * 36];
        let bright = vec![0.7_f32; 64 * 36];
        let views = [("plate", &dark), ("blurred", &bright)].map(|(label, plane)| View {
            label,
            plate: LinearRgb {
                width: 64,
                height: 36,
                planes: [plane; 3],
            },
        });
        let crop = Crop {
            left: 48,
            top: 0,
            width: 16,
        };
        let transform = DisplayTransform::default();
        let image = comparison(&views, crop, &transform, 128).expect("drawable");
        assert_eq!(image.width(), 3 * GAP_PX + 2 * 128);
        let bright_code = transform.codes([0.7; 3]);
        let lit = image.pixels().filter(|p| p.0 == bright_code).count();
        // The plate at twice its size less the outline of the crop, and the crop at eight times.
        assert!(lit > 128 * 72 + 128 * 72 - 200, "{lit}");
        let outside = Crop { left: 60, ..crop };
        assert!(comparison(&views, outside, &transform, 128).is_err());
        assert!(comparison(&[], crop, &transform, 128).is_err());
    }
}
