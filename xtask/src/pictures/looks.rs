//! The demo's plate through a library lens with one look each, and through each library lens.

use std::path::PathBuf;

use image::imageops::FilterType;

use super::panels::{Panel, grid};
use super::programs::Programs;
use super::samples::{Crop, part_of_file, with_colour_changed};

/// The part of the demo's plate with its lamps, px.
const LAMPS: Crop = Crop {
    left: 480,
    top: 20,
    width: 440,
    height: 248,
};

/// Factors on the light above white, and then on all light: discs that are not clipped show the effect of a look.
const DIMMED: f32 = 1.0 / 24.0;
const EXPOSURE: f32 = 0.5;

/// The looks, each with its label.
const LOOKS: [(&str, &str); 12] = [
    ("", "as the lens (library:modern-50)"),
    ("--blades 5", "--blades 5"),
    (
        "--blades 6 --roundness 0.5 --rotation 30",
        "--blades 6 --roundness 0.5 --rotation 30",
    ),
    ("--squeeze 2", "--squeeze 2"),
    ("--obstruction 0.5", "--obstruction 0.5"),
    ("--cats-eye 1", "--cats-eye 1"),
    ("--spherical 1", "--spherical 1"),
    ("--spherical -1", "--spherical -1"),
    ("--lens library:wide-zoom-16", "library:wide-zoom-16"),
    (
        "--lens library:wide-zoom-16 --lateral-colour 4",
        "library:wide-zoom-16 --lateral-colour 4",
    ),
    (
        "--bloom 0.5 --bloom-level 0.5",
        "--bloom 0.5 --bloom-level 0.5",
    ),
    (
        "--squeeze 1.8 --cats-eye 0.7 --spherical 0.6",
        "squeeze 1.8, cat's eye 0.7, spherical 0.6",
    ),
];

/// The looks with a name, after the lens alone.
const NAMED: [(&str, &str); 6] = [
    ("", "as the lens (library:modern-50)"),
    ("--look portrait", "--look portrait"),
    ("--look swirl", "--look swirl"),
    ("--look bubble", "--look bubble"),
    ("--look anamorphic", "--look anamorphic"),
    ("--look catadioptric", "--look catadioptric"),
];

/// Tilts of the lens, each with its label.
const TILTS: [(&str, &str); 4] = [
    ("", "as the lens (library:modern-50)"),
    ("--tilt 8", "--tilt 8"),
    ("--tilt 8 --tilt-direction 0", "--tilt 8 --tilt-direction 0"),
    ("--look miniature", "--look miniature"),
];
/// Width and height of their panels, px.
const TILTED: (u32, u32) = (640, 360);

/// The lenses of the library, each with its label.
const LENSES: [(&str, &str); 8] = [
    ("modern-50", "modern: modern-50"),
    ("swirl-58", "vintage: swirl-58"),
    ("bubble-100", "vintage: bubble-100"),
    ("soft-portrait-85", "portrait: soft-portrait-85"),
    ("anamorphic-75", "anamorphic: anamorphic-75"),
    ("macro-100", "macro: macro-100"),
    ("mirror-500", "mirror: mirror-500"),
    ("wide-zoom-16", "wide zoom: wide-zoom-16"),
];

/// Draws one panel for each look of `docs/pictures/looks.png`.
pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    sheet(programs, LOOKS.map(of_modern(programs)), 3, "looks.png")
}

/// Draws one panel for each look of `docs/pictures/named-looks.png`.
pub(super) fn draw_named(programs: &Programs) -> Result<(), String> {
    sheet(
        programs,
        NAMED.map(of_modern(programs)),
        3,
        "named-looks.png",
    )
}

/// Draws one panel for each tilt of `docs/pictures/tilt.png`: the demo's whole plate, focused at 6 m.
pub(super) fn draw_tilted(programs: &Programs) -> Result<(), String> {
    let panels = TILTS.map(|(options, label)| {
        let lens = "--lens library:modern-50 --focus-distance 6";
        let path = rendered(programs, &format!("{lens} {options}"))?;
        let image = image::open(&path).map_err(|why| format!("{}: {why}", path.display()))?;
        let (width, height) = TILTED;
        Ok(Panel {
            label: label.to_owned(),
            image: image
                .resize(width, height, FilterType::Triangle)
                .into_rgb8(),
        })
    });
    sheet(programs, panels, 2, "tilt.png")
}

/// Returns a function that draws the panel of options and a label, through `modern-50` unless the options name a lens.
fn of_modern(programs: &Programs) -> impl Fn((&str, &str)) -> Result<Panel, String> {
    move |(options, label)| {
        let lens = if options.contains("--lens") {
            ""
        } else {
            "--lens library:modern-50 "
        };
        panel(
            programs,
            &format!("--focus-distance 2 {lens}{options}"),
            label,
        )
    }
}

/// Draws one panel for each lens of `docs/pictures/library.png`. The largest discs are of one size.
pub(super) fn draw_library(programs: &Programs) -> Result<(), String> {
    let panels = LENSES.map(|(name, label)| {
        panel(
            programs,
            &format!("--focus-distance 2 --lens library:{name} --maximum-size 16"),
            label,
        )
    });
    sheet(programs, panels, 2, "library.png")
}

/// Returns the lamps of the demo's plate with these `options`.
fn panel(programs: &Programs, options: &str, label: &str) -> Result<Panel, String> {
    Ok(Panel {
        label: label.to_owned(),
        image: part_of_file(&rendered(programs, options)?, LAMPS)?,
    })
}

/// Renders the demo's plate, its lamps dimmed, with these `options`; returns the picture.
fn rendered(programs: &Programs, options: &str) -> Result<PathBuf, String> {
    let demo = programs.demo()?;
    let dimmed = |light: f32| EXPOSURE * (light.min(1.0) + DIMMED * (light - 1.0).max(0.0));
    with_colour_changed(
        &demo.join("plate.exr"),
        &programs.work().join("dimmed.exr"),
        dimmed,
    )?;
    programs.seidel(&format!("apply dimmed.exr -o look.exr {options}"))?;
    programs
        .seidel("lut look.exr -o look.png --ocio seidel --in-space lin_rec709 --view sRGB/Plain")?;
    Ok(programs.work().join("look.png"))
}

fn sheet<const N: usize>(
    programs: &Programs,
    panels: [Result<Panel, String>; N],
    columns: u32,
    file: &str,
) -> Result<(), String> {
    let panels = panels.into_iter().collect::<Result<Vec<_>, _>>()?;
    let sheet = programs.work().join(file);
    let drawn = grid(&panels, columns)?;
    drawn
        .save(&sheet)
        .map_err(|why| format!("{}: {why}", sheet.display()))?;
    programs.install(&sheet, file)
}
