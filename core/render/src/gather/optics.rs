//! The lens as the fast renderer asks it: how wide its blur is, how far it reaches, how fast it changes.

use super::Tolerance;
use super::stencil::Stencil;
use crate::cancelled;
use crate::scatter::{Source, Sources};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::{KernelRows, PsfModel};

/// A lens at one vergence, for planes with some channel weights.
pub(super) struct Optics<'a> {
    pub(super) sources: &'a Sources<'a>,
    pub(super) model: &'a dyn PsfModel,
    pub(super) vergence: f64,
    /// Distinct weights of lens channels; one stencil each.
    pub(super) mixes: &'a [Vec<f64>],
    pub(super) tolerance: &'a Tolerance,
    /// Asked whether to go on.
    pub(super) progress: &'a (dyn Fn(f64) -> bool + Sync),
}

/// Places of a plate where the lens is tried, as shares of its width and height.
const PROBES: [(f64, f64); 13] = [
    (0.5, 0.5),
    (0.0, 0.0),
    (1.0, 1.0),
    (1.0, 0.0),
    (0.0, 1.0),
    (0.0, 0.5),
    (0.5, 0.0),
    (1.0, 0.5),
    (0.5, 1.0),
    (0.25, 0.3),
    (0.8, 0.2),
    (0.7, 0.75),
    (0.3, 0.85),
];

/// The side that is tried first, px.
const FIRST_TILE: f64 = 64.0;

/// How often another side is tried before the last error is trusted.
const MOST_TRIES: usize = 4;

/// The widest tile, px of the plate.
const WIDEST_TILE: usize = 256;

impl Optics<'_> {
    /// Channels of the lens.
    pub(super) fn channel_count(&self) -> usize {
        self.mixes.first().map_or(0, Vec::len)
    }

    /// Stops where `progress` says so: what is dear to draw asks before.
    pub(super) fn go_on(&self) -> Result<()> {
        match (self.progress)(0.0) {
            true => Ok(()),
            false => Err(cancelled()),
        }
    }

    /// Whether any plane is blurred by a channel.
    pub(super) fn wanted(&self, channel: usize) -> bool {
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
                let at = (share(width, x), share(height, y));
                farthest = farthest.max(self.reach_at(at, &mut found)?);
            }
        }
        Ok((1.05 * farthest).ceil() as i32 + 2)
    }

    /// How far light goes from a source at `at`, px.
    ///
    /// # Errors
    /// A lens that cannot be drawn there.
    pub(super) fn reach_at(&self, at: (f64, f64), found: &mut Vec<Option<Source>>) -> Result<f64> {
        self.at(at, found)?;
        let mut farthest = 0.0_f64;
        for source in found.iter().flatten() {
            let reach = self.model.kernel_bounds(&source.blur);
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
        Ok(farthest)
    }

    /// How wide tiles may be on a plate of `size` for kernels between their corners to be right to the
    /// tolerance.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn sides(&self, size: (usize, usize)) -> Result<Sides> {
        // Cubics between nodes need four of them.
        let widest = WIDEST_TILE.min(size.0.min(size.1) / 3).max(1);
        let widest = widest as f64;
        let side_at = |probe: &(f64, f64), first: f64| {
            let at = (probe.0 * size.0 as f64, probe.1 * size.1 as f64);
            self.side_at(at, size, (first, widest))
        };
        let (first, rest) = (&PROBES[0], &PROBES[1..]);
        let first = side_at(first, widest.min(FIRST_TILE))?;
        let mut tried = rest
            .par_iter()
            .map(|probe| side_at(probe, (first.1 as f64).max(1.0)))
            .collect::<Result<Vec<_>>>()?;
        tried.push(first);
        let coarsest = tried.iter().map(|(level, _)| *level).max().unwrap_or(0);
        let sides = (0..=coarsest).map(|level| {
            let there = tried.iter().filter(|(tried, _)| *tried >= level);
            there.map(|(_, side)| *side).min().unwrap_or(WIDEST_TILE)
        });
        Ok(Sides(sides.collect()))
    }

    /// The coarsest level at which the blur at `at` is drawn, and the widest tile about it, px; `first` is
    /// tried first, and none above `widest`.
    fn side_at(
        &self,
        at: (f64, f64),
        (width, height): (usize, usize),
        (first, widest): (f64, f64),
    ) -> Result<(usize, usize)> {
        let least = self.least_sigma(at).max(1e-3);
        let level_for = |narrowest: f64| (least / narrowest).log2().floor().clamp(0.0, 16.0);
        let level = level_for(self.tolerance.least_sigma_for(self.model));
        // Edges that move a little between kernels count little in a picture: they are looked at softly.
        let step = level_for(self.tolerance.least_sigma).exp2();
        let wanted = self.tolerance.between_corners_at(level as u32, self.model);
        let (mut side, mut tries) = (first, 0);
        while side > 1.0 {
            let room = side / 2.0;
            let inside = |at: f64, size: usize| at.clamp(room, size as f64 - room);
            let at = (inside(at.0, width), inside(at.1, height));
            let bend = self.bend(at, room, step)?;
            // The error grows with the square of the side, more slowly where it is large.
            let fitting = (side * (wanted / bend.max(1e-12)).sqrt()).min(widest);
            let near = (0.5 * side..=2.0 * side).contains(&fitting);
            if near || bend <= wanted || tries == MOST_TRIES {
                side = fitting.min(2.0 * side);
                break;
            }
            tries += 1;
            side = fitting.max(side / 4.0);
        }
        Ok((level as usize, side.min(widest) as usize))
    }

    /// How far kernels at `at` are from the mean of those `room` px away either way, along x or y, share of
    /// their light, drawn with `step` px to a pixel: the worst of all channels that are wanted.
    fn bend(&self, at: (f64, f64), room: f64, step: f64) -> Result<f64> {
        let here = self.kernels(at, step)?;
        let mut worst = 0.0_f64;
        for along in [(room, 0.0), (0.0, room)] {
            let before = self.kernels((at.0 - along.0, at.1 - along.1), step)?;
            let after = self.kernels((at.0 + along.0, at.1 + along.1), step)?;
            for ((here, before), after) in here.iter().zip(&before).zip(&after) {
                let apart = Stencil::mean_of(&[(here, 1.0), (before, -0.5), (after, -0.5)]);
                worst = worst.max(apart.weights.iter().map(|w| f64::from(w.abs())).sum());
            }
        }
        Ok(worst)
    }

    /// The kernels of the channels that are wanted.
    fn kernels(&self, at: (f64, f64), step: f64) -> Result<Vec<Stencil>> {
        let (mut found, mut rows) = (Vec::new(), KernelRows::default());
        self.at(at, &mut found)?;
        let drawn = found.iter().flatten().map(|source| {
            let shift = (source.shift_px.0 / step, source.shift_px.1 / step);
            self.model
                .draw_rows(&source.blur.rescaled(1.0 / step), shift, &mut rows);
            Stencil::of_kernel(&rows)
        });
        Ok(drawn.collect())
    }
}

/// The widest tile of each pyramid level, px of the plate, finest first.
pub(super) struct Sides(Vec<usize>);

impl Sides {
    /// At a level, px of the plate.
    pub(super) fn at(&self, level: u32) -> usize {
        let last = self.0.len().saturating_sub(1);
        self.0
            .get(last.min(level as usize))
            .copied()
            .unwrap_or(WIDEST_TILE)
    }
}
