//! The plate of the tests and its depth.

use crate::{Picture, WHOLE};

/// Makes a grey plate with bright points, an edge, and a hole in its alpha.
pub(crate) fn plate() -> Picture {
    Picture::new(WHOLE, 4, |x, y, c| {
        let point = if (x * 7 + y * 13) % 61 == 0 { 4.0 } else { 0.0 };
        let edge = if x > 30 { 0.6 } else { 0.1 };
        match c {
            3 => f32::from(u8::from(!((10..16).contains(&x) && y < 12))),
            _ => point + edge + 0.002 * (y * (c + 1)) as f32,
        }
    })
}

/// Makes a pass of 1 / distance: a near card in front of a far background.
pub(crate) fn inverse_depth(channels: i32) -> Picture {
    Picture::new(WHOLE, channels, |x, y, _| {
        if (20..34).contains(&x) && y > 8 {
            0.9
        } else {
            0.05 + 0.001 * y as f32
        }
    })
}

/// Makes a pass of the same distances in centimetres, times `sign`.
pub(crate) fn centimetres(sign: f32) -> Picture {
    let inverse = inverse_depth(1);
    Picture::new(WHOLE, 1, |x, y, _| sign * 100.0 / inverse.at(x, y, 0))
}
