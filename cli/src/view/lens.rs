//! The page of a lens: its PSFs over the field, by distance and stop.

use rayon::prelude::*;
use seidel_core::profile::PupilChannel;
use seidel_core::{
    BlurField, Controls, FieldPoint, Lens, LensProfile, LocalBlur, ObjectDistance, Result,
};
use seidel_optics::effects::Symmetry;
use seidel_optics::psf::{PsfModel, SampleGrid};
use serde::Serialize;

use super::atlas::{Atlas, Light, ShownChannels, tile_side};
use super::{PageText, page};
use crate::pictures::sheet_labels::distance_name;

/// Distances on each side of the focus, by even steps of vergence.
const STEPS_OF_FOCUS: usize = 3;
/// Apertures: the area of the pupil over that as measured.
const STOPS: [f64; 4] = [1.0, 0.5, 0.25, 0.0625];
/// Field radii, shares of that of the corner.
const RINGS: [f64; 6] = [0.0, 0.24, 0.48, 0.67, 0.86, 0.94];
/// Step of the azimuth, degrees: a whole number of steps between the eight spokes that the script draws.
const AZIMUTH_STEP_DEG: f64 = 22.5;
/// Step of the slider for a round lens, whose PSFs the script turns, degrees.
const ROUND_STEP_DEG: f64 = 5.0;
/// Radius of a tile, standard deviations of the widest PSF; an even disc reaches 2. Skewed PSFs get more.
const SHOWN_SIGMAS: f64 = 2.3;
/// Standard deviations that the tails of the smallest PSFs need besides, and the size, px, at which that falls by e.
const TAIL_SIGMAS: f64 = 1.0;
const TAIL_PX: f64 = 3.0;
/// Least radius of a tile, px of the frame.
const LEAST_REACH_PX: f64 = 2.0;
/// Variance added to drawn PSFs, tile px².
const DOT_VARIANCE_PX2: f64 = 0.5;

/// A lens to show, and its name.
pub struct LensSubject<'a> {
    /// Name of the file or of the library lens.
    pub name: &'a str,
    /// The lens, with its controls set.
    pub lens: &'a Lens,
    /// The model that draws its PSFs.
    pub model: &'a dyn PsfModel,
    /// Largest f-number to show, if the lens has one.
    pub smallest_aperture: Option<f64>,
}

/// Returns the symmetry of a lens over the field, which saves tiles.
fn symmetry(profile: &LensProfile) -> Symmetry {
    let channels = profile.pupil_channels().iter();
    let effects = channels.flat_map(|channel| channel.effects.iter().chain(&channel.added));
    let each = effects.map(|carried| carried.effect.symmetry(&carried.values));
    each.max().unwrap_or(Symmetry::Round)
}

/// Returns the azimuths at which PSFs are drawn, degrees.
fn azimuths_deg(symmetry: Symmetry) -> Vec<f64> {
    let count = match symmetry {
        Symmetry::Round => 1,
        Symmetry::TwoPlanes => (90.0 / AZIMUTH_STEP_DEG) as usize + 1,
        Symmetry::None => (360.0 / AZIMUTH_STEP_DEG) as usize,
    };
    (0..count).map(|k| k as f64 * AZIMUTH_STEP_DEG).collect()
}

/// Returns the step by which the page turns the field, degrees.
fn azimuth_step_deg(symmetry: Symmetry) -> f64 {
    match symmetry {
        Symmetry::Round => ROUND_STEP_DEG,
        Symmetry::TwoPlanes | Symmetry::None => AZIMUTH_STEP_DEG,
    }
}

