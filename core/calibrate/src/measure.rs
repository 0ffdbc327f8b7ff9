//! Moments of observed tiles, with their noise and field position.

use rayon::prelude::*;

use crate::reference_channel::reference_channel;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::support::{Support, TilePixels};
use seidel_optics::moments::{CentralMoments, FourthMoments};
use seidel_optics::observations::ObservationSet;

/// Variance of a PSF along x or y, px², below which its pixels do not tell its centroid. A disc of this variance has its
/// centroid off by up to 0.02 px; light that falls into a single pixel, by up to half a pixel.
const MIN_VARIANCE_PX2: f64 = 0.5;

/// Mean light along a border of a tile, relative to its peak, above which the tile cuts the PSF. Whole PSFs reach 0.02.
const MAX_LIGHT_AT_BORDER: f64 = 0.1;
/// Standard errors of that mean that are taken for noise.
const NOISE_AT_BORDER: f64 = 3.0;

/// A tile excluded from a fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rejection {
    /// Index of the observation set among those given.
    pub set: usize,
    /// Index of the observation in its set.
    pub observation: usize,
    /// The observation's file.
    pub file: String,
    /// Channel name.
    pub channel: String,
    /// Reason, in words.
    pub reason: String,
}

/// Moments of one channel of one observation.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredTile {
    /// Index of the observation set.
    pub set: usize,
    /// Index of the observation in its set.
    pub observation: usize,
    /// The observation's file.
    pub file: String,
    /// Index of the channel.
    pub channel: usize,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Frame position of the centroid.
    pub centroid: ImagePoint,
    /// Ideal image point (without distortion), where known.
    pub ideal: Option<ImagePoint>,
    /// Image point from which the displacement counts: the ideal one; if no observation has one, the centroid of the
    /// channel of middle wavelength, so that at least the displacement between channels is known.
    pub origin: Option<ImagePoint>,
    /// Central moments before pixel integration, px² and px³.
    pub optical: CentralMoments,
    /// Fourth central moments before pixel integration, px⁴.
    pub fourth: FourthMoments,
    /// Whether `centroid` was placed by a fitted lens instead of by pixels.
    pub is_registered: bool,
    /// Whether the pixels are those of one colour of a mosaic, which show the centroid only roughly.
    pub is_mosaic: bool,
    /// Standard deviations of the seven moments from pixel noise; zero where the noise is unknown.
    pub noise: [f64; 7],
}

/// Variance of the finest image detail, px². Chosen by forward-blur SNR near focus: values from 2 up are
/// equivalent, and values below 1 lose up to 0.8 dB.
const DETAIL_VARIANCE_PX2: f64 = 2.0;

impl MeasuredTile {
    /// Returns whether the PSF is too narrow for its pixels to tell its centroid.
    pub(crate) fn centroid_is_unknown(&self) -> bool {
        self.is_mosaic || self.optical.mu20.min(self.optical.mu02) < MIN_VARIANCE_PX2
    }

    /// Returns the field position of the ideal image point where known, and of the centroid otherwise. The
    /// model is polynomial in the ideal position.
    pub fn field_point(&self, frame: &Frame) -> FieldPoint {
        frame.field_point(self.ideal.unwrap_or(self.centroid))
    }

    /// Returns the size (px) to which moment residuals are relative: the root of the trace plus that of the
    /// finest image detail. For PSFs of a pixel or less the residual counts in absolute terms.
    pub fn size_px(&self) -> f64 {
        (self.optical.trace().max(0.0) + 2.0 * DETAIL_VARIANCE_PX2).sqrt()
    }
}

