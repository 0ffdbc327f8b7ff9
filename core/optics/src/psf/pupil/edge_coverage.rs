//! Exact area coverage of a whole mesh, edge by edge, for light without derivatives.
//!
//! A triangle of even density covers what lies right of its edges, counted with the sign of their direction along y. An edge between
//! two triangles therefore adds the difference of their densities to everything on its right, and each edge is followed
//! once. Differences from column to column are stored, and summed along rows at the end. The result equals that of clipping
//! every triangle to every cell, to rounding.

use super::mesh::Ring;

/// Least area of a landed triangle that is followed by its edges, cells². The density of a smaller one would leave rounding errors.
const LEAST_AREA: f64 = 1e-6;

/// A triangle of the mesh: a ring and an index in it for each corner.
pub(super) type Corners<'a> = [(&'a Ring, usize); 3];

/// Light on a grid of cells, stored as differences along rows.
#[derive(Debug, Default)]
pub(super) struct EdgeCoverage {
    width: usize,
    /// Row by row, `width` + 2 values each.
    differences: Vec<f64>,
    /// First column of each row with an edge, and the column after the last one.
    touched: Vec<[usize; 2]>,
    /// Landing points of the corners of the inner and the outer ring, cells.
    inner: Vec<[f64; 2]>,
    outer: Vec<[f64; 2]>,
    /// Densities of the triangles inside of each edge of the inner and the outer ring.
    inner_density: Vec<f64>,
    outer_density: Vec<f64>,
}

impl EdgeCoverage {
    /// Prepares a grid of `width` x `height` cells without light.
    pub(super) fn clear(&mut self, width: usize, height: usize) {
        self.width = width;
        self.differences.clear();
        self.differences.resize((width + 2) * height, 0.0);
        self.touched.clear();
        self.touched.resize(height, [usize::MAX, 0]);
        self.outer.clear();
        self.outer_density.clear();
    }

    /// Adds the triangles between two neighbouring rings, the outer one being ring `k`; rings come from the innermost on, which is
    /// the centre or the edge of a hole.
    ///
    /// `place` turns landing points into cells. `light` returns the light of a triangle and is called once for each. Triangles folded to
    /// a line are left to `fold`, with the landing points of their corners and their light.
    #[inline(always)]
    pub(super) fn add_ring(
        &mut self,
        k: usize,
        [inner, outer]: [&Ring; 2],
        place: impl Fn([f64; 2]) -> [f64; 2],
        mut light: impl FnMut(&Corners) -> f64,
        mut fold: impl FnMut([[f64; 2]; 3], f64),
    ) {
        if self.outer.is_empty() {
            self.outer.extend(inner.landing.iter().map(|p| place(*p)));
            // Within the innermost ring is nothing: its centre, or a shadow.
            self.outer_density.resize(self.outer.len(), 0.0);
        }
        std::mem::swap(&mut self.inner, &mut self.outer);
        std::mem::swap(&mut self.inner_density, &mut self.outer_density);
        self.outer.clear();
        self.outer.extend(outer.landing.iter().map(|p| place(*p)));
        self.outer_density.clear();
        let mut density = |corners: Corners, at: [[f64; 2]; 3]| {
            let light = light(&corners);
            let [a, b, c] = at;
            let area = ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2.0;
            if area.abs() < LEAST_AREA {
                fold(at, light);
                return 0.0;
            }
            // Negative: the coverage right of the edges of a triangle adds up to its area, negative.
            -light / area
        };
        let (inner_count, outer_count) = ((6 * (k - 1)).max(1), 6 * k);
        let (mut first, mut last) = (None, 0.0);
        for sector in 0..6 {
            for j in 0..k {
                let (o, i) = (sector * k + j, sector * (k - 1) + j);
                let next = if o + 1 == outer_count { 0 } else { o + 1 };
                let here = if i == inner_count { 0 } else { i };
                let [start, end, apex] = [self.outer[o], self.outer[next], self.inner[here]];
                let corners = [(outer, o), (outer, next), (inner, here)];
                let outward = density(corners, [start, end, apex]);
                match first {
                    None => first = Some(outward),
                    Some(_) => self.add_edge(start, apex, last - outward),
                }
                self.outer_density.push(outward);
                last = outward;
                if j + 1 < k {
                    let ahead = if i + 1 == inner_count { 0 } else { i + 1 };
                    let tip = self.inner[ahead];
                    let corners = [(inner, here), (outer, next), (inner, ahead)];
                    let inward = density(corners, [apex, end, tip]);
                    self.add_edge(end, apex, last - inward);
                    self.add_edge(apex, tip, self.inner_density[here] - inward);
                    last = inward;
                }
            }
        }
        let first = first.unwrap_or_default();
        self.add_edge(self.outer[0], self.inner[0], last - first);
    }

