//! Planted blurs come back out of pairs of pictures.

use seidel_optics::no_progress;

use super::*;
use seidel_optics::camera::Camera;
use seidel_optics::error::ErrorKind;
use seidel_optics::lens::VergenceSeries;
use seidel_optics::moments::pixels::{PIXEL_VARIANCE_PX2, TileMoments};
use seidel_optics::numeric::SplitMix64;
use seidel_optics::profile::{LensDescription, Provenance, PupilChannel};

pub(super) const SIZE: (usize, usize) = (420, 300);
pub(super) const SIDE: usize = 21;

/// Variances along x and y at a place, px²: they change over the field.
fn planted(x: f64, y: f64) -> (f64, f64) {
    (2.5 + 1.5 * x / SIZE.0 as f64, 3.0 + 0.8 * y / SIZE.1 as f64)
}

/// A texture of noise with some light of its own.
pub(super) fn texture() -> Vec<f32> {
    let mut random = SplitMix64::new(5);
    (0..SIZE.0 * SIZE.1)
        .map(|_| (0.2 + random.unit()) as f32)
        .collect()
}

/// Every pixel spread by its own Gaussian, then `noise` added.
fn blurred(sharp: &[f32], noise: f64) -> Vec<f32> {
    let (width, height) = SIZE;
    let mut light = vec![0.0_f64; width * height];
    let reach = 10_isize;
    for (k, &value) in sharp.iter().enumerate() {
        let (x, y) = ((k % width) as isize, (k / width) as isize);
        let (vx, vy) = planted(x as f64, y as f64);
        let bell = |variance: f64| -> Vec<f64> {
            let all: Vec<f64> = (-reach..=reach)
                .map(|d| (-((d * d) as f64) / (2.0 * variance)).exp())
                .collect();
            let sum: f64 = all.iter().sum();
            all.iter().map(|v| v / sum).collect()
        };
        let (across, down) = (bell(vx), bell(vy));
        for (dy, wy) in (-reach..=reach).zip(&down) {
            for (dx, wx) in (-reach..=reach).zip(&across) {
                let (tx, ty) = (x + dx, y + dy);
                if (0..width as isize).contains(&tx) && (0..height as isize).contains(&ty) {
                    light[ty as usize * width + tx as usize] += f64::from(value) * wx * wy;
                }
            }
        }
    }
    let mut random = SplitMix64::new(9);
    light
        .iter()
        .map(|v| {
            // Four uniform numbers make a bell of variance 1/3.
            let sum: f64 = (0..4).map(|_| random.unit() - 0.5).sum();
            (v + noise * sum * 3.0_f64.sqrt()) as f32
        })
        .collect()
}

/// A lens without aberrations that blurs every point by `variance`, px², besides the pixel.
pub(super) fn lens(variance: f64) -> LensProfile {
    let constant = VergenceSeries::constant;
    let channel = PupilChannel {
        name: "Y".to_owned(),
        alpha: constant(0.0),
        beta: constant(0.0),
        gamma: constant(0.0),
        delta: constant(0.0),
        phi: constant(0.0),
        blur_variance_px2: constant(variance),
        effects: Vec::new(),
        magnification: constant(0.0),
        distortion: constant(0.0),
        measured_vergence: (0.0, 1.0),
        stop_lever_m: 0.0,
        added: Vec::new(),
        picture: None,
        wavelength_px: 0.0,
    };
    LensProfile {
        frame: Frame::new(SIZE.0 as u32, SIZE.1 as u32, None).expect("a frame"),
        pixel_pitch_um: None,
        camera: Camera::default(),
        description: LensDescription::Pupil(vec![channel]),
        held_out: None,
        provenance: Provenance::default(),
    }
}

pub(super) fn picture(planes: &[Vec<f32>]) -> PairImage<'_> {
    PairImage {
        width: SIZE.0,
        height: SIZE.1,
        planes,
        quantisation: None,
    }
}

/// Estimates PSFs for a lens that is a little sharper than the planted blur.
fn run(sharp: Vec<f32>, plate: Vec<f32>, settings: &PairSettings) -> Result<PairEstimate> {
    let (sharp, plate) = ([sharp], [plate]);
    estimate_pair(
        &lens(2.5),
        &picture(&sharp),
        &picture(&plate),
        settings,
        &no_progress,
    )
}

