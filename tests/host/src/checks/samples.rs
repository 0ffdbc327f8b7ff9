//! Hosts that hand in other samples than the plugin says it takes.

use std::ffi::CStr;

use openfx::sys::generic::core::{kOfxBitDepthByte, kOfxBitDepthShort, kOfxStatOK};
use openfx::sys::image_effect_v1::image_effect::kOfxImageEffectPropSupportedPixelDepths;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "samples",
    about: "pictures of bytes and shorts that the plugin does not say it takes are refused in words, and nothing is written",
    run,
};

const OTHERS: [&CStr; 2] = [kOfxBitDepthByte, kOfxBitDepthShort];

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    for samples in OTHERS {
        let profile = Profile {
            samples,
            ..Profile::complete()
        };
        let name = samples.to_string_lossy();
        stage::on(subject, report, profile, |loaded, report| {
            let takes = (loaded.descriptor.properties)
                .texts(kOfxImageEffectPropSupportedPixelDepths)
                .iter()
                .any(|depth| depth.as_bytes() == samples.to_bytes());
            if takes {
                report.skip(&format!("the plugin takes {name}, which this host has not"));
                return Ok(());
            }
            let instance = stage::blurring(loaded, subject, &stage::scene())?;
            loaded.host.take_messages();
            let frame = instance.render(&Request::default())?;
            report.expect(frame.status != kOfxStatOK, || {
                format!("renders pictures of {name}, which it does not say it takes")
            });
            if frame.status != kOfxStatOK {
                let unwritten = frame.picture.samples.iter().all(|sample| sample.is_nan());
                report.expect(unwritten, || {
                    format!("refuses pictures of {name}, and writes to them")
                });
                let told = loaded.host.take_messages();
                report.expect(told.iter().any(|message| message.text.len() > 8), || {
                    format!("refuses pictures of {name}, and does not say so")
                });
            }
            instance.destroy()
        })?;
    }
    Ok(())
}
