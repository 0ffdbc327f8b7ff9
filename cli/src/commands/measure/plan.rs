//! `seidel measure plan`: what to photograph.

use clap::Args;
use seidel_measure::capture_plan::{CapturePlan, CapturedLens, PlannedDistance};
use seidel_measure::printed::{Medium, PageCoverage, Viewing};
use serde_json::{Value, json};

use super::by_option;
use super::print::{MARGIN_MM, parse_paper, parse_sensor};
use crate::Console;
use crate::commands::CommandError;
use crate::pictures::significant;

/// Options of `seidel measure plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// Focal length in millimetres
    #[arg(long = "focal-length-mm", alias = "focal-mm", value_name = "MM")]
    focal_mm: f64,
    /// f-number of the shot
    #[arg(long, value_name = "N")]
    f_number: f64,
    /// Focus distance of the shot in metres, or `inf`
    #[arg(long = "focus-distance", alias = "focus-m", value_name = "METRES")]
    focus_m: f64,
    /// Pixel pitch of the sensor in micrometres
    #[arg(long, value_name = "P")]
    pitch_um: f64,
    /// Width and height of the sensor in millimetres
    #[arg(long, value_name = "WxH", default_value = "36x24", value_parser = parse_sensor)]
    sensor_mm: [f64; 2],
    /// Nearest distance that the shot needs, in metres; by default that with as much blur as the farthest
    #[arg(long = "near", alias = "near-m", value_name = "METRES")]
    near_m: Option<f64>,
    /// Farthest distance to photograph, in metres, or `inf` for stars and lights far away
    #[arg(long = "far", alias = "far-m", value_name = "METRES", default_value_t = f64::INFINITY)]
    far_m: f64,
    /// Number of distances
    #[arg(long, value_name = "N", default_value_t = 5)]
    count: usize,
    /// Paper of the charts: A0 to A5, Letter, Legal, Tabloid, or WxH in millimetres; landscape
    #[arg(long, value_name = "A3|WxH", default_value = "A3", value_parser = parse_paper)]
    paper: [f64; 2],
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

/// Exposure of the brightest pixel of a light, and of the white of a chart, as shares of the clipping level: photon noise
/// stays below the level, and lights of unlike brightness too.
const LIGHT_EXPOSURE: [f64; 2] = [0.5, 0.8];
const CHART_EXPOSURE: [f64; 2] = [0.5, 0.7];

pub(super) fn run(args: &PlanArgs, console: &mut Console) -> Result<(), CommandError> {
    let lens = CapturedLens {
        focal_mm: args.focal_mm,
        f_number: args.f_number,
        focus_m: args.focus_m,
        pitch_um: args.pitch_um,
        sensor_mm: args.sensor_mm,
        near_m: args.near_m,
        far_m: args.far_m,
        count: args.count,
    };
    let plan = lens.plan().map_err(by_option)?;
    if args.json {
        let report = report_json(args, &plan);
        console.print(format!("{report:#}"));
        return Ok(());
    }
    console.print("distances, even in 1 / distance, since blur is linear in it:");
    console.print("  distance m   blur px   largest light   chart m          lights apart px");
    for distance in &plan.distances {
        console.print(row(distance));
    }
    console.print("a page at each distance, and the command that prints it:");
    for distance in &plan.distances {
        if let Some(coverage) = args.coverage(distance) {
            console.print(format!(
                "  {}",
                coverage.describe(&metres(distance.distance_m))
            ));
            console.print(format!("    {}", args.print_command(distance)));
        }
    }
    console.print(format!(
        "blur: diameter of the circle of confusion; diffraction adds an Airy disc of {:.1} px",
        plan.airy_px
    ));
    console.print(format!(
        "places: at least {} over the whole frame at every distance, {} or more for the accuracy of the model",
        plan.least_places, plan.good_places
    ));
    let percent = |range: [f64; 2]| {
        let [low, high] = range.map(|v| 100.0 * v);
        format!("{low:.0} to {high:.0} %")
    };
    console.print(format!(
        "exposure: lowest ISO, raw, same focus and aperture as the shot; brightest pixel of a light at {} of clipping, white of a chart at {}",
        percent(LIGHT_EXPOSURE),
        percent(CHART_EXPOSURE)
    ));
    console.print(
        "also: one dark frame (cap on) at the same exposure; tripod, self-timer, no stabiliser",
    );
    Ok(())
}

impl PlanArgs {
    /// Returns how much of the frame a page covers; `None` at infinity.
    fn coverage(&self, distance: &PlannedDistance) -> Option<PageCoverage> {
        let [width_mm, height_mm] = self.paper;
        let medium = Medium {
            width_mm,
            height_mm,
            margin_mm: MARGIN_MM,
            pixel_mm: None,
        };
        let viewing = Viewing {
            distance_m: distance.distance_m,
            focal_mm: self.focal_mm,
            pitch_um: self.pitch_um,
            blur_px: distance.blur_px,
        };
        let is_finite = distance.distance_m.is_finite();
        is_finite.then(|| PageCoverage::of(&medium, &viewing, self.sensor_mm))
    }

    /// Returns the command that prints the page for a distance.
    fn print_command(&self, distance: &PlannedDistance) -> String {
        let [width, height] = self.paper;
        let [sensor_width, sensor_height] = self.sensor_mm;
        format!(
            "seidel measure print edges -o page.pdf --paper {width}x{height} --distance {} --focal-length-mm {} --pitch-um {} --sensor-mm {sensor_width}x{sensor_height} --f-number {} --focus-distance {}",
            metres(distance.distance_m),
            self.focal_mm,
            self.pitch_um,
            self.f_number,
            metres(self.focus_m)
        )
    }
}

fn metres(value: f64) -> String {
    if value.is_finite() {
        significant(value, 4)
    } else {
        "inf".to_owned()
    }
}

fn row(d: &PlannedDistance) -> String {
    let light = match d.largest_light_mm {
        Some(mm) => format!("{} mm", significant(mm, 2)),
        None => format!("{} arcsec", significant(d.largest_light_arcsec, 2)),
    };
    let chart = match d.chart_m {
        Some([w, h]) => format!("{} x {}", significant(w, 3), significant(h, 3)),
        None => "-".to_owned(),
    };
    format!(
        "  {:>10}   {:>7.1}   {light:>13}   {chart:<14}   {:>15.0}",
        metres(d.distance_m),
        d.blur_px,
        d.light_step_px
    )
}

fn report_json(args: &PlanArgs, plan: &CapturePlan) -> Value {
    let distances: Vec<Value> = (plan.distances.iter())
        .map(|d| {
            json!({
                // As in observation sets: null is infinity.
                "distance_m": d.distance_m.is_finite().then_some(d.distance_m),
                "blur_px": d.blur_px,
                "largest_light_mm": d.largest_light_mm,
                "largest_light_arcsec": d.largest_light_arcsec,
                "chart_m": d.chart_m,
                "light_step_px": d.light_step_px,
                "page": args.coverage(d).map(|page| json!({
                    "share": page.share,
                    "positions": page.positions,
                    "centres": [page.centres(0), page.centres(1)],
                    "filling_distance_m": page.filling_distance_m,
                    "print": args.print_command(d),
                })),
            })
        })
        .collect();
    json!({
        "distances": distances,
        "airy_px": plan.airy_px,
        "least_places": plan.least_places,
        "good_places": plan.good_places,
        "light_exposure": LIGHT_EXPOSURE,
        "chart_exposure": CHART_EXPOSURE,
    })
}
