//! Findings in a depth pass as messages that speak of knobs.

use seidel_core::{DepthConvention, DepthFinding, DepthProblem, Severity};

/// Returns the warnings among `findings` in a depth input `width` pixels wide, read by `convention`.
pub(crate) fn warnings(
    findings: &[DepthFinding],
    convention: DepthConvention,
    width: usize,
) -> Vec<String> {
    let doubts = findings.iter().filter(|f| f.severity == Severity::Warning);
    let sentences = doubts.map(|finding| {
        let remedy = remedy(finding.problem, convention, width);
        format!("Depth: {}; {remedy}.", finding.problem)
    });
    sentences.collect()
}

/// Returns the knobs that correct `problem`.
fn remedy(problem: DepthProblem, convention: DepthConvention, width: usize) -> String {
    match problem {
        DepthProblem::AlongRay { half_field_deg, .. } => {
            let focal_px = width as f64 / 2.0 / half_field_deg.to_radians().tan();
            format!("set Along Ray Focal to about {focal_px:.0}, or render depth along the axis")
        }
        DepthProblem::Inverted { .. } => match convention {
            DepthConvention::Distance { .. } => "set Depth Math to far=0".to_owned(),
            DepthConvention::Inverse { .. } => "set Depth Math to depth".to_owned(),
            DepthConvention::FarOne { .. } | DepthConvention::FarZero { .. } => {
                "set Depth Math to far=1 or far=0".to_owned()
            }
        },
        DepthProblem::ImplausibleRange { .. } | DepthProblem::OffTheLens { .. } => {
            "set World Scale to the unit of the pass".to_owned()
        }
        DepthProblem::Normalised { .. } => {
            "set Depth Math to far=1, or to linear with Near and Far".to_owned()
        }
        DepthProblem::Premultiplied { .. } => {
            "connect depth that is not premultiplied, anti-aliased or filtered".to_owned()
        }
        DepthProblem::Misplaced { .. } => {
            "connect the depth of this picture: of the same eye, frame and camera, the same way up"
                .to_owned()
        }
        DepthProblem::Quantised { .. } => "connect depth in half or full floats".to_owned(),
        DepthProblem::Constant { .. } => {
            "if that is meant, switch Use Depth off and set Distance".to_owned()
        }
        DepthProblem::Empty { .. } => "choose another Depth Channel".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remedies_name_knobs() {
        let finding = |problem, severity| DepthFinding {
            problem,
            severity,
            remedy: "give --an-option".to_owned(),
        };
        let inverted = DepthProblem::Inverted {
            patches: 30,
            against: 1,
            along_ray: false,
        };
        let ray = DepthProblem::AlongRay {
            patches: 30,
            against: 1,
            half_field_deg: 45.0,
            corner_error: 0.3,
        };
        let findings = [
            finding(inverted, Severity::Warning),
            finding(ray, Severity::Warning),
            finding(DepthProblem::Quantised { levels: 200 }, Severity::Note),
        ];
        let metres = DepthConvention::Distance {
            metres_per_unit: 1.0,
        };
        let texts = warnings(&findings, metres, 1000);
        assert_eq!(texts.len(), 2);
        assert!(texts[0].ends_with("set Depth Math to far=0."), "{texts:?}");
        assert!(
            texts[1].contains("Along Ray Focal to about 500"),
            "{texts:?}"
        );
        assert!(texts.iter().all(|text| !text.contains("--")), "{texts:?}");
        let reciprocal = DepthConvention::Inverse {
            metres_per_unit: 1.0,
        };
        assert!(warnings(&findings[..1], reciprocal, 9)[0].contains("to depth"));
    }
}
