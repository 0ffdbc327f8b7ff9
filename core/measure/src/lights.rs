//! Lights of photographs: the steps from pixels to tiles.

mod candidate;
mod judgement;
mod outliers;
mod repeats;
mod shade;

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::mosaic::Mosaic;
use seidel_optics::observations::{ChannelMeasurement, Measurement, Observation, ObservationSet};
use seidel_optics::tile::Tile;

use crate::background::Background;
use crate::calibration::{Calibration, check_alike};
use crate::checks::{self, Concern};
use crate::detection::{Filtered, Peak, Signal};
use crate::photograph::Photograph;
use crate::profile_fit::Profile;
use crate::rejection::{LeftOut, Reason};
use candidate::Scene;
use repeats::reject_moved;
use seidel_optics::numeric::quantile;

/// Settings of [`measure_lights`].
#[derive(Debug, Clone, PartialEq)]
pub struct LightSettings {
    /// Size of the tiles.
    pub tile: TileSize,
    /// Signal over noise of the matched filter from which on there is a light.
    pub detection_snr: f64,
    /// Flux over its noise, in the reference channel, that a light needs.
    pub min_snr: f64,
    /// Numbers of lights to leave out.
    pub leave_out: Vec<usize>,
    /// Numbers of lights to keep in spite of the checks.
    pub keep: Vec<usize>,
}

impl Default for LightSettings {
    fn default() -> Self {
        Self {
            tile: TileSize::Auto,
            detection_snr: 8.0,
            min_snr: 25.0,
            leave_out: Vec::new(),
            keep: Vec::new(),
        }
    }
}

/// Size of the tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TileSize {
    /// As wide as the lights need.
    Auto,
    /// A width and height in pixels.
    Pixels(usize),
}

impl TileSize {
    /// Sizes of tiles that can be asked for, px.
    pub const RANGE: std::ops::RangeInclusive<usize> = 7..=1023;
}

/// A light that was measured.
#[derive(Debug, Clone)]
pub struct MeasuredLight {
    /// Index of the photograph.
    pub photograph: usize,
    /// Number among all lights that were found, from top to bottom, photograph after photograph.
    pub number: usize,
    /// Column and row of the tile's top-left pixel.
    pub corner: (usize, usize),
    /// Columns and rows of the tile.
    pub size: (usize, usize),
    /// Pixels of the tile to use; all if `None`.
    pub mask: Option<Vec<bool>>,
    /// Background by channel in the middle of the tile, counts.
    pub background: Vec<f64>,
    /// Slope of the background by channel along x and y, counts per pixel; zero where it is lost in the noise.
    pub slope: Vec<[f64; 2]>,
    /// Standard deviation of a dark pixel by channel, counts.
    pub noise_sigma: Vec<f64>,
    /// Fitted profile by channel, in frame pixels; `None` where the channel is too faint.
    pub profiles: Vec<Option<Profile>>,
    /// Index of the reference channel.
    pub reference: usize,
}

impl MeasuredLight {
    /// Returns the frame position in the reference channel.
    pub fn place(&self) -> [f64; 2] {
        match &self.profiles[self.reference] {
            Some(profile) => profile.centroid,
            None => [
                self.corner.0 as f64 + self.size.0 as f64 / 2.0,
                self.corner.1 as f64 + self.size.1 as f64 / 2.0,
            ],
        }
    }

    /// Returns the standard deviation of [`MeasuredLight::place`], px.
    pub fn place_sigma(&self) -> f64 {
        let profile = self.profiles[self.reference].as_ref();
        profile.map_or(1.0, |p| p.centroid_sigma)
    }
}

