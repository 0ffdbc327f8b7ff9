//! Labels and lines of a PSF sheet: header, captions, frame outline, axis, scale bar.

use seidel_core::{LensProfile, ObjectDistance};
use seidel_optics::profile::TileCoverage;

use super::canvas::{Area, Canvas, TextSize};
use super::psf_panel::round_down;
use super::short_number;

const PANEL: [u8; 3] = [5, 6, 9];
/// The part of a panel without tiles.
pub(super) const BARE: [u8; 3] = [58, 14, 16];
const OUTLINE: [u8; 3] = [70, 76, 88];
const AXIS: [u8; 3] = [96, 104, 120];
const TEXT: [u8; 3] = [226, 230, 236];
const QUIET_TEXT: [u8; 3] = [146, 154, 168];

/// Space around and between panels, px.
pub(super) const GAP_PX: u32 = 24;
/// Height of the caption above a panel, px.
pub(super) const CAPTION_PX: u32 = 28;
/// Height of the scale bar below a panel, px.
pub(super) const SCALE_PX: u32 = 26;

/// Height of the header above all panels, px.
pub(super) const HEADER_PX: u32 = 108;

/// Draws the title, the camera data and the definition of tone.
pub(super) fn draw_header(
    canvas: &mut Canvas,
    lens: &LensProfile,
    model: &str,
    title: Option<&str>,
) {
    let room = canvas.image.width() - 2 * GAP_PX;
    let source = lens.provenance.sources.first().map(String::as_str);
    let title = title.or(source).unwrap_or("lens");
    let title = format!("PSF sheet: {title}");
    canvas.text(GAP_PX, GAP_PX, room, TextSize::Large, TEXT, &title);
    let mut facts = vec![format!(
        "{} x {} px",
        lens.frame.width_px(),
        lens.frame.height_px()
    )];
    let camera = &lens.camera;
    facts.extend(camera.focal_length_mm.map(|f| format!("{f} mm")));
    facts.extend(camera.f_number.map(|n| format!("f/{n}")));
    let squeeze = camera.squeeze.filter(|s| *s != 1.0);
    facts.extend(squeeze.map(|s| format!("{s}x anamorphic")));
    if camera.focus_distance != ObjectDistance::Unknown {
        facts.push(format!("focus {}", distance_name(camera.focus_distance)));
    }
    facts.push(format!("model {model}"));
    let note = "tone: square root of light / peak of each PSF";
    for (top, line) in [(58, facts.join("   ").as_str()), (80, note)] {
        canvas.text(
            GAP_PX,
            top,
            room,
            TextSize::fitting(line, room),
            QUIET_TEXT,
            line,
        );
    }
}

/// Draws distance and channel at the left, and the magnification at the right.
pub(super) fn draw_caption(
    canvas: &mut Canvas,
    left: u32,
    top: u32,
    width: u32,
    caption: &str,
    magnified: &str,
) {
    let both = format!("{caption}  {magnified}");
    let size = TextSize::fitting(&both, width);
    let at_right = size.width(magnified).min(width);
    let y = top + CAPTION_PX - size.capital() - 8;
    let room = width.saturating_sub(at_right + 8);
    canvas.text(left, y, room, size, TEXT, caption);
    let right = left + width - at_right;
    canvas.text(right, y, at_right, size, QUIET_TEXT, magnified);
}

/// Draws the outline of the frame and the cross of the optical axis; the part where the fit had none of its `tiles` is red.
pub(super) fn draw_frame(
    canvas: &mut Canvas,
    area: Area,
    lens: &LensProfile,
    tiles: Option<&TileCoverage>,
) {
    canvas.fill(area, if tiles.is_some() { BARE } else { PANEL });
    if let Some(tiles) = tiles {
        let [left, top, right, bottom] = tiles.covered_px(&lens.frame);
        let along =
            |at: f64, size: u32, of: u32| (at / f64::from(size) * f64::from(of)).round() as u32;
        let x = |at| along(at, lens.frame.width_px(), area.width);
        let y = |at| along(at, lens.frame.height_px(), area.height);
        let covered = Area {
            left: area.left + x(left),
            top: area.top + y(top),
            width: x(right) - x(left).min(x(right)),
            height: y(bottom) - y(top).min(y(bottom)),
        };
        canvas.fill(covered, PANEL);
    }
    canvas.outline(area, OUTLINE);
    let axis = lens.frame.axis();
    let u = axis.x_px / f64::from(lens.frame.width_px());
    let v = axis.y_px / f64::from(lens.frame.height_px());
    let x = i64::from(area.left) + (u * f64::from(area.width)).round() as i64;
    let y = i64::from(area.top) + (v * f64::from(area.height)).round() as i64;
    for k in -9..=9 {
        canvas.set(x + k, y, AXIS);
        canvas.set(x, y + k, AXIS);
    }
}

/// Draws a scale bar of a round number of frame px below the panel.
pub(super) fn draw_scale(canvas: &mut Canvas, area: Area, enlargement: f64) {
    let length_px = round_down(f64::from(area.width) / 6.0 / enlargement);
    let bar = ((length_px * enlargement).round() as u32).max(1);
    let (left, y) = (area.left, area.top + area.height + 8);
    let stroke = |left, top, width, height| Area {
        left,
        top,
        width,
        height,
    };
    canvas.fill(stroke(left, y + 3, bar, 2), TEXT);
    canvas.fill(stroke(left, y, 2, 8), TEXT);
    canvas.fill(stroke(left + bar - 2, y, 2, 8), TEXT);
    let room = area.width.saturating_sub(bar + 8);
    let label = format!("{} px", short_number(length_px));
    let size = if area.width >= 300 {
        TextSize::Medium
    } else {
        TextSize::Small
    };
    canvas.text(left + bar + 8, y - 4, room, size, QUIET_TEXT, &label);
}

/// Returns an object distance as a label.
pub(crate) fn distance_name(distance: ObjectDistance) -> String {
    match distance {
        ObjectDistance::Unknown => "distance unknown".to_owned(),
        ObjectDistance::Infinity => "infinity".to_owned(),
        ObjectDistance::Metres(m) => format!("{} m", short_number(m)),
    }
}
