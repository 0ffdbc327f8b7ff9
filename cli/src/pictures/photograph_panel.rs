//! A photograph with a legend, over which measured lights, edges or blocks are drawn.

use image::RgbImage;
use seidel_measure::{Photograph, Reason};

use super::canvas::{Area, Canvas, TextSize};

/// Width of the picture of one photograph, px, about.
const WIDTH_PX: f64 = 1600.0;
/// Largest enlargement.
const MAX_SCALE: f64 = 4.0;
/// Height of the legend, px.
const LEGEND_PX: u32 = 28;
/// Photographs that are drawn, from the first.
const MAX_PHOTOGRAPHS: usize = 8;

const BACKGROUND: [u8; 3] = [16, 16, 18];
const TEXT: [u8; 3] = [220, 220, 220];
/// Colour of the marks of kept places.
pub(super) const KEPT: [u8; 3] = [90, 220, 120];

/// Returns the colour of a reason.
pub(super) fn colour(why: Reason) -> [u8; 3] {
    match why {
        Reason::Clipped => [255, 80, 80],
        Reason::Double => [255, 170, 60],
        Reason::HotPixel => [230, 90, 230],
        Reason::Border => [120, 140, 255],
        Reason::Faint | Reason::LowContrast => [140, 140, 140],
        Reason::UnlikeNeighbours => [255, 240, 90],
        Reason::Dust => [170, 120, 80],
        Reason::Slope => [120, 90, 160],
        Reason::DarkPixels => [60, 110, 110],
        Reason::Asked => [210, 210, 210],
        Reason::Moved => [80, 220, 230],
        Reason::NotAnEdge => [255, 130, 180],
        Reason::ShortEdge => [200, 220, 255],
        Reason::CurvedEdge => [80, 220, 230],
        Reason::Sharpened => [230, 90, 230],
        Reason::Undersampled => [255, 240, 90],
        Reason::Registration => [255, 120, 190],
    }
}

/// Draws photographs one below the other; `draw` adds what was measured in each, by its index.
pub(super) fn stack(photographs: &[Photograph], draw: impl Fn(usize, &mut Panel)) -> RgbImage {
    let first = &photographs[0];
    let scale = (WIDTH_PX / first.width as f64).min(MAX_SCALE);
    let size = |v: usize| (v as f64 * scale).round().max(1.0) as u32;
    let (width, height) = (size(first.width), size(first.height));
    let count = photographs.len().min(MAX_PHOTOGRAPHS) as u32;
    let mut canvas = Canvas::new(width.max(640), (height + LEGEND_PX) * count, BACKGROUND);
    for photograph in 0..count {
        let mut panel = Panel {
            canvas: &mut canvas,
            scale,
            top: photograph * (height + LEGEND_PX),
            size: (width, height),
        };
        draw(photograph as usize, &mut panel);
    }
    canvas.image
}

/// The place of one photograph in the picture.
pub(super) struct Panel<'a> {
    canvas: &'a mut Canvas,
    scale: f64,
    top: u32,
    size: (u32, u32),
}

impl Panel<'_> {
    /// Draws the name of the photograph, the number kept and the numbers left out by reason.
    pub(super) fn legend(
        &mut self,
        name: &str,
        kept: usize,
        left_out: impl Iterator<Item = Reason>,
    ) {
        let reasons: Vec<Reason> = left_out.collect();
        let counts = Reason::ALL.map(|why| (why, reasons.iter().filter(|r| **r == why).count()));
        let mut items = vec![(name.to_owned(), TEXT), (format!("{kept} kept"), KEPT)];
        let occurring = counts.into_iter().filter(|(_, count)| *count > 0);
        items.extend(occurring.map(|(why, count)| (format!("{count} {why}"), colour(why))));
        let mut left = 8;
        for (text, colour) in items {
            let room = self.canvas.image.width().saturating_sub(left);
            (self.canvas).text(left, self.top + 10, room, TextSize::Small, colour, &text);
            left += TextSize::Small.width(&text) + 20;
        }
    }

    /// Draws the reference channel with a square root as tone curve, so that faint light shows too. `white` is the level of
    /// white, counts.
    pub(super) fn photograph(&mut self, photo: &Photograph, white: f64) {
        let reference = photo.reference_channel();
        let plane = &photo.planes[photo.plane_of(reference)];
        for y in 0..self.size.1 {
            for x in 0..self.size.0 {
                let at =
                    |v: u32, count: usize| ((f64::from(v) / self.scale) as usize).min(count - 1);
                let index = at(y, photo.height) * photo.width + at(x, photo.width);
                let share = (f64::from(plane[index]) / white).clamp(0.0, 1.0).sqrt();
                let grey = (share * 255.0) as u8;
                let row = i64::from(y + self.top + LEGEND_PX);
                self.canvas.set(i64::from(x), row, [grey; 3]);
            }
        }
    }

    /// Outlines a rectangle of the frame.
    pub(super) fn outline(&mut self, [left, top]: [f64; 2], size: [f64; 2], colour: [u8; 3]) {
        let at = |v: f64, most: u32| (v * self.scale).clamp(0.0, f64::from(most - 1)) as u32;
        let (x, y) = (at(left, self.size.0), at(top, self.size.1));
        let (right, bottom) = (
            at(left + size[0], self.size.0),
            at(top + size[1], self.size.1),
        );
        let area = Area {
            left: x,
            top: y + self.top + LEGEND_PX,
            width: (right - x).max(1),
            height: (bottom - y).max(1),
        };
        self.canvas.outline(area, colour);
    }

    /// Draws a point of the frame.
    pub(super) fn point(&mut self, [x, y]: [f64; 2], colour: [u8; 3]) {
        let (x, y) = ((x * self.scale) as i64, (y * self.scale) as i64);
        if y >= 0 && y < i64::from(self.size.1) {
            (self.canvas).set(x, y + i64::from(self.top + LEGEND_PX), colour);
        }
    }

    /// Draws a line between two points of the frame.
    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], colour: [u8; 3]) {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]) * self.scale;
        let steps = (2.0 * length).ceil().max(1.0);
        for k in 0..=steps as usize {
            let share = k as f64 / steps;
            let at = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            self.point(at, colour);
        }
    }
}
