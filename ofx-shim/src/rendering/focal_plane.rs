//! Where focus lies: red is nearer, green in focus, blue farther.

use seidel_c::SeidelRect;

use crate::pixels::Pixels;

/// What is in focus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InFocus {
    /// Vergences, 1/m, from the far end to the near one.
    pub(crate) far: f64,
    pub(crate) near: f64,
}

impl InFocus {
    /// What lies within `range` metres about the vergence `focus`; never less than a hundredth of it on either side,
    /// to be seen.
    pub(crate) fn about(focus: f64, range: f64) -> Self {
        let distance = 1.0 / focus;
        let half = range / 2.0;
        let far = if distance.is_finite() {
            1.0 / (distance + half)
        } else {
            0.0
        };
        let near = if distance - half > 0.0 {
            1.0 / (distance - half)
        } else {
            f64::INFINITY
        };
        let seen = 0.01 * focus.max(0.01);
        Self {
            far: far.min(focus - seen),
            near: near.max(focus + seen),
        }
    }
}

/// How much of the colours is seen over the picture.
const STRENGTH: f32 = 0.5;

/// Puts the source with the colours of focus over `rect`; `vergence` tells 1/m of a pixel.
pub(crate) fn focal_plane(
    (result, source): (&Pixels, &Pixels),
    rect: SeidelRect,
    focus: InFocus,
    vergence: impl Fn((i32, i32)) -> f64,
) {
    result.each(rect, |result, place| {
        let at = vergence(place);
        let tint = match at {
            _ if at > focus.near => [1.0, 0.0, 0.0],
            _ if at < focus.far => [0.0, 0.0, 1.0],
            _ => [0.0, 1.0, 0.0],
        };
        for channel in 0..result.channels() {
            let old = source.get(place, channel).unwrap_or(0.0);
            let new = match tint.get(channel as usize) {
                Some(tint) => old * (1.0 - STRENGTH) + tint * STRENGTH,
                None => old,
            };
            result.put(place, channel, new);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_is_seen_and_ends_nowhere_wrong() {
        let two_metres = InFocus::about(0.5, 1.0);
        assert_eq!((two_metres.far, two_metres.near), (1.0 / 2.5, 1.0 / 1.5));
        let thin = InFocus::about(0.5, 0.0);
        assert!(thin.far < 0.5 && thin.near > 0.5);
        assert_eq!(InFocus::about(0.5, 10.0).near, f64::INFINITY);
        let endless = InFocus::about(0.0, 1.0);
        assert!(endless.far < 0.0 && endless.near > 0.0);
    }
}
