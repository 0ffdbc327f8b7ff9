//! A reference for depth: a scene known in three dimensions, seen through many points of a thin lens's
//! aperture, and the same lens as renderers are given it.
//!
//! A surface point at vergence v that the middle of the aperture sees at pixel p is seen through the
//! aperture point u, in the unit disc, at p + R(v) u: a thin lens moves it by
//!
//!   R(v) = r s (v - 1 / d) / pitch,   s = f d / (d - f),   r = f / (2 N).
//!
//! Through one pinhole everything is sharp, and near hides far: the mean over pinholes is the picture,
//! with no approximation but their number. Planes in space have vergences linear in p, so that where a
//! pinhole's ray meets them is solved in closed form.

use rayon_free::rows;
use seidel_core::{BlurField, FieldPoint, Frame, LocalBlur};
use seidel_optics::DisplacedBlur;
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Wavefront};

/// A thin lens before a sensor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ThinLens {
    /// Focal length, mm.
    pub(crate) focal_mm: f64,
    /// Focal length over the aperture's diameter.
    pub(crate) f_number: f64,
    /// Vergence in focus, 1/m.
    pub(crate) focus_per_m: f64,
    /// Side of a pixel, mm.
    pub(crate) pitch_mm: f64,
}

impl ThinLens {
    /// Radius of the disc of a point at `vergence`, px; negative beyond focus.
    pub(crate) fn radius_px(&self, vergence: f64) -> f64 {
        let focus_per_mm = self.focus_per_m / 1000.0;
        let image_mm = self.focal_mm / (1.0 - self.focal_mm * focus_per_mm);
        let aperture_mm = self.focal_mm / (2.0 * self.f_number);
        aperture_mm * image_mm * (vergence - self.focus_per_m) / 1000.0 / self.pitch_mm
    }
}

/// The blur as renderers evaluate it: one channel, discs of constant size over the field.
impl BlurField for ThinLens {
    fn frame(&self) -> Frame {
        Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a valid frame")
    }

    fn channel_count(&self) -> usize {
        1
    }

    fn blur_at(&self, _: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
        let numbers = ReducedNumbers {
            alpha: self.radius_px(vergence),
            beta: 0.0,
            gamma: 0.0,
            delta: 0.0,
            phi: 0.0,
        };
        let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.0);
        DisplacedBlur {
            blur: LocalBlur::from_pupil(pupil, at.meridian()),
            displacement_px: (0.0, 0.0),
        }
    }
}

/// Size of all scenes, px.
pub(crate) const WIDTH: usize = 192;
/// See [`WIDTH`].
pub(crate) const HEIGHT: usize = 128;

/// A flat surface. Its position, outline and light are given in image coordinates as the centre of the aperture sees it.
#[derive(Clone, Copy)]
pub(crate) struct Card {
    /// Vergence at (0, 0), 1/m, and its derivatives along x and y, 1/m per px.
    pub(crate) vergence: [f64; 3],
    /// Tests whether the surface covers a point.
    pub(crate) covers: fn(f64, f64) -> bool,
    /// Light of a point of the surface.
    pub(crate) light: fn(f64, f64) -> f64,
}

impl Card {
    fn vergence_at(&self, x: f64, y: f64) -> f64 {
        self.vergence[0] + self.vergence[1] * x + self.vergence[2] * y
    }

    /// Returns the intersection of the card's plane with the ray that reaches (x, y) through the aperture point `u`.
    fn intersection(&self, lens: &ThinLens, x: f64, y: f64, u: [f64; 2]) -> (f64, f64) {
        // p + R(v(p)) u = (x, y) with R and v linear: R(v(p)) = (R at (x, y)) / (1 + slope along u).
        let per_vergence = lens.radius_px(1.0) - lens.radius_px(0.0);
        let slope = per_vergence * (self.vergence[1] * u[0] + self.vergence[2] * u[1]);
        let radius = lens.radius_px(self.vergence_at(x, y)) / (1.0 + slope);
        (x - radius * u[0], y - radius * u[1])
    }
}

