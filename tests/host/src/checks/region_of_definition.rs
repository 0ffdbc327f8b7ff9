//! Whether there is anything outside the region of definition.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "region_of_definition",
    about: "outside the region of definition the picture is transparent black",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let instance = stage::blurring(loaded, subject, &stage::scene())?;
        let rod = instance
            .region_of_definition(0.0, (1.0, 1.0))?
            .pixels((1.0, 1.0), 1.0);
        report.expect(rod.width() < 100_000 && rod.height() < 100_000, || {
            format!("is {rod:?} for a picture of {:?}", stage::SIZE)
        });
        let window = rod.grown(6);
        let frame = instance
            .render(&Request {
                window: Some(window),
                ..Request::default()
            })?
            .good()?;
        let lit = (window.pixels())
            .filter(|(x, y)| !rod.contains(*x, *y))
            .find(|(x, y)| frame.picture.pixel(*x, *y).iter().any(|v| *v != 0.0));
        report.expect(lit.is_none(), || {
            format!("{lit:?} is not 0 and lies outside {rod:?}")
        });
        instance.destroy()
    })
}
