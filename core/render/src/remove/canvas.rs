//! The canvas: a plate with a margin around it, on which the sharp image is estimated.
//!
//! Light from beyond the plate's edges is blurred into the plate, so the sharp image has unknowns there as well.

use crate::{RenderWindow, Scene, VergencePass};
use rayon::prelude::*;

/// A plate within a larger image, px.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Canvas {
    /// Columns added on the left, and as many on the right.
    pub margin_x: usize,
    /// Rows added above, and as many below.
    pub margin_y: usize,
    /// Columns and rows of the plate.
    pub plate: (usize, usize),
}

impl Canvas {
    /// Returns the canvas of the plate of `scene`: as wide a margin as its lens brings light from, at most half the plate.
    pub(super) fn new(scene: &Scene) -> Self {
        Self::of_share(scene, 1.0)
    }

    /// Returns a canvas whose margin is a share of that.
    pub(super) fn of_share(scene: &Scene, share: f64) -> Self {
        let (x, y) = scene.reach_px();
        let most = scene.width.max(scene.height) / 2;
        Self {
            margin_x: ((share * x).ceil() as usize).min(most),
            margin_y: ((share * y).ceil() as usize).min(most),
            plate: (scene.width, scene.height),
        }
    }

    /// Returns the columns and rows of the whole canvas.
    pub fn size(&self) -> (usize, usize) {
        (
            self.plate.0 + 2 * self.margin_x,
            self.plate.1 + 2 * self.margin_y,
        )
    }

    /// Returns the number of pixels of the plate.
    pub(super) fn plate_pixel_count(&self) -> usize {
        self.plate.0 * self.plate.1
    }

    /// Returns `scene` with the canvas in place of its plate. A `pass` replaces the vergence: one value a pixel of the
    /// canvas.
    pub fn scene<'a>(&self, scene: &Scene<'a>, pass: Option<&'a [f32]>) -> Scene<'a> {
        let (width, height) = self.size();
        Scene {
            width,
            height,
            map: (scene.map).moved(-(self.margin_x as f64), -(self.margin_y as f64)),
            vergence: pass.map_or(scene.vergence, VergencePass::PerPixel),
            ..*scene
        }
    }

    /// Extends a plane of the plate to the canvas by mirroring it at its edges.
    pub(super) fn extend_by_mirroring(&self, plate: &[f32]) -> Vec<f32> {
        self.extend(plate, |at, size| {
            let at = at.rem_euclid(2 * size as i32) as usize;
            at.min(2 * size - 1 - at)
        })
    }

    /// Extends a plane of the plate to the canvas by replicating its edge pixels.
    pub fn extend_by_replication(&self, plate: &[f32]) -> Vec<f32> {
        self.extend(plate, |at, size| at.clamp(0, size as i32 - 1) as usize)
    }

    /// `inside` maps a column or row, relative to the plate, to one on a plate of that size.
    fn extend(&self, plate: &[f32], inside: impl Fn(i32, usize) -> usize + Sync) -> Vec<f32> {
        let (width, height) = self.size();
        let columns: Vec<usize> = (0..width)
            .map(|x| inside(x as i32 - self.margin_x as i32, self.plate.0))
            .collect();
        let mut out = vec![0.0; width * height];
        out.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            let row = inside(y as i32 - self.margin_y as i32, self.plate.1);
            let row = &plate[row * self.plate.0..][..self.plate.0];
            for (out, column) in out.iter_mut().zip(&columns) {
                *out = row[*column];
            }
        });
        out
    }

    /// Crops a plane of the canvas to the plate.
    pub fn crop(&self, canvas: &[f32]) -> Vec<f32> {
        let window = RenderWindow {
            column: self.margin_x,
            row: self.margin_y,
            width: self.plate.0,
            height: self.plate.1,
        };
        window.cut(self.size().0, canvas)
    }

    /// Returns a `plane` of another canvas about the same plate on this one: cropped, or with its edge pixels replicated.
    pub(super) fn fit(&self, other: &Self, plane: &[f32]) -> Vec<f32> {
        let ((width, height), own) = (other.size(), self.size().0);
        let inside = |at: usize, margin: usize, other: usize, size: usize| {
            (at + other).saturating_sub(margin).min(size - 1)
        };
        let count = own * self.size().1;
        let pixel = |k: usize| {
            let x = inside(k % own, self.margin_x, other.margin_x, width);
            let y = inside(k / own, self.margin_y, other.margin_y, height);
            plane[y * width + x]
        };
        (0..count).into_par_iter().map(pixel).collect()
    }

    /// Returns a plane of the canvas with `value(index)` at each pixel of the plate, and `margin` around it.
    pub(super) fn embed<T: Copy>(&self, margin: T, value: impl Fn(usize) -> T) -> Vec<T> {
        let (width, height) = self.size();
        let mut out = vec![margin; width * height];
        let rows = out.chunks_exact_mut(width).skip(self.margin_y);
        for (row, out) in rows.take(self.plate.1).enumerate() {
            let out = &mut out[self.margin_x..][..self.plate.0];
            for (column, out) in out.iter_mut().enumerate() {
                *out = value(row * self.plate.0 + column);
            }
        }
        out
    }
}

/// Returns `scene` with a window of its plate in place of the plate; its vergence is left as it is.
pub(super) fn window_scene<'a>(scene: &Scene<'a>, window: RenderWindow) -> Scene<'a> {
    Scene {
        width: window.width,
        height: window.height,
        map: scene.map.moved(window.column as f64, window.row as f64),
        ..*scene
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{HEIGHT, WIDTH, lens, scene};
    use super::*;

    #[test]
    fn margins_mirror_or_replicate_the_plate() {
        let lens = lens(1.0);
        let canvas = Canvas::new(&scene(&lens));
        assert!(
            canvas.margin_x > 3 && canvas.margin_x < WIDTH / 2,
            "{canvas:?}"
        );
        let plane: Vec<f32> = (0..WIDTH * HEIGHT).map(|k| k as f32).collect();
        let mirrored = canvas.extend_by_mirroring(&plane);
        assert!(canvas.crop(&mirrored) == plane);
        let row = canvas.margin_y * canvas.size().0;
        assert_eq!(mirrored[row + canvas.margin_x - 2], 1.0);
        let replicated = canvas.extend_by_replication(&plane);
        assert_eq!(replicated[row + canvas.margin_x - 2], 0.0);
    }
}
