//! Unknown actions, and actions without arguments.

use std::ffi::CStr;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::{RenderRequest, act, status_name};
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "null_arguments",
    about: "unknown actions return ReplyDefault; NULL handles and arguments do not crash",
    run,
};

/// Actions that are called with a valid instance.
const INSTANCE_ACTIONS: [&CStr; 21] = [
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
];

/// Further actions that are called with a NULL handle only.
const LIFETIME_ACTIONS: [&CStr; 3] = [
    kOfxActionCreateInstance,
    kOfxActionDestroyInstance,
    kOfxActionLoad,
];

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let plugin = &loaded.plugin;
        let scene = fixture::scene();
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        let handles = [0, loaded.descriptor.handle(), instance.effect.handle()];
        for action in [c"OfxActionOfTheFuture", c"", c"OfxActionLoad "] {
            for handle in handles {
                let status = act(plugin, action, handle);
                report.expect(status == kOfxStatReplyDefault, || {
                    format!(
                        "the unknown action {action:?} returned {}",
                        status_name(status)
                    )
                });
            }
        }
        for action in INSTANCE_ACTIONS {
            let status = instance.act(action);
            report.expect(status != kOfxStatErrFatal, || {
                format!(
                    "{action:?} without arguments returned {}",
                    status_name(status)
                )
            });
        }
        // Other misuse is the fault of this check: it describes and changes an instance.
        for text in loaded.host.take_misuse() {
            if text.contains("NULL handle") {
                report.fault(format!("an action without arguments: {text}"));
            }
        }
        for action in INSTANCE_ACTIONS.iter().chain(&LIFETIME_ACTIONS) {
            act(plugin, action, 0);
        }
        loaded.host.take_misuse();
        // Balances the second Load.
        act(plugin, kOfxActionUnload, 0);
        let frame = instance.render_checked(&RenderRequest::default())?;
        instance.destroy()?;
        let again = fixture::render(loaded, subject, &scene, &RenderRequest::default())?;
        report.expect_same(&frame.picture, &again, "after actions without arguments");
        Ok(())
    })
}
