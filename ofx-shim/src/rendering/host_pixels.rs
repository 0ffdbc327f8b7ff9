//! Pixels in messages, as the host counts them.

use crate::geometry::PixelMap;
use crate::host::Failure;
use seidel_core::Rectangle;

/// Words before the pixel in messages of the core.
const PIXEL: &str = "pixel (";

/// Returns `failure` with the pixels of its text in the host's coordinates. The core counts columns and rows from the top left
/// corner of the source, which covers `extent` in plate pixels.
pub(crate) fn in_host_pixels(mut failure: Failure, map: PixelMap, extent: Rectangle) -> Failure {
    if let Some(text) = translated(&failure.text, map, extent) {
        failure.text = text;
    }
    failure
}

/// Returns `text` with its first pixel translated; `None` if it names none.
fn translated(text: &str, map: PixelMap, extent: Rectangle) -> Option<String> {
    let at = text.find(PIXEL)? + PIXEL.len();
    let (inside, rest) = text[at..].split_once(')')?;
    let (column, row) = inside.split_once(", ")?;
    let plate = [column.parse::<i32>().ok()?, row.parse().ok()?];
    let (x, y) = map.frame_pixel(
        extent.x.checked_add(plate[0])?,
        extent.y.checked_add(plate[1])?,
    );
    Some(format!("{}x {x}, y {y}){rest}", &text[..at]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Field;
    use crate::sys::OfxRectI;

    #[test]
    fn rows_are_counted_from_below_and_columns_from_the_host_s_origin() {
        let format = OfxRectI {
            x1: 0,
            y1: 0,
            x2: 100,
            y2: 80,
        };
        let extent = |x, y| Rectangle {
            x,
            y,
            width: 10,
            height: 10,
        };
        let map = PixelMap::new(format, Field::Whole);
        let text = |extent| translated("channel G, pixel (3, 2): is NaN; scale it", map, extent);
        let expected = |x, y| Some(format!("channel G, pixel (x {x}, y {y}): is NaN; scale it"));
        assert_eq!(text(extent(0, 0)), expected(3, 77));
        assert_eq!(text(extent(-20, 70)), expected(-17, 7));
        for other in [
            "is NaN",
            "pixel (3",
            "pixel (a, b)",
            "pixel (2147483647, 0)",
        ] {
            assert_eq!(translated(other, map, extent(5, 0)), None, "{other}");
        }
    }
}
