//! Mistakes in a pair of pictures: one is mirrored or turned, or encoded where the other is linear.

use seidel_optics::error::Error;

use super::PairImage;
use crate::registration::{Picture, register};

/// Side of the blocks whose brightness is compared, px: blur hardly changes it.
const BLOCK_PX: usize = 24;
/// Blocks needed, and the least standard deviation of the logarithm of their brightness.
const MIN_BLOCKS: usize = 24;
const MIN_CONTRAST: f64 = 0.15;
/// Least correlation of the logarithms of both pictures, and the exponents between them that no lens makes.
const MIN_CORRELATION: f64 = 0.97;
const LINEAR: std::ops::RangeInclusive<f64> = 0.7..=1.43;

/// A change of the axes of a picture: first rows and columns are exchanged, then each axis is mirrored.
#[derive(Clone, Copy)]
struct Turn {
    transposes: bool,
    mirrors: [bool; 2],
    words: &'static str,
}

const fn turn(transposes: bool, mirrors: [bool; 2], words: &'static str) -> Turn {
    Turn {
        transposes,
        mirrors,
        words,
    }
}

/// The changes that are tried, the commonest first.
const TURNS: [Turn; 5] = [
    turn(false, [false, true], "is upside down"),
    turn(false, [true, false], "is mirrored left to right"),
    turn(false, [true, true], "is turned by 180 degrees"),
    turn(true, [true, false], "is turned by 90 degrees"),
    turn(true, [false, true], "is turned by 90 degrees"),
];

/// Returns the error of a `plate` that is mirrored or turned against `sharp`; `None` where that does not align them.
pub(super) fn turned(sharp: &PairImage<'_>, plate: &PairImage<'_>) -> Option<Error> {
    let of_sharp = Picture::mean_of(sharp.width, sharp.height, sharp.planes);
    let found = TURNS.into_iter().find(|turn| {
        let (width, height) = match turn.transposes {
            true => (plate.height, plate.width),
            false => (plate.width, plate.height),
        };
        let planes: Vec<Vec<f32>> = (plate.planes.iter())
            .map(|plane| turn.applied(plane, plate.width, width, height))
            .collect();
        register(&of_sharp, &Picture::mean_of(width, height, &planes)).is_ok()
    })?;
    Some(Error::new(
        "plate",
        format!("{} against the sharp picture", found.words),
        "turn or mirror one of the pictures, so that both show the scene as the sensor saw it; the lens is not symmetric",
    ))
}

impl Turn {
    /// Returns the samples of `plane`, of rows of `from` px, as a picture of `width` x `height`.
    fn applied(self, plane: &[f32], from: usize, width: usize, height: usize) -> Vec<f32> {
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let sample = |(x, y): (usize, usize)| {
            let x = if self.mirrors[0] { width - 1 - x } else { x };
            let y = if self.mirrors[1] { height - 1 - y } else { y };
            let (x, y) = if self.transposes { (y, x) } else { (x, y) };
            plane[y * from + x]
        };
        cells.map(sample).collect()
    }
}

/// Returns a remark where the brightness of the plate goes as a power of that of the sharp picture, in the same frame of rows of `width` px.
pub(super) fn encoding_remark(
    sharp: &[Vec<f32>],
    plate: &[Vec<f32>],
    width: usize,
) -> Option<String> {
    let pairs = sharp.iter().zip(plate);
    let logs: Vec<[f64; 2]> = pairs
        .flat_map(|(sharp, plate)| logarithms(sharp, plate, width))
        .collect();
    let count = logs.len() as f64;
    if logs.len() < MIN_BLOCKS {
        return None;
    }
    let mean = [0, 1].map(|k| logs.iter().map(|l| l[k]).sum::<f64>() / count);
    let moment = |a: usize, b: usize| {
        let terms = logs.iter().map(|l| (l[a] - mean[a]) * (l[b] - mean[b]));
        terms.sum::<f64>() / count
    };
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    let (correlation, exponent) = (xy / (xx * yy).sqrt(), xy / xx);
    let is_power =
        xx.sqrt() > MIN_CONTRAST && correlation > MIN_CORRELATION && !LINEAR.contains(&exponent);
    is_power.then(|| {
        format!(
            "the brightness of the plate goes as the power {exponent:.2} of that of the sharp picture: one of them is encoded. \
             Give scene-linear pictures, or state the encoding of the pictures"
        )
    })
}

/// Returns the logarithms of the mean brightness of the blocks of both planes that are known and lit.
fn logarithms(sharp: &[f32], plate: &[f32], width: usize) -> Vec<[f64; 2]> {
    let height = sharp.len() / width;
    let mean = |plane: &[f32], left: usize, top: usize| {
        let rows = (top..top + BLOCK_PX).flat_map(|y| &plane[y * width + left..][..BLOCK_PX]);
        rows.map(|v| f64::from(*v)).sum::<f64>() / (BLOCK_PX * BLOCK_PX) as f64
    };
    let blocks = (0..height / BLOCK_PX)
        .flat_map(|row| (0..width / BLOCK_PX).map(move |column| (column, row)));
    blocks
        .map(|(column, row)| [sharp, plate].map(|p| mean(p, column * BLOCK_PX, row * BLOCK_PX)))
        .filter(|means| means.iter().all(|m| m.is_finite() && *m > 0.0))
        .map(|means| means.map(f64::ln))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::pair::tests::{SIZE, picture, texture};

    #[test]
    fn a_mirrored_plate_is_named_and_an_unrelated_one_is_not() {
        let sharp = [texture()];
        for turn in TURNS.into_iter().filter(|turn| !turn.transposes) {
            let plate = [turn.applied(&sharp[0], SIZE.0, SIZE.0, SIZE.1)];
            let error = turned(&picture(&sharp), &picture(&plate)).expect("mirrored");
            assert!(error.problem.contains(turn.words), "{error}");
        }
        let other: Vec<f32> = sharp[0].iter().map(|v| (v * 1e4).fract()).collect();
        assert!(turned(&picture(&sharp), &picture(&[other])).is_none());
    }

    #[test]
    fn a_gamma_is_named_and_falloff_of_light_is_not() {
        let (width, height) = SIZE;
        let sharp: Vec<f32> = (texture().iter().enumerate())
            .map(|(k, v)| v * (0.2 + (k % width) as f32 / width as f32))
            .collect();
        let falling = |k: usize| {
            let at = [k % width, k / width].map(|v| v as f32);
            let from = [at[0] / width as f32 - 0.5, at[1] / height as f32 - 0.5];
            1.0 - from[0] * from[0] - from[1] * from[1]
        };
        let light: Vec<f32> = (sharp.iter().enumerate())
            .map(|(k, v)| v * falling(k))
            .collect();
        let remark =
            |plate: Vec<f32>| encoding_remark(std::slice::from_ref(&sharp), &[plate], width);
        assert_eq!(remark(light.clone()), None);
        let coded = remark(light.iter().map(|v| v.powf(1.0 / 2.2)).collect());
        assert!(coded.is_some_and(|text| text.contains("power 0.4")));
    }
}
