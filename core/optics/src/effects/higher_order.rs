//! Fifth-order aberrations: the eight wave terms of sixth degree in pupil and field.

use super::{ControlRatios, Effect, Parameter, ScenePoint, Scope, SearchStart};
use crate::lens::{LocalPupil, VergenceSeries};

/// `higher_order`: higher-order spherical aberration, oblique spherical aberration, and coma, astigmatism and field
/// curvature that grow faster with field.
///
/// # Appearance
/// Rings and flares in discs that are even to third order; corners that third-order fits of the centre do not predict.
///
/// # Similar effects
/// Defocus that changes with field; vignetting.
///
/// # Model
/// Hopkins's terms `W_klm`, h^k |u|^l cos^m, without distortion. Values are the slope at the rim of the pupil in px, per
/// half frame width to the power k.
#[derive(Debug, Clone, Copy, Default)]
pub struct HigherOrder;

/// For each term, the powers of |u|², of u along the meridian, and of the field radius.
const TERMS: [(usize, usize, i32); 8] = [
    (3, 0, 0),
    (2, 1, 1),
    (1, 2, 2),
    (2, 0, 2),
    (0, 3, 3),
    (1, 1, 3),
    (0, 2, 4),
    (1, 0, 4),
];

const fn term(name: &'static str, unit: &'static str, meaning: &'static str) -> Parameter {
    Parameter {
        name,
        unit,
        meaning,
        neutral: 0.0,
        least: -1e4,
        most: 1e4,
        step: 0.1,
        scope: Scope::Lens,
    }
}

static PARAMETERS: [Parameter; 8] = [
    term("w060", "px", "spherical aberration, sixth order"),
    term("w151", "px/h", "coma, linear in field"),
    term("w242", "px/h²", "oblique spherical aberration, meridional"),
    term("w240", "px/h²", "oblique spherical aberration, isotropic"),
    term("w333", "px/h³", "elliptical coma"),
    term("w331", "px/h³", "coma, cubic in field"),
    term("w422", "px/h⁴", "astigmatism"),
    term("w420", "px/h⁴", "field curvature"),
];

impl Effect for HigherOrder {
    fn id(&self) -> &'static str {
        "higher_order"
    }

    fn summary(&self) -> &'static str {
        "fifth-order aberrations: rings and flares in discs, corners that grow worse faster"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), TERMS.len(), "one value a term");
        let (h, meridian) = (point.at.radius(), point.at.meridian());
        for ((round, along, of_field), value) in TERMS.into_iter().zip(values) {
            let degree = (2 * round + along) as f64;
            let coefficient = value * h.powi(of_field) / degree;
            if coefficient != 0.0 {
                pupil.wavefront.add(round, along, meridian, coefficient);
            }
        }
    }

    fn starts(&self) -> Vec<SearchStart> {
        let mut values = [0.0; TERMS.len()];
        values[0] = 0.1;
        vec![SearchStart::all_free(&values)]
    }

    // The slope at the rim has pupil power l - 1; the field angle X / Z2 has power k; lengths scale with Z2.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let terms = TERMS.into_iter().zip(values);
        terms
            .map(|((round, along, of_field), series)| {
                let of_pupil = ratios.pupil.powi((2 * round + along) as i32 - 1);
                series.scaled(of_pupil * ratios.image_distance.powi(1 - of_field))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FieldPoint;
    use crate::lens::Wavefront;

    #[test]
    fn a_value_is_the_slope_at_the_rim_along_the_meridian() {
        let at = FieldPoint::new(0.48, 0.64);
        let point = ScenePoint {
            at,
            ..crate::effects::tests::point()
        };
        for (k, (_, _, of_field)) in TERMS.into_iter().enumerate() {
            let mut values = [0.0; 8];
            values[k] = 2.0;
            let mut pupil = LocalPupil::circular(Wavefront::default(), 0.0);
            HigherOrder.apply(&values, point, &mut pupil);
            let slope = pupil.wavefront.slope([0.6, 0.8]);
            let want = 2.0 * 0.8_f64.powi(of_field);
            assert!((slope[0] - 0.6 * want).abs() < 1e-12, "{k} {slope:?}");
            assert!((slope[1] - 0.8 * want).abs() < 1e-12, "{k} {slope:?}");
        }
    }
}