fn settings() -> PairSettings {
    PairSettings {
        side: SIDE,
        ..PairSettings::default()
    }
}

/// Errors of a set.
#[derive(Debug)]
struct Errors {
    /// Mean and root mean square of relative errors of second moments.
    bias: f64,
    rms: f64,
    /// Largest of centroids, px.
    place: f64,
}

fn errors(set: &ObservationSet, added: f64) -> Errors {
    let (mut all, mut place) = (Vec::new(), 0.0_f64);
    for o in &set.observations {
        let m = TileMoments::plain(&o.tiles[0], None).expect("lit");
        let (vx, vy) = planted(o.centre.x_px, o.centre.y_px);
        for (got, want) in [(m.central.mu20, vx), (m.central.mu02, vy)] {
            all.push(got / (want + added) - 1.0);
        }
        let middle = SIDE as f64 / 2.0;
        let off = (m.centroid_x - middle).hypot(m.centroid_y - middle);
        place = place.max(off);
    }
    let mean = |f: &dyn Fn(f64) -> f64| all.iter().map(|&e| f(e)).sum::<f64>() / all.len() as f64;
    Errors {
        bias: mean(&|e| e),
        rms: mean(&|e| e * e).sqrt(),
        place,
    }
}

#[test]
fn planted_gaussians_return() {
    let sharp = texture();
    let plate = blurred(&sharp, 0.0);
    let found = run(sharp.clone(), plate.clone(), &settings()).expect("detail");
    assert_eq!(found.left_out, 0);
    assert!(found.at_edges.abs() < 0.01, "{}", found.at_edges);
    // What the PSF changes within a patch acts as noise.
    let e = errors(&found.set, 0.0);
    assert!(
        e.bias.abs() < 0.005 && e.rms < 0.03 && e.place < 0.08,
        "{e:?}"
    );
    assert!(found.set.faults().is_empty());
    let areas = PairSettings {
        area_means: true,
        ..settings()
    };
    let found = run(sharp, plate, &areas).expect("detail");
    let e = errors(&found.set, PIXEL_VARIANCE_PX2);
    assert!(e.bias.abs() < 0.005 && e.rms < 0.03, "{e:?}");
}

#[test]
fn noise_of_tiles_is_estimated() {
    let sharp = texture();
    let plain = run(sharp.clone(), blurred(&sharp, 0.0), &settings()).expect("detail");
    let noisy = run(sharp.clone(), blurred(&sharp, 0.003), &settings()).expect("detail");
    let mut shares = Vec::new();
    for (a, b) in plain.set.observations.iter().zip(&noisy.set.observations) {
        let pairs = a.tiles[0].samples().iter().zip(b.tiles[0].samples());
        let square: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let rms = (square / (SIDE * SIDE) as f64).sqrt();
        shares.push(rms / b.noise_sigma[0].expect("an estimate"));
    }
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    assert!((0.5..1.2).contains(&mean), "{mean}");
    // Noise drowns a second moment long before it drowns the PSF.
    let e = errors(&noisy.set, 0.0);
    assert!(e.bias.abs() < 0.02 && e.rms < 0.1 && e.place < 0.1, "{e:?}");
}

#[test]
fn clipped_pixels_take_no_part() {
    let sharp: Vec<f32> = texture().iter().map(|v| 0.55 * v).collect();
    let clip = 0.42;
    let mut plate = blurred(&sharp, 0.0);
    plate.iter_mut().for_each(|v| *v = v.min(clip));
    let clipped = plate.iter().filter(|v| **v >= clip).count();
    assert!(clipped > 5000, "{clipped}");
    // As if the sharp picture had been exposed for less.
    let sharp: Vec<f32> = sharp.iter().map(|v| 0.5 * v).collect();
    let with = PairSettings {
        clip: Some(clip),
        ..settings()
    };
    let found = run(sharp.clone(), plate.clone(), &with).expect("detail");
    let masked = errors(&found.set, 0.0).rms;
    let found = run(sharp, plate, &settings()).expect("detail");
    let trusted = errors(&found.set, 0.0).rms;
    assert!(
        masked < 0.06 && trusted > 5.0 * masked,
        "{masked} {trusted}"
    );
}

