//! The place of the rendered frame in the host's coordinates and in those of the plate.

use seidel_core::{Margins, Rectangle};

use super::Source;
use crate::expansion::expanded_region;
use crate::geometry::{Field, PixelMap, PlateScale, Scale, bounding_box, intersection, is_empty};
use crate::host::{Call, Failure, Result};
use crate::knobs::{Knobs, lens};
use crate::sys::clip::{FIELD_LOWER, FIELD_UPPER};
use crate::sys::effect::{
    FIELD_TO_RENDER, PROJECT_OFFSET, PROJECT_SIZE, RENDER_SCALE, RENDER_WINDOW,
};
use crate::sys::{OfxRectD, OfxRectI};

/// The place of a rendered frame. Rectangles are in plate pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) scale: PlateScale,
    pub(crate) map: PixelMap,
    /// Pixels on which the frame of the lens lies, centre on centre.
    pub(crate) format: Rectangle,
    /// All pixels of the source.
    pub(crate) extent: Rectangle,
    /// Pixels by which the result is larger than the source.
    pub(crate) margins: Margins,
    /// Pixels to render.
    pub(crate) window: Rectangle,
}

/// Returns the pixels that the host asks for.
///
/// # Errors
/// A host that does not give them.
pub(crate) fn render_window(call: &Call) -> Result<OfxRectI> {
    let window = call.arguments.ints::<4>(RENDER_WINDOW);
    let [x1, y1, x2, y2] =
        window.ok_or_else(|| Failure::failed("The host did not say which pixels to render."))?;
    Ok(OfxRectI { x1, y1, x2, y2 })
}

/// Returns the field that the host asks for.
pub(crate) fn field(call: &Call) -> Field {
    if call.arguments.equals(FIELD_TO_RENDER, FIELD_LOWER) {
        Field::Lower
    } else if call.arguments.equals(FIELD_TO_RENDER, FIELD_UPPER) {
        Field::Upper
    } else {
        Field::Whole
    }
}

impl Frame {
    /// Creates the place of a render of `source` to an image with the pixels `output`, of which the host asks for
    /// `window`.
    pub(crate) fn new(
        call: &Call,
        knobs: &Knobs,
        source: &Source,
        output: OfxRectI,
        window: OfxRectI,
    ) -> Self {
        // From the action, since images of some hosts give another scale.
        let render_scale = call.arguments.doubles(RENDER_SCALE).unwrap_or([1.0; 2]);
        let aspect = source.pixel_aspect();
        let bounds = source.image.bounds;
        let scale = Scale::new(render_scale, aspect);
        let field = field(call);
        let region = source.clip.region_of_definition(call.time());
        let region_scale = region.map_or(scale, |region| scale.of_regions(region, bounds, aspect));
        let region_pixels = region.map(|region| region_scale.pixels_of(region));
        let extent = region_pixels
            .filter(|pixels| !is_empty(*pixels))
            .unwrap_or(bounds);
        let project_region = project_region(call);
        let expanded =
            region.map(|region| expanded_region(call, knobs, &source.clip, region, project_region));
        let project = project_region.map(|project| {
            if region == Some(project) {
                region_scale.pixels_of(project)
            } else {
                scale.pixels_of(project)
            }
        });
        let project = project.filter(|project| !is_empty(*project));
        let format = match project {
            Some(project) if knobs.choice(&lens::FRAME) == lens::FRAME_PROJECT => project,
            _ => extent,
        };
        // Infinite regions end where the format and the images do.
        let limit = bounding_box(bounding_box(format, bounds), output);
        let map = PixelMap::new(format, field);
        let own = map.rectangle(extent);
        let grown = expanded.map_or(own, |region| map.rectangle(region_scale.pixels_of(region)));
        Self {
            margins: margins(own, grown),
            scale: PlateScale::new(scale, field),
            map,
            format: map.rectangle(format),
            extent: map.rectangle(intersection(extent, limit)),
            window: map.rectangle(intersection(window, output)),
        }
    }

    /// Returns the pixels of the window that the result has, or `None` if it has none.
    pub(crate) fn covered_window(&self) -> Option<Rectangle> {
        self.window.intersection(&self.margins.around(self.extent))
    }
}

/// Returns the margins of `grown` about `own`.
fn margins(own: Rectangle, grown: Rectangle) -> Margins {
    let margin = |inner: i32, outer: i32| (inner - outer).max(0) as usize;
    Margins {
        left: margin(own.x, grown.x),
        top: margin(own.y, grown.y),
        right: margin(grown.columns().end, own.columns().end),
        bottom: margin(grown.rows().end, own.rows().end),
    }
}

/// Returns the region of the project, canonical.
pub(crate) fn project_region(call: &Call) -> Option<OfxRectD> {
    let properties = call.effect.properties();
    let [width, height] = properties.doubles::<2>(PROJECT_SIZE)?;
    let [x1, y1] = properties.doubles::<2>(PROJECT_OFFSET).unwrap_or([0.0; 2]);
    let is_finite = [width, height, x1, y1].iter().all(|v| v.is_finite());
    (is_finite && width > 0.0 && height > 0.0).then_some(OfxRectD {
        x1,
        y1,
        x2: x1 + width,
        y2: y1 + height,
    })
}
