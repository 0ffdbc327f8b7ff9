//! `seidel measure edges`: the blur across straight edges, and the lens fitted to it.

use std::path::Path;

use clap::Args;
use image::RgbImage;
use seidel_calibrate::fit::edges::{
    Departures, EdgeFit, EdgeFitSettings, find_departures, fit_edges,
};
use seidel_core::profile::LensDescription;
use seidel_core::{
    AxisChoice, ImagePoint, LensProfile, Observation, ObservationSet, Predictor, Tile,
};
use seidel_image_io::atomic::write_folder_atomically;
use seidel_image_io::formats::png::write_rgb8;
use seidel_image_io::json::write_json;
use seidel_image_io::{FileError, edge_set, lens_profile, observation_set as manifest};
use seidel_measure::{EdgeSettings, MeasuredEdges, Reason, measure_edges};
use seidel_optics::edges::EdgeSet;
use seidel_optics::predict::predict_set;
use seidel_optics::psf::Pupil;
use serde_json::{Map, Value, json};

use super::common::CommonArgs;
use super::faults::{self, Fault, ForceArgs, Insistence};
use super::{camera, fitted, left_out, output, photographs};
use crate::Console;
use crate::commands::{CommandError, short_name};
use crate::pictures::edge_sheet::edge_sheet;
use crate::report::measured::{EDGES, MeasuredPage, Place, measured_page};

/// Options of `seidel measure edges`.
#[derive(Debug, Args)]
pub struct EdgesArgs {
    #[command(flatten)]
    pub(super) common: CommonArgs,
    /// Least step from dark to bright over the noise of a pixel
    #[arg(long, value_name = "N", default_value_t = EdgeSettings::default().min_contrast)]
    min_contrast: f64,
    /// Least length of an edge between its corners in pixels, less the blur
    #[arg(long, value_name = "PX", default_value_t = EdgeSettings::default().min_length_px)]
    min_length: f64,
    #[command(flatten)]
    force: ForceArgs,
}

/// Places along x and y at which the PSFs of the lens are drawn into the folder.
const PLACES: [usize; 2] = [9, 6];
/// Side of these tiles over the standard deviation of the widest blur, and its range, px.
const TILE_SIGMAS: f64 = 8.0;
const TILE_RANGE: (f64, f64) = (21.0, 255.0);

pub(super) fn run(args: &EdgesArgs, console: &mut Console) -> Result<(), CommandError> {
    let common = &args.common;
    common.check_photographs()?;
    output::check_targets(common)?;
    let (photographs, calibration) =
        photographs::read_all(&common.photographs, &common.input, console)?;
    let settings = EdgeSettings {
        min_contrast: args.min_contrast,
        min_length_px: args.min_length,
    };
    let measured = measure_edges(photographs, &calibration, &settings)?;
    let mut set = measured.set.clone();
    let mut left_out = left_out::entries(&measured.left_out, &measured.photographs);
    if let Some(path) = &common.also {
        append(&mut set, &mut left_out, path)?;
    }
    let data = common.camera(set.frame.width_px())?;
    data.fill(&mut set.camera, &mut set.pixel_pitch_um);
    let settings = EdgeFitSettings {
        axis: common.axis.unwrap_or(AxisChoice::Free),
    };
    let insistence = Insistence::of(&args.force);
    let departures = find_departures(&set, &settings)?;
    let found = departures.map(|d| faults::of_departures(&d, set.camera.squeeze));
    let about_photographs = faults::settle_concerns(&measured.concerns, insistence);
    let about_photographs = about_photographs.or_else(|error| {
        write(common, &set, &left_out, &measured, None)?;
        Err(error)
    })?;
    let remarks = faults::settle(
        &found.unwrap_or_default(),
        insistence,
        &common.photographs[0],
    );
    let remarks = remarks.or_else(|error| {
        write(common, &set, &left_out, &measured, None)?;
        Err(error)
    })?;
    let bar = console.progress_bar("fitting");
    let fitted = fit_edges(&set, &settings, &|share| bar.show(share));
    drop(bar);
    let mut fit = fitted?;
    let shared = measured.photographs.iter().map(|p| p.errors.variance_px2);
    // A blur along one direction that no lens has is an error of its own.
    let directed = departures.filter(|_| !remarks.is_empty());
    let directed = directed.map_or(0.0, |d| d.elongation_px2.value);
    add_blur_error(&mut fit.lens, shared.fold(directed, f64::max));
    fit.lens.provenance.sources = common.photographs.iter().map(|p| short_name(p)).collect();
    set.frame = fit.lens.frame;
    if let Some(distance) = fitted::only_distance(set.edges.iter().map(|e| e.distance)) {
        let remark = camera::extend_one_distance(&mut fit.lens, distance);
        fit.warnings.extend(remark);
    }
    let misfit: Vec<Fault> = faults::of_misfit(fit.chi2, fit.unexplained)
        .into_iter()
        .collect();
    let of_misfit = faults::settle(&misfit, insistence, &common.photographs[0]);
    let of_misfit = of_misfit.or_else(|error| {
        write(common, &set, &left_out, &measured, None)?;
        Err(error)
    })?;
    let about_edges = remarks.into_iter().chain(of_misfit);
    fit.warnings
        .extend(about_photographs.into_iter().chain(about_edges));
    write(common, &set, &left_out, &measured, Some(&fit))?;
    if common.json {
        let report = report_json(&measured, &set, &fit, departures);
        console.print(format!("{report:#}"));
    } else {
        print_report(args, &measured, &fit, console);
    }
    for warning in measured.warnings.iter().chain(&fit.warnings) {
        console.note(warning);
    }
    Ok(())
}

