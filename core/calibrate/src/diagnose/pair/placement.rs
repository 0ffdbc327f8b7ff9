//! Pictures of another size or crop, placed in the frame of the lens.

use super::{PairImage, mistakes};
use crate::registration::{Picture, Planes, Registration, Similarity, register};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{Frame, ImagePoint};

/// Largest difference of scale from 1, and rotation in radians, that windows follow without resampling. Coma moves the peaks
/// of PSFs along the radius, so that blocks of an undistorted plate match at a scale that is off by some thousandths.
const MOST_STRETCH: f64 = 0.015;
/// Shift along an axis from which on windows do not follow without placement, px.
const MOST_SHIFT_PX: isize = 5;
/// Scales of the sharp picture that are resampled. Enlarged further it lacks detail.
const SCALES: std::ops::RangeInclusive<f64> = 0.1..=1.5;
/// The places of both pictures in the frame.
pub(super) struct Placement {
    /// From pixels of the sharp picture to pixels of the frame.
    pub(super) sharp: Similarity,
    /// Corner of the plate, whole px of the frame.
    pub(super) plate_corner: [isize; 2],
    /// A remark on what was moved.
    pub(super) remark: Option<String>,
}

impl Placement {
    /// Pictures that both lie in the frame.
    const ALIGNED: Self = Self {
        sharp: Similarity::IDENTITY,
        plate_corner: [0; 2],
        remark: None,
    };
}

/// Returns the planes of `picture`, moved by `transform`, on the pixels of `frame`; unknown pixels are NaN.
pub(super) fn planes_in_frame(
    frame: &Frame,
    picture: &PairImage<'_>,
    transform: &Similarity,
    clip: Option<f32>,
) -> Vec<Vec<f32>> {
    let size = (frame.width_px() as usize, frame.height_px() as usize);
    if *transform == Similarity::IDENTITY && size == (picture.width, picture.height) {
        return picture.planes.to_vec();
    }
    let planes = Planes {
        width: picture.width,
        height: picture.height,
        planes: picture.planes,
        clip,
    };
    planes.moved(transform, size)
}

/// Registers the pictures and places them in `frame`, to a pixel. One of them must fill it.
///
/// # Errors
/// Pictures of another size that have nothing in common, that differ in scale where resampling would blur the plate, or
/// of which none fills the frame. The message says where one lies in the other, and how to crop.
pub(super) fn place(
    frame: &Frame,
    sharp: &PairImage<'_>,
    plate: &PairImage<'_>,
) -> Result<Placement> {
    let size = (frame.width_px() as usize, frame.height_px() as usize);
    let (of_sharp, of_plate) = ((sharp.width, sharp.height), (plate.width, plate.height));
    let picture = |image: &PairImage<'_>| Picture::mean_of(image.width, image.height, image.planes);
    let found = register(&picture(sharp), &picture(plate));
    let fill = of_sharp == size && of_plate == size;
    if found.is_err()
        && let Some(error) = mistakes::turned(sharp, plate)
    {
        return Err(error);
    }
    let found = match found {
        // Windows will say why where the pictures fit but have no detail.
        Err(_) if fill => return Ok(Placement::ALIGNED),
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

/// Places the sharp picture on the pixels of a plate that fills the frame.
fn into_plate(
    sharp: &PairImage<'_>,
    plate: &PairImage<'_>,
    found: &Registration,
) -> Result<Placement> {
    let transform = found.transform;
    let is_same_size = (sharp.width, sharp.height) == (plate.width, plate.height);
    if is_shift(&transform) {
        let corner = whole_shift(&transform, sharp);
        if is_same_size && corner.iter().all(|v| v.abs() < MOST_SHIFT_PX) {
            return Ok(Placement::ALIGNED);
        }
        return Ok(Placement {
            sharp: Similarity::shift(corner[0] as f64, corner[1] as f64),
            remark: Some(remark("the sharp picture", corner)),
            ..Placement::ALIGNED
        });
    }
    let scale = transform.scale();
    if !SCALES.contains(&scale) {
        return Err(Error::new(
            sizes((sharp.width, sharp.height), (plate.width, plate.height)),
            format!("differ in scale by a factor of {scale:.3}"),
            "give a sharp picture of the plate's scale or a finer one, up to ten times",
        ));
    }
    Ok(Placement {
        sharp: transform,
        remark: Some(format!(
            "registration: the sharp picture was resampled: scale {scale:.4}, rotation {:.3} degrees, its corner at ({:.2}, {:.2}) px of the plate",
            transform.rotation().to_degrees(),
            transform.shift_px[0],
            transform.shift_px[1]
        )),
        ..Placement::ALIGNED
    })
}

/// Places a plate on the pixels of a sharp picture that fills the frame.
fn into_sharp(
    sharp: &PairImage<'_>,
    plate: &PairImage<'_>,
    found: &Registration,
) -> Result<Placement> {
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
    Ok(Placement {
        plate_corner: corner,
        remark: Some(remark("the plate", corner)),
        ..Placement::ALIGNED
    })
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
