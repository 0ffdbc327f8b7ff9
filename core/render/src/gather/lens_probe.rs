//! Queries of the lens by the fast renderer: how wide its blur is, how far it reaches and how fast it changes.

use super::image::Size;
use super::kernel_store::KernelStore;
use super::stencil::Stencil;
use super::tolerance::Tolerance;
use crate::scatter::{Source, Sources};
use crate::{RenderWindow, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::{KernelRows, PsfModel};

/// A lens at one vergence, for planes with some channel weights.
pub(super) struct LensProbe<'a> {
    pub(super) sources: &'a Sources<'a>,
    pub(super) model: &'a dyn PsfModel,
    /// Object vergence, 1/m.
    pub(super) vergence: f64,
    /// Distinct weights of lens channels; one stencil each.
    pub(super) mixes: &'a [Vec<f64>],
    pub(super) tolerance: &'a Tolerance,
    /// Kernels of earlier renders.
    pub(super) kernels: Option<&'a KernelStore>,
    /// Polled for cancellation.
    pub(super) progress: &'a (dyn Fn(f64) -> bool + Sync),
}

/// The places of a plate where the change of the blur is measured, as shares of its width and height.
pub(super) const PROBES: [(f64, f64); 13] = [
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

/// Steps along each side of a plate at which its blur is compared, and the ratio of the widest blur to the narrowest beyond which the
/// plate has a line in focus. Narrower blur than this standard deviation, px, counts as sharp.
const FOCUS_STEPS: usize = 16;
const FOCUS_RATIO: f64 = 2.0;
const SHARP_SIGMA: f64 = 0.5;

/// First tile side of the search, plate px.
const FIRST_TILE: f64 = 64.0;

/// Tile sides tried before the last error found is extrapolated.
const MAX_TRIES: usize = 4;

/// Largest tile side, plate px.
const MAX_TILE: usize = 256;

/// Longer side of a plate over the shorter one, from which its tiles are those of a plate with this ratio: a strip in tiles of its
/// own short side would have thousands, all on the finest level, however wide its blur.
const STRIP: usize = 16;

/// A pyramid level with the largest tile side that interpolates the blur at one place, plate px.
#[derive(Clone, Copy)]
struct ProbedSide {
    level: usize,
    side: usize,
}

impl LensProbe<'_> {
    /// Returns the number of lens channels.
    pub(super) fn channel_count(&self) -> usize {
        self.mixes.first().map_or(0, Vec::len)
    }

    /// Checks for cancellation; called before each expensive kernel.
    ///
    /// # Errors
    /// A cancelled render.
    pub(super) fn check_cancelled(&self) -> Result<()> {
        if (self.progress)(0.0) {
            Ok(())
        } else {
            Err(cancelled())
        }
    }

    /// Returns whether any plane uses a channel.
    pub(super) fn is_used(&self, channel: usize) -> bool {
        self.mixes.iter().any(|mix| mix[channel] != 0.0)
    }

    /// Writes the sources of all channels at a plate point to `found`.
    ///
    /// # Errors
    /// A lens that cannot be drawn there.
    pub(super) fn sources_at(&self, at: (f64, f64), found: &mut Vec<Option<Source>>) -> Result<()> {
        self.sources
            .at(at, self.vergence, |channel| self.is_used(channel), found)
    }

    /// Returns the smallest standard deviation of the blur at a plate point, px; 0 where it cannot be drawn.
    pub(super) fn min_sigma(&self, at: (f64, f64)) -> f64 {
        let mut found = Vec::new();
        if self.sources_at(at, &mut found).is_err() {
            return 0.0;
        }
        let variances = found
            .iter()
            .flatten()
            .map(|s| s.blur.moments.least_variance());
        variances.fold(f64::INFINITY, f64::min).max(0.0).sqrt()
    }

    /// Returns whether the blur in the middle of a plate of `size` is at least as wide as its short side.
    ///
    /// No light stands out there once it is blurred, so that highlights need no kernel each: drawing one would take more work than
    /// the plate.
    pub(super) fn is_wider_than(&self, size: Size) -> bool {
        let centre = (0.5 * size.width as f64, 0.5 * size.height as f64);
        self.min_sigma(centre) >= size.width.min(size.height) as f64
    }

    /// Returns whether a plate of `size` is in focus along a line, as through a tilted lens: tiles beside it must be small.
    pub(super) fn has_line_in_focus(&self, size: Size) -> bool {
        if !self.model.needs_rays() {
            return false;
        }
        let places = (0..=FOCUS_STEPS).flat_map(|y| (0..=FOCUS_STEPS).map(move |x| (x, y)));
        let sigma = |(x, y): (usize, usize)| {
            let share = |k: usize, size: usize| size as f64 * k as f64 / FOCUS_STEPS as f64;
            self.min_sigma((share(x, size.width), share(y, size.height)))
        };
        let sigmas: Vec<f64> = places
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(sigma)
            .collect();
        let least = sigmas.iter().copied().fold(f64::INFINITY, f64::min);
        let most = sigmas.iter().copied().fold(0.0, f64::max);
        most > FOCUS_RATIO * least.max(SHARP_SIGMA)
    }

    /// Returns how far light travels from its source on a plate of `size`, px: the largest reach on a grid, plus a
    /// margin.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn reach(&self, size: Size) -> Result<i32> {
        const STEPS: usize = 8;
        let share = |size: usize, k: usize| size as f64 * k as f64 / STEPS as f64;
        let of_row = |y: usize| {
            let (mut farthest, mut found) = (0.0_f64, Vec::new());
            for x in 0..=STEPS {
                let at = (share(size.width, x), share(size.height, y));
                farthest = farthest.max(self.reach_at(at, &mut found)?);
            }
            Ok(farthest)
        };
        let rows = (0..=STEPS).into_par_iter().map(of_row);
        let farthest = rows.try_reduce(|| 0.0, |a, b| Ok(a.max(b)))?;
        Ok((1.05 * farthest).ceil() as i32 + 2)
    }

    /// Returns how far light travels from a source at `at`, px.
    ///
    /// # Errors
    /// A lens that cannot be drawn there.
    pub(super) fn reach_at(&self, at: (f64, f64), found: &mut Vec<Option<Source>>) -> Result<f64> {
        self.sources_at(at, found)?;
        let mut farthest = 0.0_f64;
        for source in found.iter().flatten() {
            let bounds = self.model.kernel_bounds(&source.blur);
            let (x, y) = source.shift_px;
            farthest = [
                bounds.left_px - x,
                bounds.right_px + x,
                bounds.up_px - y,
                bounds.down_px + y,
            ]
            .into_iter()
            .fold(farthest, f64::max);
        }
        Ok(farthest)
    }

    /// Measures the largest tiles on a plate of `size` whose kernels, interpolated from their corners, are within the
    /// tolerance.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn probed_sides(&self, size: Size) -> Result<ProbedSides> {
        // Cubic interpolation needs four nodes.
        let short = size.width.min(size.height);
        let nodes_along = short.max(size.width.max(size.height) / STRIP);
        let widest = MAX_TILE.min(nodes_along / 3).max(1);
        let widest = widest as f64;
        let side_at = |probe: &(f64, f64), first: f64| {
            let at = (probe.0 * size.width as f64, probe.1 * size.height as f64);
            let found = self.side_at(at, size, first, widest)?;
            Ok(self.wider_than_plate(at, size, found))
        };
        let (first, rest) = (&PROBES[0], &PROBES[1..]);
        let first = side_at(first, widest.min(FIRST_TILE))?;
        let mut probed = rest
            .par_iter()
            .map(|probe| side_at(probe, (first.side as f64).max(1.0)))
            .collect::<Result<Vec<_>>>()?;
        probed.insert(0, first);
        Ok(ProbedSides { size, probed })
    }

    /// Searches the largest tile side around `at`, from `first` and up to `widest`, plate px, at the coarsest level
    /// that draws the blur there.
    fn side_at(&self, at: (f64, f64), size: Size, first: f64, widest: f64) -> Result<ProbedSide> {
        let sigma = self.min_sigma(at).max(1e-3);
        let level_for = |narrowest: f64| (sigma / narrowest).log2().floor().clamp(0.0, 16.0);
        let level = level_for(self.tolerance.min_sigma_for(self.model));
        // At a coarser step: edges that move a little between kernels matter little in a picture.
        let step = level_for(self.tolerance.min_sigma).exp2();
        let allowed = (self.tolerance).interpolation_error_at(level as u32, self.model);
        let (mut side, mut tries) = (first, 0);
        while side > 1.0 {
            let room = side / 2.0;
            let at = (
                inside(at.0, size.width, room),
                inside(at.1, size.height, room),
            );
            let error = self.interpolation_error(at, room, step)?;
            // The error grows with the square of the side, more slowly where it is large.
            let fitting = (side * (allowed / error.max(1e-12)).sqrt()).min(widest);
            let near = (0.5 * side..=2.0 * side).contains(&fitting);
            if near || error <= allowed || tries == MAX_TRIES {
                side = fitting.min(2.0 * side);
                break;
            }
            tries += 1;
            side = fitting.max(side / 4.0);
        }
        Ok(ProbedSide {
            level: level as usize,
            side: side.min(widest) as usize,
        })
    }

    /// Doubles the tile side `found` around `at` while its kernels are within the tolerance, where the blur is wider than a plate
    /// of `size`: the plate lies in one tile then, whose kernels a coarse level draws.
    fn wider_than_plate(&self, at: (f64, f64), size: Size, found: ProbedSide) -> ProbedSide {
        let sigma = self.min_sigma(at);
        if sigma < size.width.min(size.height) as f64 {
            return found;
        }
        let step = (sigma / self.tolerance.min_sigma).log2().floor();
        let step = step.clamp(0.0, 16.0).exp2();
        let allowed = (self.tolerance).interpolation_error_at(found.level as u32, self.model);
        let mut side = found.side.max(1);
        while 2 * side <= MAX_TILE {
            let next = 2 * side;
            // The nodes of the last tiles lie beyond the plate, where a lens may have no blur.
            let (right, bottom) = ((size.width + next) as f64, (size.height + next) as f64);
            let mut nodes = [(right, 0.0), (0.0, bottom), (right, bottom)].into_iter();
            if nodes.any(|node| self.sources_at(node, &mut Vec::new()).is_err()) {
                break;
            }
            let room = side as f64;
            let at = (
                inside(at.0, size.width, room),
                inside(at.1, size.height, room),
            );
            match self.interpolation_error(at, room, step) {
                Ok(error) if error <= allowed => side = next,
                _ => break,
            }
        }
        ProbedSide { side, ..found }
    }

    /// Returns the error of kernels at `at` interpolated from those `room` px away on both sides along x or y, as a
    /// share of their light. The worst of all used channels, sampled every `step` px.
    fn interpolation_error(&self, at: (f64, f64), room: f64, step: f64) -> Result<f64> {
        let here = self.kernels(at, step)?;
        let mut worst = 0.0_f64;
        for along in [(room, 0.0), (0.0, room)] {
            let before = self.kernels((at.0 - along.0, at.1 - along.1), step)?;
            let after = self.kernels((at.0 + along.0, at.1 + along.1), step)?;
            for ((here, before), after) in here.iter().zip(&before).zip(&after) {
                let apart = Stencil::weighted_sum(&[(here, 1.0), (before, -0.5), (after, -0.5)]);
                worst = worst.max(apart.magnitude());
            }
        }
        Ok(worst)
    }

    /// Draws the kernels of the used channels at `at`, sampled every `step` px.
    fn kernels(&self, at: (f64, f64), step: f64) -> Result<Vec<Stencil>> {
        let (mut found, mut rows) = (Vec::new(), KernelRows::default());
        self.sources_at(at, &mut found)?;
        let drawn = found.iter().flatten().map(|source| {
            let shift = (source.shift_px.0 / step, source.shift_px.1 / step);
            let blur = source.blur.rescaled(1.0 / step);
            self.model
                .draw_interpolated_rows(&blur, shift, None, &mut rows);
            Stencil::from_kernel(&rows, None)
        });
        Ok(drawn.collect())
    }
}