/// Adds the error that the variances of all edges share, px², to the standard error of the symmetric blur: the fit sees only how
/// they differ.
fn add_blur_error(lens: &mut LensProfile, shared_px2: f64) {
    if let LensDescription::Pupil(channels) = &mut lens.description {
        for channel in channels {
            let sigma = &mut channel.blur_variance_px2.sigma[0];
            *sigma = sigma.hypot(shared_px2);
        }
    }
}

/// Adds the edges and the left-out ones of the folder at `path`, before those of `set`.
fn append(set: &mut EdgeSet, left_out: &mut Vec<Value>, path: &Path) -> Result<(), CommandError> {
    let mut other = edge_set::read(path)?;
    let of = |s: &EdgeSet| {
        let size = (s.frame.width_px(), s.frame.height_px());
        format!("{} of {} x {}", s.channels.join(", "), size.0, size.1)
    };
    if of(&other) != of(set) {
        return Err(CommandError::File(FileError::new(
            path.join(edge_set::FILE),
            "channels, image_size",
            format!("are {}, those of the photographs {}", of(&other), of(set)),
            "append to edges of the same camera",
        )));
    }
    other.edges.append(&mut set.edges);
    set.edges = other.edges;
    let mut all = left_out::of_set(path)?;
    all.append(left_out);
    *left_out = all;
    Ok(())
}

/// Writes the folder whole or not at all, then the files beside it; without a lens where none is to be trusted.
fn write(
    args: &CommonArgs,
    set: &EdgeSet,
    left_out: &[Value],
    measured: &MeasuredEdges,
    fit: Option<&EdgeFit>,
) -> Result<(), CommandError> {
    let sheet = edge_sheet(measured);
    let page = page(measured, set, fit, &sheet);
    let predicted = fit.map(|fit| predicted(set, fit)).transpose()?;
    write_folder_atomically(&args.out, |folder| {
        if let (Some(predicted), Some(fit)) = (&predicted, fit) {
            manifest::write_into(predicted, folder)?;
            lens_profile::write(&folder.join("lens.json"), &fit.lens)?;
        }
        edge_set::write(&folder.join(edge_set::FILE), set, Some(set.frame.axis()))?;
        write_json(&folder.join(left_out::FILE), &left_out)?;
        write_rgb8(&folder.join("sheet.png"), &sheet)?;
        output::write_page(&folder.join("report.html"), &page)
    })?;
    if let (Some(path), Some(fit)) = (&args.fit, fit) {
        lens_profile::write(path, &fit.lens)?;
    }
    if let Some(path) = &args.sheet {
        write_rgb8(path, &sheet)?;
    }
    if let Some(path) = &args.report {
        output::write_page(path, &page)?;
    }
    Ok(())
}

/// Returns the report as a web page.
fn page(
    measured: &MeasuredEdges,
    set: &EdgeSet,
    fit: Option<&EdgeFit>,
    sheet: &RgbImage,
) -> String {
    let mut noise: Vec<String> = (kept(&measured.set).into_iter())
        .map(|(name, count)| format!("{count} edges in {name}"))
        .collect();
    let gain = measured.gain;
    noise.extend(gain.map(|gain| format!("{gain:.3} counts per electron")));
    noise.extend(fit.map(|fit| {
        let misfit = fit.chi2;
        format!("chi squared of the profiles {misfit:.2} per degree of freedom")
    }));
    let places = measured.photographs.iter().enumerate();
    let places = places.flat_map(|(photograph, photo)| {
        let reference = photo.reference_channel();
        let edges = measured.set.edges.iter();
        let own = edges.filter(move |e| e.source == photo.name && e.channel == reference);
        own.map(move |edge| Place {
            photograph,
            at: [edge.mid.x_px, edge.mid.y_px],
        })
    });
    measured_page(&MeasuredPage {
        kind: EDGES,
        photographs: &measured.photographs,
        distances: set.edges.iter().map(|e| e.distance).collect(),
        kept: places.collect(),
        left_out: &measured.left_out,
        sheet,
        noise,
        lens: fit.map(|fit| &fit.lens),
        warnings: &measured.warnings,
    })
}

