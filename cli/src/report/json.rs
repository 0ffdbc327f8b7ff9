//! `report.json`: the gap report for programs, its keys in a fixed order.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use seidel_core::calibrate::diagnose::{Cause, Diagnosis, Pair, Place, Verdict};
use seidel_core::distance::ObjectDistance;
use seidel_core::{Error, Result};
use serde::Serialize;

use super::Subject;

const FORMAT: &str = "gap-report";
const VERSION: u32 = 1;

/// A gap report: where reality departs from a lens, which effect it lacks, how far adding it goes.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "GapReport")]
struct ReportFile {
    /// Always `gap-report`.
    format: &'static str,
    /// Version of the format: 1.
    version: u32,
    /// The answer in a word.
    verdict: VerdictFile,
    /// Effects that `corrected.json` has and the lens had not, the stronger first.
    added: Vec<String>,
    /// How large the gap is and how far it closes.
    gap: GapFile,
    /// Every effect tried and `unknown`, best first; probabilities sum to one.
    causes: Vec<CauseFile>,
    /// Sets of effects that these data cannot tell apart.
    equivalents: Vec<Vec<String>>,
    /// Parts of field, channel and depth where the gap lies, largest first.
    #[serde(rename = "where")]
    places: Vec<PlaceFile>,
    /// Capture that would decide what is open.
    next_capture: String,
    /// Probability that nothing is missing; those of `causes` are given that something is.
    no_gap_probability: f64,
    /// Pairs of effects tried, best first.
    pairs: Vec<PairFile>,
    /// In which part of the PSFs the gap lies.
    shape: ShapeFile,
    /// Share of the gap that a free-form residual model closes on zones of the field that took no part.
    explainable: f64,
    /// What the lens leaves on the data it was fitted to.
    lens_misfit: f64,
    /// The residual that is left, in words; empty where none is.
    residual: String,
    /// What a user should know besides.
    remarks: Vec<String>,
    /// What was diagnosed.
    subject: SubjectFile,
}

/// The answer in a word.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum VerdictFile {
    /// The lens explains the data to their noise.
    NoGap,
    /// The effects in `added` close the gap.
    Explained,
    /// Causes close it that these data cannot tell apart.
    Ambiguous,
    /// A gap stays that no known effect closes.
    Unexplained,
}

/// Mean over tiles of the squared difference of unit-sum PSFs over the squared norm of the observed one,
/// less what noise gives, on observations that took no part in fitting.
#[derive(Debug, Serialize, JsonSchema)]
struct GapFile {
    /// Of the lens as given.
    before: f64,
    /// Of the corrected lens.
    after: f64,
    /// 1 - after / before.
    closed: f64,
    /// Interval that holds `closed` with 95 %.
    closed_ci95: [f64; 2],
    /// What noise alone gives.
    noise_floor: f64,
}

/// An effect that may be missing.
#[derive(Debug, Serialize, JsonSchema)]
struct CauseFile {
    /// Identifier, or `unknown`.
    effect: String,
    /// Probability that it is what is missing.
    probability: f64,
    /// Share of the gap that it closes.
    gap_closed: f64,
    /// Interval that holds it with 95 %.
    gap_closed_ci95: [f64; 2],
    /// Its values where it fits best, by name.
    parameters: BTreeMap<String, f64>,
    /// Their standard errors.
    parameters_sigma: BTreeMap<String, f64>,
}

/// A part of the field in one channel at one object distance.
#[derive(Debug, Serialize, JsonSchema)]
struct PlaceFile {
    /// Channel name.
    channel: String,
    /// Object distance in metres; null is infinity, left out is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<f64>")]
    depth_m: Option<Option<f64>>,
    /// Part of the field.
    zone: ZoneFile,
    /// Mean gap there.
    excess: f64,
    /// The same in standard errors.
    z: f64,
    /// Tiles there.
    tiles: usize,
}

