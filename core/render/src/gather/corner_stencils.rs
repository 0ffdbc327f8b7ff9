//! Stencils at the corners of tiles, interpolated from kernels drawn at the nodes of the grid.

use super::kernel_store::{KernelKey, Truncation};
use super::lens_probe::LensProbe;
use super::passband;
use super::stencil::Stencil;
use super::tile_grid::{GridIndex, TileGrid};
use crate::Edges;
use crate::scatter::Source;
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::moments::CentralMoments;
use seidel_optics::psf::{KernelRows, LocalBlur};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// Optional values on a rectangle of nodes.
pub(super) struct SparseGrid<T> {
    columns: Range<i32>,
    rows: Range<i32>,
    values: Vec<Option<T>>,
}

impl<T> SparseGrid<T> {
    /// Creates an empty grid that covers `wanted` nodes.
    fn covering(wanted: &BTreeSet<GridIndex>) -> Self {
        let range = |of: &dyn Fn(&GridIndex) -> i32| {
            let low = wanted.iter().map(of).min().unwrap_or(0);
            low..wanted.iter().map(of).max().map_or(low, |high| high + 1)
        };
        let (rows, columns) = (range(&|node| node.row), range(&|node| node.column));
        let mut values = Vec::new();
        values.resize_with(columns.len() * rows.len(), || None);
        Self {
            columns,
            rows,
            values,
        }
    }

    fn slot(&self, node: GridIndex) -> Option<usize> {
        let GridIndex { row, column } = node;
        let inside = self.columns.contains(&column) && self.rows.contains(&row);
        inside.then(|| {
            (row - self.rows.start) as usize * self.columns.len()
                + (column - self.columns.start) as usize
        })
    }

    /// Returns the value at `node`.
    pub(super) fn at(&self, node: GridIndex) -> Option<&T> {
        self.values[self.slot(node)?].as_ref()
    }

    fn put(&mut self, node: GridIndex, value: T) {
        if let Some(slot) = self.slot(node) {
            self.values[slot] = Some(value);
        }
    }
}

/// One stencil per channel mix.
pub(super) type MixStencils = Vec<Stencil>;

/// One stencil per lens channel; `None` for unused channels.
type ChannelStencils = Vec<Option<Arc<Stencil>>>;

/// Margin by which kernels of a coarse level may reach farther than those of the plate, pixels of the level.
const ROOM_PX: f64 = 2.0 + passband::SIDE_TAPS as f64;

/// Area of a kernel over that of its part that lands on the plate, beyond which only the part is drawn.
const LARGE_KERNEL: f64 = 8.0;

/// Area of a stencil over that of its part with sources on the plate, beyond which only the part is computed. It is four in the
/// corner of a plate with a narrow blur.
const LARGE_STENCIL: usize = 4;

/// Kernels drawn at nodes, mirrored.
struct NodeKernels {
    kernels: SparseGrid<ChannelStencils>,
    /// Upper bound of how many tiles a kernel reaches.
    far: i32,
}

/// Computes the stencils at `wanted` corners of `grid`; no light travels farther than `reach`, plate px.
///
/// # Errors
/// A lens that cannot be drawn at some node.
pub(super) fn compute(
    lens: &LensProbe,
    grid: &TileGrid,
    wanted: &BTreeSet<GridIndex>,
    reach: i32,
    edges: Edges,
) -> Result<SparseGrid<MixStencils>> {
    let nodes = node_kernels(lens, grid, wanted, reach, edges)?;
    let list: Vec<_> = wanted.iter().copied().collect();
    // Channels are truncated before they are mixed: a mix of planes is then blurred exactly as its planes are.
    let stencils: Vec<MixStencils> = list
        .par_iter()
        .map(|corner| {
            let channels: ChannelStencils = (0..lens.channel_count())
                .map(|channel| {
                    let used = lens.is_used(channel);
                    used.then(|| {
                        let share = lens.tolerance.truncated_share;
                        Arc::new(corner_stencil(grid, &nodes, channel, *corner, edges, share))
                    })
                })
                .collect();
            let mixes = lens.mixes.iter();
            mixes.map(|mix| mixed(&channels, mix)).collect()
        })
        .collect();
    let mut out = SparseGrid::covering(wanted);
    for (corner, stencils) in list.into_iter().zip(stencils) {
        out.put(corner, stencils);
    }
    Ok(out)
}

