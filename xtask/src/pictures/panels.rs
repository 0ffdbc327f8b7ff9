//! Panels with a label above each, in a grid.

use image::{Pixel, Rgb, RgbImage, Rgba, imageops};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

const BACKGROUND: Rgb<u8> = Rgb([18, 20, 25]);
const TEXT: Rgb<u8> = Rgb([226, 230, 236]);
/// Space between panels, px.
const GAP_PX: u32 = 12;
/// Height of the line of a label, px.
const LABEL_PX: u32 = 20;
const FONT: (FontWeight, RasterHeight) = (FontWeight::Regular, RasterHeight::Size16);
/// Width of a letter, px.
const LETTER_PX: u32 = get_raster_width(FONT.0, FONT.1) as u32;

/// An image with a label.
pub(super) struct Panel {
    pub(super) label: String,
    pub(super) image: RgbImage,
}

/// Lays `panels` out row by row, `columns` beside each other, each with its label above.
///
/// A label that is wider than its panel continues into the next panel's place, so labels must be short enough.
pub(super) fn grid(panels: &[Panel], columns: u32) -> Result<RgbImage, String> {
    let size = |of: fn(&RgbImage) -> u32| panels.iter().map(|p| of(&p.image)).max().unwrap_or(0);
    let (width, height) = (size(RgbImage::width), size(RgbImage::height));
    for panel in panels {
        let needed = LETTER_PX * panel.label.chars().count() as u32;
        if needed > width {
            return Err(format!(
                "the label \"{}\" is wider than its panel",
                panel.label
            ));
        }
    }
    let rows = (panels.len() as u32).div_ceil(columns);
    let step = (width + GAP_PX, height + LABEL_PX + GAP_PX);
    let mut sheet = RgbImage::from_pixel(
        columns * step.0 + GAP_PX,
        rows * step.1 + GAP_PX,
        BACKGROUND,
    );
    for (index, panel) in (0..).zip(panels) {
        let left = GAP_PX + index % columns * step.0;
        let top = GAP_PX + index / columns * step.1;
        text(&mut sheet, left, top, &panel.label);
        imageops::replace(
            &mut sheet,
            &panel.image,
            left.into(),
            (top + LABEL_PX).into(),
        );
    }
    Ok(sheet)
}

/// Writes `label` with its top-left corner at (`left`, `top`).
fn text(sheet: &mut RgbImage, left: u32, top: u32, label: &str) {
    for (place, character) in (0..).zip(label.chars()) {
        let glyph = get_raster(character, FONT.0, FONT.1);
        for (y, row) in (top..).zip(glyph.iter().flat_map(|glyph| glyph.rows())) {
            for (x, &cover) in (left + place * LETTER_PX..).zip(row) {
                let [r, g, b] = TEXT.0;
                let ink = Rgba([r, g, b, cover]);
                let mut pixel = sheet.get_pixel(x, y).to_rgba();
                pixel.blend(&ink);
                sheet.put_pixel(x, y, pixel.to_rgb());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(label: &str) -> Panel {
        Panel {
            label: label.to_owned(),
            image: RgbImage::from_pixel(64, 10, Rgb([255, 0, 0])),
        }
    }

    #[test]
    fn every_panel_has_its_label_above_it() {
        let sheet = grid(&[panel("one"), panel("two"), panel("three")], 2).expect("labels fit");
        let step = (64 + GAP_PX, 10 + LABEL_PX + GAP_PX);
        assert_eq!(
            sheet.dimensions(),
            (2 * step.0 + GAP_PX, 2 * step.1 + GAP_PX)
        );
        for (column, row) in [(0, 0), (1, 0), (0, 1)] {
            let (left, top) = (GAP_PX + column * step.0, GAP_PX + row * step.1);
            let mut line = (0..LABEL_PX).flat_map(|y| (0..LETTER_PX).map(move |x| (x, y)));
            let lettered = line.any(|(x, y)| *sheet.get_pixel(left + x, top + y) != BACKGROUND);
            assert!(lettered, "panel ({column}, {row})");
            assert_eq!(*sheet.get_pixel(left, top + LABEL_PX), Rgb([255, 0, 0]));
        }
    }

    #[test]
    fn labels_that_do_not_fit_are_refused() {
        assert!(grid(&[panel("ten letters")], 1).is_err());
    }
}
