//! Reports of `--model reduced` and `--model extended`.

use seidel_calibrate::fit::pixels::{Correlation, Metric};
use seidel_core::LensProfile;
use seidel_core::fitting::{PartTrial, PupilFit};
use seidel_core::profile::{Adequacy, HeldOut};
use serde_json::{Value, json};

use super::{FitArgs, print_rejected, rejected_json};
use crate::Console;

/// Number of correlations in the text report; the JSON report has all strong ones.
const PRINTED_CORRELATIONS: usize = 5;

/// Prints the report.
pub(super) fn report_text(fit: &PupilFit, args: &FitArgs, console: &mut Console) {
    console.print(format!(
        "{:<8} {:>16} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "channel",
        "distance",
        "tiles",
        "held out",
        "alpha",
        "beta",
        "gamma",
        "delta",
        "phi",
        "blur px"
    ));
    for c in &fit.channels {
        let numbers: Vec<String> = c.numbers.iter().map(|n| format!("{n:>8.3}")).collect();
        console.print(format!(
            "{:<8} {:>16} {:>6} {:>8} {} {:>8.3}",
            c.channel,
            c.distance.to_string(),
            c.used,
            c.held_out,
            numbers.join(" "),
            c.blur_px
        ));
    }
    if let Some(channel) = fit.lens.pupil_channels().first() {
        // Amounts are those at the nearest distance measured.
        let (_, vergence) = channel.measured_vergence;
        for fitted in &channel.effects {
            let description = fitted.effect.description();
            let (id, name, summary) = (description.id, description.title, description.summary);
            let values: Vec<f64> = fitted.values.iter().map(|v| v.at(vergence)).collect();
            let amount = fitted.effect.amount(&values);
            let amount = amount.map_or_else(String::new, |amount| format!(" ({amount})"));
            // The summary opens with a sentence that says the same as the name.
            let appearance = summary.split_once(": ").map_or(summary, |(_, rest)| rest);
            console.print(format!("with {name} ({id}): {appearance}{amount}"));
        }
    }
    if let Some(plane) = fit.lens.plane_of_focus() {
        console.print(plane.to_string());
    }
    if let Some(held_out) = &fit.lens.held_out {
        print_held_out(held_out, console);
    }
    if let Some(found) = fit.axis {
        console.print(format!(
            "optical axis ({:.2} ± {:.2}, {:.2} ± {:.2}) px",
            found.axis.x_px, found.sigma_px.0, found.axis.y_px, found.sigma_px.1
        ));
    }
    print_parts_tried(fit, console);
    for Correlation { names, value } in fit.correlations.iter().take(PRINTED_CORRELATIONS) {
        console.print(format!(
            "{} and {} are correlated ({value:.2})",
            names[0], names[1]
        ));
    }
    print_rejected(&fit.rejected, args, console);
    console.print(format!("wrote {}", args.output.display()));
}

/// Prints the parts that were tried, those that took longest first, with the largest ratio of the misfits of held-out zones before and
/// after.
fn print_parts_tried(fit: &PupilFit, console: &mut Console) {
    let seconds = |part: &PartTrial| part.seconds.unwrap_or(0.0);
    let mut parts: Vec<&PartTrial> = fit.parts_tried.iter().collect();
    if parts.is_empty() {
        return;
    }
    parts.sort_by(|a, b| seconds(b).total_cmp(&seconds(a)));
    let all: f64 = parts.iter().map(|part| seconds(part)).sum();
    console.print(format!(
        "tried {} parts in {all:.1} s\n  {:<20} {:>21} {:>6} {:>9}",
        parts.len(),
        "part",
        "misfit before / after",
        "trials",
        "time"
    ));
    for part in parts {
        let gain = (part.gain).map_or_else(|| "-".to_owned(), |g| format!("{:.2}", g.exp()));
        let is_added = is_in(&fit.lens, part.effect);
        console.print(format!(
            "  {:<20} {gain:>21} {:>6} {:>7.1} s{}",
            part.effect,
            part.trials,
            seconds(part),
            if is_added { "  added" } else { "" }
        ));
    }
}

/// Returns whether a fitted `lens` has the part `effect`.
fn is_in(lens: &LensProfile, effect: &str) -> bool {
    let first = lens.pupil_channels().first();
    first.is_some_and(|channel| channel.effects.iter().any(|e| e.effect.id() == effect))
}

