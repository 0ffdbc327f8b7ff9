//! A plate taken with one lens as another would have drawn it.

use seidel_core::plate::Returned;

use crate::apply::as_it_is;
use crate::callbacks::SeidelCallbacks;
use crate::given::Given;
use crate::guard::guard;
use crate::handles;
use crate::image::SeidelImage;
use crate::job::{Job, Sight, write_back};
use crate::lens::SeidelLens;
use crate::plate::{Plate, SeidelPlate};
use crate::remove::{check_bounds, unblurred};
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, Result, SeidelStatus};
use crate::threads::{Watch, run};

/// Share of the work that is taking blur off.
const REMOVAL_SHARE: f64 = 0.9;

/// Takes the blur of the lens `from` off a plate and puts that of `to` on; the plate keeps its grain. Settings hold for
/// both lenses. All else is as in seidel_remove, but that `output.rect` must lie in the extent.
///
/// # Safety
/// That of seidel_apply.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_relens(
    from: *const SeidelLens,
    to: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    output: *const SeidelImage,
    alphas: *const SeidelImage,
    callbacks: *const SeidelCallbacks,
) -> SeidelStatus {
    guard(|| {
        let (from, to) = (handles::lens(from)?, handles::lens(to)?);
        // SAFETY: as the caller vouches.
        let given = unsafe { Given::new(settings, plate, (output, alphas), callbacks)? };
        let Given {
            settings,
            plate,
            output,
            alphas,
            callbacks,
        } = given;
        if !plate.extent.contains(output.rect) {
            return Err(Failure::argument(
                "output.rect",
                "is not all in plate.extent",
                "ask for pixels of the plate",
            ));
        }
        check_bounds(&plate, &settings)?;
        let back = if settings.raw.amount == 0.0 {
            as_it_is(plate.parts(&settings)?, settings.raw.scrub == 1)
        } else {
            let job = Job::new(&from, &plate, &settings)?;
            let other = Other::new(&to, &plate, &settings)?;
            let colours = plate.colour_count();
            let work = move |watch: &Watch| seen_anew(&job, &other, colours, watch);
            run(settings.raw.threads, &callbacks, work)?
        };
        write_back(&back, plate.extent, (&output, alphas.as_ref()));
        Ok(())
    })
}

/// The lens whose blur is put on.
struct Other {
    sight: Sight,
    weights: Vec<Vec<f64>>,
    vergence: seidel_core::plate::Vergences,
}

impl Other {
    fn new(
        lens: &std::sync::Arc<crate::lens::Lens>,
        plate: &Plate,
        settings: &Settings,
    ) -> Result<Self> {
        let sight = Sight::new(lens, settings, |lens| plate.placed(lens, settings))?;
        Ok(Self {
            weights: plate.weights(&sight.predictor, settings)?,
            vergence: plate.vergence((&sight.predictor, &sight.placed), settings)?,
            sight,
        })
    }
}

fn seen_anew(job: &Job, other: &Other, colours: usize, watch: &Watch) -> Result<Returned> {
    let found = unblurred(job, colours, false, &|share| {
        watch.tell(REMOVAL_SHARE * share)
    })?;
    let Other {
        sight,
        weights,
        vergence,
    } = other;
    let planes = sight
        .lens_use()
        .seen(&sight.placed, vergence.clone(), |seen| {
            let tell = |share| watch.tell(REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share);
            let lens = (&seen.scene, &sight.predictor);
            Ok::<_, Failure>(found.seen_by(lens, (&job.light, weights), &tell)?)
        })?;
    Ok(job.light.returned(planes))
}
