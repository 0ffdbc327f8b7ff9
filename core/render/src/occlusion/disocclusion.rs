//! Disocclusion fill: hidden samples behind the near side of depth edges, estimated from the visible far side.
//!
//! A blurred foreground is half transparent towards its edge and reveals what the plate does not show. Each pixel near
//! an edge gets one hidden sample of colour, alpha and vergence: the samples of the far side next to the edge, and
//! averages of ever larger cells of them further in, as far as the blur of both reaches. Where that far side is in focus its texture is
//! continued (`hidden_texture`). The rule is local
//! ([`HIDDEN_REACH_PX`]) and cells lie on grids fixed to the frame, so a tile with that much margin equals the whole.

use super::cell_pyramid::{self, CellLevel, JUMP};
use super::depth_layers::DepthLayers;
use super::edge_distance::EdgeDistance;
use super::extra_samples::{ExtraSamples, SPARE_PX};
use super::hidden_texture::VisibleTexture;
use super::layered_plate::LayeredPlate;
use crate::Scene;
use rayon::prelude::*;
use std::ops::Range;

/// Largest number of levels of the cell pyramid.
const MAX_LEVELS: u32 = 8;

/// Largest distance between a hidden sample and the pixels it is estimated from, px.
pub const HIDDEN_REACH_PX: usize = 3 << (MAX_LEVELS - 1);

/// Side of the largest cells, px.
const LARGEST_CELL_PX: usize = 1 << MAX_LEVELS;

/// Shifts of the grids of cells from the frame's, px: about a third of a cell of every size, each with its mirror images.
///
/// All are odd, so that the finest cells, of 2 px, are the same on all of them. The estimates of all grids are averaged. Those of one depend on where its cells lie by 0.3 dB, and are 0.2 dB worse.
const GRID_SHIFTS_PX: [[usize; 2]; 4] = {
    const NEAR: usize = LARGEST_CELL_PX / 3;
    const FAR: usize = LARGEST_CELL_PX - NEAR;
    [[NEAR, NEAR], [FAR, NEAR], [NEAR, FAR], [FAR, FAR]]
};

/// One over the weight at which an estimate counts as fully present: a quarter of its surroundings.
const FULL_PRESENCE: f32 = 4.0;
/// Least weight of a hidden sample.
const MIN_WEIGHT: f32 = 1e-3;

/// Side of the blocks on the frame's grid whose pixels share an estimate, px, beyond this distance from edges, and within this range of
/// layer coordinates.
const BLOCK_PX: usize = 2;
const SHARED_FROM_PX: f32 = 6.0;
const SAME_SURFACE: f32 = 0.25;

/// Returns the position of a plate's first pixel on the frame's grid of cells.
pub(super) fn grid_origin(scene: &Scene) -> [usize; 2] {
    scene.place_in_cell(LARGEST_CELL_PX)
}