/// Returns the coordinate nearest to `at` that lies `room` px from both borders of a plate; the middle of one without such room.
fn inside(at: f64, size: usize, room: f64) -> f64 {
    let size = size as f64;
    if 2.0 * room < size {
        at.clamp(room, size - room)
    } else {
        0.5 * size
    }
}

/// The largest tile side at each of [`PROBES`] on a plate.
pub(super) struct ProbedSides {
    size: Size,
    probed: Vec<ProbedSide>,
}

/// Distance of probes that count for a window, as a share of the plate: none of it lies farther from all of them.
const NEAR: f64 = 0.3;

impl ProbedSides {
    /// Returns the sides of tiles in `window` of the plate.
    pub(super) fn in_window(&self, window: RenderWindow) -> TileSides {
        let near = |share: f64, size: usize, start: usize, length: usize| {
            let (at, room) = (share * size as f64, NEAR * size as f64);
            at >= start as f64 - room && at <= (start + length) as f64 + room
        };
        let probes = PROBES.iter().zip(&self.probed).filter(|((x, y), _)| {
            near(*x, self.size.width, window.column, window.width)
                && near(*y, self.size.height, window.row, window.height)
        });
        let probed: Vec<&ProbedSide> = probes.map(|(_, probed)| probed).collect();
        let coarsest = probed.iter().map(|probe| probe.level).max().unwrap_or(0);
        let sides = (0..=coarsest).map(|level| {
            let there = probed.iter().filter(|probe| probe.level >= level);
            there.map(|probe| probe.side).min().unwrap_or(MAX_TILE)
        });
        TileSides(sides.collect())
    }
}

/// The largest tile side of each pyramid level, plate px, finest first.
pub(super) struct TileSides(Vec<usize>);

impl TileSides {
    /// Returns the side at a level, plate px; levels beyond the last have its side.
    pub(super) fn at(&self, level: u32) -> usize {
        let last = self.0.len().saturating_sub(1);
        self.0
            .get(last.min(level as usize))
            .copied()
            .unwrap_or(MAX_TILE)
    }
}
