//! Inputs of other sizes than Source.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::scene::Input;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "sizes",
    about: "depth and masks larger, smaller, or elsewhere than Source give whole frames",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let set = &loaded.descriptor.properties;
        if set.int(kOfxImageEffectPropSupportsMultiResolution) == Some(0) {
            report.skip("the plugin says that all inputs must be of one size");
            return Ok(());
        }
        let size = stage::SIZE;
        let bounds = [
            size.grown(9),
            size.grown(-7),
            Rect::new(-20, 5, 12, 90),
            size.moved(500, 500),
            Rect::new(3, 3, 4, 4),
        ];
        for (clip, knobs) in [("Depth", subject.kind.depth), ("Mask", subject.kind.mask)] {
            let Some(knobs) = knobs else {
                report.skip(&format!(
                    "nothing is known that makes the plugin look at {clip}"
                ));
                continue;
            };
            for bounds in bounds {
                let picture = if clip == "Mask" {
                    stage::mask(bounds)
                } else {
                    stage::depth(bounds, 4)
                };
                let scene = stage::scene().and(clip, Input::still(picture));
                let instance = stage::blurring(loaded, subject, &scene)?;
                stage::set(&instance, knobs)?;
                for crop in [false, true] {
                    let done = instance.render(&Request {
                        crop,
                        ..Request::default()
                    });
                    report.none(
                        done.and_then(crate::drive::Frame::good).err(),
                        &format!("{clip} of {bounds:?}, inputs cropped: {crop}"),
                    );
                }
                instance.destroy()?;
            }
        }
        Ok(())
    })
}
