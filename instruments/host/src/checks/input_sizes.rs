//! Inputs of other sizes than Source.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::scene::Input;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "input_sizes",
    about: "the whole frame is rendered if Depth or Mask is larger, smaller or elsewhere than Source",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let set = &loaded.descriptor.properties;
        if set.int(kOfxImageEffectPropSupportsMultiResolution) == Some(0) {
            report.skip("the plugin declares that all inputs must have the same size");
            return Ok(());
        }
        let source = fixture::BOUNDS;
        let all_bounds = [
            source.expanded(9),
            source.expanded(-7),
            Rect::new(-20, 5, 12, 90),
            source.translated(500, 500),
            Rect::new(3, 3, 4, 4),
        ];
        for (clip, settings) in [("Depth", subject.kind.depth), ("Mask", subject.kind.mask)] {
            let Some(settings) = settings else {
                report.skip(&format!("no settings are known that use {clip}"));
                continue;
            };
            for bounds in all_bounds {
                let picture = if clip == "Mask" {
                    fixture::mask(bounds)
                } else {
                    fixture::depth(bounds, 4)
                };
                let scene = fixture::scene().connect(clip, Input::still(picture));
                let instance = fixture::blurring_instance(loaded, subject, &scene)?;
                fixture::apply(&instance, settings)?;
                for crop_inputs in [false, true] {
                    let result = instance.render_checked(&RenderRequest {
                        crop_inputs,
                        ..RenderRequest::default()
                    });
                    let case = format!("{clip} of {bounds:?}, inputs cropped: {crop_inputs}");
                    report.expect_ok(result, &case);
                }
                instance.destroy()?;
            }
        }
        Ok(())
    })
}
