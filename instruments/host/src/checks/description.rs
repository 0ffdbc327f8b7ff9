//! The effect descriptor.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::status_name;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "description",
    about: "label, contexts, bit depths and thread safety are described and valid",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let set = &loaded.descriptor.properties;
        report.expect(loaded.load_status == kOfxStatOK, || {
            let status = status_name(loaded.load_status);
            format!("Load returned {status}, which some hosts take for a failure")
        });
        report.expect(
            set.texts(kOfxPropLabel).iter().any(|l| !l.is_empty()),
            || "the plugin has no label".to_owned(),
        );
        let contexts = set.texts(kOfxImageEffectPropSupportedContexts);
        report.expect(!contexts.is_empty(), || {
            "the plugin supports no context".to_owned()
        });
        for context in &contexts {
            report.expect(context.starts_with("OfxImageEffectContext"), || {
                format!("{context:?} is not a context")
            });
        }
        let depths = set.texts(kOfxImageEffectPropSupportedPixelDepths);
        report.expect(!depths.is_empty(), || {
            "the plugin supports no bit depth".to_owned()
        });
        let known = [
            kOfxBitDepthByte,
            kOfxBitDepthShort,
            kOfxBitDepthHalf,
            kOfxBitDepthFloat,
        ];
        for depth in &depths {
            report.expect(
                known.iter().any(|k| k.to_bytes() == depth.as_bytes()),
                || format!("{depth:?} is not a bit depth"),
            );
        }
        let safety = set.texts(kOfxImageEffectPluginRenderThreadSafety);
        let known = [
            kOfxImageEffectRenderUnsafe,
            kOfxImageEffectRenderInstanceSafe,
            kOfxImageEffectRenderFullySafe,
        ];
        let valid = (safety.iter()).all(|s| known.iter().any(|k| k.to_bytes() == s.as_bytes()));
        report.expect(safety.len() == 1 && valid, || {
            format!("{safety:?} is not a thread safety")
        });
        // Hosts may describe a plugin again.
        let again = crate::drive::new_descriptor(loaded.host);
        let status = loaded.describe(&again);
        report.expect(status == kOfxStatOK, || {
            "the plugin cannot be described twice".to_owned()
        });
        report.expect(again.properties.all() == set.all(), || {
            "the second description differs".to_owned()
        });
        again.invalidate(loaded.host);
        Ok(())
    })
}
