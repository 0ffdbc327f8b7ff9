//! `seidel demo`: the whole loop on synthetic data. PSFs are measured, a lens is fitted and applied, a fault is planted,
//! diagnosed and corrected.

mod photographs;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use seidel_calibrate::fit::fit_pupil;
use seidel_core::fitting::{PupilModel, PupilSettings};
use seidel_core::{
    BlurField, Depth, DepthPass, Diagnosis, DiagnosisSettings, FieldPoint, Image, Lens,
    ObjectDistance, ObservationSet, Plate, Predictor, Quality, Settings, apply,
};
use seidel_image_io::atomic::{check_folder_content, write_folder_atomically};
use seidel_image_io::error::FileError;
use seidel_image_io::formats::exr::{NewChannel, write_channels_with_texts};
use seidel_image_io::formats::png::write_rgb8_with_texts;
use seidel_image_io::metadata::TextAttributes;
use seidel_image_io::observation_set;
use seidel_image_io::provenance::{Provenance, ProvenancePaths};
use seidel_image_io::windows::ImageWindows;

use super::apply::default_rendering_record;
use super::{CommandError, write_text};
use crate::demo::anamorphic::anamorphic_lens;
use crate::demo::lens::lens as built_in_lens;
use crate::demo::observations::{measured, photographed};
use crate::demo::planted::behind_a_matte_box;
use crate::demo::scene::{Scene, scene};
use crate::pictures::comparison::{Crop, View, comparison};
use crate::pictures::display::{DisplayTransform, LinearRgb};
use crate::pictures::sheet::{SheetOptions, lens_sheet};
use crate::progress::{ProgressArgs, ProgressOutput};
use crate::report::{self, Subject};
use crate::{Console, ProgressBar};

/// Options of `seidel demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Photograph point lights as raw mosaics instead, measure them and fit a lens
    #[arg(long)]
    measure: bool,
    /// Folder to write to
    #[arg(default_value = "seidel-demo")]
    folder: PathBuf,
    /// Width of the plate in pixels; its height is 9/16 of it
    #[arg(long, default_value_t = 960, value_parser = clap::value_parser!(u32).range(64..=4096))]
    width: u32,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// The outputs, with their descriptions.
const OUTPUTS: [(&str, &str); 15] = [
    (
        "measured/",
        "noisy PSFs of a lens, as if photographed: over the frame at four distances",
    ),
    ("lens.json", "the lens profile fitted to them"),
    (
        "sheet.png",
        "PSFs of that lens over the frame, by channel and distance",
    ),
    (
        "plate.exr",
        "a CG plate, scene-linear, with depth in metres (Z)",
    ),
    ("blurred.exr", "the plate through this lens"),
    ("before-after.png", "both plates side by side"),
    (
        "observed/",
        "PSFs of the same lens on the day of the shot, when a matte box clips it",
    ),
    (
        "report.json",
        "the diagnosis: how far the fitted lens is from these PSFs, and why",
    ),
    ("report.html", "the diagnosis as a page"),
    ("corrected.json", "the fitted lens with the cause added"),
    ("corrected.exr", "the plate through the corrected lens"),
    (
        "gap.png",
        "the plate through the lens of the day, as fitted and as corrected",
    ),
    ("anamorphic.json", "a 2x anamorphic lens, designed"),
    ("anamorphic.exr", "the plate through that lens, desqueezed"),
    ("lenses.png", "the plate through both lenses, side by side"),
];

/// Distances of the PSFs of the day of the shot, m.
const OBSERVED_M: [f64; 2] = [f64::INFINITY, 1.2];
/// Seed of their noise, other than that of the measured ones.
const OBSERVED_SEED: u64 = 1 << 20;

