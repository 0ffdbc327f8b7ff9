//! `report.json`: the diagnosis for programs, with keys in a fixed order.

use schemars::JsonSchema;
use seidel_core::{Diagnosis, Error, Result};
use serde::Serialize;
use serde_json::Value;

use super::Subject;

const FORMAT: &str = "gap-report";
const VERSION: u32 = 2;
/// The only key whose value may be null (infinity).
const DISTANCE_KEY: &str = "depth_m";

/// A gap report: where reality departs from a lens, which effect the lens lacks, and how far adding it closes
/// the gap.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "GapReport")]
struct Report<'a> {
    /// Always `gap-report`.
    format: &'static str,
    /// Version of the format: 2.
    version: u32,
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
    /// The lens and the observations.
    subject: ReportSubject<'a>,
}

/// The lens and the observations.
#[derive(Serialize, JsonSchema)]
struct ReportSubject<'a> {
    /// Name of the lens profile's file.
    lens: &'a str,
    /// Name of the observation set, or of the picture it was estimated from.
    observations: &'a str,
    /// Number of PSFs in the set, with all channels of a PSF counted once.
    count: usize,
    /// Number of channels of the set.
    channels: usize,
    /// Number of object distances in the set.
    distances: usize,
    /// Number of tiles compared; a tile is a PSF in one channel.
    tiles: usize,
    /// Program and version that wrote the report.
    program: &'static str,
}

/// Returns the JSON schema of `report.json`, pretty-printed.
pub fn schema() -> String {
    let schema = schemars::schema_for!(Report);
    serde_json::to_string_pretty(&schema).expect("a schema is plain JSON")
}

/// Returns the report as JSON text with a final newline.
///
/// # Errors
/// A number that is not finite, which JSON cannot represent; the error names its key.
pub fn json(diagnosis: &Diagnosis, subject: &Subject) -> Result<String> {
    let report = Report {
        format: FORMAT,
        version: VERSION,
        diagnosis,
        subject: ReportSubject {
            lens: &subject.lens,
            observations: &subject.observations,
            count: subject.count,
            channels: subject.channels.len(),
            distances: subject.distances,
            tiles: diagnosis.tiles.len(),
            program: concat!("seidel ", env!("CARGO_PKG_VERSION")),
        },
    };
    let tree = serde_json::to_value(&report).expect("a report is plain JSON");
    if let Some(place) = null_path(&tree) {
        return Err(Error::new(
            format!("report.json: {}", place.trim_start_matches('.')),
            "is not a finite number",
            "report this as a bug, with the lens and the observations",
        ));
    }
    let text = serde_json::to_string_pretty(&report).expect("a report is plain JSON");
    Ok(text + "\n")
}

/// Returns the path of the first null, which serde_json writes for numbers that are not finite.
fn null_path(value: &Value) -> Option<String> {
    let within = |step: String, value: &Value| null_path(value).map(|rest| step + &rest);
    match value {
        Value::Null => Some(String::new()),
        Value::Array(items) => {
            let mut items = (0..).zip(items);
            items.find_map(|(index, item)| within(format!("[{index}]"), item))
        }
        Value::Object(entries) => {
            let mut entries = entries.iter().filter(|(key, _)| *key != DISTANCE_KEY);
            entries.find_map(|(key, item)| within(format!(".{key}"), item))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::{ALL, diagnosis, subject};
    use seidel_core::Verdict;
    use seidel_core::diagnosis::Capture;

    fn parsed(d: &Diagnosis) -> Value {
        serde_json::from_str(&json(d, &subject()).expect("finite")).expect("JSON")
    }

    #[test]
    fn keys_are_in_the_order_of_the_format() {
        let text = json(&diagnosis(Verdict::Explained), &subject()).expect("finite");
        let order = [
            "\"format\": \"gap-report\"",
            "\"version\": 2",
            "\"verdict\": \"explained\"",
            "\"added\"",
            "\"gap\"",
            "\"before\"",
            "\"after\"",
            "\"closed\"",
            "\"closed_ci95\"",
            "\"noise_floor\"",
            "\"causes\"",
            "\"equivalents\"",
            "\"where\"",
            "\"next_capture\"",
            "\"next_capture_id\"",
            "\"no_gap_probability\"",
            "\"remarks\"",
            "\"subject\"",
        ];
        let places: Vec<_> = order.iter().map(|key| text.find(key)).collect();
        assert!(places.iter().all(Option::is_some), "{places:?}\n{text}");
        assert!(places.is_sorted(), "{places:?}");
        let schema: Value = serde_json::from_str(&schema()).expect("JSON");
        let report: Value = serde_json::from_str(&text).expect("JSON");
        for key in report.as_object().expect("an object").keys() {
            assert!(!schema["properties"][key].is_null(), "{key}");
        }
    }

    #[test]
    fn parameters_by_channel_and_all_kinds_of_distance_are_written() {
        let report = parsed(&diagnosis(Verdict::Ambiguous));
        let first = &report["causes"][0];
        assert!(first["parameters"]["shift_1"].is_number());
        assert!(first["parameters_sigma"]["tint.R"].is_number());
        let places = report["where"].as_array().expect("a list");
        assert!(places.iter().any(|p| p["depth_m"].is_number()));
        let at_infinity = |p: &Value| p.get("depth_m").is_some_and(Value::is_null);
        assert!(places.iter().any(at_infinity));
        assert!(places.iter().any(|p| p.get("depth_m").is_none()));
    }

    #[test]
    fn causes_have_plain_words_beside_their_identifiers() {
        let report = parsed(&diagnosis(Verdict::Explained));
        let first = &report["causes"][0];
        assert_eq!(first["effect"], "vignetting");
        assert_eq!(first["title"], "vignetting");
        for key in ["meaning", "action", "amount"] {
            assert!(
                first[key].as_str().is_some_and(|text| !text.is_empty()),
                "{key}"
            );
        }
        assert_eq!(report["next_capture_id"], "far_out_of_focus");
        assert_eq!(report["where_left"].as_array().map(Vec::len), Some(1));
        assert_eq!(report["subject"]["tiles"], 486);
        let causes = report["causes"].as_array().expect("a list");
        assert!(causes.iter().all(|cause| cause["title"].is_string()));
    }

    #[test]
    fn captures_are_written_by_their_identifiers() {
        for capture in Capture::ALL {
            let mut advised = diagnosis(Verdict::Ambiguous);
            advised.next_capture_id = capture;
            assert_eq!(parsed(&advised)["next_capture_id"], capture.id());
        }
    }

    #[test]
    fn verdicts_are_written_by_their_identifiers() {
        for verdict in ALL {
            assert_eq!(parsed(&diagnosis(verdict))["verdict"], verdict.id());
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_rejected_by_key() {
        let mut broken = diagnosis(Verdict::Explained);
        broken.causes[0].parameters[1].sigma = f64::NAN;
        let error = json(&broken, &subject()).expect_err("NaN");
        assert!(error.place.contains("parameters_sigma.shift_1"), "{error}");
        let mut broken = diagnosis(Verdict::Explained);
        broken.places[1].z = f64::INFINITY;
        let error = json(&broken, &subject()).expect_err("infinite");
        assert!(error.place.contains("where[1].z"), "{error}");
    }
}
