//! Numbers, names and places as text.

use seidel_core::calibrate::diagnose::{Place, Value};
use seidel_core::distance::ObjectDistance;
use seidel_core::effects;

use crate::pictures::{decimals, significant};

/// Keeps a number and its unit on one line.
const SPACE: char = '\u{a0}';

/// Formats a share in per cent: integers, and tenths below 10 % and above 99 %.
pub(super) fn percent(share: f64) -> String {
    format!("{}{SPACE}%", percent_number(share))
}

fn percent_number(share: f64) -> String {
    let near_an_end = share.abs() < 0.0995 || (0.99..1.0).contains(&share);
    let decimals = usize::from(near_an_end && share != 0.0);
    minus_sign(&format!("{:.decimals$}", 100.0 * share))
}

/// Formats an interval of shares.
pub(super) fn percent_range([from, to]: [f64; 2]) -> String {
    let dash = if from < 0.0 || to < 0.0 {
        " to "
    } else {
        "–"
    };
    format!(
        "{}{dash}{}{SPACE}%",
        percent_number(from),
        percent_number(to)
    )
}

/// Formats a gap in per cent of the energy of a PSF, to two significant digits.
pub(super) fn gap(value: f64) -> String {
    let share = 100.0 * value;
    if share == 0.0 || !share.is_finite() {
        return format!("{share}{SPACE}%");
    }
    let decimals = decimals(share, 2);
    format!("{}{SPACE}%", minus_sign(&format!("{share:.decimals$}")))
}

/// Formats a gap without trailing zeros, for the ticks of a scale.
pub(super) fn round_gap(value: f64) -> String {
    format!("{}{SPACE}%", minus_sign(&significant(100.0 * value, 2)))
}

/// Formats a probability, never as 0 or 100 %.
pub(super) fn probability(probability: f64) -> String {
    if probability < 0.001 {
        format!("<{SPACE}0.1{SPACE}%")
    } else if probability > 0.999 {
        format!(">{SPACE}99.9{SPACE}%")
    } else {
        percent(probability)
    }
}

/// Formats a value with its standard error, both to two digits of the error.
pub(super) fn value(value: &Value) -> String {
    if value.sigma <= 0.0 {
        return minus_sign(&significant(value.value, 4));
    }
    let decimals = decimals(value.sigma, 2);
    format!(
        "{} ± {:.decimals$}",
        minus_sign(&format!("{:.decimals$}", value.value)),
        value.sigma
    )
}

/// Replaces the hyphen of a negative number by a minus sign, and drops it from a zero.
fn minus_sign(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => number.to_owned(),
    }
}

/// Formats an object distance.
pub(super) fn distance(distance: ObjectDistance) -> String {
    match distance {
        ObjectDistance::Unknown => "unknown distance".to_owned(),
        ObjectDistance::Infinity => "infinity".to_owned(),
        ObjectDistance::Metres(m) => format!("{}{SPACE}m", significant(m, 3)),
    }
}

/// Returns the name of an effect from its identifier.
pub(super) fn effect_name(id: &str) -> String {
    match id {
        "unknown" => "an unknown cause".to_owned(),
        id => id.replace('_', " "),
    }
}

/// Returns the description of an effect.
pub(super) fn effect_summary(id: &str) -> &'static str {
    match id {
        "unknown" => "none of the effects in the library",
        id => effects::by_id(id).map_or("", |effect| effect.summary()),
    }
}

/// Joins names as `a`, `a and b`, or `a, b and c`, with `last` for the conjunction.
pub(super) fn list(names: &[String], last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

/// Capitalises the first letter.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

/// Returns the direction of a sector of the field from the optical axis.
pub(super) fn angle([from, to]: [f64; 2]) -> &'static str {
    const DIRECTIONS: [&str; 8] = [
        "right",
        "lower right",
        "below",
        "lower left",
        "left",
        "upper left",
        "above",
        "upper right",
    ];
    if to - from > 300.0 {
        return "all directions";
    }
    let eighth = ((from + to) / 2.0).rem_euclid(360.0) / 45.0;
    DIRECTIONS[eighth.round() as usize % DIRECTIONS.len()]
}

/// Describes a zone of the field in a channel at a distance.
pub(super) fn place(place: &Place) -> String {
    let far = match place.zone.radius {
        [from, to] if from < 0.05 && to > 0.95 => "the whole field",
        [from, _] if from < 0.05 => "the centre of the field",
        [_, to] if to > 0.95 => "the edge of the field",
        _ => "half-way to the edge of the field",
    };
    let direction = match angle(place.zone.angle_deg) {
        "all directions" => String::new(),
        direction @ ("below" | "above") => format!(", {direction} the axis"),
        direction => format!(", {direction} of the axis"),
    };
    let depth = match place.distance {
        ObjectDistance::Unknown => String::new(),
        known => format!(" at {}", distance(known)),
    };
    format!("channel {}{depth}, {far}{direction}", place.channel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_significant_digits() {
        assert_eq!(percent(0.942), "94\u{a0}%");
        assert_eq!(percent(0.9942), "99.4\u{a0}%");
        assert_eq!(percent(0.0123), "1.2\u{a0}%");
        assert_eq!(percent(-0.0001), "0.0\u{a0}%");
        assert_eq!(percent_range([0.921, 0.958]), "92–96\u{a0}%");
        assert_eq!(percent_range([-0.021, 0.17]), "−2.1 to 17\u{a0}%");
        assert_eq!(gap(0.0812), "8.1\u{a0}%");
        assert_eq!(gap(0.004), "0.40\u{a0}%");
        assert_eq!(gap(0.000_047), "0.0047\u{a0}%");
        assert_eq!(round_gap(0.01), "1\u{a0}%");
        assert_eq!(probability(1e-9), "<\u{a0}0.1\u{a0}%");
        let mut v = Value {
            name: "w060",
            channel: None,
            unit: "px",
            value: -1.2345,
            sigma: 0.012,
        };
        assert_eq!(value(&v), "−1.234 ± 0.012");
        v.sigma = 0.0;
        assert_eq!(value(&v), "−1.234");
    }

    #[test]
    fn zones_and_lists_are_named() {
        assert_eq!(angle([0.0, 90.0]), "lower right");
        assert_eq!(angle([315.0, 405.0]), "right");
        assert_eq!(angle([-180.0, 180.0]), "all directions");
        let names = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(list(&names, "and"), "a, b and c");
        assert_eq!(list(&names[..1], "and"), "a");
        assert_eq!(sentence("the barrel"), "The barrel");
    }
}
