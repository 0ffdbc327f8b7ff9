//! The page of a diagnosis: its findings, the causes, and the gap over the field, by channel and distance.

use seidel_core::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{PageText, page};
use crate::pictures::short_number;
use crate::report::{escape, with_code};

/// Causes in the table.
const MOST_CAUSES: usize = 8;

/// The keys of a report that the page shows; others are left alone.
#[derive(Deserialize)]
struct Report {
    verdict: String,
    added: Vec<String>,
    gap: Gap,
    causes: Vec<Cause>,
    #[serde(rename = "where")]
    places: Vec<Place>,
    where_left: Vec<Place>,
    next_capture: String,
    remarks: Vec<String>,
    subject: Subject,
}

#[derive(Deserialize)]
struct Gap {
    before: f64,
    after: f64,
    closed: f64,
    noise_floor: f64,
}

#[derive(Deserialize)]
struct Cause {
    title: String,
    meaning: String,
    action: String,
    amount: String,
    probability: f64,
    gap_closed: f64,
}

#[derive(Deserialize)]
struct Place {
    channel: String,
    /// Null is infinity, left out is unknown.
    #[serde(default, deserialize_with = "present")]
    depth_m: Option<Value>,
    zone: Zone,
    excess: f64,
    tiles: usize,
}

/// Reads a value that is there, null too, as `Some`.
fn present<'de, D: serde::Deserializer<'de>>(
    from: D,
) -> std::result::Result<Option<Value>, D::Error> {
    Value::deserialize(from).map(Some)
}

#[derive(Clone, Copy, Serialize, Deserialize)]
struct Zone {
    radius: [f64; 2],
    angle_deg: [f64; 2],
}

#[derive(Deserialize)]
struct Subject {
    lens: String,
    observations: String,
    count: usize,
}

#[derive(Serialize)]
struct ReportData {
    kind: &'static str,
    state_names: [&'static str; 2],
    channels: Vec<String>,
    distances: Vec<String>,
    zones: Vec<ShownZone>,
    /// Excess at the bright end of the scale.
    largest: f64,
    largest_text: String,
}

/// A zone in one channel at one distance, with the indices of its sliders.
#[derive(Serialize)]
struct ShownZone {
    state: usize,
    channel: usize,
    distance: usize,
    #[serde(flatten)]
    zone: Zone,
    excess: f64,
    text: String,
}

/// Returns the page of `report.json`, whose text is `json`.
///
/// # Errors
/// Text that is not a report of `seidel diagnose`.
pub fn report_page(json: &str) -> Result<String> {
    let report: Report = serde_json::from_str(json).map_err(|e| {
        Error::new(
            "report",
            format!("is not a complete report ({e})"),
            "give the report.json that `seidel diagnose` wrote",
        )
    })?;
    let zones =
        || (report.places.iter().map(|p| (0, p))).chain(report.where_left.iter().map(|p| (1, p)));
    let mut channels: Vec<String> = Vec::new();
    let mut distances: Vec<(f64, String)> = Vec::new();
    for (_, place) in zones() {
        if !channels.contains(&place.channel) {
            channels.push(place.channel.clone());
        }
        let name = place.distance_name();
        if !distances.iter().any(|(_, known)| *known == name) {
            distances.push((place.vergence(), name));
        }
    }
    distances.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Red, green, blue, then others by name.
    channels.sort_by_key(|name| ("RGB".find(name.as_str()).unwrap_or(3), name.clone()));
    let distances: Vec<String> = distances.into_iter().map(|(_, name)| name).collect();
    let largest = zones().map(|(_, p)| p.excess).fold(1e-9, f64::max);
    let index = |all: &[String], name: &str| all.iter().position(|own| own == name).unwrap_or(0);
    let shown: Vec<ShownZone> = zones()
        .map(|(state, place)| ShownZone {
            state,
            channel: index(&channels, &place.channel),
            distance: index(&distances, &place.distance_name()),
            zone: place.zone,
            excess: place.excess,
            text: format!("{} ({} tiles)", percent(place.excess), place.tiles),
        })
        .collect();
    let or_none = |names: Vec<String>| {
        if names.is_empty() {
            vec!["none".to_owned()]
        } else {
            names
        }
    };
    let data = ReportData {
        kind: "report",
        state_names: ["of the given lens", "left after the correction"],
        channels: or_none(channels),
        distances: or_none(distances),
        zones: shown,
        largest,
        largest_text: percent(largest),
    };
    Ok(page(&report.text(), &data))
}

impl Place {
    fn distance_name(&self) -> String {
        match &self.depth_m {
            None => "distance unknown".to_owned(),
            Some(value) => value.as_f64().map_or_else(
                || "infinity".to_owned(),
                |m| format!("{} m", short_number(m)),
            ),
        }
    }

