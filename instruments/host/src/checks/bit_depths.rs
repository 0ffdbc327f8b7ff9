//! Images of every bit depth: those that the plugin supports, and others.

use openfx::sys::generic::core::kOfxStatOK;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::host::sample_type::SampleType;
use crate::picture::Picture;
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "bit_depths",
    about: "bytes, shorts and floats render alike; where unsupported, they are rejected with a message, and nothing is written",
    run,
};

/// Largest difference between renders of the same picture as integers and as floats, steps of the integers: rounding, and that of
/// plugins that compute with integers or dither.
const STEPS: f32 = 2.0;

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let mut supported = Vec::new();
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, _| {
        let takes = |kind: &SampleType| loaded.takes(kind.bit_depth());
        supported.extend(SampleType::ALL.into_iter().filter(takes));
        Ok(())
    })?;
    if supported.is_empty() {
        // Those that it gets then.
        supported.push(SampleType::default());
    }
    for kind in SampleType::ALL {
        if !supported.contains(&kind) {
            check_rejection(subject, report, kind)?;
        }
    }
    check_likeness(subject, report, &supported)
}

/// Checks that images that claim to have unsupported samples are rejected. Their memory is that of floats, so that no plugin reads
/// beyond it.
fn check_rejection(subject: &Subject, report: &mut Report, kind: SampleType) -> Result<(), String> {
    let profile = Profile {
        samples: Some(SampleType::Float),
        false_bit_depth: Some(kind.bit_depth()),
        ..Profile::complete()
    };
    let name = kind.bit_depth().to_string_lossy();
    fixture::with_plugin(subject, report, profile, |loaded, report| {
        let instance = fixture::blurring_instance(loaded, subject, &fixture::scene())?;
        loaded.host.take_messages();
        let frame = instance.render(&RenderRequest::default())?;
        if frame.status == kOfxStatOK {
            report.fault(format!("the plugin renders images of unsupported {name}"));
        } else {
            let is_unwritten = frame.picture.samples.iter().all(|sample| sample.is_nan());
            report.expect(is_unwritten, || {
                format!("the plugin rejects images of {name}, but writes to them")
            });
            let messages = loaded.host.take_messages();
            report.expect(messages.iter().any(|m| m.text.len() > 8), || {
                format!("the plugin rejects images of {name} without a message")
            });
        }
        instance.destroy()
    })
}

/// Checks that a picture that all supported samples hold gives the same result in each, but for rounding.
fn check_likeness(
    subject: &Subject,
    report: &mut Report,
    supported: &[SampleType],
) -> Result<(), String> {
    let (Some(first), Some(coarsest)) = (supported.first(), supported.last()) else {
        return Ok(());
    };
    let Some(source) = fixture::scene().input("Source").picture(0.0) else {
        return Ok(());
    };
    let scene = Scene::new(coarsest.picture(&source));
    let mut floats: Option<Picture> = None;
    for kind in supported {
        let profile = Profile {
            samples: Some(*kind),
            ..Profile::complete()
        };
        fixture::with_plugin(subject, report, profile, |loaded, report| {
            let frame = fixture::render(loaded, subject, &scene, &RenderRequest::default())?;
            let Some(expected) = &floats else {
                floats = Some(frame.picture);
                return Ok(());
            };
            let tolerance = kind.white().map_or(0.0, |white| STEPS / white);
            let expected = kind.picture(expected);
            let difference = expected.difference_beyond(&frame.picture, frame.window, tolerance);
            let names = [kind, first].map(|kind| kind.bit_depth().to_string_lossy());
            report.expect_none(difference, &format!("{} against {}", names[0], names[1]));
            Ok(())
        })?;
    }
    Ok(())
}
