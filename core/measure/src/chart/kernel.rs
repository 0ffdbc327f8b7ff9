//! Kernels of blocks: PSFs on a square of whole pixels.

/// Returns the centroid of a kernel relative to its central sample.
pub(super) fn centroid(kernel: &[f64], side: usize) -> [f64; 2] {
    let half = (side / 2) as f64;
    let mut sum = [0.0; 2];
    for (k, value) in kernel.iter().enumerate() {
        sum[0] += value * ((k % side) as f64 - half);
        sum[1] += value * ((k / side) as f64 - half);
    }
    sum
}

/// Returns the kernel with `variance` added along both axes, by passes of three samples.
pub(super) fn widened(kernel: &[f64], side: usize, variance: f64) -> Vec<f64> {
    // A pass may add a quarter of a px² without ringing.
    let passes = (variance / 0.25).ceil().max(1.0);
    let outer = variance / passes / 2.0;
    let pass = |values: &[f64], stride: usize| -> Vec<f64> {
        let sample = |k: usize| {
            let along = k / stride % side;
            let before = if along > 0 { values[k - stride] } else { 0.0 };
            let after = if along + 1 < side {
                values[k + stride]
            } else {
                0.0
            };
            outer * (before + after) + (1.0 - 2.0 * outer) * values[k]
        };
        (0..side * side).map(sample).collect()
    };
    let mut values = kernel.to_vec();
    for _ in 0..passes as usize {
        values = pass(&pass(&values, 1), side);
    }
    values
}
