//! The clips and parameters of every context.

use std::ffi::CStr;

use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, fixture};
use crate::host::effect::{Clip, Effect, Parameter, ParameterValue};
use crate::host::profile::Profile;
use crate::host::properties::{PropertySet, Value};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "contexts",
    about: "each context has the required clips, and parameters with defaults within their ranges",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        for context in loaded.contexts() {
            let descriptor = loaded.describe_in(&context)?;
            let name = context.to_string_lossy();
            check_clips(&descriptor, &context, &name, report);
            check_parameters(&descriptor, &name, report);
            descriptor.invalidate(loaded.host);
        }
        Ok(())
    })
}

fn check_clips(descriptor: &Effect, context: &CStr, name: &str, report: &mut Report) {
    for required in ["Source", "Output"] {
        report.expect(descriptor.clip(required).is_some(), || {
            format!("{name}: there is no clip {required}")
        });
    }
    for clip in descriptor.clips() {
        let components = clip
            .properties
            .texts(kOfxImageEffectPropSupportedComponents);
        report.expect(!components.is_empty(), || {
            format!("{name}: clip {} supports no components", clip.name)
        });
        let known = [
            kOfxImageComponentAlpha,
            kOfxImageComponentRGB,
            kOfxImageComponentRGBA,
        ];
        for one in &components {
            report.expect(known.iter().any(|k| k.to_bytes() == one.as_bytes()), || {
                format!(
                    "{name}: clip {} supports the unknown components {one:?}",
                    clip.name
                )
            });
        }
    }
    let is_optional = |clip: &Clip| clip.properties.int(kOfxImageClipPropOptional) == Some(1);
    let inputs: Vec<_> = (descriptor.clips().into_iter())
        .filter(|c| c.name != "Output")
        .collect();
    // Hosts show inputs in this order and take the format of the first.
    report.expect(inputs.first().is_some_and(|c| c.name == "Source"), || {
        format!("{name}: Source is not the first input")
    });
    if context == kOfxImageEffectContextFilter {
        for clip in inputs.iter().filter(|c| c.name != "Source") {
            report.expect(is_optional(clip), || {
                format!("{name}: clip {} is not optional", clip.name)
            });
        }
    }
}

fn check_parameters(descriptor: &Effect, name: &str, report: &mut Report) {
    let all = descriptor.parameters.all();
    let is_group = |name: &str| {
        all.iter()
            .any(|p| p.name == name && p.kind.as_c_str() == kOfxParamTypeGroup)
    };
    for parameter in &all {
        let title = format!("{name}: parameter {}", parameter.name);
        for parent in parameter.properties.texts(kOfxParamPropParent) {
            report.expect(parent.is_empty() || is_group(&parent), || {
                format!("{title} has the parent {parent:?}, which is not a group")
            });
        }
        check_default(parameter, &title, report);
        if parameter.kind.as_c_str() == kOfxParamTypePage {
            for child in parameter.properties.texts(kOfxParamPropPageChild) {
                let is_known =
                    all.iter().any(|p| p.name == child) || child.starts_with("OfxParamPageSkip");
                report.expect(is_known, || {
                    format!("{title} shows {child:?}, which is not a parameter")
                });
            }
        }
    }
}

/// Checks the default and the ranges of a parameter.
fn check_default(parameter: &Parameter, title: &str, report: &mut Report) {
    let set = &parameter.properties;
    let default = numbers(set, kOfxParamPropDefault);
    if parameter.kind.as_c_str() == kOfxParamTypeChoice {
        let options = set.texts(kOfxParamPropChoiceOption).len() as f64;
        let is_valid = default.iter().all(|v| (0.0..options).contains(v));
        report.expect(is_valid, || {
            format!("{title} has {options} options and the default {default:?}")
        });
        return;
    }
    if matches!(
        parameter.value(),
        ParameterValue::None | ParameterValue::Text(_)
    ) {
        return;
    }
    for (min, max) in [
        (kOfxParamPropMin, kOfxParamPropMax),
        (kOfxParamPropDisplayMin, kOfxParamPropDisplayMax),
    ] {
        let (min, max) = (numbers(set, min), numbers(set, max));
        let is_ordered = min.iter().zip(&max).all(|(a, b)| a < b);
        let is_finite = min.iter().chain(&max).all(|v| v.is_finite());
        report.expect(is_ordered && is_finite, || {
            format!("{title} has the range {min:?} to {max:?}")
        });
    }
    let (min, max) = (
        numbers(set, kOfxParamPropMin),
        numbers(set, kOfxParamPropMax),
    );
    let is_inside = (default.iter().enumerate()).all(|(i, v)| {
        min.get(i).is_none_or(|min| v >= min) && max.get(i).is_none_or(|max| v <= max)
    });
    report.expect(is_inside, || {
        format!("{title} has the default {default:?} outside {min:?} to {max:?}")
    });
}

/// Returns the numbers in a property.
fn numbers(set: &PropertySet, property: &CStr) -> Vec<f64> {
    (set.get(property).unwrap_or_default().iter())
        .filter_map(|value| match value {
            Value::Int(v) => Some(f64::from(*v)),
            Value::Double(v) => Some(*v),
            _ => None,
        })
        .collect()
}