/// Estimates the hidden samples of all rows; `None` once `goes_on` returns false.
pub(super) fn hidden_samples(
    input: &LayeredPlate,
    layers: &DepthLayers,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<ExtraSamples>> {
    let largest = input
        .coordinates
        .par_iter()
        .map(|coordinate| layers.size(*coordinate));
    let largest = largest.reduce(|| 0.0, f32::max);
    let reach = 2.0 * largest;
    let levels = (1..MAX_LEVELS)
        .find(|level| (1 << level) as f32 >= 6.0 * (reach + SPARE_PX))
        .unwrap_or(MAX_LEVELS);
    let band = cell_pyramid::band(input);
    let origins = GRID_SHIFTS_PX
        .map(|shift| [0, 1].map(|axis| (input.origin[axis] + shift[axis]) % LARGEST_CELL_PX));
    let planes = input.planes.len();
    let build_grids = || {
        let finest = cell_pyramid::finest(input, origins[0], &band);
        let grid = |origin: [usize; 2]| CellGrid {
            origin,
            coarser: cell_pyramid::coarser(input, origin, &finest, levels)
                .into_iter()
                .zip(2..)
                .map(|(cells, level)| SizedLevel::new(cells, level, planes, layers))
                .collect(),
        };
        let grids: Vec<CellGrid> = origins.into_par_iter().map(grid).collect();
        CellGrids {
            finest: SizedLevel::new(finest, 1, planes, layers),
            grids,
        }
    };
    // The distances take one thread.
    let (cells, distance) = rayon::join(build_grids, || EdgeDistance::new(&band, input.width));
    let edges = NearbyEdges {
        distance,
        largest_size: largest,
    };
    let search = HiddenSearch {
        input,
        layers,
        cells: &cells,
        edges: &edges,
    };
    let first = input.origin[1] % BLOCK_PX;
    let rows: Option<Vec<_>> = (0..(first + input.height).div_ceil(BLOCK_PX))
        .into_par_iter()
        // Edges may lie in few rows.
        .with_max_len(4)
        .map(|block| {
            let start = (block * BLOCK_PX).saturating_sub(first);
            let end = ((block + 1) * BLOCK_PX - first).min(input.height);
            goes_on().then(|| search.rows(start..end))
        })
        .collect();
    let mut rows: Vec<ExtraSamples> = rows?.into_iter().flatten().collect();
    let texture = VisibleTexture {
        input,
        layers,
        distance: &edges.distance,
        band: &band,
    };
    texture.continue_behind(&mut rows);
    goes_on().then_some(rows)
}

/// The grids of cells, which share the finest ones.
struct CellGrids {
    finest: SizedLevel,
    grids: Vec<CellGrid>,
}

/// Cells on one of the grids, but for the finest ones.
struct CellGrid {
    /// Position of the plate's first pixel on the grid.
    origin: [usize; 2],
    coarser: Vec<SizedLevel>,
}

/// The cells of one size, and the surface of each.
struct SizedLevel {
    /// Binary logarithm of the side of a cell in px, and the side.
    level: u32,
    side: f32,
    cells: CellLevel,
    surfaces: Vec<CellSurface>,
    /// Coordinate and samples, then zeros, cell by cell: the numbers that an estimate sums.
    records: Vec<Lanes>,
}

/// Numbers that are summed side by side.
type Lanes = [f32; 4];

/// Returns the number of [`Lanes`] of a coordinate and the samples of `planes`.
fn lanes(planes: usize) -> usize {
    (1 + planes).div_ceil(size_of::<Lanes>() / size_of::<f32>())
}

/// The farthest surface of a cell.
struct CellSurface {
    coordinate: f32,
    /// Kernel size at its depth, px.
    size: f32,
    /// Factor on its weight. A cell of mixed pixels alone counts little beside a larger one. So does a cell that a moving edge has only
    /// just reached: the band along an edge across the cell has a weight of four times its side.
    known: f32,
}

impl SizedLevel {
    fn new(cells: CellLevel, level: u32, planes: usize, layers: &DepthLayers) -> Self {
        let side = (1 << level) as f32;
        let all = cells.weight.par_iter().zip(&cells.coordinate);
        let surface = |(weight, coordinate): (&f32, &f32)| CellSurface {
            coordinate: *coordinate,
            size: layers.size(*coordinate),
            known: (weight / side).min(1.0),
        };
        let surfaces = all.map(surface).collect();
        let mut records = vec![Lanes::default(); lanes(planes) * cells.coordinate.len()];
        let numbers = records.as_flattened_mut();
        let of_cells = numbers.par_chunks_mut(numbers.len() / cells.coordinate.len());
        let read = cells
            .coordinate
            .par_iter()
            .zip(cells.samples.par_chunks(planes));
        of_cells
            .zip(read)
            .for_each(|(record, (coordinate, samples))| {
                record[0] = *coordinate;
                record[1..=planes].copy_from_slice(samples);
            });
        Self {
            level,
            side,
            surfaces,
            records,
            cells,
        }
    }
}

/// The edges of a plate, and how far blur reaches across them.
struct NearbyEdges {
    distance: EdgeDistance,
    /// Largest kernel size on the plate, px.
    largest_size: f32,
}

/// The search for the hidden samples of a plate.
struct HiddenSearch<'a> {
    input: &'a LayeredPlate<'a>,
    layers: &'a DepthLayers,
    cells: &'a CellGrids,
    edges: &'a NearbyEdges,
}

