//! Clips of all components, and all kinds of premultiplication.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::{LoadedPlugin, RenderRequest};
use crate::host::profile::Profile;
use crate::host::profiles;
use crate::picture::{Picture, plate};
use crate::scene::{Input, Scene};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "components",
    about: "Alpha, RGB and RGBA render alike, depth may have one, three or four channels, and inputs more than Source",
    run,
};

/// Largest difference between RGB and opaque RGBA, where channels may be weighted in another order.
const TOLERANCE: f32 = 1e-4;

/// The margin in which alpha may fall off at the edges of opaque pictures, in pixels.
const MARGIN: i32 = 12;

fn with_opaque_alpha(picture: &Picture) -> Picture {
    Picture::from_fn(picture.bounds, 4, |x, y, c| {
        picture.pixel(x, y).get(c).copied().unwrap_or(1.0)
    })
}

fn colours(picture: &Picture) -> Picture {
    Picture::from_fn(picture.bounds, 3, |x, y, c| picture.pixel(x, y)[c])
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let render =
            |scene: &Scene| fixture::render(loaded, subject, scene, &RenderRequest::default());
        for channels in [1, 3, 4] {
            let result = render(&Scene::new(plate(fixture::BOUNDS, channels, 1)));
            report.expect_ok(result, &format!("Source of {channels} channels"));
        }
        let source = plate(fixture::BOUNDS, 3, 1);
        let opaque = render(&Scene::new(with_opaque_alpha(&source)))?;
        let rgb = render(&Scene::new(source))?;
        let difference = colours(&rgb.picture).difference_beyond(
            &colours(&opaque.picture),
            fixture::BOUNDS.expanded(-MARGIN),
            TOLERANCE,
        );
        report.expect_none(difference, "RGB against opaque RGBA");
        for premultiplication in [
            kOfxImageOpaque,
            kOfxImagePreMultiplied,
            kOfxImageUnPreMultiplied,
        ] {
            let mut scene = fixture::scene();
            if let Some(input) = scene.inputs.get_mut("Source") {
                input.premultiplication = Some(premultiplication);
            }
            let case = format!("Source with premultiplication {premultiplication:?}");
            report.expect_ok(render(&scene), &case);
        }
        check_depth(loaded, subject, report)
    })?;
    fixture::with_plugin(subject, report, profiles::natron(), |loaded, report| {
        check_wide_inputs(loaded, subject, report)
    })
}

/// Checks that a source of few channels renders beside any other input of more, in a host that gives Output the most.
fn check_wide_inputs(
    loaded: &LoadedPlugin<'_>,
    subject: &Subject,
    report: &mut Report,
) -> Result<(), String> {
    let all = fixture::connect_all(loaded, fixture::scene())?;
    let others = all.inputs.keys().filter(|clip| *clip != "Source");
    for (clip, channels) in others.flat_map(|clip| [(clip, 1), (clip, 3)]) {
        let source = Scene::new(plate(fixture::BOUNDS, channels, 1));
        let beside = plate(fixture::BOUNDS, 4, 2);
        let scene = source.connect(clip, Input::still(beside));
        let frame = fixture::render(loaded, subject, &scene, &RenderRequest::default());
        let case = format!("Source of {channels} channels beside {clip} of 4");
        report.expect_ok(frame, &case);
    }
    Ok(())
}

/// Checks that depth of any number of channels gives the same picture.
fn check_depth(
    loaded: &LoadedPlugin<'_>,
    subject: &Subject,
    report: &mut Report,
) -> Result<(), String> {
    let Some(settings) = subject.kind.depth else {
        report.skip("no settings are known that use Depth");
        return Ok(());
    };
    let mut first: Option<Picture> = None;
    for channels in [4, 3, 1] {
        let depth = Input::still(fixture::depth(fixture::BOUNDS, channels));
        let scene = fixture::scene().connect("Depth", depth);
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        fixture::apply(&instance, settings)?;
        let frame = instance.render_checked(&RenderRequest::default());
        instance.destroy()?;
        let case = format!("depth of {channels} channels");
        match (&first, frame) {
            (None, Ok(frame)) => first = Some(frame.picture),
            (Some(first), frame) => report.expect_renders_same(first, frame, &case),
            (None, Err(fault)) => report.fault(format!("{case}: {fault}")),
        }
    }
    Ok(())
}