    /// Returns the vergence, 1/m, by which distances are sorted; unknown ones come first.
    fn vergence(&self) -> f64 {
        match &self.depth_m {
            None => -1.0,
            Some(value) => value.as_f64().map_or(0.0, |m| 1.0 / m),
        }
    }
}

impl Report {
    fn text(&self) -> PageText {
        let (subject, gap) = (&self.subject, &self.gap);
        let added = if self.added.is_empty() {
            "no effect added".to_owned()
        } else {
            format!("added: {}", self.added.join(", "))
        };
        PageText {
            title: format!("Gap between {} and {}", subject.lens, subject.observations),
            facts: vec![
                format!("verdict: {}", self.verdict.replace('_', " ")),
                added,
                format!("gap {} before, {} after", percent(gap.before), percent(gap.after)),
                format!("{} closed", percent(gap.closed)),
                format!("noise floor {}", percent(gap.noise_floor)),
                format!("{} PSFs", subject.count),
            ],
            caption: "Zones of the field in which the gap stands out from the noise, about the optical axis; the circle is the \
                      farthest PSF. The number in a zone is its mean gap, a share of the light's energy."
                .to_owned(),
            sections: self.sections(),
            made: "The numbers are those of report.json.".to_owned(),
        }
    }

    /// Returns the table of causes, the advice and the remarks.
    fn sections(&self) -> String {
        let rows = self.causes.iter().take(MOST_CAUSES).map(|cause| {
            format!(
                "<tr><td><b>{}</b><br>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
                escape(&cause.title),
                with_code(&cause.meaning),
                escape(&cause.amount),
                with_code(&cause.action),
                percent(cause.probability),
                percent(cause.gap_closed)
            )
        });
        let rows: String = rows.collect();
        let remarks: String = (self.remarks.iter())
            .map(|r| format!("<li>{}</li>\n", escape(r)))
            .collect();
        let remarks = if remarks.is_empty() {
            remarks
        } else {
            format!("<h2>Remarks</h2>\n<ul>\n{remarks}</ul>\n")
        };
        format!(
            "<section><h2>Effects</h2>\n<table><thead><tr><th>effect</th><th>fitted amount</th><th>what to do</th>\
             <th class=\"n\">probability</th><th class=\"n\">gap closed</th></tr></thead>\n<tbody>{rows}</tbody></table>\n\
             <h2>Next capture</h2>\n<p>{}</p>\n{remarks}</section>\n",
            with_code(&self.next_capture)
        )
    }
}

/// Formats a share in per cent, with a digit after the point below 10 %, and smaller ones as zero.
fn percent(share: f64) -> String {
    let decimals = usize::from((0.0005..0.0995).contains(&share.abs()));
    // Not -0.
    let value = if decimals == 0 && share.abs() < 0.005 {
        0.0
    } else {
        100.0 * share
    };
    format!("{value:.decimals$} %")
}

#[cfg(test)]
mod tests {
    use super::percent;

    #[test]
    fn shares_are_short() {
        for (share, want) in [
            (0.0, "0 %"),
            (-1e-6, "0 %"),
            (0.0761, "7.6 %"),
            (0.986, "99 %"),
            (-0.47, "-47 %"),
        ] {
            assert_eq!(percent(share), want);
        }
    }
}
