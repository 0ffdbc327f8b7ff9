//! The thick lens with offset pupils (Eqs 2-4 and 7-10).

use crate::error::{Error, Result};

/// A thick lens in air, described by its Gaussian quantities, in any one length unit (millimetres in files).
///
/// Distances are from the rear principal plane: object-side ones positive towards the scene,
/// image-side ones positive towards the sensor. `None` as an object distance is infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThickLens {
    /// Focal length f.
    pub focal_length: f64,
    /// Separation T of the principal planes.
    pub principal_separation: f64,
    /// Entrance pupil Zenter.
    pub entrance_pupil: f64,
    /// Radius R of the entrance pupil: f / (2 N) for f-number N.
    pub pupil_radius: f64,
}

/// The conjugates of a thick lens for an object plane and a focused plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conjugates {
    /// Pupil magnification M = Zexit / (T - Zenter).
    pub magnification: f64,
    /// Exit pupil Zexit.
    pub exit_pupil: f64,
    /// Exit pupil to the image of the object, Z1.
    pub z1: f64,
    /// Exit pupil to the sensor, Z2.
    pub z2: f64,
    /// Vergence of the object at the entrance pupil, v = 1 / (Zobj - Zenter).
    pub vergence: f64,
    /// Vergence of the focused plane at the entrance pupil.
    pub focus_vergence: f64,
}

impl ThickLens {
    /// Returns the conjugates for an object at distance `object` with focus at distance `focus`; `None` is infinity.
    ///
    /// # Errors
    /// Rejects a focal length or pupil radius that is not positive, a plane within the focal length or behind the
    /// entrance pupil, and numbers that are not finite.
    pub fn conjugates(&self, focus: Option<f64>, object: Option<f64>) -> Result<Conjugates> {
        let f = self.focal_length;
        let positive = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(Error::new(
                    name,
                    format!("is {value}"),
                    "give a finite length greater than zero",
                ))
            }
        };
        positive("focal length", f)?;
        positive("pupil radius", self.pupil_radius)?;
        let e = self.principal_separation - self.entrance_pupil;
        // Eq 7, Zexit / (T - Zenter), is 0/0 if the entrance pupil lies in the front principal plane;
        // this form is regular there.
        let magnification = f / (f + e);
        let exit_pupil = e * magnification;
        let z1 = self.image_distance("object distance", object)? - exit_pupil;
        let z2 = self.image_distance("focus distance", focus)? - exit_pupil;
        let conjugates = Conjugates {
            magnification,
            exit_pupil,
            z1,
            z2,
            vergence: self.vergence("object distance", object)?,
            focus_vergence: self.vergence("focus distance", focus)?,
        };
        if ![magnification, z1, z2].iter().all(|v| v.is_finite()) {
            return Err(Error::new(
                "thick lens",
                "has no finite conjugates",
                "check focal length, principal planes and entrance pupil",
            ));
        }
        Ok(conjugates)
    }

    fn image_distance(&self, name: &str, object: Option<f64>) -> Result<f64> {
        let f = self.focal_length;
        let Some(z) = object else { return Ok(f) };
        let s = z - self.principal_separation;
        if !(s.is_finite() && s > f) {
            return Err(Error::new(
                name,
                format!("is {z}, within the focal length {f} of the front principal plane"),
                "give a plane further away: nearer ones have no real image",
            ));
        }
        Ok(f * s / (s - f))
    }

    fn vergence(&self, name: &str, object: Option<f64>) -> Result<f64> {
        let Some(z) = object else { return Ok(0.0) };
        let from_pupil = z - self.entrance_pupil;
        if from_pupil <= 0.0 {
            return Err(Error::new(
                name,
                format!("is {z}, behind the entrance pupil"),
                "give a plane in front of the entrance pupil",
            ));
        }
        Ok(1.0 / from_pupil)
    }
}

impl Conjugates {
    /// Returns M q = M (1 - Z2 / Z1) = (Z2 / M)(v - vfoc): the lateral ray offset per pupil offset.
    ///
    /// The second form avoids the cancellation in 1 - Z2 / Z1 near focus.
    pub fn defocus_slope(&self) -> f64 {
        self.z2 / self.magnification * (self.vergence - self.focus_vergence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_lenses_and_objects_are_rejected() {
        let lens = ThickLens {
            focal_length: 50.0,
            principal_separation: 10.0,
            entrance_pupil: 4.0,
            pupil_radius: 10.0,
        };
        assert!(lens.conjugates(None, Some(1000.0)).is_ok());
        assert!(lens.conjugates(None, Some(40.0)).is_err());
        assert!(lens.conjugates(Some(-2.0), None).is_err());
        let flat = ThickLens {
            focal_length: 0.0,
            ..lens
        };
        assert!(flat.conjugates(None, None).is_err());
    }

    #[test]
    fn defocus_slope_agrees_with_the_printed_form_away_from_focus() {
        let lens = ThickLens {
            focal_length: 50.0,
            principal_separation: 10.0,
            entrance_pupil: 4.0,
            pupil_radius: 10.0,
        };
        let c = lens.conjugates(Some(2000.0), Some(700.0)).expect("valid");
        let printed = c.magnification * (1.0 - c.z2 / c.z1);
        assert!((c.defocus_slope() / printed - 1.0).abs() < 1e-12);
    }
}
