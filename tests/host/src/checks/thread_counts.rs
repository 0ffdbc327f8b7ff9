//! How many threads the host has.

use openfx::sys::image_effect_v1::multi_thread::kOfxMultiThreadSuite;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "thread_counts",
    about: "the picture is the same, bit for bit, for any number of threads",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = stage::usual(subject, report)?;
    let complete = Profile::complete;
    let absent = Profile {
        absent: vec![(kOfxMultiThreadSuite, 1)],
        ..complete()
    };
    let serial = Profile {
        serial: true,
        ..complete()
    };
    let cases = [
        (complete(), 1, false),
        (complete(), 2, false),
        (complete(), 3, false),
        (complete(), 8, false),
        (complete(), 0, false),
        (complete(), 4, true),
        (serial, 4, false),
        (absent, 4, false),
    ];
    for (profile, processors, fail) in cases {
        let title = format!(
            "{processors} processors, serial: {}, suite there: {}, failing: {fail}",
            profile.serial,
            profile.absent.is_empty()
        );
        stage::on(subject, report, profile, |loaded, report| {
            loaded.host.set_threads(processors, fail);
            let frame = stage::rendered(loaded, subject, &stage::scene(), &Request::default())?;
            report.none(
                expected.picture.difference(&frame.picture, frame.window),
                &title,
            );
            Ok(())
        })?;
    }
    Ok(())
}
