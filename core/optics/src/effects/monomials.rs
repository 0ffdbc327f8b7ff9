//! Wavefront terms that are monomials of pupil and field: the common part of effects without rotational symmetry.

use super::meridional_terms::coefficient;
use super::{ControlRatios, Parameter};
use crate::field::FieldPoint;
use crate::lens::{LocalPupil, VergenceSeries};

/// The term `u_x^i u_y^j x^k y^l` of a wavefront.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FieldMonomial {
    /// Powers (i, j) of the pupil point.
    pupil: [usize; 2],
    /// Powers (k, l) of the field point.
    field: [i32; 2],
}

impl FieldMonomial {
    pub(super) const fn new(pupil: [usize; 2], field: [i32; 2]) -> Self {
        Self { pupil, field }
    }

    /// Returns the name of the term's parameter: `w` and the powers of u_x, u_y, x, y.
    #[cfg(test)]
    pub(super) fn name(&self) -> String {
        let ([i, j], [k, l]) = (self.pupil, self.field);
        format!("w{i}{j}{k}{l}")
    }

    /// The degree in the pupil.
    fn pupil_degree(&self) -> usize {
        self.pupil[0] + self.pupil[1]
    }
}

/// The parameter of a term of degree `of_field` in the field; `meaning` is the term itself.
pub(super) const fn monomial(
    name: &'static str,
    meaning: &'static str,
    of_field: usize,
) -> Parameter {
    const UNITS: [&str; 5] = ["px", "px/h", "px/h²", "px/h³", "px/h⁴"];
    coefficient(name, UNITS[of_field], meaning)
}

/// Adds `terms` with `values` to the wavefront of `pupil`. A value is the term's slope at the rim, px.
pub(super) fn apply(
    terms: &[FieldMonomial],
    values: &[f64],
    at: FieldPoint,
    pupil: &mut LocalPupil,
) {
    for (term, value) in terms.iter().zip(values) {
        let [i, j] = term.pupil;
        let field = at.x.powi(term.field[0]) * at.y.powi(term.field[1]);
        let coefficient = value * field / term.pupil_degree() as f64;
        pupil.wavefront.add_monomial(i, j, coefficient);
    }
}

/// Returns `values` of `terms` for a lens with other controls.
pub(super) fn rescaled(
    terms: &[FieldMonomial],
    values: &[VergenceSeries],
    ratios: ControlRatios,
) -> Vec<VergenceSeries> {
    let each = terms.iter().zip(values);
    each.map(|(term, series)| {
        series.scaled(ratios.of_wave_term(term.pupil_degree(), term.field[0] + term.field[1]))
    })
    .collect()
}
