//! Taking a lens's blur off a plate.

use seidel_core::render::remove::Canvas;
use seidel_core::{Image, NoiseGain, PreparedPlate, RemovedPlate, remove_bytes};

use crate::call_args::CallArgs;
use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::image::{SeidelImage, SeidelRect, View};
use crate::lens::SeidelLens;
use crate::plate::{HoldoutUse, Plate, SeidelPlate, plane_count};
use crate::pointers::{Sized64, maybe_sized, put_sized};
use crate::results::{check_memory, write_back};
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, Result, SeidelStatus};
use crate::threads::{Watch, run};

/// What seidel_remove tells beside the picture. Set `size` and the two pictures before the call; the rest is written.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelFindings {
    /// sizeof(SeidelFindings).
    pub size: u64,
    /// Gets how much of each pixel was seen and not guessed, 0 to 1, a channel a colour. May be NULL.
    pub confidence: *const SeidelImage,
    /// Gets how many times its size in the plate noise has in the sharp picture, a channel a colour. May be NULL; takes as
    /// long again.
    pub noise_gain: *const SeidelImage,
    /// All pixels that were found: the plate's extent and what is about it.
    pub found: SeidelRect,
    /// Standard deviation of the noise of each colour, as given or as estimated from the plate.
    pub noise: [f64; 3],
    /// What the lens leaves unexplained of each colour, in times of what noise lets expect: well above 1.5, it is not the
    /// lens of the plate.
    pub misfit: [f64; 3],
    /// From where on samples of each colour are clipped; NaN where none are.
    pub clip_level: [f64; 3],
    /// How many are.
    pub clipped: [u64; 3],
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and raw pointers.
unsafe impl Sized64 for SeidelFindings {
    const LEAST: usize = size_of::<Self>();

    fn neutral() -> Self {
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

/// Pictures that maps go to.
struct Maps {
    confidence: Option<View>,
    noise_gain: Option<View>,
}

impl Maps {
    /// # Safety
    /// The pictures of `findings` must be NULL or good as outputs.
    unsafe fn new(findings: &SeidelFindings, plate: &Plate) -> Result<Self> {
        // SAFETY: as the caller vouches.
        let (confidence, noise_gain) = unsafe {
            (
                View::maybe(findings.confidence, "findings.confidence")?,
                View::maybe(findings.noise_gain, "findings.noise_gain")?,
            )
        };
        for view in [&confidence, &noise_gain].into_iter().flatten() {
            if view.channels != plate.colour_count() {
                return Err(Failure::argument(
                    "findings",
                    format!("a map has {} channels", view.channels),
                    "give one for each colour of the plate",
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

    fn write(&self, rect: SeidelRect, confidence: &[Vec<f32>], noise_gain: &[Vec<f32>]) {
        let maps = [
            (&self.confidence, confidence),
            (&self.noise_gain, noise_gain),
        ];
        for (view, planes) in maps {
            for (channel, plane) in planes.iter().enumerate() {
                if let Some(view) = view {
                    view.write(channel, rect, plane);
                }
            }
        }
    }
}

/// Takes the blur of the lens that a plate was taken with off it. The source must cover the extent: what it lacks counts as
/// black. `output.rect` may go beyond the extent, where light was found that lands on the plate; what lies beyond
/// `findings.found` is black. Depth is that of the sharp picture. `findings`, `settings`, `alphas` and `callbacks` may be
/// NULL as in seidel_apply.
///
/// # Safety
/// That of seidel_apply.
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
        // SAFETY: as the caller vouches.
        let args = unsafe { CallArgs::new(settings, plate, output, alphas, callbacks)? };
        let CallArgs {
            settings,
            plate,
            output,
            alphas,
            callbacks,
        } = args;
        // SAFETY: as the caller vouches.
        let asked = unsafe { maybe_sized(findings.cast_const(), "findings")? };
        let mut findings_out = asked.unwrap_or_else(SeidelFindings::neutral);
        // SAFETY: as the caller vouches.
        let maps = unsafe { Maps::new(&findings_out, &plate)? };
        check_bounds(&plate, &settings)?;
        let (image, rect) = if settings.raw.amount == 0.0 || settings.raw.strength == 0.0 {
            let image = plate.image(&settings)?;
            findings_out.found = plate.extent;
            let ones = vec![vec![1.0; plate.extent.pixels()]; plate.colour_count()];
            maps.write(plate.extent, &ones, &ones);
            (image, plate.extent)
        } else {
            let session = settings.session(&lens)?;
            let prepared = plate.prepare(&session, &settings, HoldoutUse::Ignore)?;
            let noise_gain = maps.noise_gain_use();
            let work = move |watch: &Watch| sharpen(&prepared, noise_gain, watch);
            let found = run(settings.raw.threads, &callbacks, work)?;
            let margin = (found.canvas.margin_x as i32, found.canvas.margin_y as i32);
            findings_out.found = plate.extent.grown(margin.0, margin.1);
            fill_findings(&mut findings_out, &found.removed);
            let (confidence, gain) = (found.removed.confidence(), found.removed.noise_gain());
            maps.write(plate.extent, &confidence, gain);
            (found.image, findings_out.found)
        };
        write_back(&image, rect, &output, alphas.as_ref());
        if findings.is_null() {
            return Ok(());
        }
        // SAFETY: as the caller vouches.
        unsafe { put_sized(findings, &findings_out, "findings") }
    })
}

/// Refuses what would take too much memory.
pub(crate) fn check_bounds(plate: &Plate, settings: &Settings) -> Result<()> {
    let planes = plane_count(plate.source.channels, settings) as u64;
    check_memory(remove_bytes(plate.extent.pixels() as u64, planes), settings)
}

/// A plate without its blur.
struct SharpPlate {
    removed: RemovedPlate,
    canvas: Canvas,
    /// As large as the canvas.
    image: Image,
}

fn sharpen(plate: &PreparedPlate, noise_gain: NoiseGain, watch: &Watch) -> Result<SharpPlate> {
    let removed = plate.remove(noise_gain, &|share| watch.tell(share))?;
    let canvas = removed.canvas()?;
    let planes = removed.sharp_planes(plate)?;
    let (width, height) = canvas.size();
    Ok(SharpPlate {
        image: plate.to_image_of_size(width, height, planes),
        canvas,
        removed,
    })
}

/// Writes noise, misfit and clipping of each colour to `findings`.
fn fill_findings(findings: &mut SeidelFindings, removed: &RemovedPlate) {
    for (k, colour) in removed.colours().iter().enumerate().take(3) {
        findings.noise[k] = colour.noise;
        findings.misfit[k] = colour.misfit;
        findings.clip_level[k] = colour.clipping.map_or(f64::NAN, |clipping| clipping.level);
        findings.clipped[k] = colour.clipping.map_or(0, |clipping| clipping.count as u64);
    }
}
