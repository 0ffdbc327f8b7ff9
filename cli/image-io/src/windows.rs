//! Data and display windows, and samples cropped, extended or padded from one window to another.

use std::path::Path;

use seidel_optics::Rectangle;

use crate::error::{FileError, Result};

/// The two windows of an image, by OpenEXR's names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageWindows {
    /// The pixels that are stored. They may exceed the display window (overscan) or not fill it.
    pub data: Rectangle,
    /// The frame that is shown, which the lens's full frame covers.
    pub display: Rectangle,
}

impl ImageWindows {
    /// Returns column and row of the data window's corner in the display window.
    fn corner(self) -> (i64, i64) {
        let from = |at: i32, origin: i32| i64::from(at) - i64::from(origin);
        (
            from(self.data.x, self.display.x),
            from(self.data.y, self.display.y),
        )
    }

    /// Returns the windows of an image without overscan, its corner at (0, 0).
    pub fn of_size(width: usize, height: usize) -> Self {
        let data = Rectangle {
            x: 0,
            y: 0,
            width,
            height,
        };
        Self {
            data,
            display: data,
        }
    }
}

/// Returns the samples of window `from` over window `to`: cropped, and extended beyond `from` by its edge pixels.
///
/// Samples are row-major. The result is empty if `from` is empty.
pub fn crop_or_extend<T: Copy>(samples: &[T], from: Rectangle, to: Rectangle) -> Vec<T> {
    if samples.is_empty() || samples.len() != from.width * from.height {
        return Vec::new();
    }
    let nearest = |at: usize, to: i32, from: i32, size: usize| {
        let at = i64::from(to) + at as i64 - i64::from(from);
        at.clamp(0, size as i64 - 1) as usize
    };
    let columns: Vec<usize> = (0..to.width)
        .map(|x| nearest(x, to.x, from.x, from.width))
        .collect();
    let mut out = Vec::with_capacity(to.width * to.height);
    for y in 0..to.height {
        let row = nearest(y, to.y, from.y, from.height);
        let row = &samples[row * from.width..][..from.width];
        out.extend(columns.iter().map(|&x| row[x]));
    }
    out
}

/// Returns the samples of window `from` over window `to`: cropped, and zero beyond `from`.
///
/// Samples are row-major.
pub fn crop_or_pad<T: Copy + Default>(samples: &[T], from: Rectangle, to: Rectangle) -> Vec<T> {
    let mut out = vec![T::default(); to.width * to.height];
    // Position of the corner of `to` in `from`.
    let x = i64::from(to.x) - i64::from(from.x);
    let y = i64::from(to.y) - i64::from(from.y);
    let first = (-x).clamp(0, to.width as i64);
    let end = (from.width as i64 - x).clamp(first, to.width as i64);
    for (row, out) in out.chunks_exact_mut(to.width.max(1)).enumerate() {
        let source = y + row as i64;
        if end > first && (0..from.height as i64).contains(&source) {
            let start = source as usize * from.width + (x + first) as usize;
            let count = (end - first) as usize;
            out[first as usize..end as usize].copy_from_slice(&samples[start..start + count]);
        }
    }
    out
}

/// Samples over the data window of a plate.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedSamples {
    /// One sample per pixel of the plate's data window, row-major.
    pub samples: Vec<f32>,
    /// A warning for the user, if samples had to be extended.
    pub warning: Option<String>,
}

