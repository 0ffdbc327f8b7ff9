//! Where pictures begin.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::plate;
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "origin",
    about: "a project that begins elsewhere has the same picture there",
    run,
};

/// Coordinates are rounded otherwise elsewhere.
const TOLERANCE: f32 = 1e-4;

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = stage::usual(subject, report)?;
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        for (dx, dy) in [(-13, 7), (1000, -512), (-45, -37)] {
            let moved = plate(stage::SIZE, 4, 1).moved(dx, dy);
            let frame = stage::rendered(loaded, subject, &Scene::of(moved), &Request::default())?;
            let back = frame.picture.moved(-dx, -dy);
            report.none(
                (expected.picture).difference_over(&back, expected.window, TOLERANCE),
                &format!("moved by ({dx}, {dy})"),
            );
        }
        Ok(())
    })
}
