//! Loading and unloading again and again.

use openfx::sys::generic::core::*;

use super::{Check, Report, stage};
use crate::drive::{Loaded, Request, act};
use crate::host::profile::Profile;
use crate::picture::Picture;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "reload",
    about: "a plugin unloaded and loaded again, with its binary or without, renders the same",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let mut first: Option<Picture> = None;
    for binary in 0..2 {
        stage::within(
            subject,
            report,
            Profile::complete(),
            |host, library, report| {
                let plugin = library.find(subject.id.as_deref())?;
                for load in 0..3 {
                    let loaded = if load == 0 {
                        Loaded::new(host, &plugin)?
                    } else {
                        Loaded::again(host, &plugin)?
                    };
                    let frame =
                        stage::rendered(&loaded, subject, &stage::scene(), &Request::default())?;
                    loaded.unload()?;
                    let title = format!("loaded for time {load} from binary {binary}");
                    match &first {
                        Some(first) => {
                            report.none(first.difference(&frame.picture, frame.window), &title)
                        }
                        None => first = Some(frame.picture),
                    }
                }
                // Loaded twice, unloaded twice and once more.
                let loaded = Loaded::again(host, &plugin)?;
                let loaded_twice = Loaded::again(host, &plugin)?;
                let frame =
                    stage::rendered(&loaded_twice, subject, &stage::scene(), &Request::default())?;
                if let Some(first) = &first {
                    report.none(
                        first.difference(&frame.picture, frame.window),
                        "loaded twice",
                    );
                }
                loaded_twice.unload()?;
                loaded.unload()?;
                act(&plugin, kOfxActionUnload, 0, None, None, None);
                Ok(())
            },
        )?;
    }
    Ok(())
}
