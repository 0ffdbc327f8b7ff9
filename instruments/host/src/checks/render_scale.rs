//! Renders at half scale.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::{Picture, Rect};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "render_scale",
    about: "a render at half scale equals the downsampled full one, even if regions are in pixels of that scale",
    run,
};

/// The largest difference between regions of definition at half and at full scale, in canonical pixels.
const REGION_TOLERANCE: f64 = 4.0;

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    check(subject, report, Profile::complete(), "at half scale")?;
    let pixel_regions = Profile {
        pixel_regions: true,
        ..Profile::complete()
    };
    check(
        subject,
        report,
        pixel_regions,
        "with regions in pixels of half scale",
    )
}

fn check(
    subject: &Subject,
    report: &mut Report,
    profile: Profile,
    case: &str,
) -> Result<(), String> {
    fixture::with_plugin(subject, report, profile, |loaded, report| {
        let full_window = Rect::new(0, 0, 64, 48);
        let square = Picture::from_fn(full_window, 4, |x, y, c| {
            let is_lit = Rect::new(20, 16, 44, 32).contains(x, y);
            if is_lit || c == 3 { 1.0 } else { 0.0 }
        });
        let instance = fixture::blurring_instance(loaded, subject, &Scene::new(square))?;
        let full = instance.render_checked(&RenderRequest::of_window(full_window))?;
        let half_window = Rect::new(0, 0, 32, 24);
        let half = instance.render_checked(&RenderRequest {
            scale: (0.5, 0.5),
            ..RenderRequest::of_window(half_window)
        })?;
        let difference = full.picture.half_scale().difference_beyond(
            &half.picture,
            half_window,
            subject.kind.half_scale_tolerance,
        );
        report.expect_none(difference, case);
        // Regions of definition are canonical, so they are the same but for rounding to pixels.
        let half_rod = instance.region_of_definition(0.0, (0.5, 0.5))?;
        let full_rod = instance.region_of_definition(0.0, (1.0, 1.0))?;
        let is_close = (half_rod.corners().iter().zip(full_rod.corners()))
            .all(|(a, b)| (a - b).abs() <= REGION_TOLERANCE);
        report.expect(is_close, || {
            format!(
                "the region of definition is {half_rod:?} at half scale and {full_rod:?} at full"
            )
        });
        instance.destroy()
    })
}
