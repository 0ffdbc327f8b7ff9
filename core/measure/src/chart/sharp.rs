//! A sharp photograph as the chart of a blurred one.

use crate::photograph::Photograph;

/// Returns the plane of `channel`, with a value at every pixel. In mosaics, green is interpolated along the direction of the
/// smaller gradient, and other colours by their difference to green (Hamilton and Adams 1997).
pub fn sharp_plane(photo: &Photograph, channel: usize) -> Vec<f32> {
    let plane = &photo.planes[photo.plane_of(channel)];
    if photo.mosaic.is_none() {
        return plane.clone();
    }
    let green = photo.reference_channel();
    let of_green = directed(photo, green);
    if channel == green {
        return of_green;
    }
    let difference: Vec<f32> = plane.iter().zip(&of_green).map(|(v, g)| v - g).collect();
    let mut result = of_green;
    for y in 0..photo.height {
        for x in 0..photo.width {
            result[y * photo.width + x] += nearest_mean(photo, channel, &difference, x, y);
        }
    }
    result
}

/// Returns `channel` with missing pixels interpolated along rows or columns.
fn directed(photo: &Photograph, channel: usize) -> Vec<f32> {
    let plane = &photo.planes[photo.plane_of(channel)];
    let (width, height) = (photo.width as i64, photo.height as i64);
    let at = |x: i64, y: i64| {
        // Mirrored about the border pixel, which keeps the pattern of the mosaic.
        let mirror = |v: i64, most: i64| {
            if v < 0 {
                -v
            } else if v >= most {
                2 * most - 2 - v
            } else {
                v
            }
        };
        let (x, y) = (mirror(x, width), mirror(y, height));
        f64::from(plane[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize])
    };
    let mut result = plane.clone();
    for y in 0..height {
        for x in 0..width {
            if photo.covers(channel, x as usize, y as usize) {
                continue;
            }
            let second = |dx: i64, dy: i64| {
                2.0 * at(x, y) - at(x - 2 * dx, y - 2 * dy) - at(x + 2 * dx, y + 2 * dy)
            };
            let first = |dx: i64, dy: i64| (at(x - dx, y - dy) - at(x + dx, y + dy)).abs();
            let estimate = |dx: i64, dy: i64| {
                (at(x - dx, y - dy) + at(x + dx, y + dy)) / 2.0 + second(dx, dy) / 4.0
            };
            let across = first(1, 0) + second(1, 0).abs();
            let down = first(0, 1) + second(0, 1).abs();
            let value = if across < down {
                estimate(1, 0)
            } else if down < across {
                estimate(0, 1)
            } else {
                (estimate(1, 0) + estimate(0, 1)) / 2.0
            };
            result[(y * width + x) as usize] = value as f32;
        }
    }
    result
}

/// Returns the mean of `values` over the nearest pixels of `channel`.
fn nearest_mean(photo: &Photograph, channel: usize, values: &[f32], x: usize, y: usize) -> f32 {
    if photo.covers(channel, x, y) {
        return values[y * photo.width + x];
    }
    let (mut sum, mut weight) = (0.0, 0.0);
    for v in y.saturating_sub(1)..(y + 2).min(photo.height) {
        for u in x.saturating_sub(1)..(x + 2).min(photo.width) {
            if photo.covers(channel, u, v) {
                sum += values[v * photo.width + u];
                weight += 1.0;
            }
        }
    }
    sum / f32::max(weight, 1.0)
}