/// Everything that the demo writes, besides the plate.
struct Results {
    measured: ObservationSet,
    lens: Lens,
    blurred: [Vec<f32>; 3],
    observed: ObservationSet,
    diagnosis: Diagnosis,
    corrected: Lens,
    through_corrected: [Vec<f32>; 3],
    /// The plate through the lens of the day, which nobody has on a real shot.
    of_the_day: [Vec<f32>; 3],
    anamorphic: Lens,
    through_anamorphic: [Vec<f32>; 3],
}

pub(super) fn run(
    args: &DemoArgs,
    command_line: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    if args.measure {
        return photographs::run(args, console);
    }
    let (width, height) = (args.width, args.width * 9 / 16);
    // Before the work, which takes a while.
    check_folder_content(
        &args.folder,
        &OUTPUTS.map(|(name, _)| name.trim_end_matches('/')),
    )?;
    let mut clock = Clock::start();
    let built_in = built_in_lens(width, height)?;
    let measured = measured(&built_in)?;
    let anamorphic = Lens::new(anamorphic_lens(width, height)?)?;
    clock.lap("measured PSFs");
    let bar = console.progress_bar("fitting, and drawing the plate");
    // The fit takes longest, so it alone moves the bar.
    let hidden = ProgressOutput::hidden().start("drawing the plate");
    // Much of the fit runs on one core.
    let (fitted, drawn) = rayon::join(
        || {
            fit_pupil(
                std::slice::from_ref(&measured),
                &PupilSettings {
                    model: PupilModel::Reduced,
                    ..PupilSettings::default()
                },
                &|share| bar.show(share),
            )
        },
        || {
            let plate = scene(width as usize, height as usize);
            let oval = blur(&plate, &anamorphic, Quality::Final, &hidden)?;
            Ok::<_, CommandError>((plate, oval))
        },
    );
    let (plate, through_anamorphic) = drawn?;
    let mut profile = fitted?.lens;
    profile.provenance.sources = vec!["measured".to_owned()];
    let lens = Lens::new(profile)?;
    clock.lap("fit, plate and the anamorphic render");
    let bar = console.progress_bar("blurring the plate");
    let blurred = blur(&plate, &lens, Quality::Final, &bar)?;
    clock.lap("render");
    let changed = behind_a_matte_box(&built_in);
    let observed = photographed(&changed, &OBSERVED_M, OBSERVED_SEED)?;
    let diagnosis = diagnose(&lens, &observed, console)?;
    let corrected = Lens::new(diagnosis.corrected.clone())?;
    clock.lap("diagnosis");
    let bar = console.progress_bar("blurring the plate again");
    let through_corrected = blur(&plate, &corrected, Quality::Final, &bar)?;
    // Only for a picture of 8 bits.
    let of_the_day = blur(&plate, &Lens::new(changed)?, Quality::Draft, &bar)?;
    clock.lap("two more renders");
    let results = Results {
        measured,
        lens,
        blurred,
        observed,
        diagnosis,
        corrected,
        through_corrected,
        of_the_day,
        anamorphic,
        through_anamorphic,
    };
    results.write(&args.folder, &plate, command_line)?;
    clock.lap("files");
    for (name, description) in OUTPUTS {
        let path = args.folder.join(name);
        console.print(format!("{:<32} {description}", path.display()));
    }
    let set = &results.measured;
    console.print(format!(
        "Fitted {} PSFs in {} channels; predicted PSF sizes are within {:.2} px of the true lens.",
        set.observations.len(),
        set.channels.len(),
        worst_size_error_px(
            &Predictor::new(&built_in)?,
            results.lens.predictor(),
            &set.distances()
        )?
    ));
    console.print(results.finding());
    console.print(clock.report());
    console.print("To blur a plate of your own:");
    console.print(format!(
        "  seidel apply --lens {} plate.exr -o blurred.exr",
        args.folder.join("lens.json").display()
    ));
    Ok(())
}

/// The time of the steps of the demo.
struct Clock {
    start: Instant,
    last: Instant,
    laps: Vec<String>,
}

