//! Renders of single fields.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::{Picture, plate};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "fields",
    about: "a field is rendered from its own rows, and only they are written",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        for (name, field, parity) in [
            ("lower", kOfxImageFieldLower, 0),
            ("upper", kOfxImageFieldUpper, 1),
        ] {
            let request = RenderRequest {
                field,
                ..RenderRequest::of_window(fixture::BOUNDS)
            };
            let render =
                |source: Picture| fixture::render(loaded, subject, &Scene::new(source), &request);
            let source = plate(fixture::BOUNDS, 4, 1);
            let other = Picture::from_fn(fixture::BOUNDS, 4, |x, y, c| {
                if y.rem_euclid(2) == parity {
                    source.pixel(x, y)[c]
                } else {
                    0.25
                }
            });
            let expected = render(source)?.picture;
            report.expect_same(
                &expected,
                &render(other)?,
                &format!("the {name} field, with other rows in the other field"),
            );
        }
        Ok(())
    })
}
