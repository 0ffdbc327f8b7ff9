//! Threads that remain after Unload.

use std::time::Duration;

use super::{Check, Report, fixture};
use crate::drive::{LoadedPlugin, RenderRequest};
use crate::host::profile::Profile;
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

/// Returns the identifiers of this process's threads, if the system lists them.
fn threads() -> Option<Vec<String>> {
    let entries = std::fs::read_dir("/proc/self/task").ok()?;
    Some(
        entries
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect(),
    )
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let Some(before) = threads() else {
        report.skip("threads are not listed in /proc/self/task");
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
                left = threads().unwrap_or_default();
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