/// Returns the PSFs of the fitted lens on a grid of places at every distance.
fn predicted(set: &EdgeSet, fit: &EdgeFit) -> Result<ObservationSet, CommandError> {
    let widest = set.edges.iter().map(|e| e.variance_px2).fold(0.0, f64::max);
    let (least, most) = TILE_RANGE;
    let side = (TILE_SIGMAS * widest.sqrt() + 9.0).clamp(least, most) as usize | 1;
    // A point in the middle, which places the prediction.
    let mut samples = vec![0.0; side * side];
    samples[side * side / 2] = 1.0;
    let point = Tile::new(side, side, samples)?;
    let frame = fit.lens.frame;
    let mut distances = Vec::new();
    for edge in &set.edges {
        if !distances.contains(&edge.distance) {
            distances.push(edge.distance);
        }
    }
    let [columns, rows] = PLACES;
    let mut observations = Vec::new();
    for distance in distances {
        for k in 0..columns * rows {
            let part = |k: usize, count: usize, size: u32| {
                // Whole pixels: the middle of a pixel.
                ((k as f64 + 0.5) / count as f64 * f64::from(size)).floor() + 0.5
            };
            let centre = ImagePoint::new(
                part(k % columns, columns, frame.width_px()),
                part(k / columns, rows, frame.height_px()),
            );
            let file = format!("psf/{:04}.tif", observations.len());
            let tiles = vec![point.clone(); set.channels.len()];
            observations.push(Observation::new(file, centre, distance, tiles));
        }
    }
    let mut template = ObservationSet::new(frame, set.channels.clone(), observations);
    template.axis_stated = true;
    (template.camera, template.pixel_pitch_um) = (set.camera.clone(), set.pixel_pitch_um);
    Ok(predict_set(&Predictor::new(&fit.lens)?, &template, &Pupil)?)
}

/// Returns the number of edges left out for every reason that occurs.
fn reasons(measured: &MeasuredEdges) -> Vec<(Reason, usize)> {
    let count = |why: Reason| measured.left_out.iter().filter(|l| l.why == why).count();
    let all = Reason::ALL.map(|why| (why, count(why)));
    all.into_iter().filter(|(_, count)| *count > 0).collect()
}

/// Returns the number of edges of every channel.
fn kept(set: &EdgeSet) -> Vec<(&str, usize)> {
    let count = |channel| set.edges.iter().filter(|e| e.channel == channel).count();
    let names = set.channels.iter().enumerate();
    names.map(|(k, name)| (name.as_str(), count(k))).collect()
}

fn report_json(
    measured: &MeasuredEdges,
    set: &EdgeSet,
    fit: &EdgeFit,
    departures: Option<Departures>,
) -> Value {
    let by_reason: Map<String, Value> = (reasons(measured).into_iter())
        .map(|(why, count)| (why.name().to_owned(), json!(count)))
        .collect();
    let kept: Map<String, Value> = (kept(set).into_iter())
        .map(|(name, count)| (name.to_owned(), json!(count)))
        .collect();
    let planes: Vec<Value> = (fit.planes.iter())
        .map(|plane| {
            json!({
                "channel": plane.channel,
                "distance": plane.distance.to_string(),
                "edges": plane.edges,
                "s": plane.s.0,
                "s_sigma": plane.s_sigma,
            })
        })
        .collect();
    let axis = fit.lens.frame.axis();
    json!({
        "photographs": measured.photographs.iter().map(|p| &p.name).collect::<Vec<_>>(),
        "kept": kept,
        "left_out": by_reason,
        "gain": measured.gain,
        "moments": planes,
        "lens": {
            "axis": [axis.x_px, axis.y_px],
            "axis_sigma": fit.axis.map(|a| [a.sigma_px.0, a.sigma_px.1]),
            "chi2": fit.chi2,
            "unexplained": fit.unexplained,
            "elongation_px2": departures.map(|d| [d.elongation_px2.value, d.elongation_px2.sigma]),
            "elongation_deg": departures.map(|d| d.direction_deg),
            "skewness": departures.map(|d| [d.skewness.value, d.skewness.sigma]),
            "converged": fit.converged,
        },
        "warnings": measured.warnings.iter().chain(&fit.warnings).collect::<Vec<_>>(),
    })
}

fn print_report(args: &EdgesArgs, measured: &MeasuredEdges, fit: &EdgeFit, console: &mut Console) {
    let kept: Vec<String> = (kept(&measured.set).into_iter())
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    console.print(format!("kept edges: {}", kept.join(", ")));
    for (why, count) in reasons(measured) {
        console.print(format!("left out {count}: {why}"));
    }
    if let Some(gain) = measured.gain {
        console.print(format!("gain {gain:.3} counts per electron"));
    }
    let axis = fit.lens.frame.axis();
    let sigma = fit.axis.map_or_else(String::new, |axis| {
        format!(" ± ({:.1}, {:.1})", axis.sigma_px.0, axis.sigma_px.1)
    });
    console.print(format!(
        "optical axis ({:.1}, {:.1}){sigma} px",
        axis.x_px, axis.y_px
    ));
    console.print(format!(
        "lens: chi squared of the profiles {:.2} per degree of freedom",
        fit.chi2
    ));
    console.print(format!("wrote {}", args.common.out.display()));
}
