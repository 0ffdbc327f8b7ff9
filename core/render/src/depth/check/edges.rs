//! Detection of depth filtered at edges: multiplied by alpha, or averaged with a background of zero.
//!
//! Such pixels lie in front of the surface and give it a rim of wrong blur.

use super::super::DepthConvention;
use super::{DepthCheck, DepthFinding, DepthProblem, Severity};
use rayon::prelude::*;

/// Coverages at which the product differs clearly from the surface's depth.
const PARTIAL: std::ops::RangeInclusive<f32> = 0.15..=0.85;
/// Least coverage of the surface itself.
const COVERED: f32 = 0.995;
/// Largest distance from an edge pixel to its surface, px.
const REACH: usize = 3;
/// Tolerance of ratios of depths.
const CLOSE: f32 = 0.08;
/// Least number of edge pixels.
const MIN_PIXELS: usize = 40;
/// Least share of them that are products.
const MIN_SHARE: f64 = 0.6;

/// Finds depth mixed with zero at edges.
pub(super) fn filtered(check: &DepthCheck) -> Option<DepthFinding> {
    let by_alpha = check.alpha.map(|alpha| against_alpha(check, alpha));
    by_alpha.and_then(EdgeCounts::finding).or_else(|| {
        // Inverse depth of zero is infinity, which mixtures may well approach.
        if !matches!(check.convention, DepthConvention::Distance { .. }) {
            return None;
        }
        against_empty(check).finding()
    })
}

/// Counts of edge pixels.
#[derive(Default)]
struct EdgeCounts {
    pixels: usize,
    /// Those whose depth is a fraction of the surface's.
    products: usize,
}

impl EdgeCounts {
    fn finding(self) -> Option<DepthFinding> {
        let Self { pixels, products } = self;
        let share = products as f64 / pixels.max(1) as f64;
        (pixels >= MIN_PIXELS && share >= MIN_SHARE).then(|| DepthFinding {
        problem: DepthProblem::Premultiplied { pixels, share },
        severity: Severity::Warning,
        remedy:
            "divide depth by its alpha, or render it without filtering (the nearest sample of a pixel)"
                .to_owned(),
    })
    }
}

/// Counts partly covered pixels beside a covered one; the depth of products is its depth times their alpha.
fn against_alpha(check: &DepthCheck, alpha: &[f32]) -> EdgeCounts {
    counts_of_rows(check, |counts, row| {
        for column in 0..check.width {
            let index = row * check.width + column;
            let (depth, cover) = (check.samples[index], alpha[index]);
            if !PARTIAL.contains(&cover) || !depth.is_finite() {
                continue;
            }
            let Some(surface) = surface_beside(check, alpha, column, row) else {
                continue;
            };
            counts.pixels += 1;
            counts.products += usize::from((depth / surface - cover).abs() < CLOSE);
        }
    })
}

/// Returns the counts of all rows; `add` counts the pixels of one.
fn counts_of_rows(check: &DepthCheck, add: impl Fn(&mut EdgeCounts, usize) + Sync) -> EdgeCounts {
    let rows = (0..check.height).into_par_iter();
    let counts = rows.fold(EdgeCounts::default, |mut counts, row| {
        add(&mut counts, row);
        counts
    });
    counts.reduce(EdgeCounts::default, |a, b| EdgeCounts {
        pixels: a.pixels + b.pixels,
        products: a.products + b.products,
    })
}

/// Returns the depth of the nearest covered pixel within reach.
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

/// Counts pixels between an empty one and a smooth surface; products with an unknown coverage lie clearly in front of
/// it.
fn against_empty(check: &DepthCheck) -> EdgeCounts {
    counts_of_rows(check, |counts, row| {
        let mut look = |empty: f32, edge: f32, inner: f32, deep: f32| {
            if empty != 0.0 || edge == 0.0 || inner == 0.0 {
                return;
            }
            let smooth = (inner / deep - 1.0).abs() < CLOSE / 2.0;
            let ratio = edge / inner;
            if smooth && ratio.is_finite() {
                counts.pixels += 1;
                counts.products += usize::from((CLOSE..1.0 - CLOSE).contains(&ratio));
            }
        };
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
    })
}