/// Returns light and vergence of the nearest card on the ray that reaches (x, y) through the aperture point `u`.
fn trace(lens: &ThinLens, cards: &[Card], x: f64, y: f64, u: [f64; 2]) -> (f64, f64) {
    let mut nearest = (0.0, f64::NEG_INFINITY);
    for card in cards {
        let (px, py) = card.intersection(lens, x, y, u);
        let vergence = card.vergence_at(px, py);
        if vergence > nearest.1 && (card.covers)(px, py) {
            nearest = ((card.light)(px, py), vergence);
        }
    }
    nearest
}

/// Returns a point of Roberts' R2 sequence, which fills the unit square evenly.
fn spread(index: usize) -> (f64, f64) {
    let place = |step: f64| (0.5 + step * (index + 1) as f64).fract();
    (
        place(0.754_877_666_246_692_7),
        place(0.569_840_290_998_053_2),
    )
}

/// Renders the cards through `count` pinholes. Each ray meets its pixel at another place, for anti-aliasing.
pub(crate) fn reference(lens: &ThinLens, cards: &[Card], count: usize) -> Vec<f32> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let pinholes: Vec<_> = (0..count)
        .map(|k| {
            let radius = ((k as f64 + 0.5) / count as f64).sqrt();
            let (sin, cos) = (golden * k as f64).sin_cos();
            ([radius * cos, radius * sin], spread(k))
        })
        .collect();
    rows(|column, row| {
        let sum: f64 = pinholes
            .iter()
            .map(|(u, (dx, dy))| trace(lens, cards, column as f64 + dx, row as f64 + dy, *u).0)
            .sum();
        (sum / count as f64) as f32
    })
}

/// Renders the cards from the centre of the aperture: the plate with anti-aliased edges, and the depth pass, sampled at
/// pixel centres.
pub(crate) fn plate(lens: &ThinLens, cards: &[Card]) -> (Vec<f32>, Vec<f32>) {
    let middle = [0.0, 0.0];
    let light = rows(|column, row| {
        let sum: f64 = (0..64)
            .map(|k| {
                let (dx, dy) = (((k % 8) as f64 + 0.5) / 8.0, ((k / 8) as f64 + 0.5) / 8.0);
                trace(lens, cards, column as f64 + dx, row as f64 + dy, middle).0
            })
            .sum();
        (sum / 64.0) as f32
    });
    let vergence = rows(|column, row| {
        trace(lens, cards, column as f64 + 0.5, row as f64 + 0.5, middle).1 as f32
    });
    (light, vergence)
}

/// Renders the depth pass with anti-aliased edges: the mean distance over each pixel.
pub(crate) fn smooth_depth(lens: &ThinLens, cards: &[Card]) -> Vec<f32> {
    rows(|column, row| {
        let sum: f64 = (0..16)
            .map(|k| {
                let (dx, dy) = (((k % 4) as f64 + 0.5) / 4.0, ((k / 4) as f64 + 0.5) / 4.0);
                1.0 / trace(lens, cards, column as f64 + dx, row as f64 + dy, [0.0; 2]).1
            })
            .sum();
        (16.0 / sum) as f32
    })
}

mod rayon_free {
    //! A loop over all pixels, parallel over rows.

    use super::{HEIGHT, WIDTH};

    pub(super) fn rows(pixel: impl Fn(usize, usize) -> f32 + Sync) -> Vec<f32> {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let share = HEIGHT.div_ceil(threads);
        let mut out = vec![0.0; WIDTH * HEIGHT];
        std::thread::scope(|scope| {
            for (part, out) in out.chunks_mut(share * WIDTH).enumerate() {
                let pixel = &pixel;
                scope.spawn(move || {
                    for (k, out) in out.iter_mut().enumerate() {
                        *out = pixel(k % WIDTH, part * share + k / WIDTH);
                    }
                });
            }
        });
        out
    }
}
