//! `seidel demo`: fits a lens and blurs a plate, on synthetic data.

use std::path::PathBuf;

use clap::Args;
use seidel_core::calibrate::fit::{PupilSettings, fit_pupil};
use seidel_core::field::FieldPoint;
use seidel_core::optics::BlurField;
use seidel_core::predict::Predictor;
use seidel_core::{Depth, DepthPass, Image, Lens, ObservationSet, Plate, Settings, apply};
use seidel_image_io::atomic::write_folder_atomically;
use seidel_image_io::exr::{NewChannel, write_channels};
use seidel_image_io::observation_set;
use seidel_image_io::png::write_rgb8;
use seidel_image_io::windows::ImageWindows;

use super::{CommandError, write_text};
use crate::Console;
use crate::demo::anamorphic::anamorphic_lens;
use crate::demo::lens::lens as built_in_lens;
use crate::demo::observations::measured;
use crate::demo::scene::{Scene, scene};
use crate::pictures::comparison::{Crop, View, comparison};
use crate::pictures::display::{DisplayTransform, LinearRgb};
use crate::pictures::sheet::{SheetOptions, lens_sheet};

/// Options of `seidel demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder to write to
    #[arg(default_value = "seidel-demo")]
    folder: PathBuf,
    /// Width of the plate in pixels; its height is 9/16 of it
    #[arg(long, default_value_t = 960, value_parser = clap::value_parser!(u32).range(64..=4096))]
    width: u32,
}

/// The outputs, with their descriptions.
const OUTPUTS: [(&str, &str); 9] = [
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
    ("anamorphic.json", "a 2x anamorphic lens, designed"),
    ("anamorphic.exr", "the plate through that lens, desqueezed"),
    ("lenses.png", "the plate through both lenses, side by side"),
];

pub(super) fn run(args: &DemoArgs, console: &mut Console) -> Result<(), CommandError> {
    let (width, height) = (args.width, args.width * 9 / 16);
    let built_in = built_in_lens(width, height)?;
    let set = measured(&built_in)?;
    let mut profile = fit_pupil(std::slice::from_ref(&set), &PupilSettings::default())?.lens;
    profile.provenance.sources = vec!["measured".to_owned()];
    let lens = Lens::new(profile)?;
    let plate = scene(width as usize, height as usize);
    let blurred = blur(&plate, &lens, console)?;
    let options = SheetOptions {
        title: Some("the demo's lens, fitted".to_owned()),
        ..SheetOptions::default()
    };
    let sheet = lens_sheet(lens.profile(), lens.predictor().default_model(), &options)?;
    let before_after = compare(
        &plate,
        [("plate", &plate.rgb), ("through the lens", &blurred)],
    )?;
    let anamorphic = Lens::new(anamorphic_lens(width, height)?)?;
    let oval = blur(&plate, &anamorphic, console)?;
    let views = [("spherical", &blurred), ("2x anamorphic", &oval)];
    let lenses = compare(&plate, views)?;
    write_folder_atomically(&args.folder, |folder| {
        observation_set::write(&set, &folder.join("measured"))?;
        write_text(&folder.join("lens.json"), &lens.to_json())?;
        write_rgb8(&folder.join("sheet.png"), &sheet)?;
        write_text(&folder.join("anamorphic.json"), &anamorphic.to_json())?;
        for (name, rgb) in [
            ("plate.exr", &plate.rgb),
            ("blurred.exr", &blurred),
            ("anamorphic.exr", &oval),
        ] {
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
            write_channels(&folder.join(name), windows, &channels)?;
        }
        write_rgb8(&folder.join("before-after.png"), &before_after)?;
        write_rgb8(&folder.join("lenses.png"), &lenses)
    })?;
    for (name, description) in OUTPUTS {
        let path = args.folder.join(name);
        console.print(format!("{:<32} {description}", path.display()));
    }
    console.print(format!(
        "Fitted {} PSFs in {} channels; predicted PSF sizes are within {:.2} px of the true lens.",
        set.observations.len(),
        set.channels.len(),
        worst_size_error_px(&Predictor::new(&built_in)?, lens.predictor(), &set)?
    ));
    console.print("To blur a plate of your own:");
    console.print(format!(
        "  seidel apply --lens {} plate.exr -o blurred.exr",
        args.folder.join("lens.json").display()
    ));
    Ok(())
}

/// Blurs the plate's colours with the lens, guided by its depth.
fn blur(scene: &Scene, lens: &Lens, console: &Console) -> Result<[Vec<f32>; 3], CommandError> {
    let names = ["R", "G", "B"].map(str::to_owned).to_vec();
    let image = Image::new(scene.width, scene.height, names, scene.rgb.to_vec())?;
    let depth = Depth::Pass(DepthPass::metres(scene.depth_m.clone()));
    let bar = console.progress_bar("blurring the plate");
    let blurred = apply(
        lens,
        &Plate::new(image).with_depth(depth),
        &Settings::default(),
        &|share| bar.show(share),
    )?;
    let colours = blurred.colours.try_into();
    Ok(colours.expect("an image keeps its number of channels"))
}

/// Draws labelled renderings of `plate` side by side.
fn compare<'a>(
    plate: &Scene,
    renderings: [(&'a str, &'a [Vec<f32>; 3]); 2],
) -> Result<image::RgbImage, CommandError> {
    let view = |(label, [r, g, b]): (&'a str, &'a [Vec<f32>; 3])| View {
        label,
        plate: LinearRgb {
            width: plate.width,
            height: plate.height,
            planes: [r, g, b],
        },
    };
    let views = renderings.map(view);
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
    measured: &ObservationSet,
) -> Result<f64, CommandError> {
    let mut worst: f64 = 0.0;
    for channel in 0..fitted.channel_count() {
        for distance in measured.distances() {
            let vergence = fitted.vergence(distance)?;
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
