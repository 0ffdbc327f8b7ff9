//! `seidel measure chart`: PSFs of a photograph of a known chart, block by block.

use std::path::{Path, PathBuf};

use clap::Args;
use image::RgbImage;
use seidel_calibrate::fit::coverage;
use seidel_core::{AxisChoice, ImagePoint, LensProfile, ObservationSet};
use seidel_image_io::FileError;
use seidel_image_io::photograph::{self, ColourFilter, PhotographOptions};
use seidel_image_io::samples::Encoding;
use seidel_measure::chart::{ChartPicture, ChartSet, ChartSettings, Content, measure_chart};
use seidel_measure::{Calibration, Photograph, Reason};
use serde_json::{Map, Value, json};

use super::common::CommonArgs;
use super::faults::{self, ForceArgs, Insistence};
use super::fitted::PixelNoise;
use super::{fitted, left_out, output, photographs};
use crate::Console;
use crate::commands::CommandError;
use crate::pictures::measured_sheet::chart_sheet;
use crate::report::measured::{MeasuredPage, Place, measured_page};

/// Options of `seidel measure chart`.
#[derive(Debug, Args)]
pub struct ChartArgs {
    #[command(flatten)]
    pub(super) common: CommonArgs,
    /// The picture that was printed or shown, such as the PNG of `measure print noise`
    #[arg(long, value_name = "CHART.png")]
    chart: PathBuf,
    /// The chart's corners in the photograph, from the chart's own top left clockwise; found if omitted
    #[arg(long, value_name = "X,Y,X,Y,X,Y,X,Y", value_delimiter = ',', num_args = 1.., allow_negative_numbers = true)]
    at: Vec<f64>,
    /// Width and height of the tiles in pixels, odd, or `auto` for as wide as the blur needs
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = parse_tile)]
    tile: Tile,
    #[command(flatten)]
    force: ForceArgs,
}

/// Size of the tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tile {
    Auto,
    Pixels(usize),
}

/// Range of the size of tiles, px. The time of a block grows with the fourth power.
const TILE_RANGE: std::ops::RangeInclusive<usize> = 7..=63;

pub(super) fn parse_tile(text: &str) -> Result<Tile, String> {
    if text == "auto" {
        return Ok(Tile::Auto);
    }
    let side = text
        .parse()
        .ok()
        .filter(|side| TILE_RANGE.contains(side) && side % 2 == 1);
    side.map(Tile::Pixels).ok_or_else(|| {
        let (least, most) = (TILE_RANGE.start(), TILE_RANGE.end());
        format!("give an odd number of {least} to {most} pixels, or `auto`")
    })
}

impl Tile {
    pub(super) fn side(self) -> Option<usize> {
        match self {
            Self::Auto => None,
            Self::Pixels(side) => Some(side),
        }
    }
}

pub(super) fn run(args: &ChartArgs, console: &mut Console) -> Result<(), CommandError> {
    args.common.check()?;
    output::check_targets(&args.common)?;
    let settings = ChartSettings {
        tile: args.tile.side(),
        corners: args.corners()?,
        ..ChartSettings::default()
    };
    let chart = read_chart(&args.chart)?;
    let (mut photographs, calibration) =
        photographs::read_all(&args.common.photographs, &args.common.input, console)?;
    prepare(&mut photographs, &calibration)?;
    let charts = vec![vec![chart]; photographs.len()];
    let measured = measure_all(photographs, &charts, &settings, console)?;
    let insistence = Insistence::of(&args.force);
    finish(&args.common, &measured, &[], insistence, console)
}

impl ChartArgs {
    fn corners(&self) -> Result<Option<[[f64; 2]; 4]>, CommandError> {
        if self.at.is_empty() {
            return Ok(None);
        }
        let fits = self.at.len() == 8 && self.at.iter().all(|v| v.is_finite());
        if !fits || self.common.photographs.len() > 1 {
            return Err(CommandError::Usage(
                "--at takes the four corners X,Y of the chart in one photograph, eight numbers"
                    .to_owned(),
            ));
        }
        Ok(Some(std::array::from_fn(|k| {
            [self.at[2 * k], self.at[2 * k + 1]]
        })))
    }
}

