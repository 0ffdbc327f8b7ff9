//! The tables of the page: causes, zones of the field, kinds of change of the PSF, pairs of causes.

use seidel_core::Diagnosis;
use seidel_core::diagnosis::Cause;
use seidel_optics::effects;
use seidel_optics::effects::FittedValue;

use super::markup::{bar, escape, track};
use super::words::{
    angle, between, distance, gap, gap_interval, list, meaning, percent, probability, sentence,
    title, value,
};

/// Number of zones shown; `report.json` has all.
const MOST_PLACES: usize = 12;
/// Number of pairs shown; `report.json` has all.
const MOST_PAIRS: usize = 8;

/// Returns the section with every cause tried, most probable first.
pub(super) fn causes(d: &Diagnosis) -> String {
    let rows: String = d.causes.iter().map(|c| cause_row(c, &d.added)).collect();
    let equivalents: String = d
        .equivalents
        .iter()
        .map(|ids| {
            let names: Vec<String> = ids.iter().map(|id| title(id).to_owned()).collect();
            format!(
                "<p><b>These observations cannot distinguish</b> {}.</p>\n",
                escape(&list(&names, "and"))
            )
        })
        .collect();
    let partner = if d.added.len() > 1 {
        " Two effects were added: each of them has half of the probability of the pair, and each row gives what the effect \
         closes with its best partner."
    } else {
        ""
    };
    format!(
        "<section><h2>Causes tried</h2>\n<p class=\"quiet\">Posterior probabilities given a gap; with the unknown \
         cause they sum to 100&nbsp;%. Parameters of the best fit of each effect alone, ± one standard \
         error.{partner}</p>\n{equivalents}\
         <table class=\"causes\"><thead><tr><th>Cause</th><th>Probability</th><th>Gap closed</th>\
         <th>Parameters</th></tr></thead><tbody>\n{rows}</tbody></table>\n\
         </section>\n"
    )
}

fn cause_row(cause: &Cause, added: &[&str]) -> String {
    let (row_class, bar_class) = if added.contains(&cause.effect) {
        (" class=\"added\"", "")
    } else {
        ("", "other")
    };
    let values: String = cause
        .parameters
        .iter()
        .map(|v| value_row(cause.effect, v))
        .collect();
    let closes = if cause.effect == "unknown" {
        "<td>–</td>".to_owned()
    } else if cause.parameters.is_empty() {
        "<td class=\"quiet\">not tried</td>".to_owned()
    } else {
        format!(
            "<td>{}<br><span class=\"quiet small\">{}</span></td>",
            percent(cause.gap_closed),
            between(cause.gap_closed_ci95)
        )
    };
    format!(
        "<tr{row_class}><td><span class=\"name\">{}</span> <code>{}</code><br>\
         <span class=\"quiet small\">{}</span></td>\
         <td>{}<div class=\"bar\">{}</div></td>{closes}<td><table class=\"values\">{values}</table></td></tr>\n",
        escape(&sentence(title(cause.effect))),
        escape(cause.effect),
        escape(meaning(cause.effect)),
        probability(cause.probability),
        track(cause.probability, bar_class)
    )
}

fn value_row(effect: &str, v: &FittedValue) -> String {
    let explanation = effects::by_id(effect).ok().and_then(|e| {
        let known = e.parameters().iter().find(|p| p.name == v.name);
        known.map(|p| p.meaning)
    });
    format!(
        "<tr><td title=\"{}\">{}</td><td class=\"n\">{}</td><td class=\"quiet\">{}</td></tr>",
        escape(explanation.unwrap_or("")),
        escape(&v.key()),
        value(v),
        // A pure number has no unit.
        escape(if v.unit == "1" { "" } else { v.unit })
    )
}

/// Returns the section with the zones of the largest gaps and the kinds of change of the PSF.
pub(super) fn places_and_shape(d: &Diagnosis) -> String {
    format!(
        "<section><div class=\"columns\"><div>{}</div><div>{}</div></div></section>\n",
        places(d),
        shape(d)
    )
}

