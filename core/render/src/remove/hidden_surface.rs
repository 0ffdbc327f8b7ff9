//! Depth edges of a canvas, and the surfaces that continue behind them.
//!
//! The aperture looks past the edge of a near surface, so a blurred image shows a part of the surface behind it. The farther
//! surface is continued behind the nearer one, at the depth that it has beside the edge, as far as kernels reach.
//! Light of the pixels there is unknown, like that beyond the edges of the plate.
//!
//! The nearer surface hides the farther one over twice that distance: kernels blur the light of hidden pixels beyond the last of them.

/// Smallest step of the nearness between neighbours that is a depth edge, px: two surfaces, and not one that is inclined.
const EDGE_STEP: f32 = 1.0;
/// Marks a pixel with no hidden surface behind it.
const NONE: u32 = u32::MAX;

/// The surfaces of a canvas by their *nearness*: the kernel size in px, signed and shifted so that it grows towards the camera.
pub(super) struct HiddenSurface {
    /// Columns of the canvas.
    width: usize,
    /// Nearness of the surface that each pixel shows.
    front: Vec<f32>,
    /// The pixel beside the edge whose surface continues behind each pixel.
    sources: Vec<u32>,
    /// Nearness half way between each pixel and the surface that it hides.
    hiding_limits: Vec<Option<f32>>,
}

impl HiddenSurface {
    /// Continues the surfaces of a canvas, `width` pixels wide, by at most `reach` pixels behind those in front of them, which hide
    /// light up to twice as far from the edge. `front` is the nearness of each pixel.
    pub(super) fn new(front: Vec<f32>, width: usize, reach: usize) -> Self {
        let mut surface = Self {
            width,
            sources: vec![NONE; front.len()],
            hiding_limits: Vec::new(),
            front,
        };
        let beside_edges = (0..surface.front.len()).filter(|k| {
            let nearness = surface.front[*k];
            surface
                .neighbours(*k)
                .any(|other| surface.front[other] - nearness > EDGE_STEP)
        });
        let mut wave: Vec<(usize, u32)> = beside_edges.map(|k| (k, k as u32)).collect();
        surface.continue_by(reach, &mut wave);
        let within_reach = surface.sources.clone();
        surface.continue_by(reach, &mut wave);
        let limit = |k: usize| {
            let source = surface.source(k)?;
            Some(0.5 * (surface.front[k] + surface.front[source]))
        };
        surface.hiding_limits = (0..surface.front.len()).map(limit).collect();
        surface.sources = within_reach;
        surface
    }

    /// Continues surfaces by `steps` pixels from those of `wave`, each with its source.
    fn continue_by(&mut self, steps: usize, wave: &mut Vec<(usize, u32)>) {
        for _ in 0..steps {
            let mut next = Vec::new();
            for (pixel, source) in wave.iter() {
                let limit = self.front[*source as usize] + EDGE_STEP;
                let reached = self
                    .neighbours(*pixel)
                    .filter(|k| self.sources[*k] == NONE && self.front[*k] > limit);
                next.extend(reached.map(|k| (k, *source)));
            }
            // The farthest surface wins, whatever the order.
            next.sort_unstable_by(|a, b| {
                let nearness = |source: u32| self.front[source as usize];
                (a.0.cmp(&b.0)).then(nearness(a.1).total_cmp(&nearness(b.1)).then(a.1.cmp(&b.1)))
            });
            next.dedup_by_key(|(pixel, _)| *pixel);
            for (pixel, source) in &next {
                self.sources[*pixel] = *source;
            }
            if next.is_empty() {
                break;
            }
            *wave = next;
        }
    }

    /// Returns whether a surface is hidden anywhere.
    pub(super) fn has_hidden(&self) -> bool {
        self.sources.iter().any(|source| *source != NONE)
    }

    /// Returns the pixel whose surface continues behind a pixel, if one does.
    pub(super) fn source(&self, pixel: usize) -> Option<usize> {
        let source = self.sources[pixel];
        (source != NONE).then_some(source as usize)
    }

    /// Returns whether a depth edge runs between a pixel and one of its neighbours.
    pub(super) fn is_at_edge(&self, pixel: usize) -> bool {
        let nearness = self.front[pixel];
        self.neighbours(pixel)
            .any(|other| (self.front[other] - nearness).abs() > EDGE_STEP)
    }

    /// Returns the nearness half way between a pixel and the surface that it hides, if it hides one: what is farther is hidden by the
    /// pixel.
    pub(super) fn hiding_limit(&self, pixel: usize) -> Option<f32> {
        self.hiding_limits[pixel]
    }

    /// Returns how much of the light of a surface at `nearness` those with this hiding limit hide where they cover it, 0 to 1.
    pub(super) fn hiding(limit: f32, nearness: f32) -> f32 {
        ((limit - nearness) / EDGE_STEP + 0.5).clamp(0.0, 1.0)
    }

    /// Returns whether two pixels show one surface in front.
    pub(super) fn is_front_joined(&self, a: usize, b: usize) -> bool {
        (self.front[a] - self.front[b]).abs() < EDGE_STEP
    }

    /// Returns whether two pixels have one surface behind, at least one of them hidden.
    pub(super) fn is_back_joined(&self, a: usize, b: usize) -> bool {
        let back = |pixel: usize| self.front[self.source(pixel).unwrap_or(pixel)];
        (self.source(a).is_some() || self.source(b).is_some())
            && (back(a) - back(b)).abs() < EDGE_STEP
    }

    /// Returns the plane `front` with the samples of `hidden` where a surface is hidden: the image of the surfaces behind.
    pub(super) fn back(&self, front: &[f32], hidden: &[f32]) -> Vec<f32> {
        let pixels = self.sources.iter().zip(front).zip(hidden);
        pixels
            .map(|((source, front), hidden)| if *source == NONE { *front } else { *hidden })
            .collect()
    }

    fn neighbours(&self, pixel: usize) -> impl Iterator<Item = usize> + '_ {
        let (width, height) = (self.width, self.front.len() / self.width.max(1));
        let (x, y) = (pixel % width, pixel / width);
        (y.saturating_sub(1)..(y + 2).min(height))
            .flat_map(move |row| {
                (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column)
            })
            .filter(move |other| *other != pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A near half, from column 10 on, before a far one.
    #[test]
    fn the_far_surface_continues_behind_the_near_one() {
        let front: Vec<f32> = (0..20 * 12)
            .map(|k| if k % 20 < 10 { 1.0 } else { 6.0 })
            .collect();
        let surface = HiddenSurface::new(front, 20, 4);
        for k in 0..20 * 12 {
            let is_hidden = (10..14).contains(&(k % 20));
            assert_eq!(surface.source(k).is_some(), is_hidden, "{k}");
            assert!(surface.source(k).is_none_or(|source| source % 20 == 9));
            assert_eq!(surface.is_at_edge(k), (9..11).contains(&(k % 20)));
            let hides = (10..18).contains(&(k % 20));
            assert_eq!(surface.hiding_limit(k), hides.then_some(3.5), "{k}");
        }
        assert!(!surface.is_front_joined(9, 10) && surface.is_front_joined(10, 11));
        assert!(surface.is_back_joined(9, 10) && !surface.is_back_joined(8, 9));
    }

    #[test]
    fn an_inclined_surface_hides_nothing() {
        let front: Vec<f32> = (0..20 * 12).map(|k| 0.5 * (k % 20) as f32).collect();
        let surface = HiddenSurface::new(front, 20, 4);
        assert!((0..20 * 12).all(|k| surface.source(k).is_none() && !surface.is_at_edge(k)));
    }
}
