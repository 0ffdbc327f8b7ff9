//! What was measured in photographs, over their frames: kept places with the ellipse of their second moments, others framed
//! by reason.

use image::RgbImage;
use seidel_measure::chart::ChartSet;
use seidel_measure::{LightSet, Photograph, Reason};

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
        Reason::Registration => [255, 120, 190],
        Reason::LowContrast => [180, 180, 110],
    }
}

/// A photograph and what was measured in it.
struct FramePicture<'a> {
    photo: &'a Photograph,
    /// Level that is drawn white, counts.
    brightest: f64,
    kept: Vec<Kept>,
    left_out: Vec<Omitted>,
    /// Side of the frames of places that were left out, px.
    omitted_px: f64,
}

/// A place that was kept, in frame pixels.
struct Kept {
    corner: [f64; 2],
    size: [f64; 2],
    /// Centroid, and covariance xx, xy, yy.
    ellipse: Option<([f64; 2], [f64; 3])>,
}

/// A place that was left out.
struct Omitted {
    at: [f64; 2],
    why: Reason,
}

/// Draws the lights of every photograph, one below the other.
pub fn light_sheet(set: &LightSet) -> RgbImage {
    let pictures = set.photographs.iter().enumerate().map(|(index, photo)| {
        let lights: Vec<_> = set
            .lights
            .iter()
            .filter(|l| l.photograph == index)
            .collect();
        let peaks = lights.iter().filter_map(|light| {
            let profile = light.profiles[light.reference].as_ref()?;
            Some(profile.model.iter().copied().fold(0.0, f64::max))
        });
        let kept = lights.iter().map(|light| Kept {
            corner: [light.corner.0 as f64, light.corner.1 as f64],
            size: [light.size.0 as f64, light.size.1 as f64],
            ellipse: (light.profiles[light.reference].as_ref()).map(|p| (p.centroid, p.covariance)),
        });
        let left_out = set.left_out.iter().filter(|l| l.photograph == index);
        FramePicture {
            photo,
            brightest: peaks.fold(1e-9, f64::max),
            kept: kept.collect(),
            left_out: left_out
                .map(|l| Omitted {
                    at: [l.x, l.y],
                    why: l.why,
                })
                .collect(),
            omitted_px: (set.tile_px as f64 / 2.0).max(6.0),
        }
    });
    sheet(&pictures.collect::<Vec<_>>())
}

/// Draws the blocks of every photograph of a chart.
pub fn chart_sheet(set: &ChartSet) -> RgbImage {
    let pictures = set
        .photographs
        .iter()
        .zip(&set.measurements)
        .map(|(photo, measured)| {
            let channel = photo.reference_channel();
            let plane = &photo.planes[photo.plane_of(channel)];
            let brightest = plane
                .iter()
                .copied()
                .filter(|v| *v < photo.white)
                .fold(1e-9, f32::max);
            let kept = measured.blocks.iter().map(|block| Kept {
                corner: [0, 1].map(|k| block.centre[k] as f64 + 0.5 - block.size[k] as f64 / 2.0),
                size: block.size.map(|v| v as f64),
                ellipse: Some((block.centroid(channel), block.covariance(channel))),
            });
            let left_out = measured.left_out.iter();
            FramePicture {
                photo,
                brightest: f64::from(brightest),
                kept: kept.collect(),
                left_out: left_out
                    .map(|b| Omitted {
                        at: b.at,
                        why: b.why,
                    })
                    .collect(),
                omitted_px: 2.0 * measured.side as f64,
            }
        });
    sheet(&pictures.collect::<Vec<_>>())
}

fn sheet(pictures: &[FramePicture]) -> RgbImage {
    let first = pictures[0].photo;
    let scale = (WIDTH_PX / first.width as f64).min(MAX_SCALE);
    let size = |v: usize| (v as f64 * scale).round().max(1.0) as u32;
    let (width, height) = (size(first.width), size(first.height));
    let count = pictures.len().min(MAX_PHOTOGRAPHS) as u32;
    let mut canvas = Canvas::new(width.max(640), (height + LEGEND_PX) * count, BACKGROUND);
    for (index, picture) in (0..count).zip(pictures) {
        let part = Part {
            picture,
            scale,
            top: index * (height + LEGEND_PX),
            size: (width, height),
        };
        part.draw(&mut canvas);
    }
    canvas.image
}

/// The picture of one photograph at its place.
struct Part<'a> {
    picture: &'a FramePicture<'a>,
    scale: f64,
    top: u32,
    size: (u32, u32),
}

impl Part<'_> {
    fn draw(&self, canvas: &mut Canvas) {
        self.draw_legend(canvas);
        self.draw_frame(canvas);
        for kept in &self.picture.kept {
            canvas.outline(self.area(kept.corner, kept.size), [50, 90, 60]);
            if let Some((centre, covariance)) = kept.ellipse {
                self.draw_ellipse(canvas, centre, covariance);
            }
        }
        let side = self.picture.omitted_px;
        for omitted in &self.picture.left_out {
            let corner = omitted.at.map(|v| v - side / 2.0);
            canvas.outline(self.area(corner, [side, side]), colour(omitted.why));
        }
    }

    fn draw_legend(&self, canvas: &mut Canvas) {
        let picture = self.picture;
        let kept = format!("{} kept", picture.kept.len());
        let mut items = vec![(picture.photo.name.clone(), TEXT), (kept, KEPT)];
        for why in Reason::ALL {
            let count = picture.left_out.iter().filter(|o| o.why == why).count();
            if count > 0 {
                items.push((format!("{count} {why}"), colour(why)));
            }
        }
        let mut left = 8;
        for (text, colour) in items {
            let room = canvas.image.width().saturating_sub(left);
            canvas.text(left, self.top + 10, room, 1, colour, &text);
            left += text_width(&text, 1) + 20;
        }
    }

    /// Draws the photograph with a square root as tone curve, so that faint light shows too.
    fn draw_frame(&self, canvas: &mut Canvas) {
        let photo = self.picture.photo;
        let plane = &photo.planes[photo.plane_of(photo.reference_channel())];
        for y in 0..self.size.1 {
            for x in 0..self.size.0 {
                let at =
                    |v: u32, count: usize| ((f64::from(v) / self.scale) as usize).min(count - 1);
                let index = at(y, photo.height) * photo.width + at(x, photo.width);
                let share = (f64::from(plane[index]) / self.picture.brightest).clamp(0.0, 1.0);
                let grey = (share.sqrt() * 255.0) as u8;
                canvas.set(i64::from(x), i64::from(y + self.top + LEGEND_PX), [grey; 3]);
            }
        }
    }

    /// Returns the pixels of the picture for a rectangle of the frame.
    fn area(&self, [left, top]: [f64; 2], [width, height]: [f64; 2]) -> Area {
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

    fn draw_ellipse(&self, canvas: &mut Canvas, centre: [f64; 2], [xx, xy, yy]: [f64; 3]) {
        // Cholesky factor of the covariance.
        let a = xx.max(1e-6).sqrt();
        let b = xy / a;
        let c = (yy - b * b).max(0.0).sqrt();
        for step in 0..256 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 256.0).sin_cos();
            let x = centre[0] + ELLIPSE_SCALE * a * cos;
            let y = centre[1] + ELLIPSE_SCALE * (b * cos + c * sin);
            let (x, y) = ((x * self.scale) as i64, (y * self.scale) as i64);
            if y >= 0 && y < i64::from(self.size.1) {
                canvas.set(x, y + i64::from(self.top + LEGEND_PX), KEPT);
            }
        }
    }
}
