//! An 8-bit canvas with filled boxes and text.

use image::{Pixel, Rgb, RgbImage, Rgba};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Height of a line of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TextSize {
    Small,
    Medium,
    Large,
}

impl TextSize {
    /// Returns `Medium` where `text` then fits into `room` px, else `Small`.
    pub(super) fn fitting(text: &str, room: u32) -> Self {
        if Self::Medium.width(text) <= room {
            Self::Medium
        } else {
            Self::Small
        }
    }

    /// Returns the width of `text`, px.
    pub(super) fn width(self, text: &str) -> u32 {
        text.chars().count() as u32 * self.glyph_width()
    }

    /// Returns the height of a capital letter, px.
    pub(super) fn capital(self) -> u32 {
        match self {
            Self::Small => 9,
            Self::Medium => 13,
            Self::Large => 17,
        }
    }

    /// Returns the raster of the font, and the number of its rows above a capital letter.
    fn raster(self) -> (RasterHeight, u32) {
        match self {
            Self::Small => (RasterHeight::Size16, 4),
            Self::Medium => (RasterHeight::Size24, 6),
            Self::Large => (RasterHeight::Size32, 8),
        }
    }

    fn glyph_width(self) -> u32 {
        get_raster_width(FontWeight::Regular, self.raster().0) as u32
    }
}

/// An axis-aligned box of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) left: u32,
    pub(super) top: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

/// An image being drawn, with a count of the labels that did not fit.
pub(super) struct Canvas {
    pub(super) image: RgbImage,
    /// Number of labels that were shortened to fit.
    pub(super) shortened: usize,
}

impl Canvas {
    pub(super) fn new(width: u32, height: u32, background: [u8; 3]) -> Self {
        Self {
            image: RgbImage::from_pixel(width, height, Rgb(background)),
            shortened: 0,
        }
    }

    /// Sets one pixel; does nothing outside the image.
    pub(super) fn set(&mut self, x: i64, y: i64, colour: [u8; 3]) {
        let inside = u32::try_from(x).ok().zip(u32::try_from(y).ok());
        if let Some((x, y)) = inside
            && let Some(pixel) = self.image.get_pixel_mut_checked(x, y)
        {
            *pixel = Rgb(colour);
        }
    }

    /// Fills `area`, clipped to the image.
    pub(super) fn fill(&mut self, area: Area, colour: [u8; 3]) {
        for y in area.top..area.top.saturating_add(area.height) {
            for x in area.left..area.left.saturating_add(area.width) {
                self.set(i64::from(x), i64::from(y), colour);
            }
        }
    }

    /// Draws a one-pixel outline just inside `area`.
    pub(super) fn outline(&mut self, area: Area, colour: [u8; 3]) {
        let Area {
            left,
            top,
            width,
            height,
        } = area;
        let edge = |l, t, w, h| Area {
            left: l,
            top: t,
            width: w,
            height: h,
        };
        self.fill(edge(left, top, width, 1), colour);
        self.fill(edge(left, top + height - 1, width, 1), colour);
        self.fill(edge(left, top, 1, height), colour);
        self.fill(edge(left + width - 1, top, 1, height), colour);
    }

    /// Writes `text`, its capitals with their top-left corner at (`left`, `top`); text wider than `room` px or the image ends in
    /// two dots. Returns the width written, px.
    pub(super) fn text(
        &mut self,
        left: u32,
        top: u32,
        room: u32,
        size: TextSize,
        colour: [u8; 3],
        text: &str,
    ) -> u32 {
        let room = room.min(self.image.width().saturating_sub(left));
        let fits = (room / size.glyph_width()) as usize;
        let line: String = if text.chars().count() <= fits {
            text.to_owned()
        } else {
            self.shortened += 1;
            let kept = fits.saturating_sub(2);
            text.chars().take(kept).chain("..".chars()).collect()
        };
        let (raster, above) = size.raster();
        for (place, character) in (0..).zip(line.chars().take(fits)) {
            let glyph = get_raster(character, FontWeight::Regular, raster)
                .or_else(|| get_raster('?', FontWeight::Regular, raster));
            let x = i64::from(left + place * size.glyph_width());
            let y = i64::from(top) - i64::from(above);
            for (y, row) in (y..).zip(glyph.iter().flat_map(|glyph| glyph.rows())) {
                for (x, &cover) in (x..).zip(row) {
                    self.mix(x, y, colour, cover);
                }
            }
        }
        size.width(&line)
    }

    /// Covers a pixel with `colour` by `cover` / 255; does nothing outside the image.
    fn mix(&mut self, x: i64, y: i64, [r, g, b]: [u8; 3], cover: u8) {
        let inside = u32::try_from(x).ok().zip(u32::try_from(y).ok());
        if let Some((x, y)) = inside
            && let Some(pixel) = self.image.get_pixel_mut_checked(x, y)
        {
            let mut mixed = pixel.to_rgba();
            mixed.blend(&Rgba([r, g, b, cover]));
            *pixel = mixed.to_rgb();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_is_shortened_and_counted() {
        let mut canvas = Canvas::new(56, 16, [0; 3]);
        let mut width = |left| canvas.text(left, 4, 56, TextSize::Small, [255; 3], "12345678");
        assert_eq!([width(0), width(7)], [56, 49]);
        assert_eq!(canvas.shortened, 1);
        assert!(canvas.image.pixels().any(|p| p.0 == [255; 3]));
    }
}
