//! How rows lie in memory.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::{Profile, Rows};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "rows",
    about: "padded, odd and negative row bytes give the same picture; unaligned ones do, or are refused",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::with_all(loaded, stage::scene())?;
        let instance = stage::blurring(loaded, subject, &scene)?;
        stage::use_all(&instance, subject)?;
        let request = |rows| Request {
            rows: Some(rows),
            ..Request::default()
        };
        let expected = instance.render(&request(Rows::Tight))?.good()?;
        for rows in Rows::ALL {
            let title = format!("rows {rows:?}");
            match instance.render(&request(rows))?.good() {
                Ok(frame) => report.none(
                    expected.picture.difference(&frame.picture, frame.window),
                    &title,
                ),
                Err(why) => report.fault(format!("{title}: {why}")),
            }
        }
        let frame = instance.render(&request(Rows::Unaligned))?;
        if frame.status == 0 {
            let frame = frame.good()?;
            report.none(
                expected.picture.difference(&frame.picture, frame.window),
                "rows Unaligned",
            );
        } else {
            for fault in frame.faults {
                report.fault(format!("rows Unaligned: {fault}"));
            }
        }
        instance.destroy()
    })
}
