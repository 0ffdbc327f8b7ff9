//! Blur removal beside the Wiener filter.

use rayon::prelude::*;
use seidel_core::profile::LensDescription;
use seidel_core::{
    Depth, Image, ImagePoint, Lens, LensProfile, LibraryLens, ObjectDistance, Plate, PlateGeometry,
    Rectangle, Result, Settings, apply, no_progress, remove,
};

use crate::Extent;
use crate::page::{Case, Job};
use crate::picture::Picture;
use crate::wiener;

/// Lens of the cases, and its frame.
const LENS: &str = "modern-50";
const FRAME: [usize; 2] = [1920, 1080];
/// Radii of blur, px, and standard deviations of noise, shares of the peak.
const RADII_PX: [f64; 7] = [0.0, 1.0, 3.0, 6.0, 10.0, 20.0, 60.0];
const NOISE: [f64; 4] = [0.0, 0.001, 0.01, 0.03];
const SIDE: usize = 320;

/// Measures all cases.
pub(crate) fn job(extent: Extent) -> Result<Job> {
    let lens = green_alone(LibraryLens::by_name(LENS)?.profile()?)?;
    let (radii, noise): (&[f64], &[f64]) = if extent == Extent::Quick {
        (&RADII_PX[2..3], &NOISE[..2])
    } else {
        (&RADII_PX, &NOISE)
    };
    let each = radii
        .iter()
        .flat_map(|r| noise.iter().map(move |n| (*r, *n)));
    let each: Vec<(f64, f64)> = each.collect();
    let cases: Result<Vec<Case>> = each
        .par_iter()
        .map(|&(radius, noise)| case(&lens, radius, noise))
        .collect();
    Ok(Job {
        title: "Remove blur",
        text: format!(
            "Peak signal-to-noise ratio of `seidel remove` on a picture of dead leaves ({SIDE} x {SIDE} px in the middle of the frame), \
             blurred by `library:{LENS}` out of focus, with noise. The Wiener filter knows the PSF of the middle, and the best \
             constant for each case. A border of the radius of blur counts for none."
        ),
        rivals: &["Wiener filter", "nothing"],
        cases: cases?,
    })
}

/// Returns the lens with its green channel alone, for pictures of one channel.
pub(crate) fn green_alone(mut profile: LensProfile) -> Result<Lens> {
    if let LensDescription::Pupil(channels) = &mut profile.description {
        channels.retain(|channel| channel.name == "G");
        channels
            .iter_mut()
            .for_each(|channel| channel.name = "Y".to_owned());
    }
    let wavelengths = std::mem::take(&mut profile.camera.wavelength_nm);
    let green = wavelengths.into_iter().filter(|(name, _)| name == "G");
    profile.camera.wavelength_nm = green.map(|(_, nm)| ("Y".to_owned(), nm)).collect();
    Lens::new(profile)
}

/// Returns the distance nearer than the focus at which points in the middle of the frame have a standard deviation of half
/// of `radius_px`, that of an even disc of the radius.
fn distance(lens: &Lens, radius_px: f64) -> Result<ObjectDistance> {
    let middle = ImagePoint::new(FRAME[0] as f64 / 2.0, FRAME[1] as f64 / 2.0);
    let focus = lens
        .profile()
        .camera
        .focus_distance
        .vergence_per_m()
        .unwrap_or(0.5);
    let (mut far, mut near) = (focus, 20.0 * focus);
    for _ in 0..40 {
        let vergence = (far + near) / 2.0;
        let blur = lens.blur_at("Y", middle, ObjectDistance::metres(1.0 / vergence)?)?;
        if blur.moments.mu20 < (radius_px / 2.0).powi(2) {
            far = vergence
        } else {
            near = vergence
        }
    }
    ObjectDistance::metres(1.0 / far)
}

/// Returns a plate of `picture` in the middle of the frame.
fn plate(picture: &Picture, distance: ObjectDistance) -> Result<Plate> {
    let side = picture.side;
    let window = |x: usize, y: usize, width, height| Rectangle {
        x: x as i32,
        y: y as i32,
        width,
        height,
    };
    let geometry = PlateGeometry {
        display: window(0, 0, FRAME[0], FRAME[1]),
        data: window((FRAME[0] - side) / 2, (FRAME[1] - side) / 2, side, side),
        ..PlateGeometry::of_size(side, side)
    };
    let image = Image::from_interleaved(side, side, 1, &picture.samples)?;
    Ok(Plate::new(image)
        .with_depth(Depth::Distance(distance))
        .with_geometry(geometry))
}

fn case(lens: &Lens, radius_px: f64, noise: f64) -> Result<Case> {
    let distance = distance(lens, radius_px)?;
    let reach = 2 * radius_px.ceil() as usize + 8;
    // Light from beyond the borders of the picture is in it, as in a photograph.
    let scene = Picture::dead_leaves(SIDE + 2 * reach, 1);
    let blurred = apply(
        lens,
        &plate(&scene, distance)?,
        &Settings::default(),
        &no_progress,
    )?;
    let blurred = Picture {
        side: scene.side,
        samples: blurred.colours[0].clone(),
    };
    let (truth, blurred) = (
        scene.cropped(reach),
        blurred.cropped(reach).with_noise(noise, 2),
    );
    let restored = remove(
        lens,
        &plate(&blurred, distance)?,
        &Settings::default(),
        &no_progress,
    )?;
    let restored = Picture {
        side: SIDE,
        samples: restored.colours[0].clone(),
    };
    let middle = ImagePoint::new(FRAME[0] as f64 / 2.0, FRAME[1] as f64 / 2.0);
    let psf = &lens.psf_at(middle, distance, 2 * reach + 1, None)?[0];
    let border = (radius_px.ceil() as usize).min(SIDE / 4);
    Ok(Case {
        name: format!("{radius_px} px, noise {noise}"),
        ours: restored.psnr(&truth, border),
        rivals: vec![
            wiener::best_psnr(&blurred, psf, &truth, border),
            blurred.psnr(&truth, border),
        ],
    })
}
