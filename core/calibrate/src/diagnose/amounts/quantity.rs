//! Fitted values and their format.

use super::super::diagnosis::Value;

/// The fitted values of an effect.
pub(super) struct Fitted<'a> {
    pub(super) values: &'a [Value],
}

impl<'a> Fitted<'a> {
    /// Returns the value `name` that all channels share.
    pub(super) fn of(&self, name: &str) -> Option<&'a Value> {
        let mut shared = self.values.iter().filter(|v| v.channel.is_none());
        shared.find(|v| v.name == name)
    }

    /// Returns the number `name`, zero where it was not fitted.
    pub(super) fn number(&self, name: &str) -> f64 {
        self.of(name).map_or(0.0, |v| v.value)
    }

    /// Returns the values `name` of single channels.
    pub(super) fn by_channel(&self, name: &str) -> impl Iterator<Item = (&'a str, &'a Value)> {
        let named = self.values.iter().filter(move |v| v.name == name);
        named.filter_map(|v| Some((v.channel.as_deref()?, v)))
    }

    /// Returns the length of the vector with the components `x` and `y`.
    pub(super) fn vector(&self, x: &str, y: &str) -> Option<Vector> {
        let (x, y) = (self.of(x)?, self.of(y)?);
        let length = x.value.hypot(y.value);
        let along = |v: &Value| v.value / length.max(f64::MIN_POSITIVE) * v.sigma;
        Some(Vector {
            x: x.value,
            y: y.value,
            length,
            sigma: along(x).hypot(along(y)),
        })
    }
}

/// A fitted direction with its length.
pub(super) struct Vector {
    pub(super) x: f64,
    pub(super) y: f64,
    length: f64,
    sigma: f64,
}

impl Vector {
    pub(super) fn quantity(&self, factor: f64, unit: &str) -> String {
        quantity(self.length * factor, self.sigma * factor.abs(), unit)
    }

    /// Returns the direction as seen in the picture, whose y points down.
    pub(super) fn direction(&self, sign: f64) -> &'static str {
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
        let eighth = (sign * self.y).atan2(sign * self.x).to_degrees() / 45.0;
        DIRECTIONS[(eighth.round().rem_euclid(8.0)) as usize % 8]
    }
}

impl Value {
    /// Formats the size of the value times `factor` in `unit`, with its standard error.
    pub(super) fn quantity(&self, factor: f64, unit: &str) -> String {
        quantity((self.value * factor).abs(), self.sigma * factor.abs(), unit)
    }
}

/// Formats `value` ± `sigma` with `unit`: two digits of the error, at most four significant digits of the value.
pub(super) fn quantity(value: f64, sigma: f64, unit: &str) -> String {
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

pub(super) fn joined(parts: Vec<String>) -> Option<String> {
    (!parts.is_empty()).then(|| parts.join(", "))
}
