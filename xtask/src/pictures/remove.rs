//! Removal of blur: at one distance, and through a depth pass beside lamps, with the noise gain and details.

use std::path::Path;

use image::imageops::{FilterType, resize};
use image::{Rgb, RgbImage};

use super::noise::Gaussian;
use super::panels::{Panel, grid};
use super::programs::Programs;
use super::samples::{Crop, part_of_channel, part_of_file, with_colour_changed};

/// The demo's lens, at one distance and through the depth pass, with the standard deviation of noise.
const FLAT: Blur = Blur {
    name: "remove-flat",
    options: "--lens demo/lens.json --f-number 2.8 --distance 3",
    noise: 0.001,
};
const DEEP: Blur = Blur {
    name: "remove-deep",
    options: "--lens demo/lens.json --f-number 4",
    noise: 0.003,
};
/// Enlargement of details.
const ENLARGEMENT: u32 = 2;
/// Size of a detail, px of the plate.
const DETAIL: (u32, u32) = (220, 165);
/// The clapperboard, for blur at one distance.
const CLAPPERBOARD: Crop = detail(408, 255);
/// Details for blur through the depth pass.
const DETAILS: [(Crop, &str); 3] = [
    (detail(408, 200), "clapperboard before the street"),
    (detail(0, 150), "pole before a wall"),
    (detail(180, 60), "lamps before windows"),
];
/// The part shown of the plate with depth: lamps, reflections and the clapperboard.
const CROP: Crop = Crop {
    left: 220,
    top: 50,
    width: DETAIL.0 * ENLARGEMENT,
    height: DETAIL.1 * ENLARGEMENT,
};
/// Noise gains drawn darkest and lightest, as powers of two.
const GAIN_RANGE: (f32, f32) = (-2.0, 4.0);

/// Blur of the demo's plate, and noise added to it.
struct Blur {
    name: &'static str,
    options: &'static str,
    noise: f64,
}

impl Blur {
    /// Blurs the demo's plate, adds noise and removes the blur. Files are NAME-plate.exr, NAME-sharp.exr and views of both.
    fn removed(&self, programs: &Programs, more_options: &str) -> Result<(), String> {
        let (name, options, work) = (self.name, self.options, programs.work());
        programs.seidel(&format!(
            "apply {options} demo/plate.exr -o {name}-blurred.exr"
        ))?;
        let mut noise = Gaussian::new(1);
        with_colour_changed(
            &work.join(format!("{name}-blurred.exr")),
            &work.join(format!("{name}-plate.exr")),
            |sample| sample + (self.noise * noise.sample()) as f32,
        )?;
        programs.seidel(&format!(
            "remove {options} {name}-plate.exr -o {name}-sharp.exr --no-overscan {more_options}"
        ))?;
        view(programs, &format!("{name}-plate"))?;
        view(programs, &format!("{name}-sharp"))
    }

    /// The path of the view of the noisy plate (`plate`) or of the result (`sharp`).
    fn view_of(&self, work: &Path, file: &str) -> std::path::PathBuf {
        work.join(format!("{}-{file}.png", self.name))
    }
}

const fn detail(left: u32, top: u32) -> Crop {
    Crop {
        left,
        top,
        width: DETAIL.0,
        height: DETAIL.1,
    }
}

pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    let demo = programs.demo()?;
    let work = programs.work();
    std::fs::copy(demo.join("plate.exr"), work.join("remove-truth.exr"))
        .map_err(|why| format!("{}: {why}", demo.display()))?;
    view(programs, "remove-truth")?;
    let truth = work.join("remove-truth.png");
    FLAT.removed(programs, "")?;
    DEEP.removed(programs, "--noise-gain remove-gain.exr")?;

    let mut panels = vec![
        enlarged(
            &FLAT.view_of(work, "plate"),
            CLAPPERBOARD,
            format!("one distance, f/2.8, noise {} (200 %)", FLAT.noise),
        )?,
        enlarged(
            &FLAT.view_of(work, "sharp"),
            CLAPPERBOARD,
            "after seidel remove".to_owned(),
        )?,
        enlarged(&truth, CLAPPERBOARD, "the sharp plate".to_owned())?,
    ];
    for (file, label) in [
        ("plate", format!("depth pass, f/4, noise {}", DEEP.noise)),
        ("sharp", "after seidel remove".to_owned()),
    ] {
        let image = part_of_file(&DEEP.view_of(work, file), CROP)?;
        panels.push(Panel { label, image });
    }
    let gain = part_of_channel(&work.join("remove-gain.exr"), "G", CROP)?;
    panels.push(Panel {
        label: "noise gain of G: dark 1/4, light 16".to_owned(),
        image: RgbImage::from_fn(CROP.width, CROP.height, |x, y| {
            gain_colour(gain[(y * CROP.width + x) as usize])
        }),
    });
    install(programs, &panels, "remove.png")?;

    let mut details = Vec::new();
    for (crop, place) in DETAILS {
        let plate = DEEP.view_of(work, "plate");
        let sharp = DEEP.view_of(work, "sharp");
        details.push(enlarged(&plate, crop, place.to_owned())?);
        details.push(enlarged(&sharp, crop, "after seidel remove".to_owned())?);
        details.push(enlarged(&truth, crop, "the sharp plate".to_owned())?);
    }
    install(programs, &details, "remove-depth.png")
}

/// Writes NAME.png, what a screen shows of NAME.exr.
fn view(programs: &Programs, name: &str) -> Result<(), String> {
    programs.seidel(&format!(
        "lut {name}.exr -o {name}.png --ocio seidel --in-space lin_rec709 --view sRGB/Plain"
    ))
}

/// A detail of an image file, each pixel a square.
fn enlarged(path: &Path, crop: Crop, label: String) -> Result<Panel, String> {
    let (width, height) = (crop.width * ENLARGEMENT, crop.height * ENLARGEMENT);
    let image = resize(
        &part_of_file(path, crop)?,
        width,
        height,
        FilterType::Nearest,
    );
    Ok(Panel { label, image })
}

/// Lays panels out in three columns and copies the sheet to the documentation.
fn install(programs: &Programs, panels: &[Panel], file: &str) -> Result<(), String> {
    let sheet = programs.work().join(format!("sheet-{file}"));
    let drawn = grid(panels, 3)?;
    drawn
        .save(&sheet)
        .map_err(|why| format!("{}: {why}", sheet.display()))?;
    programs.install(&sheet, file)
}

/// The colour of a noise gain: its logarithm on a ramp from dark brown to near white.
fn gain_colour(gain: f32) -> Rgb<u8> {
    let (low, high) = GAIN_RANGE;
    let place = ((gain.max(1e-6).log2() - low) / (high - low)).clamp(0.0, 1.0);
    let [dark, light] = [[60.0, 24.0, 12.0], [255.0, 244.0, 232.0]];
    Rgb(std::array::from_fn(|k| {
        (dark[k] + place * (light[k] - dark[k])).round() as u8
    }))
}
