//! Actions that nobody knows, and actions without arguments.

use std::ffi::CStr;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::{Request, act, status_name};
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "arguments",
    about: "unknown actions get ReplyDefault, and NULL for handles and arguments crashes nothing",
    run,
};

const KNOWN: [&CStr; 24] = [
    kOfxImageEffectActionDescribeInContext,
    kOfxImageEffectActionGetRegionOfDefinition,
    kOfxImageEffectActionGetRegionsOfInterest,
    kOfxImageEffectActionGetTimeDomain,
    kOfxImageEffectActionGetFramesNeeded,
    kOfxImageEffectActionGetClipPreferences,
    kOfxImageEffectActionIsIdentity,
    kOfxImageEffectActionRender,
    kOfxImageEffectActionBeginSequenceRender,
    kOfxImageEffectActionEndSequenceRender,
    c"OfxImageEffectActionGetOutputColourspace",
    c"OfxActionOpenGLContextAttached",
    c"kOfxActionOpenGLContextDetached",
    kOfxActionPurgeCaches,
    kOfxActionSyncPrivateData,
    kOfxActionInstanceChanged,
    kOfxActionBeginInstanceChanged,
    kOfxActionEndInstanceChanged,
    kOfxActionBeginInstanceEdit,
    kOfxActionEndInstanceEdit,
    kOfxActionDescribe,
    kOfxActionCreateInstance,
    kOfxActionDestroyInstance,
    kOfxActionLoad,
];

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::scene();
        let instance = stage::blurring(loaded, subject, &scene)?;
        let handles = [0, loaded.descriptor.handle(), instance.effect.handle()];
        for action in [c"OfxActionOfAnotherTime", c"", c"OfxActionLoad "] {
            for handle in handles {
                let status = act(&loaded.plugin, action, handle, None, None, None);
                report.expect(status == kOfxStatReplyDefault, || {
                    format!("the action {action:?} gave {}", status_name(status))
                });
            }
        }
        for action in KNOWN.iter().filter(|a| **a != kOfxActionLoad) {
            if [kOfxActionDestroyInstance, kOfxActionCreateInstance].contains(action) {
                continue;
            }
            let status = act(
                &loaded.plugin,
                action,
                instance.effect.handle(),
                None,
                None,
                None,
            );
            report.expect(status != kOfxStatErrFatal, || {
                format!("{action:?} without arguments gave {}", status_name(status))
            });
        }
        // What describes or changes a descriptor was called on an instance: that is the host's fault.
        let about_arguments: Vec<String> = (loaded.host.take_misuse().into_iter())
            .filter(|text| text.contains("NULL handle"))
            .collect();
        for text in about_arguments {
            report.fault(format!("of arguments that are NULL: {text}"));
        }
        for action in KNOWN {
            act(&loaded.plugin, action, 0, None, None, None);
        }
        loaded.host.take_misuse();
        // Load was called once more than Unload will be.
        act(&loaded.plugin, kOfxActionUnload, 0, None, None, None);
        let frame = instance.render(&Request::default())?.good()?;
        instance.destroy()?;
        let again = stage::rendered(loaded, subject, &scene, &Request::default())?;
        report.none(
            frame.picture.difference(&again.picture, frame.window),
            "after actions without arguments",
        );
        Ok(())
    })
}
