//! Lenses fitted to PSFs, beside the neighbouring PSFs and their principal components.

use std::path::PathBuf;

use seidel_core::{
    FitSettings, ImagePoint, Lens, LibraryLens, ObjectDistance, Observation, ObservationSet,
    Result, Tile, fit, no_progress,
};
use seidel_image_io::observation_set::{self, ReadOptions};
use seidel_optics::numeric::SplitMix64;
use seidel_optics::predict::predict_set;

use crate::Extent;
use crate::page::{Case, Job};
use crate::removal::green_alone;

/// Lenses of the library, whose PSFs are drawn with noise.
const LIBRARY: [&str; 3] = ["modern-50", "anamorphic-75", "swirl-58"];
/// Sets of real and ray-traced PSFs, which others made: folders of `psf` in the folder that `SEIDEL_DATA` names.
const MEASURED: [&str; 6] = [
    "prime50",
    "wide35",
    "tilt55",
    "ana-front-31",
    "phone",
    "optiland-us8879901",
];
/// Columns and rows of drawn PSFs, the side of their tiles, px, and their noise, shares of the peak.
const GRID: [usize; 2] = [12, 8];
const QUICK_GRID: [usize; 2] = [6, 4];
const TILE_PX: usize = 41;
const NOISE: f64 = 0.005;
/// Neighbours that are averaged.
const NEIGHBOURS: usize = 4;

/// Measures all cases.
pub(crate) fn job(extent: Extent) -> Result<Job> {
    let mut cases = Vec::new();
    for name in &LIBRARY[..if extent == Extent::Quick {
        1
    } else {
        LIBRARY.len()
    }] {
        let exact = drawn(
            name,
            if extent == Extent::Quick {
                QUICK_GRID
            } else {
                GRID
            },
        )?;
        let noisy = with_noise(&exact)?;
        cases.push(case(&format!("`library:{name}`, drawn"), &noisy, &exact)?);
    }
    let measured = if extent == Extent::Quick {
        &[][..]
    } else {
        &MEASURED[..]
    };
    for name in measured {
        let Some(folder) = std::env::var_os("SEIDEL_DATA").map(PathBuf::from) else {
            eprintln!("SKIPPED: {name} (set SEIDEL_DATA)");
            continue;
        };
        match observation_set::read(&folder.join("psf").join(name), ReadOptions::default()) {
            Ok(loaded) => cases.push(case(&format!("`{name}`"), &loaded.set, &loaded.set)?),
            Err(error) => eprintln!("SKIPPED: {error}"),
        }
    }
    Ok(Job {
        title: "Predict PSFs between those measured",
        text: format!(
            "Every second PSF of a set is fitted, the others are predicted. Signal-to-noise ratio of the predicted tiles, mean over \
             tiles. Neighbours: the {NEIGHBOURS} nearest fitted PSFs of the same distance, weighted by 1 / distance."
        ),
        rivals: &["neighbours", "mean PSF"],
        cases,
    })
}

/// Returns `grid` columns and rows of green PSFs of a lens of the library, at its focus and nearer.
fn drawn(name: &str, grid: [usize; 2]) -> Result<ObservationSet> {
    let lens = green_alone(LibraryLens::by_name(name)?.profile()?)?;
    let profile = lens.profile();
    let channels = lens.predictor().channel_names().to_vec();
    let focus = profile
        .camera
        .focus_distance
        .vergence_per_m()
        .map_or(2.0, |v| 1.0 / v);
    let [width, height] = [profile.frame.width_px(), profile.frame.height_px()].map(f64::from);
    let mut set = ObservationSet {
        axis_stated: true,
        pixel_pitch_um: profile.pixel_pitch_um,
        camera: profile.camera.clone(),
        ..ObservationSet::new(profile.frame, channels.clone(), Vec::new())
    };
    for metres in [focus, 0.93 * focus] {
        for k in 0..grid[0] * grid[1] {
            let [column, row] = [k % grid[0], k / grid[0]].map(|i| i as f64 + 0.5);
            let at = ImagePoint::new(
                width * column / grid[0] as f64,
                height * row / grid[1] as f64,
            );
            let distance = ObjectDistance::metres(metres)?;
            let tiles = lens.psf_at(at, distance, TILE_PX, None)?;
            set.observations.push(Observation::new(
                format!("{metres} m, {k}"),
                at,
                distance,
                tiles,
            ));
        }
    }
    Ok(set)
}

