//! Compositing of blurred depth layers, from the nearest to the farthest.
//!
//! Each layer has a presence m >= 0, the part of a pixel's view that the layer alone takes up, and planes c multiplied
//! by presence. Layers of one surface together take up the whole view and *add up*; separate surfaces *hide* each
//! other. Gaps between layers distinguish the two. A pixel keeps T, the transmittance of all surfaces so far, and G,
//! the part of the view taken up by the current surface. A layer gets
//!
//!   u = T min(m, 1 - G),  G <- G + min(m, 1 - G),  picture <- picture + (u / m) c.
//!
//! A nearly empty layer closes the surface. With q = max(0, 1 - m / e)^2, which is one for an empty layer,
//!
//!   T <- T (1 - q G),  G <- G (1 - q) / (1 - q G),
//!
//! which keeps T (1 - G). At the end the picture is divided by the sum of u, which fills what no layer covers. Each layer takes u off
//! T (1 - G), so the sum is 1 - T (1 - G), unless outlines dim layers behind them. Coverage
//! and light have the same weights: an opaque plate stays opaque, a transparent one as transparent as it is.

use super::Holdout;
use crate::RenderWindow;
use rayon::prelude::*;
use std::ops::Range;

/// The presence e below which a layer begins to close the surface in front of it.
const EMPTY: f32 = 0.02;

/// The composite of the layers so far, in a window of the plate.
pub(super) struct Compositor {
    window: RenderWindow,
    /// Columns of the plate.
    plate_width: usize,
    rows: Vec<Row>,
    /// For each channel mix, the weight of each presence plane.
    presence_of: Vec<Vec<f32>>,
    /// Index of each plane's channel mix.
    mix_of: Vec<usize>,
}

/// A row of the window.
struct Row {
    /// Index of the last layer at each pixel; surfaces are closed where one is missing.
    last: Vec<i32>,
    mixes: Vec<MixRow>,
    planes: Vec<Vec<f32>>,
}

/// The state of a row for planes of one channel mix.
#[derive(Clone)]
struct MixRow {
    /// T.
    transmittance: Vec<f32>,
    /// G.
    surface: Vec<f32>,
    /// Sum of u where there are outlines; without them it follows from T and G.
    used: Option<Vec<f32>>,
}

/// A blurred crop of a depth layer.
pub(super) struct BlurredLayer<'a> {
    /// Index of the layer.
    pub(super) layer: usize,
    /// Coordinate of the layer.
    pub(super) coordinate: f32,
    /// Vergence of the layer, 1/m.
    pub(super) vergence: f64,
    pub(super) crop: RenderWindow,
    pub(super) planes: &'a [Vec<f32>],
    pub(super) presence: &'a [Vec<f32>],
}

/// Mattes that hold light back without blur.
pub(super) struct SharpMattes<'a> {
    pub(super) holdout: Option<Holdout<'a>>,
    /// The outlines of foregrounds that are blurred outwards only.
    pub(super) outline: Option<Outline<'a>>,
}

/// Pixels within the outline of a foreground, which hide what lies behind them.
#[derive(Clone, Copy)]
pub(super) struct Outline<'a> {
    /// Layer coordinate of every pixel.
    pub(super) coordinates: &'a [f32],
    /// Share of the light behind every pixel that is held back.
    pub(super) held: &'a [f32],
}

impl Compositor {
    /// An empty composite of the `window` of a plate of `plate_width` columns.
    ///
    /// `presence_of` holds the weight of each presence plane for each channel mix, `mix_of` the mix of each plane. `mattes` are those of
    /// all layers.
    pub(super) fn new(
        window: RenderWindow,
        plate_width: usize,
        presence_of: Vec<Vec<f32>>,
        mix_of: Vec<usize>,
        mattes: &SharpMattes,
    ) -> Self {
        let RenderWindow { width, height, .. } = window;
        let row = || Row {
            last: vec![i32::MAX; width],
            mixes: vec![
                MixRow {
                    transmittance: vec![1.0; width],
                    surface: vec![0.0; width],
                    used: mattes.outline.map(|_| vec![0.0; width]),
                };
                presence_of.len()
            ],
            planes: vec![vec![0.0; width]; mix_of.len()],
        };
        Self {
            window,
            plate_width,
            rows: (0..height).into_par_iter().map(|_| row()).collect(),
            presence_of,
            mix_of,
        }
    }

