//! Whether there is anything for the other checks to look at.

use super::pixel_aspect::spread;
use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::Picture;
use crate::scene::{Input, Scene};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "blur",
    about: "settings that are to blur do, and depth and masks that are to be looked at make a difference",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    if subject.kind.blur.is_empty() {
        report.skip("nothing is known that makes the plugin blur");
        return Ok(());
    }
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let point = Picture::made(stage::SIZE, 4, |x, y, c| {
            if (x, y) == (22, 18) || c == 3 {
                1.0
            } else {
                0.0
            }
        });
        let frame = stage::rendered(loaded, subject, &Scene::of(point), &Request::default())?;
        let (across, up) = spread(&frame.picture);
        report.expect(across > 0.5 && up > 0.5, || {
            format!("a point is {across:.3} pixels wide and {up:.3} high")
        });
        let inputs = [
            ("Depth", stage::depth(stage::SIZE, 4), subject.kind.depth),
            ("Mask", stage::mask(stage::SIZE), subject.kind.mask),
        ];
        for (clip, picture, knobs) in inputs {
            let Some(knobs) = knobs else {
                report.skip(&format!(
                    "nothing is known that makes the plugin look at {clip}"
                ));
                continue;
            };
            let plain = stage::rendered(loaded, subject, &stage::scene(), &Request::default())?;
            let scene = stage::scene().and(clip, Input::still(picture));
            let instance = stage::blurring(loaded, subject, &scene)?;
            stage::set(&instance, knobs)?;
            let frame = instance.render(&Request::default())?.good()?;
            instance.destroy()?;
            let differs = plain
                .picture
                .difference(&frame.picture, plain.window)
                .is_some();
            report.expect(differs, || format!("{clip} makes no difference"));
        }
        Ok(())
    })
}
