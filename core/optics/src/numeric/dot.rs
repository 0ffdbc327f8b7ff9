//! The dot product of vectors.

/// Returns the sum of the products of `a` and `b`, added in order; entries beyond the shorter one do not count.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