    /// Adds a layer behind those before it.
    pub(super) fn add(&mut self, layer: &BlurredLayer, mattes: &SharpMattes) {
        let Some(seen) = self.window.overlap(layer.crop) else {
            return;
        };
        let (window, plate_width) = (self.window, self.plate_width);
        let (presence_of, mix_of) = (&self.presence_of, &self.mix_of);
        let first = seen.row - window.row;
        let rows = self.rows[first..first + seen.height]
            .par_iter_mut()
            .enumerate();
        rows.for_each_init(Scratch::default, |scratch, (line, row)| {
            let line = seen.row + line;
            let within = (line - layer.crop.row) * layer.crop.width + seen.column;
            let add = RowAddition {
                row,
                layer,
                mattes,
                columns: of_length(seen.column - window.column, seen.width),
                within_crop: of_length(within - layer.crop.column, seen.width),
                on_plate: of_length(line * plate_width + seen.column, seen.width),
                presence_of,
                mix_of,
                scratch,
            };
            pulp::Arch::new().dispatch(add);
        });
    }

    /// Returns the composited planes.
    pub(super) fn finish(self) -> Vec<Vec<f32>> {
        let Self {
            window,
            rows,
            mix_of,
            ..
        } = self;
        let plane = |(index, &mix): (usize, &usize)| {
            let mut plane = vec![0.0; window.width * window.height];
            let lines = plane.par_chunks_mut(window.width).zip(&rows);
            lines.for_each(|(out, row)| {
                let light = row.planes[index].iter().zip(row.mixes[mix].used());
                for (out, (light, used)) in out.iter_mut().zip(light) {
                    *out = if used > 0.0 { light / used } else { 0.0 };
                }
            });
            plane
        };
        mix_of.iter().enumerate().map(plane).collect()
    }
}

/// Returns the range of `length` from `start`.
fn of_length(start: usize, length: usize) -> Range<usize> {
    start..start + length
}

/// Buffers of a row.
#[derive(Default)]
struct Scratch {
    presence: Vec<f32>,
    /// Transmittance of the holdout: it dims the picture, not the weights.
    holdout: Vec<f32>,
    /// Transmittance of outlines: it dims picture and weights.
    outline: Vec<f32>,
    /// u / m of each channel mix.
    shares: Vec<Vec<f32>>,
}

/// Adds a row of a layer's crop. `pulp::Arch::dispatch` compiles it for the widest vectors of the processor.
struct RowAddition<'a> {
    row: &'a mut Row,
    layer: &'a BlurredLayer<'a>,
    mattes: &'a SharpMattes<'a>,
    /// Columns of the window.
    columns: Range<usize>,
    /// Indices of these pixels in the crop.
    within_crop: Range<usize>,
    /// Indices of these pixels on the plate.
    on_plate: Range<usize>,
    presence_of: &'a [Vec<f32>],
    mix_of: &'a [usize],
    scratch: &'a mut Scratch,
}

impl pulp::NullaryFnOnce for RowAddition<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            row,
            layer,
            mattes,
            columns,
            within_crop,
            on_plate,
            presence_of,
            mix_of,
            scratch,
        } = self;
        row.close_missed(layer.layer as i32, columns.clone());
        mattes.fill(layer, on_plate, scratch);
        scratch.shares.resize(presence_of.len(), Vec::new());
        for (index, (mix, shares)) in row.mixes.iter_mut().zip(presence_of).enumerate() {
            scratch.presence.clear();
            scratch.presence.resize(columns.len(), 0.0);
            for (plane, share) in layer.presence.iter().zip(shares) {
                if *share != 0.0 {
                    for (sum, m) in scratch.presence.iter_mut().zip(&plane[within_crop.clone()]) {
                        *sum += share * m;
                    }
                }
            }
            let out = &mut scratch.shares[index];
            out.resize(columns.len(), 0.0);
            mix.add(columns.clone(), &scratch.presence, &scratch.outline, out);
            for (share, transmittance) in out.iter_mut().zip(&scratch.holdout) {
                *share *= transmittance;
            }
        }
        for ((out, plane), mix) in row.planes.iter_mut().zip(layer.planes).zip(mix_of) {
            let lines = out[columns.clone()]
                .iter_mut()
                .zip(&plane[within_crop.clone()]);
            for ((out, light), share) in lines.zip(&scratch.shares[*mix]) {
                *out += share * light;
            }
        }
    }
}

