//! Predictions of a lens for a window: its PSFs, and the plate.

use super::estimate::{Expectation, Plans};
use super::patch::{Patch, Window};
use seidel_fourier::Complex;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::profile::PupilChannel;
use seidel_optics::psf::pupil::{Detail, PsfImage, TileGrid, Workspace, draw};

/// Change of position between the nodes of a window up to which PSFs are blended linearly, px.
const MOST_MOVE_PX: f64 = 0.3;
/// Fewest and most intervals between nodes along a side of a window.
const INTERVALS: (usize, usize) = (2, 4);

/// Positions that a plate gives its PSFs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Positions {
    /// Centroids lie where the lens puts them: a photograph, or a plate rendered with distortion.
    Lens,
    /// The mean of all channels lies on the source pixel: a plate rendered without distortion.
    Undistorted,
}

/// A lens as a pair of pictures sees it. Pixels of the sharp picture are ideal positions of its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct LensView<'a> {
    pub(super) channels: &'a [PupilChannel],
    pub(super) frame: Frame,
    pub(super) vergence: f64,
    pub(super) positions: Positions,
}

impl<'a> LensView<'a> {
    /// Returns the view at the distance of `window`.
    pub(super) fn at(&self, window: Window) -> LensView<'a> {
        LensView {
            vergence: window.vergence.unwrap_or(self.vergence),
            ..*self
        }
    }
}

impl LensView<'_> {
    /// Returns the displacement of the centroid of `channel` at point `ideal` of the frame, px.
    pub(super) fn displacement(&self, channel: usize, ideal: ImagePoint) -> [f64; 2] {
        let own = self.displacement_by_lens(channel, ideal);
        match self.positions {
            Positions::Lens => own,
            Positions::Undistorted => {
                let mean = self.mean_displacement(ideal);
                [own[0] - mean[0], own[1] - mean[1]]
            }
        }
    }

    /// Returns the mean displacement of all channels by the lens, px.
    pub(super) fn mean_displacement(&self, ideal: ImagePoint) -> [f64; 2] {
        let share = 1.0 / self.channels.len() as f64;
        let all = (0..self.channels.len()).map(|c| self.displacement_by_lens(c, ideal));
        all.fold([0.0; 2], |sum, d| {
            [sum[0] + share * d[0], sum[1] + share * d[1]]
        })
    }

    fn displacement_by_lens(&self, channel: usize, ideal: ImagePoint) -> [f64; 2] {
        let at = self.frame.field_point(ideal);
        let (x, y) =
            self.channels[channel].displacement_at(at, self.vergence, self.frame.half_width_px());
        [x, y]
    }

    /// Draws the PSF of `channel` for the pixel `at` of the sharp picture, of unit sum, in a tile whose middle lies
    /// `offset` from that pixel.
    pub(super) fn tile(
        &self,
        channel: usize,
        at: ImagePoint,
        offset: [f64; 2],
        side: usize,
        drawing: &mut Drawing,
    ) -> Vec<f64> {
        let ideal = self.frame.field_point(at);
        let pupil = self.channels[channel].pupil_at(ideal, self.vergence);
        let (moved, centroid) = (self.displacement(channel, at), pupil.centroid());
        let half = side as f64 / 2.0;
        let corner = [0, 1].map(|k| offset[k] - half - (moved[k] - centroid[k]));
        let grid = TileGrid {
            corner_px: corner,
            width: side,
            height: side,
        };
        draw(
            &pupil,
            &grid,
            &[],
            Detail::FIT,
            &mut drawing.space,
            &mut drawing.drawn,
        );
        let sum: f64 = drawing.drawn.light.iter().sum();
        let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        drawing.drawn.light.iter().map(|v| share * v).collect()
    }

    /// Returns the whole pixels by which the plate's window lies away from that of the sharp picture.
    pub(super) fn window_offset(&self, window: Window) -> [isize; 2] {
        let centre = window.centre;
        let share = 1.0 / self.channels.len() as f64;
        let offsets = (0..self.channels.len()).map(|c| self.displacement(c, centre));
        let mean = offsets.fold([0.0; 2], |sum, o| {
            [sum[0] + share * o[0], sum[1] + share * o[1]]
        });
        mean.map(|v| v.round() as isize)
    }

    /// Predicts the plate over `window`: the sharp picture convolved with PSFs that vary bilinearly between nodes.
    pub(super) fn expectation(
        &self,
        plans: &Plans,
        patch: &Patch,
        channel: usize,
        window: Window,
        offset: [isize; 2],
        drawing: &mut Drawing,
    ) -> Expectation {
        let (helix, side) = (&plans.window, plans.side);
        let offset = offset.map(|v| v as f64);
        let square = window.square();
        let intervals = self.intervals(channel, window);
        let step = square as f64 / intervals as f64;
        let corner = [window.left, window.top].map(|v| v as f64 - window.margin() as f64);
        let mut sum = vec![Complex::new(0.0, 0.0); helix.length / 2 + 1];
        for row in 0..=intervals {
            for column in 0..=intervals {
                let at = ImagePoint::new(
                    corner[0] + step * column as f64,
                    corner[1] + step * row as f64,
                );
                let tile = self.tile(channel, at, offset, side, drawing);
                let share = |index: usize, node: usize| {
                    let distance = ((index as f64 + 0.5) / step - node as f64).abs();
                    (1.0 - distance).max(0.0)
                };
                let part: Vec<f64> = patch
                    .sharp
                    .iter()
                    .enumerate()
                    .map(|(k, v)| v * share(k % square, column) * share(k / square, row))
                    .collect();
                let sharp = helix.spectrum(helix.laid_out(&part, square));
                let psf = helix.spectrum(helix.laid_out(&tile, side));
                for (sum, (s, p)) in sum.iter_mut().zip(sharp.iter().zip(&psf)) {
                    *sum += s * p;
                }
            }
        }
        let mut plate = helix.values(sum);
        plate.truncate(square * square);
        Expectation {
            tile: self.tile(channel, window.centre, offset, side, drawing),
            plate,
            least_variance: 0.0,
            sharp_variance: 0.0,
        }
    }

    /// Returns the number of intervals between nodes that positions in the window ask for.
    fn intervals(&self, channel: usize, window: Window) -> usize {
        let square = window.square() as f64;
        let (left, top) = (window.left as f64, window.top as f64);
        let at = |x: f64, y: f64| {
            self.displacement(
                channel,
                ImagePoint::new(left + x * window.side as f64, top + y * window.side as f64),
            )
        };
        let ends = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)];
        let range = |axis: usize| {
            let of = || ends.iter().map(|e| e[axis]);
            of().fold(f64::MIN, f64::max) - of().fold(f64::MAX, f64::min)
        };
        let change = range(0).max(range(1)) * square / window.side as f64;
        let wanted = (change / MOST_MOVE_PX).ceil() as usize;
        wanted.clamp(INTERVALS.0, INTERVALS.1)
    }
}

/// Working memory for drawing PSFs.
#[derive(Default)]
pub(super) struct Drawing {
    space: Workspace,
    drawn: PsfImage,
}
