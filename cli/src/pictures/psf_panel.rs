//! A panel of a PSF sheet: enlarged PSFs on a grid of field positions.

use rayon::prelude::*;
use seidel_core::{BlurField, Frame, ImagePoint, LocalBlur};
use seidel_optics::psf::{PsfModel, SampleGrid};

/// Share of a cell that the largest PSF may fill.
const FILL: f64 = 0.92;
/// Radius of a PSF for its size on the sheet, standard deviations.
const SHOWN_SIGMAS: f64 = 2.1;
/// Largest enlargement, sheet px per frame px.
const LARGEST_ENLARGEMENT: f64 = 60.0;
/// Variance added to drawn PSFs, sheet px², so that one far below a pixel still shows as a dot.
const DOT_VARIANCE_PX2: f64 = 0.5;

/// The grid and the size of all panels of a sheet.
#[derive(Debug, Clone, Copy)]
pub(super) struct PanelGrid {
    /// Columns of PSFs.
    pub(super) columns: u32,
    /// Rows of PSFs.
    pub(super) rows: u32,
    /// Width of the frame on the sheet, px.
    pub(super) width: u32,
    /// Height of the frame on the sheet, px.
    pub(super) height: u32,
}

impl PanelGrid {
    /// Returns the centres of the cells, in px of the panel and in the frame.
    fn places(&self, frame: &Frame) -> Vec<((f64, f64), ImagePoint)> {
        let (columns, rows) = (self.columns, self.rows);
        (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| {
                let u = (f64::from(column) + 0.5) / f64::from(columns);
                let v = (f64::from(row) + 0.5) / f64::from(rows);
                let at = ImagePoint::new(
                    u * f64::from(frame.width_px()),
                    v * f64::from(frame.height_px()),
                );
                ((u * f64::from(self.width), v * f64::from(self.height)), at)
            })
            .collect()
    }

    fn cell_px(&self) -> f64 {
        let width = f64::from(self.width) / f64::from(self.columns);
        let height = f64::from(self.height) / f64::from(self.rows);
        width.min(height)
    }

    /// Returns the scale of the frame, sheet px per frame px.
    pub(super) fn frame_scale(&self, frame: &Frame) -> f64 {
        f64::from(self.width) / f64::from(frame.width_px())
    }

    /// Returns the magnification of PSFs relative to the frame at which the largest of `channels` fills its
    /// cell, rounded down to a round number.
    pub(super) fn magnification(
        &self,
        field: &impl BlurField,
        channels: &[usize],
        vergence_per_m: f64,
    ) -> f64 {
        let frame = field.frame();
        let mut largest = 0.0_f64;
        for (_, at) in self.places(&frame) {
            let placed = placed_psfs(field, channels, at, vergence_per_m);
            for (blur, (dx, dy)) in placed {
                let moments = blur.moments;
                let variance = moments.trace() - moments.least_variance();
                let reach = SHOWN_SIGMAS * variance.max(0.0).sqrt() + dx.hypot(dy);
                largest = largest.max(reach);
            }
        }
        let fits = FILL * self.cell_px() / 2.0 / largest.max(1e-3);
        round_down(fits.min(LARGEST_ENLARGEMENT) / self.frame_scale(&frame))
    }

