//! The plugin's icon: a point of light as a lens draws it off its axis, with coma and rims of colour.

use super::png::png;

/// Columns and rows.
const SIZE: u32 = 128;
/// Samples of a pixel along each axis.
const FINE: u32 = 4;

/// The icon as a PNG file.
pub(super) fn icon() -> Vec<u8> {
    let mut rgba = Vec::with_capacity((SIZE * SIZE * 4) as usize);
    for y in 0..SIZE {
        for x in 0..SIZE {
            rgba.extend(pixel(x, y));
        }
    }
    png(SIZE, &rgba)
}

fn pixel(x: u32, y: u32) -> [u8; 4] {
    let mut sum = [0.0_f64; 4];
    for k in 0..FINE * FINE {
        let at = |pixel: u32, part: u32| {
            let fine = f64::from(pixel) + (f64::from(part) + 0.5) / f64::from(FINE);
            fine / f64::from(SIZE) * 2.0 - 1.0
        };
        let (u, v) = (at(x, k % FINE), at(y, k / FINE));
        let inside = f64::from(u8::from(within_plate(u, v)));
        for (total, own) in sum.iter_mut().zip(light(u, v)) {
            *total += inside * own;
        }
        sum[3] += inside;
    }
    let covered = sum[3].max(1e-9);
    let byte = |value: f64| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let colour = |c: usize| byte((sum[c] / covered).powf(1.0 / 2.2));
    let count = f64::from(FINE * FINE);
    [colour(0), colour(1), colour(2), byte(sum[3] / count)]
}

/// A square with round corners.
fn within_plate(u: f64, v: f64) -> bool {
    let beyond = |w: f64| (w.abs() - 0.72).max(0.0);
    beyond(u).hypot(beyond(v)) < 0.26
}

/// Red, green and blue at a place of the plate.
fn light(u: f64, v: f64) -> [f64; 3] {
    // Along the line to the axis, and across it.
    let (along, across) = ((u + v) / 2.0_f64.sqrt(), (v - u) / 2.0_f64.sqrt());
    let mut rgb = [0.012, 0.014, 0.020];
    for (k, total) in rgb.iter_mut().enumerate() {
        let shift = 0.07 * (k as f64 - 1.0);
        // Zones of the pupil land as circles that grow and move away: coma is their sum.
        for zone in 1..=12 {
            let share = f64::from(zone) / 12.0;
            let radius = 0.36 * share * share;
            let middle = -0.52 + shift + 0.80 * share * share;
            let off = (along - middle).hypot(across) - radius;
            *total += 0.11 * (-(off / 0.035).powi(2)).exp();
        }
        let core = (along + 0.52 - shift).hypot(across);
        *total += 0.9 * (-(core / 0.09).powi(2)).exp();
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_are_clear_and_the_point_is_bright() {
        assert_eq!(pixel(0, 0)[3], 0);
        let at = |along: f64| {
            let u = along / 2.0_f64.sqrt();
            ((u + 1.0) / 2.0 * f64::from(SIZE)) as u32
        };
        let bright = pixel(at(-0.52), at(-0.52));
        assert!(bright[3] == 255 && bright[1] > 200, "{bright:?}");
        let dark = pixel(SIZE - 20, 20);
        assert!(
            dark[3] == 255 && dark[..3].iter().all(|v| *v < 60),
            "{dark:?}"
        );
        // Signature, header, data, end.
        assert_eq!(icon().len(), 8 + 25 + 12 + 12 + 2 + 4 + 2 * 5 + 128 * 513);
    }
}
