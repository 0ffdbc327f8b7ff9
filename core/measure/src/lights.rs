//! Lights of photographs: the steps from pixels to tiles.

mod candidate;
mod outliers;
mod repeats;

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::mosaic::Mosaic;
use seidel_optics::observations::{ChannelMeasurement, Measurement, Observation, ObservationSet};
use seidel_optics::tile::Tile;

use crate::background::Background;
use crate::calibration::{Calibration, check_alike};
use crate::detection::{Filtered, Peak, Signal};
use crate::photograph::Photograph;
use crate::profile_fit::Profile;
use crate::rejection::{LeftOut, Reason};
use candidate::Scene;
use repeats::reject_moved;
use seidel_optics::numeric::quantile;

/// Settings of [`measure_lights`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSettings {
    /// Size of the tiles.
    pub tile: TileSize,
    /// Signal over noise of the matched filter from which on there is a light.
    pub detection_snr: f64,
    /// Flux over its noise, in the reference channel, that a light needs.
    pub min_snr: f64,
}

impl Default for LightSettings {
    fn default() -> Self {
        Self {
            tile: TileSize::Auto,
            detection_snr: 8.0,
            min_snr: 40.0,
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
    /// Column and row of the tile's top-left pixel.
    pub corner: (usize, usize),
    /// Columns and rows of the tile.
    pub size: (usize, usize),
    /// Pixels of the tile to use; all if `None`.
    pub mask: Option<Vec<bool>>,
    /// Background by channel, counts.
    pub background: Vec<f64>,
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
    /// Limits of the result.
    pub warnings: Vec<String>,
}

/// Standard deviation of the first matched filter, px.
const FIRST_FILTER_PX: f32 = 1.6;
/// Lights whose extent decides the matched filter and the size of tiles.
const EXTENT_LIGHTS: usize = 60;
/// Share of the peak down to which a light extends.
const EXTENT_SHARE: f32 = 0.02;
/// Largest extent that is followed, px.
const MAX_EXTENT_PX: usize = 160;
/// Radius of a tile over the extent of the lights, and its least value in px.
const TILE_OVER_EXTENT: f64 = 1.5;
const MIN_TILE_RADIUS_PX: f64 = 7.0;
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
        };
        let mut lights = scene.measure(&mut left_out);
        outliers::reject(photo, &mut lights, &mut left_out);
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
        reject_moved(&mut same, &mut left_out);
    }
    left_out.sort_by(|a, b| {
        (a.photograph, a.why)
            .cmp(&(b.photograph, b.why))
            .then(a.y.total_cmp(&b.y))
            .then(a.x.total_cmp(&b.x))
    });
    let lights: Vec<MeasuredLight> = groups.into_iter().flatten().collect();
    if lights.is_empty() {
        return Err(none_kept(&left_out));
    }
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
        warnings: Vec::new(),
    };
    set.add_warnings();
    Ok(set)
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
        .map(|p| filtered.extent(p, EXTENT_SHARE, MAX_EXTENT_PX))
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
    fn add_warnings(&mut self) {
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

    /// Returns the observation set of the lights, whose files are named in order, for a frame whose axis is `axis`.
    ///
    /// # Errors
    /// An axis that is not finite.
    pub fn observations(&self, axis: Option<ImagePoint>) -> Result<ObservationSet> {
        let first = &self.photographs[0];
        let size = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
        let frame = Frame::new(size(first.width), size(first.height), axis)?;
        let observations = (self.lights.iter().enumerate())
            .map(|(index, light)| self.observation(index, light))
            .collect::<Result<_>>()?;
        let mosaic: Option<Mosaic> = first.mosaic;
        Ok(ObservationSet {
            axis_stated: axis.is_some(),
            mosaic,
            ..ObservationSet::new(frame, first.channels.clone(), observations)
        })
    }

    fn observation(&self, index: usize, light: &MeasuredLight) -> Result<Observation> {
        let photo = &self.photographs[light.photograph];
        let (left, top) = light.corner;
        let (width, height) = light.size;
        let tiles = (0..photo.channels.len())
            .map(|channel| {
                let plane = &photo.planes[photo.plane_of(channel)];
                let rows = (top..top + height).map(|y| &plane[y * photo.width + left..][..width]);
                Tile::new(width, height, rows.collect::<Vec<_>>().concat())
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
        let file = format!("psf/{index:04}.tif");
        Ok(Observation {
            noise_sigma: light.noise_sigma.iter().copied().map(Some).collect(),
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
