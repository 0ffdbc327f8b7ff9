//! PSFs side by side: observed, predicted by each model, and how they differ, pixel by pixel.

use image::RgbImage;
use seidel_core::calibrate::eval::{ShapePrediction, ShapeRow};
use seidel_core::{Error, Result};

use super::canvas::{Area, Canvas, text_width};
use super::sheet_labels::distance_name;
use super::short_number;

const BACKGROUND: [u8; 3] = [18, 20, 25];
/// Where a tile ends and nothing is known.
const PANEL: [u8; 3] = [5, 6, 9];
const TEXT: [u8; 3] = [226, 230, 236];
const QUIET_TEXT: [u8; 3] = [146, 154, 168];

const GAP_PX: u32 = 16;
/// Least side of a panel, px: room for a column's title and for 72 px of a PSF at three times their size.
const PANEL_PX: u32 = 216;
const HEADER_PX: u32 = 104;
/// Two lines of column titles.
const TITLES_PX: u32 = 48;
/// A row's words above its panels, and the decibels below them.
const CAPTION_PX: u32 = 28;
const DECIBELS_PX: u32 = 26;
/// Length and height of the bar that explains the colours of differences.
const BAR_PX: (u32, u32) = (216, 16);

/// Share of the peak below which a pixel does not widen the part shown: 5 % grey on the picture.
const LIT_SHARE: f64 = 0.0025;
/// Room about the observed light, in which predictions that spill over are seen.
const SPILL: f64 = 1.3;
const SPILL_PX: f64 = 2.0;
/// Widest part shown, px: keeps the picture of very large tiles of a size that screens bear.
const WIDEST_PX: usize = 401;

/// Draws `rows`, which `title` names: columns are what was observed, the predictions, and each
/// prediction less what was observed.
///
/// All panels of a row show the same square about the centroid at one whole enlargement. Tone is the
/// square root of light over the greatest of the row. Differences go from blue (too little light) by
/// white to red (too much), full colour at the observed peak.
///
/// # Errors
/// No row, or rows that do not have the same predictions.
pub fn shapes_picture(title: &str, rows: &[ShapeRow]) -> Result<RgbImage> {
    Ok(draw(title, rows)?.image)
}

fn draw(title: &str, rows: &[ShapeRow]) -> Result<Canvas> {
    let titles =
        |row: &ShapeRow| -> Vec<&'static str> { row.predictions.iter().map(|p| p.title).collect() };
    let Some(first) = rows.first() else {
        return Err(Error::new("shapes", "have no row", "give at least one"));
    };
    let models = titles(first);
    if rows.iter().any(|row| titles(row) != models) {
        return Err(Error::new(
            "shapes",
            "differ in their predictions",
            "compare the same models in every row",
        ));
    }
    let parts: Vec<Part> = rows.iter().map(Part::of).collect();
    let widest = parts.iter().map(|part| part.side).max().unwrap_or(1);
    let side = PANEL_PX.max(widest as u32);
    let columns = 1 + 2 * models.len() as u32;
    let step = (side + GAP_PX, CAPTION_PX + side + DECIBELS_PX + GAP_PX);
    let top = HEADER_PX + TITLES_PX;
    let mut canvas = Canvas::new(
        GAP_PX + columns * step.0,
        top + rows.len() as u32 * step.1 + GAP_PX / 2,
        BACKGROUND,
    );
    draw_header(&mut canvas, &format!("{title}, channel {}", first.channel));
    let left_of = |column: u32| GAP_PX + column * step.0;
    draw_title(&mut canvas, (left_of(0), HEADER_PX), side, ["", "observed"]);
    for (column, &model) in (1..).zip(&models) {
        let minus = columns - models.len() as u32 + column - 1;
        draw_title(&mut canvas, (left_of(column), HEADER_PX), side, ["", model]);
        let corner = (left_of(minus), HEADER_PX);
        draw_title(&mut canvas, corner, side, [model, "- observed"]);
    }
    for (index, (row, part)) in (0..).zip(rows.iter().zip(&parts)) {
        let y = top + index * step.1;
        let times = (side / part.side as u32).max(1);
        let room = canvas.image.width() - 2 * GAP_PX;
        canvas.text((GAP_PX, y + 6), room, 2, TEXT, &caption(row, part, times));
        let place = |column: u32| Area {
            left: left_of(column),
            top: y + CAPTION_PX,
            width: side,
            height: side,
        };
        let brightest = row
            .predictions
            .iter()
            .map(|p| peak(&p.samples))
            .fold(peak(&row.observed), f64::max);
        let observed = |at: usize| row.observed[at];
        let tone = |light: f64| grey(light / brightest);
        draw_panel(&mut canvas, place(0), row, part, times, |at| {
            tone(observed(at))
        });
        let full = peak(&row.observed);
        for (column, prediction) in (1..).zip(&row.predictions) {
            let samples = &prediction.samples;
            draw_panel(&mut canvas, place(column), row, part, times, |at| {
                tone(samples[at])
            });
            let area = place(columns - models.len() as u32 + column - 1);
            draw_panel(&mut canvas, area, row, part, times, |at| {
                difference((samples[at] - observed(at)) / full)
            });
            draw_decibels(&mut canvas, area, prediction);
        }
    }
    Ok(canvas)
}

