//! Stencils at the corners of tiles, made of the kernels of the sources that they see.

use super::Tolerance;
use super::grid::Grid;
use super::optics::Optics;
use super::passband;
use super::stencil::Stencil;
use crate::scatter::Source;
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::KernelRows;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Values at the places of a rectangle, of which some are there.
pub(super) struct Places<T> {
    columns: Range<i32>,
    rows: Range<i32>,
    values: Vec<Option<T>>,
}

impl<T> Places<T> {
    fn about(wanted: &BTreeSet<(i32, i32)>) -> Self {
        let range = |of: &dyn Fn(&(i32, i32)) -> i32| {
            let low = wanted.iter().map(of).min().unwrap_or(0);
            low..wanted.iter().map(of).max().map_or(low, |high| high + 1)
        };
        let (rows, columns) = (range(&|p| p.0), range(&|p| p.1));
        let mut values = Vec::new();
        values.resize_with(columns.len() * rows.len(), || None);
        Self {
            columns,
            rows,
            values,
        }
    }

    fn slot(&self, (y, x): (i32, i32)) -> Option<usize> {
        let inside = self.columns.contains(&x) && self.rows.contains(&y);
        inside.then(|| {
            (y - self.rows.start) as usize * self.columns.len() + (x - self.columns.start) as usize
        })
    }

    /// What is at (row, column).
    pub(super) fn at(&self, place: (i32, i32)) -> Option<&T> {
        self.values[self.slot(place)?].as_ref()
    }

    fn put(&mut self, place: (i32, i32), value: T) {
        if let Some(slot) = self.slot(place) {
            self.values[slot] = Some(value);
        }
    }
}

/// One stencil per mix.
pub(super) type Mixed = Vec<Stencil>;

/// One stencil per lens channel; none where no plane wants it.
type Channels = Vec<Option<Stencil>>;

/// By how much kernels of a coarse level may be wider than those of the plate, px of the level.
const ROOM_PX: f64 = 2.0 + passband::SIDE as f64;

/// The stencils at `wanted` corners (row, column) of `grid`; no light goes farther than `reach`, px of the plate.
///
/// # Errors
/// A lens that cannot be drawn at some node.
pub(super) fn stencils(
    optics: &Optics,
    grid: &Grid,
    wanted: &BTreeSet<(i32, i32)>,
    reach: i32,
) -> Result<Places<Mixed>> {
    let (nodes, far) = kernels(optics, grid, wanted, reach)?;
    let list: Vec<_> = wanted.iter().copied().collect();
    // Channels are cut short before they are mixed: a mix of planes is then blurred as its planes are.
    let made: Vec<Mixed> = list
        .par_iter()
        .map(|corner| {
            let channels: Channels = (0..optics.channel_count())
                .map(|channel| {
                    let wanted = optics.wanted(channel);
                    wanted.then(|| joined(grid, (&nodes, far), channel, *corner, optics.tolerance))
                })
                .collect();
            let mixes = optics.mixes.iter();
            mixes.map(|mix| mixed(&channels, mix)).collect()
        })
        .collect();
    let mut places = Places::about(wanted);
    for (corner, mixed) in list.into_iter().zip(made) {
        places.put(corner, mixed);
    }
    Ok(places)
}

/// The nodes' kernels, turned round, that the corners need, and how many tiles away they can be.
fn kernels(
    optics: &Optics,
    grid: &Grid,
    wanted: &BTreeSet<(i32, i32)>,
    reach: i32,
) -> Result<(Places<Channels>, i32)> {
    // How far corners see must not depend on which of them are wanted.
    let reach = f64::from(reach) / grid.step() + ROOM_PX;
    let far = 2 + (reach / grid.tile as f64).ceil() as i32;
    let mut all = nodes_about(grid, wanted, far);
    let reaches = reaches(optics, grid, &all)?;
    let corners = Counts::of(wanted);
    all.retain(|node| corners.within(*node, reaches[node]));
    let drawn = draw_all(optics, grid, &all)?;
    let mut places = Places::about(&all);
    for (node, mixed) in all.into_iter().zip(drawn) {
        places.put(node, mixed);
    }
    Ok((places, far))
}