#[test]
fn pictures_that_tell_nothing_are_refused() {
    let flat = vec![0.5; SIZE.0 * SIZE.1];
    let error = run(flat.clone(), flat.clone(), &settings()).expect_err("no detail");
    assert!(
        error.problem.contains("detail") && error.remedy.contains("noise"),
        "{error}"
    );
    let mut random = SplitMix64::new(3);
    let grain: Vec<f32> = flat
        .iter()
        .map(|v| v + 0.01 * random.unit() as f32)
        .collect();
    let other: Vec<f32> = flat
        .iter()
        .map(|v| v + 0.01 * random.unit() as f32)
        .collect();
    run(grain, other, &settings()).expect_err("grain of two pictures has nothing in common");
    let large = PairSettings {
        side: 65,
        ..settings()
    };
    let error = run(flat.clone(), flat.clone(), &large).expect_err("too small");
    assert!(error.problem.contains("too small"), "{error}");
    let even = PairSettings {
        side: 20,
        ..settings()
    };
    assert!(run(flat.clone(), flat.clone(), &even).is_err());
}

/// Returns `plane` moved by whole pixels, with its own samples around it.
fn moved(plane: &[f32], by: [isize; 2]) -> Vec<f32> {
    let (width, height) = (SIZE.0 as isize, SIZE.1 as isize);
    let source = |k: usize| {
        let x = (k as isize % width - by[0]).rem_euclid(width);
        let y = (k as isize / width - by[1]).rem_euclid(height);
        plane[(y * width + x) as usize]
    };
    (0..plane.len()).map(source).collect()
}

#[test]
fn a_moved_plate_is_registered() {
    let sharp = texture();
    let plate = blurred(&sharp, 0.001);
    let straight = run(sharp.clone(), plate.clone(), &settings()).expect("detail");
    let [x, y] = straight.pictures.registration.shift_px;
    assert!(x.hypot(y) < 0.02, "({x}, {y})");
    for by in [[3, -2], [17, 9]] {
        let found = run(sharp.clone(), moved(&plate, by), &settings()).expect("detail");
        let remarks = found.remarks().join("; ");
        assert!(remarks.contains("registration"), "{remarks}");
        let e = errors(&found.set, 0.0);
        assert!(e.rms < 0.05 && e.place < 0.1, "{by:?}: {e:?}");
    }
}

#[test]
fn a_crop_is_placed_and_others_are_refused_with_a_remedy() {
    let sharp = [texture()];
    let plate = blurred(&sharp[0], 0.001);
    let crop = |left: usize, top: usize, width: usize, height: usize| -> Vec<f32> {
        (0..width * height)
            .map(|k| plate[(top + k / width) * SIZE.0 + left + k % width])
            .collect()
    };
    let part = |planes, width, height| PairImage {
        width,
        height,
        planes,
        quantisation: None,
    };
    let planes = [crop(60, 30, 320, 240)];
    let cropped = part(&planes, 320, 240);
    let found = estimate_pair(
        &lens(2.5),
        &picture(&sharp),
        &cropped,
        &settings(),
        &no_progress,
    )
    .expect("it lies in the frame");
    let remarks = found.remarks().join("; ");
    assert!(remarks.contains("(60, 30) px"), "{remarks}");
    let e = errors(&found.set, 0.0);
    assert!(e.rms < 0.05 && e.place < 0.1, "{e:?}");
    let error = estimate_pair(&lens(2.5), &cropped, &cropped, &settings(), &no_progress)
        .expect_err("none fills the frame");
    assert!(error.place.contains("320 x 240"), "{error}");
    assert!(
        error.problem.contains("420 x 300") && error.remedy.contains("crop"),
        "{error}"
    );
    let mut random = SplitMix64::new(4);
    let noise = [(0..320 * 240).map(|_| random.unit() as f32).collect()];
    let other = part(&noise, 320, 240);
    let error = estimate_pair(
        &lens(2.5),
        &picture(&sharp),
        &other,
        &settings(),
        &no_progress,
    )
    .expect_err("another scene");
    assert_eq!(error.kind(), ErrorKind::InsufficientData);
}