impl HiddenSearch<'_> {
    /// Returns the hidden samples of the `rows` of one block.
    fn rows(&self, rows: Range<usize>) -> Vec<ExtraSamples> {
        let (width, first) = (self.input.width, self.input.origin[0] % BLOCK_PX);
        let mut estimate = HiddenEstimates::of_planes(self.input.planes.len());
        let lines: Vec<CellLines> = (rows.clone())
            .map(|row| CellLines::new(self.cells, row as f32 + 0.5))
            .collect();
        let middle = rows.start as f32 + 0.5 * BLOCK_PX as f32;
        let of_block = (rows.len() == BLOCK_PX).then(|| CellLines::new(self.cells, middle));
        let mut out = vec![ExtraSamples::default(); rows.len()];
        for block in 0..(first + width).div_ceil(BLOCK_PX) {
            let start = (block * BLOCK_PX).saturating_sub(first);
            let columns = start..((block + 1) * BLOCK_PX - first).min(width);
            let shared = of_block.as_ref().filter(|_| columns.len() == BLOCK_PX);
            let near = shared.and_then(|_| self.common_surface(&rows, &columns));
            if let (Some(lines), Some(near)) = (shared, &near) {
                estimate.find(lines, columns.start as f32 + 0.5 * BLOCK_PX as f32, near);
            }
            for (row, (lines, out)) in rows.clone().zip(lines.iter().zip(&mut out)) {
                for column in columns.clone() {
                    let own = self.pixel(row * width + column);
                    if !self.may_uncover(&own) {
                        continue;
                    }
                    if near.is_none() {
                        estimate.find(lines, column as f32 + 0.5, &own);
                    }
                    self.add(column, &own, &estimate.mean, out);
                }
            }
        }
        out
    }

    fn pixel(&self, index: usize) -> Nearer {
        let coordinate = self.input.coordinates[index];
        Nearer {
            coordinate,
            size: self.layers.size(coordinate),
            distance_px: self.edges.distance.px(index),
        }
    }

    /// Whether blur may uncover a sample behind a pixel.
    fn may_uncover(&self, pixel: &Nearer) -> bool {
        let reach = pixel.size + self.edges.largest_size + SPARE_PX;
        share_uncovered(pixel.distance_px, reach) > 0.0
    }

    /// Returns the mean of a block of pixels that share an estimate: those of one surface away from edges, where estimates change slowly.
    fn common_surface(&self, rows: &Range<usize>, columns: &Range<usize>) -> Option<Nearer> {
        let mut mean = Nearer {
            coordinate: 0.0,
            size: 0.0,
            distance_px: f32::INFINITY,
        };
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for row in rows.clone() {
            for column in columns.clone() {
                let pixel = self.pixel(row * self.input.width + column);
                mean.coordinate += pixel.coordinate;
                mean.size += pixel.size;
                mean.distance_px = mean.distance_px.min(pixel.distance_px);
                (least, most) = (least.min(pixel.coordinate), most.max(pixel.coordinate));
            }
        }
        let count = (BLOCK_PX * BLOCK_PX) as f32;
        (mean.coordinate, mean.size) = (mean.coordinate / count, mean.size / count);
        (mean.distance_px > SHARED_FROM_PX && most - least < SAME_SURFACE).then_some(mean)
    }

    /// Adds the sample of an `estimate` behind the pixel in a `column`, where there is one.
    fn add(&self, column: usize, own: &Nearer, estimate: &HiddenEstimate, out: &mut ExtraSamples) {
        if estimate.weight <= MIN_WEIGHT {
            return;
        }
        let behind = estimate.coordinate() / estimate.weight;
        let reach = own.size + self.layers.size(behind) + SPARE_PX;
        let presence =
            (FULL_PRESENCE * estimate.weight).min(1.0) * share_uncovered(own.distance_px, reach);
        if presence > MIN_WEIGHT {
            out.columns.push(column as u32);
            out.weights.push(presence);
            out.coordinates.push(behind);
            let gain = presence / estimate.weight;
            let samples = estimate.samples(self.input.planes.len());
            out.samples
                .extend(samples.iter().map(|sample| gain * sample));
        }
    }
}

