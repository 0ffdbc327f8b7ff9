//! What a renderer is given: lens, plate geometry, depth and the planes of samples.

use crate::{BlurField, Methods, PlateMap, reach_of_pass};
use seidel_optics::error::{Error, Result};
use seidel_optics::psf::PsfModel;

/// Object vergence (1 / distance in metres) of every plate pixel.
#[derive(Debug, Clone, Copy)]
pub enum VergencePass<'a> {
    /// The whole plate at one vergence.
    Constant(f64),
    /// One value a pixel, row-major, finite.
    PerPixel(&'a [f32]),
}

/// What lies beyond the plate's edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Edges {
    /// The mirrored plate seen through the mirrored lens: light that would leave is folded back at
    /// the edge, so the plate keeps all its light.
    #[default]
    Mirror,
    /// Nothing: light that leaves is lost.
    Black,
}

/// Whether a PSF lands where the ideal chief ray would or where the lens puts it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Displacement {
    /// Every PSF has its centroid on its source pixel: blur alone.
    #[default]
    None,
    /// Each channel is displaced relative to the mean over all lens channels: lateral colour, with
    /// the plate itself left undistorted.
    Lateral,
    /// The whole displacement: distortion and lateral colour.
    Full,
}

/// A plate's optics: everything about a render but the samples.
pub struct Scene<'a> {
    /// The lens.
    pub lens: &'a dyn BlurField,
    /// What turns the lens's moments into light densities.
    pub model: &'a dyn PsfModel,
    /// Columns of the plate.
    pub width: usize,
    /// Rows of the plate.
    pub height: usize,
    /// Where the plate lies in the lens's frame.
    pub map: PlateMap,
    /// Depth of the plate.
    pub vergence: VergencePass<'a>,
    /// What lies beyond the plate.
    pub edges: Edges,
    /// Whether PSFs are displaced.
    pub displacement: Displacement,
}

/// One plane of samples to blur, such as red or alpha. Samples are linear light, premultiplied where
/// there is an alpha plane.
#[derive(Debug, Clone, Copy)]
pub struct Plane<'a> {
    /// One sample a pixel, row-major, finite; negative and very large ones are welcome.
    pub samples: &'a [f32],
    /// How much each lens channel contributes to this plane. (1, 0, 0) for red; (1/3, 1/3, 1/3) for
    /// alpha, the coverage seen by all three. They must sum to one for the plane to keep its light.
    pub weights: &'a [f64],
}

/// Applies a lens to planes.
pub trait Renderer: Sync {
    /// Stable identifier, as the command line names it.
    fn id(&self) -> &'static str;

    /// The planes as seen through the lens, in the order given.
    ///
    /// `progress` is called with the share done, from 0 to 1, from any thread; calls from different
    /// threads can arrive slightly out of order. If it returns false the render stops.
    ///
    /// # Errors
    /// - [`Scene::check`]'s;
    /// - a lens whose blur is not finite or too large to draw at some pixel;
    /// - [`stopped`], if `progress` said so.
    fn render(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>>;

    /// Renders the `window` of a plate alone, from all of its light: to the bit what [`Renderer::render`] gives
    /// there, row-major and as large as the window. A renderer that has no way of its own renders the whole.
    ///
    /// # Errors
    /// Those of [`Renderer::render`], and a window that is empty or not wholly on the plate.
    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: Window,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        window.check(scene)?;
        let whole = self.render(scene, planes, progress)?;
        let part = |plane: &Vec<f32>| window.cut(scene.width, plane);
        Ok(whole.iter().map(part).collect())
    }

    /// By which ways [`Renderer::render`] would render; nothing is drawn. A renderer that chooses nothing says
    /// that it renders once; one made of others leaves it to them: [`Noted`](crate::Noted).
    ///
    /// # Errors
    /// Those of [`Renderer::render`].
    fn methods(&self, scene: &Scene, planes: &[Plane]) -> Result<Methods> {
        scene.check(planes)?;
        Ok(Methods {
            renders: 1,
            ..Methods::default()
        })
    }
}

/// A rectangle of a plate's pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Its first column.
    pub column: usize,
    /// Its first row.
    pub row: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Window {
    /// All of a plate.
    pub(crate) fn whole(scene: &Scene) -> Self {
        Self::all_of((scene.width, scene.height))
    }

    /// All of a plate of some columns and rows.
    pub(crate) fn all_of((width, height): (usize, usize)) -> Self {
        Self {
            column: 0,
            row: 0,
            width,
            height,
        }
    }

    /// Its part of a plate's `samples`, `width` columns wide.
    pub(crate) fn cut(&self, width: usize, samples: &[f32]) -> Vec<f32> {
        let rows = samples.chunks_exact(width).skip(self.row).take(self.height);
        rows.flat_map(|row| &row[self.column..self.column + self.width])
            .copied()
            .collect()
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
    /// Number of pixels of the plate.
    pub fn pixel_count(&self) -> usize {
        self.width * self.height
    }

    /// How far along x and along y light of any pixel of the plate lands, plate pixels, tried at nine places and with room
    /// to spare; a million where the lens cannot be drawn.
    pub fn reach_px(&self) -> (f64, f64) {
        reach_of_pass(self)
    }

    /// Vergence of the pixel at row-major `index`, m^-1.
    pub fn vergence_at(&self, index: usize) -> f64 {
        match self.vergence {
            VergencePass::Constant(vergence) => vergence,
            VergencePass::PerPixel(pass) => f64::from(pass[index]),
        }
    }

    /// Whether this scene and `planes` can be rendered.
    ///
    /// # Errors
    /// An empty plate or one too large to index, a scale that is not positive, a plane or depth pass
    /// of the wrong size, the wrong number of channel weights, and samples, weights or depths that
    /// are not finite: the first one found is named by plane and pixel.
    pub fn check(&self, planes: &[Plane]) -> Result<()> {
        // A quarter of i32's range leaves room for kernels beyond the edges.
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

    fn check_samples(&self, name: &str, samples: &[f32]) -> Result<()> {
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
        // Block by block without a branch a sample: every renderer looks at every plane.
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
