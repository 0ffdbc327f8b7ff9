//! The exact render at a few pixels of a plate: the reference on plates too large to render exactly.

use crate::scatter::sources::{Source, Sources, runs};
use crate::{Edges, Plane, Scene, VergencePass};
use rayon::prelude::*;
use seidel_optics::error::{Error, Result};
use seidel_optics::psf::{KernelRows, SampleGrid};
use std::ops::RangeInclusive;

/// Returns the light that [`Scatter`](crate::Scatter) renders at `pixels` (column, row) of `plane`, in their order.
///
/// All source pixels that reach a chosen pixel contribute. Kernels whose samples sum to one anyway are sampled at the
/// chosen pixels only ([`PsfModel::sums_to_one`](seidel_optics::psf::PsfModel::sums_to_one)); others are drawn.
///
/// With `cell_px` 1 kernels are those of the exact renderer. Ray-tracing a large kernel takes milliseconds. With a
/// larger `cell_px`, ray-traced models share the kernel at the middle of each cell of `cell_px` x `cell_px` source
/// pixels; other models ignore it. The error falls by 12 dB for each halving of the cell, which is also how to measure
/// it.
///
/// The result is the same to the bit for any number of threads.
///
/// # Errors
/// Those of [`Scene::check`], a pixel outside the plate, a lens whose blur cannot be drawn, and a `cell_px` of zero, or
/// above one where the model needs rays and depth varies by pixel.
pub fn exact_at_pixels(
    scene: &Scene,
    plane: &Plane,
    pixels: &[(usize, usize)],
    cell_px: usize,
) -> Result<Vec<f64>> {
    scene.check(&[*plane])?;
    let side = if scene.model.needs_rays() { cell_px } else { 1 };
    check(scene, pixels, cell_px, side)?;
    let job = Job {
        scene,
        plane,
        pixels,
        sources: Sources::new(scene),
    };
    let parts = (0..scene.height.div_ceil(side))
        .into_par_iter()
        .map(|band| match side {
            1 => job.row(band),
            _ => job.cells(band * side, side),
        })
        .collect::<Result<Vec<_>>>()?;
    let mut total = vec![0.0; pixels.len()];
    for part in parts {
        for (total, light) in total.iter_mut().zip(part) {
            *total += light;
        }
    }
    Ok(total)
}

fn check(scene: &Scene, pixels: &[(usize, usize)], cell_px: usize, side: usize) -> Result<()> {
    let outside = |&&(column, row): &&(usize, usize)| column >= scene.width || row >= scene.height;
    if let Some((column, row)) = pixels.iter().find(outside) {
        return Err(Error::new(
            format!("pixel ({column}, {row})"),
            format!("is not on the {} x {} plate", scene.width, scene.height),
            "ask for pixels of the plate",
        ));
    }
    if cell_px == 0 {
        return Err(Error::new(
            "cell of source pixels",
            "is 0 px wide",
            "give 1 for a kernel per pixel",
        ));
    }
    if side > 1 && matches!(scene.vergence, VergencePass::PerPixel(_)) {
        return Err(Error::new(
            "cell of source pixels",
            format!("is {side} px wide, and depth varies within it"),
            "give 1 for a kernel per pixel",
        ));
    }
    Ok(())
}

struct Job<'a> {
    scene: &'a Scene<'a>,
    plane: &'a Plane<'a>,
    pixels: &'a [(usize, usize)],
    sources: Sources<'a>,
}

/// A position on or beyond the plate whose light is folded onto a chosen pixel.
struct Landing {
    column: i32,
    row: i32,
    /// Index of the chosen pixel.
    pixel: usize,
}

/// The columns and rows that light reaches, on the plate or relative to its source.
#[derive(Clone)]
struct Bounds {
    columns: RangeInclusive<i32>,
    rows: RangeInclusive<i32>,
}

impl Bounds {
    fn join(&self, other: &Self) -> Self {
        let both = |a: &RangeInclusive<i32>, b: &RangeInclusive<i32>| {
            *a.start().min(b.start())..=*a.end().max(b.end())
        };
        Self {
            columns: both(&self.columns, &other.columns),
            rows: both(&self.rows, &other.rows),
        }
    }

