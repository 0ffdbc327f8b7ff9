//! The exact renderer: every source pixel spreads its light with its own kernel. The reference that
//! faster renderers are held against. Kernels drawn ray by ray are shared by neighbours that differ
//! by less than can be seen ([`PsfModel::alike`](crate::psf::PsfModel::alike)).

use super::sheet::{Band, Strip};
use super::{Displacement, PlacedBlur, Plane, Renderer, Scene, stopped};
use crate::error::{Error, Result};
use crate::field::Frame;
use crate::psf::{KernelRows, LocalBlur};
use rayon::prelude::*;
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

/// Least variance of a displaced kernel, plate px². Undisplaced centroids lie on pixel centres;
/// displaced ones drift past them. A kernel much narrower than a pixel, seen only at pixel centres,
/// is all on one pixel until its centroid passes half way and then all on the next: where
/// displacement shrinks the picture two sources land on one pixel, where it stretches one pixel gets
/// none, and an even surface shows bright and dark lines. With variance v the light passes from pixel
/// to pixel at most 1 / (4 v) times as fast as the centroid moves, so the lines have at most 1.5
/// times the contrast of the displacement's own gradient (1 % of distortion: 1.5 %).
const DISPLACED_VARIANCE_PX2: f64 = 0.1;

/// Largest standard deviation and displacement that are drawn, plate px: beyond any use, and short of
/// filling the machine's memory with one kernel.
const LARGEST_SIGMA_PX: f64 = 512.0;
const LARGEST_DISPLACEMENT_PX: f64 = 4096.0;

impl Renderer for Scatter {
    fn id(&self) -> &'static str {
        "exact"
    }

    fn render(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        scene.check(planes)?;
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
        Ok(total.into_iter().map(narrow).collect())
    }
}

/// A render under way.
struct Job<'a> {
    scene: &'a Scene<'a>,
    planes: &'a [Plane<'a>],
    progress: &'a (dyn Fn(f64) -> bool + Sync),
    frame: Frame,
    channel_count: usize,
    rows_done: AtomicUsize,
}