/// Applies dark and flat frames, and checks that all photographs are alike.
pub(super) fn prepare(
    photographs: &mut [Photograph],
    calibration: &Calibration,
) -> Result<(), CommandError> {
    for index in 0..photographs.len() {
        seidel_measure::calibration::check_alike(&photographs[0], &photographs[index])?;
        calibration.apply(&mut photographs[index])?;
    }
    Ok(())
}

/// Reads the picture of a chart: the mean of its channels, with black at 0 and white at 1.
fn read_chart(path: &Path) -> Result<ChartPicture, CommandError> {
    let options = PhotographOptions {
        cfa: Some(ColourFilter::None),
        black: Some(0.0),
        encoding: Some(Encoding::Linear),
        ..PhotographOptions::default()
    };
    let file = photograph::read(path, &options)?;
    let channels = file.planes.len() as f32;
    let mut samples: Vec<f32> = (0..file.width * file.height)
        .map(|k| file.planes.iter().map(|p| p[k]).sum::<f32>() / channels)
        .collect();
    let low = samples.iter().copied().fold(f32::INFINITY, f32::min);
    let high = samples.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let range = (high - low).max(f32::MIN_POSITIVE);
    samples.iter_mut().for_each(|v| *v = (*v - low) / range);
    let chart = ChartPicture::new(file.width, file.height, samples, Content::Cells)
        .map_err(|error| FileError::from_core(path, error))?;
    Ok(chart)
}

/// Measures every photograph with its charts: one for all channels, or one for each.
pub(super) fn measure_all(
    photographs: Vec<Photograph>,
    charts: &[Vec<ChartPicture>],
    settings: &ChartSettings,
    console: &Console,
) -> Result<ChartSet, CommandError> {
    let bar = console.progress_bar("measuring");
    let count = photographs.len() as f64;
    let mut measurements = Vec::new();
    for (index, (photo, charts)) in photographs.iter().zip(charts).enumerate() {
        let progress = |share: f64| bar.show((index as f64 + share) / count);
        measurements.push(measure_chart(photo, charts, settings, &progress)?);
    }
    Ok(ChartSet {
        photographs,
        measurements,
    })
}

/// Fits the lens if asked to, and writes and prints the result; `remarks` are limits of the measurement. Where a fault of the photographs
/// makes the lens wrong, the set is written without one.
pub(super) fn finish(
    common: &CommonArgs,
    measured: &ChartSet,
    remarks: &[String],
    insistence: Insistence,
    console: &mut Console,
) -> Result<(), CommandError> {
    let axis = match common.axis {
        Some(AxisChoice::At(axis)) => Some(axis),
        _ => None,
    };
    let mut set = measured.observations(axis)?;
    let blocks = measured.left_out();
    let mut left_out = left_out::entries(&blocks, &measured.photographs);
    let added = match &common.also {
        Some(path) => output::append(&mut set, &mut left_out, path)?,
        None => 0,
    };
    let (about_photographs, refusal) =
        match faults::settle_concerns(&measured.concerns(), insistence) {
            Ok(remarks) => (remarks, None),
            Err(refusal) => (Vec::new(), Some(refusal)),
        };
    let fit = match (&common.fit, &refusal) {
        (Some(_), None) => Some(fitted::fit_lens(
            common,
            &mut set,
            added,
            PixelNoise::Stated,
            console,
        )?),
        _ => None,
    };
    if let Some(fit) = &fit {
        set.frame = set.frame.with_axis(fit.lens().frame.axis())?;
        set.axis_stated = true;
    }
    let places: Vec<ImagePoint> = set.observations.iter().map(|o| o.centre).collect();
    let mut remarks = remarks.to_vec();
    remarks.extend(about_photographs);
    if fit.is_none() {
        // A fit says so itself.
        remarks.extend(coverage::bare_sides(&set.frame, &places, "block"));
    }
    let remarks = remarks.as_slice();
    let lens = fit.as_ref().map(|fit| fit.lens());
    let sheet = chart_sheet(measured);
    let page = page(measured, &set, lens, &sheet, remarks);
    let written = output::Written {
        set: &set,
        left_out: &left_out,
        sheet: &sheet,
        page: &page,
        lens,
    };
    output::write(common, &written)?;
    if common.json {
        let report = report_json(measured, &set, lens, remarks);
        console.print(format!("{report:#}"));
    } else {
        print_report(common, measured, &set, console);
        if let Some(fit) = &fit {
            fitted::print_report(fit, console);
        }
    }
    for remark in remarks {
        console.note(remark);
    }
    refusal.map_or(Ok(()), Err)
}

