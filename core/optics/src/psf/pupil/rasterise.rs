//! Rasterisation of pupil triangles on the cells they land on, with exact area coverage and derivatives.
//!
//! A triangle of the pupil holds light in proportion to its area, and lands as a triangle of even light. The share of a
//! cell is the area of the part of the *pupil* triangle whose rays fall into the cell. That part is a polygon in
//! barycentric coordinates, so triangles that a caustic folds to a line need no special case.
//!
//! The derivative of the light in a cell is the flux through its sides: density times velocity, along each chord that a
//! side cuts out of a triangle.
//!
//! Area coverage of a footprint smaller than a cell loses its position in the cell. Outside renderers, such a footprint is
//! instead interpolated between cells triangle by triangle ([`Deposit::Interpolated`]).

use super::edge_coverage::{Corners, EdgeCoverage};
use super::mesh::{LANES, MAX_LIGHT_DERIVATIVES, Pack, Ring, packs};
use super::polygon::{Point, Scratch};
use super::{CellGrid, Detail};
use crate::lens::{Stop, Transmission};

/// The distribution of the light of a triangle over cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Deposit {
    /// By exact area coverage.
    Coverage,
    /// As a point at its centroid, by quadratic B-spline weights of three by three cells. They keep the centroid at any
    /// position in a cell and add a constant variance, [`Deposit::excess_variance`], which the blur must lack.
    Interpolated,
}

impl Deposit {
    /// Variance of a quadratic B-spline less that of the integration over a cell, cells².
    const SPLINE_EXCESS: f64 = 1.0 / 4.0 - 1.0 / 12.0;
    /// Largest radius of a footprint that is interpolated, cells. Area coverage of a disc of this radius displaces its
    /// centroid by a hundredth of a cell; smaller ones by up to half a cell.
    const MOST_RADIUS: f64 = 1.5;

    /// Chooses the deposit for a footprint of `radius` cells that is blurred by a `variance` of cells² afterwards. Renderers use
    /// coverage alone: with interpolation an even plate through a lens of small PSFs was not even.
    pub(super) fn choose(detail: Detail, radius: f64, variance: f64) -> Self {
        let is_small = radius <= Self::MOST_RADIUS && variance >= Self::SPLINE_EXCESS;
        if is_small && !detail.is_for_rendering() {
            Self::Interpolated
        } else {
            Self::Coverage
        }
    }

    /// Returns the variance that the deposit adds to that of exact integration over cells, cells².
    pub(super) fn excess_variance(self) -> f64 {
        match self {
            Self::Coverage => 0.0,
            Self::Interpolated => Self::SPLINE_EXCESS,
        }
    }
}

/// A grid of cells that accumulates light and its derivatives.
#[derive(Debug)]
pub(super) struct Canvas {
    width: usize,
    height: usize,
    deposit: Deposit,
    /// Number of derivatives.
    derivative_count: usize,
    /// Cells per px.
    scale: f64,
    /// Light of each cell, row-major.
    pub(super) light: Vec<f64>,
    /// Derivatives of the light, cell by cell, in packs.
    pub(super) derivatives: Vec<Pack>,
    /// Light of the whole plane, and its derivatives by the last parameters.
    total: f64,
    growth: [f64; MAX_LIGHT_DERIVATIVES],
    edges: EdgeCoverage,
}

impl Default for Canvas {
    fn default() -> Self {
        Self {
            width: 0,
            height: 0,
            deposit: Deposit::Coverage,
            derivative_count: 0,
            scale: 1.0,
            light: Vec::new(),
            derivatives: Vec::new(),
            total: 0.0,
            growth: [0.0; MAX_LIGHT_DERIVATIVES],
            edges: EdgeCoverage::default(),
        }
    }
}

impl Canvas {
    /// Resizes the canvas to `cells`, with all values zero.
    pub(super) fn clear(&mut self, cells: &CellGrid, derivative_count: usize) {
        let count = cells.columns * cells.rows;
        (self.width, self.height) = (cells.columns, cells.rows);
        self.deposit = cells.deposit;
        self.derivative_count = derivative_count;
        self.scale = cells.per_pixel as f64;
        self.light.clear();
        self.light.resize(count, 0.0);
        (self.total, self.growth) = (0.0, [0.0; MAX_LIGHT_DERIVATIVES]);
        self.derivatives.clear();
        self.derivatives
            .resize(count * packs(derivative_count), Pack::default());
        if self.follows_edges() {
            self.edges.clear(self.width, self.height);
        }
    }