/// A source pixel's light in one channel, ready to be drawn.
#[derive(Clone, Copy, PartialEq)]
struct Source {
    blur: LocalBlur,
    shift_px: (f64, f64),
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
            frame: scene.lens.frame(),
            channel_count: scene.lens.channel_count(),
            rows_done: AtomicUsize::new(0),
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
        let mut sources: Vec<Vec<(usize, Source)>> = vec![Vec::new(); self.channel_count];
        for row in first_row..(first_row + BAND_ROWS).min(height) {
            self.row_sources(row, &mut sources)?;
            for (channel, sources) in sources.iter().enumerate() {
                let model = self.scene.model;
                let mut rest = &sources[..];
                while let Some(&(_, first)) = rest.first() {
                    // Neighbours to which the lens does the same, or so nearly that the model says it
                    // cannot be seen, have one kernel: that in their middle.
                    let alike = |&&(_, source): &&(usize, Source)| {
                        model.alike(
                            (&first.blur, first.shift_px),
                            (&source.blur, source.shift_px),
                        )
                    };
                    let count = 1 + rest[1..].iter().take_while(alike).count();
                    let (run, others) = rest.split_at(count);
                    let middle = run[count / 2].1;
                    model.draw_rows(&middle.blur, middle.shift_px, &mut kernel);
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
                    rest = others;
                }
            }
            strip.empty_into(&mut band, row as i32);
            let done = self.rows_done.fetch_add(1, Ordering::Relaxed) + 1;
            if !(self.progress)(done as f64 / height as f64) {
                return Err(stopped());
            }
        }
        Ok(band)
    }

    /// The light to draw of plate row `row`: for each channel, columns and kernels.
    fn row_sources(&self, row: usize, sources: &mut [Vec<(usize, Source)>]) -> Result<()> {
        sources.iter_mut().for_each(Vec::clear);
        let width = self.scene.width;
        let mut placed = vec![None; self.channel_count];
        for column in 0..width {
            let index = row * width + column;
            let has_light = |channel: usize| {
                let mut planes = self.planes.iter();
                planes.any(|plane| plane.weights[channel] != 0.0 && plane.samples[index] != 0.0)
            };
            if !(0..self.channel_count).any(has_light) {
                continue;
            }
            let mean_needed = self.scene.displacement == Displacement::Lateral;
            for (channel, placed) in placed.iter_mut().enumerate() {
                *placed = if mean_needed || has_light(channel) {
                    Some(self.placed(channel, column, row)?)
                } else {
                    None
                };
            }
            let mean = mean_needed.then(|| mean_displacement(&placed));
            for (channel, (placed, sources)) in placed.iter().zip(&mut *sources).enumerate() {
                if let Some(placed) = placed
                    && has_light(channel)
                {
                    sources.push((column, self.source(placed, mean)));
                }
            }
        }
        Ok(())
    }

    /// What the lens does to a pixel in one channel, in plate pixels.
    fn placed(&self, channel: usize, column: usize, row: usize) -> Result<PlacedBlur> {
        let scene = self.scene;
        let scale = scene.map.scale;
        let at = self.frame.field_point(scene.map.frame_point(column, row));
        let vergence = scene.vergence_at(row * scene.width + column);
        let PlacedBlur {
            blur,
            displacement_px: (x, y),
        } = scene.lens.blur_at(channel, at, vergence);
        let placed = PlacedBlur {
            blur: blur.rescaled(scale),
            displacement_px: (x * scale, y * scale),
        };
        let moments = placed.blur.moments;
        let small = |moment: f64| moment.abs() <= LARGEST_SIGMA_PX * LARGEST_SIGMA_PX;
        let drawable = [moments.mu20, moments.mu11, moments.mu02]
            .into_iter()
            .all(small)
            && moments.to_array().iter().all(|moment| moment.is_finite());
        let near = |shift: f64| shift.abs() <= LARGEST_DISPLACEMENT_PX;
        if drawable && near(placed.displacement_px.0) && near(placed.displacement_px.1) {
            return Ok(placed);
        }
        Err(Error::new(
            format!("lens channel {channel} at plate pixel ({column}, {row})"),
            format!(
                "blurs with central moments {:?} (px², px³) and displaces by ({}, {}) px",
                moments.to_array(),
                placed.displacement_px.0,
                placed.displacement_px.1
            ),
            format!(
                "check lens and depth (vergence {vergence} m^-1); the largest blur drawn has a \
                 standard deviation of {LARGEST_SIGMA_PX} px, the largest displacement is \
                 {LARGEST_DISPLACEMENT_PX} px"
            ),
        ))
    }

    /// The kernel to draw, given the mean displacement of all channels where that is taken off.
    fn source(&self, placed: &PlacedBlur, mean: Option<(f64, f64)>) -> Source {
        let (x, y) = placed.displacement_px;
        let (shift_px, floor) = match (self.scene.displacement, mean) {
            (Displacement::None, _) => {
                return Source {
                    blur: placed.blur,
                    shift_px: (0.0, 0.0),
                };
            }
            (_, Some(mean)) => ((x - mean.0, y - mean.1), DISPLACED_VARIANCE_PX2),
            (_, None) => ((x, y), DISPLACED_VARIANCE_PX2),
        };
        Source {
            blur: placed.blur.with_least_variance(floor),
            shift_px,
        }
    }
}

fn mean_displacement(placed: &[Option<PlacedBlur>]) -> (f64, f64) {
    let (mut x, mut y) = (0.0, 0.0);
    for placed in placed.iter().flatten() {
        x += placed.displacement_px.0;
        y += placed.displacement_px.1;
    }
    let count = placed.len() as f64;
    (x / count, y / count)
}
