//! Strings lent by the host.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::Picture;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "strings",
    about: "a string that the host lends is not read after the next suite call",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let mut pictures: Vec<Picture> = Vec::new();
    for spoilt in [false, true] {
        let done = stage::on(subject, report, Profile::complete(), |loaded, _| {
            loaded.host.spoil_strings(spoilt);
            let scene = stage::with_all(loaded, stage::scene())?;
            let instance = stage::blurring(loaded, subject, &scene)?;
            let frame = instance.render(&Request::default())?.good()?;
            instance.destroy()?;
            Ok(frame.picture)
        });
        match done {
            Ok(picture) => pictures.push(picture),
            Err(why) if spoilt => {
                report.fault(format!("with strings overwritten at the next call: {why}"));
            }
            Err(why) => return Err(why),
        }
    }
    if let [kept, spoilt] = &pictures[..] {
        report.none(
            kept.difference(spoilt, kept.bounds),
            "with strings overwritten at the next call",
        );
    }
    Ok(())
}
