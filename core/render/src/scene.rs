//! The inputs of a renderer: lens, plate geometry, depth and planes of samples.

use crate::{BlurField, PlateMap};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::ImagePoint;
use seidel_optics::psf::PsfModel;
use std::ops::Range;

/// Object vergence of the plate's pixels: 1 / distance, in 1/m, 0 at infinity.
#[derive(Debug, Clone, Copy)]
pub enum VergencePass<'a> {
    /// One vergence for the whole plate.
    Constant(f64),
    /// One finite value per pixel, row-major.
    PerPixel(&'a [f32]),
}

/// The boundary condition at the plate's edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Edges {
    /// Mirrored plate and mirrored lens: light that would leave is folded back at the edge. The plate keeps all its
    /// light.
    #[default]
    Mirror,
    /// Black surroundings: light that leaves is lost.
    Black,
}

/// The part of the lens's geometric displacement that a render keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Displacement {
    /// None: every PSF has its centroid on its source pixel.
    #[default]
    None,
    /// Lateral colour: each channel is displaced relative to the mean of all lens channels. The plate itself stays
    /// undistorted.
    Lateral,
    /// All: distortion and lateral colour.
    Full,
}

/// Lens, plate geometry and depth: everything a render needs but the samples.
pub struct Scene<'a> {
    /// The lens.
    pub lens: &'a dyn BlurField,
    /// The PSF model that turns the lens's local blur into kernels.
    pub model: &'a dyn PsfModel,
    /// Columns of the plate.
    pub width: usize,
    /// Rows of the plate.
    pub height: usize,
    /// Position and scale of the plate in the lens's frame.
    pub map: PlateMap,
    /// Depth of the plate's pixels.
    pub vergence: VergencePass<'a>,
    /// Boundary condition at the plate's edges.
    pub edges: Edges,
    /// Displacement of PSFs that is kept.
    pub displacement: Displacement,
}

/// A plane of samples to blur, such as red or alpha. Samples are scene-linear, and premultiplied where the plate has
/// alpha.
#[derive(Debug, Clone, Copy)]
pub struct Plane<'a> {
    /// One finite sample per pixel, row-major; negative and very large values are allowed.
    pub samples: &'a [f32],
    /// Weight of each lens channel in this plane: (1, 0, 0) for red, (1/3, 1/3, 1/3) for alpha, the coverage seen by
    /// all three. Weights that sum to one keep the plane's light.
    pub weights: &'a [f64],
}

/// A rectangle of a plate's pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderWindow {
    /// First column.
    pub column: usize,
    /// First row.
    pub row: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl RenderWindow {
    /// The whole plate of `scene`.
    pub(crate) fn whole(scene: &Scene) -> Self {
        Self::from_size(scene.width, scene.height)
    }

    /// The whole of a plate of `width` x `height` pixels.
    pub(crate) fn from_size(width: usize, height: usize) -> Self {
        Self {
            column: 0,
            row: 0,
            width,
            height,
        }
    }

    /// Returns the smallest window with all samples of planes, `width` columns wide, whose magnitude is above `limit`.
    pub fn of_light<'s>(
        planes: impl IntoIterator<Item = &'s [f32]>,
        width: usize,
        limit: f32,
    ) -> Option<Self> {
        let is_lit = |v: &f32| v.abs() > limit;
        let (mut left, mut right, mut top, mut bottom) = (usize::MAX, 0, usize::MAX, 0);
        for plane in planes {
            for (row, line) in plane.chunks_exact(width.max(1)).enumerate() {
                let Some(first) = line.iter().position(is_lit) else {
                    continue;
                };
                let last = line.iter().rposition(is_lit).unwrap_or(first);
                (left, right) = (left.min(first), right.max(last));
                (top, bottom) = (top.min(row), bottom.max(row));
            }
        }
        (left != usize::MAX).then(|| Self {
            column: left,
            row: top,
            width: right - left + 1,
            height: bottom - top + 1,
        })
    }

    /// Returns the part that both have; `None` without any.
    pub(crate) fn overlap(self, other: Self) -> Option<Self> {
        let common = |[a, b]: [usize; 2], [length_a, length_b]: [usize; 2]| {
            let (first, end) = (a.max(b), (a + length_a).min(b + length_b));
            (first < end).then(|| (first, end - first))
        };
        let (column, width) = common([self.column, other.column], [self.width, other.width])?;
        let (row, height) = common([self.row, other.row], [self.height, other.height])?;
        Some(Self {
            column,
            row,
            width,
            height,
        })
    }

    /// Its columns.
    pub(crate) fn columns(&self) -> Range<usize> {
        self.column..self.column + self.width
    }

    /// Its rows.
    pub(crate) fn rows(&self) -> Range<usize> {
        self.row..self.row + self.height
    }

    /// Returns whether a pixel lies in the window.
    pub(crate) fn holds(&self, column: usize, row: usize) -> bool {
        self.columns().contains(&column) && self.rows().contains(&row)
    }

    /// Returns `samples` of this window in a plane of `width` x `height` pixels that is zero elsewhere.
    pub(crate) fn surrounded(&self, width: usize, height: usize, samples: &[f32]) -> Vec<f32> {
        let mut out = vec![0.0; width * height];
        for (row, line) in self.rows().zip(samples.chunks_exact(self.width)) {
            out[row * width..][self.columns()].copy_from_slice(line);
        }
        out
    }

    /// Returns this part of `samples`, a plane `width` columns wide.
    pub(crate) fn cut(&self, width: usize, samples: &[f32]) -> Vec<f32> {
        let rows = samples.chunks_exact(width).skip(self.row).take(self.height);
        rows.flat_map(|row| &row[self.column..self.column + self.width])
            .copied()
            .collect()
    }

    /// Cuts whole planes of `scene` to this window.
    pub(crate) fn cut_planes(&self, scene: &Scene, planes: Vec<Vec<f32>>) -> Vec<Vec<f32>> {
        if *self == Self::whole(scene) {
            return planes;
        }
        let cut = |plane: &Vec<f32>| self.cut(scene.width, plane);
        planes.iter().map(cut).collect()
    }

    pub(crate) fn check(&self, scene: &Scene) -> Result<()> {
        let within = |first: usize, size: usize, plate: usize| {
            size > 0 && first.checked_add(size).is_some_and(|end| end <= plate)
        };
        if within(self.column, self.width, scene.width)
            && within(self.row, self.height, scene.height)
        {
            return Ok(());
        }
        Err(Error::new(
            "window",
            format!(
                "is {} x {} from ({}, {}) on a plate of {} x {}",
                self.width, self.height, self.column, self.row, scene.width, scene.height
            ),
            "give a part of the plate of at least one pixel",
        ))
    }
}

