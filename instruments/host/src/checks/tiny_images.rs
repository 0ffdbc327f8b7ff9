//! Images of few pixels or none.

use super::{Check, Report, fixture};
use crate::drive::{RenderRequest, status_name};
use crate::host::profile::Profile;
use crate::picture::{Rect, plate};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "tiny_images",
    about: "images of one pixel, row or column render; empty images and windows do not crash",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        for (width, height) in [(1, 1), (1, 9), (9, 1), (2, 2)] {
            let scene = Scene::new(plate(Rect::new(0, 0, width, height), 4, 1));
            let result = fixture::render(loaded, subject, &scene, &RenderRequest::default());
            report.expect_ok(result, &format!("an image of {width} x {height}"));
        }
        let empty = Scene::new(plate(Rect::new(0, 0, 0, 0), 4, 1));
        for (case, scene, window) in [
            ("an empty Source", empty, Rect::new(0, 0, 4, 4)),
            ("an empty window", fixture::scene(), Rect::new(5, 5, 5, 5)),
        ] {
            let instance = fixture::blurring_instance(loaded, subject, &scene)?;
            let frame = instance.render(&RenderRequest::of_window(window))?;
            // Both success and failure are valid.
            report.expect([0, 1].contains(&frame.status), || {
                format!("{case}: Render returned {}", status_name(frame.status))
            });
            for fault in frame.faults {
                report.fault(format!("{case}: {fault}"));
            }
            instance.destroy()?;
        }
        Ok(())
    })
}