fn print_held_out(held_out: &HeldOut, console: &mut Console) {
    console.print(format!(
        "held out: {} PSFs, forward-blur SNR {:.1} dB, pixel gap {:.5}, light in the wrong pixels {:.1} %",
        held_out.tiles,
        held_out.snr_db,
        held_out.pixel_gap,
        100.0 * held_out.misplaced_light.unwrap_or(0.0)
    ));
    for group in &held_out.groups {
        console.print(format!(
            "  {:<8} {:>14} {:>6} {:>6.1} dB {:>9.5} {:>5.1} %",
            group.channel,
            group.distance.to_string(),
            group.tiles,
            group.snr_db,
            group.pixel_gap,
            100.0 * group.misplaced_light.unwrap_or(0.0)
        ));
    }
    if let Some(adequacy) = &held_out.adequacy {
        console.print(adequacy.to_string());
    }
}

/// Returns the report as JSON; `skipped` lists the observations left out on reading.
pub(super) fn report_json(fit: &PupilFit, skipped: &[String]) -> String {
    let channels: Vec<Value> = fit
        .channels
        .iter()
        .map(|c| {
            let [alpha, beta, gamma, delta, phi] = c.numbers;
            json!({
                "channel": c.channel, "distance": c.distance.to_string(),
                "used": c.used, "aside": c.held_out,
                "alpha": alpha, "beta": beta, "gamma": gamma, "delta": delta, "phi": phi,
                "blur_px": c.blur_px,
            })
        })
        .collect();
    let correlations: Vec<Value> = fit
        .correlations
        .iter()
        .map(|c| json!({"names": c.names, "value": c.value}))
        .collect();
    let unclear: Vec<Value> = fit
        .poorly_determined
        .iter()
        .map(|u| json!({"names": u.names, "times": u.inflation}))
        .collect();
    let parts_tried: Vec<Value> = fit
        .parts_tried
        .iter()
        .map(|p| {
            json!({
                "effect": p.effect, "trials": p.trials, "seconds": p.seconds,
                "misfit_before_over_after": p.gain.map(f64::exp), "added": is_in(&fit.lens, p.effect),
            })
        })
        .collect();
    let axis = fit.axis.map(|estimate| {
        json!({
            "x_px": estimate.axis.x_px, "y_px": estimate.axis.y_px,
            "sigma_x_px": estimate.sigma_px.0, "sigma_y_px": estimate.sigma_px.1,
        })
    });
    let report = json!({
        "channels": channels,
        "held_out": fit.lens.held_out.as_ref().map(held_out_json),
        "metric": match fit.metric {
            Metric::Pixels => "pixels",
            Metric::NaturalSpectrum => "picture",
        },
        "converged": fit.converged,
        "parts_tried": parts_tried,
        "axis": axis,
        "correlations": correlations,
        "unclear": unclear,
        "rejected": rejected_json(&fit.rejected),
        "left_out": skipped,
        "remarks": fit.warnings,
    });
    serde_json::to_string_pretty(&report).expect("a report is plain JSON")
}

fn held_out_json(held_out: &HeldOut) -> Value {
    let groups: Vec<Value> = held_out
        .groups
        .iter()
        .map(|g| {
            json!({
                "channel": g.channel, "distance": g.distance.to_string(), "tiles": g.tiles,
                "snr_db": g.snr_db, "pixel_gap": g.pixel_gap,
                "misplaced_light": g.misplaced_light,
            })
        })
        .collect();
    json!({
        "tiles": held_out.tiles, "rule": held_out.rule, "snr_db": held_out.snr_db,
        "pixel_gap": held_out.pixel_gap, "misplaced_light": held_out.misplaced_light,
        "neighbours_snr_db": held_out.neighbours_snr_db,
        "groups": groups, "adequacy": held_out.adequacy.as_ref().map(adequacy_json),
    })
}

fn adequacy_json(adequacy: &Adequacy) -> Value {
    let Adequacy { worst, pattern, .. } = adequacy;
    json!({
        "verdict": adequacy.verdict().id(), "in_words": adequacy.to_string(),
        "noise_gap": adequacy.noise_gap, "excess_gap": adequacy.excess_gap,
        "systematic_gap": adequacy.systematic_gap,
        "worst": {
            "channel": worst.channel, "distance": worst.distance.to_string(),
            "zone": worst.zone.id(), "excess_gap": worst.excess_gap,
            "elsewhere_gap": worst.elsewhere_gap,
        },
        "pattern": {
            "periods": pattern.periods, "share": pattern.share, "field": pattern.field.id(),
        },
    })
}