fn places(d: &Diagnosis) -> String {
    if d.places.is_empty() {
        return "<h2>Zones with a significant gap</h2>\n<p class=\"quiet\">None.</p>".to_owned();
    }
    let rows: String = d
        .places
        .iter()
        .take(MOST_PLACES)
        .map(|p| {
            let [from, to] = p.zone.radius;
            format!(
                "<tr><td>{}</td><td>{}</td><td>{from:.2}–{to:.2}, {}</td><td class=\"n\">{}</td>\
                 <td>{}<br><span class=\"quiet small\">{}</span></td></tr>\n",
                escape(&p.channel),
                distance(p.distance),
                angle(p.zone.angle_deg),
                p.tiles,
                gap(p.excess),
                gap_interval(p).unwrap_or_else(|| "uncertain".to_owned())
            )
        })
        .collect();
    format!(
        "<h2>Zones with a significant gap</h2>\n<p class=\"quiet\">Zones are given by the distance from the optical \
         axis, in units of the farthest PSF's, and by direction. A PSF is counted in each channel.</p>\n\
         <table><thead><tr><th>Channel</th><th>Distance</th><th>Zone</th><th class=\"n\">PSFs</th>\
         <th>Gap</th></tr></thead><tbody>\n{rows}</tbody></table>\n{}",
        omitted(d.places.len(), MOST_PLACES, "zones")
    )
}

/// Returns the description of a kind of change of a PSF.
fn order_meaning(name: &str) -> &'static str {
    match name {
        "position" => "centroid shift",
        "size" => "wider or narrower",
        "ellipticity" => "elongated in one direction",
        "skew" => "asymmetric, as by coma",
        "finer" => "rings, edges and cusps",
        _ => "",
    }
}

/// Returns whether a change of `z` standard errors of the noise is real.
fn significance(z: f64) -> &'static str {
    match z {
        z if z >= 5.0 => "clear of noise",
        z if z >= 2.0 => "close to noise",
        _ => "within noise",
    }
}

fn shape(d: &Diagnosis) -> String {
    let s = &d.shape;
    let width = |share: f64| 100.0 * share.clamp(0.0, 1.0);
    let orders: String = s
        .orders
        .iter()
        .map(|order| {
            let label = format!(
                "<b>{}</b> <span class=\"quiet\">{}</span>",
                escape(order.name),
                order_meaning(order.name)
            );
            let number = format!(
                "{} <span class=\"quiet\">{}</span>",
                percent(order.share),
                significance(order.z)
            );
            bar(&label, &number, order.share, "")
        })
        .collect();
    format!(
        "<h2>How the PSFs differ</h2>\n<p class=\"quiet\">Shares of the energy of the residual of the given \
         lens.</p>\n\
         <div class=\"shares\"><div class=\"a\" style=\"width:{:.1}%\"></div>\
         <div class=\"b\" style=\"width:{:.1}%\"></div></div>\
         <p class=\"small\">{} in the core, the circle that holds half the light; {} in the skirt around it.</p>\n\
         {orders}<p class=\"quiet small\">Each kind of change is fitted after those above it.</p>",
        width(s.core),
        width(s.skirt),
        percent(s.core),
        percent(s.skirt)
    )
}

/// Returns the table of pairs of effects; empty if none was tried.
pub(super) fn pairs(d: &Diagnosis) -> String {
    if d.pairs.is_empty() {
        return String::new();
    }
    let rows: String = d
        .pairs
        .iter()
        .take(MOST_PAIRS)
        .map(|pair| {
            let names: Vec<String> = pair.effects.iter().map(|id| title(id).to_owned()).collect();
            format!(
                "<tr><td><span class=\"name\">{}</span></td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
                escape(&sentence(&list(&names, "and"))),
                probability(pair.probability),
                percent(pair.gap_closed)
            )
        })
        .collect();
    let three = if d.pairs.iter().any(|pair| pair.effects.len() > 2) {
        ", and three together"
    } else {
        ""
    };
    format!(
        "<h2>Pairs of effects{three}</h2>\n<p class=\"quiet\">Posterior probability that all of them are missing, given a \
         gap.</p>\n\
         <table><thead><tr><th>Effects</th><th class=\"n\">Probability</th><th class=\"n\">Gap closed</th></tr></thead>\
         <tbody>\n{rows}</tbody></table>\n{}",
        omitted(d.pairs.len(), MOST_PAIRS, "pairs")
    )
}

/// Returns a note of how many rows a shortened table leaves out.
fn omitted(all: usize, shown: usize, what: &str) -> String {
    match all.saturating_sub(shown) {
        0 => String::new(),
        rest => format!("<p class=\"quiet small\">report.json lists {rest} more {what}.</p>\n"),
    }
}
