//! Removing the blur of a lens from a plate.

use seidel_core::{Canvas, Image, NoiseGain, PreparedPlate, Progress, RemovedPlate};

use crate::call_args::CallArgs;
use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::image::{ImageView, SeidelImage, SeidelRect};
use crate::memory::check_removal_memory;
use crate::plate::{HoldoutUse, Plate, SeidelPlate};
use crate::pointers::{Versioned, read_optional, write_versioned};
use crate::settings::SeidelSettings;
use crate::status::{Failure, Result, SeidelStatus};

/// Results of seidel_remove beside the image. The caller sets `size` and the two images; the library writes the other
/// members. Arrays have one entry for each colour, in the order of the source.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelFindings {
    /// sizeof(SeidelFindings).
    pub size: u64,
    /// Gets the share of each pixel's detail that the plate determines, 0 to 1, one channel a colour; 0 where blur is
    /// kept. NULL: not wanted.
    pub confidence: *const SeidelImage,
    /// Gets the noise of the sharp image over that of the plate, one channel a colour. NULL: not wanted. It doubles
    /// the time of the call.
    pub noise_gain: *const SeidelImage,
    /// All pixels that were estimated: the plate's extent and a margin around it.
    pub found: SeidelRect,
    /// Standard deviation of the noise, scene-linear, as set or as estimated from the plate.
    pub noise: [f64; 3],
    /// Root mean square of the residual over that expected from the noise. Well above 1.5, the lens does not explain
    /// the plate.
    pub misfit: [f64; 3],
    /// Level at which samples are clipped; NaN if none are.
    pub clip_level: [f64; 3],
    /// Number of clipped samples.
    pub clipped: [u64; 3],
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and raw pointers.
unsafe impl Versioned for SeidelFindings {
    const MIN_SIZE: usize = size_of::<Self>();

    fn defaults() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            confidence: std::ptr::null(),
            noise_gain: std::ptr::null(),
            found: SeidelRect::EMPTY,
            noise: [0.0; 3],
            misfit: [0.0; 3],
            clip_level: [f64::NAN; 3],
            clipped: [0; 3],
        }
    }
}

/// The caller's images for maps of the removal.
struct Maps {
    confidence: Option<ImageView>,
    noise_gain: Option<ImageView>,
}

impl Maps {
    /// Checks the images of `findings`.
    ///
    /// # Safety
    /// They must be NULL or valid outputs until the call ends.
    unsafe fn new(findings: &SeidelFindings, plate: &Plate) -> Result<Self> {
        // SAFETY: as the caller guarantees.
        let (confidence, noise_gain) = unsafe {
            (
                ImageView::optional(findings.confidence, "findings.confidence")?,
                ImageView::optional(findings.noise_gain, "findings.noise_gain")?,
            )
        };
        let views = [
            ("findings.confidence", &confidence),
            ("findings.noise_gain", &noise_gain),
        ];
        for (name, view) in views {
            if let Some(view) = view
                && view.channels != plate.colour_count()
            {
                return Err(Failure::argument(
                    &format!("{name}.channels"),
                    format!("is {}", view.channels),
                    &format!("give one for each colour, {}", plate.colour_count()),
                ));
            }
        }
        Ok(Self {
            confidence,
            noise_gain,
        })
    }

    fn noise_gain_use(&self) -> NoiseGain {
        if self.noise_gain.is_some() {
            NoiseGain::Measure
        } else {
            NoiseGain::Skip
        }
    }

    /// Writes the maps, whose planes cover `rect`.
    fn write(&self, rect: SeidelRect, confidence: &[Vec<f32>], noise_gain: &[Vec<f32>]) {
        let maps = [
            (&self.confidence, confidence),
            (&self.noise_gain, noise_gain),
        ];
        for (view, planes) in maps {
            let Some(view) = view else { continue };
            for (channel, plane) in planes.iter().enumerate() {
                view.write(channel, rect, plane);
            }
        }
    }
}

