//! The exact renderer: every source pixel spreads its light with its own kernel. The reference that
//! faster renderers are held against. Kernels drawn ray by ray are shared by neighbours that differ
//! by less than can be seen ([`PsfModel::alike`](seidel_optics::psf::PsfModel::alike)).

use crate::scatter::accumulators::{Band, Strip};
use crate::scatter::sources::{Source, Sources, runs};
use crate::{Plane, RenderWindow, Rendered, Renderer, Scene, VergencePass, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::KernelRows;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Scatters light pixel by pixel. The result is the same to the bit for any number of threads: the
/// plate is cut into the same bands of source rows, each gathers its light apart, and bands are added
/// in order. The time taken grows with the pixels times the kernel's area.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scatter;

/// Source rows per band. A few, so that small plates occupy many threads; not fewer, since a band
/// keeps as many rows again as the kernels reach.
const BAND_ROWS: usize = 16;

/// Bands are rendered in waves of at most this much memory where kernels are large.
const WAVE_BYTES: usize = 1 << 30;

/// After so many kernels it is asked whether to go on: those drawn ray by ray take a millisecond each.
const ASKED_AFTER: usize = 32;

impl Renderer for Scatter {
    fn id(&self) -> &'static str {
        "exact"
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
        // Several bands a thread even out their costs. How large bands are is known when the first
        // are done; at most they are as large as the plate.
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

/// A render under way.
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

    /// Tells how much is done; stops where that is asked for.
    fn go_on(&self) -> Result<()> {
        let done = self.rows_done.load(Ordering::Relaxed);
        match (self.progress)(done as f64 / self.scene.height as f64) {
            true => Ok(()),
            false => Err(cancelled()),
        }
    }

    /// The light of the band of source rows that starts at `first_row`.
    fn band(&self, first_row: usize) -> Result<Band> {
        let Scene { width, height, .. } = *self.scene;
        let mut band = Band::new(width, height, self.scene.edges, self.planes.len());
        let mut strip = Strip::new(width, self.planes.len());
        let mut kernel = KernelRows::default();
        // Of each channel, so that a channel's kernels are scattered one after the other and the
        // rows they share stay in the cache.
        let mut sources: Vec<Vec<(usize, Source)>> =
            vec![Vec::new(); self.scene.lens.channel_count()];
        for row in first_row..(first_row + BAND_ROWS).min(height) {
            self.sources.of_row(self.planes, row, &mut sources)?;
            for (channel, sources) in sources.iter().enumerate() {
                for (count, (run, middle)) in runs(self.scene.model, sources).enumerate() {
                    if count % ASKED_AFTER == ASKED_AFTER - 1 {
                        self.go_on()?;
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
            self.go_on()?;
        }
        Ok(band)
    }
}

#[cfg(test)]
mod tests;