/// Draws the kernels of sources at `nodes` of `grid`, by the offset of a target from its source.
///
/// # Errors
/// A lens that cannot be drawn at some node.
pub(super) fn source_kernels(
    lens: &LensProbe,
    grid: &TileGrid,
    nodes: &BTreeSet<GridIndex>,
) -> Result<SparseGrid<MixStencils>> {
    // Light of the margin of a coarse level spreads like that at the edge of the plate.
    let inside = |node: &GridIndex| {
        let [last_column, last_row] = grid.last;
        GridIndex::new(
            node.row.clamp(0, last_row),
            node.column.clamp(0, last_column),
        )
    };
    let all: BTreeSet<GridIndex> = nodes.iter().map(inside).collect();
    let farthest = Some(farthest_offset(grid));
    let drawn = draw_all(lens, grid, &all, Truncation::ForScattering, farthest)?;
    let kernels = drawn.into_par_iter().map(|channels| {
        let mixes = lens.mixes.iter();
        mixes.map(|mix| mixed(&channels, mix).mirrored()).collect()
    });
    let kernels: Vec<MixStencils> = kernels.collect();
    let of_node: BTreeMap<GridIndex, MixStencils> = all.into_iter().zip(kernels).collect();
    let mut out = SparseGrid::covering(nodes);
    for node in nodes {
        if let Some(kernels) = of_node.get(&inside(node)) {
            out.put(*node, kernels.clone());
        }
    }
    Ok(out)
}

/// Draws the kernels of all nodes that contribute to `wanted` corners.
fn node_kernels(
    lens: &LensProbe,
    grid: &TileGrid,
    wanted: &BTreeSet<GridIndex>,
    reach: i32,
    edges: Edges,
) -> Result<NodeKernels> {
    // The bound must not depend on which corners are wanted.
    let reach = f64::from(reach) / grid.step() + ROOM_PX;
    let far = 2 + (reach / grid.tile as f64).ceil() as i32;
    let mut all = nodes_around(grid, wanted, far);
    let reaches = reaches(lens, grid, &all)?;
    let corners = AreaCounts::new(wanted);
    all.retain(|node| corners.any_within(*node, reaches[node]));
    // Light that leaves a mirrored plate is gathered too.
    let farthest = (edges == Edges::Black).then(|| farthest_offset(grid));
    let drawn = draw_all(lens, grid, &all, Truncation::ForStencils, farthest)?;
    let mut kernels = SparseGrid::covering(&all);
    for (node, channels) in all.into_iter().zip(drawn) {
        kernels.put(node, channels);
    }
    Ok(NodeKernels { kernels, far })
}

/// Returns the grid's nodes at most `far` steps from any of `wanted`.
fn nodes_around(grid: &TileGrid, wanted: &BTreeSet<GridIndex>, far: i32) -> BTreeSet<GridIndex> {
    let near = |at: i32, axis: usize| {
        (at - far).clamp(0, grid.last[axis])..=(at + far).clamp(0, grid.last[axis])
    };
    // Corners beyond an edge are interpolated from the four nodes nearest to it.
    let least = |range: std::ops::RangeInclusive<i32>, axis: usize| {
        let last = grid.last[axis];
        let end = (*range.end()).max(3.min(last));
        (*range.start()).min((last - 3).max(0))..=end
    };
    let mut nodes = BTreeSet::new();
    for corner in wanted {
        for row in least(near(corner.row, 1), 1) {
            for column in least(near(corner.column, 0), 0) {
                nodes.insert(GridIndex::new(row, column));
            }
        }
    }
    nodes
}

/// Returns how many steps of the grid the kernels of sources around each node may reach.
fn reaches(
    lens: &LensProbe,
    grid: &TileGrid,
    nodes: &BTreeSet<GridIndex>,
) -> Result<BTreeMap<GridIndex, i32>> {
    let list: Vec<_> = nodes.iter().copied().collect();
    let reach = |node: &GridIndex| {
        let px = lens.reach_at(grid.plate_point(*node), &mut Vec::new())?;
        let steps = (px / grid.step() + ROOM_PX) / grid.tile as f64;
        Ok((*node, 2 + steps.ceil() as i32))
    };
    list.par_iter().map(reach).collect()
}

