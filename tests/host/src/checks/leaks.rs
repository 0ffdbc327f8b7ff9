//! Instances made and destroyed.

use openfx::sys::generic::core::*;

use super::{Check, Report, stage};
use crate::drive::Instance;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "leaks",
    about: "what CreateInstance takes DestroyInstance gives back",
    run,
};

/// Memory in use, of glibc; nothing elsewhere.
fn in_use() -> Option<usize> {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// `struct mallinfo2`, mallinfo(3).
        #[repr(C)]
        struct Info {
            fields: [usize; 10],
        }
        type Asks = unsafe extern "C" fn() -> Info;
        let process = libloading::os::unix::Library::this();
        // SAFETY: the type is that of the manual; older libraries do not have it.
        let asks = unsafe { process.get::<Asks>(b"mallinfo2\0") }.ok()?;
        // SAFETY: takes nothing, returns numbers.
        let info = unsafe { asks() };
        // Mapped blocks, and those in arenas.
        Some(info.fields[4] + info.fields[7])
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    None
}

/// What an instance costs in the middle of many; growing tables of the host cost more now and then.
fn cost(work: impl Fn()) -> Option<i64> {
    for _ in 0..4 {
        work();
    }
    let mut all = Vec::new();
    for _ in 0..21 {
        let before = in_use()?;
        work();
        all.push(in_use()? as i64 - before as i64);
    }
    all.sort_unstable();
    all.get(10).copied()
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::scene();
        let context = loaded.context(false)?;
        let descriptor = loaded.describe_in(&context)?;
        let life = |created: bool| {
            let instance = Instance::uncreated(loaded, &descriptor, &context, &scene);
            if created {
                instance.act(kOfxActionCreateInstance);
            }
            // Destroyed even if it was not created: `order` looks at that.
            drop(instance);
        };
        let without = cost(|| life(false));
        let with = cost(|| life(true));
        match (without, with) {
            (Some(without), Some(with)) => report.expect(with - without < 16, || {
                format!("every instance leaves {} bytes behind", with - without)
            }),
            _ => report.skip("memory is counted where the C library has mallinfo2"),
        }
        descriptor.end(loaded.host);
        Ok(())
    })
}
