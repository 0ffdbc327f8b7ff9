//! Images of a bit depth that the plugin does not support.

use std::ffi::CStr;

use openfx::sys::generic::core::{kOfxBitDepthByte, kOfxBitDepthShort, kOfxStatOK};

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "bit_depths",
    about: "images of unsupported bytes and shorts are rejected with a message, and nothing is written",
    run,
};

const DEPTHS: [&CStr; 2] = [kOfxBitDepthByte, kOfxBitDepthShort];

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    for bit_depth in DEPTHS {
        let profile = Profile {
            bit_depth,
            ..Profile::complete()
        };
        let name = bit_depth.to_string_lossy();
        fixture::with_plugin(subject, report, profile, |loaded, report| {
            if loaded.takes(bit_depth) {
                report.skip(&format!(
                    "the plugin supports {name}, which this host lacks"
                ));
                return Ok(());
            }
            let instance = fixture::blurring_instance(loaded, subject, &fixture::scene())?;
            loaded.host.take_messages();
            let frame = instance.render(&RenderRequest::default())?;
            if frame.status == kOfxStatOK {
                report.fault(format!("the plugin renders images of unsupported {name}"));
            } else {
                let is_unwritten = frame.picture.samples.iter().all(|sample| sample.is_nan());
                report.expect(is_unwritten, || {
                    format!("the plugin rejects images of {name}, but writes to them")
                });
                let messages = loaded.host.take_messages();
                report.expect(messages.iter().any(|m| m.text.len() > 8), || {
                    format!("the plugin rejects images of {name} without a message")
                });
            }
            instance.destroy()
        })?;
    }
    Ok(())
}
