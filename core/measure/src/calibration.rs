//! Dark and flat frames: subtraction, division, defective pixels and dust.

use seidel_optics::error::{Error, Result};

use crate::background::Background;
use crate::photograph::Photograph;
use seidel_optics::numeric::{median, scatter};

/// Excess of a dark frame over its median from which on a pixel is defective, standard deviations. Its photo noise is not
/// that of its neighbours even after subtraction.
const HOT_DARK_SIGMAS: f64 = 12.0;
/// Transmission of a pixel relative to its surroundings below which dust or a defect shades it.
const DUST_TRANSMISSION: f32 = 0.92;

/// Dark and flat frames of a camera, combined.
#[derive(Debug, Clone, Default)]
pub struct Calibration {
    /// Median dark frame, plane by plane.
    dark: Option<Vec<Vec<f32>>>,
    /// Flat frame relative to its median of each channel.
    flat: Option<Vec<Vec<f32>>>,
    /// Transmission of each pixel relative to its surroundings; the lowest of all planes.
    transmission: Option<Vec<f32>>,
}

impl Calibration {
    /// Combines `darks` and `flats`, photographs of the same camera as those they are for.
    ///
    /// # Errors
    /// Frames of different sizes or mosaics, and flats without light.
    pub fn new(darks: &[Photograph], flats: &[Photograph]) -> Result<Self> {
        let dark = combined(darks)?;
        let mut calibration = Self {
            dark: dark.map(|photo| photo.planes),
            ..Self::default()
        };
        let Some(mut flat) = combined(flats)? else {
            return Ok(calibration);
        };
        if let (Some(first), Some(dark)) = (darks.first(), &calibration.dark) {
            check_alike(first, &flat)?;
            subtract(&mut flat, dark);
        }
        let mut transmission = vec![1.0_f32; flat.width * flat.height];
        for channel in 0..flat.channels.len() {
            let level = Background::of(&flat, channel);
            let plane = flat.plane_of(channel);
            let covered: Vec<usize> = (0..transmission.len())
                .filter(|k| flat.covers(channel, k % flat.width, k / flat.width))
                .collect();
            let mut values: Vec<f64> = (covered.iter())
                .map(|k| f64::from(flat.planes[plane][*k]))
                .collect();
            let middle = median(&mut values);
            if middle <= 0.0 {
                return Err(Error::new(
                    format!("flat {}", flat.name),
                    format!("has no light in channel {}", flat.channels[channel]),
                    "photograph an evenly lit surface, half way to clipping",
                ));
            }
            for k in covered {
                let (x, y) = ((k % flat.width) as f64 + 0.5, (k / flat.width) as f64 + 0.5);
                let value = flat.planes[plane][k];
                let around = level.level_at(x, y).max(f64::MIN_POSITIVE);
                transmission[k] = transmission[k].min(value / around as f32);
                flat.planes[plane][k] = value / middle as f32;
            }
        }
        calibration.flat = Some(flat.planes);
        calibration.transmission = Some(transmission);
        Ok(calibration)
    }

    /// Subtracts the dark frame from `photo`, divides by the flat frame, and marks bad pixels. Clipped pixels stay clipped.
    ///
    /// # Errors
    /// A photograph of another size.
    pub fn apply(&self, photo: &mut Photograph) -> Result<()> {
        let pixels = photo.width * photo.height;
        let mut bad = std::mem::take(&mut photo.bad);
        bad.resize(pixels, false);
        for frames in [&self.dark, &self.flat].into_iter().flatten() {
            if frames.len() != photo.planes.len() || frames[0].len() != pixels {
                return Err(other_size(&photo.name));
            }
        }
        if let Some(dark) = &self.dark {
            subtract(photo, dark);
            for plane in dark {
                let values: Vec<f64> = plane.iter().map(|v| f64::from(*v)).collect();
                let cut = median(&mut values.clone()) + HOT_DARK_SIGMAS * scatter(&values).max(1.0);
                for (bad, value) in bad.iter_mut().zip(plane) {
                    *bad |= f64::from(*value) > cut;
                }
            }
        }
        if let Some(flat) = &self.flat {
            for (plane, flat) in photo.planes.iter_mut().zip(flat) {
                for (value, flat) in plane.iter_mut().zip(flat) {
                    if *value < photo.white {
                        *value /= flat.max(0.05);
                    }
                }
            }
        }
        if let Some(transmission) = &self.transmission {
            for (bad, transmission) in bad.iter_mut().zip(transmission) {
                *bad |= *transmission < DUST_TRANSMISSION;
            }
        }
        photo.bad = bad;
        Ok(())
    }

    /// Returns the transmission of a pixel where dust shades it.
    pub fn dust_at(&self, index: usize) -> Option<f64> {
        let transmission = *self.transmission.as_ref()?.get(index)?;
        (transmission < DUST_TRANSMISSION).then_some(f64::from(transmission))
    }
}

/// Returns the pixel-wise median of `frames`; `None` for none.
fn combined(frames: &[Photograph]) -> Result<Option<Photograph>> {
    let Some(first) = frames.first() else {
        return Ok(None);
    };
    for frame in frames {
        frame.check()?;
        check_alike(first, frame)?;
    }
    let mut result = first.clone();
    if frames.len() > 1 {
        for (plane, samples) in result.planes.iter_mut().enumerate() {
            for (index, sample) in samples.iter_mut().enumerate() {
                let mut all: Vec<f32> = frames.iter().map(|f| f.planes[plane][index]).collect();
                all.sort_by(f32::total_cmp);
                let (low, high) = (all[(all.len() - 1) / 2], all[all.len() / 2]);
                *sample = (low + high) / 2.0;
            }
        }
    }
    Ok(Some(result))
}

fn subtract(photo: &mut Photograph, dark: &[Vec<f32>]) {
    for (plane, dark) in photo.planes.iter_mut().zip(dark) {
        for (value, dark) in plane.iter_mut().zip(dark) {
            if *value < photo.white {
                *value -= dark;
            }
        }
    }
}

/// Rejects photographs that differ in size or mosaic.
///
/// # Errors
/// A difference, with the name of the second.
pub fn check_alike(first: &Photograph, other: &Photograph) -> Result<()> {
    if (first.width, first.height) != (other.width, other.height) {
        return Err(Error::new(
            format!("photograph {}", other.name),
            format!(
                "has {} x {} pixels, {} has {} x {}",
                other.width, other.height, first.name, first.width, first.height
            ),
            "give photographs of one camera at one size",
        ));
    }
    if first.mosaic != other.mosaic || first.channels != other.channels {
        let of = |p: &Photograph| p.mosaic.map_or("none".to_owned(), |m| m.to_string());
        return Err(Error::new(
            format!("photograph {}", other.name),
            format!(
                "has the mosaic {}, {} has {}",
                of(other),
                first.name,
                of(first)
            ),
            "give photographs of one camera, all raw or all developed",
        ));
    }
    Ok(())
}

fn other_size(name: &str) -> Error {
    Error::new(
        format!("photograph {name}"),
        "has another size than its dark or flat frame",
        "give dark and flat frames of the same camera at the same size",
    )
}
