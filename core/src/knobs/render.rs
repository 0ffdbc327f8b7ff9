//! Accuracy, edges and occlusion of a render.

use super::choice::{Choice, ChoiceOption, index_in};
use super::kind::{HostGroup, Knob, KnobKind, KnobScope, KnobUse, Number, Switch, Unit};
use crate::settings::{Edges, Expand, MaskScales, OcclusionSettings, Quality};

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

const MASK_SCALES: [MaskScales; 2] = [MaskScales::Mix, MaskScales::Blur];

const EXPANSIONS: [Expand; 3] = [Expand::Auto, Expand::Always, Expand::Never];

pub(super) static KNOBS: &[Knob] = &[
    Knob::new(
        "quality",
        KnobScope::Apply,
        "Accuracy of the render, as PSNR against the exact renderer",
        KnobKind::Choice(Choice {
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
    )
    .in_hosts(HostGroup::Render, ["quality", "Quality"]),
    Knob {
        has_effect: is_apply,
        ..Knob::new(
            "edges",
            KnobScope::Apply,
            "Light beyond the edges of the plate",
            KnobKind::Choice(Choice {
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
        )
        .in_hosts(HostGroup::Render, ["edge", "Edges"])
    },
    Knob {
        has_effect: is_apply,
        ..Knob::new(
            "expand",
            KnobScope::Apply,
            "Sides on which the data window grows by the reach of the blur, so that an element keeps its blurred rim",
            KnobKind::Choice(Choice {
                options: &[
                    ChoiceOption {
                        word: "auto",
                        label: "Auto",
                        help: "Sides where the plate is transparent: those of a plate with alpha whose border is transparent or that lie within the display window",
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
        )
        .in_hosts(HostGroup::Render, ["expand", "Expand"])
    },
    Knob {
        has_effect: is_apply,
        ..Knob::new(
            "occlusion",
            KnobScope::Apply,
            "Near surfaces occlude far ones where depth varies; otherwise the light of all depths is added",
            KnobKind::Switch(Switch {
                default: true,
                get: |settings| settings.occlusion.is_some(),
                set: |settings, is_on| {
                    settings.occlusion = is_on.then(OcclusionSettings::default);
                },
            }),
        )
        .in_hosts(HostGroup::Render, ["occlusion", "Occlusion"])
    },
    Knob {
        has_effect: is_apply,
        ..Knob::new(
            "fill-foreground",
            KnobScope::Apply,
            "Background that a blurred foreground uncovers is filled from the background beside it, rather than with the foreground's own light",
            KnobKind::Switch(Switch {
                default: true,
                get: |settings| settings.occlusion.is_none_or(|o| o.fill_foreground),
                set: |settings, is_on| {
                    if let Some(occlusion) = &mut settings.occlusion {
                        occlusion.fill_foreground = is_on;
                    }
                },
            }),
        )
        .in_hosts(HostGroup::Render, ["fillForeground", "Fill Foreground"])
    },
    Knob {
        has_effect: is_apply,
        ..Knob::new(
            "blur-inside",
            KnobScope::Apply,
            "A blurred foreground becomes transparent inside its own outline too, as in a camera; otherwise it only blurs outwards",
            KnobKind::Switch(Switch {
                default: true,
                get: |settings| settings.occlusion.is_none_or(|o| o.blur_inside),
                set: |settings, is_on| {
                    if let Some(occlusion) = &mut settings.occlusion {
                        occlusion.blur_inside = is_on;
                    }
                },
            }),
        )
        .in_hosts(HostGroup::Render, ["blurInside", "Blur Inward"])
    },
    Knob::new(
        "mix",
        KnobScope::Apply,
        "Weight of the blurred plate against its own pixels, times that of the mask",
        KnobKind::Number(Number {
            unit: Unit::Factor,
            range: (0.0, 1.0),
            default: Some(1.0),
            absent: "",
            slider: (0.0, 1.0),
            digits: 3,
            get: |settings| Some(settings.mix),
            set: |settings, value| settings.mix = value,
        }),
    ),
    Knob {
        details: "The blur is scaled before it is rendered, so a part that a mask keeps sharp has no blurred copy of itself around it.",
        has_effect: is_apply,
        ..Knob::new(
            "mask-scales",
            KnobScope::Apply,
            "What the mask scales",
            KnobKind::Choice(Choice {
                options: &[
                    ChoiceOption {
                        word: "mix",
                        label: "Mix",
                        help: "The weight of the blurred plate against its own pixels",
                    },
                    ChoiceOption {
                        word: "blur",
                        label: "Blur",
                        help: "The blur of each pixel, down to that in focus, by moving its distance towards the focus; needs a lens with a focus",
                    },
                ],
                default: 0,
                get: |settings| index_in(&MASK_SCALES, &settings.mask_scales),
                set: |settings, index| settings.mask_scales = MASK_SCALES[index],
            }),
        )
    },
    Knob {
        details: "At each place and distance the sharpest colour stays sharp, and the others blur by as much as their variance exceeds its own.",
        has_effect: is_apply,
        ..Knob::new(
            "only-chroma",
            KnobScope::Apply,
            "The lens's axial and lateral colour alone, without the blur that all colours share",
            KnobKind::Switch(Switch {
                default: false,
                get: |settings| settings.only_chroma,
                set: |settings, is_on| settings.only_chroma = is_on,
            }),
        )
    },
];