/// Returns `set` with noise of [`NOISE`].
fn with_noise(set: &ObservationSet) -> Result<ObservationSet> {
    let mut random = SplitMix64::new(3);
    // The sum of four even variables is nearly normal, with a variance of a third.
    let mut normal = || 3.0_f64.sqrt() * ((0..4).map(|_| random.unit()).sum::<f64>() - 2.0);
    let mut noisy = set.clone();
    for tile in noisy.observations.iter_mut().flat_map(|o| &mut o.tiles) {
        let peak = tile.samples().iter().copied().fold(0.0, f32::max);
        let samples = tile.samples().iter();
        let samples = samples
            .map(|s| s + (NOISE * normal()) as f32 * peak)
            .collect();
        *tile = Tile::new(tile.width(), tile.height(), samples)?;
    }
    Ok(noisy)
}

/// Fits every second PSF of `set` and scores predictions of the others, at the positions of `placed`.
fn case(name: &str, set: &ObservationSet, placed: &ObservationSet) -> Result<Case> {
    let part = |set: &ObservationSet, of: usize| {
        let chosen = set
            .observations
            .iter()
            .enumerate()
            .filter(move |(k, _)| k % 2 == of);
        let observations = chosen.map(|(_, observation)| observation.clone()).collect();
        ObservationSet {
            observations,
            ..set.clone()
        }
    };
    let (fitted, held_out) = (part(set, 0), part(set, 1));
    let lens = fit(
        std::slice::from_ref(&fitted),
        &FitSettings::default(),
        &no_progress,
    )?
    .into_lens();
    let lens = Lens::new(lens)?;
    let predicted = predict_set(
        lens.predictor(),
        &part(placed, 1),
        lens.predictor().default_model(),
    )?;
    let mut sums = [0.0; 3];
    let mut count = 0.0;
    for (observed, predicted) in held_out.observations.iter().zip(&predicted.observations) {
        let mut near: Vec<(f64, &Observation)> = (fitted.observations.iter())
            .filter(|other| other.distance == observed.distance)
            .map(|other| {
                (
                    (other.centre.x_px - observed.centre.x_px)
                        .hypot(other.centre.y_px - observed.centre.y_px),
                    other,
                )
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (channel, tile) in observed.tiles.iter().enumerate() {
            let same = |o: &&(f64, &Observation)| {
                o.1.tiles[channel].samples().len() == tile.samples().len()
            };
            let near: Vec<&(f64, &Observation)> = near.iter().filter(same).collect();
            let mean = |count: usize, weight: fn(f64) -> f64| {
                let mut sum = vec![0.0; tile.samples().len()];
                for (distance, other) in near.iter().take(count) {
                    let weight = weight(*distance) / other.tiles[channel].sum();
                    let samples = other.tiles[channel].samples().iter();
                    sum.iter_mut()
                        .zip(samples)
                        .for_each(|(sum, s)| *sum += weight * f64::from(*s));
                }
                sum
            };
            let own = predicted.tiles[channel]
                .samples()
                .iter()
                .map(|s| f64::from(*s))
                .collect();
            let all = [
                own,
                mean(NEIGHBOURS, |d| 1.0 / d.max(1.0)),
                mean(near.len(), |_| 1.0),
            ];
            sums.iter_mut()
                .zip(all)
                .for_each(|(sum, other)| *sum += snr(tile, &other));
            count += 1.0;
        }
    }
    let [ours, rivals @ ..] = sums.map(|sum| sum / count);
    Ok(Case {
        name: name.to_owned(),
        ours,
        rivals: rivals.to_vec(),
    })
}

/// Returns the signal-to-noise ratio of `predicted`, scaled to the light of `observed`, dB.
fn snr(observed: &Tile, predicted: &[f64]) -> f64 {
    let observed = observed.samples().iter().map(|s| f64::from(*s));
    let (mut cross, mut power) = (0.0, 0.0);
    for (o, p) in observed.clone().zip(predicted) {
        cross += o * p;
        power += p * p;
    }
    let gain = cross / power.max(f64::MIN_POSITIVE);
    let (mut signal, mut error) = (0.0, 0.0);
    for (o, p) in observed.zip(predicted) {
        signal += o * o;
        error += (o - gain * p).powi(2);
    }
    10.0 * (signal / error.max(f64::MIN_POSITIVE)).log10()
}
