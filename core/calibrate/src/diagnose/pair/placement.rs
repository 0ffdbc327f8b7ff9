//! Pictures of another size or crop, placed in the frame of the lens.

use std::borrow::Cow;

use super::PairImage;
use crate::registration::{Picture, Registration, Similarity, register};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{Frame, ImagePoint};

/// Largest difference of scale from 1, and rotation in radians, that windows follow without resampling. Coma moves the peaks
/// of PSFs along the radius, so that blocks of an undistorted plate match at a scale that is off by some thousandths.
const MOST_STRETCH: f64 = 0.015;
/// Shift along an axis from which on windows do not follow without placement, px.
const MOST_SHIFT_PX: isize = 5;
/// Scales of the sharp picture that are resampled. Enlarged further it lacks detail.
const SCALES: std::ops::RangeInclusive<f64> = 0.1..=1.5;
/// Lobes of the Lanczos kernel.
const LOBES: f64 = 3.0;

/// Both pictures on the pixels of the frame; unknown pixels are NaN.
pub(super) struct PlacedPair<'a> {
    pub(super) sharp: Vec<Cow<'a, [f32]>>,
    pub(super) plate: Vec<Cow<'a, [f32]>>,
    /// A remark on what was moved.
    pub(super) remark: Option<String>,
}

/// Registers the pictures and places them in `frame`. One of them must fill it.
///
/// # Errors
/// Pictures of another size that have nothing in common, that differ in scale where resampling would blur the plate, or
/// of which none fills the frame. The message says where one lies in the other, and how to crop.
pub(super) fn place<'a>(
    frame: &Frame,
    sharp: &PairImage<'a>,
    plate: &PairImage<'a>,
) -> Result<PlacedPair<'a>> {
    let size = (frame.width_px() as usize, frame.height_px() as usize);
    let (of_sharp, of_plate) = ((sharp.width, sharp.height), (plate.width, plate.height));
    let picture = |image: &PairImage<'_>| Picture::mean_of(image.width, image.height, image.planes);
    let found = register(&picture(sharp), &picture(plate));
    let fill = of_sharp == size && of_plate == size;
    let found = match found {
        // Windows will say why where the pictures fit but have no detail.
        Err(_) if fill => return Ok(unchanged(sharp, plate)),
        other => other.map_err(|e| e.within(&sizes(of_sharp, of_plate)))?,
    };
    if of_plate == size {
        into_plate(sharp, plate, &found)
    } else if of_sharp == size {
        into_sharp(sharp, plate, &found)
    } else {
        Err(cannot_fill(size, of_sharp, of_plate, &found))
    }
}

fn sizes(sharp: (usize, usize), plate: (usize, usize)) -> String {
    format!(
        "pictures of {} x {} px (sharp) and {} x {} px (through the lens)",
        sharp.0, sharp.1, plate.0, plate.1
    )
}

/// Returns the error for pictures of which none fills the frame.
fn cannot_fill(
    frame: (usize, usize),
    sharp: (usize, usize),
    plate: (usize, usize),
    found: &Registration,
) -> Error {
    let [x, y] = found.transform.shift_px;
    let same_shape =
        (plate.0 as f64 / plate.1 as f64 / (frame.0 as f64 / frame.1 as f64) - 1.0).abs() < 0.01;
    let remedy = if same_shape {
        format!(
            "scale both to {} x {} px, or use a lens profile of {} x {} px",
            frame.0, frame.1, plate.0, plate.1
        )
    } else {
        format!(
            "crop or pad both to the {} x {} px of the lens's frame, with the same pixel of the sensor in its corner",
            frame.0, frame.1
        )
    };
    Error::new(
        sizes(sharp, plate),
        format!(
            "fill the lens's frame of {} x {} px neither; the corner of the sharp picture lies at ({x:.1}, {y:.1}) px of the plate, at scale {:.4}",
            frame.0,
            frame.1,
            found.transform.scale()
        ),
        remedy,
    )
}

fn unchanged<'a>(sharp: &PairImage<'a>, plate: &PairImage<'a>) -> PlacedPair<'a> {
    let all = |image: &PairImage<'a>| image.planes.iter().map(|p| Cow::Borrowed(&p[..])).collect();
    PlacedPair {
        sharp: all(sharp),
        plate: all(plate),
        remark: None,
    }
}

/// Places the sharp picture on the pixels of a plate that fills the frame.
fn into_plate<'a>(
    sharp: &PairImage<'a>,
    plate: &PairImage<'a>,
    found: &Registration,
) -> Result<PlacedPair<'a>> {
    let transform = found.transform;
    let is_same_size = (sharp.width, sharp.height) == (plate.width, plate.height);
    let mut placed = unchanged(sharp, plate);
    if is_shift(&transform) {
        let corner = whole_shift(&transform, sharp);
        if is_same_size && corner.iter().all(|v| v.abs() < MOST_SHIFT_PX) {
            return Ok(placed);
        }
        let size = (plate.width, plate.height);
        placed.sharp = moved(sharp, corner, size);
        placed.remark = Some(remark("the sharp picture", corner));
        return Ok(placed);
    }
    let scale = transform.scale();
    if !SCALES.contains(&scale) {
        return Err(Error::new(
            sizes((sharp.width, sharp.height), (plate.width, plate.height)),
            format!("differ in scale by a factor of {scale:.3}"),
            "give a sharp picture of the plate's scale or a finer one, up to ten times",
        ));
    }
    placed.sharp = sharp
        .planes
        .iter()
        .map(|plane| {
            let from = Plane {
                width: sharp.width,
                height: sharp.height,
                samples: plane,
            };
            Cow::Owned(from.resampled(&transform.inverse(), (plate.width, plate.height)))
        })
        .collect();
    placed.remark = Some(format!(
        "registration: the sharp picture was resampled: scale {scale:.4}, rotation {:.3} degrees, its corner at ({:.2}, {:.2}) px of the plate",
        transform.rotation().to_degrees(),
        transform.shift_px[0],
        transform.shift_px[1]
    ));
    Ok(placed)
}