impl Clock {
    fn start() -> Self {
        let now = Instant::now();
        Self {
            start: now,
            last: now,
            laps: Vec::new(),
        }
    }

    /// Ends the step called `name`.
    fn lap(&mut self, name: &str) {
        let seconds = self.last.elapsed().as_secs_f64();
        self.laps.push(format!("{name} {seconds:.1} s"));
        self.last = Instant::now();
    }

    fn report(&self) -> String {
        let total = self.start.elapsed().as_secs_f64();
        format!("Took {total:.1} s: {}.", self.laps.join(", "))
    }
}

/// Finds what the fitted lens lacks against the PSFs of the day of the shot.
fn diagnose(
    lens: &Lens,
    observed: &ObservationSet,
    console: &Console,
) -> Result<Diagnosis, CommandError> {
    let settings = DiagnosisSettings {
        // Single causes are enough for one planted fault.
        pairs: false,
        ..DiagnosisSettings::default()
    };
    let bar = console.progress_bar("diagnosing");
    let found = seidel_core::diagnose(lens, observed, &settings, &|share| bar.show(share))?;
    Ok(found)
}

impl Results {
    /// Returns the finding of the diagnosis in a sentence.
    fn finding(&self) -> String {
        let gap = &self.diagnosis.gap;
        let added = if self.diagnosis.added.is_empty() {
            "no effect".to_owned()
        } else {
            self.diagnosis.added.join(" and ")
        };
        format!(
            "Planted vignetting by a matte box; the diagnosis added {added} and closed {:.1} % of a gap of {:.1} %.",
            100.0 * gap.closed,
            100.0 * gap.before
        )
    }

    /// Writes all outputs into `folder`, whole or not at all.
    fn write(
        &self,
        folder: &Path,
        plate: &Scene,
        command_line: &[OsString],
    ) -> Result<(), CommandError> {
        let subject = Subject::new(
            "lens.json".to_owned(),
            "observed".to_owned(),
            &self.observed,
        );
        let report = report::json(&self.diagnosis, &subject)?;
        let page = report::html(&self.diagnosis, &subject);
        let options = SheetOptions {
            title: Some("the demo's lens, fitted".to_owned()),
            ..SheetOptions::default()
        };
        let lens = &self.lens;
        let sheet = lens_sheet(lens.profile(), lens.predictor().default_model(), &options)?;
        let before_after = [("plate", &plate.rgb), ("through the lens", &self.blurred)];
        let lenses = [
            ("spherical", &self.blurred),
            ("2x anamorphic", &self.through_anamorphic),
        ];
        let gap = [
            ("as fitted", &self.blurred),
            ("lens of the day", &self.of_the_day),
            ("as corrected", &self.through_corrected),
        ];
        let pictures = [
            ("sheet.png", sheet),
            ("before-after.png", compare(plate, &before_after)?),
            ("lenses.png", compare(plate, &lenses)?),
            ("gap.png", compare(plate, &gap)?),
        ];
        write_folder_atomically(folder, |folder| {
            observation_set::write(&self.measured, &folder.join("measured"))?;
            observation_set::write(&self.observed, &folder.join("observed"))?;
            for (name, text) in [
                ("lens.json", &lens.to_json()),
                ("corrected.json", &self.corrected.to_json()),
                ("anamorphic.json", &self.anamorphic.to_json()),
                ("report.json", &report),
                ("report.html", &page),
            ] {
                write_text(&folder.join(name), text)?;
            }
            let made = Provenance::new(command_line).with_paths(ProvenancePaths::Names);
            for (name, rgb, lens) in [
                ("plate.exr", &plate.rgb, None),
                ("blurred.exr", &self.blurred, Some("lens.json")),
                (
                    "corrected.exr",
                    &self.through_corrected,
                    Some("corrected.json"),
                ),
                (
                    "anamorphic.exr",
                    &self.through_anamorphic,
                    Some("anamorphic.json"),
                ),
            ] {
                let texts = match lens {
                    None => made.texts(None, &[], &[]),
                    Some(lens) => {
                        let of_lens = made.clone().with_file("Lens", &folder.join(lens))?;
                        of_lens.texts(None, &default_rendering_record(), &[])
                    }
                };
                write_plate(&folder.join(name), plate, rgb, &texts)?;
            }
            for (name, picture) in &pictures {
                write_rgb8_with_texts(&folder.join(name), picture, &made.texts(None, &[], &[]))?;
            }
            Ok(())
        })?;
        Ok(())
    }
}

