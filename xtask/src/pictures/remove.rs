//! Removal of blur: a noisy plate, the sharp image, and the noise gain.

use image::{Rgb, RgbImage};

use super::noise::Gaussian;
use super::panels::{Panel, grid};
use super::programs::Programs;
use super::samples::{Crop, part_of_channel, part_of_file, with_colour_changed};

/// Standard deviation of the noise added to the plate.
const NOISE: f64 = 0.003;
/// The part shown: lamps, reflections and the clapperboard.
const CROP: Crop = Crop {
    left: 220,
    top: 50,
    width: 440,
    height: 330,
};
/// Noise gains drawn darkest and lightest, as powers of two.
const GAIN_RANGE: (f32, f32) = (-2.0, 4.0);

pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    programs.demo()?;
    let work = programs.work();
    let lens = "--lens demo/lens.json --f-number 4";
    programs.seidel(&format!(
        "apply {lens} demo/plate.exr -o remove-blurred.exr"
    ))?;
    let mut noise = Gaussian::new(1);
    with_colour_changed(
        &work.join("remove-blurred.exr"),
        &work.join("remove-plate.exr"),
        |sample| sample + (NOISE * noise.sample()) as f32,
    )?;
    programs.seidel(&format!(
        "remove {lens} remove-plate.exr -o remove-sharp.exr --no-overscan --noise-gain remove-gain.exr"
    ))?;
    let view = "--ocio seidel --in-space lin_rec709 --view sRGB/Plain";
    let mut panels = Vec::new();
    for (file, label) in [
        ("plate", format!("plate: f/4, noise {NOISE}")),
        ("sharp", "after seidel remove".to_owned()),
    ] {
        programs.seidel(&format!(
            "lut remove-{file}.exr -o remove-{file}.png {view}"
        ))?;
        let image = part_of_file(&work.join(format!("remove-{file}.png")), CROP)?;
        panels.push(Panel { label, image });
    }
    let gain = part_of_channel(&work.join("remove-gain.exr"), "G", CROP)?;
    panels.push(Panel {
        label: "noise gain of G: dark 1/4, light 16".to_owned(),
        image: RgbImage::from_fn(CROP.width, CROP.height, |x, y| {
            gain_colour(gain[(y * CROP.width + x) as usize])
        }),
    });
    let sheet = work.join("remove.png");
    let drawn = grid(&panels, 3)?;
    drawn
        .save(&sheet)
        .map_err(|why| format!("{}: {why}", sheet.display()))?;
    programs.install(&sheet, "remove.png")
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