#[derive(Serialize)]
struct LensData {
    kind: &'static str,
    frame: [u32; 2],
    axis: [f64; 2],
    distances: Vec<String>,
    start_distance: usize,
    stops: Vec<String>,
    sources: [&'static str; 1],
    polar: Polar,
    states: Vec<State>,
    atlas: Atlas,
}

/// The places of the tiles: the axis, then all azimuths of each ring.
#[derive(Serialize)]
struct Polar {
    /// Half frame widths.
    rings: Vec<f64>,
    azimuths: Vec<f64>,
    step_deg: f64,
    symmetry: Symmetry,
}

/// One distance at one stop.
#[derive(Serialize)]
struct State {
    /// Width of a tile in px of the frame.
    extent_px: f64,
}

/// Returns the page of a lens.
///
/// # Errors
/// A lens that has no PSF at one of its distances.
pub fn lens_page(subject: &LensSubject) -> Result<String> {
    let profile = subject.lens.profile();
    let frame = profile.frame;
    let symmetry = symmetry(profile);
    let polar = Polar {
        rings: RINGS.map(|share| share * frame.corner_radius()).to_vec(),
        azimuths: azimuths_deg(symmetry),
        step_deg: azimuth_step_deg(symmetry),
        symmetry,
    };
    let places = places(&polar);
    let distances = distances(profile);
    let stops = stops(subject)?;
    let side = tile_side(places.len() * distances.len() * stops.len());
    let shown = ShownChannels::of(subject.lens.predictor().channel_names());
    let mut states = Vec::new();
    let mut tiles: Vec<Light> = Vec::new();
    for distance in &distances {
        for stop in &stops {
            let vergence = stop.lens.predictor().vergence(*distance)?;
            let drawing = StateDrawing {
                lens: &stop.lens,
                model: subject.model,
                shown: &shown,
                vergence,
                side,
            };
            let (extent_px, light) = drawing.draw(&places);
            states.push(State { extent_px });
            tiles.extend(light);
        }
    }
    let focus = profile.camera.focus_distance;
    // Out of focus, where PSFs have a shape.
    let start_distance = distances.iter().position(|d| *d != focus).unwrap_or(0);
    let camera = &profile.camera;
    let known = [
        Some(format!(
            "frame {} × {} px",
            frame.width_px(),
            frame.height_px()
        )),
        camera.focal_length_mm.map(|f| format!("{f} mm")),
        camera.f_number.map(|n| format!("f/{n} as profiled")),
        focus
            .vergence_per_m()
            .map(|_| format!("focused at {}", distance_name(focus))),
        Some(shown.words.clone()),
        Some(format!("PSF model {}", subject.model.id())),
    ];
    let text = PageText {
        title: format!("PSFs of {}", subject.name),
        facts: known.into_iter().flatten().collect(),
        caption: "The frame, with enlarged PSFs at their places along spokes around the optical axis (cross). \
                  Click a PSF, or focus the picture and press the arrow keys, to choose one. The bar is in pixels of the frame."
            .to_owned(),
        sections: String::new(),
        made: format!(
            "{} PSFs of {side} × {side} px, computed from the lens profile at {}, {} and {} of the field; \
             8 bits a colour, square root of light. The azimuth turns in steps of {}°.",
            tiles.len(),
            counted(distances.len(), "distance"),
            counted(stops.len(), "stop"),
            counted(places.len(), "place"),
            azimuth_step_deg(symmetry)
        ),
    };
    let data = LensData {
        kind: "lens",
        frame: [frame.width_px(), frame.height_px()],
        axis: [frame.axis().x_px, frame.axis().y_px],
        distances: distances.iter().map(|d| distance_name(*d)).collect(),
        start_distance,
        stops: stops.iter().map(|stop| stop.name.clone()).collect(),
        sources: [""],
        polar,
        states,
        atlas: Atlas::new(side, &tiles),
    };
    Ok(page(&text, &data))
}

/// Formats a count with its noun.
fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// Returns the field points of the tiles of a state, in the order of [`Polar`].
fn places(polar: &Polar) -> Vec<FieldPoint> {
    let mut places = vec![FieldPoint::new(0.0, 0.0)];
    for radius in &polar.rings[1..] {
        for degrees in &polar.azimuths {
            let (sin, cos) = degrees.to_radians().sin_cos();
            places.push(FieldPoint::new(radius * cos, radius * sin));
        }
    }
    places
}

/// Returns the distances to show, from far to near: the measured ones of a lens described by moments, and steps from the ends
/// of the measured range to the focus of a lens modelled ray by ray.
fn distances(profile: &LensProfile) -> Vec<ObjectDistance> {
    let Some(channel) = profile.pupil_channels().first() else {
        let planes = profile
            .moments_channels()
            .iter()
            .take(1)
            .flat_map(|c| &c.planes);
        let mut all: Vec<ObjectDistance> = planes.map(|plane| plane.distance).collect();
        all.sort_by(|a, b| {
            let key = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(-1.0);
            key(a).total_cmp(&key(b))
        });
        return all;
    };
    if channel.alpha.degree() == 0 {
        return vec![ObjectDistance::Unknown];
    }
    let (far, near) = channel.measured_vergence;
    let stated = profile.camera.focus_distance.vergence_per_m();
    let focus = stated.or_else(|| PupilChannel::focus_vergence_per_m(channel));
    let focus = focus
        .filter(|v| (far..=near).contains(v))
        .unwrap_or((far + near) / 2.0);
    let step = |from: f64, to: f64, k: usize| from + (to - from) * k as f64 / STEPS_OF_FOCUS as f64;
    let mut vergences: Vec<f64> = (0..STEPS_OF_FOCUS).map(|k| step(far, focus, k)).collect();
    vergences.extend((0..=STEPS_OF_FOCUS).map(|k| step(focus, near, k)));
    vergences.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    vergences.into_iter().map(rounded_distance).collect()
}

/// Returns the distance of vergence `v`, rounded to the three digits that a label shows.
fn rounded_distance(v: f64) -> ObjectDistance {
    if v < 1e-6 {
        return ObjectDistance::Infinity;
    }
    let step = 10.0_f64.powf((1.0 / v).log10().floor() - 2.0);
    let metres = (1.0 / v / step).round() * step;
    // Free of the last digits of binary fractions.
    ObjectDistance::Metres(format!("{metres:.6}").parse().unwrap_or(metres))
}

/// A lens stopped down, and the name of the stop.
struct Stop {
    name: String,
    lens: Lens,
}

/// Returns the lens at its own f-number and stopped down; a lens that cannot be stopped down only as it is.
fn stops(subject: &LensSubject) -> Result<Vec<Stop>> {
    let profile = subject.lens.profile();
    let open = profile
        .camera
        .f_number
        .filter(|_| !profile.pupil_channels().is_empty());
    let Some(open) = open else {
        return Ok(vec![Stop {
            name: "as measured".to_owned(),
            lens: Lens::new(profile.clone())?,
        }]);
    };
    let most = subject.smallest_aperture.unwrap_or(f64::INFINITY).max(open);
    let mut all = Vec::new();
    for share in STOPS {
        let f_number = if share == 1.0 {
            open
        } else {
            (10.0 * open / share.sqrt()).round() / 10.0
        };
        if f_number > most {
            break;
        }
        let controls = Controls {
            f_number: Some(f_number).filter(|n| *n != open),
            ..Controls::default()
        };
        let lens = Lens::new(profile.with_controls(&controls)?)?;
        all.push(Stop {
            name: format!("f/{f_number}"),
            lens,
        });
    }
    Ok(all)
}

/// The drawing of all tiles of one distance at one stop.
struct StateDrawing<'a> {
    lens: &'a Lens,
    model: &'a dyn PsfModel,
    shown: &'a ShownChannels,
    vergence: f64,
    side: usize,
}