    /// Returns whether triangles are rasterised together, by their edges. Derivatives need each triangle alone.
    fn follows_edges(&self) -> bool {
        self.derivative_count == 0 && self.deposit == Deposit::Coverage
    }

    #[inline(always)]
    fn index(&self, column: i32, row: i32) -> Option<usize> {
        let inside = column >= 0
            && row >= 0
            && (column as usize) < self.width
            && (row as usize) < self.height;
        inside.then(|| row as usize * self.width + column as usize)
    }

    /// Adds light to a cell; `growth` holds its relative derivatives by the last parameters.
    #[inline(always)]
    fn add(&mut self, column: i32, row: i32, light: f64, growth: &[f64]) {
        if let Some(index) = self.index(column, row) {
            self.light[index] += light;
            if !growth.is_empty() {
                let first = self.derivative_count - growth.len();
                let start = index * packs(self.derivative_count);
                for (k, g) in growth.iter().enumerate() {
                    let k = first + k;
                    self.derivatives[start + k / LANES][k % LANES] += light * g;
                }
            }
        }
    }
}

/// The transmission of the pupil.
pub(super) struct Filter {
    pub(super) transmission: Transmission,
    /// Its changes by each of the last parameters, which change the light of triangles.
    pub(super) rates: Vec<Transmission>,
    /// A shadow in which triangles are dark.
    pub(super) shadow: Option<Stop>,
}

impl Filter {
    /// Returns the light of a triangle of the pupil with this `area` and centroid.
    #[inline(always)]
    fn light(&self, area: f64, centroid: [f64; 2]) -> f64 {
        if self.shadow.is_some_and(|disc| disc.depth(centroid) > 0.0) {
            0.0
        } else if self.transmission.is_uniform() {
            area
        } else {
            area * self.transmission.at(centroid)
        }
    }
}

/// A triangle of the mesh, mapped to the canvas.
struct Triangle<'a> {
    /// Landing points of the corners, cells.
    at: [[f64; 2]; 3],
    /// Derivatives of the landing points: all x, then all y, in packs.
    velocity: [&'a [Pack]; 3],
    /// The light it holds.
    light: f64,
    /// Relative derivatives of that light by the last parameters.
    growth: &'a [f64],
}

/// Quadratic B-spline weights of three cells in a line.
struct SplineWeights {
    /// The first cell.
    first: i32,
    /// Weight, and its derivative by the position, of each cell.
    terms: [(f64, f64); 3],
}

impl SplineWeights {
    /// Returns the weights of a point at `position`, cells.
    #[inline(always)]
    fn at(position: f64) -> Self {
        let nearest = position.floor();
        let off = position - nearest - 0.5;
        let (before, after) = (0.5 - off, 0.5 + off);
        Self {
            first: (nearest as i32).saturating_sub(1),
            terms: [
                (before * before / 2.0, -before),
                (0.75 - off * off, -2.0 * off),
                (after * after / 2.0, after),
            ],
        }
    }
}

/// Returns the signed area of a triangle.
#[inline(always)]
fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
}

/// Returns the centroid of a triangle.
#[inline(always)]
fn centroid([a, b, c]: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
}

impl Canvas {
    /// Normalises the light of the whole plane to one, the `changing` last derivatives with it.
    fn normalise(&mut self, changing: usize) {
        let share = 1.0 / self.total;
        self.light.iter_mut().for_each(|v| *v *= share);
        let derivatives = self.derivatives.as_flattened_mut();
        derivatives.iter_mut().for_each(|v| *v *= share);
        let stride = packs(self.derivative_count) * LANES;
        let first = self.derivative_count - changing;
        if changing > 0 {
            let cells = derivatives.chunks_exact_mut(stride).zip(&self.light);
            for (cell, light) in cells {
                for (derivative, growth) in cell[first..].iter_mut().zip(&self.growth[..changing]) {
                    *derivative -= light * growth * share;
                }
            }
        }
    }

