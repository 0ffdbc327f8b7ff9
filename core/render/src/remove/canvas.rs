//! The plate and what is about it: light from beyond its edges is sought as well, for it lands on the plate.

use crate::{RenderWindow, Scene, VergencePass};
use rayon::prelude::*;

/// Share of how far kernels reach that is added about a plate: what comes from farther is next to nothing.
const REACH_SHARE: f64 = 0.6;

/// A plate within a larger one, px.
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
    /// As much about the plate as its lens brings light from, but no more than half the plate.
    pub(super) fn of(scene: &Scene) -> Self {
        let (x, y) = scene.reach_px();
        let most = scene.width.max(scene.height) / 2;
        Self {
            margin_x: ((REACH_SHARE * x).ceil() as usize).min(most),
            margin_y: ((REACH_SHARE * y).ceil() as usize).min(most),
            plate: (scene.width, scene.height),
        }
    }

    /// Columns and rows of the whole canvas.
    pub fn size(&self) -> (usize, usize) {
        (
            self.plate.0 + 2 * self.margin_x,
            self.plate.1 + 2 * self.margin_y,
        )
    }

    /// `scene` of the whole canvas, at the vergences of `pass`, one a pixel of it, if that is given.
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

    /// The plate with itself mirrored about it.
    pub(super) fn mirrored(&self, plate: &[f32]) -> Vec<f32> {
        self.about(plate, |at, size| {
            let at = at.rem_euclid(2 * size as i32) as usize;
            at.min(2 * size - 1 - at)
        })
    }

    /// The plate with its nearest pixels about it.
    pub fn extended(&self, plate: &[f32]) -> Vec<f32> {
        self.about(plate, |at, size| at.clamp(0, size as i32 - 1) as usize)
    }

    fn about(&self, plate: &[f32], inside: impl Fn(i32, usize) -> usize + Sync) -> Vec<f32> {
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

    /// The plate's part of a canvas.
    pub fn cropped(&self, canvas: &[f32]) -> Vec<f32> {
        self.rows(canvas).flatten().copied().collect()
    }

    fn rows<'c>(&self, canvas: &'c [f32]) -> impl Iterator<Item = &'c [f32]> {
        let (left, width) = (self.margin_x, self.plate.0);
        canvas
            .chunks_exact(self.size().0)
            .skip(self.margin_y)
            .take(self.plate.1)
            .map(move |row| &row[left..left + width])
    }

    /// A canvas of `beyond`, and on the plate what `on_plate` makes of each index.
    pub(super) fn with_plate<T: Copy>(&self, beyond: T, on_plate: impl Fn(usize) -> T) -> Vec<T> {
        let (width, height) = self.size();
        let mut out = vec![beyond; width * height];
        let rows = out.chunks_exact_mut(width).skip(self.margin_y);
        for (row, out) in rows.take(self.plate.1).enumerate() {
            let out = &mut out[self.margin_x..][..self.plate.0];
            for (column, out) in out.iter_mut().enumerate() {
                *out = on_plate(row * self.plate.0 + column);
            }
        }
        out
    }
}

/// `scene` of a window of its plate; its vergence is still that of the whole.
pub(super) fn part_of<'a>(scene: &Scene<'a>, window: RenderWindow) -> Scene<'a> {
    Scene {
        width: window.width,
        height: window.height,
        map: scene.map.moved(window.column as f64, window.row as f64),
        ..*scene
    }
}
