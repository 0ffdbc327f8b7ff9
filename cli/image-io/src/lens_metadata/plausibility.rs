//! Values that cannot be true of a lens.

use super::number;
use super::record::{Quantity, UnitSource};

/// Bounds of values in the unit of each quantity; focus may also be infinite.
const FOCUS_M: (f64, f64) = (0.0, 1e6);
const F_NUMBERS: (f64, f64) = (0.5, 128.0);
const FOCAL_LENGTHS_MM: (f64, f64) = (1.0, 1e4);
const FILM_BACKS_MM: (f64, f64) = (0.5, 1e3);

/// Distances below this are never taken for millimetres, metres.
const LEAST_SUSPECT_M: f64 = 100.0;
/// Number of hyperfocal distances beyond which a lens is set to infinity, not to a distance.
const FAR_IN_HYPERFOCALS: f64 = 10.0;
/// Circle of confusion of the hyperfocal distance, millimetres: the usual one of 35 mm photography.
const CIRCLE_MM: f64 = 0.03;
/// Used where the file states none.
const USUAL_FOCAL_LENGTH_MM: f64 = 50.0;
const USUAL_F_NUMBER: f64 = 2.8;

/// The lens of a frame as far as it is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Optics {
    /// Focal length, millimetres.
    pub focal_length_mm: Option<f64>,
    /// F-number.
    pub f_number: Option<f64>,
}

/// A reason why a value cannot be true.
#[derive(Debug, Clone, PartialEq)]
pub struct Implausible {
    /// The value and its fault.
    pub problem: String,
    /// Advice to the user.
    pub remedy: String,
}

impl Optics {
    /// Returns why `value` of a `quantity` cannot be true of the lens; `None` if it can.
    pub fn check(&self, quantity: Quantity, value: f64, unit: UnitSource) -> Option<Implausible> {
        let text = quantity.text(value);
        let because = |problem: String| {
            Some(Implausible {
                problem,
                remedy: "correct it, or give the value by its option".to_owned(),
            })
        };
        if value.is_nan() {
            return because("is not a number of known unit".to_owned());
        }
        let (least, most) = match quantity {
            Quantity::Focus => FOCUS_M,
            Quantity::FNumber => F_NUMBERS,
            Quantity::FocalLength => FOCAL_LENGTHS_MM,
            Quantity::FilmBack => FILM_BACKS_MM,
        };
        let may_be_infinite = quantity == Quantity::Focus;
        if value == f64::INFINITY && may_be_infinite {
            return None;
        }
        if value <= 0.0 {
            return because(format!("is {text}, not above 0"));
        }
        if !(least..=most).contains(&value) {
            return because(format!("is {text}, which no lens has"));
        }
        if quantity != Quantity::Focus {
            return None;
        }
        let focal_mm = self.focal_length_mm;
        if let Some(focal_mm) = focal_mm.filter(|focal_mm| value * 1000.0 <= *focal_mm) {
            return because(format!(
                "is {text}, nearer than the focal length of {}",
                Quantity::FocalLength.text(focal_mm)
            ));
        }
        if unit != UnitSource::Defined || !self.is_like_millimetres(value) {
            return None;
        }
        let focal = focal_mm.map_or_else(String::new, |focal_mm| {
            format!(" on a lens of {}", Quantity::FocalLength.text(focal_mm))
        });
        Some(Implausible {
            problem: format!(
                "is {text}{focal}, where {} fits: the file may hold millimetres",
                Quantity::Focus.text(number::decimal(value / 1000.0))
            ),
            remedy: "correct the file, or give the focus distance".to_owned(),
        })
    }

    /// Returns whether a distance is so far that lenses say infinity, and would be a usual one in millimetres.
    fn is_like_millimetres(&self, value_m: f64) -> bool {
        let focal_mm = self.focal_length_mm.unwrap_or(USUAL_FOCAL_LENGTH_MM);
        let f_number = self.f_number.unwrap_or(USUAL_F_NUMBER);
        let hyperfocal_m = focal_mm * focal_mm / (f_number * CIRCLE_MM) / 1000.0;
        value_m >= LEAST_SUSPECT_M
            && value_m > FAR_IN_HYPERFOCALS * hyperfocal_m
            && value_m > 2.0 * focal_mm
    }
}
