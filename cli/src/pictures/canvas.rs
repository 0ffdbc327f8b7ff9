//! An 8-bit canvas with filled boxes and text in an 8 x 8 bitmap font, enlarged by integers to stay crisp.

use font8x8::{BASIC_FONTS, UnicodeFonts};
use image::{Rgb, RgbImage};

/// Side of one glyph at scale 1, px.
const GLYPH_PX: u32 = 8;

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

    /// Writes `text` with its top-left corner at (`left`, `top`) and glyphs enlarged `scale` times; text wider
    /// than `room` px or the image ends in two dots. Returns the width written, px.
    pub(super) fn text(
        &mut self,
        left: u32,
        top: u32,
        room: u32,
        scale: u32,
        colour: [u8; 3],
        text: &str,
    ) -> u32 {
        let room = room.min(self.image.width().saturating_sub(left));
        let fits = (room / (GLYPH_PX * scale)) as usize;
        let length = text.chars().count();
        let line: String = if length <= fits {
            text.to_owned()
        } else {
            self.shortened += 1;
            let kept = fits.saturating_sub(2);
            text.chars().take(kept).chain("..".chars()).collect()
        };
        for (place, character) in line.chars().take(fits).enumerate() {
            let rows = BASIC_FONTS
                .get(character)
                .or_else(|| BASIC_FONTS.get('?'))
                .unwrap_or_default();
            let x = left + place as u32 * GLYPH_PX * scale;
            for (row, bits) in rows.iter().enumerate() {
                for column in (0..GLYPH_PX).filter(|c| bits & (1 << c) != 0) {
                    let dot = Area {
                        left: x + column * scale,
                        top: top + row as u32 * scale,
                        width: scale,
                        height: scale,
                    };
                    self.fill(dot, colour);
                }
            }
        }
        text_width(&line, scale)
    }
}

/// Returns the width of `text` with glyphs enlarged `scale` times, px.
pub(super) fn text_width(text: &str, scale: u32) -> u32 {
    text.chars().count() as u32 * GLYPH_PX * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_is_shortened_and_counted() {
        let mut canvas = Canvas::new(64, 16, [0; 3]);
        assert_eq!(canvas.text(0, 0, 64, 1, [255; 3], "12345678"), 64);
        assert_eq!(canvas.shortened, 0);
        assert_eq!(canvas.text(8, 8, 64, 1, [255; 3], "12345678"), 56);
        assert_eq!(canvas.shortened, 1);
        assert!(canvas.image.pixels().any(|p| p.0 == [255; 3]));
    }
}
