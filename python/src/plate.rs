//! Plates: an image array, its depth, and what belongs to them.

use pyo3::prelude::*;
use seidel_core::{
    AlphaKind, Background, Depth, HoldoutMatte, Image, Plate, PlateGeometry, Rectangle,
};

use crate::array::{ArrayLayout, ArrayPlanes};
use crate::depth;
use crate::error::{Failure, Result};
use crate::settings::CallSettings;

/// A plate of the caller, and the layout of its array.
pub(crate) struct ArrayPlate {
    pub(crate) plate: Plate,
    pub(crate) layout: ArrayLayout,
}

/// The attributes of `seidel.Holdout`.
#[derive(FromPyObject)]
struct HoldoutArgs<'py> {
    matte: Bound<'py, PyAny>,
    depth: Option<Bound<'py, PyAny>>,
}

/// The attributes of `seidel.Background`.
#[derive(FromPyObject)]
struct BackgroundArgs<'py> {
    image: Bound<'py, PyAny>,
    depth: Bound<'py, PyAny>,
}

impl ArrayPlate {
    /// Reads the arguments `image` and `depth`.
    ///
    /// # Errors
    /// Arrays of another shape or sample type, and a depth that is not valid.
    pub(crate) fn read(
        image: &Bound<'_, PyAny>,
        depth: Option<&Bound<'_, PyAny>>,
        settings: &CallSettings,
    ) -> Result<Self> {
        let ArrayImage { image, layout } = ArrayImage::read("image", image, settings)?;
        let plate = Plate::new(image)
            .with_geometry(geometry(&layout, settings)?)
            .with_depth(depth::read("depth", depth, &layout)?);
        Ok(Self { plate, layout })
    }

    /// Adds the argument `holdout`: a matte, or a `Holdout`.
    ///
    /// # Errors
    /// Arrays of another size, and a holdout without occlusion.
    pub(crate) fn add_holdout(
        &mut self,
        holdout: Option<&Bound<'_, PyAny>>,
        settings: &CallSettings,
    ) -> Result<()> {
        let Some(holdout) = holdout else {
            return Ok(());
        };
        settings.check_occlusion("holdout")?;
        let args = if holdout.hasattr("matte")? {
            holdout.extract()?
        } else {
            HoldoutArgs {
                matte: holdout.clone(),
                depth: None,
            }
        };
        let matte = ArrayPlanes::read("holdout", &args.matte)?;
        let pass = args.depth.map(|depth| -> Result<_> {
            match depth::read("holdout.depth", Some(&depth), &self.layout)? {
                Depth::Pass(pass) => Ok(pass),
                Depth::Distance(_) => Err(Failure::argument(
                    "holdout.depth",
                    "is one distance",
                    "give an array of distances, or a DepthPass",
                )),
            }
        });
        let holdout = HoldoutMatte {
            samples: matte.into_plane("holdout", &self.layout)?,
            depth: pass.transpose()?,
        };
        (holdout.check(self.layout.width)).map_err(|error| error.within("holdout"))?;
        self.plate.holdout = Some(holdout);
        Ok(())
    }

    /// Adds the argument `mask`.
    ///
    /// # Errors
    /// An array of another size.
    pub(crate) fn add_mask(&mut self, mask: Option<&Bound<'_, PyAny>>) -> Result<()> {
        let Some(mask) = mask else {
            return Ok(());
        };
        let samples = ArrayPlanes::read("mask", mask)?;
        self.plate.mask = Some(samples.into_plane("mask", &self.layout)?);
        Ok(())
    }

    /// Adds the argument `background`, a `Background`.
    ///
    /// # Errors
    /// Arrays of another size, and a plate at one distance.
    pub(crate) fn add_background(
        &mut self,
        background: Option<&Bound<'_, PyAny>>,
        settings: &CallSettings,
    ) -> Result<()> {
        let Some(background) = background else {
            return Ok(());
        };
        if matches!(self.plate.depth, Depth::Distance(_)) {
            return Err(Failure::argument(
                "background",
                "is given, but the image lies at one distance, where nothing hides it",
                "give the depth of every pixel, or leave out the background",
            ));
        }
        let args: BackgroundArgs<'_> = background.extract()?;
        let image = ArrayImage::read("background.image", &args.image, settings)?.image;
        let depth = depth::read("background.depth", Some(&args.depth), &self.layout)?;
        self.plate.background = Some(Background { image, depth });
        Ok(())
    }
}

/// An image of the caller, and the layout of its array.
struct ArrayImage {
    image: Image,
    layout: ArrayLayout,
}

impl ArrayImage {
    /// Reads the argument `name`: Y, YA, RGB, RGBA, or RGBA and the alpha of each colour, by its number of channels.
    ///
    /// # Errors
    /// An array of another shape or sample type.
    fn read(name: &str, array: &Bound<'_, PyAny>, settings: &CallSettings) -> Result<Self> {
        let ArrayPlanes { layout, mut planes } = ArrayPlanes::read(name, array)?;
        let names: &[&str] = match planes.len() {
            1 | 2 => &["Y"],
            3 | 4 | 7 => &["R", "G", "B"],
            count => {
                return Err(Failure::argument(
                    name,
                    format!("has {count} channels"),
                    "give 1 (Y), 2 (YA), 3 (RGB), 4 (RGBA), or 7 (RGBA and the alphas of R, G and B)",
                ));
            }
        };
        let mut alphas = planes.split_off(names.len());
        let channel_alphas = alphas.split_off(alphas.len().min(1));
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        let image = Image::new(layout.width, layout.height, names, planes)?;
        let kind = if alphas.is_empty() {
            AlphaKind::Premultiplied
        } else {
            settings.alpha
        };
        let mut image = image.with_alpha(alphas.pop(), channel_alphas, kind);
        if settings.replaces_non_finite {
            image.replace_non_finite();
        }
        Ok(Self { image, layout })
    }
}

/// Returns the place of an array of `layout` in the frame of the lens.
///
/// # Errors
/// An empty display window.
pub(crate) fn geometry(layout: &ArrayLayout, settings: &CallSettings) -> Result<PlateGeometry> {
    let all = PlateGeometry::of_size(layout.width, layout.height);
    let window = settings.display_window;
    Ok(PlateGeometry {
        display: window.map_or(Ok(all.display), rectangle)?,
        pixel_aspect: settings.pixel_aspect,
        lens_scale: settings.lens_scale,
        ..all
    })
}

/// Returns the display window (x, y, width, height) of the settings.
fn rectangle(window: (i32, i32, usize, usize)) -> Result<Rectangle> {
    let (x, y, width, height) = window;
    if width == 0 || height == 0 {
        return Err(Failure::argument(
            "settings.display_window",
            format!("is {width} x {height} pixels"),
            "give (x, y, width, height) in image pixels, width and height above 0",
        ));
    }
    Ok(Rectangle {
        x,
        y,
        width,
        height,
    })
}