/// Removes the blur of the lens that a plate was taken with. The source must cover the extent: missing pixels count
/// as black. The depth image is that of the sharp image. `output.rect` may reach beyond the extent, where light that
/// landed on the plate was estimated; pixels beyond `found` of the findings are black. `alphas` is as for
/// seidel_apply. `findings`, `settings` and `callbacks` may be NULL. With `amount` or `strength` 0 the plate is
/// copied and the maps are 1.
///
/// Errors: those of seidel_apply.
///
/// # Safety
/// As for seidel_apply; images of `*findings` are outputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_remove(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    output: *const SeidelImage,
    alphas: *const SeidelImage,
    findings: *mut SeidelFindings,
    callbacks: *const SeidelCallbacks,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        // SAFETY: as the caller guarantees.
        let args = unsafe { CallArgs::new(settings, plate, output, alphas, callbacks)? };
        // SAFETY: as the caller guarantees.
        let request = unsafe { read_optional(findings.cast_const(), "findings")? };
        let request = request.unwrap_or_else(SeidelFindings::defaults);
        let (plate, settings) = (&args.plate, &args.settings);
        // SAFETY: as the caller guarantees.
        let maps = unsafe { Maps::new(&request, plate)? };
        check_removal_memory(plate, settings)?;
        let mut results = SeidelFindings {
            confidence: request.confidence,
            noise_gain: request.noise_gain,
            found: plate.extent(),
            ..SeidelFindings::defaults()
        };
        if settings.raw.amount == 0.0 || settings.raw.strength == 0.0 {
            let image = plate.image(settings)?;
            let ones = vec![vec![1.0; plate.extent().pixels()]; plate.colour_count()];
            args.write(&image, plate.extent())?;
            maps.write(plate.extent(), &ones, &ones);
        } else {
            let session = settings.session_of_plate(&lens, plate.colour_count())?;
            let prepared = plate.prepare(&session, settings, HoldoutUse::Ignore)?;
            let noise_gain = maps.noise_gain_use();
            let sharp = args.run(move |progress| sharpen(&prepared, noise_gain, progress))?;
            let (x, y) = (sharp.canvas.margin_x as i32, sharp.canvas.margin_y as i32);
            results.found = plate.extent().grown(x, y);
            fill_findings(&mut results, &sharp.removed);
            let (confidence, gain) = (sharp.removed.confidence(), sharp.removed.noise_gain());
            args.write(&sharp.image, results.found)?;
            maps.write(plate.extent(), &confidence, gain);
        }
        if findings.is_null() {
            return Ok(());
        }
        // SAFETY: as the caller guarantees.
        unsafe { write_versioned(findings, &results, "findings") }
    })
}

/// A plate without its blur.
struct SharpPlate {
    removed: RemovedPlate,
    canvas: Canvas,
    /// The sharp image, of the size of the canvas.
    image: Image,
}

fn sharpen(
    plate: &PreparedPlate,
    noise_gain: NoiseGain,
    progress: &Progress,
) -> Result<SharpPlate> {
    let removed = plate.remove(noise_gain, progress)?;
    let canvas = removed.canvas()?;
    let planes = removed.sharp_planes(plate)?;
    let (width, height) = canvas.size();
    Ok(SharpPlate {
        image: plate.to_image_of_size(width, height, planes)?,
        canvas,
        removed,
    })
}

/// Sets noise, misfit and clipping of each colour.
fn fill_findings(findings: &mut SeidelFindings, removed: &RemovedPlate) {
    for (k, colour) in removed.colours().iter().enumerate().take(3) {
        findings.noise[k] = colour.noise;
        findings.misfit[k] = colour.misfit;
        findings.clip_level[k] = colour.clipping.map_or(f64::NAN, |clipping| clipping.level);
        findings.clipped[k] = colour.clipping.map_or(0, |clipping| clipping.count as u64);
    }
}
