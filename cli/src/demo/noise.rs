//! Deterministic noise: the same plate on every machine.
//!
//! The noise is a function of the position, not a sequence of a generator: lattice points are visited in any order, and
//! several times.

/// Returns a number in 0..1, a hash of three integers.
pub(super) fn hash(x: i64, y: i64, salt: u64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ salt.wrapping_mul(0x1656_67b1_9e37_79f9);
    h ^= h >> 29;
    h = h.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h ^= h >> 32;
    h = h.wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^= h >> 29;
    (h >> 11) as f64 / (1u64 << 53) as f64
}

/// Returns value noise in 0..1 with features of size one.
pub(super) fn smooth(x: f64, y: f64, salt: u64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v) = (ease(x - column), ease(y - row));
    let (column, row) = (column as i64, row as i64);
    let corner = |i: i64, j: i64| hash(column + i, row + j, salt);
    let top = corner(0, 0) * (1.0 - u) + corner(1, 0) * u;
    let bottom = corner(0, 1) * (1.0 - u) + corner(1, 1) * u;
    top * (1.0 - v) + bottom * v
}

/// Returns value noise of three octaves in 0..1.
pub(super) fn cloudy(x: f64, y: f64, salt: u64) -> f64 {
    (smooth(x, y, salt) * 4.0
        + smooth(x * 2.1, y * 2.1, salt + 1) * 2.0
        + smooth(x * 4.3, y * 4.3, salt + 2))
        / 7.0
}

/// Returns a standard normal deviate (Box and Muller), a hash of two integers.
pub(super) fn normal(seed: u64, index: u64) -> f64 {
    let uniform = |salt| hash(index as i64, seed as i64, salt);
    let radius = (-2.0 * (1.0 - uniform(1)).ln()).sqrt();
    radius * (std::f64::consts::TAU * uniform(2)).cos()
}