/// The lights of one or more photographs.
#[derive(Debug, Clone)]
pub struct LightSet {
    /// The photographs, after dark and flat frames.
    pub photographs: Vec<Photograph>,
    /// Lights that were kept, by photograph and from top to bottom.
    pub lights: Vec<MeasuredLight>,
    /// Lights that were left out.
    pub left_out: Vec<LeftOut>,
    /// Hot pixels of each photograph.
    pub hot_pixels: Vec<usize>,
    /// Counts per electron, if a file states it.
    pub gain: Option<f64>,
    /// Width of a tile away from the borders, px.
    pub tile_px: usize,
    /// Response of the channels to the lights, relative to the reference channel.
    pub response: Vec<f64>,
    /// Faults of the photographs.
    pub concerns: Vec<Concern>,
    /// Limits of the result.
    pub warnings: Vec<String>,
}

/// Standard deviation of the first matched filter, px.
const FIRST_FILTER_PX: f32 = 1.6;
/// Lights whose extent decides the matched filter and the size of tiles.
const EXTENT_LIGHTS: usize = 60;
/// Share of the peak down to which a light extends.
const EXTENT_SHARE: f32 = 0.02;
/// Least level of the extent of a light, standard deviations of the filtered noise.
const EXTENT_SIGMAS: f32 = 5.0;
/// Extent of a light over that which a Gaussian of the same core has: PSFs have wider tails, noise has no end.
const MAX_TAIL: f64 = 1.3;
/// Largest extent that is followed, px.
const MAX_EXTENT_PX: usize = 160;
/// Radius of a tile over the extent of the lights, and its least value in px.
const TILE_OVER_EXTENT: f64 = 1.5;
const MIN_TILE_RADIUS_PX: f64 = 7.0;
/// Standard deviations below the background that an observation set allows.
const NEGATIVE_SIGMAS: f64 = 12.0;
/// Standard deviation below which PSFs are undersampled, px.
const UNRESOLVED_SIGMA_PX: f64 = 0.55;

/// Measures the lights of `photographs`, of one camera.
///
/// # Errors
/// Photographs that differ in size or mosaic; no light found; no light kept, with the counts of the reasons.
pub fn measure_lights(
    mut photographs: Vec<Photograph>,
    calibration: &Calibration,
    settings: &LightSettings,
) -> Result<LightSet> {
    let Some(first) = photographs.first() else {
        return Err(Error::new("photographs", "none given", "give at least one"));
    };
    for photo in &photographs {
        photo.check()?;
        check_alike(first, photo)?;
    }
    for photo in &mut photographs {
        calibration.apply(photo)?;
    }
    let mut found: Vec<Found> = photographs
        .iter()
        .map(|p| Found::new(p, settings))
        .collect();
    check_found(&photographs, &found)?;
    let radius = match settings.tile {
        TileSize::Pixels(side) => side as f64 / 2.0,
        TileSize::Auto => {
            let extents = found.iter().map(|f| f.extent_px);
            let widest = extents.fold(0.0, f64::max);
            (TILE_OVER_EXTENT * widest + 3.0).max(MIN_TILE_RADIUS_PX)
        }
    };
    let tile_px = match settings.tile {
        TileSize::Pixels(side) => side,
        TileSize::Auto => 2 * radius.ceil() as usize + 1,
    };
    let numbers = numbered(&found);
    check_numbers(settings, numbers.iter().map(Vec::len).sum())?;
    let mut left_out = Vec::new();
    let gain = photographs.iter().find_map(|p| p.gain);
    let mut groups: Vec<Vec<MeasuredLight>> = Vec::new();
    for (index, photo) in photographs.iter().enumerate() {
        let scene = Scene {
            index,
            photo,
            found: &found[index],
            calibration,
            tile_px,
            gain: photo.assumed_gain(),
            settings,
            numbers: &numbers[index],
        };
        let mut lights = scene.measure(&mut left_out);
        outliers::reject(photo, &mut lights, &settings.keep, &mut left_out);
        groups.push(lights);
    }
    let mut distances: Vec<ObjectDistance> = Vec::new();
    for photo in &photographs {
        if !distances.contains(&photo.distance) {
            distances.push(photo.distance);
        }
    }
    for distance in distances {
        let same = groups.iter_mut().zip(&photographs);
        let mut same: Vec<&mut Vec<MeasuredLight>> = same
            .filter_map(|(group, photo)| (photo.distance == distance).then_some(group))
            .collect();
        reject_moved(&mut same, &settings.keep, &mut left_out);
    }
    let lights: Vec<MeasuredLight> = groups.into_iter().flatten().collect();
    let response = std::mem::take(&mut found[0].signal.response);
    let hot_pixels = (found.iter())
        .map(|f| f.signal.hot.iter().flatten().filter(|h| **h).count())
        .collect();
    let mut set = LightSet {
        photographs,
        lights,
        left_out,
        hot_pixels,
        gain,
        tile_px,
        response,
        concerns: Vec::new(),
        warnings: Vec::new(),
    };
    set.leave_out_faults()?;
    set.left_out.sort_by(|a, b| {
        (a.photograph, a.why)
            .cmp(&(b.photograph, b.why))
            .then(a.y.total_cmp(&b.y))
            .then(a.x.total_cmp(&b.x))
    });
    if set.lights.is_empty() {
        let none = none_kept(&set.left_out);
        let photographs = set.photographs.iter().zip(&found);
        let mut processed =
            photographs.filter_map(|(photo, found)| judgement::processed(photo, found));
        return Err(match processed.next() {
            Some(Concern { error, .. }) => {
                let problem = format!("{}; {}", error.problem, none.problem);
                Error::new(error.place, problem, error.remedy).with_kind(none.kind())
            }
            None => none,
        });
    }
    set.concerns = judgement::concerns(&set, &found);
    set.add_warnings();
    Ok(set)
}

