//! `--show`: pictures of the blur by depth, instead of the blurred plate.

use clap::ValueEnum;
use seidel_core::{BlurMap, COC_SCALE, CocColours, FocusSide};

use crate::commands::plates::LoadedPlate;
use crate::commands::{CommandError, value_name};
use seidel_image_io::error::FileError;
use seidel_image_io::samples::Encoding;

/// The subject of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ShowChoice {
    /// Diameter of the circle of confusion in false colour
    Coc,
    /// The plate in grey where it is in focus, in orange in front of it, in blue behind it
    Focus,
    /// Depth slices that the plate is rendered in, one colour each
    Slices,
    /// Diameter of the circle of confusion in plate pixels as a number, negative in front of the focus; EXR only
    CocPx,
    /// Focus matte: 1 in focus, 0 elsewhere; EXR only
    FocusMatte,
}

impl ShowChoice {
    /// Returns whether the samples are numbers, not colours.
    pub(super) fn is_numbers(self) -> bool {
        matches!(self, Self::CocPx | Self::FocusMatte)
    }
}

/// Parses a growth of the circle of confusion.
pub(super) fn parse_tolerance(text: &str) -> Result<f32, String> {
    let number = text.parse().ok();
    let number = number.filter(|px: &f32| px.is_finite() && *px >= 0.0);
    number.ok_or_else(|| "give 0 or more plate pixels".to_owned())
}

/// A colour by its sRGB codes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Colour([u8; 3]);

impl Colour {
    fn linear(self) -> [f32; 3] {
        self.0
            .map(|code| Encoding::Srgb.decode(f32::from(code) / 255.0))
    }