impl Row {
    /// Closes surfaces where layers between the last one and `layer` were empty.
    #[inline(always)]
    fn close_missed(&mut self, layer: i32, columns: Range<usize>) {
        let last = &mut self.last[columns.clone()];
        for mix in &mut self.mixes {
            let state = mix.transmittance[columns.clone()]
                .iter_mut()
                .zip(&mut mix.surface[columns.clone()]);
            for ((transmittance, surface), last) in state.zip(&*last) {
                let is_missed = *last != layer + 1;
                let left = if is_missed { 1.0 - *surface } else { 1.0 };
                *transmittance *= left;
                *surface = if is_missed { 0.0 } else { *surface };
            }
        }
        last.fill(layer);
    }
}

impl MixRow {
    /// Adds a layer with this `presence` behind `outline`, the transmittance of outlines, and writes u / m to `shares`.
    #[inline(always)]
    fn add(
        &mut self,
        columns: Range<usize>,
        presence: &[f32],
        outline: &[f32],
        shares: &mut [f32],
    ) {
        let state = self.transmittance[columns.clone()]
            .iter_mut()
            .zip(&mut self.surface[columns.clone()]);
        let layer = presence.iter().zip(outline).zip(&mut *shares);
        for ((transmittance, surface), ((m, outline), share)) in state.zip(layer) {
            // Rounding in the inner renderer can make presence slightly negative.
            let m = m.max(0.0);
            let gap = (1.0 - m / EMPTY).max(0.0);
            let gap = gap * gap;
            let left = 1.0 - gap * *surface;
            *transmittance *= left;
            // `left` is zero where a full surface is closed completely.
            *surface = if left > 0.0 {
                *surface * (1.0 - gap) / left
            } else {
                0.0
            };
            let taken = m.min(1.0 - *surface).max(0.0);
            *surface += taken;
            let u = *transmittance * taken * outline;
            *share = if m > 0.0 { u / m } else { 0.0 };
        }
        if let Some(used) = &mut self.used {
            let layer = presence.iter().zip(&*shares);
            for (used, (m, share)) in used[columns].iter_mut().zip(layer) {
                *used += share * m.max(0.0);
            }
        }
    }

    /// Returns the sum of u at each pixel.
    fn used(&self) -> Vec<f32> {
        match &self.used {
            Some(used) => used.clone(),
            None => {
                let state = self.transmittance.iter().zip(&self.surface);
                state
                    .map(|(transmittance, surface)| 1.0 - transmittance * (1.0 - surface))
                    .collect()
            }
        }
    }
}

impl SharpMattes<'_> {
    /// Returns the share of light at a vergence and layer coordinate that passes all mattes at pixel `index`.
    pub(super) fn transmittance(&self, vergence: f64, coordinate: f32, index: usize) -> f32 {
        let holdout = self
            .holdout
            .map_or(1.0, |h| h.transmittance(vergence, index));
        let outline = self.outline.map_or(1.0, |outline| {
            let is_behind = coordinate <= outline.coordinates[index] - 1.0;
            if is_behind {
                1.0 - outline.held[index]
            } else {
                1.0
            }
        });
        holdout * outline
    }

    /// Computes the transmittance in front of a layer at the plate's pixels `range`.
    #[inline(always)]
    fn fill(&self, layer: &BlurredLayer, range: Range<usize>, scratch: &mut Scratch) {
        let Scratch {
            holdout: through_holdout,
            outline: through_outline,
            ..
        } = scratch;
        through_holdout.clear();
        through_holdout.resize(range.len(), 1.0);
        through_outline.clear();
        through_outline.resize(range.len(), 1.0);
        if let Some(Outline { coordinates, held }) = self.outline {
            let pixels = coordinates[range.clone()].iter().zip(&held[range.clone()]);
            for (transmittance, (coordinate, held)) in through_outline.iter_mut().zip(pixels) {
                // The farther of the two layers of the pixel's own surface is less than one layer away.
                if layer.coordinate <= coordinate - 1.0 {
                    *transmittance = 1.0 - held;
                }
            }
        }
        let Some(holdout) = self.holdout else {
            return;
        };
        for (transmittance, index) in through_holdout.iter_mut().zip(range) {
            *transmittance = holdout.transmittance(layer.vergence, index);
        }
    }
}