    /// Closes the outermost ring and adds the light to `cells`, row-major.
    #[inline(always)]
    pub(super) fn finish(&mut self, cells: &mut [f64]) {
        for k in 0..self.outer.len() {
            let next = if k + 1 == self.outer.len() { 0 } else { k + 1 };
            self.add_edge(self.outer[k], self.outer[next], self.outer_density[k]);
        }
        let rows = self.differences.chunks_exact(self.width + 2);
        let lines = cells.chunks_exact_mut(self.width.max(1));
        for ((row, cells), &[first, end]) in rows.zip(lines).zip(&self.touched) {
            let mut light = 0.0_f64;
            for (cell, difference) in cells.iter_mut().zip(row).take(end).skip(first) {
                light += difference;
                // Rounding leaves a trace in holes of the light.
                *cell += light.max(0.0);
            }
        }
    }

    /// Adds `density` to everything right of the edge from `from` to `to`; negative where the edge goes up.
    #[inline(always)]
    fn add_edge(&mut self, from: [f64; 2], to: [f64; 2], density: f64) {
        if from[1] == to[1] || density == 0.0 {
            return;
        }
        let (density, top, bottom) = if from[1] < to[1] {
            (density, from, to)
        } else {
            (-density, to, from)
        };
        let height = self.touched.len() as f64;
        if bottom[1] <= 0.0 || top[1] >= height {
            return;
        }
        let slope = (bottom[0] - top[0]) / (bottom[1] - top[1]);
        let mut y = top[1].max(0.0);
        let mut x = top[0] + slope * (y - top[1]);
        let end = bottom[1].min(height);
        let mut row = y as usize;
        while y < end {
            let below = ((row + 1) as f64).min(end);
            let next = if below == bottom[1] {
                bottom[0]
            } else {
                top[0] + slope * (below - top[1])
            };
            self.add_piece(row, [x.min(next), x.max(next)], density * (below - y));
            (x, y) = (next, below);
            row += 1;
        }
    }

    /// Adds `light` per cell right of a piece of an edge that crosses columns `low` to `high` within `row`.
    #[inline(always)]
    fn add_piece(&mut self, row: usize, [low, high]: [f64; 2], light: f64) {
        let width = self.width as f64;
        if low < 0.0 || high > width {
            self.add_clipped_piece(row, [low, high], light);
            return;
        }
        let line = &mut self.differences[row * (self.width + 2)..][..self.width + 2];
        let (first, last) = (low as usize, high as usize);
        let touched = &mut self.touched[row];
        *touched = [touched[0].min(first), touched[1].max(last + 1)];
        if first == last {
            let share = (low + high) / 2.0 - first as f64;
            line[first] += light * (1.0 - share);
            line[first + 1] += light * share;
            return;
        }
        // The mean over the piece of how far a column side lies right of it is half its square over the length.
        let rate = 0.5 / (high - low);
        let (mut before, mut covered) = (0.0, 0.0);
        for (column, difference) in line[first..=last].iter_mut().enumerate() {
            let side = (first + column + 1) as f64;
            let beyond = (side - high).max(0.0);
            let reached = side - low;
            let right = rate * (reached * reached - beyond * beyond);
            *difference += light * (right - before - covered);
            (covered, before) = (right - before, right);
        }
        line[last + 1] += light * (1.0 - covered);
    }

    /// [`EdgeCoverage::add_piece`] for a piece that crosses the left or right side of the grid.
    #[inline(never)]
    fn add_clipped_piece(&mut self, row: usize, [low, high]: [f64; 2], light: f64) {
        let width = self.width as f64;
        if high > width {
            // Light up to the right side has no edge there that ends it.
            self.touched[row][1] = self.width;
        }
        let length = high - low;
        let share = |from: f64, to: f64| {
            if length > 0.0 {
                ((to - from) / length).clamp(0.0, 1.0)
            } else {
                1.0
            }
        };
        if low < 0.0 {
            let share = share(low, high.min(0.0));
            self.differences[row * (self.width + 2)] += light * share;
            let touched = &mut self.touched[row];
            *touched = [0, touched[1].max(1)];
        }
        let (low_inside, high_inside) = (low.max(0.0), high.min(width));
        if high_inside > low_inside {
            let share = share(low_inside, high_inside);
            self.add_piece(row, [low_inside, high_inside], light * share);
        }
    }
}