/// A part of the field about the optical axis.
#[derive(Debug, Serialize, JsonSchema)]
struct ZoneFile {
    /// Distances from the axis in units of the farthest tile's: from, to.
    radius: [f64; 2],
    /// Directions from it, degrees from image x towards y: from, to.
    angle_deg: [f64; 2],
}

/// Two effects tried together.
#[derive(Debug, Serialize, JsonSchema)]
struct PairFile {
    /// Which.
    effects: [String; 2],
    /// Probability that both are missing.
    probability: f64,
    /// Share of the gap that they close together.
    gap_closed: f64,
}

/// Shares of the residual's energy.
#[derive(Debug, Serialize, JsonSchema)]
struct ShapeFile {
    /// Within the circle about the centroid that holds half the light.
    core: f64,
    /// Outside.
    skirt: f64,
    /// By kind of change, each after those before it.
    orders: Vec<OrderFile>,
}

/// A kind of change of a PSF.
#[derive(Debug, Serialize, JsonSchema)]
struct OrderFile {
    /// `position`, `size`, `ellipticity`, `skew` or `finer`.
    name: String,
    /// Share of the residual's energy.
    share: f64,
    /// Significance, standard errors of the noise.
    z: f64,
}

/// What was diagnosed.
#[derive(Debug, Serialize, JsonSchema)]
struct SubjectFile {
    /// Name of the lens profile's file.
    lens: String,
    /// Name of the observation set, or of the pictures it was estimated from.
    observations: String,
    /// PSFs in it.
    count: usize,
    /// Program and version that made the report.
    program: String,
}

/// The JSON schema of `report.json`, pretty-printed.
pub fn schema() -> String {
    let schema = schemars::schema_for!(ReportFile);
    serde_json::to_string_pretty(&schema).expect("a schema is plain JSON")
}

/// The report as JSON text with a final newline.
///
/// # Errors
/// A number that is not finite, which JSON cannot hold; the field is named.
pub fn json(diagnosis: &Diagnosis, subject: &Subject) -> Result<String> {
    let report = report(diagnosis, subject)?;
    let text = serde_json::to_string_pretty(&report).expect("a report is plain JSON");
    Ok(text + "\n")
}

