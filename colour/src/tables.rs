//! Look-up tables as text: what other programs read curves and transforms from.

use std::fmt::Write;

/// A 1D table in the format of Sony Pictures Imageworks, `.spi1d`: what becomes of evenly spaced values from the first
/// to the last of `range`.
pub fn spi1d(range: (f32, f32), entries: &[[f32; 3]]) -> String {
    let mut text = format!(
        "Version 1\nFrom {:?} {:?}\nLength {}\nComponents 3\n{{\n",
        range.0,
        range.1,
        entries.len()
    );
    // A String takes all that is written.
    for [red, green, blue] in entries {
        let _ = writeln!(text, "    {red:?} {green:?} {blue:?}");
    }
    text.push_str("}\n");
    text
}

/// The same of a curve that is one for all channels.
pub fn spi1d_of_one(range: (f32, f32), entries: &[f32]) -> String {
    let mut text = format!(
        "Version 1\nFrom {:?} {:?}\nLength {}\nComponents 1\n{{\n",
        range.0,
        range.1,
        entries.len()
    );
    for entry in entries {
        let _ = writeln!(text, "    {entry:?}");
    }
    text.push_str("}\n");
    text
}

/// A 3D table in the format of Iridas and Resolve, `.cube`, of `size` entries a side from the first to the last of
/// `range`; red changes quickest.
pub fn cube(title: &str, size: usize, range: (f32, f32), entries: &[[f32; 3]]) -> String {
    let title = title.replace('"', "'");
    let (low, high) = range;
    let mut text = format!("TITLE \"{title}\"\nLUT_3D_SIZE {size}\n");
    // All readers take it for granted, and not all know the words.
    if range != (0.0, 1.0) {
        let _ = writeln!(text, "DOMAIN_MIN {low:?} {low:?} {low:?}");
        let _ = writeln!(text, "DOMAIN_MAX {high:?} {high:?} {high:?}");
    }
    for [red, green, blue] in entries {
        let _ = writeln!(text, "{red:?} {green:?} {blue:?}");
    }
    text
}

/// `count` values evenly spaced over `range`, its ends included.
pub fn evenly(range: (f32, f32), count: usize) -> Vec<f32> {
    let (low, high) = (f64::from(range.0), f64::from(range.1));
    let last = count.saturating_sub(1).max(1) as f64;
    let at = |i: usize| low + (high - low) * (i as f64 / last);
    (0..count).map(|i| at(i) as f32).collect()
}

/// The colours of a [`cube`]'s entries before it changes them.
pub fn cube_grid(size: usize, range: (f32, f32)) -> Vec<[f32; 3]> {
    let values = evenly(range, size);
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
    fn texts_are_those_of_the_formats() {
        assert_eq!(
            spi1d_of_one((-0.125, 1.125), &[0.0, 1e-7]),
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
