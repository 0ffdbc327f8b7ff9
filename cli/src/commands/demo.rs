//! `seidel demo`: the main job from end to end on data the program carries itself.

use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::eval::{EvalSettings, evaluate};
use seidel_core::fit::{PupilSettings, fit_pupil};
use seidel_core::observations::ObservationSet;
use seidel_core::predict::Predictor;
use seidel_core::profile::LensProfile;
use seidel_core::render::{
    BlurField, Displacement, Edges, Gather, LayeredRenderer, Occlusion, Plane, PlateMap, Quality,
    Renderer, Scene as Optics, VergencePass,
};
use seidel_core::score::TestImage;

use super::CommandError;
use crate::demo::scene::{Scene, scene};
use crate::demo::{lens, observations};
use crate::pictures::comparison::{Crop, View, comparison};
use crate::pictures::display::{DisplayTransform, LinearRgb};
use crate::pictures::sheet::{SheetOptions, lens_sheet};
use crate::{Console, Progress};
use seidel_image_io::atomic::{write_folder_whole, write_whole};
use seidel_image_io::exr::new::{NewChannel, write_new};
use seidel_image_io::observation_set as manifest;
use seidel_image_io::picture::write_png;

/// Options of `seidel demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder to write to
    #[arg(default_value = "seidel-demo")]
    folder: PathBuf,
    /// Width of the plate in pixels; the height follows
    #[arg(long, default_value_t = 960, value_parser = clap::value_parser!(u32).range(64..=4096))]
    width: u32,
}

/// What the demo writes, and what to say of it.
const WRITES: [(&str, &str); 6] = [
    (
        "measured/",
        "PSFs of a lens, as if photographed: noisy points of light over the frame at four distances",
    ),
    ("lens.json", "the lens profile fitted to them"),
    (
        "sheet.png",
        "a picture of that lens: its PSFs over the frame by channel and distance",
    ),
    (
        "plate.exr",
        "a CG plate, scene-linear, with depth in metres (Z)",
    ),
    ("blurred.exr", "the plate as this lens would have seen it"),
    ("before-after.png", "both, for the eye"),
];

pub(super) fn run(args: &DemoArgs, console: &mut Console) -> Result<(), CommandError> {
    let (width, height) = (args.width, args.width * 9 / 16);
    let built_in = lens::lens(width, height)?;
    let set = observations::measured(&built_in)?;
    let mut fit = fit_pupil(std::slice::from_ref(&set), &PupilSettings::default())?;
    fit.lens.provenance.sources = vec!["measured".to_owned()];
    let quality = evaluate(
        &fit.lens,
        &set,
        &TestImage::natural(),
        &EvalSettings::default(),
    )?;
    let plate = scene(width as usize, height as usize);
    let progress = console.progress("blurring the plate");
    let blurred = blur(&plate, &fit.lens, &progress)?;
    drop(progress);
    let best = Predictor::new(&fit.lens)?.default_model();
    let sheet = lens_sheet(
        &fit.lens,
        best,
        &SheetOptions {
            title: Some("the demo's lens, fitted".to_owned()),
            ..SheetOptions::default()
        },
    )?;
    let before_after = compare(&plate, &blurred)?;
    write_folder_whole(&args.folder, |folder| {
        manifest::write(&set, &folder.join("measured"))?;
        write_whole(&folder.join("lens.json"), |out| {
            std::io::Write::write_all(out, fit.lens.to_json().as_bytes())
        })?;
        write_png(&folder.join("sheet.png"), &sheet)?;
        write_plate(&folder.join("plate.exr"), &plate, &plate.rgb)?;
        write_plate(&folder.join("blurred.exr"), &plate, &blurred)?;
        write_png(&folder.join("before-after.png"), &before_after)
    })?;
    for (name, what) in WRITES {
        console.say(format!("{:<32} {what}", show(&args.folder.join(name))));
    }
    let scored = format!("{}-model", best.id());
    let score = quality
        .groups
        .iter()
        .filter_map(|g| g.methods.iter().find(|m| m.id == scored))
        .map(|m| m.mean_db)
        .fold((0.0, 0.0), |(sum, count), db| (sum + db, count + 1.0));
    console.say(format!(
        "The fit took {} PSFs in {} channels. Its PSF sizes are within {:.2} px of the lens that made \
         them; pictures blurred by its PSFs match to {:.0} dB.",
        set.observations.len(),
        set.channels.len(),
        worst_size_error_px(&built_in, &fit.lens, &set)?,
        score.0 / f64::max(score.1, 1.0)
    ));
    console.say("To blur a plate of your own:");
    console.say(format!(
        "  seidel apply --lens {} plate.exr -o blurred.exr",
        show(&args.folder.join("lens.json"))
    ));
    Ok(())
}

