//! Fitted values of effects, and their format in words.

#[cfg(test)]
pub(crate) mod tests;

use super::LensScale;

/// The fitted value of an effect's parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedValue {
    /// Name of the parameter.
    pub name: &'static str,
    /// Channel of a parameter that channels do not share.
    pub channel: Option<String>,
    /// Unit.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// Standard error; zero for an integer parameter.
    pub sigma: f64,
}

impl FittedValue {
    /// Returns the name used in reports, followed by the channel if there is one.
    pub fn key(&self) -> String {
        match &self.channel {
            Some(channel) => format!("{}.{channel}", self.name),
            None => self.name.to_owned(),
        }
    }

    /// Formats the size of the value times `factor` in `unit`, with its standard error.
    pub(super) fn quantity(&self, factor: f64, unit: &str) -> String {
        quantity((self.value * factor).abs(), self.sigma * factor.abs(), unit)
    }
}

/// The fitted values of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Fitted<'a> {
    /// The values, of all channels.
    pub values: &'a [FittedValue],
    /// The units of the lens that has them.
    pub lens: &'a LensScale,
}

impl<'a> Fitted<'a> {
    /// Returns the value `name` that all channels share.
    pub(super) fn of(&self, name: &str) -> Option<&'a FittedValue> {
        let mut shared = self.values.iter().filter(|v| v.channel.is_none());
        shared.find(|v| v.name == name)
    }

    /// Returns the number `name`, zero where it was not fitted.
    pub(super) fn number(&self, name: &str) -> f64 {
        self.of(name).map_or(0.0, |v| v.value)
    }

    /// Returns the values `name` of single channels.
    pub(super) fn by_channel(
        &self,
        name: &str,
    ) -> impl Iterator<Item = (&'a str, &'a FittedValue)> {
        let named = self.values.iter().filter(move |v| v.name == name);
        named.filter_map(|v| Some((v.channel.as_deref()?, v)))
    }

    /// Returns the vector with the components `x` and `y`.
    pub(super) fn vector(&self, x: &str, y: &str) -> Option<FittedVector> {
        let (x, y) = (self.of(x)?, self.of(y)?);
        let length = x.value.hypot(y.value);
        let along = |v: &FittedValue| v.value / length.max(f64::MIN_POSITIVE) * v.sigma;
        Some(FittedVector {
            x: x.value,
            y: y.value,
            length,
            sigma: along(x).hypot(along(y)),
        })
    }

    /// Names the largest value among those of a unit of px, in its own unit.
    pub(super) fn largest(&self) -> Option<String> {
        let lengths = self.values.iter().filter(|v| v.unit.starts_with("px"));
        let largest = lengths.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))?;
        let value = quantity(largest.value, largest.sigma, largest.unit);
        Some(format!("largest term: {} = {value}", largest.name))
    }
}

/// A fitted direction with its length.
pub(super) struct FittedVector {
    pub(super) x: f64,
    pub(super) y: f64,
    length: f64,
    sigma: f64,
}

impl FittedVector {
    pub(super) fn quantity(&self, factor: f64, unit: &str) -> String {
        quantity(self.length * factor, self.sigma * factor.abs(), unit)
    }

    /// Returns the direction as seen in the picture.
    pub(super) fn direction(&self, sign: f64) -> &'static str {
        direction_in_picture([sign * self.x, sign * self.y])
    }
}

/// Returns the direction of a vector as seen in the picture, whose y points down.
pub(crate) fn direction_in_picture([x, y]: [f64; 2]) -> &'static str {
    const DIRECTIONS: [&str; 8] = [
        "the right",
        "the lower right",
        "the bottom",
        "the lower left",
        "the left",
        "the upper left",
        "the top",
        "the upper right",
    ];
    let eighth = y.atan2(x).to_degrees() / 45.0;
    DIRECTIONS[(eighth.round().rem_euclid(8.0)) as usize % 8]
}

/// Formats `value` ± `sigma` with `unit`: two digits of the error, at most four significant digits of the value. A size within its
/// error is none: its upper limit is stated, at two standard errors.
pub(super) fn quantity(value: f64, sigma: f64, unit: &str) -> String {
    if value.abs() < sigma {
        return format!(
            "less than {}",
            quantity(value.abs() + 2.0 * sigma, 0.0, unit)
        );
    }
    let after = |number: f64, digits: i32| {
        let power = number.abs().max(1e-9).log10().floor() as i32;
        (digits - 1 - power).max(0)
    };
    let of_value = after(value, if sigma > 0.0 { 4 } else { 3 });
    let decimals = if sigma > 0.0 {
        of_value.min(after(sigma, 2))
    } else {
        of_value
    } as usize;
    let space = if unit.is_empty() { "" } else { " " };
    let error = format!("{sigma:.decimals$}");
    if error.chars().any(|c| ('1'..='9').contains(&c)) {
        format!("{value:.decimals$} ± {error}{space}{unit}")
    } else {
        format!("{value:.decimals$}{space}{unit}")
    }
}

/// Formats a radial shift of the image, px.
pub(super) fn outwards(shift: f64) -> String {
    let way = if shift < 0.0 { "inwards" } else { "outwards" };
    format!("{} {way}", quantity(shift.abs(), 0.0, "px"))
}

/// Joins `parts` by commas; `None` where there are none.
pub(super) fn joined(parts: Vec<String>) -> Option<String> {
    (!parts.is_empty()).then(|| parts.join(", "))
}
