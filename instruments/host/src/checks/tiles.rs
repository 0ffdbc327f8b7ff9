//! Frames rendered in tiles.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "tiles",
    about: "a frame rendered in tiles of any shape and order has the same bits as the whole",
    run,
};

/// Divides a window into tiles, in rows from the bottom.
fn divide(window: Rect, width: i32, height: i32) -> Vec<Rect> {
    let mut tiles = Vec::new();
    for y in (window.y1..window.y2).step_by(height as usize) {
        for x in (window.x1..window.x2).step_by(width as usize) {
            tiles.push(Rect::new(x, y, x + width, y + height).intersection(&window));
        }
    }
    tiles
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        if !loaded.supports_tiles() {
            report.skip("the plugin declares that it renders no tiles");
            return Ok(());
        }
        for scene in [
            fixture::scene(),
            fixture::connect_all(loaded, fixture::scene())?,
        ] {
            let instance = fixture::blurring_instance(loaded, subject, &scene)?;
            fixture::use_depth_and_mask(&instance, subject)?;
            let whole = instance.render_checked(&RenderRequest::default())?.picture;
            for (width, height) in [(16, 16), (7, 64), (64, 3), (1000, 1000)] {
                for (crop_inputs, reversed) in
                    [(false, false), (false, true), (true, false), (true, true)]
                {
                    let mut tiles = divide(whole.bounds, width, height);
                    if reversed {
                        tiles.reverse();
                    }
                    let frame = instance.render_checked(&RenderRequest {
                        tiles,
                        crop_inputs,
                        crop_output: reversed,
                        ..RenderRequest::default()
                    });
                    let case = format!(
                        "tiles of {width} x {height}, inputs cropped: {crop_inputs}, last first: {reversed}"
                    );
                    report.expect_renders_same(&whole, frame, &case);
                }
            }
            instance.destroy()?;
        }
        Ok(())
    })
}
