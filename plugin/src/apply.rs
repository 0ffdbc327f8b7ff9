//! Putting a lens's blur on a plate, or on a part of it.

use seidel_core::plate::{Rendering, Returned, Vergences, apply_bytes};
use seidel_core::render::{self, Occlusion, RenderWindow, Scene};

use crate::callbacks::SeidelCallbacks;
use crate::given::Given;
use crate::guard::guard;
use crate::handles;
use crate::image::{SeidelImage, SeidelRect, View};
use crate::job::{Job, check_memory, write_back};
use crate::lens::SeidelLens;
use crate::plate::{Holdout, Plate, SeidelPlate, plane_count};
use crate::settings::SeidelSettings;
use crate::status::{Failure, Result, SeidelStatus};
use crate::threads::{Watch, run};

/// Puts the blur of a lens on the pixels that `output.rect` names of a plate; it must lie in the plate's extent. `output`
/// may be the memory of the source. Where the source covers what seidel_region_of_interest names, the result is that part
/// of the whole plate's, to the bit. `settings` may be NULL for the defaults, `callbacks` NULL for none. `alphas` gets the
/// alpha of each colour where settings say `alpha_per_channel`; NULL otherwise.
///
/// # Safety
/// All pointers must be NULL or good until the call ends; outputs must not be used by other threads meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_apply(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    output: *const SeidelImage,
    alphas: *const SeidelImage,
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
        let window = window_of(&plate, output.rect, alphas.as_ref())?;
        let planes = plane_count(plate.source.channels, &settings) as u64;
        check_memory(apply_bytes(plate.extent.pixels() as u64, planes), &settings)?;
        let rect = output.rect;
        if settings.raw.amount == 0.0 {
            let parts = plate.parts(&settings)?;
            let back = as_it_is(parts, settings.raw.scrub == 1);
            write_back(&back, plate.extent, (&output, alphas.as_ref()));
            return Ok(());
        }
        let job = Job::new(&lens, &plate, &settings)?;
        let holdout = plate.holdout((&job.sight.predictor, &job.sight.placed), &settings)?;
        let work = move |watch: &Watch| blurred(&job, holdout, window, watch);
        let back = run(settings.raw.threads, &callbacks, work)?;
        write_back(&back, rect, (&output, alphas.as_ref()));
        Ok(())
    })
}

/// The window of the extent that is asked for.
fn window_of(plate: &Plate, rect: SeidelRect, alphas: Option<&View>) -> Result<RenderWindow> {
    if !plate.extent.contains(rect) {
        return Err(Failure::argument(
            "output.rect",
            "is not all in plate.extent",
            "ask for pixels of the plate",
        ));
    }
    if alphas.is_some_and(|view| view.rect != rect) {
        return Err(Failure::argument(
            "alphas.rect",
            "is not that of output",
            "give pictures of the same pixels",
        ));
    }
    Ok(RenderWindow {
        column: (rect.left - plate.extent.left) as usize,
        row: (rect.top - plate.extent.top) as usize,
        width: rect.columns(),
        height: rect.height as usize,
    })
}

/// Planes that stay as they are, to the bit, but for what is scrubbed.
pub(crate) fn as_it_is(mut parts: seidel_core::plate::LightParts, scrub: bool) -> Returned {
    let planes = (parts.colours.iter_mut())
        .chain(&mut parts.alpha)
        .chain(&mut parts.own_alphas);
    if scrub {
        for sample in planes.flatten().filter(|sample| !sample.is_finite()) {
            *sample = 0.0;
        }
    }
    Returned {
        colours: parts.colours,
        alpha: parts.alpha,
        own_alphas: parts.own_alphas,
    }
}

fn blurred(
    job: &Job,
    holdout: Option<Holdout>,
    window: RenderWindow,
    watch: &Watch,
) -> Result<Returned> {
    let settings = &job.settings;
    let lens_use = job.sight.lens_use();
    let planes = lens_use.seen(&job.sight.placed, job.vergence.clone(), |seen| {
        let scene = Scene {
            edges: settings.edges(),
            ..seen.scene
        };
        let holdout = holdout.map(|h| {
            let vergence = h.vergence.map(|v| (seen.refocused)(v)).transpose()?;
            Ok::<_, seidel_core::Error>((h.matte, vergence))
        });
        let holdout = holdout.transpose()?;
        let occlusion = Occlusion {
            fill_foreground: settings.raw.fill_foreground == 1,
            blur_inside: settings.raw.blur_inside == 1,
            holdout: holdout.as_ref().map(|(matte, vergence)| render::Holdout {
                matte,
                vergence: vergence.as_ref().map(Vergences::pass),
            }),
        };
        let rendering = Rendering {
            scene: &scene,
            planes: &job.light.with_weights(&job.weights),
            occlusion: (settings.raw.occlusion == 1).then_some(occlusion),
            extended: settings.is_extended(),
        };
        let inner = settings.renderer();
        let tell = |share| watch.tell(share);
        Ok::<_, Failure>(rendering.window_by(&*inner, window, &tell)?)
    });
    let mut planes = planes?.planes;
    (job.light).develop(&job.sight.predictor, &job.weights, &mut planes);
    Ok(job.light.returned(planes))
}