    fn hex(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// The usual growth of the circle of confusion over that in the plane of focus up to which a pixel is in focus, px.
pub(super) const IN_FOCUS_PX: f32 = 2.0;
// People with any kind of colour vision can distinguish these.
const IN_FOCUS: Colour = Colour([235, 235, 235]);
const IN_FRONT: Colour = Colour([245, 130, 20]);
const BEHIND: Colour = Colour([40, 100, 235]);
/// Share of the tint, and the least light that it is given: black areas show it too.
const TINT: f32 = 0.8;
const LEAST_LIGHT: f32 = 0.02;
/// Gain of the tint, whose colours are darker than white.
const GAIN: f32 = 1.6;

/// Turn of the hue from one slice to the next, of a full circle: neighbours differ, and colours recur late.
const HUE_STEP: f64 = 0.618_034;

/// A picture of the plate's size: premultiplied planes as those of the plate, and the meaning of its colours.
pub(super) struct Shown {
    pub(super) planes: Vec<Vec<f32>>,
    pub(super) legend: Vec<String>,
}

/// Draws the picture that `choice` asks for.
///
/// # Errors
/// A plate without R, G and B, slices without a depth pass, and focus of a lens that has none.
pub(super) fn draw(
    choice: ShowChoice,
    tolerance_px: f32,
    loaded: &LoadedPlate,
) -> Result<Shown, CommandError> {
    let rgb = rgb_planes(loaded)?;
    let map = loaded.prepared.blur_map().map_err(|e| loaded.in_file(e))?;
    let needs = |option: &str, problem: &str, remedy: &str| -> CommandError {
        FileError::new(loaded.plate.path(), option, problem, remedy).into()
    };
    if map.focus_per_m.is_none() && choice != ShowChoice::Coc && choice != ShowChoice::Slices {
        let problem = "the lens has no distance at which it is sharpest";
        let option = format!("--show {}", value_name(choice));
        return Err(needs(&option, problem, "use --show coc"));
    }
    // The distance that was asked for, which aberrations may hold to be a little off the sharpest one.
    let requested = loaded.lens.session.settings().focus.focus_per_m;
    let focus_per_m = requested.or(map.focus_per_m).unwrap_or_default();
    let (pixel, legend): (PixelColour, Vec<String>) = match choice {
        ShowChoice::Coc => coc(&map),
        ShowChoice::Focus => focus(&map, focus_per_m, tolerance_px),
        ShowChoice::CocPx => coc_px(&map),
        ShowChoice::FocusMatte => focus_matte(&map, tolerance_px),
        ShowChoice::Slices if map.slices.is_empty() => {
            let problem = "the plate has one distance, so it is not cut into slices";
            let remedy = "give --depth FILE, or a plate with a depth channel Z, without --distance";
            return Err(needs("--show slices", problem, remedy));
        }
        ShowChoice::Slices => slices(&map),
    };
    let mut planes = loaded.prepared.planes().to_vec();
    let names = loaded.prepared.names();
    let alpha = names.iter().position(|name| name == "A");
    let alpha = alpha.map(|place| planes[place].clone());
    if choice.is_numbers() {
        // No alpha may change a number.
        planes.iter_mut().for_each(|plane| plane.fill(1.0));
    }
    for index in 0..map.diameter_px.len() {
        let own = rgb.map(|place| planes[place][index]);
        let coverage = alpha.as_ref().map_or(1.0, |alpha| alpha[index]);
        let colour = pixel(index, own, coverage);
        for (place, value) in rgb.into_iter().zip(colour) {
            planes[place][index] = value;
        }
    }
    Ok(Shown { planes, legend })
}

/// The premultiplied colour of the pixel at an index, from the plate's own and its alpha.
type PixelColour<'m> = Box<dyn Fn(usize, [f32; 3], f32) -> [f32; 3] + 'm>;

/// Returns the places of R, G and B among the planes.
fn rgb_planes(loaded: &LoadedPlate) -> Result<[usize; 3], CommandError> {
    let names = loaded.prepared.names();
    let place = |wanted: &str| names.iter().position(|name| name == wanted);
    match (place("R"), place("G"), place("B")) {
        (Some(r), Some(g), Some(b)) => Ok([r, g, b]),
        _ => Err(FileError::new(
            loaded.plate.path(),
            "--show",
            format!("the plate has no R, G and B (it has {})", names.join(", ")),
            "give a plate in colour, or choose a layer that is with --layer",
        )
        .into()),
    }
}

fn coc(map: &BlurMap) -> (PixelColour<'_>, Vec<String>) {
    let stops = COC_SCALE.map(|stop| {
        let colour = Colour(stop.srgb).hex();
        format!("{} {} ({colour})", stop.diameter_px, stop.name)
    });
    let diameters = &map.diameter_px;
    let least = diameters.iter().copied().fold(f32::INFINITY, f32::min);
    let largest = diameters.iter().copied().fold(0.0, f32::max);
    let legend = vec![
        format!(
            "diameter of the circle of confusion, px: {}",
            stops.join(", ")
        ),
        format!("in this plate it is {least:.1} to {largest:.1} px"),
    ];
    let colours = CocColours::default();
    let pixel = move |index: usize, _, coverage| {
        let colour = colours.of(map.diameter_px[index]);
        colour.map(|value| coverage * value)
    };
    (Box::new(pixel), legend)
}

fn coc_px(map: &BlurMap) -> (PixelColour<'_>, Vec<String>) {
    let pixel = move |index: usize, _, _| [map.signed_diameter_px(index); 3];
    let legend = "R, G and B: diameter of the circle of confusion, px, negative in front of the focus; A is 1";
    (Box::new(pixel), vec![legend.to_owned()])
}

fn focus_matte(map: &BlurMap, tolerance_px: f32) -> (PixelColour<'_>, Vec<String>) {
    let pixel = move |index: usize, _, _| [f32::from(is_sharp(map, tolerance_px, index)); 3];
    let legend = format!(
        "R, G and B: 1 in focus, where circles of confusion are at most {tolerance_px} px wider than in the plane of focus; A is 1"
    );
    (Box::new(pixel), vec![legend])
}

fn is_sharp(map: &BlurMap, tolerance_px: f32, index: usize) -> bool {
    map.diameter_px[index] <= map.focused_px[index] + tolerance_px
}

fn focus(map: &BlurMap, focus_per_m: f64, tolerance_px: f32) -> (PixelColour<'_>, Vec<String>) {
    let is_sharp = move |index: usize| is_sharp(map, tolerance_px, index);
    let count = map.diameter_px.len();
    let sharp = (0..count).filter(|index| is_sharp(*index)).count();
    let legend = vec![
        format!(
            "grey: in focus, circles of confusion at most {tolerance_px} px wider than in the plane of focus ({}); orange: in front of it; blue: behind it",
            distance_words(focus_per_m)
        ),
        format!(
            "{:.1} % of the pixels are in focus",
            100.0 * sharp as f64 / count.max(1) as f64
        ),
    ];
    let tints = [IN_FOCUS, IN_FRONT, BEHIND].map(Colour::linear);
    let pixel = move |index: usize, own: [f32; 3], coverage: f32| {
        let tint = match map.side(index) {
            _ if is_sharp(index) => tints[0],
            Some(FocusSide::Front) => tints[1],
            _ => tints[2],
        };
        let light = (own.iter().sum::<f32>() / 3.0).max(LEAST_LIGHT * coverage);
        std::array::from_fn(|k| (1.0 - TINT) * own[k] + TINT * light * GAIN * tint[k])
    };
    (Box::new(pixel), legend)
}

fn slices(map: &BlurMap) -> (PixelColour<'_>, Vec<String>) {
    let count = map.slice_of.len().max(1) as f64;
    let used = map.slices.iter().filter(|slice| slice.pixels > 0).count();
    let mut legend = vec![format!(
        "{used} depth slices hold pixels, from the farthest:"
    )];
    let lines = map.slices.iter().enumerate().filter(|(_, s)| s.pixels > 0);
    legend.extend(lines.map(|(index, slice)| {
        format!(
            "{}: {}, circles of confusion up to {:.1} px, {:.2} % of the pixels",
            slice_colour(index).hex(),
            distance_words(slice.vergence_per_m),
            slice.diameter_px,
            100.0 * slice.pixels as f64 / count
        )
    }));
    let colours: Vec<[f32; 3]> = (0..map.slices.len())
        .map(|index| slice_colour(index).linear())
        .collect();
    let pixel = move |index: usize, _, coverage| {
        colours[usize::from(map.slice_of[index])].map(|value| coverage * value)
    };
    (Box::new(pixel), legend)
}

/// Returns the colour of a slice: hues far apart for neighbours, light and dark in turn.
fn slice_colour(index: usize) -> Colour {
    let hue = 6.0 * (index as f64 * HUE_STEP).fract();
    let value = if index.is_multiple_of(2) {
        240.0
    } else {
        165.0
    };
    // Hue, saturation and value with a saturation of 3/4.
    let component = |shift: f64| {
        let at = (shift + hue) % 6.0;
        let dip = at.min(4.0 - at).clamp(0.0, 1.0);
        (value * (1.0 - 0.75 * dip)).round() as u8
    };
    Colour([component(5.0), component(3.0), component(1.0)])
}

/// Returns the distance of a vergence.
fn distance_words(vergence_per_m: f64) -> String {
    if vergence_per_m < 1e-4 {
        return "infinity".to_owned();
    }
    format!("{:.3} m", 1.0 / vergence_per_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_slices_have_other_colours() {
        let all: Vec<[u8; 3]> = (0..64).map(|index| slice_colour(index).0).collect();
        for (a, b) in all.iter().zip(&all[1..]) {
            let distance: u32 = (a.iter().zip(b))
                .map(|(a, b)| u32::from(a.abs_diff(*b)))
                .sum();
            assert!(distance > 100, "{a:?} {b:?}");
        }
        for (index, colour) in all.iter().enumerate() {
            assert!(!all[..index].contains(colour), "{index}");
        }
    }
}