    /// Rasterises the triangles between two neighbouring rings, the outer one being ring `k`.
    ///
    /// The top-left corner of the canvas lies at `origin`, px from the chief ray.
    #[inline(always)]
    pub(super) fn add_ring(
        &mut self,
        k: usize,
        inner: &Ring,
        outer: &Ring,
        origin: [f64; 2],
        filter: &Filter,
        scratch: &mut Scratch,
    ) {
        if self.follows_edges() {
            self.add_ring_by_edges(k, [inner, outer], origin, filter, scratch);
            return;
        }
        let (inner_count, outer_count) = ((6 * (k - 1)).max(1), 6 * k);
        for sector in 0..6 {
            for j in 0..k {
                let (o, i) = (sector * k + j, sector * (k - 1) + j);
                let next = if o + 1 == outer_count { 0 } else { o + 1 };
                let here = if i == inner_count { 0 } else { i };
                let corners = [(outer, o), (outer, next), (inner, here)];
                self.add_corners(corners, origin, filter, scratch);
                if j + 1 < k {
                    let ahead = if i + 1 == inner_count { 0 } else { i + 1 };
                    let corners = [(inner, here), (outer, next), (inner, ahead)];
                    self.add_corners(corners, origin, filter, scratch);
                }
            }
        }
    }

    /// [`Canvas::add_ring`] by edges.
    #[inline(always)]
    fn add_ring_by_edges(
        &mut self,
        k: usize,
        rings: [&Ring; 2],
        origin: [f64; 2],
        filter: &Filter,
        scratch: &mut Scratch,
    ) {
        let mut edges = std::mem::take(&mut self.edges);
        let scale = self.scale;
        let place = |p: [f64; 2]| [0, 1].map(|axis| (p[axis] - origin[axis]) * scale);
        let mut total = 0.0;
        let light = |corners: &Corners| {
            let u = corners.map(|(ring, k)| ring.u[k]);
            let light = filter.light(area(u), centroid(u));
            total += light;
            light
        };
        edges.add_ring(k, rings, place, light, |at, light| {
            let triangle = Triangle {
                at,
                velocity: [&[]; 3],
                light,
                growth: &[],
            };
            self.add_triangle(&triangle, scratch);
        });
        self.total += total;
        self.edges = edges;
    }

    /// Ends the rasterisation of a mesh, after its last ring.
    #[inline(always)]
    pub(super) fn finish(&mut self, changing: usize) {
        if self.follows_edges() {
            self.edges.finish(&mut self.light);
        }
        self.normalise(changing);
    }

    /// Rasterises the triangle between three mesh corners, each a ring and an index in it.
    #[inline(always)]
    fn add_corners(
        &mut self,
        corners: [(&Ring, usize); 3],
        origin: [f64; 2],
        filter: &Filter,
        scratch: &mut Scratch,
    ) {
        let u = corners.map(|(ring, k)| ring.u[k]);
        let edge = |a: usize| [u[a][0] - u[0][0], u[a][1] - u[0][1]];
        let (e, f) = (edge(1), edge(2));
        let area = area(u);
        let at = corners.map(|(ring, k)| {
            let p = ring.landing[k];
            [0, 1].map(|axis| (p[axis] - origin[axis]) * self.scale)
        });
        let width = 2 * packs(self.derivative_count);
        let velocity = corners.map(|(ring, k)| &ring.velocity[k * width..(k + 1) * width]);
        // The transmission at the centroid: exact to second order in the size of the triangle.
        let middle = centroid(u);
        let even = filter.transmission.is_uniform();
        let changing = filter.rates.len();
        let mut growth = [0.0; MAX_LIGHT_DERIVATIVES];
        for (which, growth) in growth[..changing].iter_mut().enumerate() {
            let d = corners.map(|(ring, k)| ring.drift[k * changing + which]);
            let (g, h) = (
                [d[1][0] - d[0][0], d[1][1] - d[0][1]],
                [d[2][0] - d[0][0], d[2][1] - d[0][1]],
            );
            *growth = (g[0] * f[1] - g[1] * f[0] + e[0] * h[1] - e[1] * h[0]) / (2.0 * area);
            *growth += (filter.transmission).log_derivative(&filter.rates[which], middle);
            if !even {
                let [x, y] = filter.transmission.log_gradient(middle);
                *growth +=
                    (x * (d[0][0] + d[1][0] + d[2][0]) + y * (d[0][1] + d[1][1] + d[2][1])) / 3.0;
            }
        }
        let light = filter.light(area, middle);
        let triangle = Triangle {
            at,
            velocity,
            light,
            growth: &growth[..changing],
        };
        self.total += light;
        for (sum, growth) in self.growth.iter_mut().zip(triangle.growth) {
            *sum += light * growth;
        }
        match self.deposit {
            Deposit::Coverage => self.add_triangle(&triangle, scratch),
            Deposit::Interpolated => self.add_point(&triangle),
        }
    }

