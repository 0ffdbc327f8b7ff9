//! Fields.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::Picture;
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "fields",
    about: "of a field its own rows alone are written and read",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        for (name, field, rows) in [
            ("lower", kOfxImageFieldLower, 0),
            ("upper", kOfxImageFieldUpper, 1),
        ] {
            let request = Request {
                field,
                window: Some(stage::SIZE),
                ..Request::default()
            };
            let usual = crate::picture::plate(stage::SIZE, 4, 1);
            let other = Picture::made(stage::SIZE, 4, |x, y, c| {
                if y.rem_euclid(2) == rows {
                    usual.pixel(x, y)[c]
                } else {
                    0.25
                }
            });
            let mut frames = Vec::new();
            for source in [usual, other] {
                frames.push(stage::rendered(
                    loaded,
                    subject,
                    &Scene::of(source),
                    &request,
                )?);
            }
            if let [first, second] = &frames[..] {
                report.none(
                    first.picture.difference(&second.picture, second.window),
                    &format!("the {name} field with other rows in the other field"),
                );
            }
        }
        Ok(())
    })
}
