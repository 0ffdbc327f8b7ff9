//! The lens as the fast renderer asks it: how wide its blur is, how far it reaches, how fast it changes.

use super::Tolerance;
use super::plan::LEAST_TILE;
use super::stencil::Stencil;
use crate::error::Result;
use crate::psf::{KernelRows, PsfModel};
use crate::render::sources::{Source, Sources};

/// A lens at one vergence, for planes with some channel weights.
pub(super) struct Optics<'a> {
    pub(super) sources: &'a Sources<'a>,
    pub(super) model: &'a dyn PsfModel,
    pub(super) vergence: f64,
    /// Distinct weights of lens channels; one stencil each.
    pub(super) mixes: &'a [Vec<f64>],
    pub(super) tolerance: &'a Tolerance,
}

/// Places of a plate where the lens is tried, as shares of its width and height.
const PROBES: [(f64, f64); 7] = [
    (0.5, 0.5),
    (0.0, 0.0),
    (1.0, 1.0),
    (0.0, 0.5),
    (0.5, 0.0),
    (0.25, 0.3),
    (0.8, 0.2),
];

/// Side of the tile for which errors are measured, px, and the largest side.
const TRIED_TILE: f64 = 64.0;
const LARGEST_TILE: usize = 128;

impl Optics<'_> {
    fn wanted(&self, channel: usize) -> bool {
        self.mixes.iter().any(|mix| mix[channel] != 0.0)
    }

    /// The sources of all channels at a plate point.
    pub(super) fn at(&self, at: (f64, f64), found: &mut Vec<Option<Source>>) -> Result<()> {
        self.sources
            .at(at, self.vergence, |channel| self.wanted(channel), found)
    }

    /// Least standard deviation of the blur at a plate point, px; none where it cannot be drawn.
    pub(super) fn least_sigma(&self, at: (f64, f64)) -> f64 {
        let mut found = Vec::new();
        if self.at(at, &mut found).is_err() {
            return 0.0;
        }
        let variances = found
            .iter()
            .flatten()
            .map(|s| s.blur.moments.least_variance());
        variances.fold(f64::INFINITY, f64::min).max(0.0).sqrt()
    }

    /// How far light goes from its source on a plate of `size`, px: what kernels over the plate reach.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn reach(&self, (width, height): (usize, usize)) -> Result<i32> {
        const STEPS: usize = 8;
        let (mut farthest, mut found) = (0.0_f64, Vec::new());
        for y in 0..=STEPS {
            for x in 0..=STEPS {
                let share = |size: usize, k: usize| size as f64 * k as f64 / STEPS as f64;
                self.at((share(width, x), share(height, y)), &mut found)?;
                for source in found.iter().flatten() {
                    let reach = self.model.reach_px(&source.blur);
                    let (x, y) = source.shift_px;
                    farthest = [
                        reach.left_px - x,
                        reach.right_px + x,
                        reach.up_px - y,
                        reach.down_px + y,
                    ]
                    .into_iter()
                    .fold(farthest, f64::max);
                }
            }
        }
        Ok((1.05 * farthest).ceil() as i32 + 2)
    }

    /// The largest side of a tile, px, in which kernels between corners are right to the tolerance.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn tile(&self, (width, height): (usize, usize)) -> Result<usize> {
        let mut worst = 0.0_f64;
        let size = (width as f64, height as f64);
        for (x, y) in PROBES {
            let room = TRIED_TILE / 2.0;
            let inside =
                |at: f64, size: f64| at.clamp(room.min(size / 2.0), (size - room).max(size / 2.0));
            let at = (inside(x * size.0, size.0), inside(y * size.1, size.1));
            for along in [(room, 0.0), (0.0, room)] {
                worst = worst.max(self.bend(at, along)?);
            }
        }
        // The error grows with the square of the side.
        let side = TRIED_TILE * (self.tolerance.between_corners / worst.max(1e-12)).sqrt();
        let mut tile = LARGEST_TILE;
        // Cubics between nodes need four of them.
        let room = width.min(height) / 3;
        while tile > LEAST_TILE && (tile as f64 > side || tile > room) {
            tile /= 2;
        }
        Ok(tile)
    }

    /// How far the kernel at `at` is from the mean of those `along` either way, share of its light.
    fn bend(&self, at: (f64, f64), along: (f64, f64)) -> Result<f64> {
        let least = self.least_sigma(at).max(1e-3);
        // As coarse as it will be drawn.
        let level = (least / self.tolerance.least_sigma_for(self.model))
            .log2()
            .floor()
            .max(0.0);
        let step = level.exp2();
        let here = self.kernel(at, step)?;
        let before = self.kernel((at.0 - along.0, at.1 - along.1), step)?;
        let after = self.kernel((at.0 + along.0, at.1 + along.1), step)?;
        let parts = [(&here, 1.0), (&before, -0.5), (&after, -0.5)];
        let apart = Stencil::mean_of(&parts);
        Ok(apart.weights.iter().map(|w| f64::from(w.abs())).sum())
    }

    /// The kernel of the first channel that is wanted.
    fn kernel(&self, at: (f64, f64), step: f64) -> Result<Stencil> {
        let (mut found, mut rows) = (Vec::new(), KernelRows::default());
        self.at(at, &mut found)?;
        let Some(source) = found.iter().flatten().next() else {
            return Ok(Stencil::default());
        };
        let shift = (source.shift_px.0 / step, source.shift_px.1 / step);
        self.model
            .draw_rows(&source.blur.rescaled(1.0 / step), shift, &mut rows);
        Ok(Stencil::of_kernel(&rows))
    }
}
