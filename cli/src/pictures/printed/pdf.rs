//! A chart as a PDF page at its true size.

use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str};
use seidel_measure::printed::Sheet;

use super::{black_runs, groups, level};

/// Points per millimetre.
const POINTS_PER_MM: f64 = 72.0 / 25.4;
/// Size of the caption, points.
const CAPTION_POINTS: f32 = 6.0;

/// Returns the file.
pub fn pdf(sheet: &Sheet) -> Vec<u8> {
    let [catalog, pages, page_id, contents, font] = [1, 2, 3, 4, 5].map(Ref::new);
    let [width, height] =
        [sheet.medium.width_mm, sheet.medium.height_mm].map(|v| (v * POINTS_PER_MM) as f32);
    let mut file = Pdf::new();
    file.catalog(catalog).pages(pages);
    file.pages(pages).kids([page_id]).count(1);
    let mut page = file.page(page_id);
    page.parent(pages)
        .media_box(Rect::new(0.0, 0.0, width, height))
        .contents(contents);
    page.resources().fonts().pair(Name(b"F1"), font);
    page.finish();
    file.type1_font(font).base_font(Name(b"Helvetica"));
    file.stream(contents, &content(sheet, width, height));
    file.finish()
}

fn content(sheet: &Sheet, width: f32, height: f32) -> Vec<u8> {
    let points = |v: f64| (v * POINTS_PER_MM) as f32;
    let y_up = |v: f64| ((sheet.medium.height_mm - v) * POINTS_PER_MM) as f32;
    let mut content = Content::new();
    content
        .set_fill_gray(level(sheet.background))
        .rect(0.0, 0.0, width, height)
        .fill_nonzero();
    if let Some(placed) = &sheet.cells {
        content.set_fill_gray(0.0);
        for [left, top, w, h] in black_runs(placed) {
            content.rect(points(left), y_up(top + h), points(w), points(h));
        }
        content.fill_nonzero();
    }
    for group in groups(&sheet.shapes) {
        content.set_fill_gray(level(group[0].tone));
        for shape in group {
            for (k, [x, y]) in shape.corners.iter().enumerate() {
                if k == 0 {
                    content.move_to(points(*x), y_up(*y));
                } else {
                    content.line_to(points(*x), y_up(*y));
                }
            }
            content.close_path();
        }
        content.fill_nonzero();
    }
    if sheet.medium.margin_mm > 0.0 {
        content
            .set_fill_gray(1.0 - level(sheet.background))
            .begin_text()
            .set_font(Name(b"F1"), CAPTION_POINTS)
            .next_line(points(sheet.medium.margin_mm), CAPTION_POINTS)
            .show(Str(sheet.caption.as_bytes()))
            .end_text();
    }
    content.finish().to_vec()
}
