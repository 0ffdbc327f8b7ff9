//! GetRegionsOfInterest: the pixels of the inputs that a render needs.

use std::ffi::CStr;

use super::Answer;
use crate::clips::{APERTURE, DEPTH, HOLDOUT, MASK, REFERENCE};
use crate::host::{Call, Result};
use crate::knobs::Knobs;
use crate::rendering::project_region;
use crate::settings::mask_scales_blur;
use crate::sys::OfxRectD;
use crate::sys::effect::{CLIP_SOURCE, REGION_OF_INTEREST};

/// The inputs, and the properties that request their regions.
const INPUTS: [(&CStr, &CStr); 6] = [
    (CLIP_SOURCE, c"OfxImageClipPropRoI_Source"),
    (DEPTH, c"OfxImageClipPropRoI_Depth"),
    (HOLDOUT, c"OfxImageClipPropRoI_Holdout"),
    (APERTURE, c"OfxImageClipPropRoI_Aperture"),
    (MASK, c"OfxImageClipPropRoI_Mask"),
    (REFERENCE, c"OfxImageClipPropRoI_Reference"),
];

/// Requests all of each input, since how a part is rendered depends on the whole plate; of a mask that only mixes, the rendered part. The
/// region of the project takes the place of an input's region that is not known yet (openfx-runner).
pub(super) fn regions(call: &Call) -> Result<Answer> {
    let time = call.time();
    let mask_mixes = !mask_scales_blur(&Knobs::at(&call.effect, time));
    let asked = call.arguments.doubles::<4>(REGION_OF_INTEREST);
    let asked = asked.map(|[x1, y1, x2, y2]| OfxRectD { x1, y1, x2, y2 });
    for (name, property) in INPUTS {
        let Some(clip) = call.effect.clip(name) else {
            continue;
        };
        let known = clip.region_of_definition(time);
        let all = known.or_else(|| match (asked, project_region(call)) {
            (Some(asked), Some(project)) => Some(bounding_box(asked, project)),
            (asked, project) => asked.or(project),
        });
        let Some(all) = all else {
            continue;
        };
        let wanted = match asked {
            Some(asked) if name == MASK && mask_mixes => intersection(all, asked),
            _ => all,
        };
        // Nuke runs out of memory with an empty region.
        let one_pixel = OfxRectD {
            x2: 1.0,
            y2: 1.0,
            ..OfxRectD::default()
        };
        let has_pixels = wanted.x2 > wanted.x1 && wanted.y2 > wanted.y1;
        let region = if has_pixels { wanted } else { one_pixel };
        let corners = [region.x1, region.y1, region.x2, region.y2];
        call.answers.set_doubles(property, &corners);
    }
    Ok(Answer::Done)
}

fn bounding_box(a: OfxRectD, b: OfxRectD) -> OfxRectD {
    OfxRectD {
        x1: a.x1.min(b.x1),
        y1: a.y1.min(b.y1),
        x2: a.x2.max(b.x2),
        y2: a.y2.max(b.y2),
    }
}

fn intersection(a: OfxRectD, b: OfxRectD) -> OfxRectD {
    OfxRectD {
        x1: a.x1.max(b.x1),
        y1: a.y1.max(b.y1),
        x2: a.x2.min(b.x2),
        y2: a.y2.min(b.y2),
    }
}
