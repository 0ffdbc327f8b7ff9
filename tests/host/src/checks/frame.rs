//! What is written of a frame.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "frame",
    about: "every pixel of the window is written with numbers, and nothing else is touched",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        for scene in [stage::scene(), stage::with_all(loaded, stage::scene())?] {
            let instance = stage::blurring(loaded, subject, &scene)?;
            stage::use_all(&instance, subject)?;
            let size = stage::SIZE;
            let windows = [
                None,
                Some(size),
                Some(Rect::new(3, 5, size.x2 - 8, size.y2 - 2)),
                Some(Rect::new(17, 11, 18, 12)),
                Some(size.grown(5)),
            ];
            for window in windows {
                for tight in [false, true] {
                    let request = Request {
                        window,
                        tight,
                        ..Request::default()
                    };
                    let done = instance.render(&request)?.good();
                    report.none(
                        done.err(),
                        &format!("window {window:?}, image no larger: {tight}"),
                    );
                }
            }
            instance.destroy()?;
        }
        Ok(())
    })
}
