//! Report of `--model moments`.

use seidel_core::fitting::MomentsFit;
use serde_json::json;

use super::{FitArgs, print_rejected, rejected_json};
use crate::Console;

/// Prints the report.
pub(super) fn report_text(fit: &MomentsFit, args: &FitArgs, console: &mut Console) {
    console.print(format!(
        "{:<8} {:>16} {:>6} {:>12} {:>12} {:>14}",
        "channel", "distance", "tiles", "2nd misfit %", "3rd misfit %", "least var px²"
    ));
    for plane in &fit.planes {
        console.print(format!(
            "{:<8} {:>16} {:>6} {:>12.2} {:>12.2} {:>14.3}{}",
            plane.channel,
            plane.distance.to_string(),
            plane.used,
            100.0 * plane.second_residual,
            100.0 * plane.third_residual,
            plane.least_variance_px2,
            if plane.converged {
                ""
            } else {
                "  (not converged)"
            }
        ));
    }
    if let Some(axis) = fit.axis {
        console.print(format!(
            "optical axis ({:.2} ± {:.2}, {:.2} ± {:.2}) px{}",
            axis.axis.x_px,
            axis.sigma_px.0,
            axis.axis.y_px,
            axis.sigma_px.1,
            if axis.converged {
                ""
            } else {
                " (not converged)"
            }
        ));
    }
    print_rejected(&fit.rejected, args, console);
    console.print(format!("wrote {}", args.output.display()));
}

/// Returns the report as JSON; `skipped` lists the observations left out on reading.
pub(super) fn report_json(fit: &MomentsFit, skipped: &[String]) -> String {
    let planes: Vec<_> = fit
        .planes
        .iter()
        .map(|p| {
            json!({
                "channel": p.channel,
                "distance": p.distance.to_string(),
                "tiles": p.used,
                "second_residual": p.second_residual,
                "third_residual": p.third_residual,
                "least_variance_px2": p.least_variance_px2,
                "rounds": p.iterations,
                "converged": p.converged,
            })
        })
        .collect();
    let axis = fit.axis.map(|a| {
        json!({
            "x_px": a.axis.x_px, "y_px": a.axis.y_px,
            "sigma_x_px": a.sigma_px.0, "sigma_y_px": a.sigma_px.1,
            "converged": a.converged,
        })
    });
    let report = json!({
        "planes": planes, "rejected": rejected_json(&fit.rejected), "axis": axis,
        "left_out": skipped, "remarks": fit.warnings,
    });
    serde_json::to_string_pretty(&report).expect("a report is plain JSON")
}
