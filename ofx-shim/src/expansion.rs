//! Growth of the region of definition by the reach of the blur, so that an element keeps its blurred rim.

use seidel_core::{
    Expand, HostGroup, Lens, LensSession, ObjectDistance, Rectangle, RelensSide, Settings,
};

use crate::clips::DEPTH;
use crate::geometry::{Field, PixelMap, PlateScale, Scale};
use crate::host::{Call, Clip, Result};
use crate::knobs::{Knobs, depth, lens, output};
use crate::settings::{HostQuality, chosen_lens, plate_distance_m, plate_geometry, settings};
use crate::sys::OfxRectD;
use crate::sys::clip::{ALPHA, COMPONENTS, RGBA};

/// Largest growth on a side, as a share of the longer side of the source.
const LARGEST_SHARE: f64 = 1.0;

/// Returns the canonical region of the result: `region`, that of the `source`, with the reach of the blur on the sides that
/// the knob Expand names. With Auto these are the sides of a source with alpha that lie within the `project`.
///
/// It depends on no pixels, as hosts ask for it before they give any, and not on the scale of the render. A lens that cannot be
/// used gives `region`; the render reports it.
pub(crate) fn expanded_region(
    call: &Call,
    knobs: &Knobs,
    source: &Clip,
    region: OfxRectD,
    project: Option<OfxRectD>,
) -> OfxRectD {
    let is_blur =
        knobs.choice(&lens::MODE) == lens::APPLY && knobs.choice(&output::OUTPUT) == output::RESULT;
    let mut settings = Settings::default();
    if !is_blur || (knobs.put(HostGroup::Render, PlateScale::FULL, &mut settings)).is_err() {
        return region;
    }
    let sides = match settings.expand {
        Expand::Auto if has_alpha(source) => sides_within(region, project),
        Expand::Always => [true; 4],
        Expand::Auto | Expand::Never => [false; 4],
    };
    if sides == [false; 4] {
        return region;
    }
    let format = project.filter(|_| knobs.choice(&lens::FRAME) == lens::FRAME_PROJECT);
    let Ok((x, y)) = reach(call, knobs, source, [format.unwrap_or(region), region]) else {
        return region;
    };
    let longer = (region.x2 - region.x1).max(region.y2 - region.y1);
    let grow = |side: usize, reach: f64| {
        if sides[side] {
            reach.min(LARGEST_SHARE * longer).ceil()
        } else {
            0.0
        }
    };
    OfxRectD {
        x1: region.x1 - grow(0, x),
        y1: region.y1 - grow(1, y),
        x2: region.x2 + grow(2, x),
        y2: region.y2 + grow(3, y),
    }
}

fn has_alpha(source: &Clip) -> bool {
    let components = [RGBA, ALPHA].into_iter();
    components
        .into_iter()
        .any(|own| source.properties.equals(COMPONENTS, own))
}

/// Returns which of left, bottom, right and top lie within the project.
fn sides_within(region: OfxRectD, project: Option<OfxRectD>) -> [bool; 4] {
    project.map_or([false; 4], |project| {
        [
            region.x1 > project.x1,
            region.y1 > project.y1,
            region.x2 < project.x2,
            region.y2 < project.y2,
        ]
    })
}

/// Returns how far blur reaches along x and y, canonical, for a source that fills the canonical region `source_region` of the
/// `format`.
///
/// With a depth pass, whose values are not known yet, it is that of the farthest and the nearest measured distance.
fn reach(
    call: &Call,
    knobs: &Knobs,
    source: &Clip,
    [format, source_region]: [OfxRectD; 2],
) -> Result<(f64, f64)> {
    let profile = chosen_lens(knobs, &lens::LENS, &lens::PROFILE)?;
    let full = Scale::new([1.0; 2], source.pixel_aspect().unwrap_or(1.0));
    let scale = PlateScale::new(full, Field::Whole);
    let settings = settings(knobs, &profile, scale, HostQuality::Full, RelensSide::From)?;
    let session = LensSession::new(&profile, &settings)?;
    let map = PixelMap::new(full.pixels_of(format), Field::Whole);
    let of_plate = |region| -> Rectangle { map.rectangle(full.pixels_of(region)) };
    let geometry = plate_geometry(
        session.settings(),
        scale,
        of_plate(format),
        of_plate(source_region),
    );
    let mut largest = (0.0_f64, 0.0_f64);
    for distance in distances(call, knobs, session.lens())? {
        let (x, y) = session.reach_px(&geometry, distance)?;
        largest = (largest.0.max(x), largest.1.max(y));
    }
    Ok((largest.0 / full.x, largest.1 / full.y))
}

/// Returns the distances that objects may have.
fn distances(call: &Call, knobs: &Knobs, profile: &Lens) -> Result<Vec<ObjectDistance>> {
    if !profile.predictor().depends_on_depth() {
        return Ok(vec![ObjectDistance::Unknown]);
    }
    let depth_clip = call.effect.clip(DEPTH).filter(Clip::is_connected);
    if depth_clip.is_none() || !knobs.is_on(&depth::USE_DEPTH) {
        return Ok(vec![ObjectDistance::metres(plate_distance_m(knobs))?]);
    }
    let (near, far) = profile
        .profile()
        .measured_range_m()
        .unwrap_or((f64::INFINITY, f64::INFINITY));
    let ends = [near, far, f64::INFINITY].into_iter();
    Ok(ends
        .map(ObjectDistance::metres)
        .collect::<seidel_core::Result<_>>()?)
}
