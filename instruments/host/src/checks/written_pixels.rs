//! The pixels that a render writes.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "written_pixels",
    about: "a render writes finite values to every pixel of the render window, and to nothing else",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        for scene in [
            fixture::scene(),
            fixture::connect_all(loaded, fixture::scene())?,
        ] {
            let instance = fixture::blurring_instance(loaded, subject, &scene)?;
            fixture::use_depth_and_mask(&instance, subject)?;
            let bounds = fixture::BOUNDS;
            let windows = [
                None,
                Some(bounds),
                Some(Rect::new(3, 5, bounds.x2 - 8, bounds.y2 - 2)),
                Some(Rect::new(17, 11, 18, 12)),
                Some(bounds.expanded(5)),
            ];
            for window in windows {
                for crop_output in [false, true] {
                    let result = instance.render_checked(&RenderRequest {
                        window,
                        crop_output,
                        ..RenderRequest::default()
                    });
                    let case = format!("window {window:?}, output cropped: {crop_output}");
                    report.expect_ok(result, &case);
                }
            }
            instance.destroy()?;
        }
        Ok(())
    })
}