/// Returns the smallest light of observation `index` that counts, in any channel, over the noise of a pixel.
fn darkest_over_noise(set: &ObservationSet, index: usize) -> f64 {
    let observation = &set.observations[index];
    let of_channel = |channel: usize| {
        let counted = set.counted(observation, channel);
        let light = observation.light(channel);
        let pixels = light.samples().iter().enumerate();
        let used = pixels.filter(|(k, _)| counted.as_ref().is_none_or(|c| c[*k]));
        let lowest = used.fold(f32::INFINITY, |lowest, (_, v)| lowest.min(*v));
        let noise = observation.noise_sigma[channel].unwrap_or(1.0);
        f64::from(lowest) / noise.max(f64::MIN_POSITIVE)
    };
    (0..set.channels.len())
        .map(of_channel)
        .fold(f64::INFINITY, f64::min)
}

/// Returns the number of every peak of every photograph: from top to bottom, photograph after photograph.
fn numbered(found: &[Found]) -> Vec<Vec<usize>> {
    let mut first = 0;
    let of = |found: &Found| {
        let mut order: Vec<usize> = (0..found.peaks.len()).collect();
        order.sort_by_key(|k| (found.peaks[*k].y, found.peaks[*k].x));
        let mut numbers = vec![0; order.len()];
        for (rank, k) in order.into_iter().enumerate() {
            numbers[k] = first + rank;
        }
        first += numbers.len();
        numbers
    };
    found.iter().map(of).collect()
}

fn check_numbers(settings: &LightSettings, count: usize) -> Result<()> {
    for (field, numbers) in [("leave_out", &settings.leave_out), ("keep", &settings.keep)] {
        if let Some(number) = numbers.iter().find(|n| **n >= count) {
            return Err(Error::new(
                field,
                format!("names light {number}, but {count} were found"),
                "give numbers of `left_out.json` or of the files in `psf`, which start at 0",
            ));
        }
    }
    Ok(())
}

/// Lights found in one photograph.
pub(crate) struct Found {
    pub(crate) backgrounds: Vec<Background>,
    pub(crate) signal: Signal,
    pub(crate) peaks: Vec<Peak>,
    /// Distance from its peak at which a typical light has fallen to [`EXTENT_SHARE`], px.
    pub(crate) extent_px: f64,
}

