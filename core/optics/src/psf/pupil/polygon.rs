//! Convex polygons in a triangle of the pupil, cut along the sides of cells.

/// A point of a triangle: its landing point, and its second and third barycentric coordinates.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Point {
    pub(super) at: [f64; 2],
    pub(super) b: f64,
    pub(super) c: f64,
}

impl Point {
    /// Returns the point between `self` and `other` at which coordinate `axis` is `value`.
    #[inline(always)]
    pub(super) fn cut(&self, other: &Self, axis: usize, value: f64) -> Self {
        let t = ((value - self.at[axis]) / (other.at[axis] - self.at[axis])).clamp(0.0, 1.0);
        let between = |a: f64, b: f64| a + t * (b - a);
        let mut at = [
            between(self.at[0], other.at[0]),
            between(self.at[1], other.at[1]),
        ];
        at[axis] = value;
        Self {
            at,
            b: between(self.b, other.b),
            c: between(self.c, other.c),
        }
    }
}

/// A convex polygon of up to eight corners.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Polygon {
    pub(super) points: [Point; 8],
    pub(super) count: usize,
}

impl Polygon {
    #[inline(always)]
    fn push(&mut self, point: Point) {
        // Two cuts leave at most seven corners of a triangle; rounding adds at most one.
        if self.count < self.points.len() {
            self.points[self.count] = point;
            self.count += 1;
        }
    }

    /// Returns twice the area in barycentric coordinates: the share of the light of the triangle.
    #[inline(always)]
    pub(super) fn share(&self) -> f64 {
        let first = &self.points[0];
        let mut sum = 0.0;
        for k in 1..self.count.saturating_sub(1) {
            let (p, q) = (&self.points[k], &self.points[k + 1]);
            sum += (p.b - first.b) * (q.c - first.c) - (q.b - first.b) * (p.c - first.c);
        }
        sum.abs()
    }

    /// Cuts the polygon at `value` of coordinate `axis` into the parts below and above; returns the chord between them.
    #[inline(always)]
    pub(super) fn cut(
        &self,
        axis: usize,
        value: f64,
        below: &mut Self,
        above: &mut Self,
    ) -> Option<(Point, Point)> {
        (below.count, above.count) = (0, 0);
        let mut chord = [Point::default(); 2];
        let mut ends = 0;
        let mut p = &self.points[self.count.saturating_sub(1)];
        let mut p_below = p.at[axis] < value;
        for q in &self.points[..self.count] {
            let q_below = q.at[axis] < value;
            if p_below != q_below {
                let cut = p.cut(q, axis, value);
                below.push(cut);
                above.push(cut);
                chord[ends & 1] = cut;
                ends += 1;
            }
            if q_below {
                below.push(*q);
            } else {
                above.push(*q);
            }
            (p, p_below) = (q, q_below);
        }
        (ends == 2).then_some((chord[0], chord[1]))
    }
}

/// Reusable polygons for cutting triangles.
#[derive(Debug, Default)]
pub(super) struct Scratch(pub(super) [Polygon; 5]);