/// The noise that an estimate states covers the rounding of integers, whether or not the residual shows it.
#[test]
fn rounded_pictures_widen_the_noise() {
    let rounding = |levels: f64| Quantisation {
        step: 1.0 / levels,
        curve: StoredCurve::Linear,
    };
    let round =
        |plane: &[f32]| -> Vec<f32> { plane.iter().map(|v| (v * 127.0).round() / 127.0).collect() };
    let sharp: Vec<f32> = texture().iter().map(|v| 0.15 + 0.1 * v).collect();
    let plate = blurred(&sharp, 0.0);
    let estimated = |sharp: Vec<f32>, plate: Vec<f32>, quantisation| {
        let (sharp, plate) = ([sharp], [plate]);
        let image = |planes| PairImage {
            quantisation,
            ..picture(planes)
        };
        let (sharp, plate) = (image(&sharp), image(&plate));
        estimate_pair(&lens(2.9), &sharp, &plate, &settings(), &no_progress).expect("detail")
    };
    let sigma = |found: &PairEstimate| {
        let all = found
            .set
            .observations
            .iter()
            .filter_map(|o| o.noise_sigma[0]);
        all.sum::<f64>() / found.set.observations.len() as f64
    };
    let fine = estimated(sharp.clone(), plate.clone(), None);
    let rounded = estimated(round(&sharp), round(&plate), Some(rounding(127.0)));
    assert!(
        sigma(&rounded) > 1.5 * sigma(&fine),
        "{} {}",
        sigma(&rounded),
        sigma(&fine)
    );
    // A plate that happens to agree with the prediction still has the noise of its rounding.
    let stated = estimated(sharp, plate, Some(rounding(80.0)));
    assert!(
        sigma(&stated) > 1.5 * sigma(&fine),
        "{} {}",
        sigma(&stated),
        sigma(&fine)
    );
}

/// Returns `lens` as a pair of pictures sees it.
fn view(lens: &LensProfile) -> LensView<'_> {
    LensView {
        channels: crate::diagnose::rays(lens).expect("rays"),
        frame: lens.frame,
        vergence: 0.5,
        positions: Positions::Lens,
    }
}

/// Returns a scene of random dots, seen after `transform`. They are as small as pixels can show without aliases.
fn scene(transform: &Similarity) -> Vec<f32> {
    const VARIANCE: f64 = 0.64;
    const REACH: isize = 4;
    let mut random = SplitMix64::new(6);
    let (width, height) = (SIZE.0 as isize, SIZE.1 as isize);
    let mut light = vec![0.2_f64; SIZE.0 * SIZE.1];
    for _ in 0..15_000 {
        let mut draw = |length: usize| -20.0 + (length as f64 + 40.0) * random.unit();
        let (x, y) = (draw(SIZE.0), draw(SIZE.1));
        let at = transform.apply(seidel_optics::field::ImagePoint::new(x, y));
        let size = 0.2 + random.unit();
        let (column, row) = (at.x_px.floor() as isize, at.y_px.floor() as isize);
        for y in (row - REACH).max(0)..(row + REACH + 1).min(height) {
            for x in (column - REACH).max(0)..(column + REACH + 1).min(width) {
                let (dx, dy) = (x as f64 + 0.5 - at.x_px, y as f64 + 0.5 - at.y_px);
                light[(y * width + x) as usize] +=
                    size * (-(dx * dx + dy * dy) / (2.0 * VARIANCE)).exp();
            }
        }
    }
    light.iter().map(|v| *v as f32).collect()
}

/// Returns `sharp` with the light of every pixel spread over `tile`.
fn spread_by(sharp: &[f32], tile: &[f64]) -> Vec<f32> {
    let (width, height, half) = (SIZE.0 as isize, SIZE.1 as isize, SIDE as isize / 2);
    let taps: Vec<(isize, isize, f64)> = (0..SIDE as isize * SIDE as isize)
        .map(|k| {
            let (x, y) = (k % SIDE as isize, k / SIDE as isize);
            (x - half, y - half, tile[k as usize])
        })
        .filter(|tap| tap.2 > 1e-7)
        .collect();
    let value = |k: usize| {
        let (x, y) = (k as isize % width, k as isize / width);
        let sum: f64 = taps
            .iter()
            .map(|(dx, dy, light)| {
                let (from_x, from_y) =
                    ((x - dx).clamp(0, width - 1), (y - dy).clamp(0, height - 1));
                light * f64::from(sharp[(from_y * width + from_x) as usize])
            })
            .sum();
        sum as f32
    };
    (0..sharp.len()).map(value).collect()
}

