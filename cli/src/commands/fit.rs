//! `seidel fit`: from observation sets to a lens profile.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use seidel_core::fit::{AxisChoice, Fit, FitSettings, Weighting, fit_moments};
use seidel_core::moments::support::Support;
use seidel_core::observations::ObservationSet;
use serde_json::json;

use super::choice::ChoiceArgs;
use super::{CommandError, parse_point, short_name};
use crate::Console;
use crate::files::atomic::write_whole;
use crate::files::manifest::{self, ReadOptions};

/// Options of `seidel fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Observation sets of one camera: folders with a manifest.json; several give several object
    /// distances, or more points
    #[arg(required = true, value_name = "OBS")]
    observations: Vec<PathBuf>,
    /// Where to write the lens profile
    #[arg(short, long, value_name = "LENS")]
    output: PathBuf,
    /// What to describe the lens by
    #[arg(long, value_enum, default_value_t = Model::Moments)]
    model: Model,
    /// Where the optical axis is: `free` to find it, or X,Y in frame pixels; as the set says if left out
    #[arg(long, value_name = "free|X,Y", value_parser = parse_axis)]
    axis: Option<AxisChoice>,
    /// Let every moment count alike and reject nothing, as in the paper
    #[arg(long)]
    unweighted: bool,
    /// Let all pixels of a tile take part, even those that hold noise alone
    #[arg(long)]
    all_pixels: bool,
    #[command(flatten)]
    choice: ChoiceArgs,
    /// Leave bad observations out, and say which, instead of stopping
    #[arg(long)]
    skip_bad: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// What a lens can be described by.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Model {
    /// S1..S10 per channel and object distance: the paper's model
    Moments,
}

fn parse_axis(text: &str) -> Result<AxisChoice, String> {
    if text == "free" {
        return Ok(AxisChoice::Free);
    }
    parse_point(text)
        .map(AxisChoice::At)
        .map_err(|problem| format!("{problem}, or `free`"))
}

pub(super) fn run(args: &FitArgs, console: &mut Console) -> Result<(), CommandError> {
    let Model::Moments = args.model;
    let options = ReadOptions {
        skip_bad: args.skip_bad,
    };
    let mut sets: Vec<ObservationSet> = Vec::new();
    let mut skipped = Vec::new();
    for path in &args.observations {
        let read = manifest::read(path, options)?;
        for fault in read.dropped.iter().flat_map(|d| &d.faults) {
            skipped.push(format!("{}: {fault}", path.display()));
        }
        sets.push(read.set);
    }
    for line in &skipped {
        console.remark(format!("left out {line}"));
    }
    args.choice.restrict(&mut sets)?;
    let settings = FitSettings {
        weighting: if args.unweighted {
            Weighting::Unweighted
        } else {
            Weighting::Weighted
        },
        axis: args.axis.unwrap_or_default(),
        support: if args.all_pixels {
            Support::AllPixels
        } else {
            Support::Auto
        },
    };
    let mut fit = fit_moments(&sets, &settings)?;
    fit.lens.provenance.sources = args.observations.iter().map(|p| short_name(p)).collect();
    fit.lens.provenance.settings += &args.choice.describe();
    let text = fit.lens.to_json();
    write_whole(&args.output, |out| {
        std::io::Write::write_all(out, text.as_bytes())
    })?;
    if args.json {
        console.say(report_json(&fit, &skipped));
    } else {
        report_text(&fit, args, console);
    }
    for remark in &fit.remarks {
        console.remark(remark);
    }
    Ok(())
}

fn report_text(fit: &Fit, args: &FitArgs, console: &mut Console) {
    console.say(format!(
        "{:<8} {:>16} {:>6} {:>12} {:>12} {:>14}",
        "channel", "distance", "tiles", "2nd misfit %", "3rd misfit %", "least var px²"
    ));
    for plane in &fit.planes {
        console.say(format!(
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
        console.say(format!(
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
    for r in &fit.rejected {
        console.say(format!(
            "rejected {} observation {} ({}) channel {}: {}",
            args.observations[r.set].display(),
            r.observation,
            r.file,
            r.channel,
            r.reason
        ));
    }
    console.say(format!("wrote {}", args.output.display()));
}

fn report_json(fit: &Fit, skipped: &[String]) -> String {
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
                "rounds": p.rounds,
                "converged": p.converged,
            })
        })
        .collect();
    let rejected: Vec<_> = fit
        .rejected
        .iter()
        .map(|r| {
            json!({
                "set": r.set, "observation": r.observation, "file": r.file,
                "channel": r.channel, "reason": r.reason,
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
        "planes": planes, "rejected": rejected, "axis": axis,
        "left_out": skipped, "remarks": fit.remarks,
    });
    serde_json::to_string_pretty(&report).expect("a report is plain JSON")
}
