//! Row layouts of images.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::{Profile, RowLayout};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "row_layouts",
    about: "padded, odd and negative row bytes give the same picture; unaligned ones do, or the render fails",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::connect_all(loaded, fixture::scene())?;
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        fixture::use_depth_and_mask(&instance, subject)?;
        let request = |rows| RenderRequest {
            rows: Some(rows),
            ..RenderRequest::default()
        };
        let expected = instance.render_checked(&request(RowLayout::Tight))?.picture;
        for rows in RowLayout::ALIGNED {
            let frame = instance.render_checked(&request(rows));
            report.expect_renders_same(&expected, frame, &format!("rows {rows:?}"));
        }
        let frame = instance.render(&request(RowLayout::Unaligned))?;
        for fault in &frame.faults {
            report.fault(format!("rows Unaligned: {fault}"));
        }
        if frame.status == 0 {
            report.expect_same(&expected, &frame, "rows Unaligned");
        }
        instance.destroy()
    })
}
