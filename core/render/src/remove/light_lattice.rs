//! The places of a light's sources: every pixel of a small light, a coarser lattice over a large one.

/// Unknown sources at pixels `spacing` apart. Each lights the pixels around it by a bilinear weight, so that equal sources
/// make a uniform area.
pub(super) struct SourceLattice {
    pub(super) spacing: usize,
    /// The pixels of the plate with a source, in ascending order.
    pub(super) pixels: Vec<usize>,
    /// Columns of the plate.
    width: usize,
}

impl SourceLattice {
    /// Chooses those of the `possible` pixels of a plate `width` columns wide, in ascending order, that lie on a lattice.
    pub(super) fn new(possible: &[usize], spacing: usize, width: usize) -> Self {
        let on_lattice =
            |k: &usize| (k % width).is_multiple_of(spacing) && (k / width).is_multiple_of(spacing);
        Self {
            spacing,
            pixels: possible.iter().copied().filter(on_lattice).collect(),
            width,
        }
    }

    /// Returns the indices of the four neighbours of each source; `None` where there is no source.
    pub(super) fn neighbours(&self) -> Vec<[Option<usize>; 4]> {
        let index_of = |pixel: Option<usize>| self.pixels.binary_search(&pixel?).ok();
        let neighbours = self.pixels.iter().map(|pixel| {
            let (column, step) = (pixel % self.width, self.spacing);
            [
                index_of((column >= step).then(|| pixel - step)),
                index_of((column + step < self.width).then(|| pixel + step)),
                index_of(pixel.checked_sub(step * self.width)),
                index_of(Some(pixel + step * self.width)),
            ]
        });
        neighbours.collect()
    }

    /// Returns the pixels of a plate `height` rows high that are lit by sources of this `light`, with their light, in
    /// ascending order.
    pub(super) fn lit_pixels(&self, light: &[f32], height: usize) -> Vec<(usize, f32)> {
        let reach = self.spacing as i32 - 1;
        let mut lit = Vec::new();
        for (pixel, light) in self.pixels.iter().zip(light).filter(|(_, v)| **v > 0.0) {
            let (x, y) = ((pixel % self.width) as i32, (pixel / self.width) as i32);
            for (dy, down) in hat(self.spacing).zip(-reach..) {
                for (dx, across) in hat(self.spacing).zip(-reach..) {
                    let (x, y) = (x + across, y + down);
                    if (0..self.width as i32).contains(&x) && (0..height as i32).contains(&y) {
                        lit.push((y as usize * self.width + x as usize, light * dx * dy));
                    }
                }
            }
        }
        lit.sort_by_key(|(pixel, _)| *pixel);
        lit.dedup_by(|next, sum| {
            let same = next.0 == sum.0;
            if same {
                sum.1 += next.1;
            }
            same
        });
        lit
    }
}

/// Returns the bilinear weights of a source along one axis, from 1 - `spacing` to `spacing` - 1 px.
pub(super) fn hat(spacing: usize) -> impl Iterator<Item = f32> {
    let side = spacing as i32;
    (1 - side..side).map(move |at| 1.0 - at.abs() as f32 / side as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_sources_make_a_uniform_area() {
        let (width, height, spacing) = (40, 30, 3);
        let possible: Vec<usize> = (0..width * height)
            .filter(|k| (6..27).contains(&(k % width)) && (9..20).contains(&(k / width)))
            .collect();
        let lattice = SourceLattice::new(&possible, spacing, width);
        assert_eq!(lattice.pixels.len(), 7 * 4);
        let lit = lattice.lit_pixels(&vec![2.0; lattice.pixels.len()], height);
        for (x, y) in [(6, 9), (10, 11), (24, 18)] {
            let found = lit.binary_search_by_key(&(y * width + x), |(pixel, _)| *pixel);
            assert!(
                (lit[found.expect("a lit pixel")].1 - 2.0).abs() < 1e-5,
                "{x}, {y}"
            );
        }
        let sum: f32 = lit.iter().map(|(_, light)| light).sum();
        assert!((sum - 2.0 * 28.0 * 9.0).abs() < 1e-2, "{sum}");
        let neighbours = lattice.neighbours();
        assert_eq!(neighbours[0], [None, Some(1), None, Some(7)]);
        assert_eq!(neighbours[8], [Some(7), Some(9), Some(1), Some(15)]);
    }
}
