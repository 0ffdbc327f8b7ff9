//! Numbers and names in words.

use seidel_core::calibrate::diagnose::{Place, Value};
use seidel_core::distance::ObjectDistance;
use seidel_core::effects;

/// A number and its unit stay on one line.
const SPACE: char = '\u{a0}';

/// A share in per cent: whole ones, tenths where whole ones would hide the difference to nothing or all.
pub(super) fn percent(share: f64) -> String {
    format!("{}{SPACE}%", percent_number(share))
}

fn percent_number(share: f64) -> String {
    let near_an_end = share.abs() < 0.0995 || (0.99..1.0).contains(&share);
    let decimals = usize::from(near_an_end && share != 0.0);
    signed(&format!("{:.decimals$}", 100.0 * share))
}

/// An interval of shares.
pub(super) fn percent_range((from, to): (f64, f64)) -> String {
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

/// A gap in per cent of the energy of a PSF, two digits that count.
pub(super) fn gap(value: f64) -> String {
    let share = 100.0 * value;
    if share == 0.0 || !share.is_finite() {
        return format!("{share}{SPACE}%");
    }
    let decimals = decimals(share, 2);
    format!("{}{SPACE}%", signed(&format!("{share:.decimals$}")))
}

/// A gap where round numbers stand: no zeros at the end.
pub(super) fn round_gap(value: f64) -> String {
    format!("{}{SPACE}%", digits(100.0 * value, 2))
}

/// A probability, never 0 or 100 %.
pub(super) fn odds(probability: f64) -> String {
    if probability < 0.001 {
        format!("<{SPACE}0.1{SPACE}%")
    } else if probability > 0.999 {
        format!(">{SPACE}99.9{SPACE}%")
    } else {
        percent(probability)
    }
}

/// A value with its standard error, both to two digits of the error.
pub(super) fn value(value: &Value) -> String {
    if value.sigma <= 0.0 {
        return digits(value.value, 4);
    }
    let decimals = decimals(value.sigma, 2);
    format!(
        "{} ± {:.decimals$}",
        signed(&format!("{:.decimals$}", value.value)),
        value.sigma
    )
}

/// A number to `count` significant digits, without zeros at the end of its decimals.
pub(super) fn digits(value: f64, count: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return signed(&format!("{value}"));
    }
    let decimals = decimals(value, count);
    let text = format!("{value:.decimals$}");
    let short = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    signed(short)
}

/// Decimals that give `value` so many significant digits.
fn decimals(value: f64, count: i32) -> usize {
    (count - 1 - value.abs().log10().floor() as i32).clamp(0, 9) as usize
}

/// A minus sign for the hyphen; none on a zero.
fn signed(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => number.to_owned(),
    }
}

/// An object distance.
pub(super) fn distance(distance: ObjectDistance) -> String {
    match distance {
        ObjectDistance::Unknown => "unknown distance".to_owned(),
        ObjectDistance::Infinity => "infinity".to_owned(),
        ObjectDistance::Metres(m) => format!("{}{SPACE}m", digits(m, 3)),
    }
}

/// An effect's identifier as words.
pub(super) fn effect_name(id: &str) -> String {
    match id {
        "unknown" => "an unknown cause".to_owned(),
        id => id.replace('_', " "),
    }
}

/// What an effect is and looks like.
pub(super) fn effect_summary(id: &str) -> &'static str {
    match id {
        "unknown" => "none of the effects that this program knows",
        id => effects::by_id(id).map_or("", |effect| effect.summary()),
    }
}

/// `a`, `a and b`, `a, b and c`, whatever the last word before the last is.
pub(super) fn list(names: &[String], last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

/// The first letter large.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

/// Where from the axis a part of the field lies: which way.
pub(super) fn direction((from, to): (f64, f64)) -> &'static str {
    const WAYS: [&str; 8] = [
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
        return "all round";
    }
    let eighth = ((from + to) / 2.0).rem_euclid(360.0) / 45.0;
    WAYS[eighth.round() as usize % WAYS.len()]
}

/// How far from the axis a part of the field lies.
pub(super) fn radius((from, to): (f64, f64)) -> String {
    format!("{:.2}–{:.2}", from, to)
}

/// A part of the field in a sentence.
pub(super) fn place(place: &Place) -> String {
    let (from, to) = place.radius;
    let far = match (from, to) {
        (f, t) if f < 0.05 && t > 0.95 => "over the whole field".to_owned(),
        (f, _) if f < 0.05 => "near the middle of the field".to_owned(),
        (_, t) if t > 0.95 => "towards the edge of the field".to_owned(),
        _ => "half-way to the edge of the field".to_owned(),
    };
    let way = match direction(place.angle_deg) {
        way @ ("all round" | "below" | "above") => way.to_owned(),
        way => format!("to the {way}"),
    };
    let depth = match place.distance {
        ObjectDistance::Unknown => String::new(),
        known => format!(" at {}", distance(known)),
    };
    format!("channel {}{depth}, {far}, {way}", place.channel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_values_keep_the_digits_that_count() {
        assert_eq!(percent(0.942), "94\u{a0}%");
        assert_eq!(percent(0.9942), "99.4\u{a0}%");
        assert_eq!(percent(0.0123), "1.2\u{a0}%");
        assert_eq!(percent(-0.0001), "0.0\u{a0}%");
        assert_eq!(percent_range((0.921, 0.958)), "92–96\u{a0}%");
        assert_eq!(percent_range((-0.021, 0.17)), "−2.1 to 17\u{a0}%");
        assert_eq!(gap(0.0812), "8.1\u{a0}%");
        assert_eq!(gap(0.004), "0.40\u{a0}%");
        assert_eq!(gap(0.000_047), "0.0047\u{a0}%");
        assert_eq!(round_gap(0.01), "1\u{a0}%");
        assert_eq!(odds(1e-9), "<\u{a0}0.1\u{a0}%");
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
    fn parts_of_the_field_have_words() {
        assert_eq!(direction((0.0, 90.0)), "lower right");
        assert_eq!(direction((315.0, 405.0)), "right");
        assert_eq!(direction((-180.0, 180.0)), "all round");
        let names = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(list(&names, "and"), "a, b and c");
        assert_eq!(list(&names[..1], "and"), "a");
        assert_eq!(sentence("the barrel"), "The barrel");
    }
}
