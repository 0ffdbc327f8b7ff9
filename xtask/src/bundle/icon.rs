//! The plugin's icon: the image of an off-axis point light with coma and lateral chromatic aberration.

/// Width and height, px.
const SIZE: u32 = 128;
/// Samples of a pixel along each axis.
const SUBSAMPLES: u32 = 4;

/// The icon as a PNG file.
pub(super) fn png() -> Vec<u8> {
    let mut rgba = Vec::with_capacity((SIZE * SIZE * 4) as usize);
    for y in 0..SIZE {
        for x in 0..SIZE {
            rgba.extend(pixel(x, y));
        }
    }
    encode(&rgba).expect("writing to memory does not fail")
}

fn encode(rgba: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SIZE, SIZE);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(rgba)?;
    Ok(file)
}

fn pixel(x: u32, y: u32) -> [u8; 4] {
    let mut sum = [0.0_f64; 4];
    for k in 0..SUBSAMPLES * SUBSAMPLES {
        let coordinate = |pixel: u32, sample: u32| {
            let px = f64::from(pixel) + (f64::from(sample) + 0.5) / f64::from(SUBSAMPLES);
            px / f64::from(SIZE) * 2.0 - 1.0
        };
        let u = coordinate(x, k % SUBSAMPLES);
        let v = coordinate(y, k / SUBSAMPLES);
        if is_inside(u, v) {
            for (total, value) in sum.iter_mut().zip(light(u, v)) {
                *total += value;
            }
            sum[3] += 1.0;
        }
    }
    let covered = sum[3].max(1e-9);
    let byte = |value: f64| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let colour = |c: usize| byte((sum[c] / covered).powf(1.0 / 2.2));
    let samples = f64::from(SUBSAMPLES * SUBSAMPLES);
    [colour(0), colour(1), colour(2), byte(sum[3] / samples)]
}

/// Whether a point is inside the icon's square, whose corners are round.
fn is_inside(u: f64, v: f64) -> bool {
    let beyond = |w: f64| (w.abs() - 0.72).max(0.0);
    beyond(u).hypot(beyond(v)) < 0.26
}

/// Red, green and blue at a point, both coordinates from -1 to 1.
fn light(u: f64, v: f64) -> [f64; 3] {
    // Along the diagonal, which is the direction to the optical axis, and across it.
    let along = (u + v) / 2.0_f64.sqrt();
    let across = (v - u) / 2.0_f64.sqrt();
    let mut rgb = [0.012, 0.014, 0.020];
    for (k, total) in rgb.iter_mut().enumerate() {
        let shift = 0.07 * (k as f64 - 1.0);
        // Each zone of the pupil forms a circle; its radius and offset grow with the square of the zone's. Coma is
        // their sum.
        for zone in 1..=12 {
            let rho = f64::from(zone) / 12.0;
            let radius = 0.36 * rho * rho;
            let centre = -0.52 + shift + 0.80 * rho * rho;
            let distance = (along - centre).hypot(across) - radius;
            *total += 0.11 * (-(distance / 0.035).powi(2)).exp();
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
    fn corners_are_transparent_and_the_point_light_is_bright() {
        assert_eq!(pixel(0, 0)[3], 0);
        let position = |along: f64| {
            let u = along / 2.0_f64.sqrt();
            ((u + 1.0) / 2.0 * f64::from(SIZE)) as u32
        };
        let bright = pixel(position(-0.52), position(-0.52));
        assert!(bright[3] == 255 && bright[1] > 200, "{bright:?}");
        let dark = pixel(SIZE - 20, 20);
        assert!(
            dark[3] == 255 && dark[..3].iter().all(|v| *v < 60),
            "{dark:?}"
        );
    }

    #[test]
    fn the_file_decodes_to_the_same_pixels() {
        let file = png();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file))
            .read_info()
            .expect("a header");
        let mut rgba = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut rgba).expect("pixels");
        assert_eq!([info.width, info.height], [SIZE, SIZE]);
        let at = (64 * SIZE + 50) as usize * 4;
        assert_eq!(rgba[at..at + 4], pixel(50, 64));
    }
}