fn peak(samples: &[f64]) -> f64 {
    samples.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
}

/// The square of a row that is shown, px of the row's own square; it can reach beyond it.
struct Part {
    left: i64,
    top: i64,
    side: usize,
}

impl Part {
    /// The square about the centroid that holds the observed light and some room.
    fn of(row: &ShapeRow) -> Self {
        let (cx, cy) = row.centroid_px;
        let least = LIT_SHARE * peak(&row.observed);
        let mut reach = 0.0_f64;
        for (at, &light) in row.observed.iter().enumerate() {
            if light > least {
                let (x, y) = (at % row.side_px, at / row.side_px);
                let off = |v: usize, c: f64| (v as f64 + 0.5 - c).abs();
                reach = reach.max(off(x, cx)).max(off(y, cy));
            }
        }
        let half = ((SPILL * reach + SPILL_PX).ceil() as usize).min(WIDEST_PX / 2);
        Self {
            left: cx.floor() as i64 - half as i64,
            top: cy.floor() as i64 - half as i64,
            side: 2 * half + 1,
        }
    }
}

/// The part of a row enlarged `times` in the middle of `area`, each pixel in the colour of its index.
fn draw_panel(
    canvas: &mut Canvas,
    area: Area,
    row: &ShapeRow,
    part: &Part,
    times: u32,
    colour: impl Fn(usize) -> [u8; 3],
) {
    canvas.fill(area, PANEL);
    let margin = (area.width - times * part.side as u32) / 2;
    let inside = |v: i64| usize::try_from(v).ok().filter(|&v| v < row.side_px);
    for y in 0..part.side {
        for x in 0..part.side {
            let column = inside(part.left + x as i64);
            let line = inside(part.top + y as i64);
            let (Some(column), Some(line)) = (column, line) else {
                continue;
            };
            let pixel = Area {
                left: area.left + margin + x as u32 * times,
                top: area.top + margin + y as u32 * times,
                width: times,
                height: times,
            };
            canvas.fill(pixel, colour(line * row.side_px + column));
        }
    }
}

/// Grey of a share of the greatest light: its square root, as on the sheet of a lens.
pub(super) fn grey(share: f64) -> [u8; 3] {
    [(share.clamp(0.0, 1.0).sqrt() * 255.0).round() as u8; 3]
}

/// Colour of a difference, in observed peaks: blue to white to red.
pub(crate) fn difference(share: f64) -> [u8; 3] {
    const LESS: [[f64; 3]; 2] = [[84.0, 150.0, 232.0], [14.0, 48.0, 140.0]];
    const MORE: [[f64; 3]; 2] = [[240.0, 120.0, 92.0], [150.0, 12.0, 34.0]];
    let [half, full] = if share < 0.0 { LESS } else { MORE };
    let depth = 2.0 * share.abs().min(1.0);
    let (from, to, along) = if depth < 1.0 {
        ([255.0; 3], half, depth)
    } else {
        (half, full, depth - 1.0)
    };
    std::array::from_fn(|k| (from[k] + (to[k] - from[k]) * along).round() as u8)
}

fn draw_header(canvas: &mut Canvas, title: &str) {
    let width = canvas.image.width();
    let room = width - 2 * GAP_PX;
    canvas.text((GAP_PX, GAP_PX), room, 3, TEXT, title);
    let (bar, height) = BAR_PX;
    let left = width - GAP_PX - bar;
    for x in 0..bar {
        let share = 2.0 * f64::from(x) / f64::from(bar - 1) - 1.0;
        let stroke = Area {
            left: left + x,
            top: 52,
            width: 1,
            height,
        };
        canvas.fill(stroke, difference(share));
    }
    for (share, label) in [(0.0, "-peak"), (0.5, "0"), (1.0, "+peak")] {
        let at = (share * f64::from(bar - text_width(label, 1))).round() as u32;
        canvas.text((left + at, 72), bar - at, 1, QUIET_TEXT, label);
    }
    let room = room.saturating_sub(bar + GAP_PX);
    let notes = [
        "tone: square root of light / greatest of the row",
        "differences: in observed peaks; dB: forward-blur SNR",
    ];
    let fits = notes.iter().all(|note| text_width(note, 2) <= room);
    let scale = if fits { 2 } else { 1 };
    for (y, note) in [52, 72].into_iter().zip(notes) {
        canvas.text((GAP_PX, y), room, scale, QUIET_TEXT, note);
    }
}