/// The blur of a colour, with its displacement from the mean of the colours, px of the frame.
struct PlacedBlur {
    blur: LocalBlur,
    off_px: [f64; 2],
}

impl StateDrawing<'_> {
    /// Returns the width of all tiles in px of the frame, and the light of each.
    fn draw(&self, places: &[FieldPoint]) -> (f64, Vec<Light>) {
        let blurs: Vec<Vec<PlacedBlur>> = places.par_iter().map(|at| self.blurs(*at)).collect();
        let reach = blurs
            .iter()
            .flatten()
            .map(reach_px)
            .fold(LEAST_REACH_PX, f64::max);
        let scale = self.side as f64 / (2.0 * reach);
        let light = blurs
            .par_iter()
            .map(|colours| self.tile(colours, scale))
            .collect();
        (2.0 * reach, light)
    }

    fn blurs(&self, at: FieldPoint) -> Vec<PlacedBlur> {
        let channels = self.shown.indices();
        let placed = channels
            .iter()
            .map(|&channel| self.lens.predictor().blur_at(channel, at, self.vergence));
        let placed: Vec<_> = placed.collect();
        let count = placed.len() as f64;
        let mean = placed.iter().fold([0.0, 0.0], |sum, p| {
            [
                sum[0] + p.displacement_px.0 / count,
                sum[1] + p.displacement_px.1 / count,
            ]
        });
        let relative = placed.into_iter().map(|p| PlacedBlur {
            off_px: [p.displacement_px.0 - mean[0], p.displacement_px.1 - mean[1]],
            blur: p.blur,
        });
        relative.collect()
    }

    fn tile(&self, colours: &[PlacedBlur], scale: f64) -> Light {
        let middle = self.side as f64 / 2.0;
        let planes = colours.iter().map(|colour| {
            let blur = as_dots(&colour.blur.rescaled(scale));
            let [dx, dy] = colour.off_px.map(|off| off * scale);
            let grid = SampleGrid::for_tile(self.side, self.side, middle + dx, middle + dy);
            let mut samples = vec![0.0; grid.len()];
            self.model.sample(&blur, &grid, &mut samples);
            samples
        });
        let planes: Vec<Vec<f64>> = planes.collect();
        let of_colour = |colour: usize| &planes[colour.min(planes.len() - 1)];
        (0..self.side * self.side)
            .map(|k| [of_colour(0)[k], of_colour(1)[k], of_colour(2)[k]])
            .collect()
    }
}

/// Returns the radius of a tile that shows the PSF, px of the frame.
fn reach_px(placed: &PlacedBlur) -> f64 {
    let m = placed.blur.moments;
    let widest = (m.trace() - m.least_variance()).max(1e-6).sqrt();
    let third = [m.mu30, m.mu21, m.mu12, m.mu03].map(f64::abs);
    let skew = third.into_iter().fold(0.0, f64::max) / widest.powi(3);
    // Small PSFs have the tails of a Gaussian, discs have none.
    let tail = TAIL_SIGMAS * (-widest / TAIL_PX).exp();
    let sigmas = SHOWN_SIGMAS * (1.0 + 0.5 * skew.min(1.0)) + tail;
    sigmas * widest + placed.off_px[0].hypot(placed.off_px[1])
}

/// Returns `blur`, in px of a tile, widened by [`DOT_VARIANCE_PX2`], so that one far below a pixel still shows as a dot.
fn as_dots(blur: &LocalBlur) -> LocalBlur {
    let blur = blur.with_least_variance(0.0);
    LocalBlur {
        moments: blur.moments.with_added_variance(DOT_VARIANCE_PX2),
        pupil: blur.pupil.map(|pupil| pupil.blurred_by(DOT_VARIANCE_PX2)),
        ..blur
    }
}
