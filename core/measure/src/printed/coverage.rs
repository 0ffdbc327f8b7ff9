//! The part of the frame that a page covers, and where to put the page where that is not enough.

use super::{Medium, Viewing};

/// Share of a side of the frame from which on a page fills it.
const FILLED: f64 = 0.85;
/// Largest distance between neighbouring places of the page over its width: the gaps between them are half a page wide, which
/// the smooth change of a lens over the field bridges.
const LARGEST_STEP: f64 = 1.5;

/// Photographs of a page above which a larger page is advised, and the share of the frame of that page: three times three cover it.
const MAX_PHOTOGRAPHS: usize = 12;
const ADVISED_SHARE: f64 = 0.25;

/// A page in the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PageCoverage {
    /// Width and height of the page over those of the frame.
    pub share: [f64; 2],
    /// Width and height of the field of view at the distance, m.
    pub frame_m: [f64; 2],
    /// Photographs along the width and the height that cover the frame, with the page moved between them.
    pub positions: [usize; 2],
    /// Distance at which the page fills the frame with one photograph, m.
    pub filling_distance_m: f64,
}

impl PageCoverage {
    /// Returns the coverage of a sensor of `sensor_mm` by `medium`.
    pub fn of(medium: &Medium, viewing: &Viewing, sensor_mm: [f64; 2]) -> Self {
        let page_mm = medium.inner();
        let scale = (1000.0 * viewing.distance_m - viewing.focal_mm) / viewing.focal_mm;
        let frame_m = sensor_mm.map(|side| side * scale / 1000.0);
        let share = [0, 1].map(|k| page_mm[k] / (1000.0 * frame_m[k]));
        // Both sides must be filled.
        let larger = (page_mm[0] / sensor_mm[0]).min(page_mm[1] / sensor_mm[1]);
        Self {
            share,
            frame_m,
            positions: share.map(|share| {
                if share >= FILLED {
                    1
                } else {
                    ((1.0 - share) / (LARGEST_STEP * share)).ceil() as usize + 1
                }
            }),
            filling_distance_m: viewing.focal_mm * (1.0 + larger) / 1000.0,
        }
    }

    /// Returns the centres of the page along axis 0 or 1, shares of the frame: the first and the last touch its borders.
    pub fn centres(&self, axis: usize) -> Vec<f64> {
        let (share, count) = (self.share[axis].min(1.0), self.positions[axis]);
        if count == 1 {
            return vec![0.5];
        }
        let step = (1.0 - share) / (count - 1) as f64;
        (0..count).map(|k| share / 2.0 + k as f64 * step).collect()
    }

    /// Returns in words how much of the frame the page covers at `distance_m`, and what to do.
    pub fn describe(&self, distance_m: &str) -> String {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let [width, height] = self.share;
        let covers = format!(
            "at {distance_m} m the page is {} of the frame's width and {} of its height",
            percent(width),
            percent(height)
        );
        let [columns, rows] = self.positions;
        if columns * rows == 1 {
            return format!("{covers}: one photograph covers the frame");
        }
        if columns * rows > MAX_PHOTOGRAPHS {
            let [width, height] = self.frame_m.map(|side| ADVISED_SHARE * side);
            return format!(
                "{covers}: too small there; use a page of at least {width:.2} x {height:.2} m, moved to 3 x 3 places, or photograph lights"
            );
        }
        let list = |axis: usize| {
            let centres = self.centres(axis);
            centres
                .into_iter()
                .map(percent)
                .collect::<Vec<_>>()
                .join(", ")
        };
        format!(
            "{covers}: photograph it {} times at this distance, {columns} x {rows}, with its middle at {} of the width and {} of the height, and measure all photographs together; or use a larger page (it fills the frame at {:.2} m)",
            columns * rows,
            list(0),
            list(1),
            self.filling_distance_m
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn a3_at(distance_m: f64) -> PageCoverage {
        let medium = Medium {
            width_mm: 436.0,
            height_mm: 313.0,
            margin_mm: 8.0,
            pixel_mm: None,
        };
        let viewing = Viewing {
            distance_m,
            focal_mm: 50.0,
            pitch_um: 4.0,
            blur_px: 8.0,
        };
        PageCoverage::of(&medium, &viewing, [36.0, 24.0])
    }

    #[test]
    fn a_small_page_is_moved_about() {
        // 39 times the sensor: 1.404 x 0.936 m.
        let page = a3_at(2.0);
        assert!((page.share[0] - 0.42 / 1.404).abs() < 1e-12, "{page:?}");
        assert_eq!(page.positions, [3, 3]);
        let centres = page.centres(0);
        assert!((centres[0] - page.share[0] / 2.0).abs() < 1e-12 && centres[1] == 0.5);
        // Gaps of at most half a page.
        assert!(centres[1] - centres[0] <= 1.5 * page.share[0]);
        let text = page.describe("2");
        assert!(
            text.contains("30 % of the frame's width") && text.contains("9 times"),
            "{text}"
        );
    }

    #[test]
    fn a_page_too_small_to_be_moved_about_names_one_that_is_not() {
        let page = a3_at(9.35);
        let text = page.describe("9.35");
        assert!(text.contains("at least 1.67 x 1.12 m"), "{text}");
        let large = Medium {
            width_mm: 1675.0,
            height_mm: 1120.0,
            margin_mm: 0.0,
            pixel_mm: None,
        };
        let viewing = Viewing {
            distance_m: 9.35,
            focal_mm: 50.0,
            pitch_um: 4.0,
            blur_px: 8.0,
        };
        assert_eq!(
            PageCoverage::of(&large, &viewing, [36.0, 24.0]).positions,
            [3, 3]
        );
    }

    #[test]
    fn a_page_fills_the_frame_at_the_distance_it_says() {
        let page = a3_at(2.0);
        let near = a3_at(page.filling_distance_m);
        assert!(near.share.iter().all(|s| *s > 1.0 - 1e-9), "{near:?}");
        assert_eq!(near.positions, [1, 1]);
        assert_eq!(a3_at(0.7).positions, [1, 1]);
    }
}