fn draw_title(canvas: &mut Canvas, (left, top): (u32, u32), room: u32, lines: [&str; 2]) {
    for (k, line) in (0..).zip(lines) {
        canvas.text((left, top + 4 + 20 * k), room, 2, TEXT, line);
    }
}

fn draw_decibels(canvas: &mut Canvas, area: Area, prediction: &ShapePrediction) {
    let label = format!("{:.1} dB", prediction.snr_db);
    let at = (area.left, area.top + area.height + 6);
    canvas.text(at, area.width, 2, TEXT, &label);
}

/// Where a row was observed and how large it is shown.
fn caption(row: &ShapeRow, part: &Part, times: u32) -> String {
    format!(
        "{}  h {:.2} ({:.0}% of corner)  {} px x{times}",
        distance_name(row.distance),
        row.field.radius(),
        100.0 * row.corner_share,
        short_number(part.side as f64),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_core::distance::ObjectDistance;
    use seidel_core::field::FieldPoint;

    /// A spot of 3 x 3 px about the middle of a square, and predictions of it.
    fn row(side_px: usize, titles: &[&'static str], distance: ObjectDistance) -> ShapeRow {
        let middle = side_px / 2;
        let mut observed = vec![0.0; side_px * side_px];
        for y in middle - 1..=middle + 1 {
            observed[y * side_px + middle - 1..=y * side_px + middle + 1].fill(1.0 / 9.0);
        }
        let predictions = titles.iter().map(|&title| ShapePrediction {
            title,
            samples: observed.iter().map(|v| 0.5 * v).collect(),
            snr_db: 300.0,
        });
        ShapeRow {
            file: "psf/0001.exr".to_owned(),
            channel: "Y".to_owned(),
            distance,
            field: FieldPoint::new(0.3, 0.4),
            corner_share: 0.41,
            side_px,
            centroid_px: (middle as f64 + 0.5, middle as f64 + 0.5),
            predictions: predictions.collect(),
            observed,
        }
    }

    #[test]
    fn pictures_have_their_size_and_whole_labels() {
        let distances = [
            ObjectDistance::Unknown,
            ObjectDistance::Infinity,
            ObjectDistance::Metres(2.049_53),
        ];
        for titles in [
            &["skew-normal", "Gaussian"][..],
            &["pupil", "skew-normal", "Gaussian"],
        ] {
            let rows: Vec<_> = distances.iter().map(|&d| row(31, titles, d)).collect();
            let canvas = draw("zemax-dgauss28", &rows).expect("drawable");
            let columns = 1 + 2 * titles.len() as u32;
            let want = (
                GAP_PX + columns * (PANEL_PX + GAP_PX),
                HEADER_PX + TITLES_PX + 3 * (CAPTION_PX + PANEL_PX + DECIBELS_PX + GAP_PX) + 8,
            );
            assert_eq!(canvas.image.dimensions(), want);
            assert_eq!(canvas.shortened, 0);
        }
        let mixed = [
            row(31, &["pupil"], distances[0]),
            row(31, &["Gaussian"], distances[0]),
        ];
        assert!(draw("set", &mixed).is_err());
        assert!(draw("set", &[]).is_err());
    }

    #[test]
    fn pixels_are_where_and_what_they_should_be() {
        let canvas = draw("set", &[row(31, &["pupil"], ObjectDistance::Infinity)]).expect("sound");
        let middle = |column: u32| {
            let x = GAP_PX + column * (PANEL_PX + GAP_PX) + PANEL_PX / 2;
            let y = HEADER_PX + TITLES_PX + CAPTION_PX + PANEL_PX / 2;
            canvas.image.get_pixel(x, y).0
        };
        assert_eq!(middle(0), [255; 3]);
        assert_eq!(middle(1), grey(0.5));
        assert_eq!(middle(2), difference(-0.5));
        let part = Part::of(&row(31, &[], ObjectDistance::Infinity));
        // The spot reaches 1 px from the centroid to pixel centres.
        assert_eq!((part.left, part.top, part.side), (11, 11, 9));
        // At the edge of its square the part reaches beyond; in a huge one it is cut.
        let mut wide = row(1001, &["pupil"], ObjectDistance::Infinity);
        wide.observed.fill(1e-6);
        assert_eq!(Part::of(&wide).side, WIDEST_PX);
        wide.centroid_px = (0.2, 1000.9);
        draw("set", &[wide]).expect("drawable");
    }

    #[test]
    fn differences_go_from_blue_by_white_to_red() {
        assert_eq!(difference(0.0), [255; 3]);
        let [r, _, b] = difference(-1.0);
        assert!(b > 2 * r);
        let [r, _, b] = difference(1.0);
        assert!(r > 2 * b);
        assert_eq!(difference(9.0), difference(1.0));
        assert_ne!(difference(0.02), difference(0.0), "small ones are seen");
    }
}
