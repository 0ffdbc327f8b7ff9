//! Images with another origin.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::plate;
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "origin",
    about: "translating the project translates the picture",
    run,
};

/// Largest difference, due to rounding of coordinates.
const TOLERANCE: f32 = 1e-4;

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = fixture::reference(subject, report)?;
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        for (dx, dy) in [(-13, 7), (1000, -512), (-45, -37)] {
            let scene = Scene::new(plate(fixture::BOUNDS, 4, 1).translated(dx, dy));
            let frame = fixture::render(loaded, subject, &scene, &RenderRequest::default())?;
            let difference = expected.difference_beyond(
                &frame.picture.translated(-dx, -dy),
                expected.bounds,
                TOLERANCE,
            );
            report.expect_none(difference, &format!("translated by ({dx}, {dy})"));
        }
        Ok(())
    })
}