/// Fits one channel of `file` (`channel` for messages) to the data window of a plate.
///
/// A channel of the plate's frame, which has its display window, is cropped if it covers the plate, and extended by its
/// edge pixels, with a warning, if it overlaps. A channel of another frame is taken as it is if it has the plate's size.
///
/// # Errors
/// A channel of another size that does not belong to the plate's frame or lies beside the plate.
pub(crate) fn fit_to_plate(
    samples: &[f32],
    from: ImageWindows,
    plate: ImageWindows,
    file: &Path,
    channel: &str,
) -> Result<FittedSamples> {
    let wanted = plate.data;
    let fitted = |samples, warning| Ok(FittedSamples { samples, warning });
    let size = |window: Rectangle| (window.width, window.height);
    let is_same_frame = size(from.display) == size(plate.display);
    let own = if is_same_frame {
        (from.data).moved(from.display, plate.display)
    } else {
        from.data
    };
    if is_same_frame && own.encloses(wanted) {
        return fitted(crop_or_extend(samples, own, wanted), None);
    }
    if !is_same_frame && (own.width, own.height) == (wanted.width, wanted.height) {
        let warning = (from.corner() != plate.corner()).then(|| {
            format!(
                "{}, channel {channel}: is {own} in a frame of {}, the plate {wanted} in one of {}; taken pixel by pixel",
                file.display(),
                from.display,
                plate.display
            )
        });
        return fitted(samples.to_vec(), warning);
    }
    if is_same_frame && own.intersection(&wanted).is_some() {
        let warning = format!(
            "{}, channel {channel}: covers {own}, the plate {wanted}; extended by its edge pixels",
            file.display()
        );
        return fitted(crop_or_extend(samples, own, wanted), Some(warning));
    }
    let (problem, remedy) = if is_same_frame {
        (
            format!("covers {own}, the plate {wanted}"),
            "render both at one size and data window",
        )
    } else {
        let (frame, wanted) = (from.display, plate.display);
        (
            format!("belongs to a frame of {frame}, the plate to one of {wanted}"),
            "render both at one size, or crop or scale one of them to the other's display window",
        )
    };
    Err(FileError::new(
        file,
        format!("channel {channel}"),
        problem,
        remedy,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(x: i32, y: i32, width: usize, height: usize) -> Rectangle {
        Rectangle {
            x,
            y,
            width,
            height,
        }
    }

    #[test]
    fn samples_are_cropped_extended_and_padded() {
        let own = window(-1, 2, 3, 2);
        let samples = [1, 2, 3, 4, 5, 6];
        assert_eq!(crop_or_extend(&samples, own, window(0, 3, 2, 1)), [5, 6]);
        assert!(own.encloses(window(0, 3, 2, 1)));
        assert!(!own.encloses(window(0, 3, 3, 1)) && !own.encloses(window(-2, 2, 1, 1)));
        let floats = samples.map(|v| v as f32);
        let part = crop_or_pad(&floats, own, window(1, 1, 3, 2));
        assert_eq!(part, [0.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
        let around = crop_or_pad(&floats, own, window(-2, 3, 5, 2));
        assert_eq!(around, [0.0, 4.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(crop_or_pad(&floats, own, window(9, 9, 1, 2)), [0.0; 2]);
        // A window that only overlaps.
        let moved = window(1, 1, 2, 2);
        assert_eq!(crop_or_extend(&samples, own, moved), [3, 3, 3, 3]);
        assert_eq!(crop_or_extend(&samples, own, own), samples);
        let wider = own.expanded(1, 0);
        assert_eq!(wider, window(-2, 2, 5, 2));
        let padded = [0.0, 1.0, 2.0, 3.0, 0.0, 0.0, 4.0, 5.0, 6.0, 0.0];
        assert_eq!(crop_or_pad(&floats, own, wider), padded);
        assert_eq!(crop_or_pad(&padded, wider, own), floats);
    }

    #[test]
    fn extreme_positions_do_not_overflow() {
        let (first, last) = (window(i32::MIN, 0, 4, 4), window(i32::MAX - 3, 0, 4, 4));
        assert!(
            !first.encloses(last) && first.intersection(&last).is_none() && first.encloses(first)
        );
        assert_eq!(crop_or_extend(&[7_u32; 16], first, last), [7; 16]);
        assert!(crop_or_extend::<u32>(&[], window(0, 0, 0, 4), last).is_empty());
    }

    #[test]
    fn only_channels_of_the_same_frame_are_extended() {
        let display = window(0, 0, 4, 3);
        let pass = ImageWindows {
            data: display,
            display,
        };
        let samples = [0.5; 12];
        let fit = |data: Rectangle, display: Rectangle| {
            let plate = ImageWindows { data, display };
            fit_to_plate(&samples, pass, plate, Path::new("z.exr"), "Z")
        };
        let overscan = fit(display.expanded(2, 1), display).expect("overscan");
        assert_eq!(
            (overscan.samples.len(), overscan.warning.is_some()),
            (8 * 5, true)
        );
        for (data, display) in [
            (display.expanded(2, 1), display.expanded(2, 1)),
            (window(9, 9, 5, 5), display),
        ] {
            let error = fit(data, display).expect_err("another frame").to_string();
            assert!(
                error.contains("z.exr") && error.contains("channel Z"),
                "{error}"
            );
        }
    }
}