/// Writes `rgb` with the depth of `plate` as OpenEXR with `texts`.
fn write_plate(
    path: &Path,
    plate: &Scene,
    rgb: &[Vec<f32>; 3],
    texts: &TextAttributes,
) -> Result<(), FileError> {
    let planes = rgb.iter().chain([&plate.depth_m]);
    let channels: Vec<NewChannel> = ["R", "G", "B", "Z"]
        .into_iter()
        .zip(planes)
        .map(|(name, samples)| NewChannel {
            name,
            samples,
            half: name != "Z",
        })
        .collect();
    let windows = ImageWindows::of_size(plate.width, plate.height);
    write_channels_with_texts(path, windows, &channels, texts)
}

/// Blurs the plate's colours with the lens, guided by its depth.
fn blur(
    scene: &Scene,
    lens: &Lens,
    quality: Quality,
    bar: &ProgressBar,
) -> Result<[Vec<f32>; 3], CommandError> {
    let names = ["R", "G", "B"].map(str::to_owned).to_vec();
    let image = Image::new(scene.width, scene.height, names, scene.rgb.to_vec())?;
    let depth = Depth::Pass(DepthPass::metres(scene.depth_m.clone()));
    let mut settings = Settings::default();
    settings.quality = quality;
    let blurred = apply(
        lens,
        &Plate::new(image).with_depth(depth),
        &settings,
        &|share| bar.show(share),
    )?;
    let colours = blurred.colours.try_into();
    Ok(colours.expect("an image keeps its number of channels"))
}

/// Draws labelled renderings of `plate` side by side.
fn compare<'a>(
    plate: &Scene,
    renderings: &[(&'a str, &'a [Vec<f32>; 3])],
) -> Result<image::RgbImage, CommandError> {
    let view = |(label, [r, g, b]): &(&'a str, &'a [Vec<f32>; 3])| View {
        label,
        plate: LinearRgb {
            width: plate.width,
            height: plate.height,
            planes: [r, g, b],
        },
    };
    let views: Vec<View> = renderings.iter().map(view).collect();
    // The upper right corner, where off-axis aberrations are strongest.
    let width = plate.width as u32;
    let part = (width / 4).max(16);
    let crop = Crop {
        left: width - part,
        top: 0,
        width: part,
    };
    Ok(comparison(
        &views,
        crop,
        &DisplayTransform::default(),
        width,
    )?)
}

/// Returns the largest difference of PSF size between the `truth` and the `fitted` lens, px, over field, channels and the
/// measured distances. Size is the root of the trace of the second moments.
fn worst_size_error_px(
    truth: &Predictor,
    fitted: &Predictor,
    distances: &[ObjectDistance],
) -> Result<f64, CommandError> {
    let mut worst: f64 = 0.0;
    for channel in 0..fitted.channel_count() {
        for distance in distances {
            let vergence = fitted.vergence(*distance)?;
            for step in 0..=10 {
                let at = FieldPoint::new(0.1 * f64::from(step), 0.0);
                let size = |lens: &Predictor| {
                    let moments = lens.blur_at(channel, at, vergence).blur.moments;
                    moments.trace().max(0.0).sqrt()
                };
                worst = worst.max((size(fitted) - size(truth)).abs());
            }
        }
    }
    Ok(worst)
}