/// A summed-area table of a set of nodes.
struct AreaCounts {
    first: GridIndex,
    columns: usize,
    rows: usize,
    /// Number of nodes above and to the left of each position.
    sums: Vec<u32>,
}

impl AreaCounts {
    fn new(nodes: &BTreeSet<GridIndex>) -> Self {
        let bounds = SparseGrid::<()>::covering(nodes);
        let (columns, rows) = (bounds.columns.len(), bounds.rows.len());
        let first = GridIndex::new(bounds.rows.start, bounds.columns.start);
        let mut sums = vec![0; (columns + 1) * (rows + 1)];
        for row in 0..rows {
            for column in 0..columns {
                let node = GridIndex::new(first.row + row as i32, first.column + column as i32);
                let at = |row: usize, column: usize| row * (columns + 1) + column;
                sums[at(row + 1, column + 1)] = u32::from(nodes.contains(&node))
                    + sums[at(row, column + 1)]
                    + sums[at(row + 1, column)]
                    - sums[at(row, column)];
            }
        }
        Self {
            first,
            columns,
            rows,
            sums,
        }
    }

    /// Returns whether any node of the set lies at most `steps` from `node` along both axes.
    fn any_within(&self, node: GridIndex, steps: i32) -> bool {
        let span = |at: i32, first: i32, count: usize| {
            let end = |at: i32| (at - first).clamp(0, count as i32) as usize;
            end(at - steps)..end(at + steps + 1)
        };
        let rows = span(node.row, self.first.row, self.rows);
        let columns = span(node.column, self.first.column, self.columns);
        let sum = |row: usize, column: usize| self.sums[row * (self.columns + 1) + column];
        sum(rows.end, columns.end) + sum(rows.start, columns.start)
            > sum(rows.start, columns.end) + sum(rows.end, columns.start)
    }
}

/// Draws the kernels at `nodes`, their weights at offsets up to `reach` along x and y or all.
fn draw_all(
    lens: &LensProbe,
    grid: &TileGrid,
    nodes: &BTreeSet<GridIndex>,
    truncation: Truncation,
    reach: Option<[i32; 2]>,
) -> Result<Vec<ChannelStencils>> {
    let list: Vec<_> = nodes.iter().copied().collect();
    let narrowest = lens.tolerance.min_sigma_for(lens.model);
    let pen = KernelPen {
        lens,
        grid,
        compensation: match lens.kernels {
            Some(store) => store.filters.filter(grid.level, narrowest),
            None => passband::compensation_filter(grid.level, narrowest),
        },
        truncation,
        reach,
        narrowest,
    };
    list.par_iter()
        .map_init(
            || (KernelRows::default(), Vec::new()),
            |(rows, found), node| pen.draw(*node, rows, found),
        )
        .collect()
}

/// Returns an upper bound of the distance along x and y between two pixels of a level, its margins included.
fn farthest_offset(grid: &TileGrid) -> [i32; 2] {
    let tile = grid.tile as i32;
    grid.last.map(|last| (last + 2) * tile + 4 * ROOM_PX as i32)
}

/// The lens, grid and accuracy with which kernels are drawn.
struct KernelPen<'a> {
    lens: &'a LensProbe<'a>,
    grid: &'a TileGrid,
    compensation: [f64; passband::SIDE_TAPS + 1],
    truncation: Truncation,
    /// Farthest that light of the plate lands on the plate along x and y, pixels of the level, where that bounds kernels.
    reach: Option<[i32; 2]>,
    /// Smallest standard deviation drawn at the level, in its pixels.
    narrowest: f64,
}