    /// Returns the light of the PSFs on the panel, a row-major plane per channel. The peak of each PSF over all
    /// `channels` is 1, and the PSF of each channel is displaced from the mean of the channels by lateral colour.
    pub(super) fn light(
        &self,
        field: &impl BlurField,
        model: &dyn PsfModel,
        channels: &[usize],
        vergence_per_m: f64,
        enlargement: f64,
    ) -> Vec<Vec<f32>> {
        let frame = field.frame();
        let pixels = self.width as usize * self.height as usize;
        let places = self.places(&frame);
        let drawn: Vec<Vec<(Patch, Vec<f64>)>> = places
            .par_iter()
            .map(|&(centre, at)| {
                let placed = placed_psfs(field, channels, at, vergence_per_m);
                placed
                    .into_iter()
                    .map(|(blur, (dx, dy))| {
                        let blur = as_dots(&blur.rescaled(enlargement));
                        let centroid = (centre.0 + dx * enlargement, centre.1 + dy * enlargement);
                        let patch = self.patch(centroid);
                        let mut samples = vec![0.0; patch.window.len()];
                        model.sample(&blur, &patch.window, &mut samples);
                        (patch, samples)
                    })
                    .collect()
            })
            .collect();
        let mut planes = vec![vec![0.0_f32; pixels]; channels.len()];
        for psf in &drawn {
            let peak = psf
                .iter()
                .flat_map(|(_, samples)| samples)
                .fold(f64::MIN_POSITIVE, |a, &b| a.max(b));
            for (plane, (patch, samples)) in planes.iter_mut().zip(psf) {
                let rows = samples.chunks_exact(patch.window.width.max(1));
                for (row, line) in rows.enumerate() {
                    let start = (patch.top + row) * self.width as usize + patch.left;
                    for (sum, sample) in plane[start..start + line.len()].iter_mut().zip(line) {
                        *sum += (sample / peak) as f32;
                    }
                }
            }
        }
        planes
    }

    /// Returns the part of the panel within 1.5 cells of `centroid`.
    fn patch(&self, centroid: (f64, f64)) -> Patch {
        let reach = 1.5 * self.cell_px();
        let span = |at: f64, size: u32| {
            let size = f64::from(size);
            let first = (at - reach).floor().clamp(0.0, size);
            let end = (at + reach).ceil().clamp(first, size);
            (first, (end - first) as usize)
        };
        let (left, width) = span(centroid.0, self.width);
        let (top, height) = span(centroid.1, self.height);
        Patch {
            left: left as usize,
            top: top as usize,
            window: SampleGrid {
                first_x_px: left + 0.5 - centroid.0,
                first_y_px: top + 0.5 - centroid.1,
                width,
                height,
            },
        }
    }
}

/// A part of the panel, and the window of the PSF that it shows.
struct Patch {
    left: usize,
    top: usize,
    window: SampleGrid,
}

/// Returns `blur`, in px of the sheet, widened by [`DOT_VARIANCE_PX2`].
fn as_dots(blur: &LocalBlur) -> LocalBlur {
    let blur = blur.with_least_variance(0.0);
    LocalBlur {
        moments: blur.moments.with_added_variance(DOT_VARIANCE_PX2),
        pupil: blur.pupil.map(|pupil| pupil.blurred_by(DOT_VARIANCE_PX2)),
        ..blur
    }
}

/// Returns the blur of each channel at `at`, px of the frame, with its displacement from the channels' mean.
fn placed_psfs(
    field: &impl BlurField,
    channels: &[usize],
    at: ImagePoint,
    vergence_per_m: f64,
) -> Vec<(LocalBlur, (f64, f64))> {
    let point = field.frame().field_point(at);
    let placed: Vec<_> = channels
        .iter()
        .map(|&channel| field.blur_at(channel, point, vergence_per_m))
        .collect();
    let count = placed.len().max(1) as f64;
    let mean = placed.iter().fold((0.0, 0.0), |sum, p| {
        (
            sum.0 + p.displacement_px.0 / count,
            sum.1 + p.displacement_px.1 / count,
        )
    });
    placed
        .into_iter()
        .map(|p| {
            let (dx, dy) = p.displacement_px;
            (p.blur, (dx - mean.0, dy - mean.1))
        })
        .collect()
}

/// Returns the largest of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten that does not exceed `value`.
pub(super) fn round_down(value: f64) -> f64 {
    let decade = 10.0_f64.powf(value.log10().floor());
    [8.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.5, 1.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|&step| step <= value * (1.0 + 1e-12))
        .unwrap_or(decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_rounded_down_to_round_numbers() {
        for (value, want) in [
            (1.0, 1.0),
            (1.7, 1.5),
            (9.9, 8.0),
            (0.034, 0.03),
            (60.0, 60.0),
        ] {
            assert!((round_down(value) - want).abs() < 1e-12 * want, "{value}");
        }
    }
}
