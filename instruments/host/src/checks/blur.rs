//! The blur itself, without which the other checks prove little.

use super::pixel_aspect::spread;
use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::Picture;
use crate::scene::{Input, Scene};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "blur",
    about: "the settings that should blur do, and Depth and Mask have an effect",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    if subject.kind.blur.is_empty() {
        report.skip("no settings are known that blur");
        return Ok(());
    }
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let request = RenderRequest::default();
        let point = Picture::from_fn(fixture::BOUNDS, 4, |x, y, c| {
            if (x, y) == (22, 18) || c == 3 {
                1.0
            } else {
                0.0
            }
        });
        let frame = fixture::render(loaded, subject, &Scene::new(point), &request)?;
        let blurred = spread(&frame.picture);
        report.expect(blurred.x > 0.5 && blurred.y > 0.5, || {
            format!(
                "a blurred point has a standard deviation of ({:.3}, {:.3}) pixels",
                blurred.x, blurred.y
            )
        });
        let plain = fixture::render(loaded, subject, &fixture::scene(), &request)?;
        let inputs = [
            (
                "Depth",
                fixture::depth(fixture::BOUNDS, 4),
                subject.kind.depth,
            ),
            ("Mask", fixture::mask(fixture::BOUNDS), subject.kind.mask),
        ];
        for (clip, picture, settings) in inputs {
            let Some(settings) = settings else {
                report.skip(&format!("no settings are known that use {clip}"));
                continue;
            };
            let scene = fixture::scene().connect(clip, Input::still(picture));
            let instance = fixture::blurring_instance(loaded, subject, &scene)?;
            fixture::apply(&instance, settings)?;
            let frame = instance.render_checked(&request)?;
            instance.destroy()?;
            let difference = plain.picture.difference(&frame.picture, plain.window);
            report.expect(difference.is_some(), || format!("{clip} has no effect"));
        }
        Ok(())
    })
}