/// Measures the moments of every tile of every set, and adds excluded tiles to `rejected`.
pub fn measure(
    sets: &[ObservationSet],
    support: Support,
    rejected: &mut Vec<Rejection>,
) -> Vec<MeasuredTile> {
    let jobs: Vec<(usize, usize, usize)> = sets
        .iter()
        .enumerate()
        .flat_map(|(set, s)| {
            (0..s.observations.len())
                .flat_map(move |o| (0..s.channels.len()).map(move |c| (set, o, c)))
        })
        .collect();
    let measured: Vec<Result<MeasuredTile, Rejection>> = jobs
        .into_par_iter()
        .map(|(set, observation, channel)| measure_one(sets, set, observation, channel, support))
        .collect();
    let mut tiles = Vec::with_capacity(measured.len());
    for result in measured {
        match result {
            Ok(tile) => tiles.push(tile),
            Err(rejection) => rejected.push(rejection),
        }
    }
    if tiles.iter().all(|tile| tile.ideal.is_none()) {
        set_origins(sets, &mut tiles);
    }
    tiles
}

/// Sets the origin of every tile to the centroid of its observation in the reference channel.
pub(crate) fn set_origins(sets: &[ObservationSet], tiles: &mut [MeasuredTile]) {
    let references: Vec<usize> = (sets.iter())
        .map(|set| reference_channel(&set.camera, set.channels.iter().map(String::as_str)))
        .collect();
    for observation in tiles.chunk_by_mut(|a, b| (a.set, a.observation) == (b.set, b.observation)) {
        let reference = references[observation[0].set];
        let origin = (observation.iter())
            .find(|t| t.channel == reference && (t.is_registered || !t.centroid_is_unknown()))
            .map(|t| t.centroid);
        if observation.len() > 1 {
            observation.iter_mut().for_each(|t| t.origin = origin);
        }
    }
}

/// Returns the mean light along the brightest border of the counted pixels beyond their noise, relative to their peak.
fn light_at_border(pixels: &TilePixels) -> f64 {
    let (width, height) = (pixels.tile.width(), pixels.tile.height());
    // Every second row and column of a mosaic may hold no pixel of a colour.
    let depth = if pixels.counted.is_some() { 2 } else { 1 };
    let mut peak = f64::MIN_POSITIVE;
    let mut borders = [(0.0, 0.0); 4];
    for (index, sample) in pixels.tile.samples().iter().enumerate() {
        if pixels.counted.is_some_and(|counted| !counted[index]) {
            continue;
        }
        let (x, y, sample) = (index % width, index / width, f64::from(*sample));
        peak = peak.max(sample);
        let lies_at = [
            y < depth,
            y + depth >= height,
            x < depth,
            x + depth >= width,
        ];
        for ((sum, count), _) in borders.iter_mut().zip(lies_at).filter(|(_, lies)| *lies) {
            *sum += sample;
            *count += 1.0;
        }
    }
    let sigma = pixels.noise_sigma.unwrap_or(0.0);
    let lit = borders.into_iter().filter(|(_, count)| *count > 0.0);
    let means = lit.map(|(sum, count)| sum / count - NOISE_AT_BORDER * sigma / count.sqrt());
    means.fold(0.0, f64::max) / peak
}

