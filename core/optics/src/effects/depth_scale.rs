//! Object distances are wrong by a factor.

use super::{ControlRatios, Effect, Parameter, ScenePoint, SearchStart};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `depth_scale`: a point stands at `factor` times the distance that is stated.
///
/// Looks like defocus that is wrong in proportion to vergence: with `pivot` 1, the focus distance being
/// wrong by the same factor, nothing changes in focus and the error grows with the distance from it;
/// with `pivot` 0 the focus is where it was and only far points are right. Mistaken for
/// `defocus_offset`, which it is at a single distance. Defocus is c (v - v_focus) by the depth law of the
/// lens (docs/background/model.md section 3), so alpha gains c (1/factor - 1) (v - pivot v_focus); what else depends
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

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        let &[factor, pivot] = values else {
            panic!("one value a parameter");
        };
        let off = point.vergence_per_m - pivot * point.focus_vergence_per_m;
        let alpha = point.defocus_px_m * (1.0 / factor - 1.0) * off;
        pupil.wavefront.add(1, 0, Meridian::X, alpha / 2.0);
    }

    fn starts(&self) -> Vec<SearchStart> {
        let from = |pivot| SearchStart {
            values: vec![1.05, pivot],
            free: vec![true, false],
        };
        vec![from(0.0), from(1.0)]
    }

    // A matter of the tape measure, not of the glass: the lens's own law of depth is reset.
    fn rescale(&self, values: &[VergenceSeries], _to: ControlRatios) -> Vec<VergenceSeries> {
        values.to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, point};

    fn at_vergence(v: f64) -> ScenePoint {
        ScenePoint {
            vergence_per_m: v,
            ..point()
        }
    }

    /// Defocus of the tests' lens for an object at vergence `v`, focused at `focus`.
    fn law(v: f64, focus: f64) -> LocalPupil {
        disc(point().defocus_px_m * (v - focus))
    }

    #[test]
    fn the_lens_is_asked_for_the_true_distance() {
        let focus = point().focus_vergence_per_m;
        for v in [0.0, 0.3, focus, 1.5] {
            for (pivot, true_focus) in [(0.0, focus), (1.0, focus / 1.25)] {
                let got = behind(&DepthScale, &[1.25, pivot], at_vergence(v), law(v, focus));
                let want = law(v / 1.25, true_focus);
                let (a, b) = (got.landing([1.0, 0.0])[0], want.landing([1.0, 0.0])[0]);
                assert!((a - b).abs() < 1e-12, "{v} {pivot}: {a} {b}");
            }
        }
    }

    #[test]
    fn nothing_changes_at_the_pivot() {
        let focus = point().focus_vergence_per_m;
        for (v, pivot) in [(focus, 1.0), (0.0, 0.0)] {
            let pupil = behind(&DepthScale, &[1.3, pivot], at_vergence(v), disc(2.0));
            assert_eq!(pupil, disc(2.0));
        }
    }
}
