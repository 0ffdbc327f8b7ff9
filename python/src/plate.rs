//! Plates: an image array, its depth and the settings about its place and its alpha.

use pyo3::prelude::*;
use seidel_core::{Image, Plate, PlateGeometry};

use crate::array::{ArrayLayout, ArrayPlanes};
use crate::depth;
use crate::error::{Failure, Result};
use crate::settings::CallSettings;

/// A plate of the caller, and the layout of its array.
pub(crate) struct ArrayPlate {
    pub(crate) plate: Plate,
    pub(crate) layout: ArrayLayout,
}

impl ArrayPlate {
    /// Reads the arguments `image` and `depth`. The image is Y, YA, RGB or RGBA by its number of channels.
    ///
    /// # Errors
    /// Arrays of another shape or sample type, and a depth that is not valid.
    pub(crate) fn read(
        image: &Bound<'_, PyAny>,
        depth: Option<&Bound<'_, PyAny>>,
        settings: &CallSettings,
    ) -> Result<Self> {
        let ArrayPlanes { layout, mut planes } = ArrayPlanes::read("image", image)?;
        let names: &[&str] = match planes.len() {
            1 | 2 => &["Y"],
            3 | 4 => &["R", "G", "B"],
            count => {
                return Err(Failure::argument(
                    "image",
                    format!("has {count} channels"),
                    "give 1 (Y), 2 (YA), 3 (RGB) or 4 (RGBA)",
                ));
            }
        };
        let has_alpha = planes.len() > names.len();
        let alpha = if has_alpha { planes.pop() } else { None };
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        let image = Image::new(layout.width, layout.height, names, planes)?;
        let mut image = image.with_alpha(alpha, Vec::new(), settings.alpha);
        if settings.replaces_non_finite {
            image.replace_non_finite();
        }
        let geometry = PlateGeometry {
            pixel_aspect: settings.pixel_aspect,
            lens_scale: settings.lens_scale,
            ..PlateGeometry::of_size(layout.width, layout.height)
        };
        let plate = Plate::new(image)
            .with_geometry(geometry)
            .with_depth(depth::read(depth, &layout)?);
        Ok(Self { plate, layout })
    }
}
