//! The places and distances of the tiles that a lens was fitted to, and those without a tile.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::distance::ObjectDistance;
use crate::field::Frame;

/// Share of the frame's width or height from a border without a tile that is reported. A chart on the middle half of a frame
/// gave a lens 10 dB worse at the border than one that filled it.
const MAX_BARE_SHARE: f64 = 0.2;
/// Share of the range of vergence without a tile, between two of at least three distances, that is reported.
const MAX_GAP_SHARE: f64 = 0.6;
/// Vergence, 1/m, beyond which a distance counts as measured at infinity.
const NEARLY_INFINITE_PER_M: f64 = 1e-3;

/// The tiles of a fit at one object distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TileCoverage {
    /// Vergence 1 / distance of the tiles, 1/m; left out if the distance is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vergence_per_m: Option<f64>,
    /// Number of tiles, over all channels.
    pub tiles: usize,
    /// Least and largest x of their places, frame px.
    pub x_px: [f64; 2],
    /// Least and largest y of their places, frame px.
    pub y_px: [f64; 2],
}

impl TileCoverage {
    /// Returns the object distance.
    pub fn distance(&self) -> ObjectDistance {
        match self.vergence_per_m {
            None => ObjectDistance::Unknown,
            Some(v) if v < NEARLY_INFINITE_PER_M => ObjectDistance::Infinity,
            // To the millimetre, so that 1 / (1 / 3) reads as 3.
            Some(v) => ObjectDistance::Metres((1e3 / v).round() / 1e3),
        }
    }

    /// Returns left, top, right and bottom of the part of `frame` that has tiles, px. It ends at a border that has a tile near it.
    pub fn covered_px(&self, frame: &Frame) -> [f64; 4] {
        let along = |[least, most]: [f64; 2], size: u32| {
            let size = f64::from(size);
            let bare = MAX_BARE_SHARE * size;
            // Without tiles both are infinite.
            let first = if least > bare && least <= size {
                least
            } else {
                0.0
            };
            let last = if most < size - bare && most >= 0.0 {
                most
            } else {
                size
            };
            [first, last]
        };
        let [left, right] = along(self.x_px, frame.width_px());
        let [top, bottom] = along(self.y_px, frame.height_px());
        [left, top, right, bottom]
    }

    /// Returns the sides of `frame` that have no tile near them, in words.
    pub fn bare_sides(&self, frame: &Frame) -> Vec<String> {
        let [left, top, right, bottom] = self.covered_px(frame);
        let [width, height] = [frame.width_px(), frame.height_px()].map(f64::from);
        let sides = [
            ("left (before x", left, 0.0, width),
            ("right (beyond x", right, width, width),
            ("top (before y", top, 0.0, height),
            ("bottom (beyond y", bottom, height, height),
        ];
        let bare = sides.iter().filter(|(_, at, border, _)| at != border);
        bare.map(|(side, at, _, size)| format!("{side} = {at:.0} of {size:.0} px)"))
            .collect()
    }
}

/// Returns the sides of `frame` without tiles in words, and at which distances these differ; `None` for none.
pub fn bare_sides(coverage: &[TileCoverage], frame: &Frame) -> Option<String> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for tiles in coverage {
        let (sides, distance) = (
            tiles.bare_sides(frame).join(", "),
            tiles.distance().to_string(),
        );
        match groups.iter_mut().find(|(of, _)| *of == sides) {
            Some((_, distances)) => distances.push(distance),
            None => groups.push((sides, vec![distance])),
        }
    }
    let are_alike = groups.len() == 1;
    groups.retain(|(sides, _)| !sides.is_empty());
    let words = groups.iter().map(|(sides, distances)| match are_alike {
        true => sides.clone(),
        false => format!("{sides} at {}", distances.join(", ")),
    });
    (!groups.is_empty()).then(|| words.collect::<Vec<_>>().join("; "))
}