fn report(d: &Diagnosis, subject: &Subject) -> Result<ReportFile> {
    let owned = |ids: &[&'static str]| ids.iter().map(|&id| id.to_owned()).collect();
    let gap = &d.gap;
    Ok(ReportFile {
        format: FORMAT,
        version: VERSION,
        verdict: match d.verdict {
            Verdict::NoGap => VerdictFile::NoGap,
            Verdict::Explained => VerdictFile::Explained,
            Verdict::Ambiguous => VerdictFile::Ambiguous,
            Verdict::Unexplained => VerdictFile::Unexplained,
        },
        added: owned(&d.added),
        gap: GapFile {
            before: finite(gap.before, "gap.before")?,
            after: finite(gap.after, "gap.after")?,
            closed: finite(gap.closed, "gap.closed")?,
            closed_ci95: both(gap.closed_ci95, "gap.closed_ci95")?,
            noise_floor: finite(gap.noise_floor, "gap.noise_floor")?,
        },
        causes: d.causes.iter().map(cause).collect::<Result<_>>()?,
        equivalents: d.equivalents.iter().map(|ids| owned(ids)).collect(),
        places: (0..)
            .zip(&d.places)
            .map(|(index, p)| place(index, p))
            .collect::<Result<_>>()?,
        next_capture: d.next_capture.clone(),
        no_gap_probability: finite(d.nothing_missing, "no_gap_probability")?,
        pairs: d.pairs.iter().map(pair).collect::<Result<_>>()?,
        shape: ShapeFile {
            core: finite(d.shape.core, "shape.core")?,
            skirt: finite(d.shape.skirt, "shape.skirt")?,
            orders: d
                .shape
                .orders
                .iter()
                .map(|order| {
                    let field = |key: &str| format!("shape.orders {}: {key}", order.name);
                    Ok(OrderFile {
                        name: order.name.to_owned(),
                        share: finite(order.share, &field("share"))?,
                        z: finite(order.z, &field("z"))?,
                    })
                })
                .collect::<Result<_>>()?,
        },
        explainable: finite(gap.explainable, "explainable")?,
        lens_misfit: finite(gap.lens_misfit, "lens_misfit")?,
        residual: d.residual.clone(),
        remarks: d.remarks.clone(),
        subject: SubjectFile {
            lens: subject.lens.clone(),
            observations: subject.observations.clone(),
            count: subject.count,
            program: concat!("seidel ", env!("CARGO_PKG_VERSION")).to_owned(),
        },
    })
}

fn cause(cause: &Cause) -> Result<CauseFile> {
    let field = |key: &str| format!("causes {}: {key}", cause.effect);
    let mut file = CauseFile {
        effect: cause.effect.to_owned(),
        probability: finite(cause.probability, &field("probability"))?,
        gap_closed: finite(cause.gap_closed, &field("gap_closed"))?,
        gap_closed_ci95: both(cause.gap_closed_ci95, &field("gap_closed_ci95"))?,
        parameters: BTreeMap::new(),
        parameters_sigma: BTreeMap::new(),
    };
    for value in &cause.parameters {
        let key = value.key();
        let number = finite(value.value, &field(&format!("parameters.{key}")))?;
        let sigma = finite(value.sigma, &field(&format!("parameters_sigma.{key}")))?;
        file.parameters.insert(key.clone(), number);
        file.parameters_sigma.insert(key, sigma);
    }
    Ok(file)
}

fn place(index: usize, place: &Place) -> Result<PlaceFile> {
    let field = |key: &str| format!("where[{index}].{key}");
    Ok(PlaceFile {
        channel: place.channel.clone(),
        depth_m: match place.distance {
            ObjectDistance::Unknown => None,
            ObjectDistance::Infinity => Some(None),
            ObjectDistance::Metres(m) => Some(Some(finite(m, &field("depth_m"))?)),
        },
        zone: ZoneFile {
            radius: both(place.radius, &field("zone.radius"))?,
            angle_deg: both(place.angle_deg, &field("zone.angle_deg"))?,
        },
        excess: finite(place.excess, &field("excess"))?,
        z: finite(place.z, &field("z"))?,
        tiles: place.tiles,
    })
}

fn pair(pair: &Pair) -> Result<PairFile> {
    let field = |key: &str| format!("pairs {} and {}: {key}", pair.effects[0], pair.effects[1]);
    Ok(PairFile {
        effects: pair.effects.map(str::to_owned),
        probability: finite(pair.probability, &field("probability"))?,
        gap_closed: finite(pair.gap_closed, &field("gap_closed"))?,
    })
}

/// JSON has no NaN and no infinity, and nothing else stands in for them.
fn finite(value: f64, field: &str) -> Result<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Error::new(
        format!("report.json: {field}"),
        format!("is {value}"),
        "report this as a fault, with the lens and the observations",
    ))
}

fn both(pair: (f64, f64), field: &str) -> Result<[f64; 2]> {
    Ok([finite(pair.0, field)?, finite(pair.1, field)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::made::{diagnosis, subject};
    use serde_json::Value;

    fn parsed(d: &Diagnosis) -> Value {
        serde_json::from_str(&json(d, &subject()).expect("finite")).expect("JSON")
    }

    #[test]
    fn keys_stand_as_the_format_has_them() {
        let text = json(&diagnosis(Verdict::Explained), &subject()).expect("finite");
        let order = [
            "\"format\": \"gap-report\"",
            "\"version\": 1",
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
            "\"no_gap_probability\"",
            "\"remarks\"",
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
    fn values_by_channel_and_distances_are_told_apart() {
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
    fn verdicts_are_written_as_the_core_names_them() {
        for verdict in [
            Verdict::NoGap,
            Verdict::Explained,
            Verdict::Ambiguous,
            Verdict::Unexplained,
        ] {
            assert_eq!(parsed(&diagnosis(verdict))["verdict"], verdict.id());
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused_by_field() {
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
