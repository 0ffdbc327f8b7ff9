//! Clips of every component, and every state of premultiplication.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::{Picture, plate};
use crate::scene::{Input, Scene};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "components",
    about: "Alpha, RGB and RGBA are rendered alike, and depth of one channel is depth of four",
    run,
};

/// Channels may be weighed in another order.
const TOLERANCE: f32 = 1e-4;

fn opaque(picture: &Picture) -> Picture {
    Picture::made(picture.bounds, 4, |x, y, c| {
        picture.pixel(x, y).get(c).copied().unwrap_or(1.0)
    })
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        for channels in [1, 3, 4] {
            let scene = Scene::of(plate(stage::SIZE, channels, 1));
            let done = stage::rendered(loaded, subject, &scene, &Request::default());
            report.none(done.err(), &format!("Source of {channels} channels"));
        }
        let colours = plate(stage::SIZE, 3, 1);
        let four = Scene::of(opaque(&colours));
        let three = stage::rendered(loaded, subject, &Scene::of(colours), &Request::default())?;
        let four = stage::rendered(loaded, subject, &four, &Request::default())?;
        // At the edges alpha may fall off; inside, colours are the same.
        let inside = stage::SIZE.grown(-12);
        let cut =
            |picture: &Picture| Picture::made(picture.bounds, 3, |x, y, c| picture.pixel(x, y)[c]);
        report.none(
            cut(&three.picture).difference_over(&cut(&four.picture), inside, TOLERANCE),
            "RGB against opaque RGBA",
        );
        for state in [
            kOfxImageOpaque,
            kOfxImagePreMultiplied,
            kOfxImageUnPreMultiplied,
        ] {
            let mut scene = stage::scene();
            if let Some(input) = scene.inputs.get_mut("Source") {
                input.premultiplication = Some(state);
            }
            let done = stage::rendered(loaded, subject, &scene, &Request::default());
            report.none(done.err(), &format!("Source that is {state:?}"));
        }
        depths(loaded, subject, report)
    })
}

fn depths(
    loaded: &crate::drive::Loaded<'_>,
    subject: &Subject,
    report: &mut Report,
) -> Result<(), String> {
    let Some(knobs) = subject.kind.depth else {
        report.skip("nothing makes the plugin look at depth");
        return Ok(());
    };
    let mut first: Option<crate::drive::Frame> = None;
    for channels in [4, 3, 1] {
        let depth = Input::still(stage::depth(stage::SIZE, channels));
        let scene = stage::scene().and("Depth", depth);
        let instance = stage::blurring(loaded, subject, &scene)?;
        stage::set(&instance, knobs)?;
        let frame = instance.render(&Request::default())?.good();
        instance.destroy()?;
        match (&first, frame) {
            (Some(first), Ok(frame)) => report.none(
                first.picture.difference(&frame.picture, frame.window),
                &format!("depth of {channels} channels"),
            ),
            (None, Ok(frame)) => first = Some(frame),
            (_, Err(why)) => report.fault(format!("depth of {channels} channels: {why}")),
        }
    }
    Ok(())
}
