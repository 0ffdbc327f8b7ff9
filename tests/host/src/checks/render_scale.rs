//! Half scale.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::{Picture, Rect};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "render_scale",
    about: "the picture at half scale is that at full scale, reduced, also where regions are said in pixels",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    of(subject, report, Profile::complete(), "at half scale")?;
    let pixels = Profile {
        pixel_regions: true,
        ..Profile::complete()
    };
    of(
        subject,
        report,
        pixels,
        "with regions in pixels of half scale",
    )
}

fn of(subject: &Subject, report: &mut Report, profile: Profile, what: &str) -> Result<(), String> {
    stage::on(subject, report, profile, |loaded, report| {
        let size = Rect::new(0, 0, 64, 48);
        let square = Picture::made(size, 4, |x, y, c| {
            let lit = Rect::new(20, 16, 44, 32).contains(x, y);
            if lit || c == 3 { 1.0 } else { 0.0 }
        });
        let instance = stage::blurring(loaded, subject, &Scene::of(square))?;
        let full = instance.render(&Request {
            window: Some(size),
            ..Request::default()
        })?;
        let half_size = Rect::new(0, 0, 32, 24);
        let half = instance.render(&Request {
            window: Some(half_size),
            scale: (0.5, 0.5),
            ..Request::default()
        })?;
        let (full, half) = (full.good()?, half.good()?);
        report.none(
            full.picture.halved().difference_over(
                &half.picture,
                half_size,
                subject.kind.half_scale,
            ),
            what,
        );
        // The region of definition is canonical: it is that of half the scale, in pixels of half the scale.
        let half_rod = instance.region_of_definition(0.0, (0.5, 0.5))?;
        let full_rod = instance.region_of_definition(0.0, (1.0, 1.0))?;
        let far =
            (half_rod.corners().iter().zip(full_rod.corners())).any(|(a, b)| (a - b).abs() > 4.0);
        report.expect(!far, || {
            format!(
                "the region of definition is {half_rod:?} at half scale and {full_rod:?} at full"
            )
        });
        instance.destroy()
    })
}
