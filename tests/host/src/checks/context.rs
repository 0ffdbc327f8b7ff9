//! Clips and parameters of every context.

use std::ffi::CStr;

use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, stage};
use crate::host::effect::{Clip, Effect, Setting};
use crate::host::profile::Profile;
use crate::host::properties::Value;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "context",
    about: "each context has the clips it must have, and parameters with defaults inside their ranges",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        for context in loaded.contexts() {
            let descriptor = loaded.describe_in(&context)?;
            let name = context.to_string_lossy();
            clips(&descriptor, &context, &name, report);
            parameters(&descriptor, &name, report);
            descriptor.end(loaded.host);
        }
        Ok(())
    })
}

fn clips(descriptor: &Effect, context: &CStr, name: &str, report: &mut Report) {
    for needed in ["Source", "Output"] {
        report.expect(descriptor.clip(needed).is_some(), || {
            format!("{name}: has no clip {needed}")
        });
    }
    for clip in descriptor.clips() {
        let components = clip
            .properties
            .texts(kOfxImageEffectPropSupportedComponents);
        report.expect(!components.is_empty(), || {
            format!("{name}: clip {} takes no components", clip.name)
        });
        let known = [
            kOfxImageComponentAlpha,
            kOfxImageComponentRGB,
            kOfxImageComponentRGBA,
        ];
        for one in &components {
            report.expect(known.iter().any(|k| k.to_bytes() == one.as_bytes()), || {
                format!(
                    "{name}: clip {} takes {one:?}, which are no components",
                    clip.name
                )
            });
        }
    }
    let optional = |clip: &Clip| clip.properties.int(kOfxImageClipPropOptional) == Some(1);
    let inputs: Vec<_> = (descriptor.clips().into_iter())
        .filter(|c| c.name != "Output")
        .collect();
    // The order of inputs is the order they are shown in, and the first gives the format.
    report.expect(inputs.first().is_some_and(|c| c.name == "Source"), || {
        format!("{name}: Source is not the first input")
    });
    if context == kOfxImageEffectContextFilter {
        for clip in inputs.iter().filter(|c| c.name != "Source") {
            report.expect(optional(clip), || {
                format!("{name}: clip {} of a filter must be optional", clip.name)
            });
        }
    }
}

fn parameters(descriptor: &Effect, name: &str, report: &mut Report) {
    let all = descriptor.parameters.all();
    for parameter in &all {
        let set = &parameter.properties;
        let title = format!("{name}: parameter {}", parameter.name);
        for parent in set
            .texts(kOfxParamPropParent)
            .iter()
            .filter(|p| !p.is_empty())
        {
            let group = |p: &&std::sync::Arc<crate::host::effect::Parameter>| {
                p.name == *parent && p.kind.as_c_str() == kOfxParamTypeGroup
            };
            report.expect(all.iter().any(|p| group(&p)), || {
                format!("{title} has the parent {parent:?}, which is no group")
            });
        }
        let numbers = |property: &CStr| -> Vec<f64> {
            (set.get(property).unwrap_or_default().iter())
                .filter_map(|value| match value {
                    Value::Int(v) => Some(f64::from(*v)),
                    Value::Double(v) => Some(*v),
                    _ => None,
                })
                .collect()
        };
        let first = numbers(kOfxParamPropDefault);
        if parameter.kind.as_c_str() == kOfxParamTypeChoice {
            let options = set.texts(kOfxParamPropChoiceOption).len() as f64;
            let fits = first.iter().all(|v| (0.0..options).contains(v));
            report.expect(fits, || {
                format!("{title} has {options} options and the default {first:?}")
            });
            continue;
        }
        if matches!(parameter.value(), Setting::None | Setting::Text(_)) {
            continue;
        }
        let pairs = [
            (kOfxParamPropMin, kOfxParamPropMax),
            (kOfxParamPropDisplayMin, kOfxParamPropDisplayMax),
        ];
        for (least, most) in pairs {
            let (least, most) = (numbers(least), numbers(most));
            let ordered = least.iter().zip(&most).all(|(a, b)| a < b);
            let finite = least.iter().chain(&most).all(|v| v.is_finite());
            report.expect(ordered && finite, || {
                format!("{title} ranges from {least:?} to {most:?}")
            });
        }
        let (least, most) = (numbers(kOfxParamPropMin), numbers(kOfxParamPropMax));
        let inside = (first.iter().enumerate()).all(|(i, v)| {
            least.get(i).is_none_or(|l| v >= l) && most.get(i).is_none_or(|m| v <= m)
        });
        report.expect(inside, || {
            format!("{title} has the default {first:?} outside {least:?} to {most:?}")
        });
    }
    for parameter in all
        .iter()
        .filter(|p| p.kind.as_c_str() == kOfxParamTypePage)
    {
        for child in parameter.properties.texts(kOfxParamPropPageChild) {
            let known =
                all.iter().any(|p| p.name == child) || child.starts_with("OfxParamPageSkip");
            report.expect(known, || {
                format!(
                    "{name}: page {} shows {child:?}, which is no parameter",
                    parameter.name
                )
            });
        }
    }
}
