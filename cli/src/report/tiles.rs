//! Pictures of some PSFs: observed, predicted by both lenses, and the residuals.

use seidel_core::diagnosis::Example;
use seidel_core::{Diagnosis, Tile};

use super::markup::{data_uri, escape};
use super::words::{distance, gap, percent};
use crate::pictures::shapes::difference;
use crate::pictures::tile_panel::TilePart;

/// Least side of a panel, px, before the browser scales it to its column.
const PANEL_PX: usize = 180;

/// Returns the section with a row of panels per example; empty without examples. The corrected lens is left out where it
/// is the given one.
pub(super) fn tiles(d: &Diagnosis) -> String {
    let rows: String = d.examples.iter().filter_map(|e| row(d, e)).collect();
    if rows.is_empty() {
        return String::new();
    }
    let stops: Vec<String> = (0..=16)
        .map(|k| {
            let [r, g, b] = difference(f64::from(k) / 8.0 - 1.0);
            format!("rgb({r} {g} {b})")
        })
        .collect();
    let corrected = !d.added.is_empty();
    let (class, heads): (&str, &[&str]) = if corrected {
        (
            "tiles",
            &[
                "observed",
                "given lens",
                "corrected lens",
                "residual, given",
                "residual, corrected",
            ],
        )
    } else {
        ("tiles three", &["observed", "given lens", "residual"])
    };
    let heads: String = heads
        .iter()
        .map(|head| format!("<div class=\"head\">{head}</div>"))
        .collect();
    format!(
        "<section><h2>Observed and predicted PSFs</h2>\n<p class=\"quiet\">PSFs with the largest and with typical \
         gaps, normalised to unit sum. Tone: square root of light relative to the brightest pixel of the row.</p>\n\
         <div class=\"legend\"><span>Residual: predicted minus observed light, from \
         <b>too little</b><span class=\"ramp\" style=\"background:linear-gradient(90deg,{})\"></span>\
         <b>too much</b>. Each row is scaled to its own range, stated beside it, so that even a gap below the limit of \
         detection shows.</span></div>\n\
         <div class=\"{class}\"><div class=\"head\">PSF</div>{heads}\n{rows}</div>\n\
         </section>\n",
        stops.join(",")
    )
}

fn row(d: &Diagnosis, example: &Example) -> Option<String> {
    let at = d.tiles.get(example.tile)?;
    let Example {
        observed,
        predicted,
        corrected,
        ..
    } = example;
    let size = |t: &Tile| (t.width(), t.height());
    if size(predicted) != size(observed) || size(corrected) != size(observed) {
        return None;
    }
    let part = TilePart::around(&[predicted, corrected]);
    let wide = observed.width();
    let greatest = |f: &dyn Fn(usize) -> f32| part.greatest(wide, f).max(f32::MIN_POSITIVE);
    let peak = greatest(&|k| observed.samples()[k]);
    let brightest = [predicted, corrected]
        .into_iter()
        .fold(peak, |m, tile| m.max(greatest(&|k| tile.samples()[k])));
    let off = |tile: &Tile, k: usize| (tile.samples()[k] - observed.samples()[k]).abs();
    let full = greatest(&|k| off(predicted, k).max(off(corrected, k)));
    let times = PANEL_PX.div_ceil(part.side()).max(1) as u32;
    let panels = [
        ("observed", part.light(observed, brightest, times)),
        ("given lens", part.light(predicted, brightest, times)),
        ("corrected lens", part.light(corrected, brightest, times)),
        (
            "residual of the given lens",
            part.residual(predicted, observed, full, times),
        ),
        (
            "residual of the corrected lens",
            part.residual(corrected, observed, full, times),
        ),
    ];
    let changed = !d.added.is_empty();
    let panels: String = panels
        .iter()
        .filter(|(name, _)| changed || !name.contains("corrected"))
        .map(|(name, picture)| {
            let uri = data_uri(picture);
            format!("<div class=\"tile\"><img src=\"{uri}\" alt=\"{name}\"></div>")
        })
        .collect();
    let gaps = if changed {
        format!("{} → {}", gap(at.before), gap(at.after))
    } else {
        gap(at.before)
    };
    Some(format!(
        "<div class=\"what\"><b>{}</b> at {}<br>({:.0}, {:.0}) px<br>gap {gaps}<br>\
         <span class=\"quiet\">residual ±{} of the peak; {} px wide</span></div>{panels}\n",
        escape(&at.channel),
        distance(at.distance),
        at.at.x_px,
        at.at.y_px,
        percent(f64::from(full / peak)),
        part.side()
    ))
}
