//! The overlay, and handles of positions.

use std::sync::atomic::Ordering;

use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, fixture};
use crate::drive::Instance;
use crate::host::effect::ParameterValue;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "overlay",
    about: "the overlay draws finite points, in its draw action only, and handles a pen; a drag is one step of undo",
    run,
};

// The host records wrong draw calls as misuse.
fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::connect_all(loaded, fixture::scene())?;
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        for pen in [(22.5, 18.5), (-100.0, 1e6)] {
            if instance.use_overlay(pen)?.is_none() {
                report.skip("the plugin has no overlay that uses the draw suite");
                break;
            }
        }
        for name in positions(&instance) {
            check_drag(&instance, &name, report)?;
        }
        instance.destroy()
    })
}

/// Returns the names of the parameters that are positions in the picture.
fn positions(instance: &Instance<'_>) -> Vec<String> {
    let mut all = instance.effect.parameters.all();
    all.retain(|one| {
        let types = one.properties.texts(kOfxParamPropDoubleType);
        one.kind.as_c_str() == kOfxParamTypeDouble2D
            && types
                .iter()
                .any(|t| t.as_bytes() == kOfxParamDoubleTypeXYAbsolute.to_bytes())
    });
    all.into_iter().map(|one| one.name.clone()).collect()
}

/// Checks the undo steps of a drag of the parameter `name`, whose handle the plugin draws, or the host.
fn check_drag(instance: &Instance<'_>, name: &str, report: &mut Report) -> Result<(), String> {
    let steps = || {
        let counter = &instance.loaded.host.counters.undo_steps;
        counter.swap(0, Ordering::SeqCst)
    };
    let at = |x: f64| ParameterValue::Doubles(vec![x, 18.5]);
    instance.set(name, &at(22.5))?;
    steps();
    instance.use_overlay((22.5, 18.5))?;
    let of_plugin = steps();
    report.expect(of_plugin <= 1, || {
        format!("a drag of {name} in the overlay makes {of_plugin} steps of undo")
    });
    for x in [12.5, 14.5, 16.5] {
        instance.edit(name, &at(x))?;
    }
    let beside_host = steps();
    report.expect(beside_host == 0, || {
        format!("a drag of {name} by the handle of the host makes {beside_host} steps of undo beside the host's own")
    });
    Ok(())
}