/// Returns the presence of hidden samples at a distance from the nearest edge, where blur `reach`es across it: none beyond one and a half
/// times the reach.
///
/// Blur uncovers no sample farther away. It would show in the gaps between the slices of a slanted surface, and change with whatever moves
/// near the edge.
fn share_uncovered(distance_px: f32, reach: f32) -> f32 {
    (3.0 - 2.0 * distance_px / reach).clamp(0.0, 1.0)
}

/// The cells of all sizes and grids around a row of pixels, or between two.
struct CellLines<'a> {
    /// The finest ones, and the place of the plate's first column on their grid.
    finest: (usize, CellRows<'a>),
    coarser: Vec<(usize, Vec<CellRows<'a>>)>,
}

impl<'a> CellLines<'a> {
    /// The cells around the height `y`, px from the top of the plate.
    fn new(cells: &'a CellGrids, y: f32) -> Self {
        let coarser = cells.grids.iter().map(|grid| {
            let levels = grid.coarser.iter();
            let rows = levels.map(|level| CellRows::new(level, grid.origin, y));
            (grid.origin[0], rows.collect())
        });
        let origin = cells.grids[0].origin;
        Self {
            finest: (origin[0], CellRows::new(&cells.finest, origin, y)),
            coarser: coarser.collect(),
        }
    }
}

/// The two rows of cells of one level around a row of pixels.
struct CellRows<'a> {
    level: &'a SizedLevel,
    /// First cell of each row of cells with the row's interpolation weight; `None` beyond the plate.
    rows: [Option<(usize, f32)>; 2],
    /// Column of the plate's first cell on the frame's grid.
    first_column: usize,
    /// First and end column with any weight in either row, on the frame's grid.
    lit: (i32, i32),
}

impl<'a> CellRows<'a> {
    /// The rows of cells around the height `y` of a plate whose first pixel has the position `origin` on the frame's grid.
    fn new(level: &'a SizedLevel, origin: [usize; 2], y: f32) -> Self {
        let cells = &level.cells;
        let first = origin.map(|at| at >> level.level);
        let at = (y + origin[1] as f32) / level.side - 0.5;
        let row = at.floor();
        let share = at - row;
        let found = |dy: i64, share: f32| {
            cells
                .row(row as i64 + dy - first[1] as i64)
                .map(|first| (first, share))
        };
        let rows = [found(0, 1.0 - share), found(1, share)];
        let mut lit = (i32::MAX, i32::MIN);
        for (start, _) in rows.iter().flatten() {
            let weights = &cells.weight[*start..start + cells.columns];
            if let Some(start) = weights.iter().position(|w| *w > 0.0) {
                let end = weights.iter().rposition(|w| *w > 0.0).unwrap_or(start) + 1;
                let on_grid = |column: usize| (column + first[0]) as i32;
                lit = (lit.0.min(on_grid(start)), lit.1.max(on_grid(end)));
            }
        }
        Self {
            level,
            rows,
            first_column: first[0],
            lit,
        }
    }
}

/// Estimates of a hidden sample on all grids.
struct HiddenEstimates {
    mean: HiddenEstimate,
    of_finest: HiddenEstimate,
    of_grid: HiddenEstimate,
}

impl HiddenEstimates {
    fn of_planes(planes: usize) -> Self {
        let [mean, of_finest, of_grid] = [0; 3].map(|_| HiddenEstimate::of_planes(planes));
        Self {
            mean,
            of_finest,
            of_grid,
        }
    }