impl KernelPen<'_> {
    /// Draws the mirrored kernels of a source at `node`, with the pyramid's attenuation compensated.
    fn draw(
        &self,
        node: GridIndex,
        rows: &mut KernelRows,
        found: &mut Vec<Option<Source>>,
    ) -> Result<ChannelStencils> {
        self.lens.check_cancelled()?;
        self.lens.sources_at(self.grid.plate_point(node), found)?;
        // Others are drawn as quickly as found.
        let store = (self.lens.kernels).filter(|_| self.lens.model.needs_rays());
        let mut kernel = |source: &Source| {
            let (source, mirrored) = &source.unmirrored();
            let reach = self.drawn_reach(source);
            let mut drawn = match store {
                Some(store) => {
                    store.kernel(&self.key(source, reach), || self.drawn(source, rows, reach))
                }
                None => Arc::new(self.drawn(source, rows, reach)),
            };
            if *mirrored != [false; 2] {
                drawn = Arc::new(drawn.mirrored_along(*mirrored));
            }
            match self.reach.and_then(|reach| drawn.cropped(reach)) {
                Some(part) => Arc::new(part),
                None => drawn,
            }
        };
        Ok(found
            .iter()
            .map(|source| source.as_ref().map(&mut kernel))
            .collect())
    }

    /// Returns the reach to which the kernel of `source` is drawn, pixels of the level; `None` for all of it.
    ///
    /// Plates of every size share kernels that rays draw. Only one much larger than the plate is drawn for that plate alone: it
    /// may take a thousand times the work of the part that lands there.
    fn drawn_reach(&self, source: &Source) -> Option<[i32; 2]> {
        let reach = self.reach?;
        if !self.lens.model.needs_rays() {
            return Some(reach);
        }
        // The radius of a disc of that variance.
        let radius = (2.0 * source.blur.moments.trace().max(0.0)).sqrt() / self.grid.step();
        let [x, y] = reach.map(|px| radius.min(f64::from(px)));
        (radius * radius > LARGE_KERNEL * x * y).then_some(reach)
    }

    fn key(&self, source: &Source, reach: Option<[i32; 2]>) -> KernelKey {
        // Rays draw without moments, whose last bits depend on the order of sums.
        let blur = LocalBlur {
            moments: CentralMoments::from_array([0.0; 7]),
            ..source.blur.clone()
        };
        KernelKey {
            source: Source { blur, ..*source },
            reach,
            model: self.lens.model.id(),
            level: self.grid.level,
            truncation: self.truncation,
            truncated_share: self.lens.tolerance.truncated_share,
            narrowest: self.narrowest,
        }
    }

    /// Draws the kernel of `source`. Weights beyond `reach` along x and y are left out at once: the kernel of a wide blur may
    /// be a thousand times as large as a small plate.
    fn drawn(&self, source: &Source, rows: &mut KernelRows, reach: Option<[i32; 2]>) -> Stencil {
        let (model, level) = (self.lens.model, self.grid.level);
        let scale = 1.0 / self.grid.step();
        let shift = (source.shift_px.0 * scale, source.shift_px.1 * scale);
        // The filters below take weights from this far beyond.
        let margin = passband::SIDE_TAPS as i32 + 1;
        let near = reach.map(|reach| reach.map(|px| px + margin));
        model.draw_interpolated_rows(&source.blur.rescaled(scale), shift, near, rows);
        let mut stencil = Stencil::from_kernel(rows, near);
        if model.needs_rays() && level > 0 {
            // Rays are integrated over whole pixels of the level instead of the plate's.
            stencil = stencil.sharpen(1.0 - scale * scale);
        }
        if level > 0 {
            stencil = stencil.filtered(&self.compensation);
        }
        if let Some(part) = reach.and_then(|reach| stencil.cropped(reach)) {
            stencil = part;
        }
        let share = self.lens.tolerance.truncated_share;
        stencil.trim(share / 8.0);
        if self.truncation == Truncation::ForScattering {
            stencil.trim(share);
        }
        stencil
    }
}

/// Returns the sum of the channels' stencils with the weights of a mix.
fn mixed(channels: &[Option<Arc<Stencil>>], mix: &[f64]) -> Stencil {
    let parts: Vec<(&Stencil, f64)> = channels
        .iter()
        .zip(mix)
        .filter(|(_, weight)| **weight != 0.0)
        .filter_map(|(stencil, weight)| stencil.as_deref().map(|s| (s, *weight)))
        .collect();
    match parts[..] {
        [(only, 1.0)] => only.clone(),
        _ => Stencil::weighted_sum(&parts),
    }
}

