//! The lists of the page: causes, places, pairs, and in which part of the PSFs the gap lies.

use seidel_core::calibrate::diagnose::{Cause, Diagnosis, Value};
use seidel_core::effects;

use super::headline::{bar, track};
use super::markup::escape;
use super::words::{
    direction, distance, effect_name, effect_summary, gap, list, odds, percent, percent_range,
    radius, value,
};

/// Rows of long lists; the rest stands in `report.json`.
const MOST_PLACES: usize = 12;
const MOST_PAIRS: usize = 8;

/// Every cause that was tried, best first.
pub(super) fn causes(d: &Diagnosis) -> String {
    let rows: String = d.causes.iter().map(|c| cause_row(c, &d.added)).collect();
    let twins: String = d
        .equivalents
        .iter()
        .map(|ids| {
            let names: Vec<String> = ids.iter().map(|id| effect_name(id)).collect();
            format!(
                "<p><b>These observations cannot tell apart:</b> {}.</p>\n",
                escape(&list(&names, "and"))
            )
        })
        .collect();
    let together = if d.added.len() > 1 {
        " Two effects were added: each row tells how much a cause closes with its best partner."
    } else {
        ""
    };
    format!(
        "<section><h2>Every cause that was tried</h2>\n<p class=\"quiet\">Probabilities are given that \
         something is missing, and sum to 100&nbsp;% with that of an unknown cause. Values are where each \
         effect alone fits best, with standard errors.{together}</p>\n{twins}\
         <table><thead><tr><th>Cause</th><th>Probability</th><th class=\"n\">Closes</th>\
         <th class=\"n\">95&nbsp;%</th><th>Values</th></tr></thead><tbody>\n{rows}</tbody></table>\n\
         </section>\n"
    )
}

fn cause_row(cause: &Cause, added: &[&str]) -> String {
    let class = if added.contains(&cause.effect) {
        " class=\"added\""
    } else {
        ""
    };
    let values: String = cause
        .parameters
        .iter()
        .map(|v| value_row(cause.effect, v))
        .collect();
    let closes = if cause.effect == "unknown" {
        "<td class=\"n\">–</td><td class=\"n\">–</td>".to_owned()
    } else {
        format!(
            "<td class=\"n\">{}</td><td class=\"n quiet\">{}</td>",
            percent(cause.gap_closed),
            percent_range(cause.gap_closed_ci95)
        )
    };
    let bar_class = if added.contains(&cause.effect) {
        ""
    } else {
        "other"
    };
    format!(
        "<tr{class}><td><span class=\"name\">{}</span><br><span class=\"quiet small\">{}</span></td>\
         <td>{}<div class=\"bar\">{}</div></td>{closes}<td><table class=\"values\">{values}</table></td></tr>\n",
        escape(&effect_name(cause.effect)),
        escape(effect_summary(cause.effect)),
        odds(cause.probability),
        track(cause.probability, bar_class)
    )
}

fn value_row(effect: &str, v: &Value) -> String {
    let meaning = effects::by_id(effect).ok().and_then(|e| {
        let known = e.parameters().iter().find(|p| p.name == v.name);
        known.map(|p| p.meaning)
    });
    format!(
        "<tr><td title=\"{}\">{}</td><td class=\"n\">{}</td><td class=\"quiet\">{}</td></tr>",
        escape(meaning.unwrap_or("")),
        escape(&v.key()),
        value(v),
        escape(v.unit)
    )
}

/// Parts of the field where the gap lies, and in which part of the PSFs.
pub(super) fn places_and_shape(d: &Diagnosis) -> String {
    format!(
        "<section><div class=\"columns\"><div>{}</div><div>{}</div></div></section>\n",
        places(d),
        shape(d)
    )
}