/// Returns the ranges of distance without tiles in words; empty where no distance is known.
pub fn bare_distances(coverage: &[TileCoverage]) -> Vec<String> {
    let known = from_the_farthest(coverage);
    let (Some(far), Some(near)) = (known.first(), known.last()) else {
        return Vec::new();
    };
    if known.len() == 1 {
        return vec![format!("at a distance other than {}", far.distance())];
    }
    let beyond = (far.distance() != ObjectDistance::Infinity)
        .then(|| format!("farther than {}", far.distance()));
    let nearer = format!("nearer than {}", near.distance());
    let words = beyond.into_iter().chain(distance_gap(coverage));
    words.chain([nearer]).collect()
}

/// Returns the wide range of vergence between two of at least three distances that has no tile, in words.
pub fn distance_gap(coverage: &[TileCoverage]) -> Option<String> {
    let known = from_the_farthest(coverage);
    let vergence = |tiles: &TileCoverage| tiles.vergence_per_m.unwrap_or(0.0);
    let range = vergence(known.last()?) - vergence(known.first()?);
    let mut pairs = known.windows(2).filter(|_| known.len() > 2);
    let wide = pairs.find(|pair| vergence(pair[1]) - vergence(pair[0]) > MAX_GAP_SHARE * range)?;
    let [far, near] = [wide[0].distance(), wide[1].distance()];
    Some(format!("between {far} and {near}"))
}

/// Returns the tiles at known distances, by rising vergence.
fn from_the_farthest(coverage: &[TileCoverage]) -> Vec<&TileCoverage> {
    let mut known: Vec<&TileCoverage> = coverage.iter().collect();
    known.retain(|tiles| tiles.vergence_per_m.is_some());
    known.sort_by(|a, b| {
        let key = |tiles: &TileCoverage| tiles.vergence_per_m.unwrap_or(0.0);
        key(a).total_cmp(&key(b))
    });
    known
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(vergence_per_m: Option<f64>, x_px: [f64; 2]) -> TileCoverage {
        TileCoverage {
            vergence_per_m,
            tiles: 4,
            x_px,
            y_px: [20.0, 380.0],
        }
    }

    #[test]
    fn sides_and_distances_without_tiles_are_named() {
        let frame = Frame::new(600, 400, None).expect("a frame");
        let half = at(Some(1.0 / 3.0), [30.0, 310.0]);
        assert_eq!(
            half.bare_sides(&frame),
            ["right (beyond x = 310 of 600 px)"]
        );
        assert_eq!(half.covered_px(&frame), [0.0, 0.0, 310.0, 400.0]);
        let whole = |v| at(v, [30.0, 590.0]);
        let alone = bare_sides(std::slice::from_ref(&half), &frame);
        assert_eq!(alone.as_deref(), Some("right (beyond x = 310 of 600 px)"));
        let beside = bare_sides(&[whole(Some(0.0)), half.clone()], &frame);
        assert_eq!(
            beside.as_deref(),
            Some("right (beyond x = 310 of 600 px) at 3 m")
        );
        assert_eq!(bare_sides(&[whole(Some(0.0))], &frame), None);
        assert!(whole(None).bare_sides(&frame).is_empty());
        assert!(bare_distances(&[whole(None)]).is_empty());
        let one = bare_distances(std::slice::from_ref(&half));
        assert_eq!(one, ["at a distance other than 3 m"]);
        let two = [whole(Some(0.0)), half.clone()];
        assert_eq!(bare_distances(&two), ["nearer than 3 m"]);
        let gap = [whole(Some(1.25)), half, whole(Some(0.2))];
        assert_eq!(
            bare_distances(&gap),
            [
                "farther than 5 m",
                "between 3 m and 0.8 m",
                "nearer than 0.8 m"
            ]
        );
        let even = [0.2, 0.6, 1.0].map(|v| whole(Some(v)));
        assert_eq!(distance_gap(&even), None);
    }
}
