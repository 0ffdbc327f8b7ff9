//! PSFs side by side: observed, predicted by each model, and the residuals.

use image::RgbImage;
use seidel_core::evaluation::{ShapePrediction, ShapeRow};
use seidel_core::{Error, Result};

use super::canvas::{Area, Canvas, TextSize};
use super::sheet_labels::distance_name;
use super::short_number;

const BACKGROUND: [u8; 3] = [18, 20, 25];
/// Colour of a panel beyond the tile.
const PANEL: [u8; 3] = [5, 6, 9];
const TEXT: [u8; 3] = [226, 230, 236];
const QUIET_TEXT: [u8; 3] = [146, 154, 168];

const GAP_PX: u32 = 16;
/// Least side of a panel, px: fits a column title, and 72 px of a PSF enlarged three times.
const PANEL_PX: u32 = 216;
const HEADER_PX: u32 = 104;
/// Height of two lines of column titles, px.
const TITLES_PX: u32 = 48;
/// Heights of the caption above and of the SNR below the panels of a row, px.
const CAPTION_PX: u32 = 28;
const DECIBELS_PX: u32 = 26;
/// Width and height of the colour scale of residuals, px.
const BAR_PX: (u32, u32) = (216, 16);

/// Share of the peak from which a pixel counts as lit when the crop is chosen; shown as 5 % grey.
const LIT_SHARE: f64 = 0.0025;
/// Margin around the observed light, a factor and px, where wider predictions show.
const SPILL: f64 = 1.3;
const SPILL_PX: f64 = 2.0;
/// Largest crop, px, which limits the size of the picture for very large tiles.
const WIDEST_PX: usize = 401;

/// Draws `rows` under `title`, with columns for the observed PSF, the predictions, and their residuals
/// (predicted minus observed).
///
/// All panels of a row show the same square about the centroid, enlarged by the same integer. Tone is
/// the square root of light over the largest of the row. Residuals run from blue (too little light)
/// through white to red (too much), with full colour at the observed peak.
///
/// # Errors
/// No row, and rows with different predictions.
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
    let parts: Vec<Part> = rows.iter().map(Part::around).collect();
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
    draw_title(&mut canvas, left_of(0), side, ["", "observed"]);
    for (column, &model) in (1..).zip(&models) {
        let residual = columns - models.len() as u32 + column - 1;
        draw_title(&mut canvas, left_of(column), side, ["", model]);
        draw_title(&mut canvas, left_of(residual), side, [model, "- observed"]);
    }
    for (index, (row, part)) in (0..).zip(rows.iter().zip(&parts)) {
        let y = top + index * step.1;
        let times = (side / part.side as u32).max(1);
        let room = canvas.image.width() - 2 * GAP_PX;
        canvas.text(
            GAP_PX,
            y + 6,
            room,
            TextSize::Medium,
            TEXT,
            &caption(row, part, times),
        );
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

/// The square crop of a row's tiles that is shown, px; it can reach beyond the tiles.
struct Part {
    left: i64,
    top: i64,
    side: usize,
}

impl Part {
    /// Returns the square about the centroid that contains the observed light with a margin.
    fn around(row: &ShapeRow) -> Self {
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

/// Draws the crop of a row enlarged `times` in the middle of `area`, with each pixel in the colour of its index.
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

/// Returns the grey of a share of the largest light: its square root, as on the sheet of a lens.
pub(super) fn grey(share: f64) -> [u8; 3] {
    [(share.clamp(0.0, 1.0).sqrt() * 255.0).round() as u8; 3]
}

/// Returns the colour of a residual in units of the full scale, from blue through white to red.
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
    canvas.text(GAP_PX, GAP_PX, room, TextSize::Large, TEXT, title);
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
        let at = (share * f64::from(bar - TextSize::Small.width(label))).round() as u32;
        canvas.text(left + at, 72, bar - at, TextSize::Small, QUIET_TEXT, label);
    }
    let room = room.saturating_sub(bar + GAP_PX);
    let notes = [
        "tone: square root of light / greatest of the row",
        "differences: in observed peaks; dB: forward-blur SNR",
    ];
    let fits = notes
        .iter()
        .all(|note| TextSize::Medium.width(note) <= room);
    let size = if fits {
        TextSize::Medium
    } else {
        TextSize::Small
    };
    for (y, note) in [52, 72].into_iter().zip(notes) {
        canvas.text(GAP_PX, y, room, size, QUIET_TEXT, note);
    }
}

fn draw_title(canvas: &mut Canvas, left: u32, room: u32, lines: [&str; 2]) {
    for (k, line) in (0..).zip(lines) {
        canvas.text(
            left,
            HEADER_PX + 4 + 20 * k,
            room,
            TextSize::Medium,
            TEXT,
            line,
        );
    }
}

fn draw_decibels(canvas: &mut Canvas, area: Area, prediction: &ShapePrediction) {
    let label = format!("{:.1} dB", prediction.snr_db);
    let below = area.top + area.height + 6;
    canvas.text(area.left, below, area.width, TextSize::Medium, TEXT, &label);
}

/// Returns the caption of a row: position in the field, and enlargement.
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
    use seidel_core::{FieldPoint, ObjectDistance};

    /// Returns a spot of 3 x 3 px in the middle of a square, with predictions of half its light.
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
    fn pictures_have_their_size_and_labels_fit() {
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
    fn panels_show_the_centred_crop() {
        let canvas = draw("set", &[row(31, &["pupil"], ObjectDistance::Infinity)]).expect("sound");
        let middle = |column: u32| {
            let x = GAP_PX + column * (PANEL_PX + GAP_PX) + PANEL_PX / 2;
            let y = HEADER_PX + TITLES_PX + CAPTION_PX + PANEL_PX / 2;
            canvas.image.get_pixel(x, y).0
        };
        assert_eq!(middle(0), [255; 3]);
        assert_eq!(middle(1), grey(0.5));
        assert_eq!(middle(2), difference(-0.5));
        let part = Part::around(&row(31, &[], ObjectDistance::Infinity));
        // The spot reaches 1 px from the centroid to pixel centres.
        assert_eq!((part.left, part.top, part.side), (11, 11, 9));
        // The crop of a huge tile is limited; at the edge of a tile it reaches beyond.
        let mut wide = row(1001, &["pupil"], ObjectDistance::Infinity);
        wide.observed.fill(1e-6);
        assert_eq!(Part::around(&wide).side, WIDEST_PX);
        wide.centroid_px = (0.2, 1000.9);
        draw("set", &[wide]).expect("drawable");
    }

    #[test]
    fn residuals_run_from_blue_through_white_to_red() {
        assert_eq!(difference(0.0), [255; 3]);
        let [r, _, b] = difference(-1.0);
        assert!(b > 2 * r);
        let [r, _, b] = difference(1.0);
        assert!(r > 2 * b);
        assert_eq!(difference(9.0), difference(1.0));
        assert_ne!(
            difference(0.02),
            difference(0.0),
            "small residuals are visible"
        );
    }
}
