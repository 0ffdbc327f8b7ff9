//! The beam from a point of the scene to the sensor.
//!
//! Rays form a grid in the plane of the designed entrance pupil. Equal areas of that plane have equal light. A ray counts
//! if it passes the real stop and the clear apertures.

use super::assembly::{Assembly, Landing};
use super::vector::Vector;
use crate::mask::Mask;
use crate::rays::{Cell, RayBundle};

/// Half the width of the region of the entrance pupil that is searched for rays through the stop, pupil radii.
const SEARCH: f64 = 1.8;
/// Rays across that region.
const SEARCH_RAYS: usize = 27;
/// Rays across the beam that determine its centroid and radius.
const CENTROID_CELLS: usize = 28;

/// A beam of one channel.
pub(super) struct Beam<'a> {
    assembly: &'a Assembly,
    channel: usize,
    object: Vector,
    mask: &'a Mask,
    /// Middle and half width of the part of the entrance pupil that holds the beam, mm.
    middle: [f64; 2],
    half: [f64; 2],
}

/// A cell of a beam through which light passes.
#[derive(Debug, Clone, Copy)]
pub(super) struct OpenCell {
    /// Its light; 1 for an open cell.
    pub(super) light: f64,
    /// Its middle in the stop, stop radii.
    pub(super) stop: [f64; 2],
    /// Its mean landing point, frame px.
    pub(super) at: [f64; 2],
}

/// A ray of a beam; `None` where the lens passes none.
pub(super) type BeamRay = Option<Landing>;

impl<'a> Beam<'a> {
    /// Finds the beam from the object point; `None` if no light passes.
    pub(super) fn new(
        assembly: &'a Assembly,
        channel: usize,
        object: Vector,
        mask: &'a Mask,
    ) -> Option<Self> {
        let pupil = assembly.view.pupil_mm;
        let step = 2.0 * SEARCH * pupil / (SEARCH_RAYS - 1) as f64;
        let at = |i: usize| i as f64 * step - SEARCH * pupil;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let aims =
            (0..SEARCH_RAYS * SEARCH_RAYS).map(|i| [at(i % SEARCH_RAYS), at(i / SEARCH_RAYS)]);
        let landings = assembly.follow_all(channel, object, aims.clone());
        for (aim, landing) in aims.zip(landings) {
            let open = |l: Landing| l.stop[0].hypot(l.stop[1]) <= 1.0 && l.inside_mm >= 0.0;
            if landing.is_some_and(open) {
                for axis in 0..2 {
                    low[axis] = low[axis].min(aim[axis]);
                    high[axis] = high[axis].max(aim[axis]);
                }
            }
        }
        if !(low[0].is_finite() && low[1].is_finite()) {
            return None;
        }
        Some(Self {
            assembly,
            channel,
            object,
            mask,
            middle: std::array::from_fn(|i| 0.5 * (low[i] + high[i])),
            half: std::array::from_fn(|i| 0.5 * (high[i] - low[i]) + step),
        })
    }

    /// Calls `each` with every open cell of a grid of `cells` across.
    pub(super) fn for_each(&self, cells: usize, mut each: impl FnMut(OpenCell)) {
        let width = 2.0 / cells as f64;
        let row_of = |row: usize| -> Vec<BeamRay> {
            let y = row as f64 * width - 1.0;
            self.rays((0..=cells).map(|column| [column as f64 * width - 1.0, y]))
        };
        let mut above = row_of(0);
        for row in 0..cells {
            let below = row_of(row + 1);
            for column in 0..cells {
                let corners = [
                    &above[column],
                    &above[column + 1],
                    &below[column],
                    &below[column + 1],
                ];
                let light = self.light(&Cell {
                    middle: [0.0; 2],
                    width,
                    corners,
                });
                if light > 0.0 {
                    let mean = |points: [[f64; 2]; 4]| {
                        std::array::from_fn(|i| 0.25 * points.iter().map(|p| p[i]).sum::<f64>())
                    };
                    let stop = |ray: &BeamRay| ray.map_or([0.0; 2], |landing| landing.stop);
                    each(OpenCell {
                        light,
                        stop: mean(corners.map(stop)),
                        at: mean(corners.map(Self::landing)),
                    });
                }
            }
            above = below;
        }
    }

    /// Returns the mean landing point, frame px.
    pub(super) fn centroid(&self) -> [f64; 2] {
        let (mut sum, mut light) = ([0.0; 2], 0.0);
        self.for_each(CENTROID_CELLS, |cell| {
            sum[0] += cell.light * cell.at[0];
            sum[1] += cell.light * cell.at[1];
            light += cell.light;
        });
        sum.map(|s| s / light)
    }

    /// Returns the largest distance of a ray from the centroid, px.
    pub(super) fn largest_radius_px(&self) -> f64 {
        let [x, y] = self.centroid();
        let mut most = 0.0_f64;
        self.for_each(CENTROID_CELLS, |cell| {
            most = most.max((cell.at[0] - x).hypot(cell.at[1] - y));
        });
        most
    }
}

impl RayBundle for Beam<'_> {
    type Ray = BeamRay;

    fn origin(&self) -> [f64; 2] {
        [0.0; 2]
    }

    fn half_width(&self, _y: f64) -> f64 {
        1.0
    }

    fn rays(&self, points: impl Iterator<Item = [f64; 2]>) -> Vec<BeamRay> {
        let aims = points.map(|m| std::array::from_fn(|i| self.middle[i] + self.half[i] * m[i]));
        (self.assembly).follow_all(self.channel, self.object, aims)
    }

    fn landing(ray: &BeamRay) -> [f64; 2] {
        ray.map_or([0.0; 2], |landing| landing.at)
    }

    fn light(&self, cell: &Cell<BeamRay>) -> f64 {
        let [Some(a), Some(b), Some(c), Some(d)] = cell.corners else {
            return 0.0;
        };
        let stop = |i: usize| 0.25 * (a.stop[i] + b.stop[i] + c.stop[i] + d.stop[i]);
        // The diagonals span twice the area of the cell in the stop.
        let (p, q) = (
            [d.stop[0] - a.stop[0], d.stop[1] - a.stop[1]],
            [c.stop[0] - b.stop[0], c.stop[1] - b.stop[1]],
        );
        let width = (0.5 * (p[0] * q[1] - p[1] * q[0]).abs()).sqrt();
        let light = self.mask.light([stop(0), stop(1)], width);
        if light == 0.0 {
            return 0.0;
        }
        let inside = [a, b, c, d].map(|corner| corner.inside_mm);
        let least = inside.iter().copied().fold(f64::INFINITY, f64::min);
        if least >= 0.0 {
            return light;
        }
        let [a, b, c, d] = inside;
        let change = (0.5 * (b - a + d - c)).hypot(0.5 * (c - a + d - b));
        light * (0.5 + 0.25 * (a + b + c + d) / change.max(1e-12)).clamp(0.0, 1.0)
    }
}