/// A blur with sharp edges passes texture as fine as the pixels, which a picture moved by a fraction of a pixel must not lose or
/// alias.
#[test]
fn fractions_of_a_pixel_and_small_scales_leave_no_gap() {
    let mut lens = lens(0.06);
    if let LensDescription::Pupil(channels) = &mut lens.description {
        let channel = &mut channels[0];
        channel.alpha = VergenceSeries::constant(1.6);
        channel.magnification = VergenceSeries::constant(0.003);
        channel.distortion = VergenceSeries::constant(-0.006);
    }
    let at = seidel_optics::field::ImagePoint::new(210.0, 150.0);
    let psf = view(&lens).tile(0, at, [0.0; 2], SIDE, &mut Drawing::default());
    let sharp = [scene(&Similarity::IDENTITY)];
    let scaled = Similarity {
        a: 1.01,
        b: 0.0,
        shift_px: [-0.01 * 210.0, -0.01 * 150.0],
    };
    for transform in [Similarity::shift(0.37, -0.61), scaled] {
        let plate = [spread_by(&scene(&transform), &psf)];
        let (of_sharp, of_plate) = (picture(&sharp), picture(&plate));
        let found = estimate_pair(&lens, &of_sharp, &of_plate, &settings(), &no_progress);
        let found = found.expect("texture");
        assert!(!found.pictures.distorted, "{transform:?}");
        for (x, y) in [(0.0, 0.0), (420.0, 300.0)] {
            let corner = seidel_optics::field::ImagePoint::new(x, y);
            let (got, want) = (
                found.pictures.registration.apply(corner),
                transform.apply(corner),
            );
            let off = (got.x_px - want.x_px).hypot(got.y_px - want.y_px);
            assert!(off < 0.05, "{off} px at ({x}, {y}) of {transform:?}");
        }
        assert!(found.left_out < 3, "{} left out", found.left_out);
        // Less the noise that the estimate states, as a diagnosis takes it. The dots have aliases of 4 %.
        let pixels = (SIDE * SIDE) as f64;
        let gap = |observation: &Observation| {
            let pairs = observation.tiles[0].samples().iter().zip(&psf);
            let square: f64 = pairs.map(|(a, b)| (f64::from(*a) - b).powi(2)).sum();
            let noise = pixels * observation.noise_sigma[0].expect("estimated").powi(2);
            (square - noise) / psf.iter().map(|v| v * v).sum::<f64>()
        };
        let all = &found.set.observations;
        let mean = all.iter().map(gap).sum::<f64>() / all.len() as f64;
        assert!(mean.abs() < 2e-3, "{mean} of {transform:?}");
    }
}

#[test]
fn windows_of_an_aligned_plate_have_no_offset() {
    let (sharp, plate) = ([texture()], [blurred(&texture(), 0.0)]);
    let (sharp, plate) = (picture(&sharp), picture(&plate));
    let lens = lens(2.5);
    let chosen = windows::choose(&sharp, SIDE, 12, None, None);
    let windows = chosen.expect("large enough").windows;
    let plans = Plans::new(SIDE, windows[0].square());
    for window in windows {
        let measured = offsets::measure(&view(&lens), &plans, [&sharp, &plate], 0, window, None);
        let [x, y] = measured.expect("texture").offset_px;
        assert!(x.hypot(y) < 0.02, "({x}, {y}) in {window:?}");
    }
}

#[test]
fn drawn_psfs_lie_on_their_pixels() {
    for alpha in [0.0, 0.2, 1.5] {
        let mut lens = lens(2.5);
        if let LensDescription::Pupil(channels) = &mut lens.description {
            channels[0].alpha = VergenceSeries::constant(alpha);
        }
        let at = seidel_optics::field::ImagePoint::new(200.5, 120.5);
        for offset in [[0.0, 0.0], [0.3, -0.2]] {
            let tile = view(&lens).tile(0, at, offset, SIDE, &mut Drawing::default());
            let mean = |axis: fn(usize) -> usize| -> f64 {
                tile.iter()
                    .enumerate()
                    .map(|(k, v)| v * (axis(k) as f64 + 0.5))
                    .sum()
            };
            let (x, y) = (mean(|k| k % SIDE), mean(|k| k / SIDE));
            let half = SIDE as f64 / 2.0;
            let off = (x - half + offset[0]).hypot(y - half + offset[1]);
            assert!(off < 0.005, "{off} at {offset:?} with alpha {alpha}");
        }
    }
}
