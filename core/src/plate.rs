//! A plate: an image, its place in the frame of the lens, and its depth.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::ImagePoint;
use seidel_render::{DepthConvention, DepthReading, MAX_PIXEL_ASPECT};

use crate::image::Image;
use seidel_optics::Rectangle;

/// A plate: an image, its place in the frame of the lens, and its depth.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Plate {
    /// The image, as large as the data window of `geometry`.
    pub image: Image,
    /// Place of the image in the frame of the lens.
    pub geometry: PlateGeometry,
    /// Distance of the objects in the image.
    pub depth: Depth,
    /// Matte of something that will be composited in front, used by [`apply`](crate::apply).
    pub holdout: Option<HoldoutMatte>,
    /// Mask of [`apply`](crate::apply), 0 to 1, row-major over the data window; 1 everywhere if `None`.
    /// [`Settings::mask_scales`](crate::Settings::mask_scales) chooses what it scales: the mix or the blur.
    pub mask: Option<Vec<f32>>,
    /// The plate without its foreground, used by [`apply`](crate::apply) where blur uncovers it.
    pub background: Option<Background>,
}

impl Plate {
    /// Creates a plate of `image` that fills the frame of the lens, at an unknown distance.
    ///
    /// The image may have any size: it is placed so that its width is that of the frame. A lens that was measured at more
    /// than one distance also needs [`Plate::with_depth`].
    pub fn new(image: Image) -> Self {
        let geometry = PlateGeometry::of_size(image.width(), image.height());
        Self {
            image,
            geometry,
            depth: Depth::Distance(ObjectDistance::Unknown),
            holdout: None,
            mask: None,
            background: None,
        }
    }

    /// The same plate with this `depth`.
    #[must_use]
    pub fn with_depth(mut self, depth: Depth) -> Self {
        self.depth = depth;
        self
    }

    /// The same plate with this `geometry`.
    #[must_use]
    pub fn with_geometry(mut self, geometry: PlateGeometry) -> Self {
        self.geometry = geometry;
        self
    }

    /// The same plate with this `holdout`.
    #[must_use]
    pub fn with_holdout(mut self, holdout: Option<HoldoutMatte>) -> Self {
        self.holdout = holdout;
        self
    }
}

/// Place of a plate in the frame of a lens. The display window lies centre on centre with the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateGeometry {
    /// Display window: the picture proper, pixels.
    pub display: Rectangle,
    /// Data window: the pixels that exist, overscan or crop included.
    pub data: Rectangle,
    /// Width of a pixel over its height in the scene: the squeeze of the lens for an anamorphic plate before it is
    /// desqueezed, 1 after. See [`PlatePlacement::new`](crate::PlatePlacement::new).
    pub pixel_aspect: f64,
    /// Scale of the frame of the lens on the plate.
    pub lens_scale: LensScale,
}

/// Scale of the frame of a lens on a plate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LensScale {
    /// The display window is as wide as the frame.
    #[default]
    FrameWidth,
    /// Plate pixels per pixel of the frame, counted along y.
    PixelRatio(f64),
    /// The display window shows this width of the sensor (film back), millimetres. The lens's pixel pitch must be known.
    FilmBack(f64),
}

impl PlateGeometry {
    /// Square pixels that fill the frame, `width` x `height` of them.
    pub fn of_size(width: usize, height: usize) -> Self {
        let all = Rectangle {
            x: 0,
            y: 0,
            width,
            height,
        };
        Self {
            display: all,
            data: all,
            pixel_aspect: 1.0,
            lens_scale: LensScale::FrameWidth,
        }
    }

    /// Checks that the renderers can follow this geometry.
    ///
    /// # Errors
    /// A pixel aspect outside 1/16 to 16, and a lens scale or a film back that is not above zero.
    pub fn check(&self) -> Result<()> {
        let aspect = self.pixel_aspect;
        if !(1.0 / MAX_PIXEL_ASPECT..=MAX_PIXEL_ASPECT).contains(&aspect) {
            return Err(Error::new(
                "pixel_aspect",
                format!("is {aspect}"),
                "give the width of a pixel over its height, from 1/16 to 16",
            ));
        }
        let (name, value) = match self.lens_scale {
            LensScale::FrameWidth => return Ok(()),
            LensScale::PixelRatio(ratio) => ("lens_scale", ratio),
            LensScale::FilmBack(width_mm) => ("film_back_mm", width_mm),
        };
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        Err(Error::new(
            name,
            format!("is {value}"),
            "give a number greater than zero, or none",
        ))
    }
}

