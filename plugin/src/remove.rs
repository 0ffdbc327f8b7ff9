//! Taking a lens's blur off a plate.

use seidel_core::plate::{Returned, Unblurred, remove_bytes};
use seidel_core::remove::Canvas;

use crate::apply::as_it_is;
use crate::callbacks::SeidelCallbacks;
use crate::given::Given;
use crate::guard::guard;
use crate::handles;
use crate::image::{SeidelImage, SeidelRect, View};
use crate::job::{Job, check_memory, write_back};
use crate::lens::SeidelLens;
use crate::plate::{Plate, SeidelPlate, plane_count};
use crate::pointers::{Sized64, maybe_sized, put_sized};
use crate::settings::{SEIDEL_GRAIN_KEEP, SeidelSettings, Settings};
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
    /// Standard deviation of the noise of each colour, as given or as told from the plate.
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
        let given = unsafe { Given::new(settings, plate, (output, alphas), callbacks)? };
        let Given {
            settings,
            plate,
            output,
            alphas,
            callbacks,
        } = given;
        // SAFETY: as the caller vouches.
        let asked = unsafe { maybe_sized(findings.cast_const(), "findings")? };
        let mut told = asked.unwrap_or_else(SeidelFindings::neutral);
        // SAFETY: as the caller vouches.
        let maps = unsafe { Maps::new(&told, &plate)? };
        check_bounds(&plate, &settings)?;
        let colours = plate.colour_count();
        let (back, rect) = if settings.raw.amount == 0.0 || settings.raw.strength == 0.0 {
            let parts = plate.parts(&settings)?;
            told.found = plate.extent;
            let even = vec![vec![1.0; plate.extent.pixels()]; colours];
            maps.write(plate.extent, &even, &even);
            (as_it_is(parts, settings.raw.scrub == 1), plate.extent)
        } else {
            let job = Job::new(&lens, &plate, &settings)?;
            let gain = maps.noise_gain.is_some();
            let work = move |watch: &Watch| sharp(&job, colours, gain, watch);
            let found = run(settings.raw.threads, &callbacks, work)?;
            let margin = (found.canvas.margin_x as i32, found.canvas.margin_y as i32);
            told.found = plate.extent.grown(margin.0, margin.1);
            found.tell(&mut told);
            maps.write(plate.extent, &found.confidence, &found.noise_gain);
            (found.back, told.found)
        };
        write_back(&back, rect, (&output, alphas.as_ref()));
        match findings.is_null() {
            true => Ok(()),
            // SAFETY: as the caller vouches.
            false => unsafe { put_sized(findings, &told, "findings") },
        }
    })
}

/// Refuses what would take too much memory.
pub(crate) fn check_bounds(plate: &Plate, settings: &Settings) -> Result<()> {
    let planes = plane_count(plate.source.channels, settings) as u64;
    check_memory(remove_bytes(plate.extent.pixels() as u64, planes), settings)
}

/// What was found of one colour.
struct Told {
    noise: f64,
    misfit: f64,
    /// Level and count.
    clipped: Option<(f64, usize)>,
}

/// What was found, ready to be handed over.
struct Found {
    back: Returned,
    canvas: Canvas,
    confidence: Vec<Vec<f32>>,
    noise_gain: Vec<Vec<f32>>,
    told: Vec<Told>,
}

impl Found {
    fn tell(&self, findings: &mut SeidelFindings) {
        for (k, told) in self.told.iter().enumerate().take(3) {
            findings.noise[k] = told.noise;
            findings.misfit[k] = told.misfit;
            let (level, count) = told.clipped.unwrap_or((f64::NAN, 0));
            findings.clip_level[k] = level;
            findings.clipped[k] = count as u64;
        }
    }
}

/// The plate without its blur; `progress` is told the share done.
pub(crate) fn unblurred(
    job: &Job,
    colours: usize,
    gain: bool,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Unblurred> {
    let light = job.undeveloped();
    job.seen(|seen| {
        let unblur = job.settings.unblur(colours);
        Ok(unblur.removed(&seen.scene, (&light, &job.weights), gain, progress)?)
    })
}

fn sharp(job: &Job, colours: usize, gain: bool, watch: &Watch) -> Result<Found> {
    let mut found = unblurred(job, colours, gain, &|share| watch.tell(share))?;
    let Some(canvas) = found.canvas() else {
        return Err(Failure::panicked());
    };
    let mut planes = found.sharp();
    if job.settings.raw.grain == SEIDEL_GRAIN_KEEP {
        found.add_grain(&mut planes, false);
    }
    let strength = job.settings.raw.strength as f32;
    if strength < 1.0 {
        for (plane, before) in planes.iter_mut().zip(job.light.planes()) {
            for (sample, before) in plane.iter_mut().zip(canvas.extended(before)) {
                *sample = before + strength * (*sample - before);
            }
        }
    }
    let of = found.colours().iter();
    Ok(Found {
        back: job.light.returned(planes),
        canvas,
        told: of
            .map(|colour| Told {
                noise: colour.noise,
                misfit: colour.misfit,
                clipped: colour.clipped,
            })
            .collect(),
        confidence: found.confidence(),
        noise_gain: std::mem::take(&mut found.noise_gain),
    })
}
