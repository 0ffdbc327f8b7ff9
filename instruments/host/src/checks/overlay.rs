//! The overlay.

use super::{Check, Report, fixture};
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "overlay",
    about: "the overlay draws finite points, in its draw action only, and handles a pen",
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
        instance.destroy()
    })
}
