//! A chart as pixels.

use image::{Rgb, RgbImage};
use seidel_measure::printed::{PlacedCells, Shape, Sheet};

use super::level;

/// Resolution of a paper chart as a picture, pixels per mm (about 300 dpi), and its largest side, px.
const PX_PER_MM: f64 = 12.0;
const LARGEST_PX: f64 = 12_000.0;
/// Pixels of a cell of a noise chart on paper, and the largest side of the picture, px.
const CELL_PX: usize = 4;
const LARGEST_CELLS_PX: usize = 8_000;
/// Samples along each axis of a pixel that a shape crosses.
const SAMPLES: usize = 4;

/// Returns the picture: of the pattern alone for noise on paper, else of the whole sheet.
pub fn picture(sheet: &Sheet) -> RgbImage {
    match (&sheet.cells, sheet.medium.pixel_mm) {
        (Some(placed), None) => pattern(placed),
        (Some(placed), Some(pixel_mm)) => pattern_on_screen(sheet, placed, pixel_mm),
        (None, pixel_mm) => {
            let longest = sheet.medium.width_mm.max(sheet.medium.height_mm);
            let scale = match pixel_mm {
                Some(pixel) => 1.0 / pixel,
                None => PX_PER_MM.min(LARGEST_PX / longest),
            };
            shapes(sheet, scale)
        }
    }
}

fn grey(share: f32) -> Rgb<u8> {
    Rgb([(share * 255.0).round() as u8; 3])
}

/// Returns the cells, each of the same number of pixels.
fn pattern(placed: &PlacedCells) -> RgbImage {
    let cells = &placed.cells;
    let longest = cells.columns.max(cells.rows);
    let side = (LARGEST_CELLS_PX / longest).clamp(1, CELL_PX);
    RgbImage::from_fn(
        (cells.columns * side) as u32,
        (cells.rows * side) as u32,
        |x, y| {
            let index = y as usize / side * cells.columns + x as usize / side;
            grey(f32::from(u8::from(cells.white[index])))
        },
    )
}

/// Returns the whole screen, with the pattern at its place.
fn pattern_on_screen(sheet: &Sheet, placed: &PlacedCells, pixel_mm: f64) -> RgbImage {
    let px = |mm: f64| (mm / pixel_mm).round() as u32;
    let (side, cells) = (px(placed.cell_mm).max(1), &placed.cells);
    let [left, top] = placed.origin_mm.map(px);
    RgbImage::from_fn(
        px(sheet.medium.width_mm),
        px(sheet.medium.height_mm),
        |x, y| {
            let column = x.checked_sub(left).map(|v| (v / side) as usize);
            let row = y.checked_sub(top).map(|v| (v / side) as usize);
            match (column, row) {
                (Some(c), Some(r)) if c < cells.columns && r < cells.rows => {
                    grey(f32::from(u8::from(cells.white[r * cells.columns + c])))
                }
                _ => grey(level(sheet.background)),
            }
        },
    )
}

/// Returns the sheet at `scale` pixels per mm, antialiased.
fn shapes(sheet: &Sheet, scale: f64) -> RgbImage {
    let px = |mm: f64| (mm * scale).round().max(1.0) as u32;
    let size = (px(sheet.medium.width_mm), px(sheet.medium.height_mm));
    let mut image = RgbImage::from_pixel(size.0, size.1, grey(level(sheet.background)));
    for shape in &sheet.shapes {
        let corners: Vec<[f64; 2]> = (shape.corners.iter())
            .map(|corner| corner.map(|v| v * scale))
            .collect();
        fill(&mut image, shape, &corners);
    }
    image
}

/// Fills a convex polygon, whose corners are given in pixels.
fn fill(image: &mut RgbImage, shape: &Shape, corners: &[[f64; 2]]) {
    let range = |axis: usize, most: u32| {
        let values = corners.iter().map(|c| c[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min).max(0.0) as u32;
        let high = values.fold(0.0, f64::max).ceil() as u32;
        low..high.min(most)
    };
    let rows = range(1, image.height());
    for y in rows {
        for x in range(0, image.width()) {
            let share = coverage(corners, [f64::from(x), f64::from(y)]);
            if share > 0.0 {
                let pixel = image.get_pixel_mut(x, y);
                let below = f32::from(pixel.0[0]) / 255.0;
                *pixel = grey(below + share * (level(shape.tone) - below));
            }
        }
    }
}

/// Returns the share of the pixel with top-left corner `pixel` inside a convex polygon of positive orientation.
fn coverage(corners: &[[f64; 2]], pixel: [f64; 2]) -> f32 {
    let depth = |x: f64, y: f64| {
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let inside = sides.map(|([ax, ay], [bx, by])| {
            let (dx, dy) = (bx - ax, by - ay);
            (dx * (y - ay) - dy * (x - ax)) / dx.hypot(dy)
        });
        inside.fold(f64::INFINITY, f64::min)
    };
    let middle = depth(pixel[0] + 0.5, pixel[1] + 0.5);
    if middle.abs() > 0.75 {
        return f32::from(u8::from(middle > 0.0));
    }
    let step = 1.0 / SAMPLES as f64;
    let inside = (0..SAMPLES * SAMPLES).filter(|k| {
        let at = |k: usize| (k as f64 + 0.5) * step;
        depth(pixel[0] + at(k % SAMPLES), pixel[1] + at(k / SAMPLES)) > 0.0
    });
    inside.count() as f32 / (SAMPLES * SAMPLES) as f32
}
