//! Memory that instances leave behind.

use openfx::sys::generic::core::*;

use super::{Check, Report, fixture};
use crate::drive::Instance;
use crate::host::profile::Profile;
use crate::process::allocated_bytes;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "leaks",
    about: "DestroyInstance frees what CreateInstance allocates",
    run,
};

/// Instances created before memory is measured, while caches fill.
const WARM_UP: usize = 4;

/// Instances measured. The median ignores growth of the host's tables, which is rare.
const MEASUREMENTS: usize = 21;

/// The most bytes per instance that count as no leak: less than the smallest allocation.
const MAX_BYTES: i64 = 16;

/// Returns the median of the bytes that a run of `work` leaves allocated.
fn leaked_bytes(work: impl Fn()) -> Option<i64> {
    for _ in 0..WARM_UP {
        work();
    }
    let mut leaked = Vec::new();
    for _ in 0..MEASUREMENTS {
        let before = allocated_bytes()?;
        work();
        leaked.push(allocated_bytes()? as i64 - before as i64);
    }
    leaked.sort_unstable();
    leaked.get(MEASUREMENTS / 2).copied()
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::scene();
        let context = loaded.context(&scene)?;
        let descriptor = loaded.describe_in(&context)?;
        let instance = || Instance::without_create(loaded, &descriptor, &context, &scene);
        // The host itself leaves some bytes per handle. `action_order` checks DestroyInstance without CreateInstance.
        let of_host = leaked_bytes(|| drop(instance()));
        let of_both = leaked_bytes(|| {
            instance().act(kOfxActionCreateInstance);
        });
        match (of_host, of_both) {
            (Some(of_host), Some(of_both)) => report.expect(of_both - of_host < MAX_BYTES, || {
                format!("every instance leaks {} bytes", of_both - of_host)
            }),
            _ => report.skip("the system does not tell how much memory is allocated"),
        }
        descriptor.invalidate(loaded.host);
        Ok(())
    })
}
