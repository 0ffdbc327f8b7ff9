//! Phase correlation (Kuglin and Hines 1975): the shift between two pictures of one scale.

use super::picture::Picture;
use crate::helix::Helix;

/// Share of the mean cross-power added to each frequency before whitening. It keeps frequencies that a lens has
/// blurred away from adding their noise.
const WHITENING_FLOOR: f64 = 0.1;

/// The peak of a phase correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak {
    /// Shift (x, y) from the first picture to the second, whole px.
    pub(super) shift_px: [isize; 2],
    /// Height of the peak in root mean squares of the correlation.
    pub(super) significance: f64,
}

/// Returns the peak of the phase correlation between `from` and `to`, tapered towards their edges. The pictures may
/// differ in size.
pub(super) fn peak(from: &Picture, to: &Picture) -> Peak {
    let stride = from.width + to.width;
    let rows = from.height + to.height;
    let helix = Helix::new(stride, rows);
    let spectrum = |picture: &Picture| {
        let mut values = picture.about_mean();
        for (k, value) in values.iter_mut().enumerate() {
            *value *=
                hann(k % picture.width, picture.width) * hann(k / picture.width, picture.height);
        }
        helix.spectrum(helix.laid_out(&values, picture.width))
    };
    let (first, mut cross) = (spectrum(from), spectrum(to));
    for (to, from) in cross.iter_mut().zip(&first) {
        *to *= from.conj();
    }
    let mean = cross.iter().map(|c| c.norm()).sum::<f64>() / cross.len() as f64;
    let floor = (WHITENING_FLOOR * mean).max(f64::MIN_POSITIVE);
    for value in &mut cross {
        *value /= value.norm() + floor;
    }
    let surface = helix.values(cross);
    let rms = (surface.iter().map(|v| v * v).sum::<f64>() / surface.len() as f64).sqrt();
    let (mut best, mut at) = (f64::MIN, [0, 0]);
    for y in 1 - from.height as isize..to.height as isize {
        for x in 1 - from.width as isize..to.width as isize {
            let value = surface[helix.lag(y, x)];
            if value > best {
                (best, at) = (value, [x, y]);
            }
        }
    }
    Peak {
        shift_px: at,
        significance: best / rms.max(f64::MIN_POSITIVE),
    }
}

/// Hann window.
fn hann(at: usize, length: usize) -> f64 {
    let turn = std::f64::consts::TAU * (at as f64 + 0.5) / length as f64;
    0.5 - 0.5 * turn.cos()
}