    /// Interpolates the light of a small triangle between three by three cells, as a point at its centroid.
    #[inline(never)]
    fn add_point(&mut self, t: &Triangle) {
        let half = packs(self.derivative_count);
        let [across, down] = [0, 1]
            .map(|axis| SplineWeights::at((t.at[0][axis] + t.at[1][axis] + t.at[2][axis]) / 3.0));
        for (row, (weight_y, slope_y)) in (down.first..).zip(down.terms) {
            for (column, (weight_x, slope_x)) in (across.first..).zip(across.terms) {
                self.add(column, row, t.light * weight_x * weight_y, t.growth);
                let Some(cell) = self.index(column, row).filter(|_| half > 0) else {
                    continue;
                };
                // The velocity of the centroid is the mean of those of the corners.
                let per_px = t.light * self.scale / 3.0;
                let slopes = [per_px * slope_x * weight_y, per_px * weight_x * slope_y];
                let target = &mut self.derivatives[cell * half..(cell + 1) * half];
                for velocity in t.velocity {
                    let (along_x, along_y) = velocity.split_at(half);
                    for (sums, (x, y)) in target.iter_mut().zip(along_x.iter().zip(along_y)) {
                        for lane in 0..LANES {
                            sums[lane] += slopes[0] * x[lane] + slopes[1] * y[lane];
                        }
                    }
                }
            }
        }
    }

    /// Rasterises one triangle.
    #[inline(always)]
    fn add_triangle(&mut self, t: &Triangle, scratch: &mut Scratch) {
        let low = [0, 1].map(|a| t.at[0][a].min(t.at[1][a]).min(t.at[2][a]).floor() as i32);
        let high = [0, 1].map(|a| t.at[0][a].max(t.at[1][a]).max(t.at[2][a]).floor() as i32);
        if high[0] < 0 || high[1] < 0 || low[0] >= self.width as i32 || low[1] >= self.height as i32
        {
            return;
        }
        match [0, 1].map(|axis| high[axis].saturating_sub(low[axis])) {
            [0, 0] => self.add(low[0], low[1], t.light, t.growth),
            [1, 0] => self.across_one_side(t, 0, (low[0], low[1]), (high[0], low[1])),
            [0, 1] => self.across_one_side(t, 1, (low[0], low[1]), (low[0], high[1])),
            _ => self.across_many(t, low, high, scratch),
        }
    }

    /// Rasterises a triangle that one cell side across `axis` cuts in two.
    #[inline(always)]
    fn across_one_side(&mut self, t: &Triangle, axis: usize, near: (i32, i32), far: (i32, i32)) {
        let side = f64::from(if axis == 0 { far.0 } else { far.1 });
        let off = t.at.map(|p| p[axis] - side);
        // The corner that is alone on its side of the cut.
        let below = off.map(|o| o < 0.0);
        let alone = if below[1] == below[2] {
            0
        } else if below[0] == below[2] {
            1
        } else {
            2
        };
        let (next, last) = ((alone + 1) % 3, (alone + 2) % 3);
        let (first, second) = (
            off[alone] / (off[alone] - off[next]),
            off[alone] / (off[alone] - off[last]),
        );
        let share = first * second;
        let (this, other) = if below[alone] {
            (near, far)
        } else {
            (far, near)
        };
        self.add(this.0, this.1, t.light * share, t.growth);
        self.add(other.0, other.1, t.light * (1.0 - share), t.growth);
        if self.derivative_count == 0 || off[alone] == 0.0 {
            return;
        }
        let density = 2.0 * t.light * share / off[alone].abs();
        let mut weights = [0.0; 3];
        weights[next] = density * first / 2.0;
        weights[last] = density * second / 2.0;
        weights[alone] = density - weights[next] - weights[last];
        self.add_flux(t, axis, weights, near, far);
    }

