//! `seidel measure match`: the lens of a plate of any content, from its own edges and lights.

use std::path::PathBuf;

use clap::Args;
use image::RgbImage;
use seidel_calibrate::fit::plate_match::{
    Estimate, MatchSettings, MatchedChannel, PlateLight, PlateMatch, match_plate,
};
use seidel_core::{AxisChoice, Error, ErrorKind, ImagePoint};
use seidel_image_io::atomic::check_target;
use seidel_image_io::formats::png::write_rgb8;
use seidel_image_io::{FileError, lens_profile};
use seidel_measure::{
    Calibration, EdgeSettings, LightSettings, MeasuredEdges, Photograph, measure_edges,
    measure_lights,
};
use serde_json::{Value, json};

use super::common::InputArgs;
use super::faults::{self, Fault, ForceArgs, Insistence};
use super::{camera, output, photographs};
use crate::Console;
use crate::commands::fit::parse_axis;
use crate::commands::{CommandError, short_name};
use crate::pictures::edge_sheet::edge_sheet;
use crate::report::measured::{EDGES, MeasuredPage, Place, measured_page};

/// Options of `seidel measure match`.
#[derive(Debug, Args)]
pub struct MatchArgs {
    /// Plate with straight edges all over the frame: raw, or scene-linear without sharpening
    #[arg(value_name = "PLATE")]
    plate: PathBuf,
    /// Lens profile to write
    #[arg(short, long, value_name = "LENS")]
    output: PathBuf,
    #[command(flatten)]
    pub(super) input: InputArgs,
    /// Position of the optical axis: X,Y in frame pixels, or `free` to estimate it (the default)
    #[arg(long, value_name = "free|X,Y", value_parser = parse_axis)]
    axis: Option<AxisChoice>,
    /// Least step from dark to bright over the noise of a pixel
    #[arg(long, value_name = "N", default_value_t = EdgeSettings::default().min_contrast)]
    min_contrast: f64,
    /// Least length of an edge between its corners in pixels, less the blur
    #[arg(long, value_name = "PX", default_value_t = EdgeSettings::default().min_length_px)]
    min_length: f64,
    /// Draw the edges over the plate into this file
    #[arg(long, value_name = "FILE.png")]
    sheet: Option<PathBuf>,
    /// Write the report as a web page to this file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Seed of the resampling that gives the intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    force: ForceArgs,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Variance of the pixel's area, px².
const PIXEL_VARIANCE_PX2: f64 = 1.0 / 12.0;
/// Error of the variance of a light by its fitted shape, over the variance: as that of edges.
const LIGHT_ERROR: f64 = 0.05;

pub(super) fn run(args: &MatchArgs, console: &mut Console) -> Result<(), CommandError> {
    if args.input.distances.len() > 1 {
        return Err(CommandError::Usage(
            "--distance: give one distance, that of the plate's subject".to_owned(),
        ));
    }
    check_target(&args.output)?;
    for target in [&args.sheet, &args.report].into_iter().flatten() {
        check_target(target)?;
    }
    let plates = std::slice::from_ref(&args.plate);
    let (photographs, calibration) = photographs::read_all(plates, &args.input, console)?;
    let lights = lights(photographs.clone(), &calibration)?;
    let settings = EdgeSettings {
        min_contrast: args.min_contrast,
        min_length_px: args.min_length,
    };
    let mut measured = measure_edges(photographs, &calibration, &settings)
        .map_err(|error| FileError::from_core(&args.plate, of_plate(error)))?;
    let set = &mut measured.set;
    let data = args
        .input
        .camera
        .of(plates, set.frame.width_px() as usize)?;
    data.fill(&mut set.camera, &mut set.pixel_pitch_um);
    let settings = MatchSettings {
        axis: args.axis.unwrap_or(AxisChoice::Free),
        reference: measured.photographs[0].reference_channel(),
        shared_error_px2: measured.photographs[0].errors.variance_px2,
        seed: args.seed,
    };
    let bar = console.progress_bar("matching");
    let matched = match_plate(&measured.set, &lights, &settings, &|share| bar.show(share));
    drop(bar);
    let mut matched = matched.map_err(|error| FileError::from_core(&args.plate, error))?;
    matched.lens.provenance.sources = vec![short_name(&args.plate)];
    let remark = camera::extend_one_distance(&mut matched.lens, args.input.distance(0));
    matched.warnings.extend(remark);
    let mut found: Vec<Fault> = Vec::new();
    found.extend(faults::of_misfit(matched.chi2, matched.unexplained));
    if let Some(departures) = &matched.departures {
        found.extend(faults::of_departures(
            departures,
            matched.lens.camera.squeeze,
        ));
    }
    let insistence = Insistence::of(&args.force);
    let about_plate = faults::settle_concerns(&measured.concerns, insistence)?;
    let remarks = faults::settle(&found, insistence, &args.plate)?;
    matched
        .warnings
        .extend(about_plate.into_iter().chain(remarks));
    args.write(&measured, &matched)?;
    if args.json {
        console.print(format!("{:#}", report_json(&matched, lights.len())));
    } else {
        args.print_report(&matched, console);
    }
    for warning in measured.warnings.iter().chain(&matched.warnings) {
        console.note(warning);
    }
    Ok(())
}

/// Replaces the advice about charts where a plate has too few edges.
fn of_plate(mut error: Error) -> Error {
    if error.kind() == ErrorKind::InsufficientData && error.place == "edges" {
        error.remedy = "choose a frame with straight edges that stand free, in focus and well lit, such as buildings or printed matter; or photograph a chart".to_owned();
    }
    error
}

/// Returns the lights of the plate; none where none can be measured.
fn lights(
    photographs: Vec<Photograph>,
    calibration: &Calibration,
) -> Result<Vec<PlateLight>, Error> {
    let found = match measure_lights(photographs, calibration, &LightSettings::default()) {
        Ok(found) => found,
        Err(error) if error.kind() == ErrorKind::InsufficientData => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let each = found.lights.iter().map(|light| {
        let variances = light.profiles.iter().map(|profile| {
            let profile = profile.as_ref()?;
            let [xx, _, yy] = profile.covariance;
            let [sigma_xx, _, sigma_yy, ..] = profile.shape_sigma;
            let value = (xx + yy) / 2.0;
            let sigma = (sigma_xx.hypot(sigma_yy) / 2.0).hypot(LIGHT_ERROR * value);
            Some([value - PIXEL_VARIANCE_PX2, sigma])
        });
        let [x, y] = light.place();
        PlateLight {
            at: ImagePoint::new(x, y),
            variances: variances.collect(),
        }
    });
    Ok(each.collect())
}

impl MatchArgs {
    fn write(&self, measured: &MeasuredEdges, matched: &PlateMatch) -> Result<(), CommandError> {
        let sheet = edge_sheet(measured);
        if let Some(path) = &self.sheet {
            write_rgb8(path, &sheet)?;
        }
        if let Some(path) = &self.report {
            output::write_page(path, &page(measured, matched, &sheet))?;
        }
        lens_profile::write(&self.output, &matched.lens)?;
        Ok(())
    }

    fn print_report(&self, matched: &PlateMatch, console: &mut Console) {
        console.print(format!(
            "{} edges and lights, {:.0} sharp; the scene blurs the others by {:.2} px² on average",
            matched.samples, matched.sharp, matched.scene_px2
        ));
        let axis = matched.lens.frame.axis();
        console.print(format!(
            "optical axis ({:.1}, {:.1}) px",
            axis.x_px, axis.y_px
        ));
        for line in figures(matched) {
            console.print(line);
        }
        console.print(format!("wrote {}", self.output.display()));
    }
}

/// Returns what is known of every channel, the surest first, a line each. Intervals are of 95 %.
fn figures(matched: &PlateMatch) -> Vec<String> {
    let list = |of: &dyn Fn(&MatchedChannel) -> Option<String>| {
        let each: Vec<String> = matched.channels.iter().filter_map(of).collect();
        each.join(", ")
    };
    let shown = |name: &str, e: Estimate| format!("{name} {:+.2} ± {:.2}", e.value, e.half_width);
    let mut lines = Vec::new();
    let differences = list(&|c| {
        let difference = c.difference_px2;
        (difference.half_width > 0.0).then(|| shown(&c.name, difference))
    });
    if !differences.is_empty() {
        lines.push(format!(
            "variance less that of the reference channel: {differences} px²"
        ));
    }
    let field = list(&|c| Some(shown(&c.name, c.field_px2)));
    lines.push(format!(
        "variance in the corner less that on the axis: {field} px²"
    ));
    let size = list(&|c| {
        let Estimate { value, half_width } = c.variance_px2;
        Some(format!("{} {value:.2} ± {half_width:.2}", c.name))
    });
    lines.push(format!("variance: {size} px²"));
    let relative = list(&|c| Some(format!("{} {:.0} %", c.name, 100.0 * c.relative)));
    lines.push(format!("second moments known within: {relative}"));
    lines
}

fn report_json(matched: &PlateMatch, lights: usize) -> Value {
    let pair = |e: Estimate| json!([e.value, e.half_width]);
    let channels: Vec<Value> = (matched.channels.iter())
        .map(|c| {
            json!({
                "channel": c.name,
                "samples": c.samples,
                "difference_px2": pair(c.difference_px2),
                "corner_less_axis_px2": pair(c.field_px2),
                "variance_px2": pair(c.variance_px2),
                "relative": c.relative,
            })
        })
        .collect();
    let axis = matched.lens.frame.axis();
    json!({
        "samples": matched.samples,
        "lights": lights,
        "sharp": matched.sharp,
        "scene_px2": matched.scene_px2,
        "noise_scale": matched.noise_scale,
        "axis": [axis.x_px, axis.y_px],
        "channels": channels,
        "warnings": matched.warnings,
    })
}

/// Returns the report as a web page.
fn page(measured: &MeasuredEdges, matched: &PlateMatch, sheet: &RgbImage) -> String {
    let reference = measured.photographs[0].reference_channel();
    let edges = measured.set.edges.iter().filter(|e| e.channel == reference);
    let places = edges.map(|edge| Place {
        photograph: 0,
        at: [edge.mid.x_px, edge.mid.y_px],
    });
    measured_page(&MeasuredPage {
        kind: EDGES,
        photographs: &measured.photographs,
        distances: vec![measured.photographs[0].distance],
        kept: places.collect(),
        left_out: &measured.left_out,
        sheet,
        noise: figures(matched),
        lens: Some(&matched.lens),
        warnings: &matched.warnings,
    })
}