impl Found {
    fn new(photo: &Photograph, settings: &LightSettings) -> Self {
        let backgrounds: Vec<Background> = (0..photo.channels.len())
            .map(|channel| Background::of(photo, channel))
            .collect();
        let signal = Signal::new(photo, &backgrounds);
        let min_snr = settings.detection_snr as f32;
        let mut filter_px = FIRST_FILTER_PX;
        let (mut filtered, mut peaks, mut extent_px);
        loop {
            filtered = signal.filter(filter_px);
            let radius = (1.25 * filter_px).round().max(2.0) as usize;
            peaks = filtered.peaks(radius, min_snr);
            extent_px = typical_extent(photo, &filtered, &peaks);
            // A Gaussian falls to one fiftieth at 2.8 standard deviations, those of the light and the filter together.
            let wanted = 0.5 * (extent_px / 2.8) as f32;
            if wanted < 1.5 * filter_px {
                break;
            }
            filter_px = wanted;
        }
        Self {
            backgrounds,
            signal,
            peaks,
            extent_px,
        }
    }
}

/// Returns the extent of a typical light among the brightest that are not clipped.
fn typical_extent(photo: &Photograph, filtered: &Filtered, peaks: &[Peak]) -> f64 {
    let sound = peaks.iter().filter(|p| !photo.is_clipped(p.x, p.y));
    let mut extents: Vec<f64> = sound
        .take(EXTENT_LIGHTS)
        .filter(|p| p.snr > 50.0)
        .map(|p| extent_in_noise(filtered, p))
        .collect();
    if extents.is_empty() {
        let some = peaks.iter().take(EXTENT_LIGHTS);
        extents = some
            .map(|p| filtered.extent(p, 0.2, MAX_EXTENT_PX))
            .collect();
    }
    // Lights that touch others extend farther, so not the mean.
    quantile(&mut extents, 0.5)
}

/// Returns the extent of a light, limited by that at a level which noise does not reach: along connected noise it has no end.
fn extent_in_noise(filtered: &Filtered, peak: &Peak) -> f64 {
    let share = EXTENT_SHARE.max(EXTENT_SIGMAS / peak.snr);
    // Both levels as those of a Gaussian.
    let wider = f64::from(EXTENT_SHARE.ln() / share.ln()).sqrt();
    let clear = wider * filtered.extent(peak, share, MAX_EXTENT_PX);
    let reached = filtered.extent(peak, EXTENT_SHARE, MAX_EXTENT_PX);
    reached.min(MAX_TAIL * clear)
}

fn check_found(photographs: &[Photograph], found: &[Found]) -> Result<()> {
    for (photo, found) in photographs.iter().zip(found) {
        if found.peaks.is_empty() {
            return Err(Error::new(
                format!("photograph {}", photo.name),
                "shows no light above its noise",
                "expose longer, use brighter lights, or check the black level",
            )
            .with_kind(ErrorKind::InsufficientData));
        }
    }
    Ok(())
}

fn none_kept(left_out: &[LeftOut]) -> Error {
    let counts: Vec<String> = Reason::ALL
        .iter()
        .filter_map(|why| {
            let count = left_out.iter().filter(|l| l.why == *why).count();
            (count > 0).then(|| format!("{count} {why}"))
        })
        .collect();
    let clipped = left_out.iter().filter(|l| l.why == Reason::Clipped).count();
    let remedy = if 2 * clipped > left_out.len() {
        "expose less, so that no light reaches the clipping level"
    } else {
        "photograph single lights, well apart, sharp enough and bright enough, or pinholes in a dark room"
    };
    Error::new(
        "lights",
        format!("none could be kept ({})", counts.join(", ")),
        remedy,
    )
    .with_kind(ErrorKind::InsufficientData)
}

impl LightSet {
    /// Returns the first fault of the photographs for which no lens should be measured.
    pub fn refusal(&self) -> Option<&Error> {
        checks::refusal(&self.concerns)
    }

    fn add_warnings(&mut self) {
        self.warnings
            .extend(self.concerns.iter().map(|c| c.error.to_string()));
        let mut widths: Vec<f64> = (self.lights.iter())
            .filter_map(|l| Some(l.profiles[l.reference].as_ref()?.largest_sigma_px()))
            .collect();
        let width = quantile(&mut widths, 0.5);
        if width < UNRESOLVED_SIGMA_PX {
            self.warnings.push(format!(
                "the lights are not resolved: their standard deviation is {width:.2} px, pixel area included. Pixels this large do not show the shape of the blur."
            ));
        }
    }

