//! Block matching: the patches of a plane that look like a given patch nearby.

use rayon::prelude::*;

/// Side of a patch, px.
pub(super) const PATCH: usize = 6;
/// Number of patches in a group. More gain little on photographs (docs/background/figures.md).
pub(super) const GROUP: usize = 8;
/// Distance from one reference patch to the next, px.
const STEP: usize = 3;
/// Largest distance of a patch from its reference along each axis, px.
pub(super) const SEARCH: usize = 4;
/// Rows of reference patches in a band.
const BAND: usize = 8;

/// The groups of similar patches of a plane, one for each reference patch. Reference patches cover the plane.
pub(super) struct PatchGroups {
    /// Columns and rows of the plane.
    pub(super) size: (usize, usize),
    pub(super) bands: Vec<GroupBand>,
}

/// The groups of some rows of reference patches.
pub(super) struct GroupBand {
    /// The rows of the plane on which the patches of these groups lie.
    pub(super) rows: std::ops::Range<usize>,
    /// The index of the first pixel of each patch. The first patch of a group is its reference.
    pub(super) groups: Vec<[u32; GROUP]>,
}

impl PatchGroups {
    /// Finds the groups of `plane`, which has `width` columns: the patches with the least sums of squared differences. A
    /// group is filled with its reference where the search meets fewer patches. `None` if the plane is smaller than a
    /// patch.
    pub(super) fn find(plane: &[f32], width: usize) -> Option<Self> {
        let height = plane.len() / width.max(1);
        if width < PATCH || height < PATCH {
            return None;
        }
        let (columns, rows) = (starts(width), starts(height));
        let bands = (rows.par_chunks(BAND))
            .map(|rows| {
                let first = rows[0].saturating_sub(SEARCH);
                let last = (rows[rows.len() - 1] + SEARCH).min(height - PATCH);
                let search = Search {
                    plane,
                    width,
                    columns: &columns,
                };
                GroupBand {
                    rows: first..last + PATCH,
                    groups: rows.iter().flat_map(|row| search.groups(*row)).collect(),
                }
            })
            .collect();
        Some(Self {
            size: (width, height),
            bands,
        })
    }
}

/// Returns the first columns, or rows, of reference patches on an axis of `size` pixels.
fn starts(size: usize) -> Vec<usize> {
    let last = size - PATCH;
    let mut starts: Vec<usize> = (0..last).step_by(STEP).collect();
    starts.push(last);
    starts
}

/// The search for the groups of a row of reference patches.
struct Search<'a> {
    plane: &'a [f32],
    width: usize,
    /// The first columns of the reference patches.
    columns: &'a [usize],
}

/// The best patches for a reference so far.
#[derive(Clone, Copy)]
struct Best {
    /// Sums of squared differences, ascending.
    distances: [f32; GROUP],
    patches: [u32; GROUP],
}

impl Best {
    fn insert(&mut self, distance: f32, patch: u32) {
        let mut place = GROUP - 1;
        // The reference stays the first.
        while place > 1 && self.distances[place - 1] > distance {
            self.distances[place] = self.distances[place - 1];
            self.patches[place] = self.patches[place - 1];
            place -= 1;
        }
        self.distances[place] = distance;
        self.patches[place] = patch;
    }
}

impl Search<'_> {
    /// Returns the groups of the reference patches whose first row is `row`.
    fn groups(&self, row: usize) -> Vec<[u32; GROUP]> {
        let height = self.plane.len() / self.width;
        let place = |row: usize, column: usize| (row * self.width + column) as u32;
        let mut all: Vec<Best> = (self.columns.iter())
            .map(|column| Best {
                distances: [f32::INFINITY; GROUP],
                patches: [place(row, *column); GROUP],
            })
            .collect();
        let shifts = || 0..=2 * SEARCH;
        let mut squares = vec![0.0; self.width];
        for other_row in shifts().filter_map(|dy| (row + dy).checked_sub(SEARCH)) {
            if other_row > height - PATCH {
                continue;
            }
            for dx in shifts().map(|dx| dx as isize - SEARCH as isize) {
                if other_row == row && dx == 0 {
                    continue;
                }
                self.add_up_columns(row, other_row, dx, &mut squares);
                for (column, best) in self.columns.iter().zip(&mut all) {
                    let Some(other) = column.checked_add_signed(dx) else {
                        continue;
                    };
                    if other > self.width - PATCH {
                        continue;
                    }
                    let distance: f32 = squares[*column..][..PATCH].iter().sum();
                    if distance < best.distances[GROUP - 1] {
                        best.insert(distance, place(other_row, other));
                    }
                }
            }
        }
        all.into_iter().map(|best| best.patches).collect()
    }

    /// Writes, for each column that has a neighbour `dx` columns away, the sum over the rows of a patch of squared
    /// differences from the patch that begins at `other_row`.
    fn add_up_columns(&self, row: usize, other_row: usize, dx: isize, squares: &mut [f32]) {
        squares.fill(0.0);
        let from = dx.min(0).unsigned_abs();
        let to = self.width.saturating_sub(dx.max(0).unsigned_abs());
        if from >= to {
            return;
        }
        let squares = &mut squares[from..to];
        for y in 0..PATCH {
            let own = &self.plane[(row + y) * self.width..][from..to];
            let other = (other_row + y) * self.width + dx.max(0).unsigned_abs();
            let other = &self.plane[other..][..to - from];
            for ((square, a), b) in squares.iter_mut().zip(own).zip(other) {
                *square += (a - b) * (a - b);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stripes of a period of four rows: the most similar patches are copies.
    #[test]
    fn groups_are_the_most_similar_patches_of_the_search() {
        let (width, height) = (40, 29);
        let stripes: Vec<f32> = (0..width * height)
            .map(|k| ((k / width) % 4) as f32 + 0.001 * (k % width) as f32)
            .collect();
        let groups = PatchGroups::find(&stripes, width).expect("a plane larger than a patch");
        let mut seen = vec![false; width * height];
        for band in &groups.bands {
            for group in &band.groups {
                let reference = group[0] as usize;
                for patch in group.map(|k| k as usize) {
                    assert_eq!((patch / width).abs_diff(reference / width) % 4, 0);
                    assert!((patch % width).abs_diff(reference % width) <= 3);
                    assert!(band.rows.contains(&(patch / width)));
                    assert!(band.rows.contains(&(patch / width + PATCH - 1)));
                }
                for y in 0..PATCH {
                    seen[reference + y * width..][..PATCH].fill(true);
                }
            }
        }
        assert!(seen.iter().all(|seen| *seen));
    }

    #[test]
    fn groups_of_small_planes_are_filled_with_their_reference() {
        let plane: Vec<f32> = (0..6 * 7).map(|k| (k * k % 5) as f32).collect();
        let groups = PatchGroups::find(&plane, 6).expect("a plane larger than a patch");
        let all: Vec<_> = groups.bands.iter().flat_map(|b| &b.groups).collect();
        let filled = |reference: u32, other: u32| {
            let mut group = [reference; GROUP];
            group[1] = other;
            group
        };
        assert_eq!(all, [&filled(0, 6), &filled(6, 0)]);
        assert!(PatchGroups::find(&plane, 3).is_none() && PatchGroups::find(&plane, 42).is_none());
    }
}
