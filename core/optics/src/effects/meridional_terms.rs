//! Wavefront terms of a rotationally symmetric lens: the common part of aberrations of higher order.

use super::{ControlRatios, Parameter, ScenePoint};
use crate::lens::{LocalPupil, VergenceSeries};

/// The term h^k |u|^l cos^m of Hopkins's expansion, W_klm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MeridionalTerm {
    /// Power of |u|², (l - m) / 2.
    round: usize,
    /// Power m of u along the meridian.
    along: usize,
    /// Power k of the field radius.
    field: i32,
}

impl MeridionalTerm {
    /// Creates W_klm.
    pub(super) const fn w(k: i32, l: usize, m: usize) -> Self {
        Self {
            round: (l - m) / 2,
            along: m,
            field: k,
        }
    }

    fn pupil_degree(&self) -> usize {
        2 * self.round + self.along
    }
}

/// The parameter of a term, in px of slope per half frame width to the power of `unit`.
pub(super) const fn coefficient(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
) -> Parameter {
    Parameter::new(name, unit, meaning)
        .within(-1e4, 1e4)
        .step(0.1)
}

/// Adds `terms` with `values` to the wavefront of `pupil`. A value is the slope at the rim along the meridian, px.
pub(super) fn apply(
    terms: &[MeridionalTerm],
    values: &[f64],
    point: ScenePoint,
    pupil: &mut LocalPupil,
) {
    assert_eq!(values.len(), terms.len(), "one value a term");
    let (h, meridian) = (point.at.radius(), point.at.meridian());
    for (term, value) in terms.iter().zip(values) {
        let coefficient = value * h.powi(term.field) / term.pupil_degree() as f64;
        if coefficient != 0.0 {
            (pupil.wavefront).add(term.round, term.along, meridian, coefficient);
        }
    }
}

/// Returns `values` of `terms` for a lens with other controls.
pub(super) fn rescaled(
    terms: &[MeridionalTerm],
    values: &[VergenceSeries],
    ratios: ControlRatios,
) -> Vec<VergenceSeries> {
    let each = terms.iter().zip(values);
    each.map(|(term, series)| series.scaled(ratios.of_wave_term(term.pupil_degree(), term.field)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Effect, HigherOrder, SeventhOrder};
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
        let effects: [&dyn Effect; 2] = [&HigherOrder, &SeventhOrder];
        for effect in effects {
            for (k, parameter) in effect.parameters().iter().enumerate() {
                // The name says the power of the field: w_klm.
                let field = i32::from(parameter.name.as_bytes()[1] - b'0');
                let mut values = crate::effects::neutral(effect);
                values[k] = 2.0;
                let mut pupil = LocalPupil::circular(Wavefront::default(), 0.0);
                effect.apply(&values, point, &mut pupil);
                let slope = pupil.wavefront.slope([0.6, 0.8]);
                let want = 2.0 * 0.8_f64.powi(field);
                assert!((slope[0] - 0.6 * want).abs() < 1e-12, "{k} {slope:?}");
                assert!((slope[1] - 0.8 * want).abs() < 1e-12, "{k} {slope:?}");
            }
        }
    }
}
