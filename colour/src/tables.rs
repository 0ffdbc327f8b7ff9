//! Look-up tables as text, for programs without OpenColorIO.

use std::fmt::Write;

/// Formats a 1D table as Sony Pictures Imageworks' `.spi1d`.
///
/// `entries` are the outputs for evenly spaced inputs over `range`, both ends included. They have three `CHANNELS`, or
/// one that readers use for all three.
pub fn spi1d<const CHANNELS: usize>(range: (f32, f32), entries: &[[f32; CHANNELS]]) -> String {
    let mut text = format!(
        "Version 1\nFrom {:?} {:?}\nLength {}\nComponents {CHANNELS}\n{{\n",
        range.0,
        range.1,
        entries.len()
    );
    for entry in entries {
        text.push_str("   ");
        for value in entry {
            // Writing to a String cannot fail.
            let _ = write!(text, " {value:?}");
        }
        text.push('\n');
    }
    text.push_str("}\n");
    text
}

/// Formats a 3D table as `.cube` (Iridas, Resolve), with `size` entries a side over `range`, both ends included.
///
/// `entries` are the outputs for the inputs of [`cube_grid`]: red changes fastest.
pub fn cube(title: &str, size: usize, range: (f32, f32), entries: &[[f32; 3]]) -> String {
    let title = title.replace('"', "'");
    let (low, high) = range;
    let mut text = format!("TITLE \"{title}\"\nLUT_3D_SIZE {size}\n");
    // All readers assume 0 to 1, and some reject the keywords.
    if range != (0.0, 1.0) {
        let _ = writeln!(text, "DOMAIN_MIN {low:?} {low:?} {low:?}");
        let _ = writeln!(text, "DOMAIN_MAX {high:?} {high:?} {high:?}");
    }
    for [red, green, blue] in entries {
        let _ = writeln!(text, "{red:?} {green:?} {blue:?}");
    }
    text
}

/// Returns `count` evenly spaced values over `range`, both ends included.
pub fn linspace(range: (f32, f32), count: usize) -> Vec<f32> {
    let (low, high) = (f64::from(range.0), f64::from(range.1));
    let last = count.saturating_sub(1).max(1) as f64;
    let value = |i: usize| low + (high - low) * (i as f64 / last);
    (0..count).map(|i| value(i) as f32).collect()
}

/// Returns the inputs of the entries of a [`cube`], red changing fastest.
pub fn cube_grid(size: usize, range: (f32, f32)) -> Vec<[f32; 3]> {
    let values = linspace(range, size);
    let mut grid = Vec::with_capacity(size * size * size);
    for blue in &values {
        for green in &values {
            grid.extend(values.iter().map(|red| [*red, *green, *blue]));
        }
    }
    grid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_follow_their_formats() {
        assert_eq!(
            spi1d((-0.125, 1.125), &[[0.0], [1e-7]]),
            "Version 1\nFrom -0.125 1.125\nLength 2\nComponents 1\n{\n    0.0\n    1e-7\n}\n"
        );
        assert!(spi1d((0.0, 1.0), &[[0.5, 1.0, 2.0]]).contains("\n    0.5 1.0 2.0\n}"));
        let text = cube("a \"b\"", 2, (0.0, 1.0), &cube_grid(2, (0.0, 1.0)));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[..3],
            ["TITLE \"a 'b'\"", "LUT_3D_SIZE 2", "0.0 0.0 0.0"]
        );
        assert_eq!(lines[3], "1.0 0.0 0.0");
        assert_eq!(lines.len(), 10);
        assert!(cube("", 2, (0.0, 2.0), &[]).contains("DOMAIN_MAX 2.0 2.0 2.0"));
    }
}
