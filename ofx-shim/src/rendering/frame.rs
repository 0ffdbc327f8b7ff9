//! Where the frame of a render lies.

use seidel_c::SeidelRect;

use crate::actions::Call;
use crate::geometry::{Field, Plane, Scale, is_empty, meet};
use crate::host::{Clip, Failure, Image, Result};
use crate::knobs::{Knobs, lens};
use crate::sys::clip::{FIELD_LOWER, FIELD_UPPER};
use crate::sys::effect::{
    FIELD_TO_RENDER, PROJECT_OFFSET, PROJECT_SIZE, RENDER_SCALE, RENDER_WINDOW,
};
use crate::sys::{OfxRectD, OfxRectI};

/// A frame of a render.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) scale: Scale,
    pub(crate) field: Field,
    pub(crate) plane: Plane,
    /// What the lens's frame is laid on.
    pub(crate) format: SeidelRect,
    /// All pixels of the source.
    pub(crate) extent: SeidelRect,
    /// What is asked for.
    pub(crate) window: SeidelRect,
}

/// Which pixels a render is asked for.
///
/// # Errors
/// A host that does not say.
pub(crate) fn window_of(call: &Call) -> Result<OfxRectI> {
    let window = call.arguments.ints::<4>(RENDER_WINDOW);
    let [x1, y1, x2, y2] =
        window.ok_or_else(|| Failure::failed("The host did not say which pixels to render."))?;
    Ok(OfxRectI { x1, y1, x2, y2 })
}

/// Which field it is asked for.
pub(crate) fn field_of(call: &Call) -> Field {
    match () {
        () if call.arguments.equals(FIELD_TO_RENDER, FIELD_LOWER) => Field::Lower,
        () if call.arguments.equals(FIELD_TO_RENDER, FIELD_UPPER) => Field::Upper,
        () => Field::Whole,
    }
}

impl Frame {
    /// That of a render of `source`, which came of `clip`, to a picture with the pixels `output`, of which those of
    /// `asked` are asked for.
    pub(crate) fn new(
        call: &Call,
        knobs: &Knobs,
        (clip, source): (&Clip, &Image),
        (time, output): (f64, OfxRectI),
        asked: OfxRectI,
    ) -> Self {
        // Pictures of some hosts say another scale than the render's.
        let render_scale = call.arguments.doubles(RENDER_SCALE).unwrap_or([1.0; 2]);
        let aspect = source.pixel_aspect.or(clip.pixel_aspect()).unwrap_or(1.0);
        let scale = Scale::new(render_scale, aspect);
        let field = field_of(call);
        let region = clip.region_of_definition(time);
        let of_regions = region.map_or(scale, |region| {
            scale.of_regions(region, source.bounds, aspect)
        });
        let rod = region.map(|region| of_regions.pixels_of(region));
        let extent = rod.filter(|rod| !is_empty(*rod)).unwrap_or(source.bounds);
        let project = project_of(call).map(|project| match region == Some(project) {
            true => of_regions.pixels_of(project),
            false => scale.pixels_of(project),
        });
        let project = project.filter(|project| !is_empty(*project));
        let format = match project {
            Some(project) if knobs.choice(&lens::FRAME) == lens::FRAME_PROJECT => project,
            _ => extent,
        };
        // Endless regions end where the format and the picture do.
        let most = joined(joined(format, source.bounds), output);
        let extent = meet(extent, most);
        let window = meet(asked, output);
        let plane = Plane::new(format, field);
        Self {
            scale,
            field,
            plane,
            format: plane.rect(format),
            extent: plane.rect(extent),
            window: plane.rect(window),
        }
    }

    /// What of the window lies in the extent, where anything does.
    pub(crate) fn within(&self) -> Option<SeidelRect> {
        let (a, b) = (self.window, self.extent);
        let (left, top) = (a.left.max(b.left), a.top.max(b.top));
        let width = (a.left + a.width).min(b.left + b.width) - left;
        let height = (a.top + a.height).min(b.top + b.height) - top;
        (width > 0 && height > 0).then_some(SeidelRect {
            left,
            top,
            width,
            height,
        })
    }
}

fn joined(a: OfxRectI, b: OfxRectI) -> OfxRectI {
    OfxRectI {
        x1: a.x1.min(b.x1),
        y1: a.y1.min(b.y1),
        x2: a.x2.max(b.x2),
        y2: a.y2.max(b.y2),
    }
}

/// The project's picture proper, canonical.
pub(crate) fn project_of(call: &Call) -> Option<OfxRectD> {
    let props = call.effect.properties();
    let [width, height] = props.doubles::<2>(PROJECT_SIZE)?;
    let [x1, y1] = props.doubles::<2>(PROJECT_OFFSET).unwrap_or([0.0; 2]);
    let sound = [width, height, x1, y1].iter().all(|v| v.is_finite());
    (sound && width > 0.0 && height > 0.0).then_some(OfxRectD {
        x1,
        y1,
        x2: x1 + width,
        y2: y1 + height,
    })
}
