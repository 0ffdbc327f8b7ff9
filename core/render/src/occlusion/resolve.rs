//! One picture of blurred slices, from the nearest to the farthest.
//!
//! Of each slice come a presence m >= 0 (how much of the pixel's view the slice takes up, alone) and
//! planes c already multiplied by presence. Slices of one surface together take up the whole view, so
//! they *add up*; separate surfaces *hide* each other. Which of the two holds is told by gaps: a pixel
//! of the picture keeps T, the light that still passes, and G, how much of that is taken up by the
//! surface under way. A slice gets
//!
//!   u = T min(m, 1 - G),  G <- G + min(m, 1 - G),  picture <- picture + (u / m) c.
//!
//! A slice with little in it closes the surface. With q = max(0, 1 - m / e)^2, one for an empty slice,
//!
//!   T <- T (1 - q G),  G <- G (1 - q) / (1 - q G),
//!
//! which keeps T (1 - G). In the end the picture is divided by the sum of u: what nothing was found for
//! is filled by what was. Coverage and light have the same weights, so that an opaque plate stays opaque
//! and a transparent one as transparent as it is.

use super::Holdout;
use crate::RenderWindow;
use rayon::prelude::*;

/// Presence below which a slice begins to close the surface before it.
const EMPTY: f32 = 0.02;

/// What is known so far of the picture.
pub(super) struct Resolve {
    rows: Vec<Row>,
    /// For each view, the share of each presence plane in it.
    views: Vec<Vec<f32>>,
    /// The view of each plane.
    view_of: Vec<usize>,
}

/// A row of the plate.
struct Row {
    /// Rung of the last slice that was looked at; surfaces are closed when one is missed.
    last: Vec<i32>,
    views: Vec<ViewRow>,
    planes: Vec<Vec<f32>>,
}

/// A row as seen by planes with one set of channel weights.
#[derive(Clone)]
struct ViewRow {
    /// T, G and the sum of u.
    passing: Vec<f32>,
    surface: Vec<f32>,
    used: Vec<f32>,
}

/// A blurred slice.
pub(super) struct Blurred<'a> {
    pub(super) layer: usize,
    /// Its place on the layers, and its vergence.
    pub(super) place: f32,
    pub(super) vergence: f64,
    pub(super) crop: RenderWindow,
    pub(super) planes: &'a [Vec<f32>],
    pub(super) presence: &'a [Vec<f32>],
}

/// What else keeps light back, sharp to the pixel.
pub(super) struct Sharp<'a> {
    pub(super) holdout: Option<Holdout<'a>>,
    /// Where near sides of edges keep their own edge: place of every pixel and how much of what is
    /// behind it is kept back.
    pub(super) hard: Option<(&'a [f32], &'a [f32])>,
}

impl Resolve {
    /// Nothing yet, for a plate of `width` x `height`; `views` say the shares of presence planes,
    /// `view_of` the view of each plane.
    pub(super) fn new(
        (width, height): (usize, usize),
        views: Vec<Vec<f32>>,
        view_of: Vec<usize>,
    ) -> Self {
        let row = || Row {
            last: vec![i32::MAX; width],
            views: vec![
                ViewRow {
                    passing: vec![1.0; width],
                    surface: vec![0.0; width],
                    used: vec![0.0; width],
                };
                views.len()
            ],
            planes: vec![vec![0.0; width]; view_of.len()],
        };
        Self {
            rows: (0..height).map(|_| row()).collect(),
            views,
            view_of,
        }
    }

    /// Puts a slice behind those before.
    pub(super) fn put(&mut self, slice: &Blurred, sharp: &Sharp) {
        let RenderWindow { row, height, .. } = slice.crop;
        let (views, view_of) = (&self.views, &self.view_of);
        let rows = self.rows[row..row + height].par_iter_mut().enumerate();
        rows.for_each_init(Scratch::default, |scratch, (line, row)| {
            row.put(slice, sharp, line, (views, view_of), scratch);
        });
    }

    /// The planes.
    pub(super) fn finish(self) -> Vec<Vec<f32>> {
        let Self { rows, view_of, .. } = self;
        let plane = |(index, &view): (usize, &usize)| {
            let row = |row: &Row| {
                let used = row.views[view].used.iter();
                let pairs = row.planes[index].iter().zip(used);
                pairs
                    .map(|(light, used)| if *used > 0.0 { light / used } else { 0.0 })
                    .collect::<Vec<_>>()
            };
            rows.par_iter().flat_map_iter(row).collect()
        };
        view_of.iter().enumerate().map(plane).collect()
    }
}

