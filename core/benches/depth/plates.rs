//! The plates of the bench, each with its depth pass.

use seidel_core::{Depth, DepthPass, Image, Plate, Result};

/// The size in which places and sizes of objects are given; other sizes are scaled.
const HD_WIDTH: usize = 1920;

/// The objects over the floor, in pixels of HD.
#[derive(Clone, Copy)]
pub(crate) struct Objects {
    pub(crate) leaves: usize,
    pub(crate) leaf_radius_px: [f32; 2],
    pub(crate) leaf_metres: [f32; 2],
    /// Metres of the floor at the top and at the bottom of the plate.
    pub(crate) floor_metres: [f32; 2],
    /// Left edge of a card of 320 x 600 px.
    pub(crate) card: Option<usize>,
    /// Value of 40 lamps of one pixel.
    pub(crate) lamps: Option<f32>,
}

/// The shot: a floor with leaves, lamps and a card that moves to the right by 8 px of HD a frame.
pub(crate) fn shot(frame: usize) -> Objects {
    Objects {
        leaves: 300,
        leaf_radius_px: [4.0, 16.0],
        leaf_metres: [1.0, 8.0],
        floor_metres: [12.0, 1.5],
        card: Some(300 + 8 * frame),
        lamps: Some(400.0),
    }
}

/// A floor alone.
pub(crate) const RAMP: Objects = Objects {
    leaves: 0,
    leaf_radius_px: [6.0, 24.0],
    leaf_metres: [1.2, 20.0],
    floor_metres: [20.0, 1.2],
    card: None,
    lamps: None,
};

/// The ramp behind 3000 leaves at all its depths.
pub(crate) const FOLIAGE: Objects = Objects {
    leaves: 3000,
    ..RAMP
};

/// Samples of light and depth.
struct Canvas {
    width: usize,
    height: usize,
    metres: Vec<f32>,
    tone: Vec<f32>,
}

impl Canvas {
    /// Fills a rectangle, its right and bottom edges excluded, wherever it is nearer than what is there.
    fn fill(&mut self, [left, top, right, bottom]: [f32; 4], metres: f32, tone: f32) {
        let within = |at: f32, size: usize| at.clamp(0.0, size as f32).ceil() as usize;
        for row in within(top, self.height)..within(bottom, self.height) {
            for column in within(left, self.width)..within(right, self.width) {
                let index = row * self.width + column;
                if metres < self.metres[index] {
                    (self.metres[index], self.tone[index]) = (metres, tone);
                }
            }
        }
    }
}

/// Draws a plate of `width` columns, 16 : 9.
pub(crate) fn plate(objects: &Objects, width: usize) -> Result<Plate> {
    let height = width * 9 / 16;
    let scale = width as f32 / HD_WIDTH as f32;
    let mut noise = Noise(7);
    let [far, near] = objects.floor_metres;
    let row_metres = |row: usize| far + (near - far) * row as f32 / height as f32;
    let mut canvas = Canvas {
        width,
        height,
        metres: (0..width * height).map(|k| row_metres(k / width)).collect(),
        tone: (0..width * height)
            .map(|k| 0.2 + 0.1 * (0.05 * (k % width) as f32 / scale).sin())
            .collect(),
    };
    if let Some(card) = objects.card {
        let sides = [card, 300, card + 320, 900].map(|at| at as f32 * scale);
        canvas.fill(sides, 1.2, 0.6);
    }
    for _ in 0..objects.leaves {
        let (x, y) = (noise.next() * width as f32, noise.next() * height as f32);
        let radius = scale * noise.between(objects.leaf_radius_px);
        let metres = noise.between(objects.leaf_metres);
        let sides = [x - radius, y - radius, x + radius, y + radius];
        canvas.fill(sides, metres, 0.1 + 0.05 * metres);
    }
    let mut samples = Vec::with_capacity(3 * width * height);
    for tone in &canvas.tone {
        for channel in 0..3 {
            samples.push(tone * (1.0 - 0.2 * channel as f32) + 0.02 * noise.next());
        }
    }
    if let Some(light) = objects.lamps {
        for k in 0..40 {
            let at = |px: usize| (px as f32 * scale) as usize;
            let (x, y) = (at(150 + 210 * (k % 8)), at(100 + 20 * (k / 8)));
            samples[3 * (y * width + x)..][..3].fill(light);
        }
    }
    let image = Image::from_interleaved(width, height, 3, &samples)?;
    Ok(Plate::new(image).with_depth(Depth::Pass(DepthPass::metres(canvas.metres))))
}

/// The same numbers in every run.
struct Noise(u32);

impl Noise {
    /// Returns the next number from 0 to 1.
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }

    fn between(&mut self, [low, high]: [f32; 2]) -> f32 {
        low + (high - low) * self.next()
    }
}
