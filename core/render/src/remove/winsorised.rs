//! Winsorised statistics, which a few bright lights or steep edges do not change.

/// Percentile at which magnitudes are limited.
const PERCENTILE: f64 = 0.99;

/// Statistics of many magnitudes, each limited to their 99th percentile.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct WinsorisedStatistics {
    /// The 99th percentile, at which magnitudes are limited.
    pub(super) percentile_99: f64,
    /// Mean of the limited magnitudes.
    pub(super) mean: f64,
    /// Root mean square of the limited magnitudes.
    pub(super) root_mean_square: f64,
}

impl WinsorisedStatistics {
    /// Computes the statistics of the absolute values of `samples`.
    pub(super) fn of_absolute(samples: &[f32]) -> Self {
        Self::new(samples.iter().map(|v| v.abs()).collect())
    }

    /// Computes the statistics of `magnitudes`, which are 0 or more; zeros if there are no magnitudes.
    pub(super) fn new(mut magnitudes: Vec<f32>) -> Self {
        if magnitudes.is_empty() {
            return Self::default();
        }
        let rank = ((magnitudes.len() - 1) as f64 * PERCENTILE) as usize;
        let (_, limit, above) = magnitudes.select_nth_unstable_by(rank, f32::total_cmp);
        let limit = f64::from(*limit);
        let (limited, count) = ((1 + above.len()) as f64, magnitudes.len() as f64);
        let below = || magnitudes[..rank].iter().map(|v| f64::from(*v));
        let mean_square = (below().map(|v| v * v).sum::<f64>() + limited * limit * limit) / count;
        Self {
            percentile_99: limit,
            mean: (below().sum::<f64>() + limited * limit) / count,
            root_mean_square: mean_square.sqrt(),
        }
    }
}
