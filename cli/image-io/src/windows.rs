//! Data windows: samples of one over another.

use crate::error::{FileError, Result};
use crate::exr::plate::Window;
use std::path::Path;

/// Where planes lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Windows {
    /// The pixels that there are.
    pub data: Window,
    /// The picture proper.
    pub display: Window,
}

impl Windows {
    /// Of a picture that is all there is, its corner at (0, 0).
    pub fn of_size(width: usize, height: usize) -> Self {
        let data = Window {
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

impl Window {
    /// The same with as many columns and rows more on either side.
    pub fn grown(self, columns: usize, rows: usize) -> Self {
        let less = |at: i32, by: usize| at.saturating_sub(i32::try_from(by).unwrap_or(i32::MAX));
        Self {
            x: less(self.x, columns),
            y: less(self.y, rows),
            width: self.width + 2 * columns,
            height: self.height + 2 * rows,
        }
    }

    /// Whether all pixels of `inner` are in it.
    pub fn contains(self, inner: Self) -> bool {
        let within = |inner: i32, inner_size: usize, outer: i32, outer_size: usize| {
            let first = i64::from(inner) - i64::from(outer);
            first >= 0 && first as u64 + inner_size as u64 <= outer_size as u64
        };
        within(inner.x, inner.width, self.x, self.width)
            && within(inner.y, inner.height, self.y, self.height)
    }

    /// Whether any pixel is in both.
    fn meets(self, other: Self) -> bool {
        let overlap = |a: i32, a_size: usize, b: i32, b_size: usize| {
            i64::from(a) < i64::from(b) + b_size as i64
                && i64::from(b) < i64::from(a) + a_size as i64
        };
        overlap(self.x, self.width, other.x, other.width)
            && overlap(self.y, self.height, other.y, other.height)
    }
}

/// Cuts the samples of `from` down to `to`; `None` where `to` is not wholly inside `from`.
pub fn crop<T: Copy>(samples: &[T], from: Window, to: Window) -> Option<Vec<T>> {
    let fits = from.contains(to) && samples.len() == from.width.checked_mul(from.height)?;
    fits.then(|| held(samples, from, to))
}

/// The samples of `from` over any other window, beyond `from` its nearest pixel; nothing where `from` is empty.
pub fn held<T: Copy>(samples: &[T], from: Window, to: Window) -> Vec<T> {
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

/// The samples of `from` over a window that holds it, zero beyond `from`.
pub fn surrounded(samples: &[f32], from: Window, to: Window) -> Vec<f32> {
    let mut out = held(samples, from, to);
    let offset = |inner: i32, outer: i32| (i64::from(inner) - i64::from(outer)).max(0) as usize;
    let (left, top) = (offset(from.x, to.x), offset(from.y, to.y));
    let (columns, rows) = (left..left + from.width, top..top + from.height);
    for (y, row) in out.chunks_exact_mut(to.width.max(1)).enumerate() {
        for (x, sample) in row.iter_mut().enumerate() {
            if !(rows.contains(&y) && columns.contains(&x)) {
                *sample = 0.0;
            }
        }
    }
    out
}

/// The samples of `from` over any other window, zero beyond `from`.
pub fn placed(samples: &[f32], from: Window, to: Window) -> Vec<f32> {
    let mut out = vec![0.0; to.width * to.height];
    // How far the corner of `to` is inside `from`.
    let (x, y) = (
        i64::from(to.x) - i64::from(from.x),
        i64::from(to.y) - i64::from(from.y),
    );
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

/// The `samples` of `what`, in `file`, over the data window of a plate: cut out of a larger window; as they are where
/// only the place differs but not the size; beyond a smaller window of the same picture its nearest pixel, of which
/// there is a remark.
///
/// # Errors
/// Samples that do not cover the plate and are not of the same picture.
pub fn fitted(
    samples: &[f32],
    from: Windows,
    plate: Windows,
    (file, what): (&Path, &str),
) -> Result<(Vec<f32>, Option<String>)> {
    let (own, wanted) = (from.data, plate.data);
    if let Some(cut) = crop(samples, own, wanted) {
        return Ok((cut, None));
    }
    if (own.width, own.height) == (wanted.width, wanted.height) {
        return Ok((samples.to_vec(), None));
    }
    if from.display == plate.display && own.meets(wanted) {
        let said = format!(
            "{}, {what}: covers {own}, the plate {wanted}; beyond, its nearest pixel is taken",
            file.display()
        );
        return Ok((held(samples, own, wanted), Some(said)));
    }
    Err(FileError::new(
        file,
        what,
        format!("covers {own}, the plate {wanted}"),
        "render both at one size and data window",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(x: i32, y: i32, width: usize, height: usize) -> Window {
        Window {
            x,
            y,
            width,
            height,
        }
    }

    #[test]
    fn samples_are_cut_held_and_surrounded() {
        let own = window(-1, 2, 3, 2);
        let samples = [1, 2, 3, 4, 5, 6];
        assert_eq!(crop(&samples, own, window(0, 3, 2, 1)), Some(vec![5, 6]));
        assert_eq!(crop(&samples, own, window(0, 3, 3, 1)), None);
        assert_eq!(crop(&samples, own, window(-2, 2, 1, 1)), None);
        let floats = samples.map(|v| v as f32);
        let part = placed(&floats, own, window(1, 1, 3, 2));
        assert_eq!(part, [0.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
        let around = placed(&floats, own, window(-2, 3, 5, 2));
        assert_eq!(around, [0.0, 4.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(placed(&floats, own, window(9, 9, 1, 2)), [0.0; 2]);
        // A window that only meets the other.
        let moved = window(1, 1, 2, 2);
        assert_eq!(held(&samples, own, moved), [3, 3, 3, 3]);
        assert_eq!(held(&samples, own, own), samples);
        let wider = own.grown(1, 0);
        assert_eq!(wider, window(-2, 2, 5, 2));
        let want = [0.0, 1.0, 2.0, 3.0, 0.0, 0.0, 4.0, 5.0, 6.0, 0.0];
        assert_eq!(surrounded(&floats, own, wider), want);
        assert_eq!(
            crop(&surrounded(&floats, own, wider), wider, own),
            Some(floats.to_vec())
        );
    }

    #[test]
    fn windows_at_the_ends_of_numbers_are_no_trouble() {
        let (first, last) = (window(i32::MIN, 0, 4, 4), window(i32::MAX - 3, 0, 4, 4));
        assert!(!first.contains(last) && !first.meets(last) && first.contains(first));
        assert_eq!(held(&[7_u32; 16], first, last), [7; 16]);
        assert!(held::<u32>(&[], window(0, 0, 0, 4), last).is_empty());
    }

    #[test]
    fn only_what_is_of_the_same_picture_goes_on() {
        let display = window(0, 0, 4, 3);
        let pass = Windows {
            data: display,
            display,
        };
        let samples = [0.5; 12];
        let over = |data: Window, display: Window| {
            fitted(
                &samples,
                pass,
                Windows { data, display },
                (Path::new("z.exr"), "channel Z"),
            )
        };
        let (held, said) = over(display.grown(2, 1), display).expect("overscan");
        assert_eq!((held.len(), said.is_some()), (8 * 5, true));
        for (data, display) in [
            (display.grown(2, 1), display.grown(2, 1)),
            (window(9, 9, 5, 5), display),
        ] {
            let error = over(data, display)
                .expect_err("another picture")
                .to_string();
            assert!(
                error.contains("z.exr") && error.contains("channel Z"),
                "{error}"
            );
        }
    }
}
