//! Depth that was filtered at edges: multiplied by alpha, or averaged with a background of zero. Such
//! pixels hang in the air before the surface and draw a rim of wrong blur.

use super::super::DepthConvention;
use super::{DepthCheck, DepthFinding, DepthProblem, Severity};

/// Coverages that can tell a product from the surface.
const PARTIAL: std::ops::RangeInclusive<f32> = 0.15..=0.85;
/// Coverage of the surface itself.
const COVERED: f32 = 0.995;
/// How far from an edge its surface may be, px.
const REACH: usize = 3;
/// Ratios of depths this close are equal.
const CLOSE: f32 = 0.08;
/// Edge pixels that must be seen.
const LEAST_PIXELS: usize = 40;
/// Share of them that must be products.
const LEAST_SHARE: f64 = 0.6;

/// Whether depth is mixed with zero at edges.
pub(super) fn filtered(check: &DepthCheck) -> Option<DepthFinding> {
    let (pixels, products) = match check.alpha {
        Some(alpha) => against_alpha(check, alpha),
        None => (0, 0),
    };
    let by_alpha = finding(pixels, products);
    by_alpha.or_else(|| {
        // An inverse of zero is infinity, which a mixture may well approach.
        if !matches!(check.convention, DepthConvention::Distance { .. }) {
            return None;
        }
        let (pixels, products) = against_empty(check);
        finding(pixels, products)
    })
}

fn finding(pixels: usize, products: usize) -> Option<DepthFinding> {
    let share = products as f64 / pixels.max(1) as f64;
    (pixels >= LEAST_PIXELS && share >= LEAST_SHARE).then(|| DepthFinding {
        problem: DepthProblem::Premultiplied { pixels, share },
        severity: Severity::Warning,
        remedy:
            "divide depth by its alpha, or render it without filtering (the nearest sample of a pixel)"
                .to_owned(),
    })
}

/// Partly covered pixels beside a covered one, and those whose depth is its depth times their alpha.
fn against_alpha(check: &DepthCheck, alpha: &[f32]) -> (usize, usize) {
    let (mut pixels, mut products) = (0, 0);
    for row in 0..check.height {
        for column in 0..check.width {
            let index = row * check.width + column;
            let (depth, cover) = (check.samples[index], alpha[index]);
            if !PARTIAL.contains(&cover) || !depth.is_finite() {
                continue;
            }
            let Some(surface) = surface_beside(check, alpha, column, row) else {
                continue;
            };
            pixels += 1;
            products += usize::from((depth / surface - cover).abs() < CLOSE);
        }
    }
    (pixels, products)
}

/// Depth of the nearest covered pixel.
fn surface_beside(check: &DepthCheck, alpha: &[f32], column: usize, row: usize) -> Option<f32> {
    let range = |at: usize, size: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(size);
    let mut best: Option<(usize, f32)> = None;
    for y in range(row, check.height) {
        for x in range(column, check.width) {
            let index = y * check.width + x;
            let depth = check.samples[index];
            let distance = x.abs_diff(column).pow(2) + y.abs_diff(row).pow(2);
            let nearer = best.is_none_or(|(least, _)| distance < least);
            if nearer && alpha[index] >= COVERED && depth.is_finite() && depth != 0.0 {
                best = Some((distance, depth));
            }
        }
    }
    best.map(|(_, depth)| depth)
}

/// Pixels between emptiness and a smooth surface, and those that lie clearly before it: a product with
/// coverages that nobody wrote down.
fn against_empty(check: &DepthCheck) -> (usize, usize) {
    let (mut pixels, mut products) = (0, 0);
    let mut look = |empty: f32, edge: f32, inner: f32, deep: f32| {
        let smooth = (inner / deep - 1.0).abs() < CLOSE / 2.0;
        let ratio = edge / inner;
        if empty == 0.0 && edge != 0.0 && inner != 0.0 && smooth && ratio.is_finite() {
            pixels += 1;
            products += usize::from((CLOSE..1.0 - CLOSE).contains(&ratio));
        }
    };
    for row in 0..check.height {
        for column in 0..check.width {
            if column + 3 < check.width {
                let [a, b, c, d] = std::array::from_fn(|k| check.sample(column + k, row));
                look(a, b, c, d);
                look(d, c, b, a);
            }
            if row + 3 < check.height {
                let [a, b, c, d] = std::array::from_fn(|k| check.sample(column, row + k));
                look(a, b, c, d);
                look(d, c, b, a);
            }
        }
    }
    (pixels, products)
}