    /// Returns bounds relative to a source at (`column`, `row`) as bounds on the plate.
    fn around(&self, column: usize, row: usize) -> Self {
        let moved = |range: &RangeInclusive<i32>, by: usize| {
            range.start() + by as i32..=range.end() + by as i32
        };
        Self {
            columns: moved(&self.columns, column),
            rows: moved(&self.rows, row),
        }
    }

    /// Returns those `landings`, sorted by row, that lie within.
    fn select(self, landings: &[Landing]) -> impl Iterator<Item = &Landing> {
        let first = landings.partition_point(|landing| landing.row < *self.rows.start());
        let last = landings.partition_point(|landing| landing.row <= *self.rows.end());
        let columns = self.columns;
        let near = move |landing: &&Landing| columns.contains(&landing.column);
        landings[first..last.max(first)].iter().filter(near)
    }
}

impl Job<'_> {
    /// Returns the light of plate row `row` at each chosen pixel.
    fn row(&self, row: usize) -> Result<Vec<f64>> {
        let mut sources = vec![Vec::new(); self.plane.weights.len()];
        self.sources.of_row(&[*self.plane], row, &mut sources)?;
        let mut sums = vec![0.0; self.pixels.len()];
        let mut kernel = KernelRows::default();
        for (channel, sources) in sources.iter().enumerate() {
            let runs: Vec<_> = runs(self.scene.model, sources)
                .map(|(run, middle)| (run, middle, self.bounds(middle)))
                .collect();
            let spans = runs.iter().map(|(run, _, bounds)| {
                let (first, last) = (run[0].0, run[run.len() - 1].0);
                bounds.around(first, row).join(&bounds.around(last, row))
            });
            let Some(all) = spans.reduce(|a, b| a.join(&b)) else {
                continue;
            };
            let landings = self.landings(&all);
            for (run, middle, bounds) in &runs {
                let reaches = |&(column, _): &(usize, Source)| {
                    let mut reached = bounds.around(column, row).select(&landings);
                    self.light(column, row, channel) != 0.0 && reached.next().is_some()
                };
                if !run.iter().any(reaches) {
                    continue;
                }
                let drawn = self.draw(middle, &mut kernel);
                for &(column, _) in *run {
                    let light = self.light(column, row, channel);
                    for landing in bounds.around(column, row).select(&landings) {
                        let offset = (landing.column - column as i32, landing.row - row as i32);
                        sums[landing.pixel] += light * self.weight(middle, drawn, offset);
                    }
                }
            }
        }
        Ok(sums)
    }

    /// Returns the light of the row of cells of `side` pixels at `first_row` at each chosen pixel, with one kernel per cell
    /// and channel.
    fn cells(&self, first_row: usize, side: usize) -> Result<Vec<f64>> {
        let Scene { width, height, .. } = *self.scene;
        let rows = first_row..(first_row + side).min(height);
        let mut sums = vec![0.0; self.pixels.len()];
        let (mut kernel, mut found) = (KernelRows::default(), Vec::new());
        for first_column in (0..width).step_by(side) {
            let columns = first_column..(first_column + side).min(width);
            let middle = (
                columns.start + columns.len() / 2,
                rows.start + rows.len() / 2,
            );
            let pixels = rows
                .clone()
                .flat_map(|row| columns.clone().map(move |column| (column, row)));
            for channel in 0..self.plane.weights.len() {
                // A slice of depth is mostly dark.
                let is_lit = |(column, row)| self.light(column, row, channel) != 0.0;
                if !pixels.clone().any(is_lit) {
                    continue;
                }
                let at = (middle.0 as f64 + 0.5, middle.1 as f64 + 0.5);
                let vergence = self.scene.vergence_at(middle.1 * width + middle.0);
                self.sources
                    .at(at, vergence, |wanted| wanted == channel, &mut found)?;
                let Some(source) = &found[channel] else {
                    continue;
                };
                let bounds = self.bounds(source);
                let first = bounds.around(columns.start, rows.start);
                let last = bounds.around(columns.end - 1, rows.end - 1);
                let landings = self.landings(&first.join(&last));
                if landings.is_empty() {
                    continue;
                }
                let drawn = self.draw(source, &mut kernel);
                for (column, row) in pixels.clone() {
                    let light = self.light(column, row, channel);
                    for landing in bounds.around(column, row).select(&landings) {
                        let offset = (landing.column - column as i32, landing.row - row as i32);
                        sums[landing.pixel] += light * self.weight(source, drawn, offset);
                    }
                }
            }
        }
        Ok(sums)
    }

    /// Returns the light of a source pixel in one channel.
    fn light(&self, column: usize, row: usize, channel: usize) -> f64 {
        let sample = self.plane.samples[row * self.scene.width + column];
        f64::from(sample) * self.plane.weights[channel]
    }

    /// Returns the bounds of the kernel of `source`, relative to it; all that is drawn lies within them.
    fn bounds(&self, source: &Source) -> Bounds {
        let reach = self.scene.model.kernel_bounds(&source.blur);
        let (x, y) = source.shift_px;
        let around = |shift: f64, before: f64, after: f64, more: i32| {
            (shift - before).floor() as i32..=(shift + after).ceil() as i32 + more
        };
        let padding = KernelRows::PADDING as i32;
        Bounds {
            columns: around(x, reach.left_px, reach.right_px, padding),
            rows: around(y, reach.up_px, reach.down_px, 0),
        }
    }

    /// Returns all positions within `bounds` whose light ends on a chosen pixel, by row.
    fn landings(&self, bounds: &Bounds) -> Vec<Landing> {
        let Scene {
            width,
            height,
            edges,
            ..
        } = *self.scene;
        let mut landings = Vec::new();
        for (pixel, &(column, row)) in self.pixels.iter().enumerate() {
            for row in unfolded(row, height, edges, &bounds.rows) {
                for column in unfolded(column, width, edges, &bounds.columns) {
                    landings.push(Landing { column, row, pixel });
                }
            }
        }
        landings.sort_by_key(|landing| landing.row);
        landings
    }

    /// Draws the kernel of `source`; `None` if its samples sum to one anyway.
    fn draw<'k>(&self, source: &Source, kernel: &'k mut KernelRows) -> Option<&'k KernelRows> {
        let model = self.scene.model;
        if model.sums_to_one(&source.blur) {
            return None;
        }
        model.draw_rows(&source.blur, source.shift_px, kernel);
        Some(kernel)
    }

    /// Returns the kernel's share of light at `offset` (column, row) from the source pixel.
    fn weight(&self, source: &Source, drawn: Option<&KernelRows>, offset: (i32, i32)) -> f64 {
        if let Some(kernel) = drawn {
            return drawn_weight(kernel, offset);
        }
        let window = SampleGrid {
            first_x_px: f64::from(offset.0) - source.shift_px.0,
            first_y_px: f64::from(offset.1) - source.shift_px.1,
            width: 1,
            height: 1,
        };
        let mut sample = [0.0];
        self.scene.model.sample(&source.blur, &window, &mut sample);
        sample[0]
    }
}

