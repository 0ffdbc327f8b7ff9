//! What is needed of the inputs.

use std::ffi::CStr;

use super::{Answer, Call};
use crate::clips::{DEPTH, HOLDOUT, MASK};
use crate::host::Result;
use crate::rendering::project_of;
use crate::sys::OfxRectD;
use crate::sys::effect::{CLIP_SOURCE, REGION_OF_INTEREST};
use crate::sys::property::TIME;

const INPUTS: [(&CStr, &CStr); 4] = [
    (CLIP_SOURCE, c"OfxImageClipPropRoI_Source"),
    (DEPTH, c"OfxImageClipPropRoI_Depth"),
    (HOLDOUT, c"OfxImageClipPropRoI_Holdout"),
    (MASK, c"OfxImageClipPropRoI_Mask"),
];

/// Asks for all of each input: the whole plate tells how a part of it is drawn. Of the mask, what is rendered. Some hosts
/// (openfx-runner) do not know yet how large an input is: then for all of the project.
pub(super) fn regions(call: &Call) -> Result<Answer> {
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    let asked = call.arguments.doubles::<4>(REGION_OF_INTEREST);
    let asked = asked.map(|[x1, y1, x2, y2]| OfxRectD { x1, y1, x2, y2 });
    for (name, property) in INPUTS {
        let Some(clip) = call.effect.clip(name) else {
            continue;
        };
        let known = clip.region_of_definition(time);
        let all = known.or_else(|| match (asked, project_of(call)) {
            (Some(asked), Some(project)) => Some(joined(asked, project)),
            (asked, project) => asked.or(project),
        });
        let Some(all) = all else {
            continue;
        };
        let wanted = match asked {
            Some(asked) if name == MASK => meet(all, asked),
            _ => all,
        };
        // Nuke runs out of memory for what is empty.
        let one = OfxRectD {
            x2: 1.0,
            y2: 1.0,
            ..OfxRectD::default()
        };
        let full = wanted.x2 > wanted.x1 && wanted.y2 > wanted.y1;
        let region = if full { wanted } else { one };
        let corners = [region.x1, region.y1, region.x2, region.y2];
        call.answers.set_doubles(property, &corners);
    }
    Ok(Answer::Done)
}

fn joined(a: OfxRectD, b: OfxRectD) -> OfxRectD {
    OfxRectD {
        x1: a.x1.min(b.x1),
        y1: a.y1.min(b.y1),
        x2: a.x2.max(b.x2),
        y2: a.y2.max(b.y2),
    }
}

fn meet(a: OfxRectD, b: OfxRectD) -> OfxRectD {
    OfxRectD {
        x1: a.x1.max(b.x1),
        y1: a.y1.max(b.y1),
        x2: a.x2.min(b.x2),
        y2: a.y2.min(b.y2),
    }
}
