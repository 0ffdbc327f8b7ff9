//! The overlay.

use super::{Check, Report, stage};
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "overlay",
    about: "an overlay draws with finite points inside its draw action, and bears a pen",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::with_all(loaded, stage::scene())?;
        let instance = stage::blurring(loaded, subject, &scene)?;
        let mut drawn = None;
        for pen in [(22.5, 18.5), (-100.0, 1e6)] {
            drawn = instance.overlay(pen)?;
        }
        if drawn.is_none() {
            report.skip("the plugin has no overlay that draws through the draw suite");
        }
        instance.destroy()
    })
}
