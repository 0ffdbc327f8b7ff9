//! Weighting of residuals over spatial frequency.

/// Weighting of the residual pixels of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Metric {
    /// White: all pixels alike. The maximum-likelihood choice where noise dominates.
    Pixels,
    /// Weighted by the power spectrum of natural images, 1 / f², as the effect of a PSF error on an image is.
    /// The choice where model error dominates over noise.
    #[default]
    NaturalSpectrum,
}

impl Metric {
    /// Appends to `out` the weighted samples of a tile, whose plain sum of squares is the weighted misfit.
    ///
    /// `samples` hold `columns` values per pixel of a `width` x `height` tile. The 1 / f² weighting is
    /// approximated by a binomial pyramid: each level is the previous one blurred and halved, with weights
    /// such that the levels holding a frequency f add up to about 1 / f².
    pub(super) fn apply(
        self,
        samples: &[f64],
        columns: usize,
        width: usize,
        height: usize,
        out: &mut Vec<f64>,
    ) {
        out.clear();
        if self == Self::Pixels {
            out.extend_from_slice(samples);
            return;
        }
        let mut level = samples.to_vec();
        let (mut w, mut h) = (width, height);
        // A level has a quarter of the samples and stands for four times the power.
        let mut weight = 1.0;
        loop {
            out.extend(level.iter().map(|v| v * weight));
            if w.max(h) <= 2 {
                return;
            }
            (level, w, h) = halved(&level, columns, w, h);
            weight *= GROWTH;
        }
    }
}

/// Amplitude weight of a level relative to the one before: sqrt(4 * 4), for a quarter of the samples and half
/// the frequency.
const GROWTH: f64 = 4.0;

/// Blurs with (1, 3, 3, 1) / 8 along both axes and keeps every second sample, with zeros beyond the edges.
/// The sum over samples falls to a quarter.
fn halved(level: &[f64], columns: usize, width: usize, height: usize) -> (Vec<f64>, usize, usize) {
    let (w, h) = (width / 2 + 1, height / 2 + 1);
    let taps = |k: usize, size: usize| {
        // Sample k of the half-size level lies between samples 2 k - 1 and 2 k.
        [(0, 0.125), (1, 0.375), (2, 0.375), (3, 0.125)]
            .into_iter()
            .filter_map(move |(t, weight)| {
                let at = (2 * k + t).checked_sub(2)?;
                (at < size).then_some((at, weight))
            })
    };
    let mut across = vec![0.0; w * height * columns];
    for row in 0..height {
        for column in 0..w {
            let target = (row * w + column) * columns;
            for (at, weight) in taps(column, width) {
                let source = (row * width + at) * columns;
                for k in 0..columns {
                    across[target + k] += weight * level[source + k];
                }
            }
        }
    }
    let mut down = vec![0.0; w * h * columns];
    for row in 0..h {
        let target = row * w * columns;
        for (at, weight) in taps(row, height) {
            let source = at * w * columns;
            for k in 0..w * columns {
                down[target + k] += weight * across[source + k];
            }
        }
    }
    (down, w, h)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_detail_counts_as_its_frequency_says() {
        let size = 64;
        let wave = |period: f64| -> f64 {
            let samples: Vec<f64> = (0..size * size)
                .map(|k| ((k % size) as f64 / period * std::f64::consts::TAU).sin())
                .collect();
            let mut out = Vec::new();
            Metric::NaturalSpectrum.apply(&samples, 1, size, size, &mut out);
            out.iter().map(|v| v * v).sum()
        };
        for period in [6.0, 9.0, 12.0] {
            let ratio = wave(2.0 * period) / wave(period);
            assert!((2.5..6.5).contains(&ratio), "period {period}: {ratio}");
        }
    }

    #[test]
    fn columns_are_weighed_alike() {
        let samples: Vec<f64> = (0..35).map(|k| f64::from(k * k % 11)).collect();
        let doubled: Vec<f64> = samples.iter().flat_map(|v| [*v, 2.0 * v]).collect();
        let (mut one, mut two) = (Vec::new(), Vec::new());
        Metric::NaturalSpectrum.apply(&samples, 1, 7, 5, &mut one);
        Metric::NaturalSpectrum.apply(&doubled, 2, 7, 5, &mut two);
        for (k, v) in one.iter().enumerate() {
            assert!((two[2 * k] - v).abs() < 1e-12 && (two[2 * k + 1] - 2.0 * v).abs() < 1e-12);
        }
    }
}