/// Distance of the objects in a plate.
#[derive(Debug, Clone, PartialEq)]
pub enum Depth {
    /// One distance for the whole plate.
    Distance(ObjectDistance),
    /// A distance for each pixel.
    Pass(DepthPass),
}

/// A depth pass and the meaning of its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthPass {
    /// One sample a pixel of the data window, row-major.
    pub samples: Vec<f32>,
    /// The meaning of the samples.
    pub meaning: DepthMeaning,
}

/// The meaning of the samples of a depth pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthMeaning {
    /// Unit, direction and normalisation.
    pub convention: DepthConvention,
    /// Focal length in pixel widths, where distances are measured along the ray from the camera; `None` where they
    /// are measured along the optical axis.
    pub along_ray: Option<f64>,
    /// Longest edge that is an average of both sides, by a filter or over the motion of a shutter, px, and is divided between them; 0: none.
    pub averaged_px: f64,
}

impl DepthMeaning {
    /// Distances along the optical axis, in metres.
    pub const METRES: Self = Self {
        convention: DepthConvention::Distance {
            metres_per_unit: 1.0,
        },
        along_ray: None,
        averaged_px: 0.0,
    };
}

impl DepthPass {
    /// A pass of distances along the optical axis, in metres; `f32::INFINITY` is infinitely far.
    pub fn metres(samples: Vec<f32>) -> Self {
        Self {
            samples,
            meaning: DepthMeaning::METRES,
        }
    }

    /// Returns the vergence of each pixel, in 1/m, and statistics of the pass. It is `width` pixels wide, its optical
    /// axis at `axis` in plate pixels, each pixel `pixel_aspect` times as wide as high.
    ///
    /// # Errors
    /// Those of [`DepthConvention::read`] and [`DepthReading::turn_along_axis`].
    pub fn read(&self, width: usize, axis: ImagePoint, pixel_aspect: f64) -> Result<DepthReading> {
        let mut reading = self.meaning.convention.read(&self.samples, width)?;
        if let Some(focal_px) = self.meaning.along_ray {
            reading.turn_along_axis(width, axis, focal_px, pixel_aspect)?;
        }
        Ok(reading)
    }
}

/// A plate without its foreground, such as a clean plate: an image of the plate's size, and its depth. It is sharp where the
/// plate is blurred by [`apply`](crate::apply()), and has the blur of the lens where [`remove`](crate::remove()) removes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Background {
    /// The image, with the colours of the plate.
    pub image: Image,
    /// Distance of the objects in it.
    pub depth: Depth,
}

/// Matte of something that will be composited in front of a blurred plate.
#[derive(Debug, Clone, PartialEq)]
pub struct HoldoutMatte {
    /// Share of each pixel that is held back, 0 to 1, row-major over the data window.
    pub samples: Vec<f32>,
    /// Depth of the matte: only what lies behind is held back. `None`: everything is.
    pub depth: Option<DepthPass>,
}

impl HoldoutMatte {
    /// Checks that all samples are from 0 to 1; the plate is `width` pixels wide.
    ///
    /// # Errors
    /// The first sample that is not, by its pixel.
    pub fn check(&self, width: usize) -> Result<()> {
        check_matte("holdout matte", &self.samples, width)
    }
}

/// Checks that all samples of a matte, called `name` and `width` pixels wide, are from 0 to 1.
pub(crate) fn check_matte(name: &str, samples: &[f32], width: usize) -> Result<()> {
    let bad = samples.iter().position(|v| !(0.0..=1.0).contains(v));
    bad.map_or(Ok(()), |at| {
        Err(Error::new(
            format!("{name}, pixel ({}, {})", at % width, at / width),
            format!("is {}", samples[at]),
            "give a matte of values from 0 to 1",
        ))
    })
}
