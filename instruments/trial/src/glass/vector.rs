//! Vectors in space.

/// x right, y down as in the frame, z along the axis from the scene to the sensor.
pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns a + s b.
pub(super) fn along(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn unit(a: Vector) -> Vector {
    let scale = 1.0 / dot(a, a).sqrt();
    a.map(|v| v * scale)
}

/// Returns `a` turned by `angle` radians about the unit vector `axis` (Rodrigues).
pub(super) fn turned(a: Vector, axis: Vector, angle: f64) -> Vector {
    let (sin, cos) = libm::sincos(angle);
    let part = dot(axis, a) * (1.0 - cos);
    let side = cross(axis, a);
    std::array::from_fn(|i| a[i] * cos + side[i] * sin + axis[i] * part)
}
