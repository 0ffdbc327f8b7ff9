//! Object distances wrong by a factor.

use super::{
    DefocusOffset, Description, Effect, Fitted, OneDistanceTwin, Parameter, ScenePoint, SearchStart,
};
use crate::field::Meridian;
use crate::lens::LocalPupil;

/// `depth_scale`: the true object distance is `factor` times the stated one.
///
/// # Appearance
/// Defocus with an error proportional to vergence. With `pivot` 1 the focus distance has the same error: nothing changes
/// in focus. With `pivot` 0 the focus distance is right: nothing changes at infinity.
///
/// # Similar effects
/// `defocus_offset`, which is the same at a single distance.
///
/// # Model
/// Defocus is c (v - v_focus) by the depth law of the lens (docs/background/model.md section 3), so alpha gains
/// c (1/`factor` - 1) (v - `pivot` v_focus). Other parameters that depend on depth stay, and
/// so does the factor at other lens controls.
#[derive(Debug, Clone, Copy, Default)]
pub struct DepthScale;

const PARAMETERS: [Parameter; 2] = [
    Parameter::new("factor", "1", "true object distance over the stated one")
        .neutral_at(1.0)
        .within(0.3, 3.0)
        .step(0.005),
    Parameter::new(
        "pivot",
        "1",
        "1 if the focus distance is wrong by the same factor, 0 if it is right",
    )
    .within(0.0, 1.0)
    .step(1.0),
];

impl Effect for DepthScale {
    fn description(&self) -> &'static Description {
        &Description {
            id: "depth_scale",
            summary: "object distances are wrong by a factor: defocus wrong in proportion to vergence",
            title: "wrong object distances",
            meaning: "The stated object distances are wrong by one factor, for example measured from another point than the entrance pupil.",
            action: "Measure the distances again, in metres from the entrance pupil. Correct depth_m in the manifest, and fit or diagnose again.",
            parameters: &PARAMETERS,
            two_stops_down: Description::SHRINKS,
            other_side_of_focus: Description::ADDS,
            second_distance: "the extra defocus grows with 1 / distance",
            // A lens that was fitted at one distance has no law by which wrong distances could act.
            one_distance_twin: Some(OneDistanceTwin {
                effect: &DefocusOffset,
                without: DefocusOffset::MAGNIFICATION,
            }),
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let factor = fitted.of("factor")?;
        let pivot = if fitted.number("pivot") > 0.5 {
            ", and so is the distance in focus"
        } else {
            ""
        };
        Some(format!(
            "true distances are {} times the stated ones{pivot}",
            factor.quantity(1.0, "")
        ))
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
        let from = |pivot| SearchStart::new(&[1.05, pivot], &[true, false]);
        vec![from(0.0), from(1.0)]
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

    /// Returns the disc of an object at vergence `v` for a lens focused at `focus`.
    fn law(v: f64, focus: f64) -> LocalPupil {
        disc(point().defocus_px_m * (v - focus))
    }

    #[test]
    fn defocus_is_that_of_the_true_distance() {
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
