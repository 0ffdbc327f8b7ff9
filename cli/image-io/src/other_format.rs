//! A plate written in another format than it was read in: what its samples become, and what is lost.

use std::path::Path;

use exr::meta::attribute::SampleType;

use crate::colour_space::BY_NAME;
use crate::dpx;
use crate::error::Result;
use crate::exr::choice::ColourGroup;
use crate::exr::new::{Beside, NewChannel, write_beside};
use crate::exr::plate::ExrPlate;
use crate::facts::Facts;
use crate::flat_plate::{Container, Encoding, FlatPlate, MOST_HALF, SampleDepth};
use crate::format::Format;
use crate::limits::Limits;
use crate::plate::{Plate, PlateFile};
use crate::provenance::{Texts, is_ours};
use crate::windows::{Windows, placed};
use crate::{png, tiff};

/// Channels that are named one by one where they are left out.
const MOST_NAMED: usize = 12;

/// What is said where a colour profile does not go along.
const NO_PROFILE: &str = "the colour profile (ICC) is left out";

/// Writes `plate` as `target`, which is not the format that it was read in. Returns a sentence for each thing that is
/// not as it was.
///
/// # Errors
/// A display window too large for a picture, and a target that cannot be written.
pub(crate) fn write_as(plate: &Plate, path: &Path, target: Format) -> Result<Vec<String>> {
    let mut notes = left_out(plate, target);
    let mut picture = Picture::of(plate, target, &mut notes)?;
    match target {
        Format::Exr => write_exr(plate, path, picture, &mut notes)?,
        _ => {
            picture.shape(target, &mut notes);
            let flat = flat(plate, picture, target, &mut notes);
            notes.extend(flat.write(path)?);
        }
    }
    Ok(notes)
}

/// The colour and alpha of a plate over its whole new picture.
struct Picture {
    names: Vec<String>,
    /// As the plate gives it: scene-linear, or codes of a colour space.
    colour: Vec<Vec<f32>>,
    alpha: Option<Vec<f32>>,
    premultiplied: bool,
    windows: Windows,
    texts: Texts,
}

impl Picture {
    /// The picture of `plate`: for formats without data windows cut to the display window, or surrounded by black.
    fn of(plate: &Plate, target: Format, notes: &mut Vec<String>) -> Result<Self> {
        let mut picture = Self {
            names: plate.colour_names().to_vec(),
            colour: plate.colour(),
            alpha: plate.alpha(),
            premultiplied: plate.is_premultiplied(),
            windows: plate.windows(),
            texts: texts(plate, target, notes),
        };
        let Windows { data, display } = picture.windows;
        if target == Format::Exr || data == display {
            return Ok(picture);
        }
        let limits = Limits::PLATE;
        limits.check_sides(plate.path(), "displayWindow", display.width, display.height)?;
        let bytes = display.width as u128 * display.height as u128 * 4 * 5;
        limits.check_bytes(plate.path(), "displayWindow", bytes, plate.held_bytes())?;
        if !display.contains(data) {
            notes.push(format!(
                "{target} has no data window: the plate is cut to its display window, {display}"
            ));
        }
        if !data.contains(display) {
            notes.push(format!(
                "{target} has no data window: the plate is black where its display window, {display}, has no pixels"
            ));
        }
        for plane in picture.colour.iter_mut().chain(&mut picture.alpha) {
            *plane = placed(plane, data, display);
        }
        picture.windows.data = display;
        Ok(picture)
    }

    /// Makes of the channels those that a format other than EXR has, its alpha as it takes it.
    fn shape(&mut self, target: Format, notes: &mut Vec<String>) {
        match target {
            Format::Png => self.unpremultiply(target, notes),
            Format::Dpx => self.premultiply(),
            Format::Hdr => {
                self.premultiply();
                if self.alpha.take().is_some() {
                    notes.push(format!(
                        "{target} holds no alpha: it is left out, and colour stays multiplied by it"
                    ));
                }
            }
            // TIFF says which it is.
            _ => {}
        }
        let grey = self.names == ["Y"];
        if grey && (target == Format::Hdr || target == Format::Dpx && self.alpha.is_some()) {
            self.names = ["R", "G", "B"].map(str::to_owned).to_vec();
            self.colour = vec![self.colour[0].clone(); 3];
            notes.push(format!(
                "Y is written as equal R, G and B, as {target} asks"
            ));
        }
    }

