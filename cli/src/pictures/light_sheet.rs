//! The lights of a photograph over its frame: kept ones with the ellipse of their second moments, others framed by reason.

use image::RgbImage;
use seidel_measure::{LightSet, MeasuredLight, Reason};

use super::canvas::{Area, Canvas, text_width};

/// Width of the picture of one photograph, px, about.
const WIDTH_PX: f64 = 1600.0;
/// Largest enlargement.
const MAX_SCALE: f64 = 4.0;
/// Enlargement of the ellipses, which are too small to judge otherwise.
const ELLIPSE_SCALE: f64 = 3.0;
/// Height of the legend, px.
const LEGEND_PX: u32 = 28;
/// Photographs that are drawn, from the first.
const MAX_PHOTOGRAPHS: usize = 8;

const BACKGROUND: [u8; 3] = [16, 16, 18];
const TEXT: [u8; 3] = [220, 220, 220];
const KEPT: [u8; 3] = [90, 220, 120];

/// Returns the colour of a reason.
fn colour(why: Reason) -> [u8; 3] {
    match why {
        Reason::Clipped => [255, 80, 80],
        Reason::Double => [255, 170, 60],
        Reason::HotPixel => [230, 90, 230],
        Reason::Border => [120, 140, 255],
        Reason::Faint => [140, 140, 140],
        Reason::UnlikeNeighbours => [255, 240, 90],
        Reason::Dust => [170, 120, 80],
        Reason::Moved => [80, 220, 230],
    }
}

/// Draws the lights of every photograph, one below the other.
pub fn light_sheet(set: &LightSet) -> RgbImage {
    let first = &set.photographs[0];
    let scale = (WIDTH_PX / first.width as f64).min(MAX_SCALE);
    let size = |v: usize| (v as f64 * scale).round().max(1.0) as u32;
    let (width, height) = (size(first.width), size(first.height));
    let count = set.photographs.len().min(MAX_PHOTOGRAPHS) as u32;
    let mut canvas = Canvas::new(width.max(640), (height + LEGEND_PX) * count, BACKGROUND);
    for photograph in 0..count {
        let top = photograph * (height + LEGEND_PX);
        let part = Part {
            set,
            photograph: photograph as usize,
            scale,
            top,
            size: (width, height),
        };
        part.draw(&mut canvas);
    }
    canvas.image
}

/// The picture of one photograph.
struct Part<'a> {
    set: &'a LightSet,
    photograph: usize,
    scale: f64,
    top: u32,
    size: (u32, u32),
}

impl Part<'_> {
    fn draw(&self, canvas: &mut Canvas) {
        self.draw_legend(canvas);
        self.draw_frame(canvas);
        for light in self.lights() {
            self.draw_tile(canvas, light);
            self.draw_ellipse(canvas, light);
        }
        for left_out in (self.set.left_out.iter()).filter(|l| l.photograph == self.photograph) {
            let half = (self.set.tile_px as f64 / 4.0).max(3.0);
            let area = self.area(left_out.x - half, left_out.y - half, 2.0 * half, 2.0 * half);
            canvas.outline(area, colour(left_out.why));
        }
    }

    fn lights(&self) -> impl Iterator<Item = &MeasuredLight> {
        let photograph = self.photograph;
        (self.set.lights.iter()).filter(move |light| light.photograph == photograph)
    }

    fn draw_legend(&self, canvas: &mut Canvas) {
        let mut left = 8;
        let name = &self.set.photographs[self.photograph].name;
        let kept = format!("{} kept", self.lights().count());
        let counts = Reason::ALL.map(|why| {
            let of = |l: &&seidel_measure::LeftOut| l.photograph == self.photograph && l.why == why;
            (why, self.set.left_out.iter().filter(of).count())
        });
        let mut items = vec![(name.clone(), TEXT), (kept, KEPT)];
        let occurring = counts.into_iter().filter(|(_, count)| *count > 0);
        items.extend(occurring.map(|(why, count)| (format!("{count} {why}"), colour(why))));
        for (text, colour) in items {
            let room = canvas.image.width().saturating_sub(left);
            canvas.text(left, self.top + 10, room, 1, colour, &text);
            left += text_width(&text, 1) + 20;
        }
    }

    /// Draws the photograph with a square root as tone curve, so that faint light shows too.
    fn draw_frame(&self, canvas: &mut Canvas) {
        let photo = &self.set.photographs[self.photograph];
        let plane = &photo.planes[photo.plane_of(photo.reference_channel())];
        let peaks = self.lights().filter_map(|light| {
            let profile = light.profiles[light.reference].as_ref()?;
            Some(profile.model.iter().copied().fold(0.0, f64::max))
        });
        let brightest = peaks.fold(1e-9, f64::max);
        for y in 0..self.size.1 {
            for x in 0..self.size.0 {
                let at =
                    |v: u32, count: usize| ((f64::from(v) / self.scale) as usize).min(count - 1);
                let index = at(y, photo.height) * photo.width + at(x, photo.width);
                let share = (f64::from(plane[index]) / brightest).clamp(0.0, 1.0).sqrt();
                let grey = (share * 255.0) as u8;
                canvas.set(i64::from(x), i64::from(y + self.top + LEGEND_PX), [grey; 3]);
            }
        }
    }

    /// Returns the pixels of the picture for a rectangle of the frame.
    fn area(&self, left: f64, top: f64, width: f64, height: f64) -> Area {
        let at = |v: f64, most: u32| (v * self.scale).clamp(0.0, f64::from(most - 1)) as u32;
        let (x, y) = (at(left, self.size.0), at(top, self.size.1));
        let (right, bottom) = (at(left + width, self.size.0), at(top + height, self.size.1));
        Area {
            left: x,
            top: y + self.top + LEGEND_PX,
            width: (right - x).max(1),
            height: (bottom - y).max(1),
        }
    }

    fn draw_tile(&self, canvas: &mut Canvas, light: &MeasuredLight) {
        let (left, top) = light.corner;
        let (width, height) = light.size;
        let area = self.area(left as f64, top as f64, width as f64, height as f64);
        canvas.outline(area, [50, 90, 60]);
    }

    fn draw_ellipse(&self, canvas: &mut Canvas, light: &MeasuredLight) {
        let Some(profile) = &light.profiles[light.reference] else {
            return;
        };
        let [xx, xy, yy] = profile.covariance;
        // Cholesky factor of the covariance.
        let a = xx.max(1e-6).sqrt();
        let b = xy / a;
        let c = (yy - b * b).max(0.0).sqrt();
        for step in 0..256 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 256.0).sin_cos();
            let x = profile.centroid[0] + ELLIPSE_SCALE * a * cos;
            let y = profile.centroid[1] + ELLIPSE_SCALE * (b * cos + c * sin);
            let (x, y) = ((x * self.scale) as i64, (y * self.scale) as i64);
            if y >= 0 && y < i64::from(self.size.1) {
                canvas.set(x, y + i64::from(self.top + LEGEND_PX), KEPT);
            }
        }
    }
}
