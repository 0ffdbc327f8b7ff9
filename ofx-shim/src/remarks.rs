//! Remarks on the inputs of a render, and findings in a depth pass as remarks that speak of knobs.

use seidel_core::{DepthConvention, DepthFinding, DepthProblem, Severity};

/// A sentence for the user about the inputs of a render that is complete.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Remark {
    pub(crate) severity: Severity,
    pub(crate) text: String,
}

impl Remark {
    pub(crate) fn warning(text: String) -> Self {
        Self {
            severity: Severity::Warning,
            text,
        }
    }

    /// Returns the texts of `remarks` in one.
    pub(crate) fn join(remarks: &[Self]) -> String {
        let texts: Vec<&str> = remarks.iter().map(|remark| &*remark.text).collect();
        texts.join(" ")
    }
}

/// Returns `findings` in a depth input `width` pixels wide, read by `convention`, in words.
pub(crate) fn remarks(
    findings: &[DepthFinding],
    convention: DepthConvention,
    width: usize,
) -> Vec<Remark> {
    let remarks = findings.iter().map(|finding| {
        let remedy = remedy(finding.problem, convention, width);
        Remark {
            severity: finding.severity,
            text: format!("Depth: {}; {remedy}.", finding.problem),
        }
    });
    remarks.collect()
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
        DepthProblem::Colour => {
            "connect depth, or choose its layer (in Natron by the menu Depth Layer)".to_owned()
        }
        DepthProblem::Premultiplied { .. } => {
            "connect depth that is not premultiplied, anti-aliased or filtered".to_owned()
        }
        DepthProblem::Averaged { .. } => {
            "connect depth without filter and motion blur, or set Depth Filter; blur motion after the lens".to_owned()
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
            finding(DepthProblem::Constant { value: 2.0 }, Severity::Note),
        ];
        let metres = DepthConvention::Distance {
            metres_per_unit: 1.0,
        };
        let remarks_on = |convention, width| {
            let remarks = remarks(&findings, convention, width).into_iter();
            remarks.map(|r| (r.text, r.severity)).collect::<Vec<_>>()
        };
        let (texts, severities): (Vec<_>, Vec<_>) = remarks_on(metres, 1000).into_iter().unzip();
        assert_eq!(
            severities,
            [Severity::Warning, Severity::Warning, Severity::Note]
        );
        assert!(texts[0].ends_with("set Depth Math to far=0."), "{texts:?}");
        assert!(
            texts[1].contains("Along Ray Focal to about 500"),
            "{texts:?}"
        );
        assert!(texts.iter().all(|text| !text.contains("--")), "{texts:?}");
        let reciprocal = DepthConvention::Inverse {
            metres_per_unit: 1.0,
        };
        assert!(remarks_on(reciprocal, 9)[0].0.contains("to depth"));
    }
}
