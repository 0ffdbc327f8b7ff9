//! The blocks of a photograph: regions that the chart covers.

use super::Measurement;
use super::picture::Region;

/// Side of a block over that of its tile, and its least value, px.
const BLOCK_OVER_TILE: usize = 4;
const MIN_BLOCK: usize = 72;
/// Largest side of a block over the least that its tile needs.
const LARGEST_BLOCK: f64 = 1.3;
/// Blocks along the longer side of the chart.
const MAX_BLOCKS: usize = 12;

impl Measurement<'_> {
    /// Returns the blocks, evenly spaced over the chart: over the rectangle that it holds, or over the one that holds it
    /// where that gives more, as for charts that are turned much.
    pub(super) fn blocks(&self) -> Vec<Region> {
        let [width, height] = self.chart(0).size().map(|v| v as f64);
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        let places = corners.into_iter().filter_map(|c| self.map.photo_of(c));
        let places: Vec<[f64; 2]> = places.collect();
        if places.len() < 4 {
            return Vec::new();
        }
        let sorted = |axis: usize| {
            let mut values: Vec<f64> = places.iter().map(|p| p[axis]).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let (x, y) = (sorted(0), sorted(1));
        let inner = self.blocks_within([x[1], y[1]], [x[2], y[2]]);
        let outer = self.blocks_within([x[0], y[0]], [x[3], y[3]]);
        if outer.len() > inner.len() {
            outer
        } else {
            inner
        }
    }

    /// Returns the blocks of a rectangle that chart and photograph cover.
    fn blocks_within(&self, from: [f64; 2], to: [f64; 2]) -> Vec<Region> {
        // Pixels near the chart's border receive light from beyond it.
        let margin = if self.has_white_surround {
            0.0
        } else {
            (self.side / 2 + 1) as f64
        };
        let [left, top] = from.map(|v| (v + margin).max(0.0));
        let right = (to[0] - margin).min(self.photo.width as f64);
        let bottom = (to[1] - margin).min(self.photo.height as f64);
        let side = MIN_BLOCK.max(BLOCK_OVER_TILE * self.side);
        let longest = (right - left).max(bottom - top);
        let spacing = (longest / MAX_BLOCKS as f64).max(side as f64);
        let count = |length: f64| ((length / spacing).round() as usize).max(1);
        let (columns, rows) = (count(right - left), count(bottom - top));
        let (dx, dy) = (
            (right - left) / columns as f64,
            (bottom - top) / rows as f64,
        );
        let mut blocks = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let x = left + (column as f64 + 0.5) * dx;
                let y = top + (row as f64 + 0.5) * dy;
                let size = |d: f64| d.min(LARGEST_BLOCK * side as f64) as usize;
                let region = Region {
                    left: (x - size(dx) as f64 / 2.0).round().max(0.0) as i64,
                    top: (y - size(dy) as f64 / 2.0).round().max(0.0) as i64,
                    width: size(dx),
                    height: size(dy),
                };
                if self.is_inside(region, margin) {
                    blocks.push(region);
                }
            }
        }
        blocks
    }

    /// Returns whether the photograph holds the whole block and the chart covers it.
    fn is_inside(&self, r: Region, margin: f64) -> bool {
        let (right, bottom) = (r.left + r.width as i64, r.top + r.height as i64);
        if r.left < 0
            || r.top < 0
            || right > self.photo.width as i64
            || bottom > self.photo.height as i64
        {
            return false;
        }
        let [width, height] = self.chart(0).size().map(|v| v as f64);
        let [left, top, right, bottom] = [
            r.left as f64 - margin,
            r.top as f64 - margin,
            right as f64 + margin,
            bottom as f64 + margin,
        ];
        // Rounding to pixels, and where the surround is known also the slant of a chart's sides.
        let slack = if self.has_white_surround { 0.02 } else { 0.01 };
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        corners.iter().all(|c| {
            let [x, y] = self.map.chart_of(*c);
            let within = |v: f64, most: f64| (-slack * most..(1.0 + slack) * most).contains(&v);
            within(x, width) && within(y, height)
        })
    }
}
