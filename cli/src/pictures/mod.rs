//! Pictures of lenses and results: PSF sheets, PSFs side by side, plots, and plates for display.
//!
//! Pure functions from values to pixels or text; commands write the files.

mod canvas;
pub mod comparison;
pub mod display;
pub mod edge_sheet;
pub mod measured_sheet;
mod photograph_panel;
pub mod plate_gap;
pub mod plot;
pub mod printed;
mod psf_panel;
pub mod shapes;
pub mod sheet;
pub(crate) mod sheet_labels;
pub mod tile_panel;

/// Formats a number to three significant digits, without trailing zeros.
pub(crate) fn short_number(value: f64) -> String {
    significant(value, 3)
}

/// Returns the number of decimals that show `digits` significant digits of `value`.
pub(crate) fn decimals(value: f64, digits: i32) -> usize {
    (digits - 1 - value.abs().log10().floor() as i32).clamp(0, 9) as usize
}

/// Formats a number to `digits` significant digits, without trailing zeros after the point.
pub(crate) fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let decimals = decimals(value, digits);
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_significant_digits() {
        for (value, want) in [
            (2.0, "2"),
            (0.125, "0.125"),
            (1234.5, "1234"),
            (-26.66, "-26.7"),
            (0.0, "0"),
        ] {
            assert_eq!(short_number(value), want);
        }
    }
}
