//! Similarity transforms of the plane: scale, rotation and shift.

use nalgebra::{DMatrix, DVector};
use seidel_optics::field::ImagePoint;
use seidel_optics::numeric::median;

/// Iterations of reweighting in [`Similarity::fit`].
const ITERATIONS: usize = 6;
/// Residual, in units of the median one, from which on a pair of points loses weight.
const OUTLIER_RATIO: f64 = 3.0;
/// Lower bound of that scale, px.
const LEAST_RESIDUAL_PX: f64 = 0.01;

/// A similarity transform: a point p goes to `scale` R(`rotation`) p + shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Scale times the cosine of the angle.
    pub a: f64,
    /// Scale times the sine of the angle, from x towards y.
    pub b: f64,
    /// Shift (x, y), px.
    pub shift_px: [f64; 2],
}

/// Freedom of a fitted transform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom {
    /// Shift alone.
    Shift,
    /// Shift, scale and rotation.
    Similarity,
}

/// A point and the point that it corresponds to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointPair {
    /// The point in the picture that is transformed.
    pub from: ImagePoint,
    /// The same detail in the other picture.
    pub to: ImagePoint,
}

impl Similarity {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self {
        a: 1.0,
        b: 0.0,
        shift_px: [0.0; 2],
    };

    /// Returns the transform that shifts by (x, y) px.
    pub fn shift(x: f64, y: f64) -> Self {
        Self {
            shift_px: [x, y],
            ..Self::IDENTITY
        }
    }

    /// Returns the image of `point`.
    pub fn apply(&self, point: ImagePoint) -> ImagePoint {
        let (x, y) = (point.x_px, point.y_px);
        ImagePoint::new(
            self.a * x - self.b * y + self.shift_px[0],
            self.b * x + self.a * y + self.shift_px[1],
        )
    }

    /// Returns the transform that applies `first`, then `self`.
    pub fn after(&self, first: &Self) -> Self {
        let [x, y] = first.shift_px;
        let moved = self.apply(ImagePoint::new(x, y));
        Self {
            a: self.a * first.a - self.b * first.b,
            b: self.a * first.b + self.b * first.a,
            shift_px: [moved.x_px, moved.y_px],
        }
    }

    /// Returns the inverse transform.
    pub fn inverse(&self) -> Self {
        let square = self.a * self.a + self.b * self.b;
        let (a, b) = (self.a / square, -self.b / square);
        let [x, y] = self.shift_px;
        Self {
            a,
            b,
            shift_px: [-(a * x - b * y), -(b * x + a * y)],
        }
    }

    /// Returns the scale.
    pub fn scale(&self) -> f64 {
        self.a.hypot(self.b)
    }

    /// Returns the angle from x towards y, radians.
    pub fn rotation(&self) -> f64 {
        self.b.atan2(self.a)
    }

    /// Fits the transform of `freedom` to `pairs` by iteratively reweighted least squares, so that a few wrong pairs
    /// have little influence. Returns `None` if the pairs do not determine it.
    pub fn fit(pairs: &[PointPair], freedom: Freedom) -> Option<Self> {
        let mut weights = vec![1.0; pairs.len()];
        let mut best = None;
        for _ in 0..ITERATIONS {
            let fitted = weighted(pairs, &weights, freedom)?;
            let residuals: Vec<f64> = pairs.iter().map(|p| fitted.residual(p)).collect();
            let scale = (OUTLIER_RATIO * median(&mut residuals.clone())).max(LEAST_RESIDUAL_PX);
            for (weight, residual) in weights.iter_mut().zip(&residuals) {
                *weight = 1.0 / (1.0 + (residual / scale).powi(2)).powi(2);
            }
            best = Some(fitted);
        }
        best
    }

    /// Returns the distance between the image of a pair's point and the point that it corresponds to, px.
    pub fn residual(&self, pair: &PointPair) -> f64 {
        let there = self.apply(pair.from);
        (there.x_px - pair.to.x_px).hypot(there.y_px - pair.to.y_px)
    }
}

fn weighted(pairs: &[PointPair], weights: &[f64], freedom: Freedom) -> Option<Similarity> {
    let sum: f64 = weights.iter().sum();
    if pairs.is_empty() || sum <= 0.0 {
        return None;
    }
    let mean = |of: &dyn Fn(&PointPair) -> f64| {
        pairs
            .iter()
            .zip(weights)
            .map(|(p, w)| w * of(p))
            .sum::<f64>()
            / sum
    };
    // About the centroid, shift and linear part are independent.
    let (cx, cy) = (mean(&|p| p.from.x_px), mean(&|p| p.from.y_px));
    let (tx, ty) = (mean(&|p| p.to.x_px), mean(&|p| p.to.y_px));
    let (a, b) = match freedom {
        Freedom::Shift => (1.0, 0.0),
        Freedom::Similarity => {
            let mut matrix = DMatrix::zeros(2, 2);
            let mut right = DVector::zeros(2);
            for (pair, weight) in pairs.iter().zip(weights) {
                let (x, y) = (pair.from.x_px - cx, pair.from.y_px - cy);
                let (u, v) = (pair.to.x_px - tx, pair.to.y_px - ty);
                let square = weight * (x * x + y * y);
                matrix[(0, 0)] += square;
                matrix[(1, 1)] += square;
                right[0] += weight * (x * u + y * v);
                right[1] += weight * (x * v - y * u);
            }
            if matrix[(0, 0)] <= 0.0 {
                return None;
            }
            let solved = matrix.lu().solve(&right)?;
            (solved[0], solved[1])
        }
    };
    Some(Similarity {
        a,
        b,
        shift_px: [tx - a * cx + b * cy, ty - b * cx - a * cy],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_found_among_wrong_pairs() {
        let truth = Similarity {
            a: 1.02 * 0.01_f64.cos(),
            b: 1.02 * 0.01_f64.sin(),
            shift_px: [5.25, -3.5],
        };
        let mut pairs: Vec<PointPair> = (0..30)
            .map(|k| {
                let from = ImagePoint::new(f64::from(k * 37 % 200), f64::from(k * 53 % 150));
                PointPair {
                    from,
                    to: truth.apply(from),
                }
            })
            .collect();
        for pair in pairs.iter_mut().take(4) {
            pair.to.x_px += 12.0;
        }
        let found = Similarity::fit(&pairs, Freedom::Similarity).expect("determined");
        assert!((found.scale() - 1.02).abs() < 1e-4, "{found:?}");
        assert!((found.rotation() - 0.01).abs() < 1e-4, "{found:?}");
        let back = found
            .inverse()
            .apply(found.apply(ImagePoint::new(70.0, 20.0)));
        assert!((back.x_px - 70.0).abs() < 1e-9 && (back.y_px - 20.0).abs() < 1e-9);
        let twice = found.after(&truth).apply(ImagePoint::new(70.0, 20.0));
        let want = found.apply(truth.apply(ImagePoint::new(70.0, 20.0)));
        assert!((twice.x_px - want.x_px).hypot(twice.y_px - want.y_px) < 1e-9);
        assert!(Similarity::fit(&[], Freedom::Shift).is_none());
    }
}