/// Places a plate on the pixels of a sharp picture that fills the frame.
fn into_sharp<'a>(
    sharp: &PairImage<'a>,
    plate: &PairImage<'a>,
    found: &Registration,
) -> Result<PlacedPair<'a>> {
    let transform = found.transform;
    if !is_shift(&transform) {
        return Err(Error::new(
            sizes((sharp.width, sharp.height), (plate.width, plate.height)),
            format!(
                "differ by a scale of {:.4} and a rotation of {:.3} degrees, and the plate cannot be resampled without blur",
                transform.scale(),
                transform.rotation().to_degrees()
            ),
            "crop the plate from the frame without scaling it, or give the whole frame",
        ));
    }
    let corner = whole_shift(&transform, sharp).map(|v| -v);
    let mut placed = unchanged(sharp, plate);
    placed.plate = moved(plate, corner, (sharp.width, sharp.height));
    placed.remark = Some(remark("the plate", corner));
    Ok(placed)
}

fn remark(what: &str, corner: [isize; 2]) -> String {
    format!(
        "registration: {what} was placed with its corner at ({}, {}) px of the lens's frame",
        corner[0], corner[1]
    )
}

fn is_shift(transform: &Similarity) -> bool {
    (transform.scale() - 1.0).abs() <= MOST_STRETCH && transform.rotation().abs() <= MOST_STRETCH
}

/// Returns the whole pixels by which `transform` moves the middle of `picture`.
fn whole_shift(transform: &Similarity, picture: &PairImage<'_>) -> [isize; 2] {
    let middle = ImagePoint::new(picture.width as f64 / 2.0, picture.height as f64 / 2.0);
    let there = transform.apply(middle);
    [
        (there.x_px - middle.x_px).round() as isize,
        (there.y_px - middle.y_px).round() as isize,
    ]
}

/// Returns the planes of `picture` with its corner at `corner` of a picture of `size`.
fn moved<'a>(
    picture: &PairImage<'a>,
    corner: [isize; 2],
    size: (usize, usize),
) -> Vec<Cow<'a, [f32]>> {
    let (width, height) = size;
    let source = |at: usize, corner: isize, length: usize| {
        usize::try_from(at as isize - corner)
            .ok()
            .filter(|k| *k < length)
    };
    picture
        .planes
        .iter()
        .map(|plane| {
            let cell = |k: usize| {
                let x = source(k % width, corner[0], picture.width);
                let y = source(k / width, corner[1], picture.height);
                x.zip(y)
                    .map_or(f32::NAN, |(x, y)| plane[y * picture.width + x])
            };
            Cow::Owned((0..width * height).map(cell).collect())
        })
        .collect()
}

/// A plane to be resampled.
struct Plane<'a> {
    width: usize,
    height: usize,
    samples: &'a [f32],
}

impl Plane<'_> {
    /// Resamples the plane by a Lanczos kernel at the points that `back` gives for the pixels of a picture of `size`.
    /// Where pixels grow, the kernel grows with them.
    fn resampled(&self, back: &Similarity, size: (usize, usize)) -> Vec<f32> {
        let stretch = back.scale().max(1.0);
        let cells = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
        cells
            .map(|(x, y)| {
                let at = back.apply(ImagePoint::new(x as f64 + 0.5, y as f64 + 0.5));
                self.sample(at, stretch)
            })
            .collect()
    }

    fn sample(&self, at: ImagePoint, stretch: f64) -> f32 {
        let reach = LOBES * stretch;
        let range = |at: f64, length: usize| {
            let (first, last) = ((at - reach).ceil(), (at + reach).floor());
            (first >= 0.0 && last < length as f64).then_some(first as usize..=last as usize)
        };
        let (x, y) = (at.x_px - 0.5, at.y_px - 0.5);
        let (Some(columns), Some(rows)) = (range(x, self.width), range(y, self.height)) else {
            return f32::NAN;
        };
        let across: Vec<f64> = columns
            .clone()
            .map(|k| lanczos((k as f64 - x) / stretch))
            .collect();
        let (mut sum, mut weights) = (0.0, 0.0);
        for row in rows {
            let down = lanczos((row as f64 - y) / stretch);
            for (column, across) in columns.clone().zip(&across) {
                let weight = down * across;
                sum += weight * f64::from(self.samples[row * self.width + column]);
                weights += weight;
            }
        }
        (sum / weights) as f32
    }
}

/// Lanczos kernel.
fn lanczos(x: f64) -> f64 {
    let sinc = |x: f64| {
        let turn = std::f64::consts::PI * x;
        if turn == 0.0 { 1.0 } else { turn.sin() / turn }
    };
    if x.abs() < LOBES {
        sinc(x) * sinc(x / LOBES)
    } else {
        0.0
    }
}