fn show(path: &Path) -> String {
    path.display().to_string()
}

/// The plate's colours through the lens.
fn blur(
    plate: &Scene,
    lens: &LensProfile,
    progress: &Progress,
) -> Result<[Vec<f32>; 3], CommandError> {
    let predictor = Predictor::new(lens)?;
    let vergence: Vec<f32> = plate.depth_m.iter().map(|m| 1.0 / m).collect();
    let optics = Optics {
        lens: &predictor,
        model: predictor.default_model(),
        width: plate.width,
        height: plate.height,
        map: PlateMap {
            origin: seidel_core::field::ImagePoint::new(0.0, 0.0),
            scale: plate.width as f64 / f64::from(predictor.frame().width_px()),
        },
        vergence: VergencePass::PerPixel(&vergence),
        edges: Edges::Mirror,
        displacement: Displacement::Lateral,
    };
    const OWN_CHANNEL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let planes: Vec<Plane> = plate
        .rgb
        .iter()
        .zip(&OWN_CHANNEL)
        .map(|(samples, weights)| Plane { samples, weights })
        .collect();
    let inner = Gather {
        quality: Quality::Final,
    };
    let renderer = LayeredRenderer {
        inner: &inner,
        settings: Occlusion::default(),
    };
    let rendered = renderer.render(&optics, &planes, &|share| {
        progress.set(share);
        true
    })?;
    Ok(rendered
        .planes
        .try_into()
        .expect("one plane for each given"))
}

fn write_plate(path: &Path, plate: &Scene, rgb: &[Vec<f32>; 3]) -> seidel_image_io::Result<()> {
    let mut channels: Vec<NewChannel> = ["R", "G", "B"]
        .into_iter()
        .zip(rgb)
        .map(|(name, samples)| NewChannel {
            name,
            samples,
            half: true,
        })
        .collect();
    channels.push(NewChannel {
        name: "Z",
        samples: &plate.depth_m,
        half: false,
    });
    write_new(path, plate.width, plate.height, &channels)
}

fn compare<'a>(
    plate: &'a Scene,
    blurred: &'a [Vec<f32>; 3],
) -> Result<image::RgbImage, CommandError> {
    let view = |label, [r, g, b]: &'a [Vec<f32>; 3]| View {
        label,
        plate: LinearRgb {
            width: plate.width,
            height: plate.height,
            planes: [r, g, b],
        },
    };
    let views = [view("plate", &plate.rgb), view("through the lens", blurred)];
    // The upper right corner, where the lens shows most.
    let part = (plate.width as u32 / 4).max(16);
    let crop = Crop {
        left: plate.width as u32 - part,
        top: 0,
        width: part,
    };
    Ok(comparison(
        &views,
        crop,
        &DisplayTransform::default(),
        plate.width as u32,
    )?)
}

/// Largest difference of PSF size (root of the trace, px) between the fitted and the built-in lens, over
/// field, channels and the distances measured.
fn worst_size_error_px(
    built_in: &LensProfile,
    fitted: &LensProfile,
    measured: &ObservationSet,
) -> Result<f64, CommandError> {
    let (truth, found) = (Predictor::new(built_in)?, Predictor::new(fitted)?);
    let mut worst: f64 = 0.0;
    for channel in 0..found.channel_count() {
        for distance in measured.distances() {
            let vergence = found.vergence(distance)?;
            for step in 0..=10 {
                let at = seidel_core::field::FieldPoint::new(0.1 * f64::from(step), 0.0);
                let size = |lens: &Predictor| {
                    let m = lens.blur_at(channel, at, vergence).blur.moments;
                    m.trace().max(0.0).sqrt()
                };
                worst = worst.max((size(&found) - size(&truth)).abs());
            }
        }
    }
    Ok(worst)
}
