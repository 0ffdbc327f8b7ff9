//! Numbers as makers write them: lengths with units, fractions, f-numbers with fractions of stops, hexadecimal floats.

/// Returns a number: decimal, a fraction such as `45/10`, or `inf`. `None` for NaN and anything else.
pub(super) fn parse(text: &str) -> Option<f64> {
    let text = text.trim();
    if matches!(
        text.to_ascii_lowercase().as_str(),
        "inf" | "infinity" | "+inf" | "∞"
    ) {
        return Some(f64::INFINITY);
    }
    let plain = |text: &str| text.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((numerator, denominator)) => plain(numerator)? / plain(denominator)?,
        None => plain(text)?,
    };
    (!value.is_nan()).then_some(value)
}

/// Returns the millimetres in a unit of length.
pub(super) fn millimetres_per(unit: &str) -> Option<f64> {
    match unit.trim().to_ascii_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" | "metric" => Some(1000.0),
        "cm" => Some(10.0),
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Some(1.0),
        "ft" | "foot" | "feet" | "'" | "imperial" => Some(304.8),
        "in" | "inch" | "inches" | "\"" => Some(25.4),
        _ => None,
    }
}

/// A length with the unit that stands beside it.
pub(super) struct Length<'t> {
    pub(super) value: f64,
    /// Unit as written; empty if there is none.
    pub(super) unit: &'t str,
}

/// Splits a length such as `991mm` into number and unit.
pub(super) fn parse_length(text: &str) -> Option<Length<'_>> {
    let text = text.trim();
    if let Some(value) = parse(text) {
        return Some(Length { value, unit: "" });
    }
    let is_unit = |c: char| c.is_alphabetic() || ['\'', '"'].contains(&c);
    let number = text.trim_end_matches(is_unit);
    Some(Length {
        value: parse(number)?,
        unit: &text[number.len()..],
    })
}

/// An f-number or T-number.
pub(super) struct Stop {
    pub(super) value: f64,
    pub(super) is_t_stop: Option<bool>,
}

/// Parses `5.6`, `f/2.8`, `T2.3`, and full stops with tenths, such as `1.4 + 7/10` and `T 2 3/10`.
pub(super) fn parse_stop(text: &str) -> Option<Stop> {
    let text = text.trim();
    let (is_t_stop, rest) = match text.chars().next()? {
        'T' | 't' => (Some(true), &text[1..]),
        'F' | 'f' => (Some(false), &text[1..]),
        _ => (None, text),
    };
    let rest = rest.trim_start_matches(['/', ' ']);
    let value = match rest.split_once(['+', ' ']) {
        None => parse(rest)?,
        Some((base, part)) => {
            let stops = parse(part.trim().trim_start_matches('+'))?;
            let base = full_stop(parse(base)?)?;
            decimal(base * (stops / 2.0).exp2())
        }
    };
    Some(Stop { value, is_t_stop })
}

/// Returns the exact value of a full stop, a power of the square root of two, that rings write with two digits.
fn full_stop(nominal: f64) -> Option<f64> {
    let exact = (2.0 * nominal.log2()).round() / 2.0;
    let exact = exact.exp2();
    // 5.6 and 11 are written for 5.657 and 11.31.
    let is_near = nominal > 0.0 && (nominal / exact - 1.0).abs() < 0.04;
    is_near.then_some(exact)
}

/// Returns the float whose bits are eight hexadecimal digits, as a short decimal number.
pub(super) fn parse_hexadecimal_float(text: &str) -> Option<f64> {
    let text = text.trim();
    if text.len() != 8 {
        return None;
    }
    let value = f32::from_bits(u32::from_str_radix(text, 16).ok()?);
    parse(&value.to_string())
}

/// Rounds to nine significant digits: arithmetic on decimal numbers stays decimal.
pub(super) fn decimal(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// Formats a value with at most five significant digits.
pub(super) fn rounded(value: f64) -> String {
    let value = format!("{value:.4e}").parse().unwrap_or(value);
    if value.is_finite() && value.abs() >= 1e9 {
        return format!("{value:e}");
    }
    value.to_string()
}