/// Returns the normalised weight of a drawn kernel at `offset` (column, row).
fn drawn_weight(kernel: &KernelRows, offset: (i32, i32)) -> f64 {
    let span = kernel.spans().find(|span| span.row == offset.1);
    let weight = span.and_then(|span| {
        let column = usize::try_from(offset.0 - span.column).ok()?;
        span.weights.get(column)
    });
    weight.map_or(0.0, |&weight| f64::from(weight) / kernel.sum())
}

/// Returns every position of an axis within `range` whose light lands on `index` of `size` pixels: the inverse of
/// [`fold`](crate::scatter::accumulators::fold).
fn unfolded(
    index: usize,
    size: usize,
    edges: Edges,
    range: &RangeInclusive<i32>,
) -> impl Iterator<Item = i32> + use<> {
    let (index, size) = (index as i32, size as i32);
    let (period, second) = match edges {
        Edges::Black => (None, None),
        Edges::Mirror => (Some(2 * size), Some(2 * size - 1 - index)),
    };
    let (first, last) = (*range.start(), *range.end());
    [Some(index), second]
        .into_iter()
        .flatten()
        .flat_map(move |place| {
            let start = period.map_or(place, |period| first + (place - first).rem_euclid(period));
            let step = period.unwrap_or(i32::MAX);
            std::iter::successors(Some(start), move |at| at.checked_add(step))
                .take_while(move |at| *at <= last)
                .filter(move |at| *at >= first)
        })
}

#[cfg(test)]
mod tests;
