//! Errors of renders with depth against exact kernels, in the same occlusion.

use super::aim::{Aim, Wanted};
use super::lens;
use super::plates::{FOLIAGE, Objects, RAMP, plate, shot};
use seidel_core::{
    Image, Lens, LensSession, Plate, Quality, RenderWindow, Result, Settings, apply, no_progress,
};
use std::sync::Arc;

/// Columns of the plates: exact renders take a minute each.
const WIDTH: usize = 480;

/// Value of the lamps whose energy is compared.
const LAMP: f32 = 1e5;

/// Returns the aims of accuracy.
pub(crate) fn aims(moments: &Lens) -> Result<Vec<Aim>> {
    let ray_by_ray = lens()?;
    let mut aims = Vec::new();
    for (lens, of) in [(&ray_by_ray, "ray by ray"), (moments, "moments")] {
        for (name, objects) in [("shot", shot(0)), ("foliage", FOLIAGE)] {
            eprintln!("accuracy: {name}, {of}");
            let plate = plate(&objects, WIDTH)?;
            let exact = rendered(lens, &plate, Quality::Exact)?;
            let fine = rendered(lens, &plate, Quality::Final)?;
            aims.push(Aim::new(
                format!("{name}, {of}: final against exact"),
                Wanted::AtLeast(60.0),
                "dB",
                psnr(&fine, &exact),
            ));
        }
    }
    let shot = plate(&shot(0), 1920)?;
    let [draft, fine] =
        [Quality::Draft, Quality::Final].map(|quality| rendered(&ray_by_ray, &shot, quality));
    let (draft, fine) = (draft?, fine?);
    aims.push(Aim::new(
        "HD shot: draft against final",
        Wanted::AtLeast(45.0),
        "dB",
        psnr(&draft, &fine),
    ));
    aims.push(Aim::new(
        "HD shot: a quarter against the whole, largest difference",
        Wanted::AtMost(0.0),
        "",
        difference_of_quarter(&ray_by_ray, shot, &fine)?,
    ));
    aims.push(Aim::new(
        format!("lamps of {LAMP:e}: error of their energy"),
        Wanted::AtMost(1.0),
        "%",
        energy_error_percent(&ray_by_ray)?,
    ));
    Ok(aims)
}

fn rendered(lens: &Lens, plate: &Plate, quality: Quality) -> Result<Image> {
    let mut settings = Settings::default();
    settings.quality = quality;
    apply(lens, plate, &settings, &no_progress)
}

/// Returns the PSNR of `a` against `b`, dB, with a peak of one; samples are limited to white.
fn psnr(a: &Image, b: &Image) -> f64 {
    let (a, b) = (a.to_interleaved(), b.to_interleaved());
    let pairs = a.iter().zip(&b);
    let squares = pairs.map(|(a, b)| f64::from(a.min(1.0) - b.min(1.0)).powi(2));
    -10.0 * (squares.sum::<f64>() / a.len() as f64).log10()
}

/// Returns the largest difference between a window rendered alone and the same part of the `whole`.
fn difference_of_quarter(lens: &Lens, plate: Plate, whole: &Image) -> Result<f64> {
    let window = RenderWindow {
        column: whole.width() / 4,
        row: whole.height() / 4,
        width: whole.width() / 2,
        height: whole.height() / 2,
    };
    let session = Arc::new(LensSession::new(lens, &Settings::default())?);
    let parts = session.prepare(plate)?.apply_window(window, &no_progress)?;
    let mut largest = 0.0_f32;
    for (part, whole_plane) in parts.iter().zip(&whole.colours) {
        for (row, line) in part.chunks_exact(window.width).enumerate() {
            let first = (window.row + row) * whole.width() + window.column;
            for (a, b) in line.iter().zip(&whole_plane[first..]) {
                largest = largest.max((a - b).abs());
            }
        }
    }
    Ok(f64::from(largest))
}

/// Returns the error of the light that lamps add to a floor, per cent.
fn energy_error_percent(lens: &Lens) -> Result<f64> {
    let sum = |lamps: Option<f32>| {
        let plate = plate(&Objects { lamps, ..RAMP }, WIDTH)?;
        let image = rendered(lens, &plate, Quality::Final)?;
        let samples = image.colours[1].iter();
        Ok(samples.map(|sample| f64::from(*sample)).sum::<f64>())
    };
    let added = sum(Some(LAMP))? - sum(None)?;
    Ok(100.0 * (added / (40.0 * f64::from(LAMP)) - 1.0).abs())
}