/// Returns the mean squared residual over the variance of photon noise: the median of all blocks, by channel.
fn chi_square(measured: &ChartSet) -> Vec<f64> {
    let channels = measured.photographs[0].channels.len();
    (0..channels)
        .map(|channel| {
            let blocks = measured.measurements.iter().flat_map(|m| &m.blocks);
            let mut values: Vec<f64> = blocks.map(|b| b.chi_square[channel]).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(0.0)
        })
        .collect()
}

fn page(
    measured: &ChartSet,
    set: &ObservationSet,
    lens: Option<&LensProfile>,
    sheet: &RgbImage,
    remarks: &[String],
) -> String {
    let mut noise: Vec<String> = (measured.photographs.iter().zip(&measured.measurements))
        .map(|(photo, m)| {
            format!(
                "{}: centroids of blocks are within {:.3} px of the smooth map in the median",
                photo.name, m.registration_px
            )
        })
        .collect();
    let channels = &measured.photographs[0].channels;
    for (name, chi) in channels.iter().zip(chi_square(measured)) {
        noise.push(format!(
            "{name}: residuals have {chi:.1} times the variance of photon noise"
        ));
    }
    let kept = measured
        .measurements
        .iter()
        .enumerate()
        .flat_map(|(photograph, m)| {
            m.blocks.iter().map(move |b| Place {
                photograph,
                at: b.centre.map(|v| v as f64 + 0.5),
            })
        });
    measured_page(&MeasuredPage {
        kind: "blocks",
        photographs: &measured.photographs,
        distances: set.observations.iter().map(|o| o.distance).collect(),
        kept: kept.collect(),
        left_out: &measured.left_out(),
        sheet,
        noise,
        lens,
        warnings: remarks,
    })
}

fn reasons(measured: &ChartSet) -> Vec<(Reason, usize)> {
    let left_out = measured.left_out();
    let all = Reason::ALL.map(|why| (why, left_out.iter().filter(|l| l.why == why).count()));
    all.into_iter().filter(|(_, count)| *count > 0).collect()
}

fn report_json(
    measured: &ChartSet,
    set: &ObservationSet,
    lens: Option<&LensProfile>,
    remarks: &[String],
) -> Value {
    let by_reason: Map<String, Value> = (reasons(measured).into_iter())
        .map(|(why, count)| (why.name().to_owned(), json!(count)))
        .collect();
    let corners = |index: usize| -> Vec<Value> {
        let map = &measured.measurements[index].map;
        let [width, height] = measured.measurements[index].chart_size.map(|v| v as f64);
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        corners.iter().map(|c| json!(map.photo_of(*c))).collect()
    };
    let photographs: Vec<Value> = (measured
        .photographs
        .iter()
        .zip(&measured.measurements)
        .enumerate())
    .map(|(index, (photo, m))| {
        json!({
            "file": photo.name,
            "corners": corners(index),
            "registration_px": m.registration_px,
            "tile_px": m.side,
            "white_surround": m.has_white_surround,
            "kept": m.blocks.len(),
        })
    })
    .collect();
    json!({
        "photographs": photographs,
        "kept": measured.kept(),
        "observations": set.observations.len(),
        "left_out": by_reason,
        "residual_over_noise": set.channels.iter().zip(chi_square(measured))
            .map(|(name, chi)| (name.clone(), json!(chi))).collect::<Map<_, _>>(),
        "lens": lens.map(fitted::report_json),
        "warnings": remarks,
    })
}

fn print_report(
    common: &CommonArgs,
    measured: &ChartSet,
    set: &ObservationSet,
    console: &mut Console,
) {
    for (photo, m) in measured.photographs.iter().zip(&measured.measurements) {
        console.print(format!(
            "{}: kept {} of {} blocks, tiles of {} px, registered within {:.3} px",
            photo.name,
            m.blocks.len(),
            m.blocks.len() + m.left_out.len(),
            m.side,
            m.registration_px
        ));
    }
    for (why, count) in reasons(measured) {
        console.print(format!("left out {count}: {why}"));
    }
    console.print(format!(
        "wrote {} ({} observations)",
        common.out.display(),
        set.observations.len()
    ));
}
