//! PSFs to look at: observed, predicted, corrected, and what the two leave.

use seidel_core::calibrate::diagnose::{Diagnosis, Example};
use seidel_core::tile::Tile;

use super::markup::{data_uri, escape};
use super::words::{distance, gap, percent};
use crate::pictures::shapes::difference;
use crate::pictures::tile_panel::TilePart;

/// Least side of a panel, px, before the browser fits it into its column.
const PANEL_PX: usize = 180;

/// The rows of panels; nothing where there is no example.
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
    format!(
        "<section><h2>What the PSFs look like</h2>\n<p class=\"quiet\">Worst gaps and typical ones, unit \
         sums. Light is shown as the square root of its share of the brightest pixel of a row.</p>\n\
         <div class=\"legend\"><span>Residuals: predicted less observed light, from \
         <b>too little</b><span class=\"ramp\" style=\"background:linear-gradient(90deg,{})\"></span>\
         <b>too much</b>; one scale a row, stated beside it.</span></div>\n\
         <div class=\"tiles\"><div class=\"head\">PSF</div><div class=\"head\">observed</div>\
         <div class=\"head\">lens as given</div><div class=\"head\">corrected lens</div>\
         <div class=\"head\">residual before</div><div class=\"head\">residual after</div>\n{rows}</div>\n\
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
    let part = TilePart::of(&[predicted, corrected]);
    let wide = observed.width();
    let greatest = |f: &dyn Fn(usize) -> f32| part.greatest(wide, f).max(f32::MIN_POSITIVE);
    let peak = greatest(&|k| observed.samples()[k]);
    let brightest = [predicted, corrected]
        .into_iter()
        .fold(peak, |m, tile| m.max(greatest(&|k| tile.samples()[k])));
    let off = |tile: &Tile, k: usize| (tile.samples()[k] - observed.samples()[k]).abs();
    let full = greatest(&|k| off(predicted, k).max(off(corrected, k)));
    let times = PANEL_PX.div_ceil(part.side()).max(1) as u32;
    let panel = |picture, what: &str| {
        format!(
            "<div class=\"tile\"><img src=\"{}\" alt=\"{what}\"></div>",
            data_uri(&picture)
        )
    };
    Some(format!(
        "<div class=\"what\"><b>{}</b> at {}<br>({:.0}, {:.0}) px<br>gap {} → {}<br>\
         <span class=\"quiet\">colours to ±{} of its peak; {} px wide</span></div>{}{}{}{}{}\n",
        escape(&at.channel),
        distance(at.distance),
        at.at.x_px,
        at.at.y_px,
        gap(at.before),
        gap(at.after),
        percent(f64::from(full / peak)),
        part.side(),
        panel(part.light(observed, brightest, times), "observed"),
        panel(part.light(predicted, brightest, times), "lens as given"),
        panel(part.light(corrected, brightest, times), "corrected lens"),
        panel(
            part.residual(predicted, observed, full, times),
            "residual before"
        ),
        panel(
            part.residual(corrected, observed, full, times),
            "residual after"
        )
    ))
}
