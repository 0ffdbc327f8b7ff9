//! Threads that are left when a plugin is gone.

use super::{Check, Report, stage};
use crate::drive::{Loaded, Request};
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "threads",
    about: "no thread of the plugin is left after Unload",
    run,
};

/// Threads of this process by their numbers, nothing where the system does not say.
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
        report.skip("threads are counted where /proc/self/task lists them");
        return Ok(());
    };
    stage::within(
        subject,
        report,
        Profile::complete(),
        |host, library, report| {
            let plugin = library.find(subject.id.as_deref())?;
            for time in 0..2 {
                let loaded = Loaded::new(host, &plugin)?;
                stage::rendered(&loaded, subject, &stage::scene(), &Request::default())?;
                loaded.unload()?;
                // A thread that has ended may be listed for a moment longer.
                let mut left = Vec::new();
                for _ in 0..100 {
                    left = threads().unwrap_or_default();
                    left.retain(|thread| !before.contains(thread));
                    if left.is_empty() {
                        break;
                    }
                    std::thread::sleep(std::time::Duration::from_millis(20));
                }
                report.expect(left.is_empty(), || {
                    format!("{} threads are left after Unload {}", left.len(), time + 1)
                });
            }
            Ok(())
        },
    )
}
