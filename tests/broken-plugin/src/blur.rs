//! The box.

/// Shares of the pixels that a box of half-width `half` covers, from the middle outwards.
pub(crate) fn weights(half: f64) -> Vec<f32> {
    let half = half.max(0.5);
    let mut all = Vec::new();
    loop {
        // How much of the pixel that far out lies in the box.
        let share = (half - (all.len() as f64 - 0.5)).clamp(0.0, 1.0);
        if share <= 0.0 {
            break;
        }
        all.push(share as f32);
    }
    let sum = all[0] + 2.0 * all[1..].iter().sum::<f32>();
    for weight in &mut all {
        *weight /= sum;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::weights;

    #[test]
    fn weights_add_up_to_one() {
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
