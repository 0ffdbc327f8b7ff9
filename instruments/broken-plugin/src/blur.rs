//! The weights of the box.

/// Returns the weights of pixels by their distance from the centre, for a box of half-width `half` in pixels. Partly
/// covered pixels have a smaller weight; all weights, counted on both sides, sum to 1.
pub(crate) fn weights(half: f64) -> Vec<f32> {
    let half = half.max(0.5);
    let mut weights = Vec::new();
    loop {
        let coverage = (half - (weights.len() as f64 - 0.5)).clamp(0.0, 1.0);
        if coverage <= 0.0 {
            break;
        }
        weights.push(coverage as f32);
    }
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
    for weight in &mut weights {
        *weight /= sum;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::weights;

    #[test]
    fn weights_sum_to_one() {
        assert_eq!(weights(0.5), [1.0]);
        assert_eq!(weights(0.1), [1.0]);
        for half in [0.7, 1.5, 4.5, 4.25] {
            let all = weights(half);
            let sum = all[0] + 2.0 * all[1..].iter().sum::<f32>();
            assert!((sum - 1.0).abs() < 1e-6);
        }
        assert_eq!(weights(4.5).len(), 5);
    }
}
