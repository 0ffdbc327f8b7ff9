//! The gap in a plate as a picture: one map a channel, before and after a correction.

use image::RgbImage;
use seidel_core::{ChannelPlateGap, PlateGap};

use super::canvas::{Area, Canvas, TextSize};
use super::short_number;

const BACKGROUND: [u8; 3] = [18, 20, 25];
const TEXT: [u8; 3] = [226, 230, 236];
const QUIET_TEXT: [u8; 3] = [146, 154, 168];
/// Colour of blocks where a picture is unknown.
const UNKNOWN: [u8; 3] = [5, 6, 9];
const GAP_PX: u32 = 16;
const HEADER_PX: u32 = 72;
const CAPTION_PX: u32 = 28;
/// Least width of a map, px: fits its caption.
const LEAST_MAP_PX: u32 = 420;
/// Width and height of the colour scale, px.
const BAR_PX: (u32, u32) = (216, 16);
/// Share of the blocks of the given lens that reach full colour.
const FULL_COLOUR_SHARE: f64 = 0.02;

/// Draws the gap of a plate with the given lens beside that with the corrected one, one row a channel. All maps share one
/// scale, whose end is written beside the colour bar.
pub fn plate_gap_picture(title: &str, before: &PlateGap, after: &PlateGap) -> RgbImage {
    let times = LEAST_MAP_PX.div_ceil(before.columns.max(1) as u32).max(1);
    let (width, height) = (times * before.columns as u32, times * before.rows as u32);
    let row = height + CAPTION_PX + GAP_PX;
    let mut canvas = Canvas::new(
        3 * GAP_PX + 2 * width,
        HEADER_PX + row * before.channels.len() as u32,
        BACKGROUND,
    );
    let full = full_scale(before);
    draw_header(&mut canvas, title, full);
    for (k, pair) in before.channels.iter().zip(&after.channels).enumerate() {
        let top = HEADER_PX + row * k as u32;
        for (side, (gap, name)) in [(pair.0, "given lens"), (pair.1, "corrected lens")]
            .into_iter()
            .enumerate()
        {
            let left = GAP_PX + side as u32 * (width + GAP_PX);
            let caption = format!("{}, {name}: {}", gap.channel, short_number(gap.whole));
            canvas.text(left, top, width, TextSize::Medium, TEXT, &caption);
            draw_map(
                &mut canvas,
                gap,
                before.columns,
                (left, top + CAPTION_PX),
                times,
                full,
            );
        }
    }
    canvas.image
}

/// Returns the gap of full colour: few blocks of the given lens lie above it.
fn full_scale(gap: &PlateGap) -> f64 {
    let mut all: Vec<f64> = gap
        .channels
        .iter()
        .flat_map(|c| &c.blocks)
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    all.sort_by(f64::total_cmp);
    let index = ((1.0 - FULL_COLOUR_SHARE) * all.len() as f64) as usize;
    let value = all.get(index.min(all.len().saturating_sub(1)));
    value.copied().unwrap_or(1.0).max(1e-9)
}

fn draw_header(canvas: &mut Canvas, title: &str, full: f64) {
    let width = canvas.image.width();
    canvas.text(
        GAP_PX,
        GAP_PX,
        width - 2 * GAP_PX,
        TextSize::Medium,
        TEXT,
        title,
    );
    let (bar, height) = BAR_PX;
    let (left, top) = (GAP_PX, 42);
    for x in 0..bar {
        let stroke = Area {
            left: left + x,
            top,
            width: 1,
            height,
        };
        canvas.fill(stroke, heat(f64::from(x) / f64::from(bar - 1)));
    }
    let scale = format!(
        "0 to {} of the local contrast (variance)",
        short_number(full)
    );
    let from = left + bar + GAP_PX;
    canvas.text(
        from,
        top,
        width.saturating_sub(from),
        TextSize::Medium,
        QUIET_TEXT,
        &scale,
    );
}

fn draw_map(
    canvas: &mut Canvas,
    gap: &ChannelPlateGap,
    columns: usize,
    corner: (u32, u32),
    times: u32,
    full: f64,
) {
    for (k, value) in gap.blocks.iter().enumerate() {
        let block = Area {
            left: corner.0 + times * (k % columns) as u32,
            top: corner.1 + times * (k / columns) as u32,
            width: times,
            height: times,
        };
        let colour = if value.is_finite() {
            heat(value / full)
        } else {
            UNKNOWN
        };
        canvas.fill(block, colour);
    }
}

/// Returns the colour of a share of the full scale: black through red and yellow to white.
fn heat(share: f64) -> [u8; 3] {
    let share = share.clamp(0.0, 1.0);
    let ramp = |from: f64| (255.0 * (3.0 * (share - from)).clamp(0.0, 1.0)).round() as u8;
    [ramp(0.0), ramp(1.0 / 3.0), ramp(2.0 / 3.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_gaps_are_brighter_and_unknown_blocks_are_dark() {
        let gap = |blocks: [f64; 4]| PlateGap {
            columns: 2,
            rows: 2,
            channels: vec![ChannelPlateGap {
                channel: "G".to_owned(),
                blocks: blocks.to_vec(),
                whole: blocks[0],
            }],
        };
        let picture = plate_gap_picture(
            "plate",
            &gap([0.0, 0.2, 0.4, f64::NAN]),
            &gap([0.0, 0.0, 0.0, 0.0]),
        );
        let light = |x: u32, y: u32| {
            let pixel = picture.get_pixel(x, y).0;
            pixel.iter().map(|v| u32::from(*v)).sum::<u32>()
        };
        let (left, top) = (GAP_PX + 10, HEADER_PX + CAPTION_PX + 10);
        assert_eq!(light(left, top), 0);
        assert!(light(left + 210, top) > 100);
        assert!(light(left, top + 210) > light(left + 210, top));
        assert_eq!(picture.get_pixel(left + 210, top + 210).0, UNKNOWN);
        assert_eq!(light(left + 420 + GAP_PX, top + 210), 0);
    }
}