fn measure_one(
    sets: &[ObservationSet],
    set: usize,
    index: usize,
    channel: usize,
    support: Support,
) -> Result<MeasuredTile, Rejection> {
    let observation = &sets[set].observations[index];
    let reject = |reason: &str| Rejection {
        set,
        observation: index,
        file: observation.file.clone(),
        channel: sets[set].channels[channel].clone(),
        reason: reason.to_owned(),
    };
    if observation.saturated {
        return Err(reject("marked saturated, so clipping biases its moments"));
    }
    let light = observation.light(channel);
    let sigma = observation.noise_sigma[channel];
    let counted = sets[set].counted(observation, channel);
    let pixels = TilePixels {
        tile: &light,
        counted: counted.as_deref(),
        noise_sigma: sigma,
    };
    let at_border = light_at_border(&pixels);
    if at_border > MAX_LIGHT_AT_BORDER {
        return Err(reject(&format!(
            "the tile cuts the PSF: along one border its light is {:.0} % of its peak. Cut larger tiles",
            100.0 * at_border
        )));
    }
    let (plain, mask) = pixels
        .moments(support)
        .ok_or_else(|| reject("holds no light above its noise"))?;
    let noise = match sigma {
        Some(sigma) if sigma > 0.0 => {
            let gain = observation.gain.unwrap_or(0.0);
            plain.photon_noise(&light, mask.as_deref(), sigma, gain)
        }
        _ => [0.0; 7],
    };
    let measured =
        (observation.measurement.as_ref()).and_then(|m| m.channels.get(channel)?.as_ref());
    let centroid = measured.map(|m| m.centroid);
    let optical = plain.without_pixel_area();
    Ok(MeasuredTile {
        set,
        observation: index,
        file: observation.file.clone(),
        channel,
        distance: observation.distance,
        centroid: centroid
            .unwrap_or_else(|| observation.frame_point(plain.centroid_x, plain.centroid_y)),
        ideal: observation.ideal,
        origin: observation.ideal,
        optical: optical.central,
        fourth: optical.fourth,
        is_registered: false,
        is_mosaic: sets[set].mosaic.is_some(),
        noise,
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use seidel_optics::mosaic::Mosaic;
    use seidel_optics::observations::Observation;
    use seidel_optics::tile::Tile;

    /// Returns a set of discs with `radius`, in tiles of 15 px, at `places` of a frame of 1000 x 600 px, at infinity and at 2 m in
    /// turn.
    pub(crate) fn discs(radius: f64, places: &[[f64; 2]]) -> ObservationSet {
        let frame = Frame::new(1000, 600, None).expect("a frame");
        let samples = (0..225).map(|k| {
            let (x, y) = (f64::from(k % 15) - 7.0, f64::from(k / 15) - 7.0);
            if x.hypot(y) <= radius { 1.0 } else { 0.0 }
        });
        let tile = Tile::new(15, 15, samples.collect()).expect("light");
        let observations = places.iter().enumerate().map(|(k, [x, y])| {
            let at = ImagePoint::new(*x, *y);
            let distance = [ObjectDistance::Infinity, ObjectDistance::Metres(2.0)][k % 2];
            Observation::new(format!("{k}"), at, distance, vec![tile.clone()])
        });
        ObservationSet::new(frame, vec!["Y".into()], observations.collect())
    }

    #[test]
    fn tiles_that_cut_their_psf_are_rejected() {
        for (radius, cut) in [(6.0, false), (9.0, true)] {
            let mut rejected = Vec::new();
            let set = discs(radius, &[[300.5, 200.5]]);
            let measured = measure(&[set], Support::AllPixels, &mut rejected);
            assert_eq!(measured.is_empty(), cut, "{radius}");
            let named = rejected
                .iter()
                .all(|r| r.file == "0" && r.reason.contains("cuts the PSF"));
            assert!(named && rejected.len() == usize::from(cut), "{rejected:?}");
        }
    }

    #[test]
    fn noise_at_a_border_does_not_cut_a_psf() {
        let mut set = discs(6.0, &[[300.5, 200.5]]);
        let mut samples = set.observations[0].tiles[0].samples().to_vec();
        // Light of a cut PSF, or noise of a fifth of the peak.
        samples[..15].fill(0.15);
        set.observations[0].tiles[0] = Tile::new(15, 15, samples).expect("light");
        let is_cut = |set: &ObservationSet| {
            measure(
                std::slice::from_ref(set),
                Support::AllPixels,
                &mut Vec::new(),
            )
            .is_empty()
        };
        assert!(is_cut(&set));
        set.observations[0].noise_sigma[0] = Some(0.2);
        assert!(!is_cut(&set));
    }

    #[test]
    fn pixels_of_other_colours_do_not_cut_a_psf() {
        let mut set = discs(6.0, &[[300.5, 200.5]]);
        set.channels = vec!["G".into()];
        set.mosaic = Some(Mosaic::parse("RGGB").expect("a mosaic"));
        let counted = set.counted(&set.observations[0], 0).expect("a mosaic");
        let mut samples = set.observations[0].tiles[0].samples().to_vec();
        for (sample, _) in samples.iter_mut().zip(counted).filter(|(_, of_g)| !of_g) {
            *sample += 0.5;
        }
        set.observations[0].tiles[0] = Tile::new(15, 15, samples).expect("light");
        let measured = measure(&[set], Support::AllPixels, &mut Vec::new());
        assert_eq!(measured.len(), 1);
    }
}