/// The grid's nodes at most `far` steps from any of `wanted`.
fn nodes_about(grid: &Grid, wanted: &BTreeSet<(i32, i32)>, far: i32) -> BTreeSet<(i32, i32)> {
    let near = |at: i32, axis: usize| {
        (at - far).clamp(0, grid.last[axis])..=(at + far).clamp(0, grid.last[axis])
    };
    // The four nodes at an edge serve all corners beyond it.
    let least = |range: std::ops::RangeInclusive<i32>, axis: usize| {
        let last = grid.last[axis];
        let end = (*range.end()).max(3.min(last));
        (*range.start()).min((last - 3).max(0))..=end
    };
    let mut nodes = BTreeSet::new();
    for &(y, x) in wanted {
        for row in least(near(y, 1), 1) {
            for column in least(near(x, 0), 0) {
                nodes.insert((row, column));
            }
        }
    }
    nodes
}

/// How many steps of the grid the kernel of a source about each node may reach.
fn reaches(
    optics: &Optics,
    grid: &Grid,
    nodes: &BTreeSet<(i32, i32)>,
) -> Result<BTreeMap<(i32, i32), i32>> {
    let list: Vec<_> = nodes.iter().copied().collect();
    let reach = |node: &(i32, i32)| {
        let px = optics.reach_at(grid.node_at(node.1, node.0), &mut Vec::new())?;
        let steps = (px / grid.step() + ROOM_PX) / grid.tile as f64;
        Ok((*node, 2 + steps.ceil() as i32))
    };
    list.par_iter().map(reach).collect()
}

/// How many places of a set lie in a rectangle.
struct Counts {
    first: (i32, i32),
    columns: usize,
    rows: usize,
    /// Of places above and left of each one.
    sums: Vec<u32>,
}