/// Returns the error of a render that its `progress` callback cancelled.
pub(crate) fn cancelled() -> Error {
    Error::cancelled("render")
}

impl Scene<'_> {
    /// Returns the number of pixels of the plate.
    pub fn pixel_count(&self) -> usize {
        self.width * self.height
    }

    /// Returns the vergence of the pixel at row-major `index`, 1/m.
    pub fn vergence_at(&self, index: usize) -> f64 {
        match self.vergence {
            VergencePass::Constant(vergence) => vergence,
            VergencePass::PerPixel(pass) => f64::from(pass[index]),
        }
    }

    /// Returns the position (x, y) of the plate's first pixel in its cell of a grid that is fixed to the frame, with cells of `side` plate
    /// pixels. Four cells meet in the middle of the frame, so that a mirrored plate has the mirrored cells.
    pub fn place_in_cell(&self, side: usize) -> [usize; 2] {
        let frame = self.lens.frame();
        let middle = [frame.width_px(), frame.height_px()].map(|px| f64::from(px) / 2.0);
        let middle = ImagePoint::new(middle[0], middle[1]);
        self.map.place_in_cell_about(middle, side)
    }

    /// Checks that this scene and `planes` can be rendered.
    ///
    /// # Errors
    /// An empty plate or one too large to index, a scale that is not positive, a plane or depth pass of the wrong
    /// size, the wrong number of channel weights, and samples, weights or depths that are not finite. The error
    /// names the first plane and pixel found.
    pub fn check(&self, planes: &[Plane]) -> Result<()> {
        // A quarter of the range of i32 leaves room for kernels beyond the edges.
        let largest = 1 << 29;
        if self.width == 0 || self.height == 0 || self.width > largest || self.height > largest {
            return Err(Error::new(
                "plate size",
                format!("is {} x {}", self.width, self.height),
                "give a plate of at least one pixel",
            ));
        }
        let PlateMap { origin, scale } = self.map;
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::new(
                "plate scale",
                format!("is {scale}"),
                "give a positive number of plate pixels per pixel of the lens's frame",
            ));
        }
        if !origin.x_px.is_finite() || !origin.y_px.is_finite() {
            return Err(Error::new(
                "plate origin",
                format!("is ({}, {})", origin.x_px, origin.y_px),
                "give the frame position of the plate's top-left corner in pixels",
            ));
        }
        match self.vergence {
            VergencePass::Constant(vergence) if vergence.is_finite() => {}
            VergencePass::Constant(vergence) => {
                return Err(Error::new(
                    "vergence",
                    format!("is {vergence}"),
                    "give 1 / distance in metres, 0 for infinity",
                ));
            }
            VergencePass::PerPixel(pass) => self.check_samples("depth pass", pass)?,
        }
        for (index, plane) in planes.iter().enumerate() {
            let name = format!("plane {index}");
            let channels = self.lens.channel_count();
            if plane.weights.len() != channels || !plane.weights.iter().all(|w| w.is_finite()) {
                return Err(Error::new(
                    name,
                    format!("has channel weights {:?}", plane.weights),
                    format!("give one finite weight for each of the lens's {channels} channels"),
                ));
            }
            self.check_samples(&name, plane.samples)?;
        }
        Ok(())
    }

    pub(crate) fn check_samples(&self, name: &str, samples: &[f32]) -> Result<()> {
        if samples.len() != self.pixel_count() {
            return Err(Error::new(
                name,
                format!("has {} samples", samples.len()),
                format!(
                    "give one a pixel of the {} x {} plate",
                    self.width, self.height
                ),
            ));
        }
        // No branch per sample: every renderer scans every plane.
        let sound = |block: &[f32]| block.iter().fold(true, |all, v| all & v.is_finite());
        let bad = samples.chunks(64).position(|block| !sound(block));
        let bad = bad.and_then(|block| {
            let rest = samples[64 * block..].iter();
            let within = rest.into_iter().position(|sample| !sample.is_finite());
            within.map(|k| 64 * block + k)
        });
        match bad {
            None => Ok(()),
            Some(index) => Err(Error::new(
                format!(
                    "{name}, pixel ({}, {})",
                    index % self.width,
                    index / self.width
                ),
                format!("is {}", samples[index]),
                "replace values that are not finite before blurring",
            )),
        }
    }
}
