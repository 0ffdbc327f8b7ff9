//! Object distance and vergence, its inverse, in which the depth law is a polynomial.

use crate::error::{Error, Result};

/// Distance of an object along the optical axis from the entrance pupil, away from the camera.
///
/// Files write the three cases as a missing key, `null`, and a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObjectDistance {
    /// Unknown.
    Unknown,
    /// At infinity: light arrives collimated.
    Infinity,
    /// A distance in metres, finite and positive.
    Metres(f64),
}

impl ObjectDistance {
    /// Creates a known distance from metres; positive infinity becomes [`ObjectDistance::Infinity`].
    ///
    /// # Errors
    /// Rejects NaN, zero and negative distances.
    pub fn metres(metres: f64) -> Result<Self> {
        if metres.is_nan() || metres <= 0.0 {
            return Err(Error::new(
                "distance",
                format!("is {metres} m"),
                "give metres along the optical axis from the entrance pupil, greater than zero, or null for infinity",
            ));
        }
        Ok(if metres.is_infinite() {
            Self::Infinity
        } else {
            Self::Metres(metres)
        })
    }

    /// Returns the vergence v = 1 / distance in 1/m (dioptres): 0 at infinity, `None` if unknown.
    pub fn vergence_per_m(self) -> Option<f64> {
        match self {
            Self::Unknown => None,
            Self::Infinity => Some(0.0),
            Self::Metres(m) => Some(1.0 / m),
        }
    }
}

impl std::fmt::Display for ObjectDistance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown => f.write_str("unknown distance"),
            Self::Infinity => f.write_str("infinity"),
            Self::Metres(m) => write!(f, "{m} m"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_checked_and_inverted() {
        assert_eq!(
            ObjectDistance::metres(4.0).expect("valid").vergence_per_m(),
            Some(0.25)
        );
        assert_eq!(
            ObjectDistance::metres(f64::INFINITY),
            Ok(ObjectDistance::Infinity)
        );
        assert_eq!(ObjectDistance::Infinity.vergence_per_m(), Some(0.0));
        assert_eq!(ObjectDistance::Unknown.vergence_per_m(), None);
        for bad in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(ObjectDistance::metres(bad).is_err(), "{bad}");
        }
    }
}
