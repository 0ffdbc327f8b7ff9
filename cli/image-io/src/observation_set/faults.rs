//! Faults of a manifest, collected so that a user sees all of them at once.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Fault;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// The keys whose value may be null, which is infinity.
const DISTANCES: [&str; 2] = ["depth_m", "focus_distance_m"];

/// The faults of the set as a whole, or of one of its observations.
#[derive(Default)]
pub(super) struct Faults {
    /// Index of the observation.
    observation: Option<usize>,
    /// The tile's file, as the manifest names it.
    file: String,
    pub(super) all: Vec<Fault>,
}

impl Faults {
    pub(super) fn of_observation(index: usize, file: &str) -> Self {
        Self {
            observation: Some(index),
            file: file.to_owned(),
            all: Vec::new(),
        }
    }

    pub(super) fn push(
        &mut self,
        field: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.all.push(Fault {
            observation: self.observation,
            file: self.file.clone(),
            field: field.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        });
    }

    /// Converts a JSON object, whose keys have `prefix` in messages. The first key or value that does not fit is a fault.
    pub(super) fn parse<T: DeserializeOwned>(&mut self, prefix: &str, value: Value) -> Option<T> {
        const REMEDY: &str = "correct it; the guide lists the keys of observation sets";
        // Serde takes null for a missing key.
        let keys = value.as_object().into_iter().flatten();
        let mut nulls = keys.filter(|(key, value)| value.is_null() && !is_distance(key));
        if let Some((key, _)) = nulls.next() {
            self.push(
                format!("{prefix}{key}"),
                "is null",
                "give a value, or leave it out",
            );
            return None;
        }
        // Serde takes a list for a struct.
        if value.is_array() {
            self.push(self.place(), "is a list", "give a JSON object");
            return None;
        }
        let parsed = serde_path_to_error::deserialize(value);
        let fault = |error: serde_path_to_error::Error<serde_json::Error>| {
            let field = match error.path().to_string().as_str() {
                "." => self.place().to_owned(),
                path => format!("{prefix}{path}"),
            };
            self.push(field, format!("does not fit: {}", error.inner()), REMEDY);
        };
        parsed.map_err(fault).ok()
    }

    /// The field of faults of the whole.
    fn place(&self) -> &'static str {
        if self.observation.is_some() {
            "observation"
        } else {
            "manifest"
        }
    }

    /// Returns an optional number greater than zero.
    pub(super) fn positive(&mut self, field: &str, number: Option<f64>, unit: &str) -> Option<f64> {
        let number = number?;
        if number <= 0.0 {
            let remedy = format!("give {unit} greater than zero, or leave it out");
            self.push(field, format!("is {number}"), remedy);
            return None;
        }
        Some(number)
    }

    /// Returns a distance in metres: absent is unknown, null is infinity.
    pub(super) fn distance(&mut self, field: &str, metres: Option<Option<f64>>) -> ObjectDistance {
        let distance = match metres {
            None => return ObjectDistance::Unknown,
            Some(None) => return ObjectDistance::Infinity,
            Some(Some(metres)) => ObjectDistance::metres(metres),
        };
        distance.unwrap_or_else(|error| {
            let remedy = "give metres greater than zero, null for infinity, or leave it out";
            self.push(field, error.problem, remedy);
            ObjectDistance::Unknown
        })
    }
}

fn is_distance(key: &str) -> bool {
    DISTANCES.contains(&key)
}
