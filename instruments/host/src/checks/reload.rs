//! Repeated loading and unloading.

use openfx::sys::generic::core::*;

use super::{Check, Report, fixture};
use crate::drive::{LoadedPlugin, RenderRequest, act};
use crate::host::profile::Profile;
use crate::picture::Picture;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "reload",
    about: "a plugin loaded again renders the same, whether or not its binary was unloaded",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let mut first: Option<Picture> = None;
    let scene = fixture::scene();
    let request = RenderRequest::default();
    for binary in 1..=2 {
        let complete = Profile::complete();
        fixture::with_host(subject, report, complete, |host, plugin, report| {
            for load in 1..=3 {
                let loaded = if load == 1 {
                    LoadedPlugin::load(host, plugin)?
                } else {
                    LoadedPlugin::load_again(host, plugin)?
                };
                let frame = fixture::render(&loaded, subject, &scene, &request)?;
                loaded.unload()?;
                let case = format!("load {load} of binary {binary}");
                match &first {
                    Some(first) => report.expect_same(first, &frame, &case),
                    None => first = Some(frame.picture),
                }
            }
            let loaded = LoadedPlugin::load_again(host, plugin)?;
            let loaded_twice = LoadedPlugin::load_again(host, plugin)?;
            let frame = fixture::render(&loaded_twice, subject, &scene, &request)?;
            if let Some(first) = &first {
                report.expect_same(first, &frame, "loaded twice");
            }
            loaded_twice.unload()?;
            loaded.unload()?;
            // One Unload too many must not crash.
            act(plugin, kOfxActionUnload, 0);
            Ok(())
        })?;
    }
    Ok(())
}
