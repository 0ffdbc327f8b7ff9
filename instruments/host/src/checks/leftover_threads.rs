//! Threads that remain after Unload.

use std::time::Duration;

use super::{Check, Report, fixture};
use crate::drive::{LoadedPlugin, RenderRequest};
use crate::host::profile::Profile;
use crate::process::thread_ids;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "leftover_threads",
    about: "no thread of the plugin remains after Unload",
    run,
};

/// The number of times that threads are listed before they count as left over, since the system may list a thread for a
/// moment after it has ended.
const ATTEMPTS: usize = 100;

/// The time between two of these.
const INTERVAL: Duration = Duration::from_millis(20);

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let Some(before) = thread_ids() else {
        report.skip("the system does not list threads");
        return Ok(());
    };
    let complete = Profile::complete();
    fixture::with_host(subject, report, complete, |host, plugin, report| {
        for load in 1..=2 {
            let loaded = LoadedPlugin::load(host, plugin)?;
            fixture::render(
                &loaded,
                subject,
                &fixture::scene(),
                &RenderRequest::default(),
            )?;
            loaded.unload()?;
            let mut left = Vec::new();
            for _ in 0..ATTEMPTS {
                left = thread_ids().unwrap_or_default();
                left.retain(|thread| !before.contains(thread));
                if left.is_empty() {
                    break;
                }
                std::thread::sleep(INTERVAL);
            }
            report.expect(left.is_empty(), || {
                format!("{} threads remain after Unload {load}", left.len())
            });
        }
        Ok(())
    })
}
