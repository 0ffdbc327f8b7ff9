//! The region of definition.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "region_of_definition",
    about: "outside the region of definition the picture is transparent black",
    run,
};

/// The largest plausible width and height, in pixels.
const MAX_SIZE: usize = 100_000;

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let instance = fixture::blurring_instance(loaded, subject, &fixture::scene())?;
        let rod = instance
            .region_of_definition(0.0, (1.0, 1.0))?
            .pixels((1.0, 1.0), 1.0);
        if rod.width() >= MAX_SIZE || rod.height() >= MAX_SIZE {
            return Err(format!(
                "the region of definition is {rod:?} for a picture of {:?}",
                fixture::BOUNDS
            ));
        }
        let window = rod.expanded(6);
        let frame = instance.render_checked(&RenderRequest::of_window(window))?;
        let outside = (window.pixels())
            .filter(|(x, y)| !rod.contains(*x, *y))
            .find(|(x, y)| frame.picture.pixel(*x, *y).iter().any(|v| *v != 0.0));
        if let Some(pixel) = outside {
            report.fault(format!(
                "the pixel {pixel:?} is not black, but lies outside {rod:?}"
            ));
        }
        instance.destroy()
    })
}