impl Counts {
    fn of(places: &BTreeSet<(i32, i32)>) -> Self {
        let about = Places::<()>::about(places);
        let (columns, rows) = (about.columns.len(), about.rows.len());
        let first = (about.rows.start, about.columns.start);
        let mut sums = vec![0; (columns + 1) * (rows + 1)];
        for row in 0..rows {
            for column in 0..columns {
                let place = (first.0 + row as i32, first.1 + column as i32);
                let at = |row: usize, column: usize| row * (columns + 1) + column;
                sums[at(row + 1, column + 1)] = u32::from(places.contains(&place))
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

    /// Whether any lies at most `steps` from `place` along both axes.
    fn within(&self, place: (i32, i32), steps: i32) -> bool {
        let span = |at: i32, first: i32, count: usize| {
            let end = |at: i32| (at - first).clamp(0, count as i32) as usize;
            end(at - steps)..end(at + steps + 1)
        };
        let rows = span(place.0, self.first.0, self.rows);
        let columns = span(place.1, self.first.1, self.columns);
        let sum = |row: usize, column: usize| self.sums[row * (self.columns + 1) + column];
        sum(rows.end, columns.end) + sum(rows.start, columns.start)
            > sum(rows.start, columns.end) + sum(rows.end, columns.start)
    }
}

fn draw_all(optics: &Optics, grid: &Grid, nodes: &BTreeSet<(i32, i32)>) -> Result<Vec<Channels>> {
    let list: Vec<_> = nodes.iter().copied().collect();
    let narrowest = optics.tolerance.least_sigma_for(optics.model);
    let given_back = passband::filter(grid.level, narrowest);
    list.par_iter()
        .map_init(
            || (KernelRows::default(), Vec::new()),
            |(rows, found), node| draw(optics, (grid, &given_back), *node, rows, found),
        )
        .collect()
}

/// The kernels of a source at `node` (row, column), turned round.
fn draw(
    optics: &Optics,
    (grid, given_back): (&Grid, &[f64]),
    (row, column): (i32, i32),
    rows: &mut KernelRows,
    found: &mut Vec<Option<Source>>,
) -> Result<Channels> {
    optics.go_on()?;
    optics.at(grid.node_at(column, row), found)?;
    let scale = 1.0 / grid.step();
    let channels: Channels = found
        .iter()
        .map(|source| {
            source.as_ref().map(|source| {
                let shift = (source.shift_px.0 * scale, source.shift_px.1 * scale);
                optics
                    .model
                    .draw_rows(&source.blur.rescaled(scale), shift, rows);
                let mut stencil = Stencil::of_kernel(rows);
                if optics.model.needs_rays() && grid.level > 0 {
                    // Drawn as light on whole pixels of the level, not of the plate.
                    stencil = stencil.sharpen(1.0 - scale * scale);
                }
                if grid.level > 0 {
                    stencil = stencil.filtered(given_back);
                }
                stencil.trim(optics.tolerance.left_out / 8.0);
                stencil
            })
        })
        .collect();
    Ok(channels)
}

/// The mean of what is seen through channels of some weights.
fn mixed(channels: &[Option<Stencil>], mix: &[f64]) -> Stencil {
    let parts: Vec<(&Stencil, f64)> = channels
        .iter()
        .zip(mix)
        .filter(|(_, weight)| **weight != 0.0)
        .filter_map(|(stencil, weight)| stencil.as_ref().map(|s| (s, *weight)))
        .collect();
    match parts[..] {
        [(only, 1.0)] => only.clone(),
        _ => Stencil::mean_of(&parts),
    }
}

/// What an output pixel at `corner` (row, column) sees: at each offset the weight of the source there,
/// its kernel joined from those of the nodes about it.
fn joined(
    grid: &Grid,
    (nodes, far): (&Places<Channels>, i32),
    channel: usize,
    (row, column): (i32, i32),
    tolerance: &Tolerance,
) -> Stencil {
    let (columns, rows) = seen(grid, (nodes, far), channel, (row, column));
    let mut out = Stencil::zeros(columns.clone(), rows.clone());
    if columns.is_empty() || rows.is_empty() {
        return out;
    }
    let across = grid.shares(0, column, columns);
    let down = grid.shares(1, row, rows);
    for node_row in down.nodes() {
        for node_column in across.nodes() {
            let Some(kernel) = kernel_of(nodes, (node_row, node_column), channel) else {
                continue;
            };
            out.add_shared(kernel, across.of(node_column), down.of(node_row));
        }
    }
    out.trim(tolerance.left_out);
    out
}

/// The kernel of `channel` at a node, where it was drawn.
fn kernel_of(nodes: &Places<Channels>, node: (i32, i32), channel: usize) -> Option<&Stencil> {
    nodes.at(node)?.get(channel)?.as_ref()
}

/// Offsets of the sources that a corner can see: those whose nodes' kernels reach it.
fn seen(
    grid: &Grid,
    (nodes, far): (&Places<Channels>, i32),
    channel: usize,
    (row, column): (i32, i32),
) -> (Range<i32>, Range<i32>) {
    let (mut columns, mut rows) = (0..0, 0..0);
    let join = |a: &mut Range<i32>, b: Range<i32>| {
        *a = if a.start >= a.end {
            b
        } else {
            a.start.min(b.start)..a.end.max(b.end)
        };
    };
    // A kernel counts where its own sources, and those up to two tiles about them, can be.
    let slack = 2 * grid.tile as i32;
    let about = row - far..=row + far;
    let places = about.flat_map(|y| (column - far..=column + far).map(move |x| (y, x)));
    for (node_row, node_column) in places {
        let Some(kernel) = kernel_of(nodes, (node_row, node_column), channel) else {
            continue;
        };
        let x = (node_column - column) * grid.tile as i32;
        let y = (node_row - row) * grid.tile as i32;
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
