//! Object distances are wrong by a factor.

use super::{Effect, Parameter, Resetting, ScenePoint, Start};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `depth_scale`: a point stands at `factor` times the distance that is stated.
///
/// Looks like defocus that is wrong in proportion to vergence: with `pivot` 1, the focus distance being
/// wrong by the same factor, nothing changes in focus and the error grows with the distance from it;
/// with `pivot` 0 the focus is where it was and only far points are right. Mistaken for
/// `defocus_offset`, which it is at a single distance. Defocus is c (v - v_focus) by the depth law of the
/// lens (docs/model.md section 3), so alpha gains c (1/factor - 1) (v - pivot v_focus); what else depends
/// on depth is left as it was. The law is the thin lens's.
#[derive(Debug, Clone, Copy, Default)]
pub struct DepthScale;

static PARAMETERS: [Parameter; 2] = [
    Parameter::new("factor", "1", "true object distance over the stated one")
        .at_rest(1.0)
        .within(0.3, 3.0)
        .step(0.005),
    Parameter::new(
        "pivot",
        "1",
        "whether the focus distance is wrong by the same factor: 1, or 0 where it is right",
    )
    .within(0.0, 1.0)
    .step(1.0),
];

impl Effect for DepthScale {
    fn id(&self) -> &'static str {
        "depth_scale"
    }

    fn summary(&self) -> &'static str {
        "object distances are wrong by a factor: defocus wrong in proportion to vergence"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn act(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        let &[factor, pivot] = values else {
            panic!("one value a parameter");
        };
        let off = point.vergence_per_m - pivot * point.focus_vergence_per_m;
        let alpha = point.defocus_px_m * (1.0 / factor - 1.0) * off;
        pupil.wavefront.add(1, 0, Meridian::X, alpha / 2.0);
    }

    fn starts(&self) -> Vec<Start> {
        let from = |pivot| Start {
            values: vec![1.05, pivot],
            free: vec![true, false],
        };
        vec![from(0.0), from(1.0)]
    }

    // A matter of the tape measure, not of the glass: the lens's own law of depth is reset.
    fn reset(&self, values: &[VergenceSeries], _to: Resetting) -> Vec<VergenceSeries> {
        values.to_vec()
    }
}
