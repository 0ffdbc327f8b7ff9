//! The exact renderer: every source pixel scatters its light with its own kernel. It is the reference for faster ones.
//!
//! Neighbours whose ray-traced kernels differ by less than can be seen share one
//! ([`PsfModel::alike`](seidel_optics::psf::PsfModel::alike)).

use crate::scatter::accumulators::{Band, Strip};
use crate::scatter::sources::{Source, Sources, runs};
use crate::{Plane, RenderWindow, Rendered, Renderer, Scene, VergencePass, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::KernelRows;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The exact renderer: scatters light pixel by pixel.
///
/// Bands of source rows accumulate their light separately and are added in order, so the result is the same to the bit
/// for any number of threads. Time grows with the number of pixels times the area of kernels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scatter;

/// Source rows per band: few enough for small plates to occupy many threads. Each band also holds the rows that its
/// kernels reach, so fewer would cost memory.
const BAND_ROWS: usize = 16;

/// Memory of the bands rendered together where kernels are large, bytes.
const WAVE_BYTES: usize = 1 << 30;

/// Kernels drawn between checks for cancellation: ray-traced ones take a millisecond each.
const CANCELLATION_INTERVAL: usize = 32;

impl Renderer for Scatter {
    fn id(&self) -> &'static str {
        "exact"
    }

    /// Rounding of 32-bit sums.
    fn overshoot(&self) -> f32 {
        1e-6
    }

    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        scene.check(planes)?;
        window.check(scene)?;
        let job = Job::new(scene, planes, progress);
        let mut total = vec![vec![0.0_f64; scene.pixel_count()]; planes.len()];
        let band_count = scene.height.div_ceil(BAND_ROWS);
        // Several bands per thread even out their costs. Their size is known once the first are done, and is at
        // most that of the plate.
        let threads = rayon::current_num_threads();
        let wave_of = |band_bytes: usize| (WAVE_BYTES / band_bytes.max(1)).clamp(1, 4 * threads);
        let mut wave = wave_of(planes.len() * scene.pixel_count() * size_of::<f64>());
        let mut first = 0;
        while first < band_count {
            let last = (first + wave).min(band_count);
            let bands = (first..last)
                .into_par_iter()
                .map(|band| job.band(band * BAND_ROWS))
                .collect::<Result<Vec<_>>>()?;
            for band in &bands {
                band.merge_into(&mut total);
            }
            wave = wave_of(bands.iter().map(Band::size_bytes).max().unwrap_or(0));
            first = last;
        }
        let narrow = |plane: Vec<f64>| plane.into_iter().map(|light| light as f32).collect();
        let planes = total.into_iter().map(narrow).collect();
        let layers = match scene.vergence {
            VergencePass::Constant(_) => 1,
            VergencePass::PerPixel(_) => 0,
        };
        Ok(Rendered::exact(window.cut_planes(scene, planes), layers))
    }
}

/// A render in progress.
struct Job<'a> {
    scene: &'a Scene<'a>,
    planes: &'a [Plane<'a>],
    progress: &'a (dyn Fn(f64) -> bool + Sync),
    sources: Sources<'a>,
    rows_done: AtomicUsize,
}

impl<'a> Job<'a> {
    fn new(
        scene: &'a Scene<'a>,
        planes: &'a [Plane<'a>],
        progress: &'a (dyn Fn(f64) -> bool + Sync),
    ) -> Self {
        Self {
            scene,
            planes,
            progress,
            sources: Sources::new(scene),
            rows_done: AtomicUsize::new(0),
        }
    }

    /// Reports the share done and checks for cancellation.
    fn report(&self) -> Result<()> {
        let done = self.rows_done.load(Ordering::Relaxed);
        if (self.progress)(done as f64 / self.scene.height as f64) {
            Ok(())
        } else {
            Err(cancelled())
        }
    }

    /// Scatters the band of source rows that starts at `first_row`.
    fn band(&self, first_row: usize) -> Result<Band> {
        let Scene { width, height, .. } = *self.scene;
        let mut band = Band::new(width, height, self.scene.edges, self.planes.len());
        let mut strip = Strip::new(width, self.planes.len());
        let mut kernel = KernelRows::default();
        // Sorted by channel: the kernels of a channel are scattered one after the other, so that the rows they share
        // stay in the cache.
        let mut sources: Vec<Vec<(usize, Source)>> =
            vec![Vec::new(); self.scene.lens.channel_count()];
        for row in first_row..(first_row + BAND_ROWS).min(height) {
            self.sources.of_row(self.planes, row, &mut sources)?;
            for (channel, sources) in sources.iter().enumerate() {
                for (count, (run, middle)) in runs(self.scene.model, sources).enumerate() {
                    if count % CANCELLATION_INTERVAL == CANCELLATION_INTERVAL - 1 {
                        self.report()?;
                    }
                    self.scene
                        .model
                        .draw_rows(&middle.blur, middle.shift_px, &mut kernel);
                    for &(column, _) in run {
                        strip.make_room(&kernel, column as i32);
                        for (index, plane) in self.planes.iter().enumerate() {
                            let light = f64::from(plane.samples[row * width + column]);
                            let gain = light * plane.weights[channel] / kernel.sum();
                            if gain != 0.0 {
                                strip.add(index, &kernel, column as i32, gain as f32);
                            }
                        }
                    }
                }
            }
            strip.empty_into(&mut band, row as i32);
            self.rows_done.fetch_add(1, Ordering::Relaxed);
            self.report()?;
        }
        Ok(band)
    }
}

#[cfg(test)]
mod tests;