    /// Leaves out the lights whose observations a fit would refuse.
    fn leave_out_faults(&mut self) -> Result<()> {
        let set = self.observations(None)?;
        let mut at_fault: Vec<usize> = (set.faults().iter())
            .filter_map(|f| f.observation)
            .collect();
        at_fault.dedup();
        for index in at_fault.into_iter().rev() {
            let light = self.lights.remove(index);
            let [x, y] = light.place();
            self.left_out.push(LeftOut {
                photograph: light.photograph,
                number: Some(light.number),
                x,
                y,
                why: Reason::DarkPixels,
                value: darkest_over_noise(&set, index),
                limit: -NEGATIVE_SIGMAS,
            });
        }
        Ok(())
    }

    /// Returns the observation set of the lights, whose files are named after their numbers, for a frame whose axis is `axis`.
    ///
    /// # Errors
    /// An axis that is not finite.
    pub fn observations(&self, axis: Option<ImagePoint>) -> Result<ObservationSet> {
        let first = &self.photographs[0];
        let size = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
        let frame = Frame::new(size(first.width), size(first.height), axis)?;
        let observations = (self.lights.iter())
            .map(|light| self.observation(light))
            .collect::<Result<_>>()?;
        let mosaic: Option<Mosaic> = first.mosaic;
        Ok(ObservationSet {
            axis_stated: axis.is_some(),
            mosaic,
            ..ObservationSet::new(frame, first.channels.clone(), observations)
        })
    }

    fn observation(&self, light: &MeasuredLight) -> Result<Observation> {
        let photo = &self.photographs[light.photograph];
        let (left, top) = light.corner;
        let (width, height) = light.size;
        let tiles = (0..photo.channels.len())
            .map(|channel| {
                let plane = &photo.planes[photo.plane_of(channel)];
                let pattern = photo.channel_pattern(photo.plane_of(channel));
                let pixels = (0..width * height).map(|k| {
                    let (column, row) = (k % width, k / width);
                    let (x, y) = (left + column, top + row);
                    let colour = pattern[2 * (y % 2) + x % 2];
                    let [across, down] = colour.map_or([0.0; 2], |c| light.slope[c]);
                    let slope = across * (column as f64 + 0.5 - width as f64 / 2.0)
                        + down * (row as f64 + 0.5 - height as f64 / 2.0);
                    plane[y * photo.width + x] - slope as f32
                });
                Tile::new(width, height, pixels.collect())
            })
            .collect::<Result<_>>()?;
        let centre = ImagePoint::new(
            left as f64 + width as f64 / 2.0,
            top as f64 + height as f64 / 2.0,
        );
        let channels = (light.profiles.iter())
            .map(|profile| {
                let p = profile.as_ref()?;
                Some(ChannelMeasurement {
                    centroid: ImagePoint::new(p.centroid[0], p.centroid[1]),
                    centroid_sigma_px: p.centroid_sigma,
                    flux: p.flux,
                    snr: p.flux / p.flux_sigma.max(f64::MIN_POSITIVE),
                })
            })
            .collect();
        let share = checks::added_error(&self.concerns);
        let noise_sigma = light
            .noise_sigma
            .iter()
            .zip(&light.profiles)
            .map(|(sigma, profile)| {
                let model = profile.iter().flat_map(|p| &p.model);
                Some(sigma.hypot(share * model.copied().fold(0.0, f64::max)))
            });
        let file = format!("psf/{:04}.tif", light.number);
        Ok(Observation {
            noise_sigma: noise_sigma.collect(),
            background: light.background.clone(),
            gain: self.gain,
            weight_mask: light.mask.clone(),
            measurement: Some(Measurement {
                source: photo.name.clone(),
                channels,
            }),
            ..Observation::new(file, centre, photo.distance, tiles)
        })
    }
}