fn places(d: &Diagnosis) -> String {
    if d.places.is_empty() {
        return "<h2>Parts of the field that stand out</h2>\n<p class=\"quiet\">None.</p>"
            .to_owned();
    }
    let rows: String = d
        .places
        .iter()
        .take(MOST_PLACES)
        .map(|p| {
            format!(
                "<tr><td>{}</td><td>{}</td><td>{}, {}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{:.1}</td></tr>\n",
                escape(&p.channel),
                distance(p.distance),
                radius(p.radius),
                direction(p.angle_deg),
                p.tiles,
                gap(p.excess),
                p.z
            )
        })
        .collect();
    format!(
        "<h2>Parts of the field that stand out</h2>\n<p class=\"quiet\">Radius from the optical axis in units \
         of the farthest PSF's; z is the mean gap in its standard errors.</p>\n\
         <table><thead><tr><th>Channel</th><th>Distance</th><th>Part of the field</th><th class=\"n\">PSFs</th>\
         <th class=\"n\">Gap</th><th class=\"n\">z</th></tr></thead><tbody>\n{rows}</tbody></table>\n{}",
        more(d.places.len(), MOST_PLACES, "parts")
    )
}

/// What a kind of change of a PSF is.
fn order_meaning(name: &str) -> &'static str {
    match name {
        "position" => "where the light lands",
        "size" => "wider or narrower",
        "ellipticity" => "stretched one way",
        "skew" => "drawn out to one side",
        "finer" => "rings, edges, kinks",
        _ => "",
    }
}

fn shape(d: &Diagnosis) -> String {
    let s = &d.shape;
    let width = |share: f64| 100.0 * share.clamp(0.0, 1.0);
    let orders: String = s
        .orders
        .iter()
        .map(|order| {
            let words = format!(
                "<b>{}</b> <span class=\"quiet\">{}</span>",
                escape(order.name),
                order_meaning(order.name)
            );
            let number = format!(
                "{} <span class=\"quiet\">z&nbsp;{:.0}</span>",
                percent(order.share),
                order.z
            );
            bar(&words, &number, order.share, "")
        })
        .collect();
    format!(
        "<h2>In which part of the PSFs</h2>\n<p class=\"quiet\">Shares of the energy of the residual before \
         anything is added.</p>\n\
         <div class=\"shares\"><div class=\"a\" style=\"width:{:.1}%\"></div>\
         <div class=\"b\" style=\"width:{:.1}%\"></div></div>\
         <p class=\"small\">{} in the core, the circle that holds half the light; {} in the skirt about it.</p>\n\
         {orders}<p class=\"quiet small\">Each kind of change after those above it; z is its significance in \
         standard errors of the noise.</p>",
        width(s.core),
        width(s.skirt),
        percent(s.core),
        percent(s.skirt)
    )
}

/// Pairs of causes; nothing where none was tried.
pub(super) fn pairs(d: &Diagnosis) -> String {
    if d.pairs.is_empty() {
        return String::new();
    }
    let rows: String = d
        .pairs
        .iter()
        .take(MOST_PAIRS)
        .map(|pair| {
            let names = pair.effects.map(effect_name);
            format!(
                "<tr><td><span class=\"name\">{}</span></td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
                escape(&names.join(" and ")),
                odds(pair.probability),
                percent(pair.gap_closed)
            )
        })
        .collect();
    format!(
        "<h2>Two causes together</h2>\n<p class=\"quiet\">The probability is that both are missing.</p>\n\
         <table><thead><tr><th>Pair</th><th class=\"n\">Probability</th><th class=\"n\">Closes</th></tr></thead>\
         <tbody>\n{rows}</tbody></table>\n{}",
        more(d.pairs.len(), MOST_PAIRS, "pairs")
    )
}

/// What a shortened list leaves out.
fn more(all: usize, shown: usize, what: &str) -> String {
    match all.saturating_sub(shown) {
        0 => String::new(),
        rest => format!("<p class=\"quiet small\">{rest} more {what} stand in report.json.</p>\n"),
    }
}
