//! A sharp photograph as the chart of a blurred one.

use crate::photograph::Photograph;

/// Standard deviation of the Gaussian over which differences between colours are averaged, px, and the distance at which it ends.
/// Colours change more slowly than light, and single differences hold the errors of the interpolation of green.
const DIFFERENCE_PX: f32 = 1.7;
const DIFFERENCE_REACH: usize = 4;

/// Returns the plane of `channel`, with a value at every pixel. In mosaics, colours are scaled to the level of green, since only
/// balanced colours differ little in detail. Then green is interpolated along the direction of the smaller gradient, and other
/// colours by their difference to green (Hamilton and Adams 1997).
pub fn sharp_plane(photo: &Photograph, channel: usize) -> Vec<f32> {
    let plane = &photo.planes[photo.plane_of(channel)];
    if photo.mosaic.is_none() {
        return plane.clone();
    }
    let levels: Vec<f32> = (0..photo.channels.len()).map(|c| level(photo, c)).collect();
    let green = photo.reference_channel();
    let balanced: Vec<f32> = (plane.iter().enumerate())
        .map(|(k, value)| {
            let (x, y) = (k % photo.width, k / photo.width);
            let own = (0..levels.len()).find(|c| photo.covers(*c, x, y));
            value * levels[green] / own.map_or(levels[green], |c| levels[c])
        })
        .collect();
    let mut result = directed(photo, &balanced, green);
    if channel != green {
        let difference: Vec<f32> = balanced.iter().zip(&result).map(|(v, g)| v - g).collect();
        for y in 0..photo.height {
            for x in 0..photo.width {
                result[y * photo.width + x] += smooth_mean(photo, channel, &difference, x, y);
            }
        }
    }
    let scale = levels[channel] / levels[green];
    result.iter().map(|v| v * scale).collect()
}

/// Returns the mean of the pixels of `channel`; one where it is not positive.
fn level(photo: &Photograph, channel: usize) -> f32 {
    let plane = &photo.planes[photo.plane_of(channel)];
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (k, value) in plane.iter().enumerate() {
        if photo.covers(channel, k % photo.width, k / photo.width) {
            sum += f64::from(*value);
            count += 1.0;
        }
    }
    let mean = sum / count.max(1.0);
    if mean > 0.0 { mean as f32 } else { 1.0 }
}

/// Returns `channel` of `plane` with missing pixels interpolated along rows or columns.
fn directed(photo: &Photograph, plane: &[f32], channel: usize) -> Vec<f32> {
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
    let mut result = plane.to_vec();
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

/// Returns the mean of `values` over the pixels of `channel` around a pixel, the nearer ones more.
fn smooth_mean(photo: &Photograph, channel: usize, values: &[f32], x: usize, y: usize) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.0);
    let near = |at: usize, size: usize| {
        at.saturating_sub(DIFFERENCE_REACH)..(at + DIFFERENCE_REACH + 1).min(size)
    };
    for v in near(y, photo.height) {
        for u in near(x, photo.width) {
            if photo.covers(channel, u, v) {
                let square = (u.abs_diff(x).pow(2) + v.abs_diff(y).pow(2)) as f32;
                let own = (-0.5 * square / DIFFERENCE_PX.powi(2)).exp();
                sum += own * values[v * photo.width + u];
                weight += own;
            }
        }
    }
    if weight > 0.0 { sum / weight } else { 0.0 }
}
