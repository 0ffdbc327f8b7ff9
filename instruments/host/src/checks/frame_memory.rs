//! Memory that grows from frame to frame.

use super::{Check, Report, fixture};
use crate::drive::{Instance, RenderRequest};
use crate::host::effect::ParameterValue;
use crate::host::profile::Profile;
use crate::process::allocated_bytes;
use crate::subject::{Animated, Subject};

pub(super) static CHECK: Check = Check {
    name: "frame_memory",
    about: "the frames of a shot with an animated parameter take no more memory than its first ones",
    run,
};

/// Frames of the shot.
const FRAMES: usize = 120;

/// Frames after which caches are full.
const WARM_UP: usize = 60;

/// Most bytes that a frame may leave behind, as a share of its picture. Tables of the host and of the plugin grow a little.
const MAX_SHARE: f64 = 0.25;

/// Renders the frames of a shot and returns the bytes allocated after each.
fn allocated_by_frame(
    instance: &Instance<'_>,
    animated: &Animated,
) -> Result<Option<Vec<usize>>, String> {
    let (least, most) = animated.range;
    let mut all = Vec::new();
    for frame in 0..FRAMES {
        let share = frame as f64 / FRAMES as f64;
        let value = ParameterValue::Doubles(vec![least + share * (most - least)]);
        instance.set(animated.name, &value)?;
        let request = RenderRequest {
            time: frame as f64,
            ..RenderRequest::default()
        };
        drop(instance.render_checked(&request)?);
        let Some(bytes) = allocated_bytes() else {
            return Ok(None);
        };
        all.push(bytes);
    }
    Ok(Some(all))
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let Some(animated) = &subject.kind.animated else {
        report.skip("no number is known that changes the blur");
        return Ok(());
    };
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::connect_all(loaded, fixture::scene())?;
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        fixture::use_depth_and_mask(&instance, subject)?;
        fixture::apply(&instance, animated.in_use)?;
        match allocated_by_frame(&instance, animated)? {
            Some(bytes) => {
                let frames = (FRAMES - WARM_UP) as f64;
                let grown = bytes[FRAMES - 1] as f64 - bytes[WARM_UP - 1] as f64;
                let picture = (fixture::BOUNDS.width() * fixture::BOUNDS.height() * 16) as f64;
                report.expect(grown / frames < MAX_SHARE * picture, || {
                    format!(
                        "memory grows by {:.0} bytes a frame of {picture} bytes",
                        grown / frames
                    )
                });
            }
            None => report.skip("the system does not tell how much memory is allocated"),
        }
        instance.destroy()
    })
}