    /// Estimates what lies behind a place of the plate `x` px from its left border.
    fn find(&mut self, lines: &CellLines, x: f32, near: &Nearer) {
        self.mean.clear();
        self.of_finest.clear();
        let (first, finest) = &lines.finest;
        self.of_finest.add_line(finest, x + *first as f32, near);
        for (first, lines_of_grid) in &lines.coarser {
            self.of_grid.copy_from(&self.of_finest);
            for line in lines_of_grid {
                self.of_grid.add_line(line, x + *first as f32, near);
            }
            self.mean
                .add_share(&self.of_grid, 1.0 / lines.coarser.len() as f32);
        }
    }
}

/// A pixel of a near surface.
struct Nearer {
    coordinate: f32,
    /// Kernel size, px.
    size: f32,
    /// Distance from the nearest edge.
    distance_px: f32,
}

/// The estimate of a hidden sample, accumulated from fine cells to coarse ones.
struct HiddenEstimate {
    weight: f32,
    /// Coordinate and samples, as [`SizedLevel::records`], multiplied by the weight.
    sums: Vec<Lanes>,
}

impl HiddenEstimate {
    fn of_planes(planes: usize) -> Self {
        Self {
            weight: 0.0,
            sums: vec![Lanes::default(); lanes(planes)],
        }
    }

    fn coordinate(&self) -> f32 {
        self.sums.as_flattened()[0]
    }

    fn samples(&self, planes: usize) -> &[f32] {
        &self.sums.as_flattened()[1..=planes]
    }

    fn clear(&mut self) {
        self.weight = 0.0;
        self.sums.fill(Lanes::default());
    }

    fn copy_from(&mut self, other: &Self) {
        self.weight = other.weight;
        self.sums.copy_from_slice(&other.sums);
    }

    /// Adds a `share` of another estimate.
    fn add_share(&mut self, other: &Self, share: f32) {
        self.weight += share * other.weight;
        self.add_record(&other.sums, share);
    }

    /// Adds the hidden samples of the cells of one size around the place `x` of their grid.
    fn add_line(&mut self, line: &CellRows, x: f32, near: &Nearer) {
        let left = 1.0 - self.weight;
        // The four cells reach no farther than twice their side, by the measure of `EdgeDistance`, and hold pixels at edges alone.
        if left < MIN_WEIGHT || near.distance_px > 2.0 * line.level.side {
            return;
        }
        let at = x / line.level.side - 0.5;
        // Rounds down: `at` is -0.5 or more.
        let column = (at + 1.0) as i32 - 1;
        if column + 1 < line.lit.0 || column >= line.lit.1 {
            return;
        }
        let share = at - column as f32;
        for (first, across) in line.rows.iter().flatten() {
            for (column, down) in [(column, 1.0 - share), (column + 1, share)] {
                if column < line.lit.0 || column >= line.lit.1 {
                    continue;
                }
                let cell = first + column as usize - line.first_column;
                let share = left * across * down;
                self.add_cell(line.level, cell, share, near);
            }
        }
    }

    /// Adds a cell with a weight of up to `share`, as far as it lies behind the pixel and within reach of its blur.
    fn add_cell(&mut self, level: &SizedLevel, cell: usize, share: f32, near: &Nearer) {
        let surface = &level.surfaces[cell];
        let behind = (near.coordinate - surface.coordinate - JUMP / 2.0).clamp(0.0, 1.0);
        if surface.known == 0.0 || behind == 0.0 {
            return;
        }
        // Cells up to four thirds of the reach of the blur count in full, those from four times it on not at all.
        let reach = near.size + surface.size + SPARE_PX;
        let within = (2.0 * reach / level.side - 0.5).clamp(0.0, 1.0);
        let weight = share * behind * within * surface.known;
        self.weight += weight;
        let lanes = self.sums.len();
        self.add_record(&level.records[cell * lanes..][..lanes], weight);
    }

    fn add_record(&mut self, record: &[Lanes], weight: f32) {
        for (sums, numbers) in self.sums.iter_mut().zip(record) {
            for (sum, number) in sums.iter_mut().zip(numbers) {
                *sum += weight * number;
            }
        }
    }
}
