//! Accuracy, edges and occlusion of a render.

use super::choice::{Choice, ChoiceOption, index_in};
use super::kind::{HostGroup, HostKnob, Knob, KnobKind, KnobScope, KnobUse, Relation, Switch};
use crate::settings::{Edges, Expand, OcclusionSettings, Quality};

const fn host(name: &'static str, label: &'static str) -> Option<HostKnob> {
    Some(HostKnob {
        name,
        label,
        group: HostGroup::Render,
    })
}

fn is_apply(case: &KnobUse) -> bool {
    !case.is_removal()
}

const QUALITIES: [Quality; 3] = [Quality::Draft, Quality::Final, Quality::Exact];

const EDGES: [Option<Edges>; 4] = [
    Some(Edges::Mirror),
    Some(Edges::Black),
    Some(Edges::Extend),
    None,
];

const EXPANSIONS: [Expand; 3] = [Expand::Auto, Expand::Always, Expand::Never];

pub(super) static KNOBS: &[Knob] = &[
    Knob {
        name: "quality",
        host: host("quality", "Quality"),
        scope: KnobScope::Apply,
        help: "Accuracy of the render, as PSNR against the exact renderer",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Choice(Choice {
            options: &[
                ChoiceOption {
                    word: "draft",
                    label: "Draft",
                    help: "For previews: 45 dB",
                },
                ChoiceOption {
                    word: "final",
                    label: "Final",
                    help: "For delivery: 60 dB, 75 dB where no blur is above 6 px, 50 dB for lenses modelled ray by ray",
                },
                ChoiceOption {
                    word: "exact",
                    label: "Exact",
                    help: "A kernel of its own for every source pixel: slow",
                },
            ],
            default: 1,
            get: |settings| index_in(&QUALITIES, &settings.quality),
            set: |settings, index| settings.quality = QUALITIES[index],
        }),
        has_effect: |_| true,
    },
    Knob {
        name: "edges",
        host: host("edge", "Edges"),
        scope: KnobScope::Apply,
        help: "Light beyond the edges of the plate",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Choice(Choice {
            options: &[
                ChoiceOption {
                    word: "mirror",
                    label: "Mirror",
                    help: "The mirrored plate: no light is lost",
                },
                ChoiceOption {
                    word: "black",
                    label: "Black",
                    help: "Black: light that leaves the plate is lost",
                },
                ChoiceOption {
                    word: "extend",
                    label: "Nearest",
                    help: "The nearest pixel of the plate, with its depth and blur",
                },
                ChoiceOption {
                    word: "auto",
                    label: "Auto",
                    help: "By alpha: mirror for full frames, black for elements over nothing, extend for elements that the border cuts",
                },
            ],
            default: 3,
            get: |settings| index_in(&EDGES, &settings.edges),
            set: |settings, index| settings.edges = EDGES[index],
        }),
        has_effect: is_apply,
    },
    Knob {
        name: "expand",
        host: host("expand", "Expand"),
        scope: KnobScope::Apply,
        help: "Sides on which the data window grows by the reach of the blur, so that an element keeps its blurred rim",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Choice(Choice {
            options: &[
                ChoiceOption {
                    word: "auto",
                    label: "Auto",
                    help: "Sides beyond which nothing is known to be: those of a plate with alpha whose border is transparent or that lie within the display window",
                },
                ChoiceOption {
                    word: "on",
                    label: "On",
                    help: "All sides",
                },
                ChoiceOption {
                    word: "off",
                    label: "Off",
                    help: "No side: light beyond the data window is cropped",
                },
            ],
            default: 0,
            get: |settings| index_in(&EXPANSIONS, &settings.expand),
            set: |settings, index| settings.expand = EXPANSIONS[index],
        }),
        has_effect: is_apply,
    },
    Knob {
        name: "occlusion",
        host: host("occlusion", "Occlusion"),
        scope: KnobScope::Apply,
        help: "Near surfaces occlude far ones where depth varies; otherwise the light of all depths is added",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Switch(Switch {
            default: true,
            get: |settings| settings.occlusion.is_some(),
            set: |settings, is_on| {
                settings.occlusion = is_on.then(OcclusionSettings::default);
            },
        }),
        has_effect: is_apply,
    },
    Knob {
        name: "fill-foreground",
        host: host("fillForeground", "Fill Foreground"),
        scope: KnobScope::Apply,
        help: "Background that a blurred foreground uncovers is filled from the background beside it, rather than with the foreground's own light",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Switch(Switch {
            default: true,
            get: |settings| settings.occlusion.is_none_or(|o| o.fill_foreground),
            set: |settings, is_on| {
                if let Some(occlusion) = &mut settings.occlusion {
                    occlusion.fill_foreground = is_on;
                }
            },
        }),
        has_effect: is_apply,
    },
    Knob {
        name: "blur-inside",
        host: host("blurInside", "Blur Inward"),
        scope: KnobScope::Apply,
        help: "A blurred foreground becomes transparent inside its own outline too, as in a camera; otherwise it only blurs outwards",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Switch(Switch {
            default: true,
            get: |settings| settings.occlusion.is_none_or(|o| o.blur_inside),
            set: |settings, is_on| {
                if let Some(occlusion) = &mut settings.occlusion {
                    occlusion.blur_inside = is_on;
                }
            },
        }),
        has_effect: is_apply,
    },
];
