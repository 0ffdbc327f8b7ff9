//! Numbers, names and places as text.

use seidel_calibrate::diagnose::cause_words;
use seidel_core::ObjectDistance;
use seidel_core::diagnosis::Place;
use seidel_optics::effects::FittedValue;

use crate::pictures::{decimals, significant};
use crate::terms::with_options;

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

/// Share from which on a gap counts as closed entirely.
const ALL_CLOSED: f64 = 0.9995;

/// Formats the share of a gap that closes.
pub(super) fn closed(share: f64) -> String {
    if share > ALL_CLOSED {
        format!("more than 99.9{SPACE}%")
    } else {
        percent(share)
    }
}

/// Formats the 95 % interval of a share of the gap in words.
pub(super) fn between([from, to]: [f64; 2]) -> String {
    if from > ALL_CLOSED {
        format!("{} (95{SPACE}% interval)", closed(from))
    } else {
        interval(&percent(from), &percent(to))
    }
}

/// Width of the 95 % interval of the closed share from which on observations do not determine it.
const WIDE_INTERVAL: f64 = 0.3;

/// Returns whether observations do not determine the closed share with that 95 % interval.
pub(super) fn is_wide([from, to]: [f64; 2]) -> bool {
    to - from > WIDE_INTERVAL
}

/// Formats the closed share of a gap with its 95 % interval in words.
pub(super) fn closed_between(share: f64, interval: [f64; 2]) -> String {
    if is_wide(interval) {
        "a share that these observations do not determine".to_owned()
    } else if interval[0] > ALL_CLOSED {
        between(interval)
    } else if is_narrow(interval) {
        closed(share)
    } else {
        format!("{}, {}", closed(share), between(interval))
    }
}

/// Returns whether both ends of an interval read the same.
pub(super) fn is_narrow([from, to]: [f64; 2]) -> bool {
    percent(from) == percent(to)
}

/// Formats the 95 % interval of the gap of a zone in words; `None` where it is wider than the gap, or ends above all light.
pub(super) fn gap_interval(place: &Place) -> Option<String> {
    let half = 1.96 * place.excess / place.z.max(f64::MIN_POSITIVE);
    let bound = |value: f64| {
        let decimals = decimals(100.0 * place.excess, 2);
        let share = format!("{:.decimals$}", 100.0 * value.max(0.0));
        format!("{}{SPACE}%", minus_sign(&share))
    };
    let is_stated = half <= place.excess / 2.0 && place.excess + half <= 1.0;
    is_stated.then(|| interval(&bound(place.excess - half), &bound(place.excess + half)))
}

fn interval(from: &str, to: &str) -> String {
    if from == to {
        format!("{from} (95{SPACE}% interval)")
    } else {
        format!("between {from} and {to} (95{SPACE}% interval)")
    }
}

/// Formats a gap in per cent of the energy of a PSF, to two significant digits. Less than what noise gives is zero.
pub(super) fn gap(value: f64) -> String {
    let share = 100.0 * value;
    if share < 0.0 {
        return format!("0{SPACE}% (within noise)");
    }
    if share > 100.0 {
        return format!("more than 100{SPACE}%");
    }
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

/// Formats a probability for HTML, never as 0 or 100 %.
pub(super) fn probability(probability: f64) -> String {
    if probability < 0.001 {
        format!("&lt;{SPACE}0.1{SPACE}%")
    } else if probability > 0.999 {
        format!("&gt;{SPACE}99.9{SPACE}%")
    } else {
        percent(probability)
    }
}

/// Formats a value with its standard error, both to two digits of the error.
pub(super) fn value(value: &FittedValue) -> String {
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

/// Returns the name of an effect in plain words; its identifier where it has none.
pub(super) fn title(id: &str) -> &str {
    cause_words(id).title
}

/// Returns the meaning of an effect for the lens or the camera.
pub(super) fn meaning(id: &str) -> &'static str {
    cause_words(id).meaning
}

/// Returns the advice on what to do about an effect.
pub(super) fn action(id: &str) -> String {
    with_options(cause_words(id).action)
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
        assert_eq!(closed(0.942), "94\u{a0}%");
        assert_eq!(closed(1.02), "more than 99.9\u{a0}%");
        assert_eq!(gap(0.0812), "8.1\u{a0}%");
        assert_eq!(gap(0.004), "0.40\u{a0}%");
        assert_eq!(gap(0.000_047), "0.0047\u{a0}%");
        assert_eq!(round_gap(0.01), "1\u{a0}%");
        assert_eq!(probability(1e-9), "&lt;\u{a0}0.1\u{a0}%");
        let mut v = FittedValue {
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
    fn intervals_are_in_words() {
        let words = |ends| between(ends).replace('\u{a0}', " ");
        assert_eq!(
            words([0.921, 0.958]),
            "between 92 % and 96 % (95 % interval)"
        );
        assert_eq!(
            words([-0.021, 0.17]),
            "between −2.1 % and 17 % (95 % interval)"
        );
        assert_eq!(words([0.9997, 1.0]), "more than 99.9 % (95 % interval)");
        assert_eq!(words([0.5, 0.501]), "50 % (95 % interval)");
        assert_eq!(
            closed_between(0.942, [0.921, 0.958]).replace('\u{a0}', " "),
            "94 %, between 92 % and 96 % (95 % interval)"
        );
        assert_eq!(closed_between(1.0, [0.9997, 1.0]), between([0.9997, 1.0]));
        let wide = closed_between(0.88, [0.0, 1.0]);
        assert_eq!(wide, "a share that these observations do not determine");
        assert_eq!(gap(2.17).replace('\u{a0}', " "), "more than 100 %");
        let place = &crate::report::samples::places()[0];
        assert_eq!(
            gap_interval(place).expect("narrow").replace('\u{a0}', " "),
            "between 13 % and 15 % (95 % interval)"
        );
        let mut wide = place.clone();
        wide.z = 3.0;
        assert_eq!(gap_interval(&wide), None);
        assert_eq!(closed_between(0.9994, [0.9992, 0.9994]), "99.9\u{a0}%");
        assert_eq!(gap(-1e-4), "0\u{a0}% (within noise)");
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
