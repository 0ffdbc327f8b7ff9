//! Robust statistics: median, median absolute deviation, quantiles.

/// Ratio of a standard deviation to the median absolute deviation of a normal distribution.
const SIGMA_OVER_MAD: f64 = 1.4826;

/// Returns the median; zero for no values.
pub fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// Returns the value below which a `share` of `values` lies; zero for no values.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = ((values.len() - 1) as f64 * share).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(index, f64::total_cmp);
    *value
}

/// Returns the standard deviation of a normal distribution with the median absolute deviation of `values`.
pub fn scatter(values: &[f64]) -> f64 {
    let mut copy = values.to_vec();
    let middle = median(&mut copy);
    copy.iter_mut().for_each(|v| *v = (*v - middle).abs());
    SIGMA_OVER_MAD * median(&mut copy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_do_not_count() {
        let mut values = [3.0, 1.0, 2.0, 1e9, 2.5];
        assert_eq!(median(&mut values), 2.5);
        assert_eq!(quantile(&mut values, 0.0), 1.0);
        assert!(scatter(&values) < 1.0);
        assert_eq!(median(&mut []), 0.0);
    }
}