    /// Rasterises a triangle over any number of cells.
    #[inline(always)]
    fn across_many(&mut self, t: &Triangle, low: [i32; 2], high: [i32; 2], scratch: &mut Scratch) {
        let [rest, spare, strip, spare_strip, cell] = &mut scratch.0;
        let (mut rest, mut spare) = (rest, spare);
        let (mut strip, mut spare_strip) = (strip, spare_strip);
        rest.count = 3;
        for (k, (b, c)) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].into_iter().enumerate() {
            rest.points[k] = Point { at: t.at[k], b, c };
        }
        // Everything outside the canvas counts as one column or row on that side.
        let (width, height) = (self.width as i32, self.height as i32);
        let (left, right) = (low[0].max(-1), high[0].min(width));
        for column in left..=right {
            if column == right {
                std::mem::swap(&mut strip, &mut rest);
            } else {
                let chord = rest.cut(0, f64::from(column + 1), strip, spare);
                std::mem::swap(&mut rest, &mut spare);
                if let Some((p, q)) = chord {
                    self.through_column_side(t, column, p, q);
                }
            }
            if strip.count < 3 || column < 0 || column >= width {
                continue;
            }
            let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in &strip.points[..strip.count] {
                (first, last) = (first.min(p.at[1]), last.max(p.at[1]));
            }
            let first = (first.floor() as i32).max(-1);
            let last = (last.floor() as i32).min(height);
            for row in first..last {
                let chord = strip.cut(1, f64::from(row + 1), cell, spare_strip);
                std::mem::swap(&mut strip, &mut spare_strip);
                if let Some((p, q)) = chord {
                    self.add_chord(t, 1, p, q, (column, row), (column, row + 1));
                }
                self.add(column, row, t.light * cell.share(), t.growth);
            }
            self.add(column, last, t.light * strip.share(), t.growth);
        }
    }

    /// Adds the flux through the side between `column` and the next along the chord p-q, row by row.
    #[inline(always)]
    fn through_column_side(&mut self, t: &Triangle, column: i32, p: Point, q: Point) {
        if self.derivative_count == 0 {
            return;
        }
        let (mut p, q) = if p.at[1] <= q.at[1] { (p, q) } else { (q, p) };
        let first = (p.at[1].floor() as i32).max(-1);
        let last = (q.at[1].floor() as i32).min(self.height as i32);
        for row in first..=last {
            let end = if row == last {
                q
            } else {
                p.cut(&q, 1, f64::from(row + 1))
            };
            self.add_chord(t, 0, p, end, (column, row), (column + 1, row));
            p = end;
        }
    }

    /// Adds the flux through the chord p-q, which lies on a cell side across `axis`, between two cells.
    #[inline(always)]
    fn add_chord(
        &mut self,
        t: &Triangle,
        axis: usize,
        p: Point,
        q: Point,
        from: (i32, i32),
        to: (i32, i32),
    ) {
        if self.derivative_count == 0 {
            return;
        }
        let square = |x: f64, y: f64| x * x + y * y;
        let steep = square(t.at[1][axis] - t.at[0][axis], t.at[2][axis] - t.at[0][axis]);
        let length = square(p.b - q.b, p.c - q.c);
        let density = 2.0 * t.light * (length / steep).sqrt();
        if density == 0.0 || !density.is_finite() {
            return;
        }
        let (b, c) = ((p.b + q.b) / 2.0, (p.c + q.c) / 2.0);
        let weights = [density * (1.0 - b - c), density * b, density * c];
        self.add_flux(t, axis, weights, from, to);
    }

    /// Adds the flux between two cells for the weighted velocity of the corners along `axis`.
    #[inline(always)]
    fn add_flux(
        &mut self,
        t: &Triangle,
        axis: usize,
        weights: [f64; 3],
        from: (i32, i32),
        to: (i32, i32),
    ) {
        let half = packs(self.derivative_count);
        let weights = weights.map(|w| w * self.scale);
        let [u, v, w] = t.velocity;
        let (u, v, w) = (
            &u[axis * half..(axis + 1) * half],
            &v[axis * half..(axis + 1) * half],
            &w[axis * half..(axis + 1) * half],
        );
        let from = self.index(from.0, from.1).map(|pixel| pixel * half);
        let to = self.index(to.0, to.1).map(|pixel| pixel * half);
        for k in 0..half {
            let mut flux = Pack::default();
            for lane in 0..LANES {
                flux[lane] =
                    weights[0] * u[k][lane] + weights[1] * v[k][lane] + weights[2] * w[k][lane];
            }
            if let Some(pixel) = from {
                let losing = &mut self.derivatives[pixel + k];
                for lane in 0..LANES {
                    losing[lane] -= flux[lane];
                }
            }
            if let Some(pixel) = to {
                let gaining = &mut self.derivatives[pixel + k];
                for lane in 0..LANES {
                    gaining[lane] += flux[lane];
                }
            }
        }
    }
}