/// Buffers of a row.
#[derive(Default)]
struct Scratch {
    presence: Vec<f32>,
    /// What sharp things let through: to be seen, and to be counted.
    seen: Vec<f32>,
    counted: Vec<f32>,
    /// u / m of each view.
    shares: Vec<Vec<f32>>,
}

impl Row {
    /// Puts row `line` of the slice's crop behind.
    fn put(
        &mut self,
        slice: &Blurred,
        sharp: &Sharp,
        line: usize,
        (views, view_of): (&[Vec<f32>], &[usize]),
        scratch: &mut Scratch,
    ) {
        let crop = slice.crop;
        let columns = crop.column..crop.column + crop.width;
        let from = line * crop.width..(line + 1) * crop.width;
        let first = (crop.row + line) * self.last.len() + crop.column;
        self.close_missed(slice.layer as i32, columns.clone());
        sharp.fill(slice, first..first + crop.width, scratch);
        scratch.shares.resize(views.len(), Vec::new());
        for (index, (view, shares)) in self.views.iter_mut().zip(views).enumerate() {
            scratch.presence.clear();
            scratch.presence.resize(crop.width, 0.0);
            for (plane, share) in slice.presence.iter().zip(shares) {
                if *share != 0.0 {
                    for (sum, m) in scratch.presence.iter_mut().zip(&plane[from.clone()]) {
                        *sum += share * m;
                    }
                }
            }
            let out = &mut scratch.shares[index];
            out.resize(crop.width, 0.0);
            view.take(columns.clone(), &scratch.presence, &scratch.counted, out);
            for (share, seen) in out.iter_mut().zip(&scratch.seen) {
                *share *= seen;
            }
        }
        for ((out, plane), view) in self.planes.iter_mut().zip(slice.planes).zip(view_of) {
            let lines = out[columns.clone()].iter_mut().zip(&plane[from.clone()]);
            for ((out, light), share) in lines.zip(&scratch.shares[*view]) {
                *out += share * light;
            }
        }
    }

    /// Closes surfaces where slices between the last one and `layer` were empty.
    fn close_missed(&mut self, layer: i32, columns: std::ops::Range<usize>) {
        for column in columns {
            let last = &mut self.last[column];
            if *last != layer + 1 {
                for view in &mut self.views {
                    view.passing[column] *= 1.0 - view.surface[column];
                    view.surface[column] = 0.0;
                }
            }
            *last = layer;
        }
    }
}

impl ViewRow {
    /// Takes a slice of the given presence; `counted` is how much of it is let through. Writes u / m.
    fn take(
        &mut self,
        columns: std::ops::Range<usize>,
        presence: &[f32],
        counted: &[f32],
        shares: &mut [f32],
    ) {
        let state = self.passing[columns.clone()]
            .iter_mut()
            .zip(&mut self.surface[columns.clone()])
            .zip(&mut self.used[columns]);
        let given = presence.iter().zip(counted).zip(shares);
        for (((passing, surface), used), ((m, counted), share)) in state.zip(given) {
            // Rounding of inner renderers can leave presence a little below zero.
            let m = m.max(0.0);
            let gap = (1.0 - m / EMPTY).max(0.0);
            let gap = gap * gap;
            let left = 1.0 - gap * *surface;
            *passing *= left;
            // Where nothing is left the surface was full, and the gap complete.
            *surface = if left > 0.0 {
                *surface * (1.0 - gap) / left
            } else {
                0.0
            };
            let taken = m.min(1.0 - *surface).max(0.0);
            *surface += taken;
            let u = *passing * taken * counted;
            *used += u;
            *share = if m > 0.0 { u / m } else { 0.0 };
        }
    }
}

impl Sharp<'_> {
    /// What is let through of a slice at the plate's pixels `range`.
    fn fill(&self, slice: &Blurred, range: std::ops::Range<usize>, scratch: &mut Scratch) {
        let Scratch { seen, counted, .. } = scratch;
        seen.clear();
        seen.resize(range.len(), 1.0);
        counted.clear();
        counted.resize(range.len(), 1.0);
        if let Some((places, kept)) = self.hard {
            let pixels = places[range.clone()].iter().zip(&kept[range.clone()]);
            for (counted, (place, kept)) in counted.iter_mut().zip(pixels) {
                // The farther of the two slices of the pixel's own surface is less than one layer off.
                if slice.place <= place - 1.0 {
                    *counted = 1.0 - kept;
                }
            }
        }
        let Some(holdout) = self.holdout else {
            return;
        };
        for (seen, index) in seen.iter_mut().zip(range) {
            *seen = holdout.passing(slice.vergence, index);
        }
    }
}
