//! A synthetic plate with the statistics of photographs, the same on every machine.

use rayon::prelude::*;

/// Octaves of noise of equal strength, which give a 1 / f spectrum.
const OCTAVES: u32 = 8;

/// Number of overlapping discs, for edges, and their smallest and largest radius, px at a plate width of 1920.
const DISCS: u32 = 1500;
const RADII: (f64, f64) = (6.0, 300.0);

/// Brightness of lights.
const LIGHT: f32 = 200.0;

/// Returns three planes of linear light, R, G and B, from 0 to 1 except for lights: a `light_share` of all pixels.
pub(crate) fn plate(width: usize, height: usize, light_share: f64) -> Vec<Vec<f32>> {
    (0..3)
        .map(|channel| plane(width, height, channel, light_share))
        .collect()
}

fn plane(width: usize, height: usize, channel: u32, light_share: f64) -> Vec<f32> {
    let scale = width as f64 / 1920.0;
    let mut samples = vec![0.5_f32; width * height];
    for disc in 0..DISCS {
        paint(&mut samples, width, scale, disc, channel);
    }
    let rows = samples.par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        for (x, sample) in row.iter_mut().enumerate() {
            let grain = uniform(x as i64, y as i64, 1000 + channel);
            let noise = noise(x as f64 / scale, y as f64 / scale) + 0.1 * (grain - 0.5);
            *sample = (f64::from(*sample) * (0.6 + 0.8 * noise)).clamp(0.0, 1.0) as f32;
            if uniform(x as i64, y as i64, 999) < light_share {
                *sample = LIGHT;
            }
        }
    });
    samples
}

/// Paints a disc, at the same place in all channels.
fn paint(samples: &mut [f32], width: usize, scale: f64, disc: u32, channel: u32) {
    let height = samples.len() / width;
    let dice = |salt: u32| uniform(i64::from(disc), 0, salt);
    // Radii r with a density of r^-3, as of objects at random distances.
    let (least, most) = RADII;
    let (low, high) = (least.powi(-2), most.powi(-2));
    let radius = scale / (low + (high - low) * dice(1)).sqrt();
    let (x, y) = (dice(2) * width as f64, dice(3) * height as f64);
    let shade = dice(4) * (0.7 + 0.3 * dice(5 + channel));
    let range = |at: f64, size: usize| {
        let end = (at + radius).ceil().clamp(0.0, size as f64) as usize;
        (at - radius).floor().max(0.0) as usize..end
    };
    for row in range(y, height) {
        let off = row as f64 + 0.5 - y;
        let half = (radius * radius - off * off).max(0.0).sqrt();
        let end = (x + half).round().clamp(0.0, width as f64) as usize;
        let start = ((x - half).round().max(0.0) as usize).min(end);
        samples[row * width + start..row * width + end].fill(shade as f32);
    }
}

/// Returns octaves of smoothed lattice noise, 0 to 1.
fn noise(x: f64, y: f64) -> f64 {
    let mut sum = 0.0;
    for octave in 0..OCTAVES {
        let cell = f64::from(2_u32 << octave);
        let (u, v) = (x / cell, y / cell);
        let (i, j) = (u.floor(), v.floor());
        let ease = |t: f64| t * t * (3.0 - 2.0 * t);
        let (s, t) = (ease(u - i), ease(v - j));
        let value = |di: i64, dj: i64| uniform(i as i64 + di, j as i64 + dj, 100 + octave);
        let top = value(0, 0) * (1.0 - s) + value(1, 0) * s;
        let bottom = value(0, 1) * (1.0 - s) + value(1, 1) * s;
        sum += top * (1.0 - t) + bottom * t;
    }
    sum / f64::from(OCTAVES)
}

/// Returns a pseudorandom number from 0 to 1 for a position and a salt, by the finaliser of SplitMix64.
fn uniform(x: i64, y: i64, salt: u32) -> f64 {
    let mut z = (x as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add((y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
        .wrapping_add(u64::from(salt).wrapping_mul(0x1656_67b1_9e37_79f9));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
