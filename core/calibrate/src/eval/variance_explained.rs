//! Variance of a moment over the field explained by a prediction (MVarFrac of the paper).

/// Explained variance, per cent.
///
/// 100 is perfect; 0 is no better than the mean of the measured values; negative is worse. `None` where the
/// measured values do not vary.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct VarianceExplained {
    /// Over all tiles: 100 (1 - mean(E²) / Var(M)) with E = measured - predicted and the population variance.
    /// A constant error counts.
    #[serde(rename = "all_percent")]
    pub full: Option<f64>,
    /// The same without the ceil(0.05 (N - 1)) most negative and most positive E; Var(M) is of the remaining
    /// tiles.
    #[serde(rename = "middle_90_percent")]
    pub middle: Option<f64>,
}

impl VarianceExplained {
    /// Computes the explained variance of pairs (measured, predicted), one per tile.
    pub fn of(pairs: &[(f64, f64)]) -> Self {
        let full = explained(pairs.iter());
        let mut by_error = pairs.to_vec();
        by_error.sort_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)));
        // ceil(0.05 (N - 1)) in integers.
        let dropped = pairs.len().saturating_sub(1).div_ceil(20);
        let kept = by_error.len().saturating_sub(2 * dropped);
        Self {
            full,
            middle: explained(by_error.iter().skip(dropped).take(kept)),
        }
    }
}

fn explained<'a>(pairs: impl ExactSizeIterator<Item = &'a (f64, f64)> + Clone) -> Option<f64> {
    let count = pairs.len() as f64;
    let mean = pairs.clone().map(|p| p.0).sum::<f64>() / count;
    let variance = pairs.clone().map(|p| (p.0 - mean).powi(2)).sum::<f64>() / count;
    let square = pairs.map(|p| (p.0 - p.1).powi(2)).sum::<f64>() / count;
    (variance > 0.0).then(|| 100.0 * (1.0 - square / variance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hand_made_numbers() {
        // Mean 2.5, variance 1.25; errors 1, 0, 0, -1: mean square 0.5.
        let got = VarianceExplained::of(&[(1.0, 0.0), (2.0, 2.0), (3.0, 3.0), (4.0, 5.0)]);
        assert!((got.full.expect("varies") - 60.0).abs() < 1e-12);
        // Dropping one at each end leaves the two exact pairs.
        assert_eq!(got.middle, Some(100.0));
    }

    #[test]
    fn a_constant_error_counts() {
        let got = VarianceExplained::of(&[(1.0, 2.0), (2.0, 3.0), (3.0, 4.0)]);
        // Variance 2/3, mean square 1. The middle is a single tile, which does not vary.
        assert!((got.full.expect("varies") + 50.0).abs() < 1e-12);
        assert_eq!(got.middle, None);
    }

    #[test]
    fn five_per_cent_are_dropped_at_each_end() {
        // 100 tiles: the 5 large errors of each sign are exactly those dropped.
        let pairs: Vec<(f64, f64)> = (0..100)
            .map(|k| {
                let m = f64::from(k);
                let error = match k % 10 {
                    0 if k < 50 => 1000.0,
                    0 => -1000.0,
                    _ => 0.0,
                };
                (m, m - error)
            })
            .collect();
        let got = VarianceExplained::of(&pairs);
        assert!(got.full.expect("varies") < 0.0);
        assert_eq!(got.middle, Some(100.0));
    }

    #[test]
    fn constant_measurements_give_none() {
        assert_eq!(VarianceExplained::of(&[(1.0, 1.0)]).full, None);
        assert_eq!(VarianceExplained::of(&[]).full, None);
        assert_eq!(VarianceExplained::of(&[(1.0, 1.0), (1.0, 0.5)]).full, None);
    }
}
