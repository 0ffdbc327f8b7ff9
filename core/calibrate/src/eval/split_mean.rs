//! Means over random splits, with confidence intervals.

/// Mean over splits of the mean M_FB over test tiles.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SplitMean {
    /// The mean, dB.
    pub mean_db: f64,
    /// Half width of the 95 % confidence interval of the mean, dB, by Student's t over splits; `None` for a
    /// single split. Splits share tiles, so it covers the choice of training tiles only.
    #[serde(rename = "half_width_95_db")]
    pub half_width_db: Option<f64>,
    /// The worst split, dB.
    pub worst_db: f64,
}

impl SplitMean {
    /// Averages one mean per split; `None` without any.
    pub(super) fn of(means: &[f64]) -> Option<Self> {
        if means.is_empty() {
            return None;
        }
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let half_width_db = (means.len() > 1).then(|| {
            let square: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
            student_t(means.len() - 1) * (square / (count - 1.0) / count).sqrt()
        });
        Some(Self {
            mean_db: mean,
            half_width_db,
            worst_db: means.iter().copied().fold(f64::INFINITY, f64::min),
        })
    }
}

/// Returns the 97.5 % quantile of Student's t with `freedom` degrees of freedom, within 0.001.
fn student_t(freedom: usize) -> f64 {
    const FEW: [f64; 8] = [
        12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060,
    ];
    if let Some(t) = freedom.checked_sub(1).and_then(|k| FEW.get(k)) {
        return *t;
    }
    // Expansion about the normal distribution (Abramowitz and Stegun 26.7.5).
    let (z, n) = (1.959_964_f64, freedom as f64);
    let g1 = (z.powi(3) + z) / 4.0;
    let g2 = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let g3 = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + g1 / n + g2 / (n * n) + g3 / (n * n * n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn students_t_is_that_of_the_tables() {
        for (freedom, want) in [
            (1, 12.706),
            (8, 2.306),
            (9, 2.262),
            (19, 2.093),
            (60, 2.000),
        ] {
            assert!((student_t(freedom) - want).abs() < 1e-3, "{freedom}");
        }
    }

    #[test]
    fn the_interval_is_that_of_the_mean() {
        let got = SplitMean::of(&[1.0, 2.0, 3.0]).expect("some");
        assert_eq!((got.mean_db, got.worst_db), (2.0, 1.0));
        // Standard deviation 1 over three splits, two degrees of freedom.
        let want = 4.3027 / 3.0_f64.sqrt();
        assert!((got.half_width_db.expect("several") - want).abs() < 1e-12);
        assert_eq!(SplitMean::of(&[5.0]).expect("one").half_width_db, None);
        assert_eq!(SplitMean::of(&[]), None);
    }
}
