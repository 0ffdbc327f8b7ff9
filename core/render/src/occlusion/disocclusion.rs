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
    let build_grids = || {
        let finest = cell_pyramid::finest(input, origins[0], &band);
        let grid = |origin: [usize; 2]| CellGrid {
            origin,
            coarser: cell_pyramid::coarser(input, origin, &finest, levels)
                .into_iter()
                .zip(2..)
                .map(|(cells, level)| SizedLevel::new(cells, level, layers))
                .collect(),
        };
        let grids: Vec<CellGrid> = origins.into_par_iter().map(grid).collect();
        CellGrids {
            finest: SizedLevel::new(finest, 1, layers),
            grids,
        }
    };
    // The distances take one thread.
    let (cells, distance) = rayon::join(build_grids, || EdgeDistance::new(&band, input.width));
    let edges = NearbyEdges {
        distance,
        largest_size: largest,
    };
    let rows: Option<Vec<_>> = (0..input.height)
        .into_par_iter()
        // Edges may lie in few rows.
        .with_max_len(8)
        .map(|row| goes_on().then(|| hidden_row(input, layers, &cells, &edges, row)))
        .collect();
    let mut rows = rows?;
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
    fn new(cells: CellLevel, level: u32, layers: &DepthLayers) -> Self {
        let side = (1 << level) as f32;
        let all = cells.weight.par_iter().zip(&cells.coordinate);
        let surface = |(weight, coordinate): (&f32, &f32)| CellSurface {
            coordinate: *coordinate,
            size: layers.size(*coordinate),
            known: (weight / side).min(1.0),
        };
        Self {
            level,
            side,
            surfaces: all.map(surface).collect(),
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

fn hidden_row(
    input: &LayeredPlate,
    layers: &DepthLayers,
    cells: &CellGrids,
    edges: &NearbyEdges,
    row: usize,
) -> ExtraSamples {
    let mut out = ExtraSamples::default();
    let [mut estimate, mut of_grid] = [0; 2].map(|_| HiddenEstimate {
        samples: vec![0.0; input.planes.len()],
        ..HiddenEstimate::default()
    });
    let grids = &cells.grids;
    let lines: Vec<(usize, Vec<CellRows>)> = grids
        .iter()
        .map(|grid| {
            let levels = std::iter::once(&cells.finest).chain(&grid.coarser);
            let rows = levels.map(|level| CellRows::new(level, grid.origin, row));
            (grid.origin[0], rows.collect())
        })
        .collect();
    for column in 0..input.width {
        let index = row * input.width + column;
        let coordinate = input.coordinates[index];
        let (own, distance_px) = (layers.size(coordinate), edges.distance.px(index));
        if share_uncovered(distance_px, own + edges.largest_size + SPARE_PX) == 0.0 {
            continue;
        }
        estimate.clear();
        for (first, lines) in &lines {
            of_grid.estimate(lines, own, column + first, coordinate);
            estimate.add_share(&of_grid, 1.0 / grids.len() as f32);
        }
        if estimate.weight <= MIN_WEIGHT {
            continue;
        }
        let behind = estimate.coordinate / estimate.weight;
        let reach = own + layers.size(behind) + SPARE_PX;
        let presence =
            (FULL_PRESENCE * estimate.weight).min(1.0) * share_uncovered(distance_px, reach);
        if presence > MIN_WEIGHT {
            out.columns.push(column as u32);
            out.weights.push(presence);
            out.coordinates.push(behind);
            let gain = presence / estimate.weight;
            out.samples
                .extend(estimate.samples.iter().map(|sample| gain * sample));
        }
    }
    out
}

/// Returns the presence of hidden samples at a distance from the nearest edge, where blur `reach`es across it: none beyond one and a half
/// times the reach.
///
/// Blur uncovers no sample farther away. It would show in the gaps between the slices of a slanted surface, and change with whatever moves
/// near the edge.
fn share_uncovered(distance_px: f32, reach: f32) -> f32 {
    (3.0 - 2.0 * distance_px / reach).clamp(0.0, 1.0)
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
    /// The rows of cells around row `y` of a plate whose first pixel has the position `origin` on the frame's grid.
    fn new(level: &'a SizedLevel, origin: [usize; 2], y: usize) -> Self {
        let cells = &level.cells;
        let first = origin.map(|at| at >> level.level);
        let at = ((y + origin[1]) as f32 + 0.5) / level.side - 0.5;
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

/// The estimate of a hidden sample, accumulated from fine cells to coarse ones.
#[derive(Default)]
struct HiddenEstimate {
    weight: f32,
    /// Multiplied by the weight, as the samples are.
    coordinate: f32,
    samples: Vec<f32>,
}

impl HiddenEstimate {
    fn clear(&mut self) {
        (self.weight, self.coordinate) = (0.0, 0.0);
        self.samples.fill(0.0);
    }

    /// Adds a `share` of another estimate.
    fn add_share(&mut self, other: &Self, share: f32) {
        self.weight += share * other.weight;
        self.coordinate += share * other.coordinate;
        for (sum, sample) in self.samples.iter_mut().zip(&other.samples) {
            *sum += share * sample;
        }
    }

    /// Estimates what lies behind the pixel in column `x` of the frame's grid with a layer `coordinate` and a kernel of `size`.
    fn estimate(&mut self, lines: &[CellRows], size: f32, x: usize, coordinate: f32) {
        self.clear();
        for line in lines {
            let left = 1.0 - self.weight;
            if left < MIN_WEIGHT {
                return;
            }
            let at = (x as f32 + 0.5) / line.level.side - 0.5;
            // Rounds down: `at` is -0.5 or more.
            let column = (at + 1.0) as i32 - 1;
            if column + 1 < line.lit.0 || column >= line.lit.1 {
                continue;
            }
            let share = at - column as f32;
            for (first, across) in line.rows.iter().flatten() {
                for (column, down) in [(column, 1.0 - share), (column + 1, share)] {
                    if column < line.lit.0 || column >= line.lit.1 {
                        continue;
                    }
                    let cell = first + column as usize - line.first_column;
                    let share = left * across * down;
                    self.add_cell(line.level, cell, share, coordinate, size);
                }
            }
        }
    }

    /// Adds a cell with a weight of up to `share`, as far as it lies behind `coordinate` and within reach of a blur of
    /// `size`.
    fn add_cell(
        &mut self,
        level: &SizedLevel,
        cell: usize,
        share: f32,
        coordinate: f32,
        size: f32,
    ) {
        let surface = &level.surfaces[cell];
        let behind = (coordinate - surface.coordinate - JUMP / 2.0).clamp(0.0, 1.0);
        if surface.known == 0.0 || behind == 0.0 {
            return;
        }
        // Cells up to four thirds of the reach of the blur count in full, those from four times it on not at all.
        let reach = size + surface.size + SPARE_PX;
        let near = (2.0 * reach / level.side - 0.5).clamp(0.0, 1.0);
        self.add(&level.cells, cell, share * behind * near * surface.known);
    }

    fn add(&mut self, level: &CellLevel, cell: usize, weight: f32) {
        self.weight += weight;
        self.coordinate += weight * level.coordinate[cell];
        let planes = self.samples.len();
        let from = &level.samples[cell * planes..(cell + 1) * planes];
        for (sum, sample) in self.samples.iter_mut().zip(from) {
            *sum += weight * sample;
        }
    }
}