/// Computes the stencil of an output pixel at `corner`.
///
/// The weight at each offset is that of the source there, whose kernel is interpolated from the nodes around it.
fn corner_stencil(
    grid: &TileGrid,
    nodes: &NodeKernels,
    channel: usize,
    corner: GridIndex,
    edges: Edges,
    truncated_share: f64,
) -> Stencil {
    let (mut columns, mut rows) = source_offsets(grid, nodes, channel, corner);
    if edges == Edges::Black {
        (columns, rows) = on_plate(grid, corner, columns, rows);
    }
    let mut out = Stencil::zeros(columns.clone(), rows.clone());
    if columns.is_empty() || rows.is_empty() {
        return out;
    }
    let across = grid.interpolation_weights(0, corner.column, columns);
    let down = grid.interpolation_weights(1, corner.row, rows);
    for node_row in down.nodes() {
        for node_column in across.nodes() {
            let node = GridIndex::new(node_row, node_column);
            let Some(kernel) = nodes.kernel(node, channel) else {
                continue;
            };
            out.add_weighted(kernel, across.of(node_column), down.of(node_row));
        }
    }
    out.trim(truncated_share);
    out
}

/// Returns the part of the offsets of a `corner` at which targets in its tiles have sources on the plate. Where that would leave
/// out little, all are returned: stencils are truncated by their light.
fn on_plate(
    grid: &TileGrid,
    corner: GridIndex,
    columns: Range<i32>,
    rows: Range<i32>,
) -> (Range<i32>, Range<i32>) {
    let (tile, room) = (grid.tile as i32, 4 * ROOM_PX as i32);
    let part = |offsets: &Range<i32>, at: i32, last: i32| {
        let first = -(at + 1) * tile - room;
        let end = (last + 1 - at) * tile + room + 1;
        let start = offsets.start.max(first);
        start..offsets.end.min(end).max(start)
    };
    let near_columns = part(&columns, corner.column, grid.last[0]);
    let near_rows = part(&rows, corner.row, grid.last[1]);
    let area = |columns: &Range<i32>, rows: &Range<i32>| columns.len() * rows.len();
    if area(&columns, &rows) > LARGE_STENCIL * area(&near_columns, &near_rows) {
        (near_columns, near_rows)
    } else {
        (columns, rows)
    }
}

impl NodeKernels {
    /// Returns the kernel of `channel` at a node, where it was drawn.
    fn kernel(&self, node: GridIndex, channel: usize) -> Option<&Stencil> {
        self.kernels.at(node)?.get(channel)?.as_deref()
    }
}

/// Returns the column and row offsets of the sources whose interpolated kernels reach a corner.
fn source_offsets(
    grid: &TileGrid,
    nodes: &NodeKernels,
    channel: usize,
    corner: GridIndex,
) -> (Range<i32>, Range<i32>) {
    let GridIndex { row, column } = corner;
    let far = nodes.far;
    let (mut columns, mut rows) = (0..0, 0..0);
    let join = |a: &mut Range<i32>, b: Range<i32>| {
        *a = if a.start >= a.end {
            b
        } else {
            a.start.min(b.start)..a.end.max(b.end)
        };
    };
    // A node contributes to sources up to two tiles away.
    let slack = 2 * grid.tile as i32;
    // A strip has few nodes along its short side, however far its blur reaches.
    let near = |at: i32, drawn: &Range<i32>| drawn.start.max(at - far)..drawn.end.min(at + far + 1);
    let (rows_near, columns_near) = (
        near(row, &nodes.kernels.rows),
        near(column, &nodes.kernels.columns),
    );
    let all = rows_near.flat_map(|y| columns_near.clone().map(move |x| GridIndex::new(y, x)));
    for node in all {
        let Some(kernel) = nodes.kernel(node, channel) else {
            continue;
        };
        let x = (node.column - column) * grid.tile as i32;
        let y = (node.row - row) * grid.tile as i32;
        let near = |at: i32, offsets: Range<i32>| {
            let (low, high) = (
                (at - slack).max(offsets.start),
                (at + slack).min(offsets.end),
            );
            low..high.max(low)
        };
        let (x, y) = (near(x, kernel.columns()), near(y, kernel.rows()));
        if !x.is_empty() && !y.is_empty() {
            join(&mut columns, x);
            join(&mut rows, y);
        }
    }
    (columns, rows)
}