    fn premultiply(&mut self) {
        if let (Some(alpha), false) = (&self.alpha, self.premultiplied) {
            for plane in &mut self.colour {
                for (sample, alpha) in plane.iter_mut().zip(alpha) {
                    *sample *= alpha;
                }
            }
        }
        self.premultiplied = true;
    }

    fn unpremultiply(&mut self, target: Format, notes: &mut Vec<String>) {
        if let (Some(alpha), true) = (&self.alpha, self.premultiplied) {
            let glows = |i: usize| alpha[i] <= 0.0 && self.colour.iter().any(|p| p[i] != 0.0);
            let lost = (0..alpha.len()).filter(|&i| glows(i)).count();
            if lost > 0 {
                notes.push(format!(
                    "{target} holds colour that is not multiplied by alpha: {lost} pixels of colour without alpha are black"
                ));
            }
            for plane in &mut self.colour {
                for (sample, &alpha) in plane.iter_mut().zip(alpha) {
                    *sample = if alpha > 0.0 { *sample / alpha } else { 0.0 };
                }
            }
            self.premultiplied = false;
        }
    }
}

/// The texts that go along: what made the picture, and in PNG any.
fn texts(plate: &Plate, target: Format, notes: &mut Vec<String>) -> Texts {
    let all = match &plate.file {
        PlateFile::Exr { plate, group } => {
            // In no order there.
            let mut texts = plate.provenance(group.colour[0]);
            texts.sort();
            texts
        }
        PlateFile::Flat { plate, .. } => plate.texts().to_vec(),
    };
    let kept = |(name, _): &(String, String)| target == Format::Png || is_ours(name);
    let (kept, others): (Texts, Texts) = all.into_iter().partition(kept);
    let names: Vec<String> = others.into_iter().map(|(name, _)| name).collect();
    if !names.is_empty() {
        notes.push(format!("texts are left out: {}", names.join(", ")));
    }
    kept
}

/// What is not written, a sentence each.
fn left_out(plate: &Plate, target: Format) -> Vec<String> {
    let mut notes = match &plate.file {
        PlateFile::Exr { plate, group } => left_of_exr(plate, group, target),
        PlateFile::Flat { plate, .. } => left_of_flat(plate, target),
    };
    let aspect = plate.pixel_aspect();
    if aspect != 1.0 && !matches!(target, Format::Exr | Format::Dpx) {
        notes.push(format!(
            "{target} does not say that pixels are {aspect} times as wide as high"
        ));
    }
    notes
}

