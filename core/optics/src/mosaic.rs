//! Colour filter mosaics: which colour of light each pixel of a raw photograph records.

use std::fmt;

use crate::error::{Error, Result};

/// A colour filter mosaic that repeats every two columns and rows, such as that of Bayer.
///
/// Its phase is that of the frame: the first letter is the colour of the frame's top-left pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Mosaic {
    /// Colours of the top row's two pixels, then of the second row's.
    pattern: [char; 4],
}

impl Mosaic {
    /// Creates a mosaic from four letters, such as `RGGB`.
    ///
    /// # Errors
    /// Rejects text that is not four of the letters R, G and B, or lacks one of the three.
    pub fn parse(text: &str) -> Result<Self> {
        let letters: Vec<char> = text.chars().collect();
        let pattern: [char; 4] = match letters.try_into() {
            Ok(pattern) => pattern,
            Err(_) => return Err(invalid(text)),
        };
        let known = pattern.iter().all(|c| "RGB".contains(*c));
        let complete = "RGB".chars().all(|c| pattern.contains(&c));
        if known && complete {
            Ok(Self { pattern })
        } else {
            Err(invalid(text))
        }
    }

    /// Returns the colour of the pixel in `column` and `row` of the frame.
    pub fn colour_at(&self, column: usize, row: usize) -> char {
        self.pattern[2 * (row % 2) + column % 2]
    }

    /// Returns whether the pixel in `column` and `row` of the frame has the colour of the channel called `name`.
    pub fn is_of(&self, name: &str, column: usize, row: usize) -> bool {
        let mut letters = name.chars();
        letters.next() == Some(self.colour_at(column, row)) && letters.next().is_none()
    }

    /// Returns the mosaic of the frame whose top-left pixel is the one in `column` and `row` of this one.
    #[must_use]
    pub fn shifted(&self, column: usize, row: usize) -> Self {
        let at = |k: usize| self.colour_at(column + k % 2, row + k / 2);
        Self {
            pattern: std::array::from_fn(at),
        }
    }

    /// Returns the share of the pixels that have the colour of the channel called `name`.
    pub fn share_of(&self, name: &str) -> f64 {
        let of = (0..4).filter(|k| self.is_of(name, k % 2, k / 2));
        of.count() as f64 / 4.0
    }
}

impl fmt::Display for Mosaic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.pattern.iter().try_for_each(|c| write!(f, "{c}"))
    }
}

fn invalid(text: &str) -> Error {
    Error::new(
        "mosaic",
        format!("is `{text}`"),
        "give the colours of the frame's top-left 2 x 2 pixels, such as RGGB",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_is_that_of_the_top_left_pixel() {
        let mosaic = Mosaic::parse("GRBG").expect("a pattern");
        assert_eq!(mosaic.to_string(), "GRBG");
        assert_eq!(mosaic.colour_at(1, 0), 'R');
        assert_eq!(mosaic.colour_at(2, 3), 'B');
        assert!(mosaic.is_of("G", 5, 7) && !mosaic.is_of("GG", 5, 7));
        assert_eq!(mosaic.shifted(1, 0).to_string(), "RGGB");
        assert_eq!(mosaic.share_of("G"), 0.5);
        assert_eq!(mosaic.share_of("Y"), 0.0);
        for bad in ["RGB", "RGGBX", "RGGX", "RRGG", ""] {
            assert!(Mosaic::parse(bad).is_err(), "{bad}");
        }
    }
}