fn left_of_exr(plate: &ExrPlate, group: &ColourGroup, target: Format) -> Vec<String> {
    let mut notes = Vec::new();
    let several = plate.parts() > 1;
    let written = |id| group.colour.contains(&id) || group.alpha == Some(id);
    let others: Vec<String> = plate
        .channels()
        .into_iter()
        .filter(|channel| !written(channel.id))
        .map(|channel| match channel.part {
            Some(part) if several => format!("{part}:{}", channel.name),
            _ => channel.name,
        })
        .collect();
    if !others.is_empty() {
        let named = others[..others.len().min(MOST_NAMED)].join(", ");
        let more = match others.len().saturating_sub(MOST_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        notes.push(format!(
            "{target} holds one picture: channels {named}{more} are left out"
        ));
    }
    let kept = match target {
        Format::Dpx => plate.facts(group.colour[0]).names(),
        _ => Vec::new(),
    };
    if plate.has_own_attributes(&kept) {
        let but = match kept.is_empty() {
            true => String::new(),
            false => format!(" but for {}", kept.join(", ")),
        };
        notes.push(format!("the attributes of the EXR are left out{but}"));
    }
    notes
}

/// What a plate says of its picture that EXR and DPX both have places for.
fn facts(plate: &Plate) -> Facts {
    match &plate.file {
        PlateFile::Exr { plate, group } => plate.facts(group.colour[0]),
        PlateFile::Flat { plate, .. } => match &plate.container {
            Container::Dpx(carried) => carried.facts(),
            _ => Facts::default(),
        },
    }
}

fn left_of_flat(plate: &FlatPlate, target: Format) -> Vec<String> {
    let left = match &plate.container {
        Container::Png(carried) => match carried.names() {
            names if names.is_empty() => None,
            names => Some(format!("{} of the PNG", names.join(", "))),
        },
        Container::Tiff(carried) if carried.has_texts() => Some("the tags of the TIFF".to_owned()),
        Container::Dpx(carried) => match carried.facts().names() {
            names if target == Format::Exr && !names.is_empty() => Some(format!(
                "the header of the DPX but for {}, and its user data",
                names.join(", ")
            )),
            _ => Some("the header of the DPX and its user data".to_owned()),
        },
        Container::Hdr { lines } if !lines.is_empty() => {
            Some("the header lines of the HDR".to_owned())
        }
        Container::Jpeg { exif: true, .. } => {
            Some("the notes of the camera in the JPEG (EXIF)".to_owned())
        }
        _ => None,
    };
    let left = left.map(|what| format!("{what} are left out"));
    left.into_iter().chain(plate.only_first()).collect()
}

/// The colour profile of a plate.
fn icc(plate: &Plate) -> Option<Vec<u8>> {
    match &plate.file {
        PlateFile::Flat { plate, .. } => plate.icc(),
        PlateFile::Exr { .. } => None,
    }
}

/// How the samples of a plate are stored in its file.
fn depth_of(plate: &Plate) -> SampleDepth {
    match &plate.file {
        PlateFile::Flat { plate, .. } => plate.depth(),
        PlateFile::Exr { plate, group } => {
            let channels = plate.channels();
            let is_half = |id| {
                let own = channels.iter().find(|channel| channel.id == id);
                own.is_some_and(|channel| channel.sample_type == SampleType::F16)
            };
            match group.colour.iter().all(|&id| is_half(id)) {
                true => SampleDepth::F16,
                false => SampleDepth::F32,
            }
        }
    }
}

/// How samples that were stored as `source` are stored in another format but EXR: no coarser where it can be, but RGB
/// in DPX has the 10 bits that programs expect of it unless there were 12 or 16. Programs disagree on where samples of
/// 10 bits lie that are not three a pixel.
fn flat_depth(source: SampleDepth, target: Format, channels: usize) -> SampleDepth {
    use SampleDepth::{F32, Rgbe, U8, U10, U12, U16};
    match (target, source) {
        (Format::Hdr, _) => Rgbe,
        (Format::Dpx, U12) => U12,
        (Format::Dpx, U16) => U16,
        (Format::Dpx, _) if channels != 3 => U16,
        (Format::Dpx, _) => U10,
        (_, U8) => U8,
        (Format::Tiff, U10 | U12 | U16) => U16,
        (Format::Tiff, _) => F32,
        _ => U16,
    }
}

/// The picture of `plate` in the form of `target`.
fn flat(plate: &Plate, picture: Picture, target: Format, notes: &mut Vec<String>) -> FlatPlate {
    let source = depth_of(plate);
    let channels = picture.names.len() + usize::from(picture.alpha.is_some());
    let depth = flat_depth(source, target, channels);
    let options = &plate.options;
    let encoding = match options.colour_managed {
        // Codes of some colour space already.
        true => Encoding::Linear,
        false if depth.is_integer() => options.encoding.unwrap_or(Encoding::Srgb),
        false => Encoding::Linear,
    };
    let was = match &plate.file {
        PlateFile::Flat { encoding, .. } => *encoding,
        PlateFile::Exr { .. } => Encoding::Linear,
    };
    if source != depth || was != encoding {
        let meaning = match encoding {
            _ if options.colour_managed => "",
            Encoding::Linear => ", proportional to light",
            Encoding::Srgb => ", sRGB-encoded",
        };
        notes.push(format!("{source} samples are written as {depth}{meaning}"));
    }
    let Picture {
        names,
        mut colour,
        alpha,
        premultiplied,
        windows,
        texts,
    } = picture;
    for sample in colour.iter_mut().flatten() {
        *sample = encoding.encode(*sample);
    }
    let icc = icc(plate);
    // A profile goes with its codes.
    let fits = was == encoding
        && depth.is_integer()
        && !options.colour_managed
        && matches!(target, Format::Png | Format::Tiff);
    if icc.is_some() && !fits {
        notes.push(NO_PROFILE.to_owned());
    }
    let icc = icc.filter(|_| fits);
    let size = (windows.data.width, windows.data.height);
    let container = match target {
        Format::Tiff => {
            let premultiplied = alpha.as_ref().map(|_| premultiplied);
            Container::Tiff(tiff::tags::Carried::new(premultiplied, icc))
        }
        Format::Dpx => {
            let meaning = (!options.colour_managed).then_some(encoding);
            let aspect = plate.pixel_aspect();
            let mut carried = dpx::Carried::new(size, channels, depth, meaning, aspect);
            let lost = carried.put_facts(&facts(plate));
            if !lost.is_empty() {
                let lost = lost.join(", ");
                notes.push(format!("DPX has no room for {lost}: left out"));
            }
            Container::Dpx(Box::new(carried))
        }
        Format::Hdr => Container::Hdr { lines: Vec::new() },
        _ => Container::Png(Box::new(png::Carried::new(icc))),
    };
    let alpha_name = alpha.as_ref().map(|_| "A".to_owned());
    FlatPlate {
        path: plate.path().to_path_buf(),
        container,
        depth,
        width: size.0,
        height: size.1,
        names: names.into_iter().chain(alpha_name).collect(),
        planes: colour.into_iter().chain(alpha).collect(),
        texts,
        changed: true,
        notes: Vec::new(),
    }
}

/// Writes the picture of `plate` as EXR: half where that holds what its file held, else float.
fn write_exr(
    plate: &Plate,
    path: &Path,
    mut picture: Picture,
    notes: &mut Vec<String>,
) -> Result<()> {
    picture.premultiply();
    let source = depth_of(plate);
    let planes = || picture.colour.iter().chain(&picture.alpha);
    let fine = matches!(
        source,
        SampleDepth::U8 | SampleDepth::U10 | SampleDepth::F16
    );
    let half = fine && planes().flatten().all(|v| v.abs() <= MOST_HALF);
    let depth = match half {
        true => SampleDepth::F16,
        false => SampleDepth::F32,
    };
    let meaning = match plate.options.colour_managed {
        true => "",
        false => ", proportional to light",
    };
    notes.push(format!("{source} samples are written as {depth}{meaning}"));
    if icc(plate).is_some() {
        notes.push(NO_PROFILE.to_owned());
    }
    let names = picture.names.iter().map(String::as_str).chain(["A"]);
    let channels: Vec<NewChannel> = names
        .zip(planes())
        .map(|(name, samples)| NewChannel {
            name,
            samples,
            half,
        })
        .collect();
    let mut texts = picture.texts.clone();
    if let Some(space) = &plate.space {
        texts.push((BY_NAME.to_owned(), space.clone()));
    }
    let beside = Beside {
        pixel_aspect: Some(plate.pixel_aspect()),
        facts: facts(plate),
        packing: plate.options.packing,
        texts,
    };
    write_beside(path, picture.windows, &channels, beside)
}
